#include "confirm_mapping.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <utility>

#include "column_words.h"
#include "level_axes.h"
#include "path_fit.h"

namespace explain {
namespace {

using recording::Table;

/// How many samples `late` lags behind `reference`, by the largest correlation; NaN if unclear.
double lag_s(const std::vector<double>& t, const std::vector<double>& reference,
             const std::vector<double>& late) {
  const double dt = (t.back() - t.front()) / static_cast<double>(t.size() - 1);
  if (!(dt > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  // Half a second, as far as that is a part of the log; 4 kHz is the fastest logger.
  const int most =
      static_cast<int>(std::min({0.5 / dt, static_cast<double>(t.size()) / 4.0, 2000.0}));
  std::vector<double> r(2 * static_cast<std::size_t>(most) + 1);
  std::size_t best = 0;
  for (int k = -most; k <= most; ++k) {
    double ab = 0, aa = 0, bb = 0;
    for (std::size_t i = static_cast<std::size_t>(most);
         i + static_cast<std::size_t>(most) < t.size(); ++i) {
      const double a = reference[i], b = late[static_cast<std::size_t>(static_cast<int>(i) + k)];
      if (!std::isfinite(a) || !std::isfinite(b)) continue;
      ab += a * b;
      aa += a * a;
      bb += b * b;
    }
    const auto at = static_cast<std::size_t>(k + most);
    r[at] = aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0.0;
    if (r[at] > r[best]) best = at;
  }
  if (r[best] < 0.8 || best == 0 || best + 1 == r.size())
    return std::numeric_limits<double>::quiet_NaN();
  const double a = r[best - 1], b = r[best], c = r[best + 1];
  const double vertex = (a - c) / (2 * (a - 2 * b + c));
  return (static_cast<double>(best) - most + vertex) * dt;
}

/// How well a heading agrees with the course, at the sign and the zero at which it does so best.
struct Agreement {
  double strength = -1, sign = 1, offset = 0;
};

Agreement agreement_of(const std::vector<double>& course, const std::vector<double>& heading) {
  Agreement best;
  for (const double s : {1.0, -1.0}) {
    double sin_sum = 0, cos_sum = 0, count = 0;
    for (std::size_t i = 0; i < course.size(); ++i)
      if (std::isfinite(course[i]) && std::isfinite(heading[i])) {
        sin_sum += std::sin(course[i] - s * heading[i]);
        cos_sum += std::cos(course[i] - s * heading[i]);
        count += 1;
      }
    const double strength = count > 0 ? std::hypot(sin_sum, cos_sum) / count : 0.0;
    if (strength > best.strength) best = {strength, s, std::atan2(sin_sum, cos_sum)};
  }
  return best;
}

/// Heading: which way it turns and where its zero lies, against the course of the path.
void confirm_yaw(const Table& table, const Path& path, bool by_satellites, Mapping& mapping) {
  ColumnMapping* m = find_channel(mapping, "yaw_rad");
  if (m == nullptr) return;
  const std::vector<double> raw = mapped_values(mapping, table, "yaw_rad");
  Agreement agreement = agreement_of(path.course, raw);
  auto& [best, sign, offset] = agreement;
  if (by_satellites && best < 0.5) {
    mapping.notes.push_back(
        fmt::format("column '{}' is not used: the path confirms neither its sign nor its zero "
                    "(agreement {:.2f})",
                    m->column, std::max(0.0, best)));
    std::erase_if(mapping.columns,
                  [](const ColumnMapping& other) { return other.channel == "yaw_rad"; });
    best = -1;
  }
  // Only quarter turns are a convention; the rest is the sensor's and stays in the data.
  const double quarter = std::round(offset / (std::numbers::pi / 2)) * (std::numbers::pi / 2);
  m = find_channel(mapping, "yaw_rad");
  if (m != nullptr) m->scale *= sign, m->offset = quarter;
  if (m != nullptr)
    mapping.notes.push_back(
        fmt::format("yaw_rad: against the path's course sign {:+.0f}, zero {:.0f} degrees, mean "
                    "difference {:.2f} degrees, agreement {:.3f} (1 is perfect)",
                    sign, quarter / kDegree, (offset - quarter) / kDegree, best));
}

/// A unit that was guessed becomes the one in which the channel is what the path says of it;
/// `slope` is how many times that it was. Returns what remains.
double settle_unit(double slope, const char* what, ColumnMapping& m, Mapping& mapping) {
  if (!mapping.guessed.contains(m.channel) || std::abs(std::abs(slope) - 1.0) <= 0.3) return slope;
  std::vector<double> units{1.0};
  if (m.channel == "vx_mps") units = {1.0, 1 / 3.6, 0.44704, 1852.0 / 3600};
  if (m.channel.ends_with("_mps2")) units = {1.0, 9.80665};
  if (m.channel.ends_with("_radps")) units = {1.0, kDegree};
  for (const double unit : units) {
    const double scale = std::copysign(unit, m.scale), left = slope * scale / m.scale;
    if (std::abs(std::abs(left) - 1.0) > 0.08) continue;
    mapping.notes.push_back(
        fmt::format("{} from '{}': factor {:g}, by {}", m.channel, m.column, unit, what));
    // What no path says of goes with what it does say, where the same file names no unit of both.
    for (const auto& [leader, follower] :
         std::initializer_list<std::pair<const char*, const char*>>{
             {"vx_mps", "vy_mps"},
             {"ax_mps2", "az_mps2"},
             {"yaw_rate_radps", "roll_rate_radps"},
             {"yaw_rate_radps", "pitch_rate_radps"}})
      if (ColumnMapping* const f = find_channel(mapping, follower);
          m.channel == leader && f != nullptr && mapping.guessed.contains(follower))
        f->scale *= std::abs(scale / m.scale);
    m.scale = scale;
    return left;
  }
  return slope;
}

/// Sign, size and delay of a channel against what the path says of it.
void confirm(const Table& table, const std::vector<double>& t, const char* channel,
             const std::vector<double>& reference, const char* what, Mapping& mapping) {
  ColumnMapping* m = find_channel(mapping, channel);
  if (m == nullptr) return;
  Fit fit = through_zero(reference, mapped_values(mapping, table, channel));
  if (std::abs(fit.correlation) < 0.5) {
    mapping.notes.push_back(
        fmt::format("{}: correlation {:.2f} with {}: sign and unit not confirmed", channel,
                    fit.correlation, what));
    return;
  }
  fit.slope = settle_unit(fit.slope, "the path", *m, mapping);
  if (mapping.guessed.contains(channel) && std::abs(std::abs(fit.slope) - 1.0) > 0.3) {
    mapping.notes.push_back(
        fmt::format("column '{}' is not used: its unit is not known, and {:.3g} times {} is none "
                    "that is",
                    m->column, std::abs(fit.slope), what));
    std::erase_if(mapping.columns,
                  [&](const ColumnMapping& other) { return other.channel == channel; });
    return;
  }
  if (fit.slope < 0) m->scale = -m->scale;
  mapping.notes.push_back(fmt::format("{}: {:.3f} times {}, correlation {:.3f}{}", channel,
                                      std::abs(fit.slope), what, std::abs(fit.correlation),
                                      fit.slope < 0 ? "; sign turned" : ""));
  if (std::abs(std::abs(fit.slope) - 1.0) > 0.3)
    mapping.notes.push_back(
        fmt::format("{}: a factor of {:.3g} remains: wrong unit?", channel, std::abs(fit.slope)));
  const double late = lag_s(t, reference, mapped_values(mapping, table, channel));
  if (std::isfinite(late))
    mapping.notes.push_back(fmt::format(
        "{}: {} {} by {:.3f} s (not corrected: set delay_s if the logger is known to do so)",
        channel, late >= 0 ? "lags" : "leads", what, std::abs(late)));
}

void confirm_steering(const Table& table, const char* channel, const std::vector<double>& curvature,
                      bool by_satellites, Mapping& mapping) {
  ColumnMapping* m = find_channel(mapping, channel);
  if (m == nullptr) return;
  const Fit fit = through_zero(curvature, mapped_values(mapping, table, channel));
  if (by_satellites && std::abs(fit.correlation) <= 0.5) {
    mapping.notes.push_back(
        fmt::format("column '{}' is not used: the path does not confirm it (correlation "
                    "{:.2f}), and it may be the steering wheel's",
                    m->column, fit.correlation));
    std::erase_if(mapping.columns,
                  [&](const ColumnMapping& other) { return other.channel == channel; });
    return;
  }
  // Front wheels turn about as far as the curvature asks; understeer is less than this.
  if (std::abs(fit.correlation) > 0.5 && std::abs(fit.slope) > 5.0) {
    mapping.notes.push_back(fmt::format(
        "column '{}' is not used: it turns {:.1f} times as far as the curvature asks of the "
        "front wheels of a car of 3 m wheelbase, as a steering wheel does; map it to {} with "
        "scale {}{:.6g} over the steering's ratio",
        m->column, std::abs(fit.slope), channel, fit.slope < 0 ? "-" : "", m->scale));
    std::erase_if(mapping.columns,
                  [&](const ColumnMapping& other) { return other.channel == channel; });
    return;
  }
  // A unit that was guessed must be right: games write a share of the lock.
  if (mapping.guessed.contains(channel) && std::abs(fit.correlation) > 0.5 &&
      (std::abs(fit.slope) < 0.3 || std::abs(fit.slope) > 1.35)) {
    mapping.notes.push_back(fmt::format(
        "column '{}' is not used: its unit is not known, and as it is it turns {:.2f} times as far "
        "as the curvature asks of a car of 3 m wheelbase; where it goes with the front wheels' "
        "angle, map it to {} with scale {:.4g}",
        m->column, std::abs(fit.slope), channel, m->scale / fit.slope));
    std::erase_if(mapping.columns,
                  [&](const ColumnMapping& other) { return other.channel == channel; });
    return;
  }
  if (fit.correlation < -0.5) m->scale = -m->scale;
  mapping.notes.push_back(fmt::format("{}: correlation {:.2f} with the path's curvature{}", channel,
                                      std::abs(fit.correlation),
                                      fit.correlation < -0.5 ? "; sign turned" : ""));
}

/// Accelerations that go with each other's reference are exchanged: the axes of a telephone lie as
/// it does.
void exchange_accelerations(const Table& table, const std::vector<double>& ahead,
                            const std::vector<double>& aside, Mapping& mapping) {
  ColumnMapping* const ax = find_channel(mapping, "ax_mps2");
  ColumnMapping* const ay = find_channel(mapping, "ay_mps2");
  if (ax == nullptr || ay == nullptr) return;
  const std::vector<double> x = mapped_values(mapping, table, "ax_mps2"),
                            y = mapped_values(mapping, table, "ay_mps2");
  const auto goes = [](const std::vector<double>& reference, const std::vector<double>& values) {
    return std::abs(through_zero(reference, values).correlation);
  };
  if (goes(ahead, x) > 0.5 || goes(aside, y) > 0.5 || goes(aside, x) < 0.8 || goes(ahead, y) < 0.8)
    return;
  std::swap(ax->channel, ay->channel);
  mapping.notes.push_back(
      fmt::format("the path says that '{}' is lateral and '{}' longitudinal: exchanged", ay->column,
                  ax->column));
}

/// How a travel goes with the acceleration, beside what goes with downforce (speed squared): the
/// slope, and the correlation of what the other two leave of both.
Fit by_acceleration(const std::vector<double>& travel, const std::vector<double>& speed,
                    const std::vector<double>& acceleration) {
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < travel.size(); ++i)
    if (std::isfinite(travel[i]) && std::isfinite(acceleration[i]) && speed[i] > 5.0)
      rows.push_back(static_cast<Eigen::Index>(i));
  const auto count = static_cast<Eigen::Index>(rows.size());
  if (count < 200) return {};
  Eigen::VectorXd downforce(count);
  Eigen::MatrixX2d left(count, 2);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(rows[static_cast<std::size_t>(k)]);
    downforce[k] = speed[i] * speed[i];
    left.row(k) << acceleration[i], travel[i];
  }
  downforce.array() -= downforce.mean();
  left.rowwise() -= left.colwise().mean().eval();
  if (const double all = downforce.squaredNorm(); all > 0.0)
    left -= downforce * (downforce.transpose() * left / all).eval();
  const double xx = left.col(0).squaredNorm(), yy = left.col(1).squaredNorm(),
               xy = left.col(0).dot(left.col(1));
  if (!(xx > 0.0) || !(yy > 0.0)) return {};
  return {xy / xx, xy / std::sqrt(xx * yy)};
}

}  // namespace

ColumnMapping* find_channel(Mapping& mapping, const std::string& channel) {
  for (ColumnMapping& m : mapping.columns)
    if (m.channel == channel) return &m;
  return nullptr;
}

std::vector<double> mapped_values(Mapping& mapping, const Table& table,
                                  const std::string& channel) {
  const ColumnMapping* m = find_channel(mapping, channel);
  std::vector<double> out;
  if (m == nullptr) return out;
  out = *table.find(m->column);
  for (double& x : out) x = x * m->scale + m->offset;
  return out;
}

void confirm_travels(const Table& table, const std::vector<double>& t, Mapping& mapping) {
  bool any = false;
  std::vector<double> speed, acceleration;
  if (find_channel(mapping, "vx_mps") != nullptr) {
    speed = recording::fill_gaps(t, mapped_values(mapping, table, "vx_mps"));
    acceleration = acceleration_of(t, speed);
  }
  for (const char* const wheel : {"fl", "fr", "rl", "rr"}) {
    const std::string channel = fmt::format("suspension_{}_m", wheel);
    ColumnMapping* const m = find_channel(mapping, channel);
    if (m == nullptr) continue;
    any = true;
    const Fit fit = speed.empty() ? Fit{}
                                  : by_acceleration(mapped_values(mapping, table, channel), speed,
                                                    acceleration);
    const bool turned = wheel[0] == 'f' ? fit.slope > 0.0 : fit.slope < 0.0;
    const bool sure = std::abs(fit.correlation) > 0.3;
    if (sure && turned) m->scale = -m->scale;
    mapping.notes.push_back(
        fmt::format("{}: correlation {:.2f} with the acceleration by vx_mps: {}", channel,
                    std::abs(fit.correlation),
                    !sure    ? "the sign is not confirmed (bump is positive)"
                    : turned ? "sign turned, bump is positive"
                             : "the sign is right, bump is positive"));
  }
  if (any)
    mapping.notes.emplace_back(
        "suspension travels: where zero is and the ratio of a sensor at the damper to the wheel's "
        "travel are not in a log: set offset and scale, travel is 0 where the car stands");
}

void confirm_without_place(const Table& table, const std::vector<double>& t, Mapping& mapping) {
  ColumnMapping* const speed = find_channel(mapping, "vx_mps");
  if (speed == nullptr) return;
  const auto filled = [&](const char* channel) {
    return recording::fill_gaps(t, mapped_values(mapping, table, channel));
  };
  std::vector<double> v = filled("vx_mps");
  const double most = *std::max_element(v.begin(), v.end());
  constexpr double kSlow_mps = 60.0;  // what is faster may as well be km/h or mph
  // Whole numbers are what buses and gauges show, and hardly ever m/s.
  const std::vector<double>& logged = *table.find(speed->column);
  const bool whole = most > 15.0 && std::all_of(logged.begin(), logged.end(), [](double x) {
                       return std::isnan(x) || x == std::floor(x);
                     });
  if (mapping.guessed.contains("vx_mps") && speed->scale == 1.0 && (most > kSlow_mps || whole)) {
    const ColumnMapping* const ahead = find_channel(mapping, "ax_mps2");
    const bool known = ahead != nullptr && !mapping.guessed.contains("ax_mps2");
    const Fit fit = known ? through_zero(filled("ax_mps2"), acceleration_of(t, v)) : Fit{};
    const double left = std::abs(fit.correlation) > 0.8
                            ? std::abs(settle_unit(fit.slope, "ax_mps2", *speed, mapping))
                            : 0.0;
    if (std::abs(left - 1.0) > 0.3) {
      mapping.missing.push_back(
          fmt::format("the unit of '{}' is not known: up to {:g}, it may be m/s, km/h or mph; map "
                      "it to vx_mps with scale 1, 0.277778 or 0.44704",
                      speed->column, most));
      std::erase_if(mapping.columns, [&](const ColumnMapping& m) {
        return m.channel == "vx_mps" ||
               (m.channel == "vy_mps" && mapping.guessed.contains(m.channel));
      });
      return;
    }
    v = filled("vx_mps");
  }
  const std::vector<double> rate = mapped_values(mapping, table, "yaw_rate_radps"),
                            ay = mapped_values(mapping, table, "ay_mps2");
  if (rate.empty() || ay.empty()) return;
  std::vector<double> turning(v.size()), aside(v.size());
  for (std::size_t i = 0; i < v.size(); ++i) {
    turning[i] = v[i] > 3.0 ? ay[i] / v[i] : std::numeric_limits<double>::quiet_NaN();
    aside[i] = v[i] * rate[i];
  }
  ColumnMapping* const yaw_rate = find_channel(mapping, "yaw_rate_radps");
  if (const Fit fit = through_zero(turning, rate);
      std::abs(fit.correlation) > 0.8 && !mapping.guessed.contains("ay_mps2"))
    settle_unit(fit.slope, "ay_mps2 over vx_mps", *yaw_rate, mapping);
  if (const Fit fit = through_zero(aside, ay); fit.correlation < -0.5)
    mapping.notes.push_back(
        fmt::format("ay_mps2 and yaw_rate_radps contradict each other (correlation {:.2f} with "
                    "vx_mps times yaw rate): turn the scale of one, both are positive to the left",
                    fit.correlation));
}

void confirm_mapping(const Table& table, const std::vector<double>& t, const std::vector<double>& x,
                     const std::vector<double>& y, bool by_satellites, Mapping& mapping) {
  const Path path = path_of(t, x, y);
  confirm_yaw(table, path, by_satellites, mapping);
  const auto against = [&](const char* channel, const std::vector<double>& reference,
                           const char* what) {
    confirm(table, t, channel, reference, what, mapping);
  };
  against("yaw_rate_radps", path.rate, "the turning of the path");
  std::vector<double> lateral(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) lateral[i] = path.speed[i] * path.rate[i];
  leave_out_axes_of_plane(table, path, lateral, mapping);
  against("vx_mps", path.speed, "the speed of the path");
  exchange_accelerations(table, path.acceleration, lateral, mapping);
  against("ax_mps2", path.acceleration, "the path's acceleration");
  against("ay_mps2", lateral, "speed times turning of the path");
  std::vector<double> curvature(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) curvature[i] = path.rate[i] / path.speed[i] * 3.0;
  for (const char* channel : {"steer_rad", "steer_command_rad"})
    confirm_steering(table, channel, curvature, by_satellites, mapping);
}

}  // namespace explain
