// Why a car left its line: which limit it met.
#pragma once

#include <string>

#include "vehicle/step.h"

namespace vehicle {

/// Looks at every step; a plain value.
class OffLine {
 public:
  static constexpr double kFar_m = 3.0;

  /// `plan_k`: the tyres' temperature that the plan of speeds reckons with.
  void look(const Car<double>& car, const State<double>& state, const Detail<double>& detail,
            double away_m, double time_s, double step_s, double plan_k);

  /// One sentence about the first place where the car was kFar_m off its line; empty: nowhere.
  const std::string& limit() const { return limit_; }

 private:
  std::string reason(const Car<double>& car, double coldest_k, double plan_k) const;

  double lifted_ = 0.0, front_ = 0.0, rear_ = 0.0;  ///< over the second before
  std::string limit_;
};

}  // namespace vehicle
