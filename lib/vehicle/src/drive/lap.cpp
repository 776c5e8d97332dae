#include "vehicle/lap.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>

#include "off_line.h"
#include "vehicle/error.h"
#include "vehicle/laws/turbocharger.h"
#include "vehicle/laws/tyre_heat.h"
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
        &Powers<double>::turbo, &Powers<double>::ledge})
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
  double ahead_m = (line.closed ? 0.0 : tail_of(car)) + options.ahead_m;
  if (!(ahead_m >= 0.0 && ahead_m < 0.25 * line.length_m))
    throw Error(
        fmt::format("a car that begins {:g} m ahead; wanted 0 to {:.0f} m, a quarter of "
                    "the line",
                    options.ahead_m, 0.25 * line.length_m));
  while (first + 2 < line.s_m.size() && line.s_m[first + 1] <= ahead_m) ++first;
  ahead_m -= line.s_m[first];
  const std::size_t next = (first + 1) % line.x_m.size();
  const double heading_rad =
      line.closed ? line.heading_rad[first]
                  : std::atan2(line.y_m[next] - line.y_m[first], line.x_m[next] - line.x_m[first]);
  StartOptions& begin = out.start;
  begin.x_m = line.x_m[first] + ahead_m * std::cos(heading_rad);
  begin.y_m = line.y_m[first] + ahead_m * std::sin(heading_rad);
  begin.z_near_m =
      surface.z_at_uv(line.u_begin_m + line.u_step_m * static_cast<double>(first), line.v_m[first]);
  begin.yaw_rad = heading_rad;
  begin.speed_mps = options.standing ? 0.0 : line.speed_mps[first];
  begin.gear = choose_gear(car, begin.speed_mps, kMostGears);
  begin.fuel_kg = options.fuel_kg;
  begin.tyre_k = options.tyre_k;
  begin.disc_k = options.disc_k;
  return out;
}

Driver driver_on(const RacingLine& line, const Begin& begin, const LapOptions& options) {
  Driver driver;
  driver.options = options.driver;
  driver.options.step_s = options.step.step_s;
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

double coldest_k(const State<double>& state) {
  double coldest = state[kTyre];
  for (std::size_t k = 1; k < kWheels; ++k) coldest = std::min(coldest, state[kTyre + k]);
  return coldest;
}

/// Whether the coldest tyre grips by over 1 % less than the plan reckons with: on a road without
/// grip nothing keeps tyres warm.
bool grips_less(const Car<double>& car, const State<double>& state, const SpeedOptions& plan) {
  const auto grip = [&](double tyre_k) {
    return laws::tread_factors(car.parameters, car.files->tyre_grip, car.terms[Term::tyre_thermal],
                               tyre_k)
        .grip;
  };
  return grip(coldest_k(state)) < 0.99 * grip(plan.tyre_k);
}

/// The plan from here on, with what the tyres have become.
void plan_next(const Car<double>& car, const State<double>& state, SpeedOptions& plan,
               RacingLine& line) {
  plan.tyre_k = coldest_k(state);
  plan.fuel_kg = state[kFuel];
  plan.standing_start = false;
  plan_speed(line, car, plan);
}

/// A car under way: what it has, what it did.
class LapRun {
 public:
  LapRun(const Car<double>& car, const Road& road, const LapOptions& options, bool among_others)
      : tracker_(*road.surface()),
        car_(car),
        road_(road),
        options_(options),
        surface_(*road.surface()),
        line_(line_for(surface_, options)),
        plan_(options.speed),
        recorder_(options.devices, options.record_every, options.step.step_s, options.on_row),
        clock_(line_, options.step.step_s, nose_of(car)),
        laps_(line_.closed ? options.laps : 1),
        among_others_(among_others) {
    plan_.tyre_k = options.tyre_k;
    plan_.fuel_kg = options.fuel_kg;
    plan_.standing_start = options.standing;
    plan_speed(line_, car, plan_);
    const Begin begin = begin_on(line_, surface_, car, options);
    sim_ = start(car, road, begin.start);
    driver_ = driver_on(line_, begin, options);
    const auto& v_m = surface_.grid().v_m;
    out_.least_edge_m = v_m.back() - v_m.front();
    energy_begin_ = energy(car, sim_.state);
  }
  LapRun(const LapRun&) = delete;
  LapRun& operator=(const LapRun&) = delete;

  bool under_way() const {
    return out_.problem.empty() && static_cast<int>(out_.lap_s.size()) < laps_;
  }
  OpponentPlace place() const { return {sim_.state[kX], sim_.state[kY]}; }

  /// One step, with other cars where they are now.
  void advance(std::span<const OpponentPlace> others) {
    const State<double> before = sim_.state;
    const double time_s = sim_.time_s;
    Controls<double> controls = drive(driver_, line_, car_, sim_.state, detail_);
    feel_wake(nearest_wake(options_.opponents, time_s, others, sim_.state), controls);
    const StepResult result = step(car_, sim_, controls, road_, options_.step, detail_);
    ++out_.steps;
    const RoadPoint& under = detail_.wheel[0].road;
    if (!result.ok()) {
      out_.problem = describe(result, time_s, under.u_m, under.v_m);
      return;
    }
    add(out_.energy_j, work_of_step(car_, before, sim_.state, detail_, options_.step));
    swing_.look(car_, before, detail_);
    note(before, others);
    if (options_.on_step)
      options_.on_step({time_s, before, sim_.state, detail_, line_, driver_.station});
    if (recorder_.wants_step()) {
      const crg::UV place = tracker_.at(
          before[kX], before[kY], before[kZ] - car_.parameters[Parameter::chassis_cog_height_m]);
      wakes_.note(controls);
      recorder_.record(time_s, before, detail_, controls, place.u_m, place.v_m);
    }
    const double away_m = off_line_m(line_, driver_.station, before);
    off_line_.look(car_, before, detail_, away_m, time_s, options_.step.step_s, plan_.tyre_k);
    end_laps(time_s, away_m, before[kVx]);
  }

  /// What came of it.
  LapResult finish() {
    out_.step_swing = swing_.largest();
    out_.swing_warning = swing_.warning(options_.step);
    out_.limit = off_line_.limit();
    out_.ledge_warning = ledge_warning(sim_.discrete.ledges);
    out_.complete = static_cast<int>(out_.lap_s.size()) == laps_;
    out_.energy_change_j = energy(car_, sim_.state) - energy_begin_;
    out_.telemetry = recorder_.table();
    if ((among_others_ || !options_.opponents.empty()) && options_.devices == nullptr)
      wakes_.add_to(out_);
    return std::move(out_);
  }

 private:
  void note(const State<double>& before, std::span<const OpponentPlace> others) {
    note_wheels(detail_, surface_.grid().v_m, out_);
    out_.top_mps = std::max(out_.top_mps, before[kVx]);
    for (const OpponentPlace& other : others)
      out_.nearest_m =
          std::min(out_.nearest_m, std::hypot(other.x_m - before[kX], other.y_m - before[kY]));
    if (car_.files->turbo == Turbo::kFull &&
        laws::surges(car_.files->compressor_surge_kgps, detail_.turbo.compressor_kgps,
                     before[kCharge] / laws::air_pressure(car_.parameters)))
      out_.surge_s += options_.step.step_s;
  }

  void end_laps(double time_s, double away_m, double vx_mps) {
    out_.furthest_off_line_m = std::max(out_.furthest_off_line_m, away_m);
    const double u_m = detail_.wheel[0].road.u_m;
    if (away_m > 30.0) {
      out_.problem =
          fmt::format("the car left the line by 30 m at t = {:.2f} s, u = {:.1f} m", time_s, u_m);
      return;
    }
    if (const std::optional<double> lap_s = clock_.look(driver_, time_s)) {
      out_.lap_s.push_back(*lap_s);
      if (under_way()) plan_next(car_, sim_.state, plan_, line_);
    }
    constexpr std::size_t kEvery = 1024;  // steps between looks at the tyres
    if (under_way() && out_.steps % kEvery == 0 && grips_less(car_, sim_.state, plan_))
      plan_next(car_, sim_.state, plan_, line_);
    if (options_.progress && out_.steps % 4096 == 0)
      options_.progress(
          fmt::format("lap {} of {}", out_.lap_s.size() + 1, laps_),
          (static_cast<double>(out_.lap_s.size()) + driver_.s_m / line_.length_m) / laps_);
    if (time_s - clock_.lap_begin_s() > options_.longest_s)
      out_.problem =
          fmt::format("no lap within {:.0f} s; the car is at u = {:.1f} m with {:.2f} m/s",
                      options_.longest_s, u_m, vx_mps);
  }

  RoadTracker tracker_;
  Simulation<double> sim_{};
  const Car<double>& car_;
  const Road& road_;
  const LapOptions& options_;
  const crg::Surface& surface_;
  RacingLine line_;
  SpeedOptions plan_;
  RunRecorder recorder_;
  LapClock clock_;
  Driver driver_;
  Detail<double> detail_{};
  WakeColumns wakes_;
  StepSwing swing_;
  OffLine off_line_;
  double energy_begin_ = 0.0;
  LapResult out_;
  int laps_;
  bool among_others_;
};

}  // namespace

std::vector<LapResult> drive_together(std::span<const Entrant> cars, const Road& road) {
  if (road.surface() == nullptr) throw Error("a lap needs a CRG road");
  for (const Entrant& entrant : cars) {
    check_step(entrant.car->parameters, entrant.options.step);
    if (entrant.options.step.step_s != cars.front().options.step.step_s)
      throw Error(fmt::format("steps of {} and {} s in one run; wanted one step for all cars",
                              cars.front().options.step.step_s, entrant.options.step.step_s));
  }
  std::deque<LapRun> runs;
  for (const Entrant& entrant : cars) {
    if (entrant.options.progress) entrant.options.progress("racing line", 0.0);
    runs.emplace_back(*entrant.car, road, entrant.options, cars.size() > 1);
  }
  std::vector<std::vector<OpponentPlace>> others(runs.size());
  for (bool goes_on = true; goes_on;) {
    goes_on = false;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      others[i].clear();
      for (std::size_t k = 0; k < runs.size(); ++k)
        if (k != i && runs[k].under_way()) others[i].push_back(runs[k].place());
    }
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (!runs[i].under_way()) continue;
      runs[i].advance(others[i]);
      goes_on = true;
    }
  }
  std::vector<LapResult> out;
  out.reserve(runs.size());
  for (LapRun& run : runs) out.push_back(run.finish());
  return out;
}

LapResult drive_laps(const Car<double>& car, const Road& road, const LapOptions& options) {
  const Entrant alone{&car, options};
  return std::move(drive_together({&alone, 1}, road).front());
}

}  // namespace vehicle
