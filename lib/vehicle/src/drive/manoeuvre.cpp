#include "vehicle/manoeuvre.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "vehicle/driver.h"
#include "vehicle/error.h"
#include "vehicle/step_swing.h"

namespace vehicle {
namespace {

constexpr double kFeature_m = 60.0;  ///< where kerb, bump begin
constexpr std::pair<std::string_view, ManoeuvreKind> kNames[] = {
    {"step-steer", ManoeuvreKind::kStepSteer},
    {"sine", ManoeuvreKind::kSine},
    {"chirp", ManoeuvreKind::kChirp},
    {"ramp", ManoeuvreKind::kRamp},
    {"braking", ManoeuvreKind::kBraking},
    {"coast-down", ManoeuvreKind::kCoastDown},
    {"kerb", ManoeuvreKind::kKerb},
    {"bump", ManoeuvreKind::kBump},
    {"split-friction", ManoeuvreKind::kSplitFriction},
    {"reverse", ManoeuvreKind::kReverse}};

/// A straight road along x, 12 m wide, heights (or grip) from a formula of u and v.
crg::Crg straight(double length_m, double step_m, const std::function<double(double, double)>& z) {
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = step_m;
  const auto rows = static_cast<int>(std::lround(length_m / step_m)) + 1;
  for (int j = -60; j <= 60; ++j) grid.v_m.push_back(0.1 * j);
  for (int i = 0; i < rows; ++i) {
    line.x_m.push_back(step_m * i);
    line.y_m.push_back(0.0);
    line.heading_rad.push_back(0.0);
    for (const double v : grid.v_m) grid.z_m.push_back(static_cast<float>(z(step_m * i, v)));
  }
  return crg::make_crg(line, std::move(grid));
}

std::optional<crg::Surface> surface_for(const Manoeuvre& m) {
  const auto wave = [&](double u, double begin, double length, int waves) {
    if (u < begin || u > begin + length * waves) return 0.0;
    return m.height_m * 0.5 * (1.0 - std::cos(2.0 * std::numbers::pi * (u - begin) / length));
  };
  const double length_m = std::max(200.0, 50.0 + m.speed_mps * m.duration_s);
  switch (m.kind) {
    case ManoeuvreKind::kKerb:
      return crg::Surface(straight(length_m, 0.05, [&](double u, double v) {
        return v > 0.3 ? wave(u, kFeature_m, 0.4, 15) : 0.0;
      }));
    case ManoeuvreKind::kBump:
      return crg::Surface(
          straight(length_m, 0.05, [&](double u, double) { return wave(u, kFeature_m, 1.0, 1); }));
    case ManoeuvreKind::kSplitFriction: {
      crg::SurfaceOptions options;
      options.friction_map =
          straight(length_m, 0.5, [&](double, double v) { return v > 0.0 ? m.low_grip : 1.0; });
      return crg::Surface(straight(length_m, 0.5, [](double, double) { return 0.0; }), options);
    }
    default:
      return std::nullopt;
  }
}

using Kind = ManoeuvreKind;

constexpr double kBegin_s = 1.0;  ///< of what the manoeuvre is about

bool brakes(const Manoeuvre& m) {
  return m.kind == Kind::kBraking || m.kind == Kind::kSplitFriction;
}

bool in_neutral(const Manoeuvre& m) {
  return m.kind == Kind::kCoastDown || m.kind == Kind::kKerb || m.kind == Kind::kBump || brakes(m);
}

/// Of the front wheels, `since` the manoeuvre began.
double steer_at(const Manoeuvre& m, double since) {
  if (since < 0.0) return 0.0;
  const double whole = std::max(1e-9, m.duration_s - kBegin_s);
  if (m.kind == Kind::kStepSteer) return m.steer_rad;
  if (m.kind == Kind::kSine)
    return m.steer_rad * std::sin(2.0 * std::numbers::pi * m.frequency_hz * since);
  if (m.kind == Kind::kChirp) {
    constexpr double kLow_hz = 0.2, kHigh_hz = 4.0;
    return m.steer_rad * std::sin(2.0 * std::numbers::pi *
                                  (kLow_hz + 0.5 * (kHigh_hz - kLow_hz) * since / whole) * since);
  }
  if (m.kind == Kind::kRamp) return m.steer_rad * since / whole;
  return 0.0;
}

/// What is asked of the car at time t, in the state `before` the step.
Controls<double> controls_at(const Car<double>& car, const Manoeuvre& m, double t, int gear,
                             const State<double>& before) {
  const bool backward = m.kind == Kind::kReverse;
  Controls<double> c;
  c.gear_command = gear;
  if (!in_neutral(m))
    c.throttle_command =
        std::clamp(0.25 + 0.25 * (m.speed_mps - (backward ? -before[kVx] : before[kVx])), 0.0, 1.0);
  const auto command = [&](double road_wheel_rad) {
    return laws::steering_command(car.files->steering, car.parameters[Parameter::steering_ratio],
                                  road_wheel_rad);
  };
  if (!backward)
    c.steer_command_rad = command(steer_at(m, t - kBegin_s));
  else if (t >= 0.5 * m.duration_s)
    c.steer_command_rad = command(m.steer_rad);
  if (brakes(m) && t - kBegin_s >= 0.0)
    c.brake_command_pa = {m.pressure_pa, m.pressure_pa, 0.6 * m.pressure_pa, 0.6 * m.pressure_pa};
  return c;
}

}  // namespace

ManoeuvreKind manoeuvre_named(std::string_view name) {
  std::string known;
  for (const auto& [word, kind] : kNames) {
    if (word == name) return kind;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", word);
  }
  throw Error(
      fmt::format("there is no manoeuvre '{}'; wanted one of: {}", name.substr(0, 40), known));
}

ManoeuvreResult run_manoeuvre(const Car<double>& car, const Manoeuvre& m) {
  check_step(car.parameters, m.step);
  const std::optional<crg::Surface> surface = surface_for(m);
  const Road road = surface ? Road(*surface) : Road();
  StartOptions begin;
  begin.x_m = 20.0;
  begin.speed_mps = m.speed_mps;
  begin.fuel_kg = m.fuel_kg;
  begin.gear = in_neutral(m) ? 0 : choose_gear(car, m.speed_mps, kMostGears);
  const bool backward = m.kind == ManoeuvreKind::kReverse;
  if (backward) {
    if (overall_ratio(car.parameters, -1) == 0.0)
      throw Error(
          "the car has no reverse gear (gearbox.ratio_reverse = 0), wanted one to drive backward; "
          "state its ratio in the vehicle file");
    begin.gear = -1;
    begin.speed_mps = 0.0;
    begin.x_m = 20.0 + m.speed_mps * m.duration_s;
  }
  Simulation<double> sim = start(car, road, begin);
  Detail<double> detail{};
  RunRecorder recorder(m.devices, m.record_every, m.step.step_s, m.on_row);
  ManoeuvreResult out;
  StepSwing swing;
  double brake_x_m = 0.0;
  bool braking = false;
  const auto steps = static_cast<std::size_t>(std::lround(m.duration_s / m.step.step_s));
  for (std::size_t i = 0; i < steps; ++i) {
    if (m.progress && i % 4096 == 0)
      m.progress("manoeuvre", static_cast<double>(i) / static_cast<double>(steps));
    const double t = static_cast<double>(i) * m.step.step_s;
    const State<double> before = sim.state;
    const Controls<double> c = controls_at(car, m, t, begin.gear, before);
    if (!braking && brakes(m) && t - kBegin_s >= 0.0) {
      brake_x_m = before[kX];
      braking = true;
    }
    const StepResult result = step(car, sim, c, road, m.step, detail);
    const RoadPoint& under = detail.wheel[0].road;
    if (!result.ok()) {
      out.problem = describe(result, t, under.u_m, under.v_m);
      break;
    }
    swing.look(car, before, detail);
    if (recorder.wants_step()) recorder.record(t, before, detail, c, before[kX], before[kY]);
    for (const auto& wheel : detail.wheel) out.peak_fz_n = std::max(out.peak_fz_n, wheel.fz_n);
    out.peak_ay_mps2 = std::max(out.peak_ay_mps2, std::abs(detail.specific_force_mps2.y));
    out.peak_yaw_rate_radps = std::max(out.peak_yaw_rate_radps, std::abs(before[kYawRate]));
    if (braking && out.stop_m == 0.0 && sim.state[kVx] < 0.05)
      out.stop_m = sim.state[kX] - brake_x_m;
  }
  out.complete = out.problem.empty();
  out.step_swing = swing.largest();
  out.swing_warning = swing.warning(m.step);
  out.ledge_warning = ledge_warning(sim.discrete.ledges);
  out.end_mps = sim.state[kVx];
  out.telemetry = recorder.table();
  return out;
}

}  // namespace vehicle
