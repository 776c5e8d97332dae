// A drive of the truth car: driver, what lies between him and the car, car and logger, millisecond
// by millisecond.
#pragma once

#include "driver.h"
#include "log.h"

namespace trials {

/// A car with what lies between its driver and itself.
struct Variant {
  TruthCar car;
  double throttle_dead_s = 0, brake_dead_s = 0, steer_dead_s = 0, steer_lag_s = 0;
  double throttle_gain = 1, steer_gain = 1;
  double steer_play_rad = 0;     ///< of the road wheels, from end to end; not together with the lag
  const Track* track = nullptr;  ///< heights of its own; null: those of the track driven on
};

struct Drive {
  std::vector<Row> row;  ///< every kRow_s; none where the car left the road
  double lap_s = 0.0;    ///< mean
  /// RMS difference 0.45 s after both variants were set to the same state, in standard deviations
  /// of the channel's noise: per channel that is compared, and of the most affected one. 0 with one
  /// variant only.
  std::array<double, kChannels> channel_size{};
  double size = 0.0;
};

/// Drives laps of the track. With `other` the two variants are compared: every 0.9 s the other is
/// set to the state of the first and goes on for 0.45 s with the same driver.
Drive drive(const Variant& truth, const Track& track, const Style& style, const Variant* other);

}  // namespace trials
