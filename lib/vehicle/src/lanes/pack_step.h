// One step of a pack: the laws of the single step on Pack<N>. Included by one source for each
// instruction set, after native.h.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "kernel.h"
#include "pack_map.h"
#include "vehicle/step.h"

namespace vehicle::many {

/// Numbers of one lane into packs and back: both sides are rows of plain numbers.
template <int N>
void spread(const double* from, std::size_t count, std::size_t lane, void* to) {
  auto* const out = static_cast<double*>(to) + lane;
  for (std::size_t k = 0; k < count; ++k) out[k * N] = from[k];
}
template <int N>
void gather(const void* from, std::size_t count, std::size_t lane, double* to) {
  const auto* const in = static_cast<const double*>(from) + lane;
  for (std::size_t k = 0; k < count; ++k) to[k] = in[k * N];
}

// Where the rows lie: every member but these is a number of the scalar.
template <class T>
inline constexpr std::size_t kWheelNumbers = (sizeof(WheelDetail<T>) - sizeof(RoadPointOf<T>)) /
                                             sizeof(T);
template <class T>
inline constexpr std::size_t kDetailNumbers = (sizeof(Detail<T>) - offsetof(Detail<T>, power)) /
                                              sizeof(T);
template <class T>
inline constexpr std::size_t kCarNumbers = (offsetof(Car<T>, patch) -
                                            offsetof(Car<T>, sprung_mass_kg)) /
                                           sizeof(T);
template <int N>
inline constexpr bool kRowsFit =
    kWheelNumbers<Pack<N>> == kWheelNumbers<double>&& kDetailNumbers<Pack<N>> ==
    kDetailNumbers<double>&& kCarNumbers<Pack<N>> == kCarNumbers<double>;

/// Whose place each lane of a pack has: its own, or where it has nothing to step that of one that
/// has.
template <int N>
using Whose = std::array<std::size_t, N>;

/// The roads of a pack: each lane asks the road for itself.
template <int N>
struct PackRoads {
  std::span<Lane> lanes;
  const Whose<N>& whose;
  const Road& road;
  std::array<std::array<RoadPoint, N>, kWheels>& points;
};
struct NoCursors {};  // they lie in the lanes

template <int N>
dynamics::Ground<Pack<N>> ground_under(const PackRoads<N>& roads, const Car<Pack<N>>&,
                                       std::size_t wheel, const Pack<N>& x_m, const Pack<N>& y_m,
                                       const Pack<N>& z_near_m, const Pack<N>& heading_x,
                                       const Pack<N>& heading_y, NoCursors&,
                                       RoadPointOf<Pack<N>>& point) {
  std::array<RoadPoint, N>& points = roads.points[wheel];
  for (std::size_t begin = 0; begin < N; begin += 4) {
    FourAsk ask;
    for (std::size_t k = 0; k < 4; ++k) {
      ask.x_m[k] = x_m[begin + k];
      ask.y_m[k] = y_m[begin + k];
      ask.z_near_m[k] = z_near_m[begin + k];
      ask.heading_x[k] = heading_x[begin + k];
      ask.heading_y[k] = heading_y[begin + k];
    }
    ground_of(roads.lanes.subspan(begin).template first<4>(), roads.road, wheel, ask,
              std::span<RoadPoint, 4>(points.data() + begin, 4));
  }
  for (std::size_t k = 0; k < N; ++k) {
    const RoadPoint& own = points[roads.whose[k]];
    point.z_m.set(k, own.z_m);
    point.dzdx.set(k, own.dzdx);
    point.dzdy.set(k, own.dzdy);
    point.friction.set(k, own.friction);
  }
  return {point.z_m, point.dzdx, point.dzdy};
}

template <int N>
class PackKernel final : public Kernel {
  using T = Pack<N>;
  static_assert(kRowsFit<N>);

 public:
  explicit PackKernel(std::span<const Car<double>* const> cars) {
    const Car<double>& first = *cars.front();
    car_.files = first.files;
    car_.contact = first.contact;
    car_.tyre_options = first.tyre_options;
    for (std::size_t k = 0; k < N; ++k) {
      const Car<double>& car = k < cars.size() ? *cars[k] : first;
      spread<N>(car.parameters.value.data(), kParameterCount, k, &car_.parameters);
      spread<N>(car.terms.value.data(), kTermCount, k, &car_.terms);
      spread<N>(&car.sprung_mass_kg, kCarNumbers<double>, k, &car_.sprung_mass_kg);
    }
  }

  void take(std::span<const Car<double>* const> cars, std::span<const Parameter> which) override {
    for (std::size_t k = 0; k < N; ++k) {
      const Car<double>& car = *cars[k < cars.size() ? k : 0];
      for (const Parameter p : which) car_.parameters[p].set(k, car.parameters[p]);
    }
  }

  void step(std::span<Lane, kMostLanes> all, const Road& road,
            const StepOptions& options) override {
    const std::span<Lane> lanes = all.template first<N>();
    const double h = options.step_s;
    State<T> s, rate;
    Inputs<T> in;
    Whose<N> whose;
    std::size_t driven = 0;
    while (lanes[driven].sim == nullptr) ++driven;
    for (std::size_t k = 0; k < N; ++k) {
      whose[k] = lanes[k].sim != nullptr ? k : driven;
      take_lane(lanes[whose[k]], k, s, in);
    }
    std::array<std::array<RoadPoint, N>, kWheels> points;
    const PackRoads<N> roads{lanes, whose, road, points};
    NoCursors none;
    Detail<T>& detail = detail_;
    derivative(car_, s, in, roads, none, rate, detail);
    for (std::size_t k = 0; k < lanes.size(); ++k) {
      Lane& lane = lanes[k];
      lane.moved = lane.sim != nullptr;
      for (std::size_t i = 0; i < kWheels && lane.moved; ++i)
        if (!std::isfinite(points[i][k].z_m) || (options.stop_off_road && !points[i][k].on_road)) {
          lane.result = {StepResult::Problem::kNoRoad, i};
          lane.moved = false;
          if (lane.detail != nullptr) give_detail(lane, k, points, detail, *lane.detail);
        }
    }
    settle_frictions(car_, h, rate, detail);
    if (car_.files->turbo == Turbo::kFull) settle_air(h, rate, detail);
    if (car_.contact != Contact::kStrip) settle_ledges(lanes, whose, h, s, points, rate, detail);
    integrate(car_, s, rate, detail, options);
    const Mask<N> odd = suspect(s);
    for (std::size_t k = 0; k < lanes.size(); ++k) {
      Lane& lane = lanes[k];
      if (!lane.moved) continue;
      gather<N>(&s, kStateSize, k, lane.sim->state.value.data());
      lane.suspect = odd[k];
      if (lane.detail != nullptr) give_detail(lane, k, points, detail, *lane.detail);
    }
  }

 private:
  static void take_lane(const Lane& lane, std::size_t k, State<T>& s, Inputs<T>& in) {
    spread<N>(lane.sim->state.value.data(), kStateSize, k, &s);
    const Inputs<double>& from = *lane.in;
    in.steer_rad.set(k, from.steer_rad);
    in.steer_rate_radps.set(k, from.steer_rate_radps);
    in.throttle.set(k, from.throttle);
    for (std::size_t i = 0; i < kWheels; ++i) {
      in.brake_pa[i].set(k, from.brake_pa[i]);
      in.sunk_m[i].set(k, from.sunk_m[i]);
    }
    in.gear[k] = from.gear;
    in.next_gear[k] = from.next_gear;
    in.clutch.set(k, from.clutch);
    in.hold_n.set(k, from.hold_n);
    in.opponent.set(k, from.opponent);
    in.wake_x_m.set(k, from.wake_x_m);
    in.wake_y_m.set(k, from.wake_y_m);
  }

  static void give_detail(const Lane& lane, std::size_t k,
                          const std::array<std::array<RoadPoint, N>, kWheels>& points,
                          const Detail<T>& from, Detail<double>& to) {
    to.inputs = *lane.in;
    gather<N>(&from.to_map, sizeof(to.to_map) / sizeof(double), k, &to.to_map.x.x);
    for (std::size_t i = 0; i < kWheels; ++i) {
      gather<N>(&from.wheel[i], kWheelNumbers<double>, k, &to.wheel[i].fz_n);
      to.wheel[i].road = points[i][k];
    }
    gather<N>(&from.power, kDetailNumbers<double>, k, &to.power.tyre_normal);
  }
  static void take_detail(const Detail<double>& from, std::size_t k, Detail<T>& to) {
    for (std::size_t i = 0; i < kWheels; ++i)
      spread<N>(&from.wheel[i].fz_n, kWheelNumbers<double>, k, &to.wheel[i]);
    spread<N>(&from.power.tyre_normal, kDetailNumbers<double>, k, &to.power);
  }

  /// Where no lane meets a ledge, what is remembered of the wheels; else lane by lane.
  static void settle_ledges(std::span<Lane> lanes, const Whose<N>& whose, double h,
                            const State<T>& s,
                            const std::array<std::array<RoadPoint, N>, kWheels>& points,
                            State<T>& rate, Detail<T>& detail) {
    std::array<laws::Ledge<T>, kWheels> now;
    const Rotation<T> R = detail.to_map;
    const Vec3<T> origin{s[kX], s[kY], s[kZ]};
    Mask<N> meets = false;
    for (std::size_t i = 0; i < kWheels; ++i) {
      laws::Ledge<T> last;
      for (std::size_t k = 0; k < N; ++k) {
        const laws::Ledge<double>& own = lanes[whose[k]].sim->discrete.ledge[i];
        last.known.set(k, own.known);
        spread<N>(&own.hub_m.x, 7, k, &last.hub_m);  // hub, normal, radius
        last.sunk_m.set(k, own.sunk_m);
      }
      ledges::remember(R, origin, detail.wheel[i], now[i]);
      meets = meets || ledges::turns(last, ledges::jump_m(last, now[i]));
    }
    for (std::size_t k = 0; k < lanes.size(); ++k) {
      Lane& lane = lanes[k];
      if (!lane.moved) continue;
      if (meets[k]) {
        Detail<double> own_detail;
        State<double> own, own_rate;
        give_detail(lane, k, points, detail, own_detail);
        gather<N>(&s, kStateSize, k, own.value.data());
        gather<N>(&rate, kStateSize, k, own_rate.value.data());
        settle_ledges_of(lane, h, own, own_rate, own_detail);
        spread<N>(own_rate.value.data(), kStateSize, k, &rate);
        take_detail(own_detail, k, detail);
        continue;
      }
      for (std::size_t i = 0; i < kWheels; ++i) {
        laws::Ledge<double>& own = lane.sim->discrete.ledge[i];
        own.known = true;
        gather<N>(&now[i].hub_m, 7, k, &own.hub_m.x);
        own.pressed_m = now[i].pressed_m[k];
        own.sunk_m = 0.0;
      }
    }
  }

  static Mask<N> suspect(const State<T>& s) {
    Mask<N> out = false;
    for (std::size_t i = 0; i < kStateSize; ++i) out = out || s[i] - s[i] != T(0.0);
    for (std::size_t i = kVx; i <= kVz; ++i) out = out || abs(s[i]) > T(kFastest_mps);
    return out || abs(s[kPitch]) > T(kFarthestTilt_rad) || abs(s[kRoll]) > T(kFarthestTilt_rad);
  }

  Car<T> car_;
  Detail<T> detail_;  // of the last step
};

}  // namespace vehicle::many
