// The recordings of another simulator, TUMFTM Open-Car-Dynamics (ocd_trials), and their car as a
// car of lib/vehicle.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "base/read_file.h"
#include "recording/recording.h"
#include "vehicle/car.h"
#include "vehicle/tyre_file.h"
#include "vehicle/vehicle_file.h"

namespace support {

/// What was driven in each recording of a folder, by its truth.json; empty where it is not there.
inline std::vector<nlohmann::json> trials_of(const std::string& folder) {
  const std::string path = folder + "/truth.json";
  if (!std::filesystem::exists(path)) return {};
  return base::parse_json<nlohmann::json>(base::read_file(path, 1u << 24)).at("trials");
}

/// A log (.csv.xz) as canonical channels; travel is negative when compressed there.
inline recording::Recording recorded_log(const std::string& packed) {
  const std::string csv =
      (std::filesystem::temp_directory_path() / fmt::format("recorded_log_{}.csv", ::getpid()))
          .string();
  if (std::system(fmt::format("xz -dc '{}' > '{}'", packed, csv).c_str()) != 0)
    throw std::runtime_error(packed + ": xz failed");
  recording::Table table = recording::read_table(csv);
  std::filesystem::remove(csv);
  for (std::size_t c = 0; c < table.names.size(); ++c)
    if (table.names[c].starts_with("suspension_"))
      for (double& value : table.columns[c]) value = -value;
  return recording::make_recording(table, packed);
}

/// The stated car of nominal/vehicle.yaml with the factors by which the recorded one differs.
struct RecordedCar {
  vehicle::CarFiles files;
  vehicle::Parameters<double> parameters = vehicle::default_parameters();
  vehicle::Amplitudes<double> terms = vehicle::default_amplitudes();
};

inline RecordedCar recorded_car(const std::string& folder, const nlohmann::json& factors) {
  using namespace vehicle;  // NOLINT: names of one library
  using P = Parameter;
  RecordedCar car;
  const auto factor = [&](const char* name) { return factors.at(name).get<double>(); };
  TyreCoefficients tyre = read_tyre(folder + "/nominal/tyre.tir").coefficients;
  // Constant relaxation lengths as near as the polynomials of 5.2 come: (1 + dfz) exp(-dfz).
  tyre.ptx3 = 1.0;
  car.files.tyre = {tyre, tyre};
  car.files.fx_arm = FxArm::kRollingRadius;
  // Torque at the rear axle, ratio 1: throttle * full load - (1 - throttle) * motoring. Their full
  // load is 2400 N m or 300 kW, whichever is less; points 20 rad/s apart, as they list it, cut off
  // its corner at 125 rad/s by 65 N m.
  Map2& engine = car.files.engine_torque_nm;
  engine.y = {0.0, 1.0};
  for (double radps = 0.0; radps <= 280.0; radps += radps < 125.0 ? 125.0 : 5.0) {
    engine.x.push_back(radps);
    engine.z.push_back(-120.0);
    engine.z.push_back(std::min(2400.0, 300000.0 / std::max(radps, 1.0)));
  }
  Parameters<double>& p = car.parameters;
  p[P::chassis_mass_kg] = 760.0 * factor("mass");
  p[P::chassis_wheelbase_m] = 3.0;
  p[P::chassis_cog_behind_front_m] = 1.6 * factor("cog");
  p[P::chassis_cog_height_m] = 0.28;
  p[P::chassis_roll_inertia_kgm2] = 120.0;
  p[P::chassis_pitch_inertia_kgm2] = 650.0;
  p[P::chassis_yaw_inertia_kgm2] = 900.0 * factor("inertia_z");
  p[P::steering_ackermann] = 0.0;
  // 1 / (1 + 0.06 s): the second pole of 10 ms is taken out by the lead.
  p[P::steering_ratio] = 1.0;
  p[P::steering_dead_time_s] = 0.0;
  p[P::steering_lag_s] = std::sqrt(0.06 * 0.01);
  p[P::steering_damping] = 0.07 / (2.0 * std::sqrt(0.06 * 0.01));
  p[P::steering_lead_s] = 0.01;
  p[P::engine_inertia_kgm2] = 1.0;
  p[P::engine_idle_gain_nms] = 0.0;
  p[P::engine_limit_radps] = 3000.0;
  p[P::clutch_torque_nm] = 1e4;
  p[P::clutch_stick_radps] = 0.1;
  p[P::gearbox_ratio_1] = 1.0;
  for (const P other : {P::gearbox_ratio_2, P::gearbox_ratio_3, P::gearbox_ratio_4,
                        P::gearbox_ratio_5, P::gearbox_ratio_6})
    p[other] = 0.0;
  p[P::gearbox_final] = 1.0;
  p[P::gearbox_efficiency] = 1.0;
  p[P::aero_density_kgpm3] = 1.2;
  p[P::aero_drag_area_m2] = 0.9 * factor("drag");
  p[P::aero_drag_height_m] = 0.28;
  p[P::aero_side_area_m2] = 0.0;
  const auto axles = [&](P front, double of_front, P rear, double of_rear) {
    p[front] = of_front;
    p[rear] = of_rear;
  };
#define BOTH(key, of_front, of_rear) axles(P::front_##key, of_front, P::rear_##key, of_rear)
  BOTH(track_m, 1.6, 1.55);
  BOTH(unsprung_mass_kg, 16.0, 18.0);
  BOTH(wheel_inertia_kgm2, 1.15, 1.35);
  BOTH(spring_npm, 160000.0, 140000.0);
  BOTH(bump_damping_nspm, 7000.0, 6500.0);
  BOTH(rebound_damping_nspm, 7000.0, 6500.0);
  BOTH(damper_fast_share, 1.0, 1.0);
  BOTH(anti_roll_npm, 55000.0, 5000.0);  // theirs counts half of the difference
  BOTH(camber_rad, 0.0, 0.0);
  BOTH(toe_rad, 0.0, 0.0);
  BOTH(lift_area_m2, 0.95, 1.45);
  BOTH(brake_area_m2, 0.004, 0.004);
  BOTH(brake_radius_m, 0.125, 0.125);
  BOTH(brake_friction, 0.3, 0.15);
  BOTH(tyre_grip, factor("grip"), factor("grip"));
  BOTH(tyre_cornering_stiffness, factor("cornering_stiffness"), factor("cornering_stiffness"));
#undef BOTH
  for (const Term off : {Term::aero_ride_height,
                         Term::aero_yaw,
                         Term::aero_slipstream,
                         Term::wind,
                         Term::suspension_kinematics,
                         Term::bump_stop,
                         Term::tyre_camber,
                         Term::tyre_moments,
                         Term::tyre_carcass_damping,
                         Term::tyre_thermal,
                         Term::tyre_warm_up,
                         Term::brake_fade,
                         Term::brake_friction_temperature,
                         Term::turbo_lag,
                         Term::centrifugal_clutch,
                         Term::locked_differential,
                         Term::limited_slip,
                         Term::fuel_burn,
                         Term::steering_friction,
                         Term::throttle_actuator,
                         Term::brake_actuator})
    car.terms[off] = 0.0;
  return car;
}

/// The car as its owners state it: none of its factors.
inline RecordedCar stated_car(const std::string& folder, nlohmann::json factors) {
  for (auto& [name, factor] : factors.items()) factor = 1.0;
  return recorded_car(folder, factors);
}

/// What the owners of the recorded car say of how far it may be off: a few per cent.
inline std::array<double, vehicle::kParameterCount> few_per_cent() {
  std::array<double, vehicle::kParameterCount> out{};
  using P = vehicle::Parameter;
  for (const P p : {P::chassis_mass_kg, P::chassis_cog_behind_front_m, P::chassis_yaw_inertia_kgm2,
                    P::aero_drag_area_m2, P::front_tyre_grip, P::rear_tyre_grip,
                    P::front_tyre_cornering_stiffness, P::rear_tyre_cornering_stiffness})
    out[static_cast<std::size_t>(p)] = 0.06;
  return out;
}

/// The first `longest_s` of a log; without the channels that `kept_back` names.
template <class KeptBack>
recording::Recording begin_of(const recording::Recording& log, double longest_s,
                              const KeptBack& kept_back) {
  const std::vector<double>& time = *log.table.find("time_s");
  const auto rows =
      std::upper_bound(time.begin(), time.end(), time.front() + longest_s) - time.begin();
  recording::Table out;
  for (std::size_t c = 0; c < log.table.names.size(); ++c) {
    const std::string& name = log.table.names[c];
    if (kept_back(name)) continue;
    const std::vector<double>& column = log.table.columns[c];
    out.add(name, {column.begin(), column.begin() + rows});
  }
  return recording::make_recording(out, "begin");
}
inline recording::Recording begin_of(const recording::Recording& log, double longest_s) {
  return begin_of(log, longest_s, [](const std::string&) { return false; });
}

/// Of a car whose file says nothing of them.
inline std::array<double, vehicle::kParameterCount> default_priors() {
  std::array<double, vehicle::kParameterCount> out{};
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = vehicle::parameter_list()[i].prior;
  return out;
}

}  // namespace support
