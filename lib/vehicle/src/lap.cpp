#include "vehicle/lap.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "vehicle/error.h"
#include "vehicle/step_swing.h"
#include "vehicle/work.h"

namespace vehicle {
namespace {

void add(Powers<double>& sum, const Powers<double>& work) {
  for (const auto member :
       {&Powers<double>::tyre_normal, &Powers<double>::tyre_x, &Powers<double>::tyre_y,
        &Powers<double>::tyre_moment, &Powers<double>::drag, &Powers<double>::downforce,
        &Powers<double>::side, &Powers<double>::damper, &Powers<double>::brake,
        &Powers<double>::engine, &Powers<double>::driveline, &Powers<double>::clutch,
        &Powers<double>::fuel, &Powers<double>::hold, &Powers<double>::unfelt,
        &Powers<double>::turbo})
    sum.*member += work.*member;
}

constexpr double kNoWake = std::numeric_limits<double>::quiet_NaN();

/// Half the strip of road that a wheel looks at, and reserve.
constexpr double kBesideWheel_m = 0.5;

/// The line to drive; throws Error where the road has none for so many laps.
RacingLine line_for(const crg::Surface& surface, const LapOptions& options) {
  RacingLine line = plan_line(surface, options.line);
  if (!line.closed && options.laps > 1)
    throw Error(fmt::format(
        "{} laps of an open road, whose end is {:.0f} m from its begin; wanted one, or a closed "
        "road",
        options.laps,
        std::hypot(line.x_m.back() - line.x_m.front(), line.y_m.back() - line.y_m.front())));
  return line;
}

/// How far the car reaches before and behind its centre of gravity, what its wheels look at
/// included.
double nose_of(const Car<double>& car) {
  return car.parameters[Parameter::chassis_cog_behind_front_m] + kBesideWheel_m;
}
double tail_of(const Car<double>& car) {
  return car.parameters[Parameter::chassis_wheelbase_m] + 2.0 * kBesideWheel_m - nose_of(car);
}

/// Where the car stands first: the station before it, and the rest. On an open road all four wheels
/// stand on it: the car begins by its tail behind the road's begin.
struct Begin {
  std::size_t station = 0;
  StartOptions start;
};

Begin begin_on(const RacingLine& line, const crg::Surface& surface, const Car<double>& car,
               const LapOptions& options) {
  Begin out;
  std::size_t& first = out.station;
  double ahead_m = line.closed ? 0.0 : tail_of(car);
  while (first + 2 < line.s_m.size() && line.s_m[first + 1] <= ahead_m) ++first;
  ahead_m -= line.s_m[first];
  const std::size_t next = (first + 1) % line.x_m.size();
  const double heading_rad =
      line.closed ? line.heading_rad[0]
                  : std::atan2(line.y_m[next] - line.y_m[first], line.x_m[next] - line.x_m[first]);
  StartOptions& begin = out.start;
  begin.x_m = line.x_m[first] + ahead_m * std::cos(heading_rad);
  begin.y_m = line.y_m[first] + ahead_m * std::sin(heading_rad);
  begin.z_near_m =
      surface.z_at_uv(line.u_begin_m + line.u_step_m * static_cast<double>(first), line.v_m[first]);
  begin.yaw_rad = heading_rad;
  begin.speed_mps = options.standing ? 0.0 : line.speed_mps[first];
  begin.gear = choose_gear(car, begin.speed_mps, 6);
  begin.fuel_kg = options.fuel_kg;
  begin.tyre_k = options.tyre_k;
  begin.disc_k = options.disc_k;
  return out;
}

Driver driver_on(const RacingLine& line, const Begin& begin, const LapOptions& options) {
  Driver driver;
  driver.options = options.driver;
  driver.gear = begin.start.gear;
  driver.station = begin.station;
  driver.s_m = line.s_m[begin.station];
  return driver;
}

/// Where the wake of another car lay, for every row that was recorded.
struct WakeColumns {
  std::vector<double> x_m, y_m;

  void note(const Controls<double>& controls) {
    x_m.push_back(controls.opponent ? controls.wake_x_m : kNoWake);
    y_m.push_back(controls.opponent ? controls.wake_y_m : kNoWake);
  }
  void add_to(LapResult& out) {
    out.telemetry.add("wake_x_m", std::move(x_m));
    out.telemetry.add("wake_y_m", std::move(y_m));
  }
};

void feel_wake(const std::optional<Wake>& wake, Controls<double>& controls) {
  if (!wake) return;
  controls.opponent = true;
  controls.wake_x_m = wake->x_m;
  controls.wake_y_m = wake->y_m;
}

/// Distance of the car from the segment of the line that the driver is on.
double off_line_m(const RacingLine& line, std::size_t station, const State<double>& state) {
  const std::size_t i = station, j = (i + 1) % line.x_m.size();
  const double dx = line.x_m[j] - line.x_m[i], dy = line.y_m[j] - line.y_m[i];
  return std::abs((state[kX] - line.x_m[i]) * dy - (state[kY] - line.y_m[i]) * dx) /
         std::max(1e-9, std::hypot(dx, dy));
}

/// How near the wheels came to the road's edges, and whether one left it.
void note_wheels(const Detail<double>& detail, const std::vector<double>& v_m, LapResult& out) {
  bool off = false;
  for (const WheelDetail<double>& wheel : detail.wheel) {
    off = off || !wheel.road.on_road;
    out.least_edge_m =
        std::min({out.least_edge_m, wheel.road.v_m - v_m.front(), v_m.back() - wheel.road.v_m});
  }
  if (off) ++out.steps_off_road;
}

/// Knows when the car goes over the line.
class LapClock {
 public:
  LapClock(const RacingLine& line, double step_s, double nose_m)
      : line_(line), step_s_(step_s), nose_m_(nose_m) {}

  double lap_begin_s() const { return lap_begin_s_; }

  /// The time of a lap that ends with this step; nothing while it goes on.
  std::optional<double> look(const Driver& driver, double time_s) {
    const double place_s = driver.s_m;
    half_round_ = half_round_ || std::abs(place_s - 0.5 * line_.length_m) < 0.1 * line_.length_m;
    // Over the line: his place jumped back by about a lap.
    const bool over =
        line_.closed ? half_round_ && place_s < last_s_m_ - 0.5 * line_.length_m
                     : driver.station + 3 >= line_.s_m.size() || line_.length_m - place_s < nose_m_;
    std::optional<double> lap_s;
    if (over) {
      const double gone = line_.closed ? place_s + line_.length_m - last_s_m_ : 1.0;
      const double share = line_.closed && gone > 0.0 ? (line_.length_m - last_s_m_) / gone : 0.0;
      const double crossed_s = time_s - step_s_ * (1.0 - share);
      lap_s = crossed_s - lap_begin_s_;
      lap_begin_s_ = crossed_s;
      half_round_ = false;
    }
    last_s_m_ = place_s;
    return lap_s;
  }

 private:
  const RacingLine& line_;
  double step_s_, nose_m_;
  double lap_begin_s_ = 0.0, last_s_m_ = 0.0;
  bool half_round_ = false;  // the start lies on the line: a lap counts once the far side was seen
};

/// The plan of the next lap, with what the tyres have become.
void plan_next(const Car<double>& car, const State<double>& state, SpeedOptions& plan,
               RacingLine& line) {
  double coldest = state[kTyre];
  for (std::size_t k = 1; k < kWheels; ++k) coldest = std::min(coldest, state[kTyre + k]);
  plan.tyre_k = coldest;
  plan.fuel_kg = state[kFuel];
  plan.standing_start = false;
  plan_speed(line, car, plan);
}

}  // namespace

LapResult drive_laps(const Car<double>& car, const Road& road, const LapOptions& options) {
  if (road.surface() == nullptr) throw Error("a lap needs a CRG road");
  check_step(car.parameters, options.step);
  const crg::Surface& surface = *road.surface();
  if (options.progress) options.progress("racing line", 0.0);
  RacingLine line = line_for(surface, options);
  SpeedOptions plan = options.speed;
  plan.tyre_k = options.tyre_k;
  plan.fuel_kg = options.fuel_kg;
  plan.standing_start = options.standing;
  plan_speed(line, car, plan);

  const Begin begin = begin_on(line, surface, car, options);
  Simulation<double> sim = start(car, road, begin.start);
  Driver driver = driver_on(line, begin, options);

  LapResult out;
  const auto& v_m = surface.file().grid.v_m;
  out.least_edge_m = v_m.back() - v_m.front();
  RunRecorder recorder(options.devices, options.record_every, options.step.step_s, options.on_row);
  Detail<double> detail{};
  WakeColumns wakes;
  StepSwing swing;
  RoadTracker tracker(surface);
  const double energy_begin = energy(car, sim.state);
  LapClock clock(line, options.step.step_s, nose_of(car));
  const int laps = line.closed ? options.laps : 1;
  while (static_cast<int>(out.lap_s.size()) < laps) {
    const State<double> before = sim.state;
    const double time_s = sim.time_s;
    Controls<double> controls = drive(driver, line, car, sim.state, detail);
    feel_wake(nearest_wake(options.opponents, time_s, sim.state), controls);
    const StepResult result = step(car, sim, controls, road, options.step, detail);
    ++out.steps;
    const RoadPoint& under = detail.wheel[0].road;
    if (!result.ok()) {
      out.problem = describe(result, time_s, under.u_m, under.v_m);
      break;
    }
    add(out.energy_j, work_of_step(car, before, sim.state, detail, options.step));
    swing.look(car, before, detail);
    note_wheels(detail, v_m, out);
    out.top_mps = std::max(out.top_mps, before[kVx]);
    const double away = off_line_m(line, driver.station, before);
    out.furthest_off_line_m = std::max(out.furthest_off_line_m, away);
    if (recorder.wants_step()) {
      const crg::UV place = tracker.at(
          before[kX], before[kY], before[kZ] - car.parameters[Parameter::chassis_cog_height_m]);
      wakes.note(controls);
      recorder.record(time_s, before, detail, controls, place.u_m, place.v_m);
    }
    if (away > 30.0) {
      out.problem = fmt::format("the car left the line by 30 m at t = {:.2f} s, u = {:.1f} m",
                                time_s, under.u_m);
      break;
    }
    if (const std::optional<double> lap_s = clock.look(driver, time_s)) {
      out.lap_s.push_back(*lap_s);
      if (static_cast<int>(out.lap_s.size()) < laps) plan_next(car, sim.state, plan, line);
    }
    if (options.progress && out.steps % 4096 == 0)
      options.progress(fmt::format("lap {} of {}", out.lap_s.size() + 1, laps),
                       (static_cast<double>(out.lap_s.size()) + driver.s_m / line.length_m) / laps);
    if (time_s - clock.lap_begin_s() > options.longest_s) {
      out.problem =
          fmt::format("no lap within {:.0f} s; the car is at u = {:.1f} m with {:.2f} m/s",
                      options.longest_s, under.u_m, before[kVx]);
      break;
    }
  }
  out.step_swing = swing.largest();
  out.swing_warning = swing.warning(options.step);
  out.complete = static_cast<int>(out.lap_s.size()) == laps;
  out.energy_change_j = energy(car, sim.state) - energy_begin;
  out.telemetry = recorder.table();
  if (!options.opponents.empty() && options.devices == nullptr) wakes.add_to(out);
  return out;
}

}  // namespace vehicle
