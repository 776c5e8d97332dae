// First-order boost of a turbocharged engine: a share of the torque waits for it.
//
// The boost, 0 to 1, chases the throttle; it rises as fast as the exhaust drives the turbine, in
// proportion to engine speed and throttle, and falls with a time of its own. Own choice of a first
// order with the gas flow as its pace, for cars of whose turbocharger nothing is known;
// laws/turbocharger.h has the air path.
#pragma once

#include <cmath>

#include "vehicle/laws/clip.h"
#include "vehicle/maths.h"
#include "vehicle/parameters.h"

namespace vehicle::laws {

/// Names and units as in parameters.def, group turbo.
template <class T>
struct BoostParameters {
  T rise_s, fall_s, reference_radps, idle_flow;
};

template <class T>
BoostParameters<T> boost_parameters(const Parameters<T>& p) {
  using P = Parameter;
  return {p[P::turbo_rise_s], p[P::turbo_fall_s], p[P::turbo_reference_radps],
          p[P::turbo_idle_flow]};
}

/// The lag of the boost: rate = lacking flow / time_s. `flow`: exhaust gas over that at full
/// throttle and reference speed, engine speed held to 0.02 to 10 times it; 1 while falling.
template <class T>
struct BoostLag {
  T flow, time_s;
};

/// `lacking` is throttle less boost, throttle from 0 to 1.
template <class T>
BoostLag<T> boost_lag(const BoostParameters<T>& p, const T& lacking, const T& engine_radps,
                      const T& throttle) {
  const auto rises = lacking > T(0);
  const auto flow = [&] {
    return T(clip(T(engine_radps / p.reference_radps), 0.02, 10.0) *
             (p.idle_flow + (1.0 - p.idle_flow) * throttle));
  };
  return {choose(rises, flow, [] { return T(1); }), select(rises, p.rise_s, p.fall_s)};
}

/// Rate of the boost, 1/s.
template <class T>
T boost_rate(const BoostParameters<T>& p, const T& boost, const T& engine_radps,
             const T& throttle) {
  const T lacking = throttle - boost;
  const BoostLag<T> lag = boost_lag(p, lacking, engine_radps, throttle);
  return lacking * lag.flow / lag.time_s;
}

/// The boost `step_s` later under a throttle and an engine speed that stay: exact.
template <class T>
T boost_after(const BoostParameters<T>& p, const T& boost, const T& engine_radps, const T& throttle,
              double step_s) {
  using maths::exp;
  const T lacking = throttle - boost;
  const BoostLag<T> lag = boost_lag(p, lacking, engine_radps, throttle);
  return throttle - lacking * exp(-step_s * (lag.flow / lag.time_s));
}

/// Driving torque less what waits for boost; a dragging engine waits for none. `share` of the
/// torque needs full boost.
template <class T>
T boosted_torque(const T& torque_nm, const T& share, const T& lacking) {
  return select(lacking > T(0) && torque_nm > T(0), T(torque_nm * (1.0 - share * lacking)),
                torque_nm);
}

}  // namespace vehicle::laws
