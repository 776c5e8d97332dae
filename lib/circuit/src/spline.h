// Smooth functions over u through a few knots. Private to the circuit.
#pragma once

#include <vector>

#include "circuit/circuit.h"

namespace road {

/// Cubic Hermite pieces over knots. With a period the last piece leads back to the first knot.
class Spline {
 public:
  Spline() = default;

  /// C2: natural at the ends, or periodic (`period_m` > 0).
  static Spline smooth(const Knots& knots, double period_m);

  /// C1 and monotone between knots (Fritsch & Butland 1984): no overshoot.
  static Spline monotone(const Knots& knots, double period_m);

  double at(double u_m) const;
  double largest() const;

 private:
  Spline(const Knots& knots, double period_m)
      : u_(knots.u_m), value_(knots.value), slope_(u_.size(), 0.0), period_m_(period_m) {}

  double step(std::size_t i) const {
    return i + 1 < u_.size() ? u_[i + 1] - u_[i] : u_[0] + period_m_ - u_[i];
  }
  double secant(std::size_t i) const { return (value_[(i + 1) % u_.size()] - value_[i]) / step(i); }

  std::vector<double> u_, value_, slope_;
  double period_m_ = 0.0;  // 0: open
};

}  // namespace road
