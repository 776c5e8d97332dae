#include "turns_along.h"

#include <algorithm>
#include <cmath>

namespace explain {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// A road turns where it does so by more than this; a turn by more than half of the most nearby.
constexpr double kTurns_1pm = 1.0 / 2500.0, kTurn_1pm = 1.0 / 1200.0, kNear_m = 200.0;

double step_up(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (10 - 15 * t + 6 * t * t);
}

}  // namespace

VectorXd side_of(const VectorXd& turned_rad, double place_m, bool closed,
                 std::vector<bool>& turns) {
  const Index n = turned_rad.size();
  constexpr Index kBeside = 3;
  VectorXd side = VectorXd::Zero(n);
  std::vector<Index> known;
  turns.assign(static_cast<std::size_t>(n), false);
  const double laps = std::max(1.0, turned_rad.cwiseAbs().sum() / (2 * 3.14159265358979323846));
  for (Index k = 0; k < n; ++k) {
    double sum = 0.0;
    for (Index d = -kBeside; d <= kBeside; ++d)
      if (closed || (k + d >= 0 && k + d < n)) sum += turned_rad[((k + d) % n + n) % n];
    if (std::abs(sum) < kTurns_1pm * (2 * kBeside + 1) * place_m * laps) continue;
    side[k] = sum > 0 ? -1.0 : 1.0;
    known.push_back(k);
    turns[static_cast<std::size_t>(k)] = true;
  }
  if (known.empty()) return side;
  for (std::size_t j = 0; j < known.size(); ++j) {
    const Index from = known[j], to = j + 1 < known.size() ? known[j + 1] : known[0] + n;
    if (to >= n && !closed) break;
    for (Index k = from + 1; k < to; ++k) {
      const double share = static_cast<double>(k - from) / static_cast<double>(to - from);
      side[k % n] = (1 - share) * side[from] + share * side[to % n];
    }
  }
  for (Index k = 0; !closed && k < n; ++k) {
    if (k < known.front()) side[k] = side[known.front()];
    if (k > known.back()) side[k] = side[known.back()];
  }
  return side;
}

VectorXd smooth(const VectorXd& x, double place_m, bool closed, Index reach, double bell_m) {
  const Index n = x.size();
  VectorXd out(n);
  for (Index k = 0; k < n; ++k) {
    double sum = 0.0, all = 0.0;
    for (Index d = -std::min(reach, n / 2); d <= std::min(reach, n / 2); ++d) {
      if (!closed && (k + d < 0 || k + d >= n)) continue;
      const double at = static_cast<double>(d) * place_m / bell_m, w = std::exp(-0.5 * at * at);
      sum += w * x[((k + d) % n + n) % n];
      all += w;
    }
    out[k] = sum / all;
  }
  return out;
}

std::vector<Turn> turns_of(const VectorXd& curvature_1pm, double place_m, bool closed) {
  const Index n = curvature_1pm.size(),
              reach = std::min(static_cast<Index>(kNear_m / place_m), n / 2);
  std::vector<int> way(static_cast<std::size_t>(n), 0);
  for (Index k = 0; k < n; ++k) {
    double most = 0.0;
    for (Index d = -reach; d <= reach; ++d)
      if (closed || (k + d >= 0 && k + d < n))
        most = std::max(most, std::abs(curvature_1pm[((k + d) % n + n) % n]));
    if (std::abs(curvature_1pm[k]) > std::max(0.5 * most, kTurn_1pm))
      way[static_cast<std::size_t>(k)] = curvature_1pm[k] > 0 ? 1 : -1;
  }
  const auto first = closed ? std::find(way.begin(), way.end(), 0) : way.begin();
  if (first == way.end()) return {};
  const auto from = static_cast<Index>(first - way.begin());
  std::vector<Turn> out;
  for (Index i = 0; i < n;) {
    const int now = way[static_cast<std::size_t>((from + i) % n)];
    Index j = i + 1;
    while (j < n && way[static_cast<std::size_t>((from + j) % n)] == now) ++j;
    constexpr double kShortest_m = 25.0, kApart_m = 60.0;
    const double length_m = static_cast<double>(j - i) * place_m,
                 begin_m = (static_cast<double>(from + i) - 0.5) * place_m;
    const double side = now > 0 ? -1.0 : 1.0;
    if (now != 0 && !out.empty() && out.back().side == side &&
        begin_m - out.back().end_m < kApart_m)
      out.back().end_m = begin_m + length_m;
    else if (now != 0 && length_m >= kShortest_m)
      out.push_back({begin_m, begin_m + length_m, side});
    i = j;
  }
  const double lap_m = static_cast<double>(n) * place_m;
  for (Turn& turn : out)
    if (closed && turn.begin_m >= lap_m) turn.begin_m -= lap_m, turn.end_m -= lap_m;
  return out;
}

Eigen::MatrixXd ramps_of(const std::vector<Turn>& turns, Index places, double place_m, bool closed,
                         const Ramps& ramps) {
  const double lap_m = closed ? static_cast<double>(places) * place_m : 0.0;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(places, static_cast<Index>(turns.size()));
  for (Index t = 0; t < out.cols(); ++t) {
    const Turn& turn = turns[static_cast<std::size_t>(t)];
    for (Index k = 0; k < places; ++k)
      for (const int lap : {-1, 0, 1}) {
        if (!closed && lap != 0) continue;
        const double at_m = static_cast<double>(k) * place_m + lap * lap_m;
        out(k, t) +=
            turn.side * (step_up((at_m - turn.begin_m + ramps.begin_m[t]) / ramps.length_m + 0.5) -
                         step_up((at_m - turn.end_m - ramps.end_m[t]) / ramps.length_m + 0.5));
      }
  }
  return out;
}

}  // namespace explain
