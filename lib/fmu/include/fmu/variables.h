// The one list of what an FMU of the car shows: made from the lists of lib/vehicle (telemetry,
// states, parameters, terms) and from the short ones here. Model description, reading, writing and
// the documentation all go by it.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace fmu {

enum class Type : std::uint8_t { kReal, kInteger, kBoolean, kString };
enum class Causality { kIndependent, kInput, kOutput, kParameter, kLocal };
enum class Variability { kContinuous, kDiscrete, kTunable, kFixed };

/// The list that a variable stands in, and so where its value comes from or goes to.
enum class Source { kTelemetry, kForces, kState, kRate, kInput, kStart, kParameter, kTerm, kText };

/// Inputs, in the order of the list.
enum class Input : std::size_t {
  kSteering,
  kThrottle,
  kBrake,
  kGear,
  kClutch,
  kWakeActive,
  kWakeX,
  kWakeY,
  kOpponentActive,
  kOpponentX,
  kOpponentY
};
/// How a run begins and how it is stepped.
enum class Start : std::size_t { kU, kV, kYaw, kSpeed, kFuel, kTyre, kDisc, kSolverStep };
/// String parameters.
enum class Text : std::size_t {
  kVehicle,
  kSetup,
  kRoad,
  kFriction,
  kContact,
  kIntegrator,
  kResources,
  kCount
};
inline constexpr std::size_t kTextCount = static_cast<std::size_t>(Text::kCount);

struct Variable {
  std::string name;  ///< structured; "*" stands for the wheel, or the number in brackets
  std::string text;  ///< what it is, one line
  std::string unit;  ///< "" for what is no real number; "1" without dimension
  Type type = Type::kReal;
  Causality causality = Causality::kOutput;
  Variability variability = Variability::kContinuous;
  Source source = Source::kTelemetry;
  std::size_t size = 1;         ///< 1, or 4: wheels fl, fr, rl, rr, or cars 1 to 4
  std::size_t index = 0;        ///< of its first value within its source
  std::uint32_t reference = 0;  ///< of its first value; the values of all follow one another
  double start = 0.0;           ///< of each value; texts have theirs in the unit
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

/// In the order of the references: numbers first (time is reference 0), then texts. Starts of
/// parameters and terms are those of the lists; a unit has those of its car.
std::vector<Variable> variables();

/// How many values a list has: one more than the last reference.
std::uint32_t count_values(const std::vector<Variable>& list);

/// The states, by their places, of which value `i` of an output is a function at the time reached;
/// the first alone is all of it but for u and v. None: it is of the last step.
std::vector<std::size_t> states_behind(const Variable& variable, std::size_t i);

/// Name of value `i` of a variable: "wheel.fl.fz" of "wheel.*.fz".
std::string value_name(const Variable& variable, std::size_t i);
/// Name of all its values together: "wheel.fz".
std::string array_name(const Variable& variable);

}  // namespace fmu
