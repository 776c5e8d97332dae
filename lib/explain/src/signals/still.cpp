#include "still.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

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

double mean(const std::vector<double>& x, const Run& run) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = run.begin; i < run.end; ++i)
    if (std::isfinite(x[i])) sum += x[i], count += 1.0;
  return sum / count;
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
  std::vector<double> way_m, turned_rad, path_mps, course_rad;
};

Moved moved_of(const Signals& s) {
  Moved out;
  double way = 0, turned = 0, course = 0;
  for (std::size_t i = 0; i < s.n; ++i) {
    if (std::isfinite(s.x[kVx][i])) way += s.x[kVx][i] * Signals::kStep_s;
    if (s.present[kYawRate] && std::isfinite(s.x[kYawRate][i]))
      turned += s.x[kYawRate][i] * Signals::kStep_s;
    out.way_m.push_back(way);
    out.turned_rad.push_back(turned);
    const double path = std::hypot(s.dx[kX][i], s.dx[kY][i]);
    out.path_mps.push_back(path > kMoves_mps ? path : kNaN);
    const double step = std::atan2(s.dx[kY][i], s.dx[kX][i]) - course;
    if (path > kMoves_mps) course += std::remainder(step, 2 * std::numbers::pi);
    out.course_rad.push_back(path > kMoves_mps ? course : kNaN);
  }
  return out;
}

/// Over parts of a second: how far the path turned, and how far the car went.
struct Turned {
  double turned_rad = 0.0, way_m = 0.0;
};

std::vector<Turned> by_seconds(const Moved& moved, const Run& run) {
  std::vector<Turned> out;
  const std::size_t second = steps_of(1.0);
  for (std::size_t i = run.begin; i + second < run.end; i += second) {
    const double turned = moved.course_rad[i + second] - moved.course_rad[i];
    if (std::isfinite(turned)) out.push_back({turned, moved.way_m[i + second] - moved.way_m[i]});
  }
  return out;
}

/// By how much the path turned otherwise than a car that turns by `rate_radps` all along, rad.
double turned_otherwise(const Moved& moved, const Run& run, double rate_radps) {
  double turned = 0.0, seconds = 0.0;
  for (const Turned& part : by_seconds(moved, run)) turned += part.turned_rad, seconds += 1.0;
  return std::abs(turned - rate_radps * seconds);
}

/// How differently the path bends within a run, as a lateral acceleration at its mean speed.
double bends_mps2(const Moved& moved, const Run& run) {
  double least = HUGE_VAL, most = -HUGE_VAL, way = 0.0, seconds = 0.0;
  for (const Turned& part : by_seconds(moved, run)) {
    if (!(part.way_m > kMoves_mps)) continue;
    least = std::min(least, part.turned_rad / part.way_m);
    most = std::max(most, part.turned_rad / part.way_m);
    way += part.way_m, seconds += 1.0;
  }
  return most > least ? (most - least) * (way / seconds) * (way / seconds) : 0.0;
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
  // A device that leaves places out now and then is a usual one; what else stands so often while
  // they go on is broken, and the rest of it may be.
  std::size_t beside = 0;
  for (const Run& run : runs)
    for (std::size_t i = run.begin; i < run.end; ++i) beside += std::isfinite(s.x[kX][i]) ? 1 : 0;
  const bool doubtful = often || (beside * 20 > s.n && channels.front() != kX);
  for (const Channel c : channels) {
    if (often && (c == kX || c == kY || c == kVx))
      throw vehicle::Error(what +
                           "; position and speed are the least the analysis needs: give a "
                           "log in which they go on");
    if (often) s.present[c] = false;
    for (const Run& run : often ? std::vector<Run>{{0, s.n}} : runs)
      for (std::size_t i = run.begin; i < run.end; ++i) s.x[c][i] = s.dx[c][i] = kNaN;
  }
  s.broken = s.broken || doubtful;
  s.remarks.push_back(what + (often ? ": not used" : ": not used there"));
}

constexpr double kClosed = 0.05, kOpen = 0.98;

/// The most by which the speed changes within 5 s, and beyond what a slope of a tenth makes of it,
/// m/s.
struct SpeedChanges {
  double gained = 0.0, lost = 0.0, gained_over_slope = 0.0, lost_over_slope = 0.0;
};

SpeedChanges speed_changes(const Signals& s, std::size_t begin, std::size_t end) {
  constexpr double kSlope_mps2 = 1.0;
  const std::vector<double>& v = s.x[kVx];
  const std::size_t most = steps_of(5.0);
  SpeedChanges out;
  for (std::size_t i = begin; i < end; ++i)
    for (std::size_t k = i + 1; k < std::min(end, i + most); ++k) {
      const double change = v[k] - v[i];
      if (!std::isfinite(change)) continue;
      const double by_slope = kSlope_mps2 * Signals::kStep_s * static_cast<double>(k - i);
      out.gained = std::max(out.gained, change), out.lost = std::max(out.lost, -change);
      out.gained_over_slope = std::max(out.gained_over_slope, change - by_slope);
      out.lost_over_slope = std::max(out.lost_over_slope, -change - by_slope);
    }
  return out;
}

/// How often the throttle stays for a second where it is neither closed nor open.
std::size_t holds_of_throttle(const Signals& s) {
  return still_runs(s, {kThrottle}, 1.0,
                    [&](const Run& run) {
                      const double at = s.x[kThrottle][run.begin];
                      return at > kClosed && at < kOpen;
                    })
      .size();
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

bool moves_against_throttle(const Signals& s, std::size_t begin, std::size_t end) {
  constexpr double kBy_mps = 8.0, kAlone_mps = 1.0;
  const SpeedChanges all = speed_changes(s, begin, end);
  const double at = s.x[kThrottle][begin];
  if ((all.gained > kBy_mps && all.lost > kBy_mps) || (all.lost > kBy_mps && at > 0.3)) return true;
  // What a driver closed acts for half a second more.
  if (at < kClosed)
    return all.gained > kBy_mps ||
           speed_changes(s, begin + steps_of(0.5), end).gained_over_slope > kAlone_mps;
  // A pedal that is held somewhere for so long once, and never else, is none.
  return at < kOpen && holds_of_throttle(s) == 1 &&
         std::min(all.gained_over_slope, all.lost_over_slope) > kAlone_mps;
}

void leave_out_still(Signals& s) {
  const Moved moved = moved_of(s);
  take_out(s, {kX, kY}, still_runs(s, {kX, kY}, 0.5, [&](const Run& run) {
             return range(moved.way_m, run) > 0.3 * kMoves_mps &&
                    range(moved.way_m, run) >
                        kMoves_mps * Signals::kStep_s * static_cast<double>(run.end - run.begin);
           }));
  constexpr double kOtherwise_rad = 0.3;
  const auto turns = [&](const Run& run) {
    return range(moved.turned_rad, run) > 0.1 || turned_otherwise(moved, run, 0.0) > kOtherwise_rad;
  };
  const auto speeds = [&](double most) {
    return [&, most](const Run& run) { return speed_range(s, moved, run) > most; };
  };
  if (s.present[kYaw]) take_out(s, {kYaw}, still_runs(s, {kYaw}, 1.0, turns));
  take_out(s, {kVx}, still_runs(s, {kVx}, 1.0, [&](const Run& run) {
             return range(moved.path_mps, run) > 2.0;
           }));
  if (s.present[kAx]) take_out(s, {kAx}, still_runs(s, {kAx}, 1.0, speeds(3.0)));
  if (s.present[kYawRate])
    take_out(s, {kYawRate}, still_runs(s, {kYawRate}, 1.0, [&](const Run& run) {
               return turned_otherwise(moved, run, s.x[kYawRate][run.begin]) > kOtherwise_rad;
             }));
  if (s.present[kAy])
    take_out(s, {kAy}, still_runs(s, {kAy}, 1.0, [&](const Run& run) {
               const double v = mean(moved.path_mps, run);
               return turned_otherwise(moved, run, s.x[kAy][run.begin] / v) > kOtherwise_rad;
             }));
  if (s.present[kSteer])
    take_out(s, {kSteer}, still_runs(s, {kSteer}, 2.0, [&](const Run& run) {
               return bends_mps2(moved, run) > 6.0;
             }));
  if (s.present[kThrottle])
    take_out(s, {kThrottle}, still_runs(s, {kThrottle}, 5.0, [&](const Run& run) {
               return moves_against_throttle(s, run.begin, run.end);
             }));
}

}  // namespace explain
