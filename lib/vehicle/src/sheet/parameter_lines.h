// The parameters of a vehicle file that is written, each with where its value is from.
#pragma once

#include <cstddef>
#include <string>

#include "vehicle/parameters.h"

namespace vehicle {

class ParameterLines {
 public:
  /// As the sheet says it.
  void stated(Parameter parameter, double value);
  /// Follows from numbers of the sheet.
  void follows(Parameter parameter, double value, const std::string& how);
  /// Assumed; `prior` is two standard deviations as a share of the value, or in the unit at 0.
  void guessed(Parameter parameter, double value, double prior, const std::string& why);

  /// The three kinds under headings, indented as entries of `parameters:`.
  std::string text() const;
  std::size_t guesses() const { return guesses_; }

 private:
  std::string stated_, follows_, guessed_;
  std::size_t guesses_ = 0;
};

/// The same parameter of axle 0 (front) or 1 (rear).
Parameter of_axle(Parameter front, std::size_t axle);

}  // namespace vehicle
