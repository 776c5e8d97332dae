#include "antenna.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <optional>
#include <vector>

#include "not_known.h"

namespace explain {
namespace {

/// By how much the path is faster than the car per rate of turning, from steps [begin, end), m: of
/// a fit with the speed's own scale and zero. None where the car turns too little to say.
std::optional<double> faster_by_turning(const Signals& s, std::size_t begin, std::size_t end) {
  constexpr double kRolls_mps = 8.0, kTurns_radps = 0.05;
  constexpr std::size_t kLeast = 200;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double turning = 0.0;
  std::size_t count = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const double vy = s.present[kVy] ? s.x[kVy][i] : 0.0, v = std::hypot(s.x[kVx][i], vy),
                 rate = s.present[kYawRate] ? s.x[kYawRate][i] : s.dx[kYaw][i],
                 path = std::hypot(s.dx[kX][i], s.dx[kY][i]) * std::hypot(1.0, s.grade[i]);
    if (!(v > kRolls_mps) || !std::isfinite(path + rate)) continue;
    const Eigen::Vector3d row(1.0, v, rate);
    normal += row * row.transpose();
    right += row * (path - v);
    turning += rate * rate;
    ++count;
  }
  if (count < kLeast || turning < kTurns_radps * kTurns_radps * static_cast<double>(count))
    return std::nullopt;
  normal.diagonal() *= 1 + 1e-9;
  return normal.ldlt().solve(right)[2];
}

}  // namespace

void doubt_antenna_aside(Signals& s) {
  if (!s.present[kYawRate] && !s.present[kYaw]) return;
  // Of 53 sound recordings, of four simulators and two real cars, none reaches it.
  constexpr double kCounts_m = 1.0, kAlike = 0.6;
  const auto all = faster_by_turning(s, 0, s.n), first = faster_by_turning(s, 0, s.n / 2),
             second = faster_by_turning(s, s.n / 2, s.n);
  if (!all || !first || !second || std::abs(*all) < kCounts_m) return;
  if (*first / *all < kAlike || *second / *all < kAlike) return;
  s.broken = true;
  s.remarks.push_back(fmt::format(
      "{}: '{}', '{}' are slower than '{}' in {} turns and faster in others, as a point {:.1f} m "
      "to the {} of where the speed is measured: give the places of the middle of the car, not of "
      "an antenna beside it",
      s.name, s.column[kX], s.column[kY], s.column[kVx], *all < 0 ? "left" : "right",
      std::abs(*all), *all < 0 ? "left" : "right"));
}

}  // namespace explain
