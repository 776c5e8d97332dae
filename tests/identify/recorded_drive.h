// A drive of the simulated car: what truly happened at every wheel, and what a race logger writes
// of it.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/random.h"
#include "identify/forces.h"
#include "recording/channels.h"
#include "recording/recording.h"
#include "vehicle/driver.h"
#include "vehicle/telemetry.h"

namespace test_drive {

/// Of a wheel: fx, fy, fz, kappa, alpha, camber, power lost at the tread.
using TrueWheel = std::array<double, 7>;

struct Drive {
  recording::Table telemetry;  ///< ideal
  std::vector<std::array<TrueWheel, vehicle::kWheels>> wheel;
};

/// Laps of the built-in driver, or until `longest_s`, in steps of `step_s`; a row every `every`
/// steps.
inline Drive drive_car(const vehicle::Car<double>& car, const vehicle::Road& road,
                       std::size_t every, int laps, double longest_s, double step_s = 0.001) {
  using namespace vehicle;  // NOLINT: names of one library
  StepOptions steps;
  steps.step_s = step_s;
  RacingLine line = plan_line(*road.surface());
  plan_speed(line, car, SpeedOptions{});
  const std::size_t first = line.closed ? 0 : 4;
  StartOptions begin;
  begin.x_m = line.x_m[first];
  begin.y_m = line.y_m[first];
  begin.yaw_rad = line.heading_rad[first];
  begin.z_near_m = road.surface()->z_at_uv(
      line.u_begin_m + line.u_step_m * static_cast<double>(first), line.v_m[first]);
  begin.speed_mps = line.speed_mps[first];
  begin.gear = choose_gear(car, begin.speed_mps, 6);
  Simulation<double> sim = start(car, road, begin);
  Driver driver;
  driver.gear = begin.gear;
  driver.station = first;
  driver.s_m = line.s_m[first];
  Detail<double> detail{};
  Drive out;
  for (const std::string& name : recording::telemetry_channels()) out.telemetry.add(name, {});
  std::vector<double> row(recording::telemetry_channels().size());
  double last_m = driver.s_m;
  for (std::size_t k = 0; sim.time_s < longest_s && laps > 0; ++k) {
    const Controls<double> controls = drive(driver, line, car, sim.state, detail);
    const State<double> before = sim.state;
    const double time_s = sim.time_s;
    const StepResult result = step(car, sim, controls, road, steps, detail);
    if (!result.ok()) throw std::runtime_error(describe(result, time_s, 0.0, 0.0));
    if (k % every == 0) {
      fill_telemetry(time_s, before, detail, controls, 0.0, 0.0, row);
      for (std::size_t i = 0; i < row.size(); ++i) out.telemetry.columns[i].push_back(row[i]);
      auto& wheels = out.wheel.emplace_back();
      for (std::size_t i = 0; i < kWheels; ++i) {
        const WheelDetail<double>& w = detail.wheel[i];
        wheels[i] = {w.fx_n,
                     w.fy_n,
                     w.fz_n,
                     w.kappa,
                     std::atan(w.tan_alpha),
                     w.camber_rad,
                     -w.fx_n * w.slip_x_mps - w.fy_n * w.slip_y_mps};
      }
    }
    if (line.closed && driver.s_m < last_m - 0.5 * line.length_m) --laps;
    if (!line.closed && driver.station + 8 >= line.s_m.size()) laps = 0;
    last_m = driver.s_m;
  }
  return out;
}

/// What a race logger writes: white noise on every channel, no temperatures, no height; loads where
/// its wheels have cells.
inline recording::Table logged(const Drive& drive, bool lateral_speed, std::uint64_t seed,
                               bool load_cells = false) {
  std::map<std::string, double> noise{
      {"x_m", 0.02},       {"y_m", 0.02},         {"yaw_rad", 0.002},
      {"vx_mps", 0.05},    {"vy_mps", 0.05},      {"roll_rate_radps", 0.005},
      {"ax_mps2", 0.2},    {"ay_mps2", 0.2},      {"pitch_rate_radps", 0.005},
      {"az_mps2", 0.3},    {"steer_rad", 0.0005}, {"yaw_rate_radps", 0.005},
      {"throttle", 0.005}, {"engine_radps", 1.0}};
  for (const std::string wheel : {"fl", "fr", "rl", "rr"}) {
    noise["wheel_" + wheel + "_radps"] = 0.1;
    noise["brake_" + wheel + "_pa"] = 3e4;
    noise["suspension_" + wheel + "_m"] = 3e-4;
    if (load_cells) noise["fz_" + wheel + "_n"] = 80.0;
  }
  if (!lateral_speed) noise.erase("vy_mps");
  recording::Table log;
  log.add("time_s", *drive.telemetry.find("time_s"));
  log.add("gear", *drive.telemetry.find("gear"));
  for (const auto& [channel, sd] : noise) {
    base::Random random = base::random_of(seed, channel);
    std::vector<double> values = *drive.telemetry.find(channel);
    for (double& v : values) v += sd * random.normal();
    log.add(channel, std::move(values));
  }
  return log;
}

/// How an estimate compares with the truth.
struct Comparison {
  double rmse = 0.0, peak = 0.0, inside = 0.0;  ///< inside: share of rows in the 90 % interval
  std::size_t rows = 0;
};

template <class Truth>
Comparison compare(const identify::Estimated& e, std::size_t rows, const Truth& truth) {
  Comparison out;
  double square = 0.0, inside = 0.0;
  for (std::size_t k = 0; k < rows; ++k) {
    if (!std::isfinite(e.value[k])) continue;
    const double is = truth(k), off = e.value[k] - is;
    square += off * off;
    out.peak = std::max(out.peak, std::abs(is));
    inside += std::abs(off) < 1.645 * e.sd[k] ? 1.0 : 0.0;
    ++out.rows;
  }
  out.rmse = std::sqrt(square / static_cast<double>(out.rows));
  out.inside = inside / static_cast<double>(out.rows);
  return out;
}

}  // namespace test_drive
