// The fits behind reduce.h: each takes moments of the full car and fills its part of the numbers.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "identify/reduce.h"
#include "recording/channels.h"

namespace identify {

inline constexpr double kMostWheelSlip = 0.25;  ///< of a wheel that counts as rolling
inline constexpr double kLeastLoad_n = 100.0;   ///< of a wheel that counts as standing on the road
inline constexpr double kPastPeak = 0.999;  ///< of the largest side force of an axle: it is past

inline double side_of(std::size_t wheel) { return wheel % 2 == 0 ? 1.0 : -1.0; }

/// Adds up how far one number is from that of the full car.
struct ErrorSum {
  double squares = 0.0, most = 0.0, of = 0.0;
  std::size_t rows = 0;
  void add(double full, double reduced) { add_miss(full, reduced - full); }
  void add_miss(double full, double miss) {
    squares += miss * miss;
    most = std::max(most, std::abs(miss));
    of = std::max(of, std::abs(full));
    ++rows;
  }
  /// `of_shares`: the misses were shares already.
  PartError as(const std::string& name, const std::string& unit, bool of_shares = false) const {
    const double size = of_shares || !(of > 0.0) ? 1.0 : of;
    const double rms = rows > 0 ? std::sqrt(squares / static_cast<double>(rows)) : 0.0;
    return {name, unit, rms / size, most / size, of, rows};
  }
};

/// Masses, lengths and what the full car states of air and differential; no fits yet.
ReducedCar plain_numbers(const vehicle::Car<double>& car, double fuel_kg);

/// Downforce, lateral transfer and inclinations; errors are appended.
void fit_loads(ReducedCar& car, const std::vector<CarMoment>& moments,
               std::vector<PartError>& errors);

/// Rolling radius by load.
void fit_radius(ReducedCar& car, const std::vector<CarMoment>& moments,
                std::vector<PartError>& errors);

/// Trails: the yaw moment that the forces at the axles leave.
void fit_yaw(ReducedCar& car, const std::vector<CarMoment>& moments,
             std::vector<PartError>& errors);

/// Curves of the wheels, and those of the axles from moments with little yaw moment (`trimmed`).
void fit_curves(ReducedCar& car, const std::vector<CarMoment>& moments,
                const std::vector<CarMoment>& trimmed, const vehicle::Car<double>& full,
                unsigned threads, std::vector<PartError>& errors);

/// Relaxation lengths from swept sines.
void fit_relaxation(ReducedCar& car, const std::vector<std::vector<CarMoment>>& sweeps,
                    std::vector<PartError>& errors);

/// How far the differential's formula is from the full car's.
void judge_differential(const ReducedCar& car, const std::vector<CarMoment>& moments,
                        std::vector<PartError>& errors);

/// The planar state that a moment of the full car was in; what presses is the moment's.
PlanarState planar_state(const CarMoment& moment);

/// A moment whose wheels neither slide far nor hang in the air.
bool grips(const CarMoment& moment);

/// The lines of control_*.inc as text; CMake puts them into a source.
extern const char* const kControlCar;     ///< types, curves, loads, differential
extern const char* const kControlSingle;  ///< control_single_track()
extern const char* const kControlDouble;  ///< control_double_track()

}  // namespace identify
