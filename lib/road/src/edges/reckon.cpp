#include "road/reckon.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "base/statistics.h"
#include "mesh/error.h"
#include "recording/recording.h"

namespace road {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr std::size_t kMostCells = 6000;  // of which the same bends are looked for
constexpr double kSameBends = 0.6;        // correlation of a lap with the next
constexpr double kOtherBends = 0.5;       // share of the best: a way within one bend is no lap
constexpr double kWholeTurns = 0.15;      // turns off a whole number, which a gyro's bias makes
constexpr double kMostGap = 0.25;         // of a lap

/// The drive over the way driven: how far the path has turned.
struct Motion {
  std::vector<double> time_s, s_m, turned_rad;  // of each row, from 0
};

Motion integrate(const std::vector<double>& time_s, const std::vector<double>& vx_mps,
                 const std::vector<double>& yaw_rate_radps, const std::vector<double>& vy_mps) {
  const std::vector<double> v = recording::fill_gaps(time_s, vx_mps),
                            r = recording::fill_gaps(time_s, yaw_rate_radps),
                            left = recording::fill_gaps(time_s, vy_mps);
  constexpr double kSlow_mps = 3.0;  // a side slip says nothing below
  const auto slip_rad = [&](std::size_t i) {
    return left.empty() || !(v[i] > kSlow_mps) || !std::isfinite(left[i])
               ? 0.0
               : std::atan2(left[i], v[i]);
  };
  Motion m{time_s, {0.0}, {0.0}};
  double turned_rad = 0.0;  // of the nose
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    const double dt = time_s[i] - time_s[i - 1],
                 way_mps =
                     0.5 * (v[i] / std::cos(slip_rad(i)) + v[i - 1] / std::cos(slip_rad(i - 1)));
    turned_rad += dt * 0.5 * (r[i] + r[i - 1]);
    m.s_m.push_back(m.s_m.back() + dt * std::max(0.0, way_mps));
    m.turned_rad.push_back(turned_rad + slip_rad(i) - slip_rad(0));
  }
  return m;
}

/// Of `values` over ascending `at`, at one place.
double value_at(const std::vector<double>& at, const std::vector<double>& values, double x) {
  const auto upper = std::upper_bound(at.begin(), at.end(), x);
  if (upper == at.begin()) return values.front();
  if (upper == at.end()) return values.back();
  const auto i = static_cast<std::size_t>(upper - at.begin());
  const double span = at[i] - at[i - 1];
  return values[i - 1] + (span > 0 ? (x - at[i - 1]) / span : 0.0) * (values[i] - values[i - 1]);
}

/// Curvature in cells of equal length, over three of them.
struct Bends {
  double cell_m = 0.0;
  std::vector<double> curvature_1pm, turned_rad;

  double correlation(std::size_t from, std::size_t to, std::size_t lag) const {
    double ab = 0, aa = 0, bb = 0;
    for (std::size_t k = from; k < to; ++k) {
      const double a = curvature_1pm[k], b = curvature_1pm[k + lag];
      ab += a * b, aa += a * a, bb += b * b;
    }
    return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0.0;
  }
};

Bends bends_of(const Motion& m) {
  Bends out;
  const std::size_t n = std::min(kMostCells, m.time_s.size());
  out.cell_m = m.s_m.back() / static_cast<double>(n);
  for (std::size_t k = 0; k <= n; ++k)
    out.turned_rad.push_back(value_at(m.s_m, m.turned_rad, out.cell_m * static_cast<double>(k)));
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t a = k > 0 ? k - 1 : 0, b = std::min(n, k + 2);
    out.curvature_1pm.push_back((out.turned_rad[b] - out.turned_rad[a]) /
                                (out.cell_m * static_cast<double>(b - a)));
  }
  return out;
}

struct Lap {
  std::size_t cells = 0;
  double turns = 0.0;  // a whole number
};

/// The shortest way after which everything comes again.
std::optional<Lap> find_lap(const Bends& bends) {
  const std::size_t n = bends.curvature_1pm.size(), least = 10, most = 3 * n / 4;
  std::vector<double> same(most, 0.0);
  for (std::size_t lag = least; lag < most; ++lag) same[lag] = bends.correlation(0, n - lag, lag);
  const auto off_turns = [&](std::size_t lag) {
    std::vector<double> turned;
    for (std::size_t k = 0; k + lag <= n; ++k)
      turned.push_back((bends.turned_rad[k + lag] - bends.turned_rad[k]) / kTurn_rad);
    return base::median(std::move(turned));
  };
  double best = 0.0;
  bool left_first_bend = false;
  std::optional<Lap> lap;
  double highest = 0.0;
  for (std::size_t lag = least; lag < most; ++lag) highest = std::max(highest, same[lag]);
  for (std::size_t lag = least; lag + 1 < most; ++lag) {
    left_first_bend = left_first_bend || same[lag] < kOtherBends * highest;
    const bool peak = same[lag] >= same[lag - 1] && same[lag] >= same[lag + 1];
    // A multiple of a lap may fit a little better than the lap.
    if (!left_first_bend || !peak || same[lag] < kSameBends || same[lag] < best + 0.1) continue;
    const double turns = off_turns(lag);
    if (std::abs(turns - std::round(turns)) > kWholeTurns) continue;
    best = same[lag];
    lap = {lag, std::round(turns)};
  }
  return lap;
}

/// The cell after one lap (or before it) where the bends around are those around `from`. None where
/// they agree best at the end of what was driven: the place may lie beyond.
std::optional<std::size_t> same_place(const Bends& bends, std::size_t from, const Lap& lap,
                                      bool forward) {
  const std::size_t n = bends.curvature_1pm.size(), around = lap.cells / 4,
                    slack = lap.cells / 30 + 2, shortest = lap.cells - slack,
                    longest = std::min(lap.cells + slack, forward ? n - from : from);
  double best = 0.0;
  std::size_t at = shortest;
  for (std::size_t lag = shortest; lag <= longest; ++lag) {
    const std::size_t first = forward ? from : from - lag;
    const std::size_t a = first > around ? first - around : 0,
                      b = std::min(first + around, n - lag);
    if (b < a + around) continue;
    const double same = bends.correlation(a, b, lag);
    if (same > best) best = same, at = lag;
  }
  if (best < 0.5 * kSameBends || at == shortest || at == longest) return std::nullopt;
  return forward ? from + at : from - at;
}

/// Where laps begin and end, m of way driven. They begin on a straight, where the way the car goes
/// is least in doubt.
std::vector<double> lap_lines(const Bends& bends, const Lap& lap) {
  const std::size_t n = bends.curvature_1pm.size(), half = lap.cells / 40 + 1;
  std::size_t start = 0;
  double straightest = std::numeric_limits<double>::infinity();
  for (std::size_t k = half; k + lap.cells + half <= n; ++k) {
    double bent = 0.0;
    for (const std::size_t at : {k, k + lap.cells})
      for (std::size_t i = at - half; i < std::min(n, at + half); ++i)
        bent += std::abs(bends.curvature_1pm[i]);
    if (bent < straightest) straightest = bent, start = k;
  }
  std::vector<std::size_t> lines{start};
  while (const auto next = same_place(bends, lines.back(), lap, true)) lines.push_back(*next);
  while (const auto before = same_place(bends, lines.front(), lap, false))
    lines.insert(lines.begin(), *before);
  std::vector<double> out;
  for (const std::size_t line : lines) out.push_back(bends.cell_m * static_cast<double>(line));
  return out;
}

/// Places of rows [begin, end) from a row at the origin on, forward or backward in time.
class Walk {
 public:
  Walk(const Motion& m, ReckonedPlaces& out) : m_(m), out_(out) {}

  /// From `from_m` to `to_m` of way, which may lie before it; the heading is 0 at `from_m` and
  /// loses `bias_radps`. Gives back where it ends.
  std::pair<double, double> go(double from_m, double to_m, double bias_radps) {
    const double t0 = value_at(m_.s_m, m_.time_s, from_m),
                 turned0 = value_at(m_.s_m, m_.turned_rad, from_m);
    const auto heading = [&](double t, double turned) {
      return turned - turned0 - bias_radps * (t - t0);
    };
    const bool forward = to_m >= from_m;
    double x = 0, y = 0, s = from_m, angle = 0.0;
    const auto step = [&](double to, double next_angle) {
      const double mean = 0.5 * (angle + next_angle);
      x += (to - s) * std::cos(mean), y += (to - s) * std::sin(mean);
      s = to, angle = next_angle;
    };
    const auto first = static_cast<std::size_t>(
        std::upper_bound(m_.s_m.begin(), m_.s_m.end(), from_m) - m_.s_m.begin());
    for (std::size_t k = forward ? first : first - 1;; k += forward ? 1 : std::size_t(-1)) {
      if (k >= m_.s_m.size() || (forward ? m_.s_m[k] > to_m : m_.s_m[k] < to_m)) break;
      step(m_.s_m[k], heading(m_.time_s[k], m_.turned_rad[k]));
      out_.x_m[k] = x, out_.y_m[k] = y;
    }
    step(to_m, heading(value_at(m_.s_m, m_.time_s, to_m), value_at(m_.s_m, m_.turned_rad, to_m)));
    return {x, y};
  }

 private:
  const Motion& m_;
  ReckonedPlaces& out_;
};

/// Every lap comes back to the origin, and goes on as it began.
void close_laps(const Motion& m, const std::vector<double>& lines, double turns,
                const std::string& name, ReckonedPlaces& out) {
  Walk walk(m, out);
  std::vector<double> lengths_m, biases_radps;
  for (std::size_t lap = 0; lap + 1 < lines.size(); ++lap) {
    const double a = lines[lap], b = lines[lap + 1];
    const double over =
        value_at(m.s_m, m.turned_rad, b) - value_at(m.s_m, m.turned_rad, a) - kTurn_rad * turns;
    biases_radps.push_back(over / (value_at(m.s_m, m.time_s, b) - value_at(m.s_m, m.time_s, a)));
    const auto [x, y] = walk.go(a, b, biases_radps.back());
    for (std::size_t k = 0; k < m.s_m.size(); ++k)
      if (m.s_m[k] > a && m.s_m[k] <= b) {
        out.x_m[k] -= x * (m.s_m[k] - a) / (b - a);
        out.y_m[k] -= y * (m.s_m[k] - a) / (b - a);
      }
    lengths_m.push_back(b - a);
    out.turn_rad = std::max(out.turn_rad, std::abs(over));
    out.gap_m = std::max(out.gap_m, std::hypot(x, y));
  }
  out.laps = lengths_m.size();
  const auto row_after = [&](double s_m) {
    return static_cast<std::size_t>(std::upper_bound(m.s_m.begin(), m.s_m.end(), s_m) -
                                    m.s_m.begin());
  };
  out.begin = row_after(lines.front());
  out.end = row_after(lines.back());
  out.lap_m = base::median(lengths_m);
  if (out.gap_m > kMostGap * out.lap_m)
    throw Error(fmt::format(
        "{}: speed and yaw rate miss the start of a lap of {:.0f} m by {:.0f} m; wanted a forward "
        "speed in m/s and a yaw rate in rad/s: look at their units in the mapping",
        name, out.lap_m, out.gap_m));
  walk.go(lines.front(), std::max(0.0, lines.front() - out.lap_m), biases_radps.front());
  walk.go(lines.back(), std::min(m.s_m.back(), lines.back() + out.lap_m), biases_radps.back());
}

}  // namespace

ReckonedPlaces reckon_places(const std::string& name, const std::vector<double>& time_s,
                             const std::vector<double>& vx_mps,
                             const std::vector<double>& yaw_rate_radps,
                             const std::vector<double>& vy_mps) {
  constexpr std::size_t kLeastRows = 50;
  if (time_s.size() < kLeastRows)
    throw Error(fmt::format("{}: {} rows; wanted {} with a speed and a yaw rate", name,
                            time_s.size(), kLeastRows));
  const Motion motion = integrate(time_s, vx_mps, yaw_rate_radps, vy_mps);
  if (!(motion.s_m.back() > 10.0) || !std::isfinite(motion.turned_rad.back()))
    throw Error(fmt::format("{}: a way of {:.1f} m by its speed and yaw rate; wanted a drive", name,
                            motion.s_m.back()));
  ReckonedPlaces out;
  out.x_m.assign(time_s.size(), std::numeric_limits<double>::quiet_NaN());
  out.y_m = out.x_m;
  out.end = time_s.size();
  const Bends bends = bends_of(motion);
  const std::optional<Lap> lap = find_lap(bends);
  const std::vector<double> lines = lap ? lap_lines(bends, *lap) : std::vector<double>{};
  if (lines.size() >= 2) {
    close_laps(motion, lines, lap->turns, name, out);
  } else {
    out.lap_m = motion.s_m.back();
    Walk(motion, out).go(0.0, out.lap_m, 0.0);
  }
  return out;
}

}  // namespace road
