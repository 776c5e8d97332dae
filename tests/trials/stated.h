// The files that a simulation is given of a trial: its road and its car, as far as they are known.
#pragma once

#include <filesystem>
#include <string>

#include "stated_tyre.h"
#include "truth_car.h"

namespace trials {

/// Whole, or the program ends.
void write(const std::filesystem::path& path, const std::string& text);

/// A CRG with the line of one track and the heights of another, with what the effects of `car` add
/// to them.
void write_road(const Track& line_of, const Track& heights_of, const TruthCar& car,
                const std::filesystem::path& path);

/// Terms that the truth car has none of unless a trial is about them.
inline constexpr const char* kTermsOff =
    "aero_ride_height: 0, aero_yaw: 0, turbo_lag: 0, tyre_thermal: 0, tyre_camber: 0, "
    "brake_friction_temperature: 0, fuel_burn: 0, limited_slip: 0, "
    "locked_differential: 0, steering_actuator: 0, steering_friction: 0, throttle_actuator: 0, "
    "brake_actuator: 0, wind: 0";

/// Motor, gears, wheels of the second car.
inline constexpr const char* kSecondDrivetrain =
    "  engine.limit_radps: 830\n  front.wheel_inertia_kgm2: 0.9\n  rear.wheel_inertia_kgm2: 0.9\n"
    "  gearbox.efficiency: 0.95\n  gearbox.final: 3\n  gearbox.ratio_1: 2.9\n  gearbox.ratio_2: "
    "2.1\n  gearbox.ratio_3: 1.65\n  gearbox.ratio_4: 1.36\n  gearbox.ratio_5: 1.16\n  "
    "gearbox.ratio_6: 1.02\n";

struct StatedCar {
  StatedTyre front, rear;
  /// Has the torque of this car times torque_factor().
  TruthCar engine;
  double torque_scale = 1, torque_tilt = 0;
  double mass_kg = 0, wheelbase_m = 0, cog_behind_front_m = 0, cog_height_m = 0,
         yaw_inertia_kgm2 = 0;
  double front_track_m = 0, rear_track_m = 0, drag_area_m2 = 0, front_lift_area_m2 = 0,
         rear_lift_area_m2 = 0;
  double engine_inertia_kgm2 = 0, front_brake_friction = 0, rear_brake_friction = 0, camber_rad = 0,
         front_roll_share = 0.55;  ///< of the load transfer to the side, where no springs are given
  std::string first_parameters, last_parameters;  ///< further lines before and behind these
  std::string drivetrain = kSecondDrivetrain;
  double drag_height_m = 0;
  std::string terms = kTermsOff;
};

/// Stated torque over true: the scale, times 1 + tilt near the top of the motor's speeds and 1 -
/// tilt near their bottom (200 and 800 rad/s; of the electric motor 480 and 1920).
double torque_factor(const StatedCar& car, double omega_radps);

/// Friction of pads that give this torque per pressure and axle, with the calipers of the stated
/// car.
double front_friction(double brake_nm_per_pa);
double rear_friction(double brake_nm_per_pa);

/// Writes vehicle.yaml and what it names: front.tir, rear.tir, engine.csv.
void write_car(const StatedCar& car, const std::filesystem::path& folder);

}  // namespace trials
