#include "changes_in_time.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "explain/signals.h"

namespace explain {
namespace {

constexpr std::size_t kWindow = static_cast<std::size_t>(10.0 / Signals::kStep_s);

double median(std::vector<double> x) {
  std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2), x.end());
  return x[x.size() / 2];
}

/// How far `share` of the values are from one.
double farthest(std::vector<double> x, double from, double share) {
  for (double& v : x) v = std::abs(v - from);
  const auto at =
      x.begin() + static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(x.size()))) - 1;
  std::nth_element(x.begin(), at, x.end());
  return *at;
}

/// One window: where it begins and what was measured in it.
struct Window {
  std::size_t begin;
  double value;
};

std::vector<Window> slopes(const std::vector<double>& x, const std::vector<double>& reference,
                           double least_swing, double lag_s) {
  const auto lag = static_cast<std::ptrdiff_t>(std::lround(lag_s / Signals::kStep_s));
  std::vector<Window> out;
  for (std::size_t begin = 0; begin + kWindow <= reference.size(); begin += kWindow) {
    double n = 0, sx = 0, sr = 0, xx = 0, rr = 0, xr = 0;
    for (std::size_t i = begin; i < begin + kWindow; ++i) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(i) + lag;
      if (at < 0 || at >= static_cast<std::ptrdiff_t>(x.size())) continue;
      const double v = x[static_cast<std::size_t>(at)], r = reference[i];
      if (!std::isfinite(v) || !std::isfinite(r)) continue;
      n += 1, sx += v, sr += r, xx += v * v, rr += r * r, xr += v * r;
    }
    if (2 * n < kWindow) continue;
    const double vx = xx / n - sx * sx / n / n, vr = rr / n - sr * sr / n / n,
                 c = xr / n - sx * sr / n / n;
    if (vr > least_swing * least_swing && c > 0.9 * std::sqrt(vx * vr))
      out.push_back({begin, c / vr});
  }
  return out;
}

/// Where the values become `counts` times as large or small and stay so; `share` of those of one
/// side lie within half of the change.
std::optional<Change> step_of(const std::vector<Window>& windows, double share, double counts) {
  constexpr std::size_t kEachSide = 2;
  std::optional<Change> best;
  double least = HUGE_VAL;
  // Else the window in which it changes is neither before nor after.
  for (std::size_t between = 0; between < 2 && !best; ++between)
    for (std::size_t k = kEachSide; k + between + kEachSide <= windows.size(); ++k) {
      std::vector<double> before, after;
      for (std::size_t j = 0; j < windows.size(); ++j)
        if (j < k || j >= k + between) (j < k ? before : after).push_back(windows[j].value);
      const double a = median(before), b = median(after);
      const double scatter = std::max(farthest(before, a, share), farthest(after, b, share));
      if (std::max(a, b) < counts * std::min(a, b) || scatter > 0.5 * std::abs(b - a)) continue;
      double sum = 0.0;
      for (const auto& [side, middle] : {std::pair{&before, a}, {&after, b}})
        for (const double v : *side) sum += std::abs(v - middle);
      if (sum < least)
        least = sum, best = Change{static_cast<double>(windows[k].begin) * Signals::kStep_s, a, b};
    }
  return best;
}

}  // namespace

std::optional<Change> slope_changes(const std::vector<double>& x,
                                    const std::vector<double>& reference, double least_swing,
                                    double lag_s, double counts) {
  return step_of(slopes(x, reference, least_swing, lag_s), 1.0, counts);
}

std::optional<Change> ratio_changes(const std::vector<double>& x,
                                    const std::vector<double>& expected, double counts) {
  constexpr double kShare = 0.8;
  constexpr std::size_t kLeast = kWindow / 4;
  std::vector<Window> windows;
  for (std::size_t begin = 0; begin + kWindow <= expected.size(); begin += kWindow) {
    double square = 0.0, both = 0.0;
    std::size_t count = 0;
    for (std::size_t i = begin; i < begin + kWindow; ++i)
      if (std::isfinite(x[i] * expected[i]))
        square += expected[i] * expected[i], both += x[i] * expected[i], ++count;
    if (count >= kLeast && square > 0) windows.push_back({begin, both / square});
  }
  return step_of(windows, kShare, counts);
}

std::optional<Change> drifts(const std::vector<double>& x, const std::vector<double>& reference) {
  // What a road that leans adds is no drift: it goes with the reference.
  constexpr Eigen::Index kTerms = 3;
  Eigen::MatrixXd terms(static_cast<Eigen::Index>(x.size() / kWindow), kTerms);
  Eigen::VectorXd apart(terms.rows());
  Eigen::Index count = 0;
  const double end_s = static_cast<double>(x.size() - 1) * Signals::kStep_s;
  for (std::size_t begin = 0; begin + kWindow <= x.size(); begin += kWindow) {
    double n = 0, sum = 0, level = 0;
    for (std::size_t i = begin; i < begin + kWindow; ++i)
      if (std::isfinite(x[i] - reference[i]))
        n += 1, sum += x[i] - reference[i], level += reference[i];
    if (2 * n <= kWindow) continue;
    const double part = (static_cast<double>(begin) + 0.5 * kWindow) * Signals::kStep_s / end_s;
    terms.row(count) << 1, part, level / n;
    apart[count++] = sum / n;
  }
  if (count < 2 * kTerms) return std::nullopt;
  // A window in which one of them leaps says nothing: left out beyond four standard deviations.
  constexpr double kLeap = 4.0;
  Eigen::VectorXd used = Eigen::VectorXd::Ones(count);
  Eigen::Vector3d fitted;
  double deviation = 0.0;
  for (int round = 0; round < 4; ++round) {
    const Eigen::MatrixXd in = used.asDiagonal() * terms.topRows(count);
    Eigen::Matrix3d normal = in.transpose() * in;
    normal.diagonal() *= 1 + 1e-9;
    const Eigen::Matrix3d inverse = normal.inverse();
    fitted = inverse * (in.transpose() * apart.head(count));
    const Eigen::VectorXd e = apart.head(count) - terms.topRows(count) * fitted;
    const double n = used.sum();
    if (n < 2 * kTerms) return std::nullopt;
    deviation = std::sqrt(used.cwiseProduct(e).squaredNorm() / (n - kTerms) * inverse(1, 1));
    std::vector<double> sizes;
    for (const double far : e) sizes.push_back(std::abs(far));
    const double sigma = 1.4826 * median(sizes);
    used = (e.array().abs() <= kLeap * sigma).cast<double>();
  }
  if (!(std::abs(fitted[1]) > 10 * deviation)) return std::nullopt;
  return Change{end_s, fitted[0], fitted[0] + fitted[1]};
}

}  // namespace explain
