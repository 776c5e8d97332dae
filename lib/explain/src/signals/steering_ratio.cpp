#include "steering_ratio.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "path_says.h"

namespace explain {

void leave_out_other_steering(Signals& s, const vehicle::Vehicle& car) {
  if (!s.present[kSteer] || s.commanded[kSteer]) return;
  const PathSays path = path_says(s);
  const Match follows = match(s.x[kSteer], path.curvature, 0.005);
  constexpr double kFollows = 0.9, kApart = 0.1, kLow = 0.7, kHigh = 1.4;
  if (!follows.known || !(follows.correlation > kFollows)) return;
  Eigen::Matrix3d sums = Eigen::Matrix3d::Zero();  // of what wheelbase and tyres ask, and of it
  for (std::size_t i = 0; i < s.n; ++i) {
    const double bend_1pm = path.turn_radps[i] / s.x[kVx][i];
    const Eigen::Vector3d at(bend_1pm, path.turn_radps[i] * s.x[kVx][i], s.x[kSteer][i]);
    if (at.allFinite()) sums += at * at.transpose();
  }
  const Eigen::Matrix2d both = sums.topLeftCorner<2, 2>();
  if (both.determinant() < kApart * both(0, 0) * both(1, 1)) return;
  const double ratio = both.ldlt().solve(sums.topRightCorner<2, 1>())[0] /
                       car.parameters[vehicle::Parameter::chassis_wheelbase_m];
  if (ratio > kLow && ratio < kHigh) return;
  s.broken = true;
  s.present[kSteer] = false;
  s.remarks.push_back(
      fmt::format("{}: '{}' turns {:.2f} times as much as the wheelbase asks in these bends: "
                  "another unit, the steering wheel, or another car: not used; correct it in the "
                  "mapping (scale {:.3g})",
                  s.name, s.column[kSteer], ratio, 1 / ratio));
}

}  // namespace explain
