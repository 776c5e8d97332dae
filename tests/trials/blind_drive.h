// Driving the truth car through the blind trials, with everything between driver, car and logger.
#pragma once

#include <numbers>

#include "truth_car.h"

namespace trials::blind {

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
  double normal() { return std::sqrt(-2 * std::log(1 - uniform())) * std::cos(2 * std::numbers::pi * uniform()); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(uniform() * static_cast<double>(n)); }
};

/// What a log holds, before sensors.
enum { kT, kX, kY, kYaw, kVx, kVy, kR, kAx, kAy, kAz, kSteer, kThrottle, kBrake, kGear, kEngine, kWfl, kWfr, kWrl, kWrr, kFzF, kFzR, kLogged };
inline constexpr std::array<double, kLogged> kNoise{0, 0.02, 0.02, 0.002, 0.04, 0.03, 0.004, 0.15, 0.15, 0.3, 0.0004, 0.002, 1.5e4, 0, 1.5, 0.15, 0.15, 0.15, 0.15, 60, 60};

/// A car with what lies between its driver and itself.
struct Variant {
  TruthCar car;
  double throttle_dead_s = 0, brake_dead_s = 0, steer_dead_s = 0, steer_lag_s = 0;
  double throttle_gain = 1, steer_gain = 1;
  const Track* track = nullptr;  ///< heights of its own; null: those of the track driven on
};

struct Drive {
  std::vector<std::array<double, kLogged>> row;  ///< every kRow_s
  /// RMS difference 0.45 s after both variants were set to the same state, in standard deviations of
  /// the channel's noise: of the most affected channel; and the sum of the squares of all.
  double size = 0.0, distance = 0.0;
  std::array<double, kLogged> channel_size{};
};
inline constexpr double kRow_s = 0.005;

/// Laps of this track at a pace that changes from lap to lap. Rows are empty where the car left the road.
Drive drive(const Variant& truth, const Track& track, int laps, unsigned long long seed, const Variant* other);

/// What the sensor `name` of a channel says in row k, before noise.
double sensed(const Drive& d, std::size_t k, int channel, const std::vector<Effect>& effects, const std::string& name);

}  // namespace trials::blind
