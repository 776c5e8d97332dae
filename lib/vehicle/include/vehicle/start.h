// A car at the begin of a run.
#pragma once

#include <cmath>
#include <limits>

#include "vehicle/actuate.h"
#include "vehicle/laws/turbocharger.h"
#include "vehicle/road.h"

namespace vehicle {

/// The whole of a running car; trivially copyable when T is: a copy is a restart point.
template <class T>
struct Simulation {  // NOLINT(clang-analyzer-optin.performance.Padding): read in this order
  State<T> state;
  Discrete<T> discrete;
  RoadCursors cursors;
  double time_s = 0.0;
};

/// A car at rest or rolling straight at `speed_mps` in `gear`, design height above `road` at
/// (x, y), level with the road, wheels and engine turning to match, everything at the temperatures
/// given. Not yet in exact balance: fuel and downforce still settle.
struct StartOptions {
  double x_m = 0.0, y_m = 0.0, yaw_rad = 0.0;
  double z_near_m = std::numeric_limits<double>::quiet_NaN();  ///< which level of a bridge
  double speed_mps = 0.0;
  int gear = 1;
  double fuel_kg = 30.0;
  double tyre_k = 360.0;
  double disc_k = 500.0;
};

template <class T>
Simulation<T> start(const Car<T>& car, const Road& road, const StartOptions& options) {
  using P = Parameter;
  Simulation<T> sim{};
  const RoadPoint ground = road.at(options.x_m, options.y_m, options.z_near_m, 0, sim.cursors);
  const double cy = std::cos(options.yaw_rad), sy = std::sin(options.yaw_rad);
  const double along = ground.dzdx * cy + ground.dzdy * sy;
  const double across = -ground.dzdx * sy + ground.dzdy * cy;
  const double pitch = -std::atan(along);
  const double roll = std::atan(across * std::cos(pitch));
  const double height = value_of(car.parameters[P::chassis_cog_height_m]);
  State<T>& s = sim.state;
  for (T& value : s.value) value = T(0);
  const Rotation<double> R = rotation(roll, pitch, options.yaw_rad);
  s[kX] = T(options.x_m + height * R.z.x);
  s[kY] = T(options.y_m + height * R.z.y);
  s[kZ] = T(ground.z_m + height * R.z.z);
  s[kRoll] = T(roll);
  s[kPitch] = T(pitch);
  s[kYaw] = T(options.yaw_rad);
  s[kVx] = T(options.speed_mps);
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = axle_of(i);
    const TyreCoefficients& tyre = car.files->tyre[a];
    const double deflection = tyre.unloaded_radius_m * tyre.qre0 - value_of(car.static_radius_m[a]);
    const double radius = rolling_radius(tyre, value_of(car.static_load_n[a]),
                                         tyre.unloaded_radius_m * tyre.qre0, deflection);
    s[kSpin + i] = T(options.speed_mps / radius);
    s[kTyre + i] = T(options.tyre_k);
    s[kDiscSurface + i] = T(options.disc_k);
    s[kDiscCore + i] = T(options.disc_k);
  }
  sim.discrete.gear = sim.discrete.gear_wanted = options.gear;
  T engine = car.parameters[P::engine_idle_radps];
  if (options.gear != 0) {
    const T ratio = overall_ratio(car.parameters, options.gear);
    const T turning = ratio * s[kSpin + 2];
    if (turning > engine) engine = turning;
  }
  s[kEngine] = engine;
  s[kFuel] = T(options.fuel_kg);
  if (car.files->turbo == Turbo::kFull) {
    const laws::TurboState<T> path = laws::idling_air_path(car.parameters, engine);
    s[kManifold] = path.manifold_pa;
    s[kCharge] = path.charge_pa;
    s[kExhaust] = path.exhaust_pa;
    s[kTurbo] = path.shaft_radps;
  }
  return sim;
}

}  // namespace vehicle
