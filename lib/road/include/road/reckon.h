// Where a car was that logged only how fast it went and turned.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace road {

/// Of each row, in a frame that begins where a lap begins, x the way the car goes there.
struct ReckonedPlaces {
  std::vector<double> x_m, y_m;  ///< NaN more than a lap before the first whole lap, or after it
  std::size_t laps = 0;          ///< whole ones; 0: no way was driven twice, and nothing is closed
  std::size_t begin = 0, end = 0;  ///< rows of the whole laps; else all
  double lap_m = 0.0;              ///< median; of an open way its length
  /// Largest of all laps: what speed and yaw rate leave open at the end of a lap.
  double turn_rad = 0.0;  ///< over or under whole turns; taken off evenly in time
  double gap_m = 0.0;     ///< taken off evenly along the lap
};

/// Integrates the motion in a plane. A lap is the shortest way after which the same bends come in
/// the same order and the car has turned whole turns, or none in all. Every lap begins and ends at
/// one place. `time_s` ascends; NaN of the others is bridged by straight lines; `yaw_rate_radps` is
/// counter-clockwise; `vy_mps`, to the left, may be empty: the car goes where its nose points.
/// Throws Error naming `name`: less than 50 rows or a car that hardly moves; laps that miss their
/// start by more than a quarter of their length.
ReckonedPlaces reckon_places(const std::string& name, const std::vector<double>& time_s,
                             const std::vector<double>& vx_mps,
                             const std::vector<double>& yaw_rate_radps,
                             const std::vector<double>& vy_mps = {});

}  // namespace road
