// A driver for the truth car, and what a logger would see of the drive.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "truth_car.h"

namespace trials {

constexpr double kPi = std::numbers::pi;

struct Random {
  unsigned long long state;
  double uniform() {
    state += 0x9E3779B97F4A7C15ull;
    unsigned long long z = state;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }
  double in(double low, double high) { return low + (high - low) * uniform(); }
  double normal() { return std::sqrt(-2 * std::log(1 - uniform())) * std::cos(2 * kPi * uniform()); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(uniform() * static_cast<double>(n)); }
};

/// What a log holds, before sensors.
enum { kT, kX, kY, kYaw, kVx, kVy, kR, kAx, kAy, kAz, kSteer, kThrottle, kBrake, kGear, kEngine, kWfl, kWfr, kWrl, kWrr, kFzF, kFzR, kS, kV,
       kRollRate, kPitchRate, kTravel, kLoad = kTravel + 4, kDisc = kLoad + 4, kLogged = kDisc + 4 };
const std::array<double, kLogged> kNoise{0, 0.02, 0.02, 0.002, 0.04, 0.03, 0.004, 0.15, 0.15, 0.3, 0.0004, 0.002, 1.5e4, 0, 1.5, 0.15, 0.15, 0.15, 0.15, 60, 60, 0, 0,
                                           0.004, 0.004, 2e-4, 2e-4, 2e-4, 2e-4, 60, 60, 60, 60, 1.5, 1.5, 1.5, 1.5};

/// How a drive is made.
struct Style {
  int laps = 1;
  unsigned long long seed = 1;
  double dead_throttle = 0, dead_brake = 0, dead_steer = 0;  ///< s, between the log and the car
  double pace_low = 0.72, pace_high = 0.93, first_pace = 0.7;
  double sway_m = 1.5;  ///< largest offset from the line
  int sway_waves = 3;   ///< per lap
  double drive = 1.0;   ///< how hard he accelerates, against what his plan takes for possible
  double weave_rad = 0.0, weave_from_hz = 0.5, weave_to_hz = 2.0;  ///< steering swung to and fro, ever faster over 20 s
};

struct Drive {
  std::vector<std::array<double, kLogged>> row;  ///< every 5 ms
  double size = 0.0;                             ///< of the effects, see below
  std::array<double, kLogged> channel_size{};
  double lap_s = 0.0;
};

/// Drives laps of the track. `measure` sizes the effects: every 0.9 s a copy of the car without them
/// goes on for 0.45 s from the same state.
Drive drive(const TruthCar& car, const Track& track, const Style& style, bool measure);

/// A channel as its sensor gives it; a delayed or filtered copy is read from the fine rows.
double sensed(const Drive& d, std::size_t k, int channel, const std::vector<Effect>& effects, const std::string& name);

}  // namespace trials
