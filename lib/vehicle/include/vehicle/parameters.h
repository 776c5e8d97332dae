// What can be adjusted about a car: the one list of its parameters and the one list of its terms.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "vehicle/lanes.h"

namespace vehicle {

/// Names every parameter; parameters.def says what each one means.
enum class Parameter : std::size_t {
#define VEHICLE_PARAMETER(group, key, unit, value, low, high, prior, text) group##_##key,
#include "vehicle/parameters.def"
#undef VEHICLE_PARAMETER
  kCount
};
inline constexpr std::size_t kParameterCount = static_cast<std::size_t>(Parameter::kCount);

struct ParameterInfo {
  std::string_view name;  ///< group.key, the key with its unit
  std::string_view unit;
  double value;      ///< default
  double low, high;  ///< bounds
  double prior;      ///< two standard deviations: share of the value, or in the unit at value 0
  std::string_view text;
};

/// In the order of the enum.
std::span<const ParameterInfo, kParameterCount> parameter_list();
std::optional<Parameter> find_parameter(std::string_view name);

/// One value per parameter, SI units. T is double or an automatic differentiation type.
template <class T>
struct Parameters {
  std::array<T, kParameterCount> value;

  const T& operator[](Parameter p) const { return value[static_cast<std::size_t>(p)]; }
  T& operator[](Parameter p) { return value[static_cast<std::size_t>(p)]; }
  /// The parameter named for the front axle, of axle 0 (front) or 1 (rear).
  const T& axle(std::size_t axle, Parameter front) const {
    constexpr std::size_t kStep = static_cast<std::size_t>(Parameter::rear_track_m) -
                                  static_cast<std::size_t>(Parameter::front_track_m);
    return value[static_cast<std::size_t>(front) + axle * kStep];
  }
  bool operator==(const Parameters&) const = default;
};

/// The most forward gears that a car can have.
inline constexpr int kMostGears = static_cast<int>(Parameter::gearbox_ratio_10) -
                                  static_cast<int>(Parameter::gearbox_ratio_1) + 1;

/// Engine speed over that of the mean driven wheel, final drive included: below 0 in reverse (gear
/// -1), 0 where nothing is engaged or the car has no such gear.
template <class T>
T overall_ratio(const Parameters<T>& p, int gear) {
  if (gear == -1) return T(-p[Parameter::gearbox_ratio_reverse] * p[Parameter::gearbox_final]);
  if (gear < 1 || gear > kMostGears) return T(0);
  return p[static_cast<Parameter>(static_cast<std::size_t>(Parameter::gearbox_ratio_1) +
                                  static_cast<std::size_t>(gear) - 1)] *
         p[Parameter::gearbox_final];
}

/// Whether a gear is asked for at all.
inline bool is_gear(int gear) { return gear != 0; }

/// Each car in its own gear.
template <int N>
Pack<N> overall_ratio(const Parameters<Pack<N>>& p, const Int<Pack<N>>& gear) {
  Pack<N> out(0.0);
  for (std::size_t lane = 0; lane < N; ++lane) out.set(lane, overall_ratio(p, gear[lane])[lane]);
  return out;
}
template <std::size_t N>
Mask<static_cast<int>(N)> is_gear(const std::array<int, N>& gear) {
  Mask<static_cast<int>(N)> out = false;
  for (std::size_t lane = 0; lane < N; ++lane) out.set(lane, is_gear(gear[lane]));
  return out;
}

/// The highest forward gear that a car has; 0: it has none.
int top_gear(const Parameters<double>& p);

/// The defaults of the list.
Parameters<double> default_parameters();

/// Names every term; terms.def says what its absence means.
enum class Term : std::size_t {
#define VEHICLE_TERM(name, text) name,
#include "vehicle/terms.def"
#undef VEHICLE_TERM
  kCount
};
inline constexpr std::size_t kTermCount = static_cast<std::size_t>(Term::kCount);
static_assert(kTermCount <= 64);

/// A set of terms as bits, for builds of the equations that leave some out.
using TermSet = std::uint64_t;
inline constexpr TermSet kAllTerms = ~TermSet{0};
constexpr TermSet without(Term term, TermSet set = kAllTerms) {
  return set & ~(TermSet{1} << static_cast<std::size_t>(term));
}

struct TermInfo {
  std::string_view name;
  std::string_view absence;  ///< what the car is like without it
};
std::span<const TermInfo, kTermCount> term_list();
std::optional<Term> find_term(std::string_view name);

/// How much of each term acts, 0 to 1. At exactly 0 its equations are not evaluated at all, so that
/// the result is bit for bit that of a build without the term.
template <class T>
struct Amplitudes {
  std::array<T, kTermCount> value;

  const T& operator[](Term t) const { return value[static_cast<std::size_t>(t)]; }
  T& operator[](Term t) { return value[static_cast<std::size_t>(t)]; }
};

/// Both lists as two Markdown tables: docs/vehicle_parameters.md is this text.
std::string describe_parameters();

/// All terms at 1, except locked_differential (a car has one differential) and brake_vanes (one law
/// of convection).
Amplitudes<double> default_amplitudes();

/// True for a number that is zero and whose derivatives, if it has any, are all zero; for a pack of
/// nothing else.
template <class T>
bool is_exactly_zero(const T& x) {
  if constexpr (kIsPack<T>) {
    return all(x == T(0.0));
  } else if constexpr (std::is_arithmetic_v<T>) {
    return x == T(0);
  } else {
    if (x.a != 0) return false;
    for (int i = 0; i < x.v.size(); ++i)
      if (x.v[i] != 0) return false;
    return true;
  }
}

/// The same, lane by lane.
template <class T>
Flag<T> exactly_zero(const T& x) {
  if constexpr (kIsPack<T>) {
    return x == T(0.0);
  } else {
    return is_exactly_zero(x);
  }
}

/// The value of a number without its derivatives.
template <class T>
Real<T> value_of(const T& x) {
  if constexpr (kIsPack<T>) {
    return x;
  } else if constexpr (std::is_arithmetic_v<T>) {
    return static_cast<double>(x);
  } else {
    return x.a;
  }
}

}  // namespace vehicle
