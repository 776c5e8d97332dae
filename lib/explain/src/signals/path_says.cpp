#include "path_says.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "changes_in_time.h"
#include "not_known.h"

namespace explain {
namespace {

/// The larger half of the steps over which the course of the path is taken: positions jitter by
/// centimetres and decimetres, and the course between two that are close jitters with them.
constexpr std::size_t kChord = 8;

/// Steps of shift that are tried to either side.
constexpr int kMost = 60;

/// Worth of a shift, less the closer it is to none.
double worth(double correlation, int lag) { return std::abs(correlation) - 0.0002 * std::abs(lag); }

Match at_shift(const std::vector<double>& x, const std::vector<double>& reference,
               double least_swing, int lag) {
  double n = 0, sx = 0, sr = 0, xx = 0, rr = 0, xr = 0;
  for (std::size_t i = kMost; i + kMost < reference.size(); i += 2) {
    const double r = reference[i],
                 v = x[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + lag)];
    if (!std::isfinite(r) || !std::isfinite(v)) continue;
    n += 1, sx += v, sr += r, xx += v * v, rr += r * r, xr += v * r;
  }
  if (n < 100) return {};
  const double vx = xx / n - sx * sx / n / n, vr = rr / n - sr * sr / n / n,
               c = xr / n - sx * sr / n / n;
  if (!(vr > least_swing * least_swing) || !(vx > 0)) return {};
  return {c / std::sqrt(vx * vr), c / vr, lag * Signals::kStep_s, true};
}

/// How much of `slip` a lateral speed holds beside what a lever arm adds to it by turning and a
/// heading that is a little off by speed: noise of `slip` makes less of it, up to `most`.
struct Share {
  double least = 0.0, most = 0.0;
};
Share share_of_slip(const Signals& s, const PathSays& path) {
  Eigen::Matrix4d sums = Eigen::Matrix4d::Zero();
  for (std::size_t i = 0; i < s.n; ++i) {
    const Eigen::Vector4d at(s.x[kVy][i], path.slip_mps[i], path.turn_radps[i], s.x[kVx][i]);
    if (at.allFinite()) sums += at * at.transpose();
  }
  // Of both what the other two do not hold.
  const Eigen::Matrix2d both =
      sums.topLeftCorner<2, 2>() -
      sums.topRightCorner<2, 2>() *
          sums.bottomRightCorner<2, 2>().ldlt().solve(sums.bottomLeftCorner<2, 2>());
  return {both(0, 1) / both(1, 1), both(0, 0) / both(0, 1)};
}

}  // namespace

Match match(const std::vector<double>& x, const std::vector<double>& reference,
            double least_swing) {
  Match best;
  int at = 0;
  double at_once = 0;
  for (int lag = -kMost; lag <= kMost; ++lag) {
    const Match here = at_shift(x, reference, least_swing, lag);
    if (here.known && (!best.known || worth(here.correlation, lag) > worth(best.correlation, at)))
      best = here, at = lag;
    if (lag == 0) at_once = here.correlation;
  }
  best.at_once = at_once;
  if (!best.known || std::abs(at) == kMost) return best;
  const double before = std::abs(at_shift(x, reference, least_swing, at - 1).correlation),
               after = std::abs(at_shift(x, reference, least_swing, at + 1).correlation),
               bend = before + after - 2 * std::abs(best.correlation);
  if (bend < 0)
    best.lag_s += Signals::kStep_s * std::clamp(0.5 * (before - after) / bend, -0.5, 0.5);
  return best;
}

PathSays path_says(const Signals& s) {
  PathSays p;
  for (auto* v :
       {&p.turn_radps, &p.along_mps2, &p.across_mps2, &p.curvature, &p.slowing_mps2, &p.slip_mps})
    v->assign(s.n, kNaN);
  for (std::size_t i = kChord; i + kChord < s.n; ++i) {
    const double speed = std::hypot(s.dx[kX][i], s.dx[kY][i]);
    if (!(speed > 6)) continue;
    // Between the chords before and behind.
    const double before =
                     std::atan2(s.x[kY][i] - s.x[kY][i - kChord], s.x[kX][i] - s.x[kX][i - kChord]),
                 after =
                     std::atan2(s.x[kY][i + kChord] - s.x[kY][i], s.x[kX][i + kChord] - s.x[kX][i]);
    p.turn_radps[i] = std::remainder(after - before, 2 * std::numbers::pi) /
                      (static_cast<double>(kChord) * Signals::kStep_s);
    p.along_mps2[i] = s.dx[kVx][i];
    p.slowing_mps2[i] = -p.along_mps2[i];
    p.across_mps2[i] = p.turn_radps[i] * speed;
    p.curvature[i] = 3.0 * p.turn_radps[i] / speed;
    if (s.present[kYaw])
      p.slip_mps[i] =
          s.x[kVx][i] * std::sin(std::remainder(std::atan2(s.dx[kY][i], s.dx[kX][i]) - s.x[kYaw][i],
                                                2 * std::numbers::pi));
  }
  return p;
}

std::vector<double> between_chords(const std::vector<double>& turning) {
  std::vector<double> out(turning.size(), kNaN);
  constexpr double kAll = static_cast<double>(kChord * kChord);
  for (std::size_t i = kChord; i + kChord < turning.size(); ++i) {
    double sum = static_cast<double>(kChord) * turning[i];
    for (std::size_t d = 1; d < kChord; ++d)
      sum += static_cast<double>(kChord - d) * (turning[i - d] + turning[i + d]);
    out[i] = sum / kAll;
  }
  return out;
}

std::string wrong_with_slip(const Signals& s, const PathSays& path) {
  if (!s.present[kVy] || !s.present[kYaw]) return {};
  const Match m = match(s.x[kVy], path.slip_mps, 0.1);
  if (!m.known) return {};
  // Far ahead of the centre of mass turning outweighs the slip; that is a place, no sign.
  const Share share = share_of_slip(s, path);
  constexpr double kHigh = 1.4, kLow = 0.67, kTold = 0.6, kFollows = 0.9, kLate_s = 0.15,
                   kOnTime_s = 0.15;
  const Match heading = match(s.dx[kYaw], path.turn_radps, 0.02);
  if (m.correlation > kFollows && std::abs(m.lag_s) > kLate_s &&
      std::abs(heading.lag_s) < kOnTime_s)
    return fmt::format("runs on another clock: {:.2f} s {} against the path and the heading",
                       std::abs(m.lag_s), m.lag_s > 0 ? "late" : "early");
  if (m.correlation < -0.3 && share.least < 0)
    return "has the other sign than the path against the heading";
  if (const auto change = slope_changes(s.x[kVy], path.slip_mps, 0.1, m.lag_s, 1.6))
    return fmt::format(
        "is {:.2f} times the path against the heading until about {:.0f} s, and {:.2f} times after "
        "it",
        change->before, change->time_s, change->after);
  if (m.correlation > 0.5 &&
      (share.least > kHigh || (share.most < kLow && share.least > kTold * share.most)))
    return fmt::format(
        "is {:.3g} times the path against the heading, or more where positions jitter: another "
        "unit",
        share.least);
  return {};
}

}  // namespace explain
