#include "vehicle/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "recording/channels.h"
#include "replay_commands.h"
#include "replay_errors.h"
#include "replay_path.h"
#include "replay_windows.h"
#include "vehicle/error.h"
#include "vehicle/steady_engine.h"
#include "vehicle/step_swing.h"
#include "vehicle/telemetry.h"

namespace vehicle {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kHold_1ps = 3.0;  ///< how fast the held car comes back to its recorded place

/// States that the recording sets, by place in the state.
using RecordedStates = std::vector<std::pair<std::size_t, Channel>>;

RecordedStates recorded_states(const Source& source) {
  RecordedStates out, body;
  bool whole_body = true;
  for (std::size_t i = 0; i < kStateSize; ++i) {
    const StateInfo& info = kStates[i];
    if (info.recorded == Recorded::kNever) continue;
    Channel channel = source.channel(std::string(info.channel));
    if (channel.empty())
      whole_body = whole_body && info.recorded != Recorded::kWithBody;
    else
      (info.recorded == Recorded::kWithBody ? body : out).emplace_back(i, std::move(channel));
  }
  if (whole_body) out.insert(out.end(), body.begin(), body.end());
  return out;
}

/// Puts the car on the recording: what was recorded replaces what was simulated.
void put_on(const Road& road, std::size_t row, const RecordedStates& states,
            Simulation<double>& sim) {
  State<double>& s = sim.state;
  const double before_mps = std::max(1.0, s[kVx]);
  const auto ground_m = [&] { return road.at(s[kX], s[kY], s[kZ], 0, sim.cursors).z_m; };
  const double height_m = s[kZ] - ground_m();
  bool spins = false, engine = false, body = false;
  for (const auto& [index, channel] : states) {
    s[index] = channel[row];
    body = body || index == kZ;
    spins = spins || index == kSpin;
    engine = engine || index == kEngine;
  }
  const double z_m = ground_m() + height_m;
  if (!body && std::isfinite(z_m)) s[kZ] = z_m;
  // Wheels and engine that were not recorded keep their slips.
  const double factor = std::max(1.0, s[kVx]) / before_mps;
  if (!spins)
    for (std::size_t i = 0; i < kWheels; ++i) s[kSpin + i] *= factor;
  if (!spins && !engine && sim.discrete.gear > 0) s[kEngine] *= factor;
}

/// The recorded motion that every window begins on and is held to.
struct Motion {
  Channel x_m, y_m, yaw_rad, vx_mps, z_m;
};

/// Everything that a replay is driven with.
struct Replay {
  const Road& road;
  const recording::Recording& recording;
  const ReplayOptions& options;
  const Source& source;
  Car<double> car;
  Commands commands;
  Motion motion;
  RecordedStates states;
  Map2 engine_torque_nm;  ///< what the driver takes for the engine; empty: the car's map

  const std::vector<double>& time() const { return source.time; }
};

StartOptions start_of(const Replay& replay, const Window& window) {
  const Motion& motion = replay.motion;
  const std::size_t row = window.settle;
  StartOptions begin;
  begin.x_m = motion.x_m[row];
  begin.y_m = motion.y_m[row];
  begin.z_near_m = motion.z_m.empty() ? kNaN : motion.z_m[row];
  begin.yaw_rad = motion.yaw_rad[row];
  begin.speed_mps = std::max(0.0, motion.vx_mps[row]);
  begin.gear = replay.commands.gear.empty()
                   ? choose_gear(replay.car, begin.speed_mps, kMostGears)
                   : std::clamp(static_cast<int>(replay.commands.gear[row]), -1, kMostGears);
  begin.fuel_kg = replay.options.fuel_kg;
  begin.tyre_k = replay.options.tyre_k;
  begin.disc_k = replay.options.disc_k;
  return begin;
}

/// The push that holds speed and place: critically damped on the distance to the recorded place,
/// seen along the recorded heading.
double hold_n(const Replay& replay, std::size_t row, double t, const State<double>& state) {
  const Motion& m = replay.motion;
  const std::vector<double>& time = replay.time();
  const double cy = std::cos(m.yaw_rad[row]), sy = std::sin(m.yaw_rad[row]);
  const double behind_m =
      cy * (at(m.x_m, time, row, t) - state[kX]) + sy * (at(m.y_m, time, row, t) - state[kY]);
  const double slower_mps = at(m.vx_mps, time, row, t) - state[kVx];
  return (replay.car.parameters[Parameter::chassis_mass_kg] + state[kFuel]) * kHold_1ps *
         (2.0 * slower_mps + kHold_1ps * behind_m);
}

/// Who drives in a window: the commands, what leads back to the path, or the driver.
class Pilot {
 public:
  Pilot(const Replay& replay, const Window& window, const StartOptions& begin)
      : replay_(replay),
        line_(line_of(replay, window)),
        keeper_{replay.motion.x_m,     replay.motion.y_m,
                replay.motion.yaw_rad, replay.commands.steer_command_rad,
                window.settle,         stretch_end(replay.recording, window)},
        driver_(driver_at(line_, begin.x_m, begin.y_m, begin.gear, replay.options.driver_options)),
        gear_(begin.gear) {
    driver_.options.step_s = replay.options.step.step_s;
  }

  /// `row`: the recorded row before t; `detail`: of the step before.
  Controls<double> controls(std::size_t row, double t, const State<double>& state,
                            const Detail<double>& detail) {
    const ReplayOptions& options = replay_.options;
    const Car<double>& car = replay_.car;
    Controls<double> c =
        controls_at(replay_.commands, replay_.time(), row, t, car, state[kVx], gear_);
    if (options.driver) {
      const Controls<double> driven = drive(driver_, line_, car, state, detail);
      c.steer_command_rad = driven.steer_command_rad;
      c.throttle_command = driven.throttle_command;
      c.brake_command_pa = driven.brake_command_pa;
      c.gear_command = gear_ = driven.gear_command;
    } else if (options.closed_path) {
      c.steer_command_rad = replay_.commands.steer_command_rad.empty()
                                ? drive(driver_, line_, car, state, detail).steer_command_rad
                                : keeper_.steer(car, state, options.driver_options);
    }
    if (options.hold_speed) c.hold_n = hold_n(replay_, row, t, state);
    return c;
  }

 private:
  static RacingLine line_of(const Replay& replay, const Window& window) {
    const bool followed = replay.options.driver ||
                          (replay.options.closed_path && replay.commands.steer_command_rad.empty());
    if (!followed) return {};
    RacingLine line = recorded_line(replay.motion.x_m, replay.motion.y_m, replay.motion.vx_mps,
                                    {window.stretch_begin, stretch_end(replay.recording, window)});
    line.engine_torque_nm = replay.engine_torque_nm;
    return line;
  }

  const Replay& replay_;
  RacingLine line_;
  PathKeeper keeper_;
  Driver driver_;
  int gear_;
};

/// Writes down simulated rows at the times of recorded ones, which lie between two steps: both are
/// kept, the row is on their line.
class RowWriter {
 public:
  RowWriter(const std::vector<double>& time, double step_s, ReplayErrors& errors, ReplayResult& out)
      : time_(time),
        step_s_(step_s),
        errors_(errors),
        out_(out),
        now_(recording::telemetry_channels().size()),
        before_(now_.size()),
        between_(now_.size()) {}

  /// Where the rows that are asked for do not follow the step before.
  void skip() { have_before_ = false; }

  /// The rows from `next` on that lie up to t.
  void write(double t, const State<double>& state, const Detail<double>& detail,
             const Controls<double>& c, const crg::UV& place, std::size_t end, std::size_t& next) {
    const auto& names = recording::telemetry_channels();
    fill_telemetry(t, state, detail, c, place.u_m, place.v_m, now_);
    for (; next < end && time_[next] <= t + 1e-9; ++next) {
      between_ = now_;
      if (have_before_)
        for (std::size_t i = 0; i < names.size(); ++i)
          if (names[i] != "u_m" && names[i] != "gear")  // both may jump
            between_[i] =
                before_[i] + (time_[next] - t + step_s_) / step_s_ * (now_[i] - before_[i]);
      between_[0] = time_[next];
      for (std::size_t i = 0; i < names.size(); ++i)
        out_.telemetry.columns[i].push_back(between_[i]);
      out_.telemetry.columns[names.size()].push_back(c.hold_n);
      out_.telemetry.columns.back().push_back(static_cast<double>(out_.windows));
      errors_.add(next, between_);
    }
    before_ = now_;
    have_before_ = true;
  }

 private:
  const std::vector<double>& time_;
  double step_s_;
  ReplayErrors& errors_;
  ReplayResult& out_;
  std::vector<double> now_, before_, between_;
  bool have_before_ = false;
};

/// Drives one window from `sim` on, which stands at its first row to settle.
void drive_window(const Replay& replay, const Window& window, const StartOptions& begin,
                  RowWriter& rows, Simulation<double>& sim, ReplayResult& out) {
  const ReplayOptions& options = replay.options;
  const Car<double>& car = replay.car;
  const std::vector<double>& time = replay.time();
  const double h = options.step.step_s;
  Pilot pilot(replay, window, begin);
  Detail<double> detail{};
  std::optional<RoadTracker> tracker;
  if (replay.road.surface() != nullptr) tracker.emplace(*replay.road.surface());
  std::size_t next = window.first, row = window.settle;
  bool settled = false;
  StepSwing swing;
  rows.skip();
  for (std::int64_t n = 0; next < window.end; ++n) {
    if (options.progress && n % 4096 == 0)
      options.progress("replay", static_cast<double>(next) / static_cast<double>(time.size()));
    const double t = time[window.settle] + static_cast<double>(n) * h;
    while (row + 2 < time.size() && time[row + 1] <= t) ++row;
    if (!settled && t >= time[window.first] - 0.5 * h) {
      put_on(replay.road, window.first, replay.states, sim);
      settled = true;
    }
    const State<double> state = sim.state;
    const Controls<double> c = pilot.controls(row, t, state, detail);
    const StepResult result = step(car, sim, c, replay.road, options.step, detail);
    if (!result.ok()) {
      const RoadPoint& under = detail.wheel[0].road;
      out.problems.push_back(fmt::format("window {}: {}", out.windows,
                                         describe(result, t - time.front(), under.u_m, under.v_m)));
      break;
    }
    swing.look(car, state, detail);
    if (!settled || time[next] > t + 1.5 * h) {
      rows.skip();
      continue;
    }
    crg::UV place{state[kX], state[kY]};
    if (tracker)
      place = tracker->at(state[kX], state[kY],
                          state[kZ] - car.parameters[Parameter::chassis_cog_height_m]);
    rows.write(t, state, detail, c, place, window.end, next);
  }
  if (swing.largest() > out.step_swing) {
    out.step_swing = swing.largest();
    out.swing_warning = swing.warning(options.step);
  }
  if (const laws::LedgeTotal& ledges = sim.discrete.ledges; ledges.most_j > out.ledge_most_j) {
    out.ledge_most_j = ledges.most_j;
    out.ledge_warning = ledge_warning(ledges);
  }
}

/// What the push that held the speed amounts to.
void sum_up_push(ReplayResult& out) {
  const std::vector<double>& pushes_n = *out.telemetry.find("hold_n");
  for (const double push_n : pushes_n) {
    out.hold_mean_n += push_n;
    out.hold_rms_n += push_n * push_n;
    out.hold_most_n = std::max(out.hold_most_n, std::abs(push_n));
  }
  const auto rows = static_cast<double>(std::max<std::size_t>(1, pushes_n.size()));
  out.hold_mean_n /= rows;
  out.hold_rms_n = std::sqrt(out.hold_rms_n / rows);
}

}  // namespace

ReplayResult replay(const Car<double>& stated, const Road& road,
                    const recording::Recording& recording, const ReplayOptions& options) {
  check_step(stated.parameters, options.step);
  const Source source{recording, *recording.table.find("time_s")};
  ReplayResult out;
  Replay replay{road, recording, options, source, stated, {}, {}, {}, {}};
  replay.commands = read_commands(source, options, replay.car, out.driven_by);
  replay.motion = {source.need("x_m"), source.need("y_m"), source.need("yaw_rad"),
                   source.need("vx_mps"), source.channel("z_m")};
  replay.states = recorded_states(source);
  if (options.driver) replay.engine_torque_nm = steady_engine(replay.car);
  ReplayErrors errors(source);
  for (const std::string& name : recording::telemetry_channels()) out.telemetry.add(name, {});
  out.telemetry.add("hold_n", {});
  out.telemetry.add("window", {});
  if (options.hold_speed && options.driver)
    throw Error("the driver holds the speed by his pedals; a push beside them tells nothing");

  Simulation<double> last{};  // temperatures and fuel go on from the window before
  RowWriter rows(source.time, options.step.step_s, errors, out);
  for (const Window& window : cut(recording, source.time, replay.motion.vx_mps, options, out)) {
    ++out.windows;
    const StartOptions begin = start_of(replay, window);
    Simulation<double> sim = start(replay.car, road, begin);
    if (out.windows > 1) {
      for (std::size_t i = 0; i < kStateSize; ++i)
        if (kStates[i].kept) sim.state[i] = last.state[i];
    }
    put_on(road, window.settle, replay.states, sim);
    errors.begin(window);
    const Simulation<double> before = sim;
    const std::size_t problems = out.problems.size();
    drive_window(replay, window, begin, rows, sim, out);
    // What a car that ran away has heated its tyres to is nothing to go on from.
    last = out.problems.size() == problems ? sim : before;
  }
  if (out.windows == 0)
    throw Error(fmt::format(
        "nothing to replay: in {} pieces the car stands, {} are shorter than {} s; give "
        "a recording of a longer drive without gaps",
        out.standing, out.too_short, options.settle_s + kShortest_s));
  out.errors = errors.finish();
  sum_up_push(out);
  return out;
}

std::string format_errors(const ReplayResult& result) {
  std::string out = "channel,samples,max,rmse,hold_max,hold_rmse,trend_max,trend_rmse\n";
  for (const ChannelError& e : result.errors)
    out += fmt::format("{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", e.channel, e.samples,
                       e.max, e.rmse, e.hold_max, e.hold_rmse, e.trend_max, e.trend_rmse);
  return out;
}

}  // namespace vehicle
