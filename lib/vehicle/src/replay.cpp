#include "vehicle/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "vehicle/error.h"
#include "vehicle/step_swing.h"
#include "vehicle/telemetry.h"

namespace vehicle {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<const char*, kWheels> kWheelNames{"fl", "fr", "rl", "rr"};
constexpr double kTrend_s = 0.2;
constexpr double kHold_1ps = 3.0;    ///< how fast the held car comes back to its recorded place
constexpr double kShortest_s = 0.1;  ///< of a window

/// A channel without empty cells; empty where it was not recorded.
using Channel = std::vector<double>;

double at(const Channel& channel, const std::vector<double>& time, std::size_t row, double t) {
  const double share = std::clamp((t - time[row]) / (time[row + 1] - time[row]), 0.0, 1.0);
  return channel[row] + share * (channel[row + 1] - channel[row]);
}

/// What the recording asks of the car.
struct Commands {
  Channel steer_command_rad, throttle_command, gear, wake_x_m, wake_y_m;
  std::array<Channel, kWheels> brake_command_pa;
};

struct Source {
  const Recording& recording;
  const std::vector<double>& time;

  Channel channel(const std::string& name) const {
    const std::vector<double>* const values = recording.table.find(name);
    if (values == nullptr) return {};
    Channel filled = fill_gaps(time, *values);
    if (std::isnan(filled.front())) return {};
    return filled;
  }
  Channel need(const std::string& name) const {
    Channel values = channel(name);
    if (values.empty())
      throw Error(fmt::format("the recording has no channel {}; a replay needs it", name));
    return values;
  }
};

/// The commands, and the car without those actuators whose outcome was recorded.
Commands read_commands(const Source& source, const ReplayOptions& options, Car<double>& car,
                       std::vector<std::string>& said) {
  using P = Parameter;
  Commands out;
  const auto past = [&](Term term) { car.terms[term] = 0.0; };
  const auto scaled = [](Channel values, double factor) {
    for (double& value : values) value *= factor;
    return values;
  };
  out.wake_x_m = source.channel("wake_x_m");
  out.wake_y_m = source.channel("wake_y_m");
  if (options.driver) {
    said.emplace_back("the driver steers, accelerates, brakes and shifts along the recorded path");
    return out;
  }
  if (options.hold_speed)
    said.emplace_back("a push along the car holds its speed and place to the recording");
  out.steer_command_rad = source.channel("steer_command_rad");
  const char* const how = options.closed_path ? ", with what leads back to the recorded path" : "";
  if (!out.steer_command_rad.empty()) {
    said.push_back(std::string("steer_command_rad steers") + how);
  } else {
    out.steer_command_rad = scaled(source.channel("steer_rad"), car.parameters[P::steering_ratio]);
    past(Term::steering_actuator);
    past(Term::steering_friction);
    if (!out.steer_command_rad.empty())
      said.push_back(std::string("the measured steer_rad steers, past the steering actuator") +
                     how);
    else if (options.closed_path)
      said.emplace_back("no steering was recorded: the driver steers along the recorded path");
    else
      throw Error(
          "the recording has neither steer_command_rad nor steer_rad; let the driver close the "
          "path");
  }
  out.throttle_command = source.channel("throttle_command");
  if (!out.throttle_command.empty()) {
    said.emplace_back("throttle_command drives");
  } else {
    out.throttle_command =
        scaled(source.channel("throttle"), 1.0 / car.parameters[P::throttle_gain]);
    if (out.throttle_command.empty())
      throw Error("the recording has neither throttle_command nor throttle; a replay needs one");
    past(Term::throttle_actuator);
    said.emplace_back("the measured throttle drives, past the throttle actuator");
  }
  const auto all_wheels = [&](const std::string& before, const std::string& after) {
    bool found = false;
    for (std::size_t i = 0; i < kWheels; ++i) {
      out.brake_command_pa[i] =
          source.channel(fmt::format("{}{}{}", before, kWheelNames[i], after));
      found = found || !out.brake_command_pa[i].empty();
    }
    return found;
  };
  const auto one = [&](const char* name) {
    const Channel channel = source.channel(name);
    if (!channel.empty()) out.brake_command_pa.fill(channel);
    return !channel.empty();
  };
  if (all_wheels("brake_", "_command_pa")) {
    said.emplace_back("brake_.._command_pa brake each wheel");
  } else if (one("brake_command_pa")) {
    said.emplace_back("brake_command_pa brakes all wheels alike");
  } else if (all_wheels("brake_", "_pa") || one("brake_pa")) {
    for (Channel& channel : out.brake_command_pa)
      channel = scaled(channel, 1.0 / car.parameters[P::brake_gain]);
    past(Term::brake_actuator);
    said.emplace_back("the measured brake pressures brake, past the brake actuators");
  } else {
    said.emplace_back("no brake was recorded: it stays open");
  }
  if (const std::vector<double>* const gear = source.recording.table.find("gear")) {
    out.gear = source.channel("gear");
    // While a shift was measured as neutral, the command already is the next gear.
    double next = out.gear.empty() ? 0.0 : out.gear.back(), since = 0.0;
    for (std::size_t i = out.gear.size(); i-- > 0;) {
      out.gear[i] = std::round(std::isfinite((*gear)[i]) ? (*gear)[i] : next);
      if (out.gear[i] != 0.0) {
        next = out.gear[i];
        since = source.time[i];
      } else if (since - source.time[i] < 1.0) {
        out.gear[i] = next;
      }
    }
  }
  said.emplace_back(out.gear.empty() ? "no gear was recorded: the car shifts by itself"
                                     : "gear shifts");
  return out;
}

/// The recorded path as a line to follow, a station every metre at least.
RacingLine recorded_line(const std::vector<double>& x, const std::vector<double>& y,
                         const std::vector<double>& speed, const Stretch& stretch) {
  RacingLine line;
  for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
    if (!line.x_m.empty()) {
      const double gone = std::hypot(x[i] - line.x_m.back(), y[i] - line.y_m.back());
      if (gone < 1.0) continue;
      line.length_m += gone;
    }
    line.x_m.push_back(x[i]);
    line.y_m.push_back(y[i]);
    line.s_m.push_back(line.length_m);
    line.speed_mps.push_back(speed[i]);
    line.grade.push_back(0.0);
  }
  return line;
}

/// The straight line through the samples of [row's time - kTrend_s, row's time]: value and slope.
std::pair<double, double> trend(const std::vector<double>& time, const Channel& channel,
                                std::size_t row, std::size_t first) {
  double n = 0.0, st = 0.0, sv = 0.0, stt = 0.0, stv = 0.0;
  for (std::size_t i = row + 1; i-- > first && time[row] - time[i] <= kTrend_s + 1e-9;) {
    const double t = time[i] - time[row];
    n += 1.0;
    st += t;
    sv += channel[i];
    stt += t * t;
    stv += t * channel[i];
  }
  const double spread = n * stt - st * st;
  if (n < 2.0 || spread <= 0.0) return {channel[row], 0.0};
  const double slope = (n * stv - st * sv) / spread;
  return {(sv - slope * st) / n, slope};
}

/// Part of the recording that is driven in one go.
struct Window {
  std::size_t stretch_begin, settle, first, end;  ///< rows; [settle, first) is not judged
};

/// Errors of the car and of the trivial predictors in one channel, summed over all windows.
struct Sums {
  std::size_t samples = 0;
  std::array<double, 3> max{}, squares{};

  void add(double car, double hold, double trended) {
    ++samples;
    const std::array<double, 3> errors{car, hold, trended};
    for (std::size_t k = 0; k < 3; ++k) {
      max[k] = std::max(max[k], std::abs(errors[k]));
      squares[k] += errors[k] * errors[k];
    }
  }
  ChannelError finish(const std::string& channel) const {
    const auto rmse = [&](std::size_t k) {
      return std::sqrt(squares[k] / static_cast<double>(std::max<std::size_t>(1, samples)));
    };
    return {channel, samples, max[0], rmse(0), max[1], rmse(1), max[2], rmse(2)};
  }
};

/// Every telemetry channel that was measured and is no command, and the place.
class Comparison {
 public:
  explicit Comparison(const Source& source) : source_(source) {
    const auto& names = telemetry_channels();
    for (std::size_t c = 0; c < names.size(); ++c) {
      const std::string& name = names[c];
      if (name == "time_s" || name == "gear" || name == "u_m" || name == "v_m" ||
          name.find("command") != std::string::npos)
        continue;
      Channel filled = source.channel(name);
      if (filled.empty()) continue;
      if (name == "x_m") x_ = channels_.size();
      if (name == "y_m") y_ = channels_.size();
      if (name == "yaw_rad") yaw_ = channels_.size();
      channels_.push_back({c, source.recording.table.find(name), std::move(filled), {}, {}});
    }
  }

  void begin(const Window& window) {
    first_ = window.first;
    for (One& one : channels_)
      one.trend = trend(source_.time, one.filled, window.first, window.stretch_begin);
  }

  /// A simulated row of telemetry against recorded row `row` of the window.
  void add(std::size_t row, const std::vector<double>& values) {
    if (row == first_) return;  // put there
    const double ahead_s = source_.time[row] - source_.time[first_];
    const auto held = [&](const One& one) { return one.filled[first_]; };
    const auto trended = [&](const One& one) {
      return one.trend.first + ahead_s * one.trend.second;
    };
    for (One& one : channels_) {
      const double truth = (*one.raw)[row];
      if (std::isfinite(truth))
        one.sums.add(values[one.column] - truth, held(one) - truth, trended(one) - truth);
    }
    const One &x = channels_[x_], &y = channels_[y_], &yaw = channels_[yaw_];
    const double cy = std::cos(yaw.filled[row]), sy = std::sin(yaw.filled[row]);
    const auto along = [&](double px, double py) {
      return cy * (px - x.filled[row]) + sy * (py - y.filled[row]);
    };
    const auto lateral = [&](double px, double py) {
      return -sy * (px - x.filled[row]) + cy * (py - y.filled[row]);
    };
    const double px = values[x.column], py = values[y.column];
    place_[0].add(along(px, py), along(held(x), held(y)), along(trended(x), trended(y)));
    place_[1].add(lateral(px, py), lateral(held(x), held(y)), lateral(trended(x), trended(y)));
  }

  std::vector<ChannelError> finish() const {
    std::vector<ChannelError> out{place_[0].finish("along_m"), place_[1].finish("lateral_m")};
    for (const One& one : channels_)
      out.push_back(one.sums.finish(telemetry_channels()[one.column]));
    return out;
  }

 private:
  struct One {
    std::size_t column;
    const std::vector<double>* raw;
    Channel filled;
    Sums sums;
    std::pair<double, double> trend;
  };
  const Source& source_;
  std::vector<One> channels_;
  std::size_t x_ = 0, y_ = 0, yaw_ = 0, first_ = 0;
  std::array<Sums, 2> place_;
};

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

/// The row past the stretch that the window lies in.
std::size_t stretch_end(const Recording& recording, const Window& window) {
  for (const Stretch& stretch : recording.stretches)
    if (stretch.begin == window.stretch_begin) return stretch.end;
  return window.end;
}

/// Cuts the recording into windows; counts what cannot be one.
std::vector<Window> cut(const Recording& recording, const std::vector<double>& time,
                        const Channel& vx_mps, const ReplayOptions& options, ReplayResult& out) {
  std::vector<Window> windows;
  for (const Stretch& stretch : recording.stretches) {
    const auto row_at = [&](double t) {
      const auto from = time.begin() + static_cast<std::ptrdiff_t>(stretch.begin);
      const auto to = time.begin() + static_cast<std::ptrdiff_t>(stretch.end);
      return static_cast<std::size_t>(std::lower_bound(from, to, t - 1e-9) - time.begin());
    };
    const double end_s = time[stretch.end - 1];
    double begin_s = time[stretch.begin] + options.settle_s;
    if (begin_s + kShortest_s > end_s) ++out.too_short;
    while (begin_s + kShortest_s <= end_s) {
      Window window{};
      window.stretch_begin = stretch.begin;
      window.first = row_at(begin_s);
      window.settle = row_at(time[window.first] - options.settle_s);
      begin_s = options.window_s > 0.0 ? time[window.first] + options.window_s : end_s;
      window.end = std::min(stretch.end, row_at(begin_s) + 1);
      double fastest = 0.0;
      for (std::size_t i = window.first; i < window.end; ++i)
        fastest = std::max(fastest, std::abs(vx_mps[i]));
      if (fastest < 1.0)
        ++out.standing;
      else
        windows.push_back(window);
    }
  }
  return windows;
}

/// What the recording, or the driver, asks at time t; `row` is the recorded row before t.
Controls<double> controls_at(const Commands& commands, const std::vector<double>& time,
                             std::size_t row, double t, const Car<double>& car, double vx_mps,
                             int& gear) {
  Controls<double> c;
  if (!commands.steer_command_rad.empty())
    c.steer_command_rad = at(commands.steer_command_rad, time, row, t);
  if (!commands.throttle_command.empty())
    c.throttle_command = std::clamp(at(commands.throttle_command, time, row, t), 0.0, 1.0);
  for (std::size_t i = 0; i < kWheels; ++i)
    if (!commands.brake_command_pa[i].empty())
      c.brake_command_pa[i] = std::max(0.0, at(commands.brake_command_pa[i], time, row, t));
  gear = commands.gear.empty() ? choose_gear(car, vx_mps, gear)
                               : std::clamp(static_cast<int>(commands.gear[row]), -1, 6);
  c.gear_command = gear;
  c.opponent = !commands.wake_x_m.empty() && !commands.wake_y_m.empty();
  if (c.opponent) {
    c.wake_x_m = at(commands.wake_x_m, time, row, t);
    c.wake_y_m = at(commands.wake_y_m, time, row, t);
  }
  return c;
}

/// The recorded steering at the recorded place nearest to the car, and what leads back to the path:
/// the arc that takes away the offset of a point ahead.
struct PathKeeper {
  const Channel &x_m, &y_m, &yaw_rad, &steer_rad;
  std::size_t row, end;

  double steer(const Car<double>& car, const State<double>& s, const DriverOptions& options) {
    const auto away = [&](std::size_t i) { return std::hypot(x_m[i] - s[kX], y_m[i] - s[kY]); };
    while (row + 1 < end && away(row + 1) <= away(row)) ++row;
    const double cy = std::cos(yaw_rad[row]), sy = std::sin(yaw_rad[row]);
    const double offset_m = -sy * (s[kX] - x_m[row]) + cy * (s[kY] - y_m[row]);
    const double ahead_m = options.preview_m + options.preview_s * std::max(0.0, s[kVx]);
    const double arc_1pm =
        -2.0 * (offset_m + ahead_m * (s[kYaw] - yaw_rad[row])) / (ahead_m * ahead_m);
    return steer_rad[row] + car.parameters[Parameter::steering_ratio] * arc_1pm *
                                car.parameters[Parameter::chassis_wheelbase_m];
  }
};

/// The driver who steers along the line, where the window begins.
Driver driver_at(const RacingLine& line, double x_m, double y_m, int gear,
                 const DriverOptions& options) {
  Driver driver;
  driver.options = options;
  driver.gear = std::max(1, gear);
  double best = 1e300;
  for (std::size_t i = 0; i < line.x_m.size(); ++i) {
    const double away = std::hypot(line.x_m[i] - x_m, line.y_m[i] - y_m);
    if (away >= best) continue;
    best = away;
    driver.station = i;
    driver.s_m = line.s_m[i];
  }
  return driver;
}

}  // namespace

ReplayResult replay(const Car<double>& stated, const Road& road, const Recording& recording,
                    const ReplayOptions& options) {
  check_step(stated.parameters, options.step);
  const Source source{recording, *recording.table.find("time_s")};
  const std::vector<double>& time = source.time;
  Car<double> car = stated;
  ReplayResult out;
  const Commands commands = read_commands(source, options, car, out.driven_by);
  const Channel x_m = source.need("x_m"), y_m = source.need("y_m"),
                yaw_rad = source.need("yaw_rad"), vx_mps = source.need("vx_mps"),
                z_m = source.channel("z_m");
  const RecordedStates states = recorded_states(source);
  Comparison comparison(source);
  const auto& names = telemetry_channels();
  for (const std::string& name : names) out.telemetry.add(name, {});
  out.telemetry.add("hold_n", {});
  out.telemetry.add("window", {});
  if (options.hold_speed && options.driver)
    throw Error("the driver holds the speed by his pedals; a push beside them tells nothing");

  const double h = options.step.step_s;
  Simulation<double> last{};  // temperatures and fuel go on from the window before
  std::vector<double> now(names.size()), before(names.size()), between(names.size());
  for (const Window& window : cut(recording, time, vx_mps, options, out)) {
    ++out.windows;
    StartOptions begin;
    begin.x_m = x_m[window.settle];
    begin.y_m = y_m[window.settle];
    begin.z_near_m = z_m.empty() ? kNaN : z_m[window.settle];
    begin.yaw_rad = yaw_rad[window.settle];
    begin.speed_mps = std::max(0.0, vx_mps[window.settle]);
    begin.gear = commands.gear.empty()
                     ? choose_gear(car, begin.speed_mps, 6)
                     : std::clamp(static_cast<int>(commands.gear[window.settle]), -1, 6);
    begin.fuel_kg = options.fuel_kg;
    begin.tyre_k = options.tyre_k;
    begin.disc_k = options.disc_k;
    Simulation<double> sim = start(car, road, begin);
    if (out.windows > 1) {
      for (std::size_t i = 0; i < kStateSize; ++i)
        if (kStates[i].kept) sim.state[i] = last.state[i];
    }
    put_on(road, window.settle, states, sim);
    comparison.begin(window);
    RacingLine line;
    if (options.driver || (options.closed_path && commands.steer_command_rad.empty()))
      line =
          recorded_line(x_m, y_m, vx_mps, {window.stretch_begin, stretch_end(recording, window)});
    PathKeeper keeper{x_m,           y_m,
                      yaw_rad,       commands.steer_command_rad,
                      window.settle, stretch_end(recording, window)};
    Driver driver = driver_at(line, begin.x_m, begin.y_m, begin.gear, options.driver_options);
    Detail<double> detail{};
    std::optional<RoadTracker> tracker;
    if (road.surface() != nullptr) tracker.emplace(*road.surface());
    int gear = begin.gear;
    std::size_t next = window.first, row = window.settle;
    bool settled = false, have_before = false;
    StepSwing swing;
    for (std::int64_t n = 0; next < window.end; ++n) {
      if (options.progress && n % 4096 == 0)
        options.progress("replay", static_cast<double>(next) / static_cast<double>(time.size()));
      const double t = time[window.settle] + static_cast<double>(n) * h;
      while (row + 2 < time.size() && time[row + 1] <= t) ++row;
      if (!settled && t >= time[window.first] - 0.5 * h) {
        put_on(road, window.first, states, sim);
        settled = true;
      }
      const State<double> state = sim.state;
      Controls<double> c = controls_at(commands, time, row, t, car, state[kVx], gear);
      if (options.driver) {
        const Controls<double> driven = drive(driver, line, car, state, detail);
        c.steer_command_rad = driven.steer_command_rad;
        c.throttle_command = driven.throttle_command;
        c.brake_command_pa = driven.brake_command_pa;
        c.gear_command = gear = driven.gear_command;
      } else if (options.closed_path) {
        c.steer_command_rad = commands.steer_command_rad.empty()
                                  ? drive(driver, line, car, state, detail).steer_command_rad
                                  : keeper.steer(car, state, options.driver_options);
      }
      if (options.hold_speed) {
        // Critically damped on the distance to the recorded place, seen along the recorded heading.
        const double cy = std::cos(yaw_rad[row]), sy = std::sin(yaw_rad[row]);
        const double behind_m =
            cy * (at(x_m, time, row, t) - state[kX]) + sy * (at(y_m, time, row, t) - state[kY]);
        const double slower_mps = at(vx_mps, time, row, t) - state[kVx];
        c.hold_n = (car.parameters[Parameter::chassis_mass_kg] + state[kFuel]) * kHold_1ps *
                   (2.0 * slower_mps + kHold_1ps * behind_m);
      }
      const StepResult result = step(car, sim, c, road, options.step, detail);
      if (!result.ok()) {
        const RoadPoint& under = detail.wheel[0].road;
        out.problems.push_back(
            fmt::format("window {}: {}", out.windows,
                        describe(result, t - time.front(), under.u_m, under.v_m)));
        break;
      }
      swing.look(car, state, detail);
      // A recorded row lies between two steps: both are written down, the row on their line.
      if (!settled || time[next] > t + 1.5 * h) {
        have_before = false;
        continue;
      }
      crg::UV place{state[kX], state[kY]};
      if (tracker)
        place = tracker->at(state[kX], state[kY],
                            state[kZ] - car.parameters[Parameter::chassis_cog_height_m]);
      fill_telemetry(t, state, detail, c, place.u_m, place.v_m, now);
      for (; next < window.end && time[next] <= t + 1e-9; ++next) {
        between = now;
        if (have_before)
          for (std::size_t i = 0; i < names.size(); ++i)
            if (names[i] != "u_m" && names[i] != "gear")  // both may jump
              between[i] = before[i] + (time[next] - t + h) / h * (now[i] - before[i]);
        between[0] = time[next];
        for (std::size_t i = 0; i < names.size(); ++i)
          out.telemetry.columns[i].push_back(between[i]);
        out.telemetry.columns[names.size()].push_back(c.hold_n);
        out.telemetry.columns.back().push_back(static_cast<double>(out.windows));
        comparison.add(next, between);
      }
      before = now;
      have_before = true;
    }
    last = sim;
    if (swing.largest() > out.step_swing) {
      out.step_swing = swing.largest();
      out.swing_warning = swing.warning(options.step);
    }
  }
  if (out.windows == 0)
    throw Error(
        fmt::format("nothing to replay: {} windows standing, {} stretches shorter than {} s",
                    out.standing, out.too_short, options.settle_s + kShortest_s));
  out.errors = comparison.finish();
  const std::vector<double>& hold_n = *out.telemetry.find("hold_n");
  for (const double push_n : hold_n) {
    out.hold_mean_n += push_n;
    out.hold_rms_n += push_n * push_n;
    out.hold_most_n = std::max(out.hold_most_n, std::abs(push_n));
  }
  const auto rows = static_cast<double>(std::max<std::size_t>(1, hold_n.size()));
  out.hold_mean_n /= rows;
  out.hold_rms_n = std::sqrt(out.hold_rms_n / rows);
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
