#include "scales_of_car.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "changes_in_time.h"
#include "not_known.h"
#include "path_says.h"

namespace explain {
namespace {

/// Ratios beyond are of no car of which the file is meant; on an oval that leans loads are half
/// more.
constexpr double kLow = 0.7, kHigh = 1.4, kHighLoad = 1.7;

/// What a pedal usually shows where the car speeds up so at that speed; NaN where it rests.
std::vector<double> usual_for_motion(const Signals& s, const std::vector<double>& pedal,
                                     double rests) {
  constexpr int kTerms = 5;
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  const auto terms = [&](std::size_t i) {
    const double v = s.x[kVx][i] / 30.0, a = s.dx[kVx][i] / 5.0;
    return Terms(1.0, v, v * v, a, a * v);
  };
  const auto pressed = [&](std::size_t i) {
    const double v = s.x[kVx][i], a = s.dx[kVx][i];  // a limiter holds the speed of a pit lane
    return v > kMayStand_mps && pedal[i] > rests && (v > 25.0 || std::abs(a) > 0.3);
  };
  Eigen::Matrix<double, kTerms, kTerms> normal = decltype(normal)::Identity() * 1e-6;
  Terms right = Terms::Zero();
  for (std::size_t i = 0; i < s.n; ++i)
    if (pressed(i)) normal += terms(i) * terms(i).transpose(), right += terms(i) * pedal[i];
  const Terms fitted = normal.ldlt().solve(right);
  std::vector<double> out(s.n, kNaN);
  for (std::size_t i = 0; i < s.n; ++i)
    if (pressed(i)) out[i] = std::max(rests, terms(i).dot(fitted));
  return out;
}

}  // namespace

void leave_out_other_steering(Signals& s, const vehicle::Vehicle& car) {
  if (!s.present[kSteer] || s.commanded[kSteer]) return;
  const PathSays path = path_says(s);
  const Match follows = match(s.x[kSteer], path.curvature, 0.005);
  constexpr double kFollows = 0.9, kApart = 0.1;
  if (!follows.known || !(follows.correlation > kFollows)) return;
  const double base_m = car.parameters[vehicle::Parameter::chassis_wheelbase_m];
  Eigen::Matrix3d sums = Eigen::Matrix3d::Zero();  // of what wheelbase and tyres ask, and of it
  for (std::size_t i = 0; i < s.n; ++i) {
    const Eigen::Vector3d at(base_m * path.turn_radps[i] / s.x[kVx][i],
                             path.turn_radps[i] * s.x[kVx][i], s.x[kSteer][i]);
    if (at.allFinite()) sums += at * at.transpose();
  }
  const Eigen::Matrix2d both = sums.topLeftCorner<2, 2>();
  if (!(both.determinant() > kApart * both(0, 0) * both(1, 1))) return;
  const double ratio = both.ldlt().solve(sums.topRightCorner<2, 1>())[0];
  if (!(ratio > 0.0) || (ratio > kLow && ratio < kHigh)) return;  // below: nothing is told apart
  s.broken = true;
  s.present[kSteer] = false;
  s.remarks.push_back(
      fmt::format("{}: '{}' turns {:.2f} times as much as the wheelbase asks in these bends: "
                  "another unit, the steering wheel, or another car: not used; correct it in the "
                  "mapping (scale {:.3g})",
                  s.name, s.column[kSteer], ratio, 1 / ratio));
}

void leave_out_other_loads(Signals& s, const vehicle::Vehicle& car) {
  if (!s.present[kLoadFront] || !s.present[kLoadRear]) return;
  using P = vehicle::Parameter;
  const auto& p = car.parameters;
  const double weight_n = p[P::chassis_mass_kg] * p[P::environment_gravity_mps2],
               by_square = 0.5 * p[P::aero_density_kgpm3] *
                           (p[P::front_lift_area_m2] + p[P::rear_lift_area_m2]);
  double logged_n = 0.0, stated_n = 0.0;
  std::vector<double> of_all_n(s.n), wanted_n(s.n);
  for (std::size_t i = 0; i < s.n; ++i) {
    of_all_n[i] = s.x[kLoadFront][i] + s.x[kLoadRear][i];
    wanted_n[i] = weight_n + by_square * s.x[kVx][i] * s.x[kVx][i];
    if (std::isfinite(wanted_n[i] + of_all_n[i])) logged_n += of_all_n[i], stated_n += wanted_n[i];
  }
  const double ratio = logged_n / stated_n;
  constexpr double kLoadChanges = 1.25;
  const auto change = ratio_changes(of_all_n, wanted_n, kLoadChanges);
  if (!change && !(ratio < kLow || ratio > kHighLoad)) return;
  s.broken = true;
  s.present[kLoadFront] = s.present[kLoadRear] = false;
  const std::string hold = fmt::format(
      "{}: '{}', '{}' hold {:.2f} times the weight and downforce "
      "of the car",
      s.name, s.column[kLoadFront], s.column[kLoadRear], change ? change->before : ratio);
  s.remarks.push_back(
      hold + (change ? fmt::format(" until about {:.0f} s, and {:.2f} times after it: not used; "
                                   "correct them in the mapping, or leave that part of the log out",
                                   change->time_s, change->after)
                     : fmt::format(": another unit, or another car: not used; correct them in the "
                                   "mapping (scale {:.3g})",
                                   1 / ratio)));
}

void leave_out_what_changes(Signals& s) {
  std::vector<double> rolling = s.x[kVx];
  for (double& v : rolling)
    if (!(v > kMayStand_mps)) v = kNaN;
  for (const Channel c : {kWheelFront, kWheelRear}) {
    if (!s.present[c]) continue;
    const auto change = ratio_changes(s.x[c], rolling, kSpeedChanges);
    if (!change) continue;
    s.broken = true;
    s.remarks.push_back(
        fmt::format("{}: '{}' is {:.3g} times the speed until about {:.0f} s, and {:.3g} times "
                    "after it: not used; correct it in the mapping",
                    s.name, s.column[c], change->before, change->time_s, change->after));
    s.present[c] = false;
    if (c == kWheelRear) s.present[kWheelRearDifference] = false;
  }
  constexpr double kOpen = 0.03, kBraked_pa = 1e5, kPedalChanges = 1.6;
  for (const Channel c : {kThrottle, kBrakeFront}) {
    if (!s.present[c]) continue;
    const auto change = ratio_changes(
        s.x[c], usual_for_motion(s, s.x[c], c == kThrottle ? kOpen : kBraked_pa), kPedalChanges);
    if (!change) continue;
    s.broken = true;
    s.remarks.push_back(fmt::format(
        "{}: '{}' is {:.2f} times what it usually is for what the car does until about {:.0f} s, "
        "and {:.2f} times after it: not used; correct it in the mapping, or leave that part of the "
        "log out. Forces are not compared until that is mended; sensors and kinematics are",
        s.name, s.column[c], change->before, change->time_s, change->after));
    for (const Channel force :
         {kSteer, kThrottle, kBrakeFront, kBrakeRear, kBrakeFrontApart, kBrakeRearApart})
      s.present[force] = false;
  }
}

}  // namespace explain
