// What the parts of a new car are made of.
#pragma once

#include <array>
#include <optional>

#include "guesses.h"
#include "parameter_lines.h"
#include "vehicle/data_sheet.h"

namespace vehicle {

constexpr double kSheetGravity = 9.80665, kAirDensity = 1.2;

/// The sheet's numbers and the guesses in their place, and what both lead to.
struct Basis {
  const DataSheet& sheet;
  ParameterLines& lines;
  double cog_m, grip, drag_m2;
  std::array<double, 2> downforce_m2, wheel_n, nominal_n, unsprung_kg;
};

inline double value_for(const std::optional<double>& stated, Guess guess, CarKind kind) {
  return stated.value_or(guessed_value(guess, kind));
}

/// Downforce, or drag, of an area.
inline double air_force_n(double area_m2, double mps) {
  return 0.5 * kAirDensity * area_m2 * mps * mps;
}

/// A parameter that is guessed by the kind of car.
inline void add_guess(const Basis& b, Parameter parameter, double value, Guess by) {
  b.lines.guessed(parameter, value, guess(by).prior, guess(by).why);
}

/// The sheet's number, or the guess in its place.
inline void add_or_guess(const Basis& b, Parameter parameter, bool is_stated, double value,
                         Guess by) {
  is_stated ? b.lines.stated(parameter, value) : add_guess(b, parameter, value, by);
}

}  // namespace vehicle
