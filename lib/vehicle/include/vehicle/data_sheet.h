// What a data sheet says of a car: the ten numbers or so that a team knows, read from YAML.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vehicle {

/// What is guessed where the sheet is silent depends on it.
enum class CarKind { kRoad, kRace, kFormula, kKart };

enum class Differential { kOpen, kLimitedSlip, kLocked };

/// A tyre as its size says. Metres.
struct TyreSize {
  double radius_m = 0.0, width_m = 0.0, rim_m = 0.0;  ///< unloaded; section; diameter of the rim
};

/// The numbers of a data sheet. What is empty was not stated.
struct DataSheet {
  std::string path, name;
  CarKind kind = CarKind::kRoad;
  double mass_kg = 0.0;  ///< with driver, without fuel
  double wheelbase_m = 0.0;
  double front_weight = 0.0;  ///< share of the weight on the front axle
  std::array<double, 2> track_m{};
  std::array<std::string, 2> tyre_name;
  std::array<TyreSize, 2> tyre;
  std::vector<std::pair<double, double>> torque;  ///< rpm, N m at full throttle; ascending
  double power_rpm = 0.0;                         ///< of the greatest power
  std::optional<double> limit_rpm;
  bool curve_guessed = false;  ///< the torque's peak was not stated
  bool turbo = false;
  std::vector<double> gear_ratios;  ///< empty: `gear_count` of them are worked out
  std::optional<double> gear_count, final_drive;
  std::optional<Differential> differential;
  std::optional<double> cog_height_m, grip, drag_area_m2;
  std::optional<std::array<double, 2>> downforce_area_m2, brake_disc_m, ride_hz;
  std::optional<double> top_speed_kmh, to_100_kmh_s;  ///< as published; only compared with
};

/// Reads a sheet. Throws Error with file:line, the number seen and what is plausible, on unknown,
/// missing and implausible keys, and on numbers that contradict each other.
DataSheet read_data_sheet(const std::string& path);

/// A sheet to begin with: a car's numbers, every key with its unit, range and default.
std::string example_data_sheet();

}  // namespace vehicle
