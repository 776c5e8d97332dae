#include "sides.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/statistics.h"
#include "not_known.h"
#include "path_says.h"
#include "vehicle/error.h"

namespace explain {
namespace {

constexpr double kRolls_mps = 8.0, kPushes_mps2 = 0.5;

/// How the difference follows a cause, without shift.
struct Follows {
  double slope = 0.0, correlation = 0.0;
};

Follows follows(const std::vector<double>& x, const std::vector<double>& cause) {
  double n = 0, sx = 0, sc = 0, xx = 0, cc = 0, xc = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(cause[i])) continue;
    n += 1, sx += x[i], sc += cause[i], xx += x[i] * x[i], cc += cause[i] * cause[i],
        xc += x[i] * cause[i];
  }
  if (n < 200) return {};
  const double vx = xx / n - sx * sx / n / n, vc = cc / n - sc * sc / n / n,
               c = xc / n - sx * sc / n / n;
  return vx > 0 && vc > 0 ? Follows{c / vc, c / std::sqrt(vx * vc)} : Follows{};
}

/// How far a share is from none, root mean square.
double apart_from_speed(const std::vector<double>& share) {
  double n = 0, square = 0;
  for (const double x : share)
    if (std::isfinite(x)) n += 1, square += x * x;
  return std::sqrt(square / std::max(n, 1.0));
}

std::vector<double> right_less_left(const std::pair<std::vector<double>, std::vector<double>>& both,
                                    double factor) {
  std::vector<double> out(both.first.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = factor * (both.second[i] - both.first[i]);
  return out;
}

struct Range {
  double low = HUGE_VAL, high = -HUGE_VAL;
  void add(double x) {
    if (std::isfinite(x)) low = std::min(low, x), high = std::max(high, x);
  }
  double size() const { return std::max(0.0, high - low); }
};

/// When a column begins to stand for ten seconds or more, in which that of the other side takes
/// more than half of its range, s.
std::optional<double> stands_beside(const std::vector<double>& x,
                                    const std::vector<double>& other) {
  constexpr auto kLong = static_cast<std::size_t>(10.0 / Signals::kStep_s);
  constexpr double kGoesOn = 0.5;
  Range all;
  for (const double v : other) all.add(v);
  for (std::size_t i = 0; i < x.size(); ++i) {
    Range beside;
    std::size_t end = i;
    for (; end < x.size() && std::abs(x[end] - x[i]) <= 1e-9 * (1 + std::abs(x[i])); ++end)
      beside.add(other[end]);
    if (end >= i + kLong && beside.size() > kGoesOn * all.size())
      return static_cast<double>(i) * Signals::kStep_s;
    i = std::max(i, end == 0 ? 0 : end - 1);
  }
  return std::nullopt;
}

struct Axles {
  Signals& s;
  const std::vector<double>& turn_radps;
  std::string front(const std::string& both) const { return both.substr(0, both.find(',')); }
  std::string second(const std::string& both) const { return both.substr(both.find(',') + 1); }

  void leave_out(Channel c, const std::string& why) const {
    s.remarks.push_back(fmt::format("{}: {}: not used; correct it in the mapping", s.name, why));
    s.broken = true;
    s.present[c] = false;
    std::fill(s.x[c].begin(), s.x[c].end(), kNaN);
    std::fill(s.dx[c].begin(), s.dx[c].end(), kNaN);
    if (c == kWheelRear) s.present[kWheelRearDifference] = false;
    if (c == kBrakeFront || c == kBrakeRear)
      for (const Channel of_brakes : {kBrakeFront, kBrakeRear, kBrakeFrontApart, kBrakeRearApart})
        s.present[of_brakes] = false;
  }

  /// Which of two wheels does not roll as fast as the car, where they differ by a quarter.
  bool one_wheel_apart(Channel c, const std::pair<std::vector<double>, std::vector<double>>& both,
                       double factor) const {
    double moving = 0, apart = 0, off_left = 0, off_right = 0, since_s = kNaN;
    for (std::size_t i = 0; i < s.n; ++i) {
      const double v = s.x[kVx][i], left = factor * both.first[i], right = factor * both.second[i];
      if (!(v > kRolls_mps) || !std::isfinite(left + right)) continue;
      moving += 1;
      if (std::abs(left - right) < 0.25 * v) continue;
      if (apart == 0) since_s = static_cast<double>(i) * Signals::kStep_s;
      apart += 1, off_left += std::abs(left - v), off_right += std::abs(right - v);
    }
    if (apart < 0.05 * moving || moving < 200) return false;
    const bool left = off_left > off_right;
    leave_out(c, fmt::format("'{}' differs from '{}' and from the speed by over a quarter for "
                             "{:.0f} % of the drive, first at {:.1f} s",
                             left ? front(s.column[c]) : second(s.column[c]),
                             left ? second(s.column[c]) : front(s.column[c]), 100 * apart / moving,
                             since_s));
    return true;
  }

  /// Wheels of an axle are of one size, but for the few hundredths by which ovals are driven
  /// better.
  void another_size(Channel c,
                    const std::pair<std::vector<double>, std::vector<double>>& both) const {
    constexpr double kCounts = 0.05, kStraight_1pm = 0.005;  // a bend of 200 m: 0.8 %
    std::vector<double> ratio;
    for (std::size_t i = 0; i < s.n; ++i)
      if (s.x[kVx][i] > kRolls_mps && both.first[i] > 0 && both.second[i] > 0 &&
          !(std::abs(s.x[kYawRate][i]) > kStraight_1pm * s.x[kVx][i]))
        ratio.push_back(both.first[i] / both.second[i]);
    if (ratio.size() < 200) return;
    const double usual = base::median(std::move(ratio));
    if (std::abs(std::log(usual)) > kCounts)
      leave_out(c, fmt::format("'{}' is {:.2f} times '{}' for most of the drive",
                               front(s.column[c]), usual, second(s.column[c])));
  }

  /// Where one of two stands for ten seconds while the other goes up and down as it does elsewhere.
  void one_stands(Channel c,
                  const std::pair<std::vector<double>, std::vector<double>>& both) const {
    for (const bool left : {true, false}) {
      const std::vector<double>&x = left ? both.first : both.second,
            &other = left ? both.second : both.first;
      const auto begin_s = stands_beside(x, other);
      if (!begin_s) continue;
      leave_out(c, fmt::format("'{}' stands still from {:.1f} s on, where '{}' goes on",
                               left ? front(s.column[c]) : second(s.column[c]), *begin_s,
                               left ? second(s.column[c]) : front(s.column[c])));
      return;
    }
  }

  /// What most of the drive has, so that speeds are metres a second; 1 where they are. NaN where
  /// the car hardly moves.
  double radius_m(Channel c) const {
    std::vector<double> ratio;
    for (std::size_t i = 0; i < s.n; ++i)
      if (s.x[kVx][i] > kRolls_mps && s.x[c][i] > 0) ratio.push_back(s.x[kVx][i] / s.x[c][i]);
    if (ratio.size() < 200) return kNaN;
    return base::median(std::move(ratio));
  }

  void wheels(Channel c, const std::pair<std::vector<double>, std::vector<double>>& both) const {
    if (!s.present[c]) return;
    const double factor = radius_m(c);
    if (!(factor > 0)) return;
    // A track of half a metre at least; an axle that is locked shows none, and one that pushes
    // spins its inner wheel or locks.
    std::vector<double> turn = turn_radps;
    for (std::size_t i = 0; i < s.n; ++i)
      if (!(s.dx[kVx][i] < kPushes_mps2)) turn[i] = kNaN;
    const Follows f = follows(right_less_left(both, factor), turn);
    if (f.correlation < -0.5 && f.slope < -0.5)
      return leave_out(c,
                       fmt::format("'{}' is faster in left turns and '{}' in right ones: left and "
                                   "right are exchanged",
                                   front(s.column[c]), second(s.column[c])));
    if (!one_wheel_apart(c, both, factor)) another_size(c, both);
  }

  /// Of an axle that is driven and one that is not, as shares of the speed, against what speeds the
  /// car up. Cars here drive their rear wheels.
  void driven() const {
    if (!s.present[kWheelFront] || !s.present[kWheelRear]) return;
    constexpr double kSlips_s2pm = 0.001, kOfSpeed_s2pm = 0.0015, kSame = 0.25;
    constexpr double kMostSlip = 0.05;  // more is a wheel in the air, or over a kerb
    const double front_m = radius_m(kWheelFront), rear_m = radius_m(kWheelRear);
    std::vector<double> pushes(s.n, kNaN), front(s.n, kNaN), rear(s.n, kNaN), path(s.n, kNaN),
        rear_less_front(s.n, kNaN);
    for (std::size_t i = 0; i < s.n; ++i) {
      const double v = s.x[kVx][i];
      if (!(v > kRolls_mps) || !(s.dx[kVx][i] > kPushes_mps2)) continue;
      pushes[i] = s.dx[kVx][i];
      front[i] = front_m * s.x[kWheelFront][i] / v - 1;
      rear[i] = rear_m * s.x[kWheelRear][i] / v - 1;
      rear_less_front[i] = rear[i] - front[i];
      path[i] = std::hypot(s.dx[kX][i], s.dx[kY][i]) / v - 1;
      if (std::abs(front[i]) > kMostSlip || std::abs(path[i]) > kMostSlip)
        front[i] = path[i] = rear_less_front[i] = kNaN;
    }
    // Only their own speed keeps to wheels while others and the path agree on another one.
    const double of_speed = apart_from_speed(rear);
    const Follows together = follows(path, front);
    const bool is_rear = of_speed < kSame * apart_from_speed(front) &&
                         of_speed < kSame * apart_from_speed(path) && together.slope > 0.5 &&
                         together.correlation > 0.5;
    const Follows slips = follows(rear_less_front, pushes), of_front = follows(front, pushes),
                  of_rear = follows(rear, pushes), of_path = follows(path, pushes);
    const bool slips_before = of_front.slope < -kOfSpeed_s2pm && of_front.correlation < -0.5 &&
                              of_path.slope < 0.5 * of_front.slope &&
                              std::abs(of_rear.slope) < 0.25 * std::abs(of_front.slope);
    if (is_rear || slips_before)
      throw vehicle::Error(fmt::format(
          "{}: '{}' is as fast as '{}' where these slip under power, and '{}' and the path are "
          "slower: it is the speed of the driven wheels; give a speed over ground, or that of the "
          "wheels that are not driven",
          s.name, s.column[kVx], s.column[kWheelRear], s.column[kWheelFront]));
    if (slips.slope > -kSlips_s2pm || slips.correlation > -0.3) return;
    leave_out(
        kWheelFront,
        fmt::format("'{}' slip where the car speeds up, and '{}' roll with it: front and rear "
                    "are exchanged, or the front wheels are driven",
                    s.column[kWheelFront], s.column[kWheelRear]));
    s.present[kWheelRear] = s.present[kWheelRearDifference] = false;
  }

  /// What a car presses on the road on average is its weight and more: 1 kN at the least (a kart
  /// with its driver has 1.6), below 100 kN.
  void unit_of_loads() const {
    double n = 0, sum = 0;
    for (std::size_t i = 0; i < s.n; ++i)
      if (const double load_n = s.x[kLoadFront][i] + s.x[kLoadRear][i]; std::isfinite(load_n))
        n += 1, sum += load_n / 1e3;
    if (n < 200 || (sum > 1.0 * n && sum < 100.0 * n)) return;
    for (const Channel c : {kLoadFront, kLoadRear})
      leave_out(c, fmt::format("'{}' and the other axle's are {:.3g} in all, no weight of a car in "
                               "newton",
                               s.column[c], 1e3 * sum / n));
  }

  void loads(Channel c, const std::pair<std::vector<double>, std::vector<double>>& both,
             const std::vector<double>& to_the_left_mps2) const {
    if (!s.present[c]) return;
    if (follows(right_less_left(both, 1.0), to_the_left_mps2).correlation < -0.7)
      leave_out(c,
                fmt::format("'{}' is loaded in left turns and '{}' in right ones: left and right "
                            "are exchanged",
                            front(s.column[c]), second(s.column[c])));
  }
};

}  // namespace

void leave_out_exchanged(Signals& s, const Sides& sides) {
  const PathSays path = path_says(s);
  const Axles axles{s, path.turn_radps};
  for (const auto& [c, both] : sides) {
    if (!s.present[c]) continue;
    if (c == kWheelFront || c == kWheelRear)
      axles.wheels(c, both);
    else if (c == kLoadFront || c == kLoadRear)
      axles.loads(c, both, s.present[kAy] ? s.x[kAy] : path.across_mps2);
    if (s.present[c]) axles.one_stands(c, both);
  }
  axles.driven();
  if (!s.present[kLoadFront] || !s.present[kLoadRear]) return;
  axles.unit_of_loads();
  if (!s.present[kLoadFront]) return;
  std::vector<double> in_front(s.n);  // the share: how much presses on both changes with speed
  for (std::size_t i = 0; i < s.n; ++i)
    in_front[i] = s.x[kLoadFront][i] / (s.x[kLoadFront][i] + s.x[kLoadRear][i]);
  // What presses on the car moves the share as well: it need not follow closely, but by an arm.
  constexpr double kArm_s2pm = 0.003;
  const Follows braked = follows(in_front, path.slowing_mps2);
  if (braked.correlation < -0.4 && braked.slope < -kArm_s2pm) {
    axles.leave_out(kLoadFront, fmt::format("'{}' is less where the car slows down, and '{}' more: "
                                            "front and rear are exchanged",
                                            s.column[kLoadFront], s.column[kLoadRear]));
    s.present[kLoadRear] = false;
  }
}

}  // namespace explain
