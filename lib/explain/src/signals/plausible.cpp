#include "plausible.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "changes_in_time.h"
#include "not_known.h"
#include "path_says.h"
#include "vehicle/error.h"

namespace explain {
namespace {

std::string unit_of(double slope) {
  const double k = std::abs(slope);
  if (k > 40 && k < 80) return "looks like degrees where radians are wanted";
  if (k > 0.07 && k < 0.14) return "looks like multiples of g where m/s2 are wanted";
  return fmt::format("is {:.3g} times what the path asks for", k);
}

double largest(const std::vector<double>& values) {
  double most = 0;
  for (const double v : values)
    if (std::isfinite(v)) most = std::max(most, std::abs(v));
  return most;
}

/// Without the 2 % that are larger, such as overshoots.
double usually_largest(std::vector<double> x) {
  std::erase_if(x, [](double v) { return !std::isfinite(v); });
  if (x.empty()) return 0.0;
  const auto at = x.begin() + static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(x.size()));
  std::nth_element(x.begin(), at, x.end());
  return *at;
}

/// What the path says of a channel: its values there, how far they swing at least before it says
/// anything, and the slopes and the correlation that are the channel's own.
struct Reference {
  const std::vector<double>& values;
  double swing;
  const char* what;
  double low, high, least;
};

/// On a road that leans by 20 degrees an accelerometer shows 0.7 of what it does beside it.
constexpr double kChange = 1.6;

std::string changed(const Change& change, const char* what) {
  return fmt::format(
      "is {:.2f} times what {} of the path asks for until about {:.0f} s, and {:.2f} times after "
      "it",
      change.before, what, change.time_s, change.after);
}

struct Channels {
  Signals& s;
  bool forces = true;  ///< none of what moves the car was left out

  void leave_out(Channel c, const std::string& why) {
    for (const Channel force : {kYawRate, kVy, kSteer, kThrottle, kBrakeFront, kBrakeRear})
      forces = forces && c != force;
    s.broken = true;
    s.remarks.push_back(
        fmt::format("{}: '{}' {}: not used; correct it in the mapping", s.name, s.column[c], why));
    s.present[c] = false;
    std::fill(s.x[c].begin(), s.x[c].end(), kNaN);
    std::fill(s.dx[c].begin(), s.dx[c].end(), kNaN);
  }

  void check(Channel c, const std::vector<double>& values, const Reference& path) {
    if (!s.present[c]) return;
    const Match m = match(values, path.values, path.swing);
    if (!m.known) return;
    if (std::abs(m.correlation) < path.least)
      return leave_out(c, fmt::format("does not follow {} of the path (correlation {:.2f})",
                                      path.what, m.correlation));
    // A slow filter is late too, but it also flattens: that is a finding, no wrong clock.
    if (std::abs(m.lag_s) > 0.5 && std::abs(m.correlation) > 0.9 && m.slope > 0.75 &&
        m.slope < 1.33)
      return leave_out(c, fmt::format("runs on another clock: {:.2f} s {}", std::abs(m.lag_s),
                                      m.lag_s > 0 ? "late" : "early"));
    if (m.slope < 0)
      return leave_out(c, fmt::format("has the other sign than {} of the path", path.what));
    if (const auto change = slope_changes(values, path.values, path.swing, m.lag_s, kChange))
      return leave_out(c, changed(*change, path.what));
    if (m.slope < path.low || m.slope > path.high) return leave_out(c, unit_of(m.slope));
  }
};

/// Swapped axes first: each then follows the other's reference.
void check_swapped(Channels& channels, const PathSays& path) {
  Signals& s = channels.s;
  if (s.present[kAx] && s.present[kAy]) {
    const Match xx = match(s.x[kAx], path.along_mps2, 0.5),
                xy = match(s.x[kAx], path.across_mps2, 0.5),
                yx = match(s.x[kAy], path.along_mps2, 0.5);
    if (xx.known && xy.known && std::abs(xx.correlation) < 0.5 && std::abs(xy.correlation) > 0.8 &&
        std::abs(yx.correlation) > 0.8) {
      channels.leave_out(
          kAx,
          fmt::format(
              "follows the lateral acceleration, and '{}' the one along the path: they are swapped",
              s.column[kAy]));
      channels.leave_out(kAy, "is swapped with it");
    }
  }
  if (s.present[kThrottle] && s.present[kBrakeFront]) {
    const Match t = match(s.x[kThrottle], path.along_mps2, 0.3),
                b = match(s.x[kBrakeFront], path.slowing_mps2, 0.3);
    if (t.known && b.known && t.correlation < -0.4 && b.correlation < -0.2) {
      channels.leave_out(kThrottle,
                         fmt::format("slows the car down, and '{}' speeds it up: they are swapped",
                                     s.column[kBrakeFront]));
      channels.leave_out(kBrakeFront, "is swapped with the throttle");
      s.present[kBrakeRear] = false;
    } else if (t.known && t.correlation < -0.4) {
      channels.leave_out(kThrottle,
                         "is largest where the car slows down: 1 is closed there; give it scale -1 "
                         "and offset 1");
    }
  }
}

/// Of the course, less or plus the heading: where it lies on average and how much of it does.
std::complex<double> course_beside_heading(const Signals& s, const PathSays& path, double sign) {
  std::complex<double> sum = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < s.n; ++i)
    if (std::isfinite(path.turn_radps[i]) && std::isfinite(s.x[kYaw][i])) {
      sum += std::polar(1.0, std::atan2(s.dx[kY][i], s.dx[kX][i]) - sign * s.x[kYaw][i]);
      count += 1.0;
    }
  return count > 0 ? sum / count : sum;
}

void check_yaw(Channels& channels, const PathSays& path) {
  Signals& s = channels.s;
  if (!s.present[kYaw]) return;
  const std::complex<double> compass = course_beside_heading(s, path, -1.0),
                             heading = course_beside_heading(s, path, 1.0);
  constexpr double kAlike = 0.9, kNear = 0.26, kRight = std::numbers::pi / 2;
  const double offset = std::arg(heading);
  // To the north-east both are alike.
  const bool right = std::abs(heading) > kAlike && std::abs(offset) < kNear;
  if (!right && std::abs(compass) > kAlike && std::abs(std::arg(compass) - kRight) < kNear)
    channels.leave_out(kYaw,
                       "counts clockwise from north, where counter-clockwise from the x axis "
                       "is wanted: give it scale -1 and offset 1.5708");
  channels.check(kYaw, s.dx[kYaw], {path.turn_radps, 0.02, "the turning", 0.67, 1.5, 0.7});
  if (s.present[kYaw] && std::abs(offset) > kNear)
    channels.leave_out(
        kYaw, fmt::format("has another zero: {:.3f} rad from the course on average", offset));
}

/// Heading comes back to what it was: what a gyro's zero moves by shows against it.
void check_drift(Channels& channels) {
  Signals& s = channels.s;
  if (!s.present[kYawRate] || !s.present[kYaw]) return;
  constexpr double kCounts_radps = 0.003;
  const auto drift = drifts(s.x[kYawRate], s.dx[kYaw]);
  if (drift && std::abs(drift->after - drift->before) > kCounts_radps)
    channels.leave_out(kYawRate, fmt::format("has a zero that drifts from {:.4f} to {:.4f} rad/s "
                                             "against the heading",
                                             drift->before, drift->after));
}

/// Behind a filter of the first order.
std::vector<double> behind_filter(const std::vector<double>& x, double time_s) {
  std::vector<double> out(x.size(), kNaN);
  const double share = 1 - std::exp(-Signals::kStep_s / time_s);
  for (std::size_t i = 0; i < x.size(); ++i)
    out[i] = i > 0 && std::isfinite(out[i - 1]) ? out[i - 1] + share * (x[i] - out[i - 1]) : x[i];
  return out;
}

/// A slow filter makes an acceleration late and flat, which is no other clock and no other unit.
bool is_slowly_filtered(const std::vector<double>& ax, const std::vector<double>& along_mps2,
                        const Match& unfiltered) {
  constexpr double kSwing_mps2 = 0.03, kLate_s = 0.05, kLate = 0.15, kLow = 0.85, kHigh = 1.2;
  for (double time_s = 0.2; time_s < 5.0; time_s *= 1.2) {
    const Match m = match(ax, behind_filter(along_mps2, time_s), kSwing_mps2);
    if (m.known && std::abs(m.lag_s) <= kLate_s + kLate * time_s && m.slope > kLow &&
        m.slope < kHigh && m.correlation > unfiltered.correlation)
      return true;
  }
  return false;
}

void check_motion(Channels& channels, const PathSays& path) {
  Signals& s = channels.s;
  constexpr double kGyroChanges = 1.2, kTurns_radps = 0.02;
  channels.check(kYawRate, s.x[kYawRate],
                 {path.turn_radps, kTurns_radps, "the turning", 0.67, 1.5, 0.7});
  // By what it turns in all: within a window a road that begins to lean is steeper than its cosine.
  std::vector<double> turns_radps = path.turn_radps;
  for (double& t : turns_radps)
    if (std::abs(t) < kTurns_radps) t = kNaN;
  if (const auto change = ratio_changes(s.x[kYawRate], turns_radps, kGyroChanges);
      change && s.present[kYawRate])
    channels.leave_out(kYawRate, changed(*change, "the turning"));
  check_yaw(channels, path);
  check_drift(channels);
  const Match flattened = match(s.x[kAx], path.along_mps2, 0.5);
  constexpr double kFollows = 0.3, kIsTheSame = 0.9;
  if ((flattened.correlation < kFollows || flattened.correlation > kIsTheSame) &&
      !is_slowly_filtered(s.x[kAx], path.along_mps2, flattened))
    channels.check(kAx, s.x[kAx],
                   {path.along_mps2, 0.5, "the acceleration along", 0.5, 1.6, kFollows});
  channels.check(kAy, s.x[kAy], {path.across_mps2, 0.5, "the acceleration across", 0.67, 1.5, 0.7});
  if (const std::string why = wrong_with_slip(s, path); !why.empty()) channels.leave_out(kVy, why);
}

/// Pressures that slow a car down are millions of pascals: the largest is below 2 kPa, or below 40
/// where the car slows with it. Some kPa alone may be all that one shows that never braked.
bool is_other_pressure(const std::vector<double>& pressure, const std::vector<double>& slowing) {
  const double most = largest(pressure);
  if (most < 2e3 || most > 4e4) return most < 2e3;
  const Match m = match(pressure, slowing, 0.5);
  return m.known && m.correlation > 0.5;
}

/// A pedal that is pressed as far as it goes reads 1: it stays there often, at less than that where
/// the column is scaled. A pedal that moves with the need for it is as often a little below.
bool is_other_share(const std::vector<double>& throttle) {
  constexpr double kOpen = 0.9, kBand = 0.03, kLeast_s = 10.0, kOftener = 4.0;
  constexpr int kTimes = 5;
  const double most = usually_largest(throttle);
  double there_s = 0.0, below_s = 0.0;
  int times = 0;
  bool before = false;
  for (const double x : throttle) {
    if (!std::isfinite(x)) continue;
    const bool there = std::abs(x - most) < kBand * most;
    times += there && !before ? 1 : 0;
    there_s += there ? Signals::kStep_s : 0.0;
    below_s += std::abs(x - (1 - 2 * kBand) * most) <= kBand * most ? Signals::kStep_s : 0.0;
    before = there;
  }
  return most > 0.05 && most < kOpen && times >= kTimes &&
         there_s > std::max(kLeast_s, kOftener * below_s);
}

void check_controls(Channels& channels, const PathSays& path) {
  Signals& s = channels.s;
  if (!s.commanded[kSteer])
    channels.check(kSteer, s.x[kSteer], {path.curvature, 0.005, "the curvature", 0.2, 5.0, 0.5});
  if (s.present[kThrottle] && largest(s.x[kThrottle]) > 1.5)
    channels.leave_out(
        kThrottle,
        fmt::format("reaches {:.3g}: {} where a share from 0 to 1 is wanted",
                    largest(s.x[kThrottle]),
                    largest(s.x[kThrottle]) < 150 ? "per cent" : "another unit or channel"));
  constexpr double kAfter_s = 0.35, kMoves = 0.7, kBetter = 0.15;
  if (const Match m = match(s.x[kThrottle], path.along_mps2, 0.3);
      s.present[kThrottle] && m.known && m.correlation > kMoves && m.lag_s > kAfter_s &&
      m.correlation > m.at_once + kBetter)
    channels.leave_out(kThrottle,
                       fmt::format("is pressed {:.2f} s after the car speeds up: it runs "
                                   "on another clock",
                                   m.lag_s));
  if (s.present[kThrottle] && !s.commanded[kThrottle] && is_other_share(s.x[kThrottle]))
    channels.leave_out(
        kThrottle,
        fmt::format("goes to {:.2f} and stays there time and again: a pedal that is pressed as far "
                    "as it goes is 1; give it scale {:.3g}, or take it out if it is held back",
                    usually_largest(s.x[kThrottle]), 1 / usually_largest(s.x[kThrottle])));
  for (const Channel c : {kBrakeFront, kBrakeRear})
    if (s.present[c] && is_other_pressure(s.x[c], path.slowing_mps2))
      channels.leave_out(c,
                         fmt::format("reaches {:.3g}: bar or another unit where pascal are wanted",
                                     largest(s.x[c])));
}

void check_wheels(Channels& channels, const PathSays& path) {
  Signals& s = channels.s;
  for (const Channel c : {kWheelFront, kWheelRear}) {
    if (!s.present[c]) continue;
    double vv = 0, vw = 0;
    for (std::size_t i = 0; i < s.n; ++i)
      if (std::isfinite(s.x[c][i]) && std::isfinite(path.along_mps2[i]))
        vv += s.x[kVx][i] * s.x[kVx][i], vw += s.x[kVx][i] * s.x[c][i];
    // A wheel of 0.2 to 0.5 m, or metres per second.
    const double ratio = vv > 0 ? vw / vv : 0.0;
    if (s.wheels_in_mps ? ratio < 0.7 || ratio > 1.4 : ratio < 2.0 || ratio > 5.0)
      channels.leave_out(
          c, fmt::format("is {:.3g} times the speed: another unit, or no wheel speed", ratio));
  }
}

/// What a column lacks while the car is on the road: one that lacks most of it says little of the
/// drive, and what is judged without it is not what the log shows.
void check_missing(Channels& channels) {
  Signals& s = channels.s;
  for (std::size_t c = 0; c < kChannelCount; ++c) {
    if (!s.present[c] || c == kX || c == kY) continue;
    std::size_t missing = 0, first = s.n, driven = 0;
    for (std::size_t i = 0; i < s.n; ++i) {
      if (!std::isfinite(s.x[kX][i])) continue;
      ++driven;
      if (!std::isfinite(s.x[c][i])) ++missing, first = std::min(first, i);
    }
    const std::string what = fmt::format("has nothing for {:.1f} of {:.1f} s on the road",
                                         static_cast<double>(missing) * Signals::kStep_s,
                                         static_cast<double>(driven) * Signals::kStep_s);
    if (2 * missing > driven && c == kVx)
      throw vehicle::Error(
          fmt::format("{}: '{}' {}; position and speed are the least the analysis needs", s.name,
                      s.column[c], what));
    if (2 * missing > driven && c != kEngine && c != kGear && c != kFuel)
      channels.leave_out(static_cast<Channel>(c), what);
    else if (static_cast<double>(missing) * Signals::kStep_s > 2.0)
      s.remarks.push_back(
          fmt::format("{}: '{}' has nothing for {:.1f} s in all, first at {:.1f} s: "
                      "what needs it is not looked at there",
                      s.name, s.column[c], static_cast<double>(missing) * Signals::kStep_s,
                      static_cast<double>(first) * Signals::kStep_s));
  }
}

/// Speed against path and gyro against heading are off alike where the clock itself is.
void refuse_another_clock(const Signals& s, const PathSays& path) {
  if (!s.present[kYawRate]) return;
  std::vector<double> on_the_map = s.x[kYawRate];  // of a body that leans with the road
  for (std::size_t i = 0; i < s.n; ++i)
    on_the_map[i] *= std::hypot(1.0, s.bank[i]) * std::hypot(1.0, s.grade[i]);
  double vv = 0, vp = 0;
  for (std::size_t i = 0; i < s.n; ++i) {
    const double along = std::hypot(s.dx[kX][i], s.dx[kY][i]), v = s.x[kVx][i];
    if (std::isfinite(path.turn_radps[i]) && std::isfinite(v)) vv += v * v, vp += v * along;
  }
  const double speed = vv > 0 ? vp / vv : 1.0;
  // A heading that is too rough for that leaves the path, whose turning is known less well.
  const Match heading = s.present[kYaw] ? match(s.dx[kYaw], on_the_map, 0.02) : Match{},
              gyro = match(between_chords(on_the_map), path.turn_radps, 0.02);
  const bool by_heading = heading.known && heading.correlation > 0.992;
  if (!by_heading && !(gyro.known && gyro.correlation > 0.99)) return;
  const double turn = by_heading ? heading.slope : 1 / gyro.slope;
  // Radii are a per cent off as often as gyros are.
  const double least = wheels_of_speed(s) ? 0.015 : by_heading ? 0.007 : 0.012;
  if (std::abs(speed - 1) > least && std::abs(turn / speed - 1) < (by_heading ? 0.004 : 0.006))
    throw vehicle::Error(fmt::format(
        "{}: the path is {:.3f} times as fast as '{}', and the {} turns {:.3f} times as fast as "
        "'{}': the clock runs {} by {:.1f} %; give time_s the scale {:.4f} in the mapping",
        s.name, speed, s.column[kVx], by_heading ? "heading" : "path", turn, s.column[kYawRate],
        speed < 1 ? "fast" : "slow", 100 * std::abs(1 / speed - 1), speed));
}

void remark_laps_and_gaps(Signals& s) {
  if (s.closed && s.rounds < kTwoRounds)
    s.remarks.push_back(
        fmt::format("{}: {:.1f} laps: what comes back every lap cannot be told from what happens "
                    "once, so that the road is not tested",
                    s.name, s.rounds));
  double gap = 0, longest = 0;
  for (std::size_t i = 0; i < s.n; ++i) {
    gap = std::isfinite(s.x[kX][i]) ? 0.0 : gap + Signals::kStep_s;
    longest = std::max(longest, gap);
  }
  if (longest > 0.5)
    s.remarks.push_back(
        fmt::format("{}: a gap of {:.1f} s: nothing is interpolated over it", s.name, longest));
}

}  // namespace

void leave_out_implausible(Signals& s) {
  const PathSays path = path_says(s);
  refuse_another_clock(s, path);
  Channels channels{s};
  check_swapped(channels, path);
  check_motion(channels, path);
  check_controls(channels, path);
  check_wheels(channels, path);
  check_missing(channels);
  if (!channels.forces) {
    // What moves the car would be explained without one of its causes.
    s.remarks.push_back(
        s.name + ": forces are not compared until that is mended; sensors and kinematics are");
    for (const Channel c : {kSteer, kThrottle, kBrakeFront, kBrakeRear}) s.present[c] = false;
  }
  if (!s.present[kWheelRear]) s.present[kWheelRearDifference] = false;
  if (!s.present[kBrakeFront]) s.present[kBrakeFrontApart] = false;
  if (!s.present[kBrakeRear]) s.present[kBrakeRearApart] = false;
  remark_laps_and_gaps(s);
}

}  // namespace explain
