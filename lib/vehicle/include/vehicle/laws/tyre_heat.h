// Temperature of a tyre's tread, and what grip and stiffness make of it.
//
// One node per tyre: heated by a share of the sliding power, cooled by air and road. A window of
// full grip with rational flanks, or a measured map, and an exponential stiffness: own choice of
// shapes (docs/vehicle.md says what was looked for); every number is a parameter.
#pragma once

#include <cmath>

#include "vehicle/map.h"
#include "vehicle/maths.h"
#include "vehicle/parameters.h"

namespace vehicle::laws {

/// Shares of grip that are missing at a tread temperature: below the window, above it.
template <class T>
struct WindowLoss {
  T cold, hot;
};

template <class T>
WindowLoss<T> window_loss(const Parameters<T>& p, const T& tread_k) {
  using P = Parameter;
  const T cold = (p[P::tyre_window_begin_k] - tread_k) / p[P::tyre_cold_width_k];
  const T hot = (tread_k - p[P::tyre_window_end_k]) / p[P::tyre_hot_width_k];
  const auto none = [] { return T(0); };
  return {choose(
              cold > T(0),
              [&] { return T(p[P::tyre_cold_loss] * cold * cold / (1.0 + cold * cold)); }, none),
          choose(
              hot > T(0), [&] { return T(p[P::tyre_hot_loss] * hot * hot / (1.0 + hot * hot)); },
              none)};
}

/// Factors on grip and on stiffness at a tread temperature, both 1 where `amount` is 0. Grip is
/// `grip_map` over the temperature, K, or where that is empty the window.
template <class T>
struct TreadFactors {
  T grip, stiffness;
};

template <class T>
TreadFactors<T> tread_factors(const Parameters<T>& p, const Map1& grip_map, const T& amount,
                              const T& tread_k) {
  using P = Parameter;
  using maths::exp;
  T grip = T(1);
  if (grip_map.empty()) {
    const WindowLoss<T> loss = window_loss(p, tread_k);
    grip -= loss.cold;
    grip -= loss.hot;
  } else {
    grip = evaluate(grip_map, tread_k);
  }
  const T soft = exp(T(-p[P::tyre_stiffness_slope_1pk] * (tread_k - p[P::tyre_window_begin_k])));
  return {1.0 + amount * (grip - 1.0), 1.0 + amount * (soft - 1.0)};
}

/// How fast the tread warms, K/s: `sliding_w` is the power of the tyre's forces over the sliding of
/// the tread, positive into heat; the road cools where `loaded`.
template <class T>
T tread_rate(const Parameters<T>& p, const T& capacity_jpk, const T& tread_k, const T& sliding_w,
             const T& speed_mps, const Flag<T>& loaded) {
  using P = Parameter;
  const T heat = select(sliding_w > T(0), T(p[P::tyre_slip_share] * sliding_w), T(0));
  T cooling = (p[P::tyre_cooling_still_wpk] + p[P::tyre_cooling_speed_jpkm] * speed_mps) *
              (tread_k - p[P::environment_temperature_k]);
  const T road_w = p[P::tyre_road_cooling_wpk] * (tread_k - p[P::environment_track_temperature_k]);
  cooling = select(loaded, T(cooling + road_w), cooling);
  return (heat - cooling) / capacity_jpk;
}

}  // namespace vehicle::laws
