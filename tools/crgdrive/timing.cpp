#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "load_car.h"
#include "vehicle/driver.h"
#include "vehicle/error.h"
#include "vehicle/step_swing.h"

namespace crgdrive {
namespace {

/// Histogram with doubling bins up to the step itself, which is the line not to cross. `us`:
/// sorted.
void print_histogram(const std::vector<double>& us, double deadline, Terminal& terminal) {
  double low = 0.0;
  for (double high = 0.5; low < us.back(); low = high, high *= std::sqrt(2.0)) {
    const auto n = static_cast<std::size_t>(std::upper_bound(us.begin(), us.end(), high) -
                                            std::upper_bound(us.begin(), us.end(), low));
    const bool line_here = low < deadline && high >= deadline;
    if (n == 0 && !line_here) continue;
    const auto width = static_cast<std::size_t>(
        std::ceil(50.0 * static_cast<double>(n) / static_cast<double>(us.size())));
    terminal.print(fmt::format("{:>9.1f} us |{:<50}| {}{}\n", high, std::string(width, '#'), n,
                               line_here ? "  <- real time" : ""));
  }
}

/// `us`: what the steps took.
void print_times(std::vector<double> us, const vehicle::StepOptions& options,
                 const vehicle::StepSwing& swing, Terminal& terminal) {
  const std::size_t count = us.size();
  const double total = std::accumulate(us.begin(), us.end(), 0.0);
  const auto late = static_cast<std::size_t>(
      std::count_if(us.begin(), us.end(), [&](double t) { return t > options.step_s * 1e6; }));
  std::sort(us.begin(), us.end());
  const auto quantile = [&](double share) {
    return us[std::min(count - 1, static_cast<std::size_t>(share * static_cast<double>(count)))];
  };
  const double factor = static_cast<double>(count) * options.step_s * 1e6 / total;
  if (terminal.json) {
    terminal.print(fmt::format(
        "{{\"median_us\": {:.4f}, \"p99_us\": {:.4f}, \"max_us\": {:.4f}, \"steps\": {}, "
        "\"steps_late\": {}, "
        "\"step_us\": {:g}, \"real_time_factor\": {:.2f}, \"step_swing\": {:.4g}}}\n",
        quantile(0.5), quantile(0.99), us.back(), count, late, options.step_s * 1e6, factor,
        swing.largest()));
    return;
  }
  terminal.print(fmt::format(
      "one step of {:g} ms: median {:.2f} us, p99 {:.2f} us, longest {:.1f} us; {} of {} steps "
      "late; "
      "{:.0f} times real time\n",
      options.step_s * 1e3, quantile(0.5), quantile(0.99), us.back(), late, count, factor));
  if (const std::string warning = swing.warning(options); !warning.empty())
    terminal.print(warning + "\n");
  print_histogram(us, options.step_s * 1e6, terminal);
}

}  // namespace

int timing(const TimingCommand& command, Terminal& terminal) {
  const vehicle::Vehicle v = load_vehicle(command.car);
  const auto car = vehicle::make_car(v.files, v.parameters, v.terms, v.contact);
  if (v.contact == vehicle::Contact::kStrip && command.track_path.empty())
    throw vehicle::Error(
        "strip contact looks at samples of a road, a plane has none: nothing to measure; give "
        "--road, or --contact single-point");
  const vehicle::StepOptions options = step_options(command.car);
  vehicle::check_step(v.parameters, options);
  std::optional<crg::Surface> surface;
  vehicle::RacingLine line;
  vehicle::StartOptions begin;
  begin.speed_mps = 40.0;
  if (!command.track_path.empty()) {
    surface.emplace(crg::read(command.track_path));
    line = vehicle::plan_line(*surface);
    vehicle::plan_speed(line, car, {});
    begin.x_m = line.x_m[0];
    begin.y_m = line.y_m[0];
    begin.z_near_m = surface->z_at_uv(line.u_begin_m, line.v_m[0]);
    begin.yaw_rad = line.heading_rad[0];
    begin.speed_mps = line.speed_mps[0];
  }
  const vehicle::Road road = surface ? vehicle::Road(*surface) : vehicle::Road();
  begin.gear = vehicle::choose_gear(car, begin.speed_mps, vehicle::kMostGears);
  auto sim = vehicle::start(car, road, begin);
  vehicle::Driver driver;
  driver.gear = begin.gear;
  driver.options.step_s = options.step_s;
  vehicle::Detail<double> detail{};
  vehicle::Controls<double> controls;

  const auto count = static_cast<std::size_t>(command.seconds / options.step_s);
  if (count == 0) throw vehicle::Error("--stop-s is shorter than a step");
  std::vector<double> us(count);
  const base::Progress progress = terminal.progress();
  vehicle::StepSwing swing;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 4096 == 0) progress("timing", static_cast<double>(i) / static_cast<double>(count));
    if (surface) {
      controls = vehicle::drive(driver, line, car, sim.state, detail);
    } else {  // a slow sine on the plane, speed held
      controls.gear_command = driver.gear =
          vehicle::choose_gear(car, sim.state[vehicle::kVx], driver.gear);
      controls.throttle_command =
          std::clamp(0.3 + 0.2 * (40.0 - sim.state[vehicle::kVx]), 0.0, 1.0);
      controls.steer_command_rad = 0.02 * std::sin(3.0 * sim.time_s);
    }
    const vehicle::State<double> state = sim.state;
    const auto before = std::chrono::steady_clock::now();
    const vehicle::StepResult result = vehicle::step(car, sim, controls, road, options, detail);
    us[i] = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - before)
                .count();
    if (!result.ok())
      throw vehicle::Error(vehicle::describe(result, sim.time_s, detail.wheel[0].road.u_m,
                                             detail.wheel[0].road.v_m));
    swing.look(car, state, detail);
  }
  print_times(std::move(us), options, swing, terminal);
  return kOk;
}

}  // namespace crgdrive
