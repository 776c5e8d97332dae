#include "convoys.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "effect.h"
#include "engine_and_brakes.h"
#include "led_car.h"

namespace explain {
namespace {

using P = vehicle::Parameter;

/// What a setting makes of the car's files.
struct FileChanges {
  std::array<double, 4> engine_shape{};
  double engine_limit_radps = 0.0, rolling = 1.0, radius_by_load = 1.0;
  std::array<double, 2> wheel_radius{1, 1};
  bool operator==(const FileChanges&) const = default;
};

FileChanges file_changes(const Signals& s, const vehicle::Vehicle& car, const Setting& set) {
  FileChanges out{set.engine_shape, set.p[P::engine_limit_radps], set.rolling, set.radius_by_load};
  // A measured throttle needs no gain: one that is off is a map that is off between the ends. With
  // the command beside it the gain lies between the two.
  if (!s.commanded[kThrottle] && !s.present[kThrottleCommand])
    out.engine_shape[0] += 0.5 * (set.p[P::throttle_gain] / car.parameters[P::throttle_gain] - 1.0);
  // A logger's own radius is no property of the tyre.
  if (!s.wheels_in_mps) out.wheel_radius = set.wheel_radius;
  return out;
}

/// What must be the same for cars to be computed together.
struct Alike {
  FileChanges files;
  int substeps = 0;
  std::size_t alone = 0;  ///< another for each that goes alone
  double reaction = 0.0;
  std::vector<Acting> effects;
  bool operator==(const Alike&) const = default;
};

/// Of a mechanism that acts at every substep, or of an actuator's dead time that is longer than
/// packs keep: driven alone.
bool goes_alone(const Setting& set) {
  const auto acts = [](const Acting& a) {
    return a.effect->on_the_way != nullptr && a.amount[0] != 0;
  };
  constexpr double kLongest_steps = 500;
  const double longest_s = kLongest_steps * Signals::kStep_s / set.substeps;
  return std::any_of(set.effects.begin(), set.effects.end(), acts) ||
         set.p[P::steering_dead_time_s] > longest_s || set.p[P::throttle_dead_time_s] > longest_s ||
         set.p[P::brake_dead_time_s] > longest_s;
}

}  // namespace

vehicle::CarFiles files_with(const Signals& s, const vehicle::Vehicle& car, const Setting& set) {
  const FileChanges changes = file_changes(s, car, set);
  vehicle::CarFiles files = car.files;
  files.engine_torque_nm = shaped_engine_map(car.files.engine_torque_nm, changes.engine_shape,
                                             changes.engine_limit_radps);
  for (std::size_t axle = 0; axle < 2; ++axle) {
    vehicle::TyreCoefficients& tyre = files.tyre[axle];
    tyre.qsy1 *= changes.rolling;
    tyre.deflection_share *= changes.radius_by_load;
    tyre.unloaded_radius_m *= changes.wheel_radius[axle];
  }
  return files;
}

std::vector<std::vector<std::size_t>> convoys(const Signals& s, const vehicle::Vehicle& car,
                                              std::span<const Setting* const> settings) {
  constexpr std::size_t kMost = 8;  // of the widest pack
  std::vector<std::vector<std::size_t>> out;
  std::vector<Alike> of;
  for (std::size_t k = 0; k < settings.size(); ++k) {
    const Setting& set = *settings[k];
    const Alike own{file_changes(s, car, set), set.substeps, goes_alone(set) ? k + 1 : 0,
                    set.reaction, set.effects};
    std::size_t g = 0;
    while (g < out.size() && !(of[g] == own && out[g].size() < kMost)) ++g;
    if (g == out.size()) out.emplace_back(), of.push_back(own);
    out[g].push_back(k);
  }
  return out;
}

bool same_drive(const KnownDrive& known, const Setting& setting, const Lead& by) {
  // What sensors, road and delays do to the drive stands in what leads it.
  const auto of_the_car = [](Setting s) {
    const Setting none;
    s.sensor = none.sensor;
    s.throttle_s = s.brake_s = s.steer_s = s.steer_lag_s = s.burn = 0.0;
    s.bank = s.grade = s.vertical = s.shift_u = s.imu_yaw = s.imu_ahead = 0.0;
    s.vy_ahead = s.place_ahead = s.derived_ax = s.level = s.filter_lead_s = 0.0;
    s.pressure_by_command = none.pressure_by_command;
    s.along = {};
    return s;
  };
  const auto same = [](const auto& a, const auto& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
      return x == y || (std::isnan(x) && std::isnan(y));
    });
  };
  const Lead& k = known.by;
  return k.vy_known == by.vy_known && k.reserve_kg == by.reserve_kg && same(k.vx_mps, by.vx_mps) &&
         (!k.vy_known || same(k.vy_mps, by.vy_mps)) && same(k.yaw_radps, by.yaw_radps) &&
         same(k.yaw_rad, by.yaw_rad) && same(k.steer, by.steer) && same(k.throttle, by.throttle) &&
         same(k.brake_front_pa, by.brake_front_pa) && same(k.brake_rear_pa, by.brake_rear_pa) &&
         same(k.brake_front_apart_pa, by.brake_front_apart_pa) &&
         same(k.brake_rear_apart_pa, by.brake_rear_apart_pa) && same(k.gear, by.gear) &&
         same(k.gravity_mps2, by.gravity_mps2) && same(k.fuel_kg, by.fuel_kg) &&
         of_the_car(known.setting) == of_the_car(setting);
}

}  // namespace explain
