#include "plausible.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "not_known.h"

namespace explain {
namespace {

/// The larger half of the steps over which the course of the path is taken: positions jitter by
/// centimetres and decimetres, and the course between two that are close jitters with them.
constexpr std::size_t kChord = 8;

struct Match {
  double correlation = 0.0, slope = 0.0, lag_s = 0.0;
  bool known = false;  ///< enough was going on to say
};

/// How `x` follows `reference`, at the shift within 3 s at which it does so best.
Match match(const std::vector<double>& x, const std::vector<double>& reference,
            double least_swing) {
  Match best;
  constexpr int kMost = 60;
  for (int lag = -kMost; lag <= kMost; ++lag) {
    double n = 0, sx = 0, sr = 0, xx = 0, rr = 0, xr = 0;
    for (std::size_t i = kMost; i + kMost < reference.size(); i += 2) {
      const double r = reference[i],
                   v = x[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + lag)];
      if (!std::isfinite(r) || !std::isfinite(v)) continue;
      n += 1, sx += v, sr += r, xx += v * v, rr += r * r, xr += v * r;
    }
    if (n < 100) continue;
    const double vx = xx / n - sx * sx / n / n, vr = rr / n - sr * sr / n / n,
                 c = xr / n - sx * sr / n / n;
    if (!(vr > least_swing * least_swing) || !(vx > 0)) continue;
    const double correlation = c / std::sqrt(vx * vr);
    // A clock is only doubted for a clear gain over none.
    const double worth = std::abs(correlation) - 0.0002 * std::abs(lag);
    if (!best.known ||
        worth > std::abs(best.correlation) - 0.0002 * std::abs(best.lag_s / Signals::kStep_s))
      best = {correlation, c / vr, lag * Signals::kStep_s, true};
  }
  return best;
}

/// How much of `slip` a lateral speed holds beside whatever a lever arm adds to it by turning.
double share_of_slip(const std::vector<double>& vy, const std::vector<double>& slip,
                     const std::vector<double>& turn) {
  double ss = 0, st = 0, tt = 0, vs = 0, vt = 0;
  for (std::size_t i = 0; i < vy.size(); ++i) {
    if (!std::isfinite(vy[i]) || !std::isfinite(slip[i]) || !std::isfinite(turn[i])) continue;
    ss += slip[i] * slip[i], st += slip[i] * turn[i], tt += turn[i] * turn[i];
    vs += vy[i] * slip[i], vt += vy[i] * turn[i];
  }
  return vs * tt - vt * st;  // over a determinant that is positive
}

/// What a path says that the channels of its log should show.
struct Expected {
  std::vector<double> turn, along, across, curvature, slowing, slip;
};

Expected expected_of(const Signals& s) {
  Expected p;
  for (auto* v : {&p.turn, &p.along, &p.across, &p.curvature, &p.slowing, &p.slip})
    v->assign(s.n, kNaN);
  for (std::size_t i = kChord; i + kChord < s.n; ++i) {
    const double speed = std::hypot(s.dx[kX][i], s.dx[kY][i]);
    if (!(speed > 6)) continue;
    // Between the chords before and behind.
    const double before =
                     std::atan2(s.x[kY][i] - s.x[kY][i - kChord], s.x[kX][i] - s.x[kX][i - kChord]),
                 after =
                     std::atan2(s.x[kY][i + kChord] - s.x[kY][i], s.x[kX][i + kChord] - s.x[kX][i]);
    p.turn[i] = std::remainder(after - before, 2 * std::numbers::pi) /
                (static_cast<double>(kChord) * Signals::kStep_s);
    p.along[i] = s.dx[kVx][i];
    p.slowing[i] = -p.along[i];
    p.across[i] = p.turn[i] * speed;
    p.curvature[i] = 3.0 * p.turn[i] / speed;  // of a car with a wheelbase of 3 m
    if (s.present[kYaw])
      p.slip[i] =
          s.x[kVx][i] * std::sin(std::remainder(std::atan2(s.dx[kY][i], s.dx[kX][i]) - s.x[kYaw][i],
                                                2 * std::numbers::pi));
  }
  return p;
}

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

/// What the path says of a channel: its values there, how far they swing at least before it says
/// anything, and the slopes and the correlation that are the channel's own.
struct Reference {
  const std::vector<double>& values;
  double swing;
  const char* what;
  double low, high, least;
};

struct Channels {
  Signals& s;
  bool forces = true;  ///< none of what moves the car was left out

  void leave_out(Channel c, const std::string& why) {
    for (const Channel force : {kYawRate, kVy, kSteer, kThrottle, kBrakeFront, kBrakeRear})
      forces = forces && c != force;
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
    if (m.slope < path.low || m.slope > path.high) return leave_out(c, unit_of(m.slope));
  }
};

/// Swapped axes first: each then follows the other's reference.
void check_swapped(Channels& channels, const Expected& path) {
  Signals& s = channels.s;
  if (s.present[kAx] && s.present[kAy]) {
    const Match xx = match(s.x[kAx], path.along, 0.5), xy = match(s.x[kAx], path.across, 0.5),
                yx = match(s.x[kAy], path.along, 0.5);
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
    const Match t = match(s.x[kThrottle], path.along, 0.3),
                b = match(s.x[kBrakeFront], path.slowing, 0.3);
    if (t.known && b.known && t.correlation < -0.4 && b.correlation < -0.2) {
      channels.leave_out(kThrottle,
                         fmt::format("slows the car down, and '{}' speeds it up: they are swapped",
                                     s.column[kBrakeFront]));
      channels.leave_out(kBrakeFront, "is swapped with the throttle");
      s.present[kBrakeRear] = false;
    }
  }
}

void check_yaw(Channels& channels, const Expected& path) {
  Signals& s = channels.s;
  if (!s.present[kYaw]) return;
  channels.check(kYaw, s.dx[kYaw], {path.turn, 0.02, "the turning", 0.67, 1.5, 0.7});
  double sum_c = 0, sum_s = 0;
  for (std::size_t i = 0; i < s.n; ++i)
    if (std::isfinite(path.turn[i]) && s.present[kYaw] && std::isfinite(s.x[kYaw][i])) {
      const double d = std::atan2(s.dx[kY][i], s.dx[kX][i]) - s.x[kYaw][i];
      sum_c += std::cos(d), sum_s += std::sin(d);
    }
  const double offset = std::atan2(sum_s, sum_c);
  if (s.present[kYaw] && std::abs(offset) > 0.26)
    channels.leave_out(
        kYaw, fmt::format("has another zero: {:.3f} rad from the course on average", offset));
}

void check_motion(Channels& channels, const Expected& path) {
  Signals& s = channels.s;
  channels.check(kYawRate, s.x[kYawRate], {path.turn, 0.02, "the turning", 0.67, 1.5, 0.7});
  check_yaw(channels, path);
  const Match flattened = match(s.x[kAx], path.along, 0.5);
  // The flattening of a slow filter is no unit either; only a sign or a g is.
  if (flattened.correlation < 0 || std::abs(flattened.correlation) > 0.9)
    channels.check(kAx, s.x[kAx], {path.along, 0.5, "the acceleration along", 0.5, 1.6, 0.3});
  channels.check(kAy, s.x[kAy], {path.across, 0.5, "the acceleration across", 0.67, 1.5, 0.7});
  if (s.present[kVy] && s.present[kYaw]) {
    const Match m = match(s.x[kVy], path.slip, 0.1);
    // Far ahead of the centre of mass turning outweighs the slip; that is a place, no sign.
    if (m.known && m.correlation < -0.3 && share_of_slip(s.x[kVy], path.slip, path.turn) < 0)
      channels.leave_out(kVy, "has the other sign than the path against the heading");
  }
}

void check_controls(Channels& channels, const Expected& path) {
  Signals& s = channels.s;
  if (!s.commanded[kSteer])
    channels.check(kSteer, s.x[kSteer], {path.curvature, 0.005, "the curvature", 0.2, 5.0, 0.5});
  if (s.present[kThrottle] && largest(s.x[kThrottle]) > 1.5)
    channels.leave_out(
        kThrottle,
        fmt::format("reaches {:.3g}: {} where a share from 0 to 1 is wanted",
                    largest(s.x[kThrottle]),
                    largest(s.x[kThrottle]) < 150 ? "per cent" : "another unit or channel"));
  for (const Channel c : {kBrakeFront, kBrakeRear})
    if (s.present[c] && largest(s.x[c]) < 2000)
      channels.leave_out(c,
                         fmt::format("reaches {:.3g}: bar or another unit where pascal are wanted",
                                     largest(s.x[c])));
}

void check_wheels(Channels& channels, const Expected& path) {
  Signals& s = channels.s;
  for (const Channel c : {kWheelFront, kWheelRear}) {
    if (!s.present[c]) continue;
    double vv = 0, vw = 0;
    for (std::size_t i = 0; i < s.n; ++i)
      if (std::isfinite(s.x[c][i]) && std::isfinite(path.along[i]))
        vv += s.x[kVx][i] * s.x[kVx][i], vw += s.x[kVx][i] * s.x[c][i];
    // A wheel of 0.2 to 0.5 m, or metres per second.
    const double ratio = vv > 0 ? vw / vv : 0.0;
    if (s.wheels_in_mps ? ratio < 0.7 || ratio > 1.4 : ratio < 2.0 || ratio > 5.0)
      channels.leave_out(
          c, fmt::format("is {:.3g} times the speed: another unit, or no wheel speed", ratio));
  }
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
  const Expected path = expected_of(s);
  Channels channels{s};
  check_swapped(channels, path);
  check_motion(channels, path);
  check_controls(channels, path);
  check_wheels(channels, path);
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
