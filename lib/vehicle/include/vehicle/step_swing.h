// Finds what an integration that is about to become unstable does: it swings at its step.
#pragma once

#include <array>
#include <string>

#include "vehicle/step.h"

namespace vehicle {

/// Looks for quantities that go up in one step and down in the next, on and on: load, longitudinal
/// force, side force (as shares of the static load) and speed of every wheel, the speed of the
/// engine (as a share of itself, of 10 rad/s where it is slower), and the three components of what
/// an accelerometer measures (as shares of 9.81 m/s2). A plain value; look() after every step.
class StepSwing {
 public:
  /// From here on a run says so.
  static constexpr double kWorthSaying = 0.01;

  void look(const Car<double>& car, const State<double>& state, const Detail<double>& detail);

  /// The smallest change in 12 alternating steps in a row, as a share; the largest so far.
  double largest() const { return largest_; }

  /// Empty below kWorthSaying, else one sentence: what swings, by how much, what to do.
  std::string warning(const StepOptions& options) const;

 private:
  static constexpr std::size_t kRun = 12, kQuantities = 4 * kWheels + 4;
  static constexpr double kSlow_radps = 10.0;
  struct Quantity {
    double value = 0.0;
    std::array<double, kRun> changes{};
    std::size_t next = 0, run = 0;
  };
  std::array<Quantity, kQuantities> quantities_;
  double largest_ = 0.0;
  std::size_t which_ = 0;
};

}  // namespace vehicle
