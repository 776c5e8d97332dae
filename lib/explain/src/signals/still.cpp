#include "still.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "not_known.h"
#include "signal_samples.h"
#include "vehicle/error.h"

namespace explain {
namespace {

constexpr double kMoves_mps = 6.0;

struct Run {
  std::size_t begin = 0, end = 0;
};

std::size_t steps_of(double time_s) { return static_cast<std::size_t>(time_s / Signals::kStep_s); }

/// How far `x` goes up and down within a run.
double range(const std::vector<double>& x, const Run& run) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (std::size_t i = run.begin; i < run.end; ++i)
    if (std::isfinite(x[i])) low = std::min(low, x[i]), high = std::max(high, x[i]);
  return high > low ? high - low : 0.0;
}

/// Runs of at least `least_s` in which no `still` channel changes by more than rounding although
/// `moved` says that it should have. What is smoothed stands still for less long than what it was
/// made of: so much is added to both ends.
std::vector<Run> still_runs(const Signals& s, const std::vector<Channel>& still, double least_s,
                            const std::function<bool(const Run&)>& moved) {
  constexpr double kEdge_s = 0.25;
  std::vector<Run> out;
  const auto stands = [&](std::size_t i) {
    return std::all_of(still.begin(), still.end(), [&](Channel c) {
      return std::abs(s.dx[c][i]) <= 1e-9 * (1 + std::abs(s.x[c][i]));
    });
  };
  for (std::size_t i = 0; i < s.n; ++i) {
    if (!stands(i)) continue;
    Run run{i, i};
    while (run.end < s.n && stands(run.end)) ++run.end;
    i = run.end;
    const std::size_t edge = steps_of(kEdge_s);
    if (run.end - run.begin < steps_of(least_s) || !moved(run)) continue;
    out.push_back({run.begin - std::min(edge, run.begin), std::min(s.n, run.end + edge)});
  }
  return out;
}

/// What turns and what speeds a car up, per step, by whatever is logged beside the channel.
struct Moved {
  std::vector<double> way_m, turned_rad, path_mps;
};

Moved moved_of(const Signals& s) {
  Moved out;
  double way = 0, turned = 0;
  for (std::size_t i = 0; i < s.n; ++i) {
    if (std::isfinite(s.x[kVx][i])) way += s.x[kVx][i] * Signals::kStep_s;
    if (s.present[kYawRate] && std::isfinite(s.x[kYawRate][i]))
      turned += s.x[kYawRate][i] * Signals::kStep_s;
    out.way_m.push_back(way);
    out.turned_rad.push_back(turned);
    const double path = std::hypot(s.dx[kX][i], s.dx[kY][i]);
    out.path_mps.push_back(path > kMoves_mps ? path : kNaN);
  }
  return out;
}

/// Where speed is far from steady: by the path and by the speed itself.
double speed_range(const Signals& s, const Moved& moved, const Run& run) {
  return std::max(range(moved.path_mps, run), range(s.x[kVx], run));
}

/// Names the channels in the remark.
std::string quoted(const Signals& s, const std::vector<Channel>& channels) {
  std::string names;
  for (const Channel c : channels) names += (names.empty() ? "'" : ", '") + s.column[c] + "'";
  return names;
}

void take_out(Signals& s, const std::vector<Channel>& channels, const std::vector<Run>& runs) {
  if (runs.empty()) return;
  std::size_t steps = 0;
  for (const Run& run : runs) steps += run.end - run.begin;
  const std::string what = fmt::format(
      "{}: {} {} still {} time{} while the car moves, {:.1f} s in all, first at {:.1f} s", s.name,
      quoted(s, channels), channels.size() > 1 ? "stand" : "stands", runs.size(),
      runs.size() > 1 ? "s" : "", static_cast<double>(steps) * Signals::kStep_s,
      static_cast<double>(runs.front().begin) * Signals::kStep_s);
  const bool often = steps * 5 > s.n;
  for (const Channel c : channels) {
    if (often && (c == kX || c == kY || c == kVx))
      throw vehicle::Error(what +
                           "; position and speed are the least the analysis needs: give a "
                           "log in which they go on");
    if (often) s.present[c] = false;
    for (const Run& run : often ? std::vector<Run>{{0, s.n}} : runs)
      for (std::size_t i = run.begin; i < run.end; ++i) s.x[c][i] = s.dx[c][i] = kNaN;
  }
  s.broken = s.broken || often;
  s.remarks.push_back(what + (often ? ": not used" : ": not used there"));
}

}  // namespace

void leave_out_leaps(Signals& s) {
  std::vector<double> bends(s.n), usual;
  for (std::size_t i = 0; i < s.n; ++i) {
    bends[i] = std::hypot(rate_at(s.dx[kX], i), rate_at(s.dx[kY], i));
    if (std::isfinite(bends[i])) usual.push_back(bends[i]);
  }
  if (usual.empty()) return;
  const auto most = usual.begin() + static_cast<std::ptrdiff_t>(usual.size() * 9 / 10);
  std::nth_element(usual.begin(), most, usual.end());
  const double leap_mps2 = std::max(100.0, 8 * *most);  // positions jitter
  const std::size_t edge = steps_of(0.3);
  std::vector<bool> leaps(s.n, false);
  std::size_t count = 0, first = s.n;
  for (std::size_t i = 0; i < s.n; ++i) {
    const double path = std::hypot(s.dx[kX][i], s.dx[kY][i]), speed = s.x[kVx][i];
    if (!(std::abs(path - speed) > 5 + 0.2 * std::abs(speed)) && !(bends[i] > leap_mps2)) continue;
    first = std::min(first, i);
    for (std::size_t k = i - std::min(i, edge); k < std::min(s.n, i + edge + 1); ++k)
      count += leaps[k] ? 0 : 1, leaps[k] = true;
  }
  if (count == 0 || count * 20 > s.n) return;
  for (std::size_t i = 0; i < s.n; ++i)
    if (leaps[i])
      for (const Channel c : {kX, kY}) s.x[c][i] = s.dx[c][i] = kNaN;
  s.remarks.push_back(
      fmt::format("{}: {} leap against the speed, {:.1f} s in all, first at {:.1f} s: "
                  "not used there",
                  s.name, quoted(s, {kX, kY}), static_cast<double>(count) * Signals::kStep_s,
                  static_cast<double>(first) * Signals::kStep_s));
}

void leave_out_still(Signals& s) {
  const Moved moved = moved_of(s);
  take_out(s, {kX, kY}, still_runs(s, {kX, kY}, 0.5, [&](const Run& run) {
             return range(moved.way_m, run) > 0.3 * kMoves_mps &&
                    range(moved.way_m, run) >
                        kMoves_mps * Signals::kStep_s * static_cast<double>(run.end - run.begin);
           }));
  const auto turns = [&](const Run& run) { return range(moved.turned_rad, run) > 0.1; };
  const auto speeds = [&](double most) {
    return [&, most](const Run& run) { return speed_range(s, moved, run) > most; };
  };
  if (s.present[kYaw]) take_out(s, {kYaw}, still_runs(s, {kYaw}, 1.0, turns));
  take_out(s, {kVx}, still_runs(s, {kVx}, 1.0, [&](const Run& run) {
             return range(moved.path_mps, run) > 2.0;
           }));
  if (s.present[kAx]) take_out(s, {kAx}, still_runs(s, {kAx}, 1.0, speeds(3.0)));
  // Full throttle for seconds is usual, and so is none; half is not while the car also slows down.
  if (s.present[kThrottle])
    take_out(s, {kThrottle}, still_runs(s, {kThrottle}, 5.0, [&](const Run& run) {
               const double at = s.x[kThrottle][run.begin];
               for (std::size_t i = run.begin; i < run.end; ++i)
                 if (!(s.x[kVx][i] > kMoves_mps)) return false;
               return at > 0.05 && at < 0.95 && speed_range(s, moved, run) > 8.0;
             }));
}

}  // namespace explain
