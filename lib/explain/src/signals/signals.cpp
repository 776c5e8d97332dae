#include "explain/signals.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "antenna.h"
#include "late_together.h"
#include "not_known.h"
#include "place_on_road.h"
#include "plausible.h"
#include "sides.h"
#include "signal_samples.h"
#include "speed_of_path.h"
#include "still.h"
#include "vehicle/error.h"

namespace explain {
namespace {

using vehicle::Error;

/// The log's clock, from 0.
struct Clock {
  std::vector<double> time_s;
  double duration_s = 0.0;
  std::size_t repeated = 0, first_repeated = 0;  ///< rows with the time of the one before
};

Clock clock_of(const recording::Table& table, const Mapping& mapping, const std::string& name) {
  const ColumnMapping* column = nullptr;
  for (const ColumnMapping& m : mapping.columns)
    if (m.channel == "time_s" && table.find(m.column) != nullptr) column = &m;
  if (column == nullptr && !mapping.path.empty())
    throw Error(fmt::format("{}: {} takes no column for time_s; crgexplain map proposes a mapping",
                            name, mapping.path));
  if (column == nullptr)
    throw Error(
        fmt::format("{}: no time_s; columns are '{}', ...: crgexplain map proposes a mapping", name,
                    table.names.empty() ? "" : table.names[0]));
  Clock clock;
  std::vector<double>& time = clock.time_s;
  time = *table.find(column->column);
  for (double& t : time) t = t * column->scale + column->offset;
  double last = -std::numeric_limits<double>::infinity();
  double first_s = kNaN;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (!std::isfinite(time[i])) continue;
    if (std::isnan(first_s)) first_s = time[i];
    if (time[i] < last - 1e-9)
      throw Error(
          fmt::format("{}: row {}: the clock goes back from {:.3f} to {:.3f} s; cut the log there",
                      name, i + 1, last, time[i]));
    if (time[i] <= last && clock.repeated++ == 0) clock.first_repeated = i + 1;
    last = time[i];
  }
  for (double& t : time) t -= first_s;
  clock.duration_s = last - first_s;
  const double duration = clock.duration_s;
  if (!(duration >= 10.0))
    throw Error(fmt::format("{}: {:.1f} s long; at least 10 s are wanted", name,
                            std::isfinite(duration) ? duration : 0.0));
  if (duration > 1e5)
    throw Error(
        fmt::format("{}: {:.0f} s long; the clock's unit is not seconds, or the log wants cutting",
                    name, duration));
  return clock;
}

constexpr double kSlowest_hz = 5.0;

/// Puts channels of a log into signals, all smoothed by one kernel.
class SmoothedChannels {
 public:
  SmoothedChannels(Signals& signals, const recording::Table& table, const Mapping& mapping,
                   const Clock& clock)
      : signals_(signals), table_(table), mapping_(mapping), clock_(clock) {
    // Wide enough for ten samples, not wider than needed.
    double slowest = signals_.sample_hz;
    for (const char* motion :
         {"vx_mps", "vy_mps", "yaw_rate_radps", "ax_mps2", "ay_mps2", "az_mps2"})
      if (const double hz = static_cast<double>(read(motion).t.size()) / clock_.duration_s;
          hz > 1.2 * kSlowest_hz)
        slowest = std::min(slowest, hz);
    half_s_ = std::max(
        {0.15, 4.0 / signals_.sample_hz, slowest < 0.7 * signals_.sample_hz ? 2.2 / slowest : 0.0});
  }

  Samples read(const std::string& channel) const {
    return samples_of(table_, mapping_, channel, clock_.time_s);
  }

  /// Of what no car does within a sample: how it moves, turns and steers. Pedals leap where a gear
  /// is changed, wheels where they lock.
  Samples read_smooth(const std::string& channel, double impossible = HUGE_VAL) const {
    Samples out = read(channel);
    if (channel == "yaw_rad")
      for (std::size_t i = 1; i < out.x.size(); ++i)
        out.x[i] = out.x[i - 1] + std::remainder(out.x[i] - out.x[i - 1], 2 * std::numbers::pi);
    const std::vector<double> spikes = take_out_spikes(out, impossible);
    if (!spikes.empty())
      signals_.remarks.push_back(fmt::format(
          "{}: '{}': {} samples leap from their neighbours, first at {:.2f} s: not used",
          signals_.name, out.column, spikes.size(), spikes.front()));
    return out;
  }

  /// False where the log has nothing that can be used.
  bool put(Channel c, const Samples& samples) {
    if (samples.t.size() < 20) return false;
    // The kernel is that of all channels: slower ones would widen it too much.
    if (const double hz = static_cast<double>(samples.t.size()) / clock_.duration_s;
        hz < 1.2 * kSlowest_hz && hz < 0.5 * signals_.sample_hz) {
      const std::string what = fmt::format(
          "{}: '{}' has {:.1f} measurements a second (repeats not counted) in a log of {:.0f} rows "
          "a second; at least {:.0f} are wanted",
          signals_.name, samples.column, hz, signals_.sample_hz, 1.2 * kSlowest_hz);
      if (c == kX || c == kY || c == kVx) throw Error(what);
      signals_.remarks.push_back(what + ": not used; take it out of the mapping");
      signals_.broken = signals_.broken || (c != kEngine && c != kFuel);
      return false;
    }
    smooth(samples, 0.0, signals_.n, half_s_, signals_.x[c], signals_.dx[c]);
    signals_.present[c] = true;
    signals_.column[c] = samples.column;
    if (c == kYawRate || c == kAx || c == kAy)
      signals_.noise[c] = noise_like(samples, half_s_, signals_.x[c]);
    return true;
  }

  /// The mean of left and right, or as `sign_second` and `factor` say.
  bool put_mean(Channel c, const std::vector<std::string>& names, double sign_second = 1.0,
                double factor = 0.5) {
    Samples a = read(names[0]), b = read(names[1]);
    if (a.t.size() < 20 || b.t.size() < 20) return false;
    put(c, a);
    std::vector<double> x, dx;
    smooth(b, 0.0, signals_.n, half_s_, x, dx);
    if (c == kWheelFront || c == kWheelRear || c == kLoadFront || c == kLoadRear ||
        c == kBrakeFront || c == kBrakeRear)
      sides_[c] = {signals_.x[c], x};
    for (std::size_t i = 0; i < signals_.n; ++i) {
      signals_.x[c][i] = factor * (signals_.x[c][i] + sign_second * x[i]);
      signals_.dx[c][i] = factor * (signals_.dx[c][i] + sign_second * dx[i]);
    }
    signals_.column[c] = a.column + "," + b.column;
    return true;
  }

  const Sides& sides() const { return sides_; }

  void put_measured_or_command(Channel c, const char* measured, const char* command) {
    if (put(c, c == kSteer ? read_smooth(measured) : read(measured))) {
      if (c == kSteer) put(kSteerCommand, read(command));
      if (c == kThrottle) put(kThrottleCommand, read(command));
      if (c == kBrakeFront) put(kBrakeCommand, read(command));
      return;
    }
    if (put(c, read(command))) signals_.commanded[c] = true;
  }

 private:
  Signals& signals_;
  const recording::Table& table_;
  const Mapping& mapping_;
  const Clock& clock_;
  double half_s_ = 0.0;
  Sides sides_;
};

void put_motion(Signals& s, SmoothedChannels& channels) {
  // A change of gear alone is some 10 m/s2 for one sample or two.
  constexpr double kPlace_m = 2.0, kSpeed_mps = 5.0, kHeading_rad = 0.3, kAcceleration_mps2 = 25.0;
  for (const auto& [c, channel, impossible] : {std::tuple{kX, "x_m", kPlace_m},
                                               {kY, "y_m", kPlace_m},
                                               {kYaw, "yaw_rad", kHeading_rad},
                                               {kVx, "vx_mps", kSpeed_mps},
                                               {kYawRate, "yaw_rate_radps", HUGE_VAL},
                                               {kAx, "ax_mps2", kAcceleration_mps2},
                                               {kAy, "ay_mps2", kAcceleration_mps2}})
    channels.put(c, channels.read_smooth(channel, impossible));
  for (const auto& [c, channel] :
       {std::pair{kVy, "vy_mps"}, {kAz, "az_mps2"}, {kEngine, "engine_radps"}, {kFuel, "fuel_kg"}})
    channels.put(c, channels.read(channel));
  for (const Channel c : {kX, kY, kVx})
    if (!s.present[c])
      throw Error(fmt::format("{}: no {}; position and speed are the least the analysis needs{}",
                              s.name,
                              c == kX   ? "x_m"
                              : c == kY ? "y_m"
                                        : "vx_mps",
                              c == kVx ? ": name its column in the mapping"
                                       : "; crgexplain road makes places of speed and yaw rate"));
}

/// Left minus right of an axle, where a car that brakes its wheels one by one makes them differ.
void put_brakes_apart(Signals& s, SmoothedChannels& channels, Channel apart, Channel mean,
                      const std::vector<std::string>& names) {
  // Of the pressures' size. Noise makes 0.009 of one pressure in the recordings of another
  // simulator; a driver who brakes wheels by their loads makes 0.21 and more.
  constexpr double kCounts = 0.03;
  channels.put_mean(apart, names, -1.0, 1.0);
  const auto size = [&](Channel c) {
    double sum = 0.0;
    for (const double x : s.x[c]) sum += std::isfinite(x) ? x * x : 0.0;
    return std::sqrt(sum);
  };
  s.present[apart] = s.present[apart] && size(apart) > kCounts * size(mean);
}

void put_controls(Signals& s, SmoothedChannels& channels) {
  channels.put_measured_or_command(kSteer, "steer_rad", "steer_command_rad");
  channels.put_measured_or_command(kThrottle, "throttle", "throttle_command");
  if (!channels.put_mean(kBrakeFront, {"brake_fl_pa", "brake_fr_pa"}) ||
      !channels.put_mean(kBrakeRear, {"brake_rl_pa", "brake_rr_pa"})) {
    if (channels.put_mean(kBrakeFront, {"brake_fl_command_pa", "brake_fr_command_pa"}) &&
        channels.put_mean(kBrakeRear, {"brake_rl_command_pa", "brake_rr_command_pa"})) {
      s.commanded[kBrakeFront] = s.commanded[kBrakeRear] = true;
    } else {
      for (const Channel c : {kBrakeFront, kBrakeRear}) {
        s.present[c] = false;
        channels.put_measured_or_command(c, "brake_pa", "brake_command_pa");
      }
    }
  } else if (!channels.put_mean(kBrakeCommand, {"brake_fl_command_pa", "brake_fr_command_pa"})) {
    channels.put(kBrakeCommand, channels.read("brake_command_pa"));
  }
  const std::string of = s.commanded[kBrakeFront] ? "_command_pa" : "_pa";
  put_brakes_apart(s, channels, kBrakeFrontApart, kBrakeFront, {"brake_fl" + of, "brake_fr" + of});
  put_brakes_apart(s, channels, kBrakeRearApart, kBrakeRear, {"brake_rl" + of, "brake_rr" + of});
}

void put_wheels(Signals& s, SmoothedChannels& channels) {
  if (!(channels.put_mean(kWheelFront, {"wheel_fl_radps", "wheel_fr_radps"}) &&
        channels.put_mean(kWheelRear, {"wheel_rl_radps", "wheel_rr_radps"}) &&
        channels.put_mean(kWheelRearDifference, {"wheel_rl_radps", "wheel_rr_radps"}, -1.0, 1.0))) {
    s.wheels_in_mps = channels.put_mean(kWheelFront, {"wheel_fl_mps", "wheel_fr_mps"});
    channels.put_mean(kWheelRear, {"wheel_rl_mps", "wheel_rr_mps"});
    channels.put_mean(kWheelRearDifference, {"wheel_rl_mps", "wheel_rr_mps"}, -1.0, 1.0);
  }
  channels.put_mean(kLoadFront, {"fz_fl_n", "fz_fr_n"}, 1.0, 1.0);
  channels.put_mean(kLoadRear, {"fz_rl_n", "fz_rr_n"}, 1.0, 1.0);
}

/// A gear is a whole number: the nearest sample, no smoothing.
void put_gear(Signals& s, const Samples& gear) {
  if (gear.t.size() < 20) return;
  s.present[kGear] = true;
  s.column[kGear] = gear.column;
  s.x[kGear].assign(s.n, kNaN);
  s.dx[kGear].assign(s.n, 0.0);
  std::size_t k = 0;
  for (std::size_t i = 0; i < s.n; ++i) {
    const double t = Signals::kStep_s * static_cast<double>(i);
    while (k + 1 < gear.t.size() && gear.t[k + 1] <= t) ++k;
    s.x[kGear][i] = std::round(gear.x[k]);
  }
}

/// Slows down as no car does that rolls, climbs or has its throttle closed.
bool brakes(const Signals& s) {
  constexpr double kBraked_mps2 = 5.0, kLeast_s = 2.0;
  const auto braked =
      std::count_if(s.dx[kVx].begin(), s.dx[kVx].end(), [](double x) { return x < -kBraked_mps2; });
  return static_cast<double>(braked) * Signals::kStep_s > kLeast_s;
}

void leave_out_constant(Signals& s) {
  const auto moves = [&](std::size_t c) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double x : s.x[c])
      if (std::isfinite(x)) low = std::min(low, x), high = std::max(high, x);
    return s.present[c] && high - low > 1e-9;
  };
  for (std::size_t c = 0; c < kChannelCount; ++c) {
    if (!s.present[c]) {
      s.x[c].assign(s.n, kNaN);
      s.dx[c].assign(s.n, kNaN);
      continue;
    }
    if (c != kGear && c != kFuel && !moves(c)) {
      // A dead sensor says of the car what is not so; pedals and gears may stay where they are, and
      // a car may brake by one axle.
      const bool dead = c == kYawRate || c == kAx || c == kAy || c == kSteer || c == kWheelFront ||
                        c == kWheelRear || (c == kThrottle && moves_against_throttle(s, 0, s.n)) ||
                        (c == kBrakeFront && !moves(kBrakeRear) && brakes(s)) ||
                        (c == kBrakeRear && !moves(kBrakeFront) && brakes(s));
      // Both axles may have one column.
      const std::string remark =
          fmt::format("{}: '{}' is constant: not used{}", s.name, s.column[c],
                      dead ? "; take it out of the mapping" : "");
      if (s.remarks.empty() || s.remarks.back() != remark) s.remarks.push_back(remark);
      s.broken = s.broken || dead;
      s.present[c] = false;
    }
  }
}

/// Where a log has neither yaw rate nor heading, the car turns as its path does, less what its
/// lateral speed says of the angle between them.
void turn_by_the_path(Signals& s) {
  if (s.present[kYawRate] || s.present[kYaw]) return;
  const auto course = [&](std::size_t i) { return std::atan2(s.dx[kY][i], s.dx[kX][i]); };
  for (std::size_t i = 2; i + 2 < s.n; ++i) {
    const double vx = s.x[kVx][i], vy = s.present[kVy] ? s.x[kVy][i] : 0.0,
                 dvy = s.present[kVy] ? s.dx[kVy][i] : 0.0;
    s.x[kYaw][i] = course(i) - std::atan2(vy, vx);
    s.dx[kYaw][i] = std::remainder(course(i + 2) - course(i - 2), 2 * std::numbers::pi) /
                        (4 * Signals::kStep_s) -
                    (vx * dvy - vy * s.dx[kVx][i]) / (vx * vx + vy * vy);
  }
  s.remarks.push_back(s.name + ": neither yaw rate nor heading: the car turns as its path does");
}

/// All channels on one clock, without those that hold nothing.
Signals put_together(const recording::Table& table, const Mapping& mapping, const Clock& clock,
                     const std::string& name, Sides& sides) {
  Signals s;
  s.name = name;
  s.imu_yaw_rad = mapping.imu_yaw_rad;
  s.imu_ahead_m = mapping.imu_ahead_m;
  s.sample_hz = static_cast<double>(clock.time_s.size() - 1) / clock.duration_s;
  if (s.sample_hz < 5)
    throw Error(
        fmt::format("{}: {:.1f} samples a second; at least 10 are wanted", name, s.sample_hz));
  s.n = static_cast<std::size_t>(clock.duration_s / Signals::kStep_s) + 1;
  if (clock.repeated > 0)
    s.remarks.push_back(
        fmt::format("{}: {} rows have the time of the row before, first row {}: taken together",
                    name, clock.repeated, clock.first_repeated));
  SmoothedChannels channels(s, table, mapping, clock);
  put_motion(s, channels);
  put_controls(s, channels);
  put_wheels(s, channels);
  put_gear(s, channels.read("gear"));
  leave_out_constant(s);
  refuse_another_unit(s);
  leave_out_still(s);
  leave_out_leaps(s);
  sides = channels.sides();
  return s;
}

/// The same with the columns of a device whose clock is behind moved to where they belong.
Signals put_in_time(const recording::Table& table, const Mapping& mapping, const Clock& clock,
                    const std::string& name, Sides& sides) {
  Signals s = put_together(table, mapping, clock, name, sides);
  const std::optional<LateColumns> late = late_together(s);
  if (!late) return s;
  Mapping in_time = mapping;
  for (ColumnMapping& m : in_time.columns)
    if (std::find(late->columns.begin(), late->columns.end(), m.column) != late->columns.end())
      m.delay_s += late->delay_s;
  s = put_together(table, in_time, clock, name, sides);
  s.late = *late;
  s.remarks.push_back(fmt::format(
      "{}: '{}' come {:.3f} s {} all together, against what the other columns say of the path: "
      "moved to where they belong",
      name, fmt::join(late->columns, "', '"), std::abs(late->delay_s),
      late->delay_s > 0 ? "late" : "early"));
  return s;
}

}  // namespace

Signals make_signals(const recording::Table& table, const Mapping& mapping,
                     const crg::Surface& surface, const std::string& name) {
  Sides sides;
  Signals s = put_in_time(table, mapping, clock_of(table, mapping, name), name, sides);
  place_on_road(s, surface);
  leave_out_implausible(s);
  leave_out_exchanged(s, sides);
  doubt_antenna_aside(s);
  turn_by_the_path(s);
  return s;
}

}  // namespace explain
