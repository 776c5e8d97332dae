#include "parameter_lines.h"

#include <fmt/format.h>

#include <cmath>

namespace vehicle {
namespace {

std::string_view written_name(Parameter parameter) {
  return parameter_list()[static_cast<std::size_t>(parameter)].name;
}

}  // namespace

Parameter of_axle(Parameter front, std::size_t axle) {
  constexpr std::size_t kStep = static_cast<std::size_t>(Parameter::rear_track_m) -
                                static_cast<std::size_t>(Parameter::front_track_m);
  return static_cast<Parameter>(static_cast<std::size_t>(front) + axle * kStep);
}

void ParameterLines::stated(Parameter parameter, double value) {
  stated_ += fmt::format("  {}: {:.5g}\n", written_name(parameter), value);
}

void ParameterLines::follows(Parameter parameter, double value, const std::string& how) {
  follows_ += fmt::format("  {}: {:.4g}  # {}\n", written_name(parameter), value, how);
}

void ParameterLines::guessed(Parameter parameter, double value, double prior,
                             const std::string& why) {
  ++guesses_;
  const double width = value == 0.0 ? prior : prior * std::abs(value);
  guessed_ +=
      fmt::format("  {}: {{value: {:.4g}, prior: {:g}, assumed: true}}  # {:.3g} to {:.3g}: {}\n",
                  written_name(parameter), value, prior, value - width, value + width, why);
}

std::string ParameterLines::text() const {
  return "  # As the data sheet says.\n" + stated_ + "  # What follows from it.\n" + follows_ +
         "  # Guessed: value, how far off it may be, the range, and why.\n" + guessed_;
}

}  // namespace vehicle
