#include "vehicle/lap.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "base/ending.h"
#include "base/json_text.h"
#include "live.h"
#include "load_car.h"
#include "recording/log_table.h"
#include "vehicle/error.h"
#include "vehicle/said_opponent.h"
#include "write_telemetry.h"

namespace crgdrive {
namespace {

std::string sentences(const vehicle::LapResult& result) {
  std::string text;
  for (std::size_t i = 0; i < result.lap_s.size(); ++i)
    text += fmt::format("lap {}: {:.3f} s\n", i + 1, result.lap_s[i]);
  text += fmt::format(
      "top speed {:.1f} m/s; at most {:.2f} m off the line; a wheel came within {:.2f} m of the "
      "road's edge, "
      "{} of {} steps with a wheel off the road; swings at the step: {:.4f} %\n",
      result.top_mps, result.furthest_off_line_m, result.least_edge_m, result.steps_off_road,
      result.steps, 100.0 * result.step_swing);
  if (!result.limit.empty()) text += result.limit + "\n";
  if (!result.swing_warning.empty()) text += result.swing_warning + "\n";
  if (!result.ledge_warning.empty()) text += result.ledge_warning + "\n";
  if (result.surge_s > 0.0)
    text += fmt::format(
        "the compressor was below its surge line for {:.2f} s; no surge cycle is modelled, so "
        "pressures there are too calm\n",
        result.surge_s);
  const double sum = result.energy_j.sum();
  text += fmt::format(
      "energy: engine {:.1f} kJ, drag {:.1f}, brakes {:.1f}, tyres {:.1f}, driveline {:.1f}, "
      "dampers {:.1f}; "
      "sum of all {:.1f} against a change of {:.1f}\n",
      result.energy_j.engine / 1e3, result.energy_j.drag / 1e3, result.energy_j.brake / 1e3,
      (result.energy_j.tyre_x + result.energy_j.tyre_y + result.energy_j.tyre_moment) / 1e3,
      result.energy_j.driveline / 1e3, result.energy_j.damper / 1e3, sum / 1e3,
      result.energy_change_j / 1e3);
  return text;
}

nlohmann::ordered_json lap_numbers(const std::string& out_path, const vehicle::LapResult& result) {
  const vehicle::Powers<double>& e = result.energy_j;
  return {{"complete", result.complete},
          {"lap_s", result.lap_s},
          {"top_mps", result.top_mps},
          {"limit", result.limit},
          {"furthest_off_line_m", result.furthest_off_line_m},
          {"least_edge_m", result.least_edge_m},
          {"steps", result.steps},
          {"steps_off_road", result.steps_off_road},
          {"step_swing", result.step_swing},
          {"swing_warning", result.swing_warning},
          {"ledge_warning", result.ledge_warning},
          {"energy_j",
           {{"engine", e.engine},
            {"drag", e.drag},
            {"brakes", e.brake},
            {"tyres", e.tyre_x + e.tyre_y + e.tyre_moment},
            {"driveline", e.driveline},
            {"dampers", e.damper},
            {"sum", e.sum()},
            {"change", result.energy_change_j}}},
          {"surge_s", result.surge_s},
          {"telemetry", out_path}};
}

/// A lap as it was ordered: a second car is taken out of the opponents.
struct Ordered {
  LapCommand command;
  std::string out_path;
  std::vector<std::string> log_paths;
  std::vector<double> ahead_s;
};

Ordered ordered(const LapCommand& asked) {
  Ordered out{asked, "", {}, {}};
  LapCommand& c = out.command;
  for (const std::string& said : asked.opponents) {
    const auto [path, ahead_s, ahead_m] = vehicle::said_opponent(said);
    const std::string ending = base::ending_of(path);
    if (ending != ".yaml" && ending != ".yml") {
      if (ahead_m)
        throw UsageError(
            fmt::format("--opponent {}: a log is ahead by seconds: {}@2s", said, path));
      out.log_paths.push_back(path);
      out.ahead_s.push_back(
          ahead_s.value_or(static_cast<double>(out.log_paths.size()) * asked.opponent_ahead_s));
      continue;
    }
    if (!c.second_path.empty()) throw UsageError("--opponent " + said + ": the second of its kind");
    if (ahead_s || ahead_m.value_or(0.0) < 0.0 || ahead_m.value_or(0.0) > 1000.0)
      throw UsageError(
          fmt::format("--opponent {}: a car begins 0 to 1000 m ahead: {}@15m", said, path));
    c.second_path = path;
    if (ahead_m) c.second_ahead_m = *ahead_m;
  }
  if (c.second_path.empty() && (c.out_paths.size() > 1 || c.grip_usage.size() > 1))
    throw UsageError(
        "two of --output or of --grip-usage are of a second car: --opponent VEHICLE.yaml");
  if (c.out_paths.size() > 2) throw UsageError("--output is wanted once for each of the two cars");
  if (c.grip_usage.empty()) c.grip_usage = {vehicle::SpeedOptions().grip_usage};
  if (!c.margin_m) c.margin_m = vehicle::RacingLineOptions().margin_m;
  if (!c.out_paths.empty()) out.out_path = c.out_paths[0];
  if (c.out_paths.size() > 1) c.second_out_path = c.out_paths[1];
  if (c.grip_usage.size() > 1) c.second_grip_usage = c.grip_usage[1];
  return out;
}

/// What the command says of a run, without what lives as long as the run.
vehicle::LapOptions lap_options(const Ordered& order) {
  const LapCommand& command = order.command;
  vehicle::LapOptions options;
  options.laps = command.laps;
  options.standing = command.standing;
  options.tyre_k = command.tyre_k;
  options.disc_k = command.disc_k;
  options.fuel_kg = command.fuel_kg;
  options.speed.grip_usage = command.grip_usage[0];
  options.speed.begin_mps = command.begin_mps;
  options.line.margin_m = *command.margin_m;
  options.step = step_options(command.car);
  for (std::size_t i = 0; i < order.log_paths.size(); ++i) {
    const std::string& path = order.log_paths[i];
    options.opponents.push_back(
        vehicle::make_opponent(recording::read_log_table(path), order.ahead_s[i], path));
  }
  return options;
}

/// The telemetry of one car of the run, with all files that had a part in it.
void write_drive(const Ordered& order, const std::string& out_path, const vehicle::Vehicle& v,
                 const CarOptions& car, const std::vector<std::string>& others,
                 const vehicle::LapResult& result) {
  if (out_path.empty()) return;
  const LapCommand& command = order.command;
  std::vector<std::string> files{command.track_path};
  if (!command.friction_path.empty()) files.push_back(command.friction_path);
  if (!command.devices_path.empty()) files.push_back(command.devices_path);
  files.insert(files.end(), order.log_paths.begin(), order.log_paths.end());
  files.insert(files.end(), others.begin(), others.end());
  std::string from = provenance("lap", v, car, files) +
                     fmt::format("# start fuel_kg={:g} tyre_k={:g} disc_k={:g}\n", command.fuel_kg,
                                 command.tyre_k, command.disc_k);
  if (!order.ahead_s.empty())
    from += fmt::format("# opponents {:g} s ahead\n", fmt::join(order.ahead_s, ", "));
  if (!command.second_path.empty())
    from += fmt::format("# two cars, the second begins {:g} m ahead, grip usage {:g} and {:g}\n",
                        command.second_ahead_m, command.grip_usage[0], command.second_grip_usage);
  else
    from +=
        fmt::format("# grip usage {:g}, margin {:g} m\n", command.grip_usage[0], *command.margin_m);
  write_telemetry(out_path, from, result.telemetry);
}

// What the terminal says of the drives; `tried`: what was driven with first.
void tell(const Ordered& order, const LapCommand& tried, bool is_tuned,
          const std::vector<vehicle::LapResult>& results, Terminal& terminal) {
  const LapCommand& command = order.command;
  const vehicle::LapResult& result = results.front();
  const bool is_pair = results.size() > 1;
  if (terminal.json) {
    nlohmann::ordered_json told = lap_numbers(order.out_path, result);
    told["grip_usage"] = command.grip_usage[0];
    told["margin_m"] = *command.margin_m;
    if (is_pair) {
      told["nearest_m"] = result.nearest_m;
      told["second"] = lap_numbers(command.second_out_path, results.back());
    }
    terminal.print(base::json_text(told));
  } else if (is_pair) {
    terminal.print("first car\n" + sentences(result) + "second car\n" + sentences(results.back()) +
                   fmt::format("the cars' centres came within {:.1f} m; cars do not touch\n",
                               result.nearest_m));
  } else {
    const double usage = command.grip_usage[0], first_usage = tried.grip_usage[0];
    std::string text;
    if (command.margin_m != tried.margin_m)
      text = fmt::format(
          "driven with --grip-usage {:g} --margin-m {:g}: nearer to the edges no --grip-usage from "
          "{:g} down to {:g} keeps the car on its line\n",
          usage, *command.margin_m, first_usage, vehicle::kLeastGripUsage);
    else if (usage != first_usage)
      text = fmt::format("driven with --grip-usage {:g}: with {:g} the car left its line\n", usage,
                         first_usage);
    else if (is_tuned && !result.limit.empty())
      text = fmt::format("no --grip-usage from {:g} down to {:g} keeps the car on its line\n",
                         first_usage, vehicle::kLeastGripUsage);
    terminal.print(text + sentences(result));
  }
}

}  // namespace

int lap(const LapCommand& asked, Terminal& terminal) {
  Ordered order = ordered(asked);
  const LapCommand& command = order.command;
  const vehicle::Vehicle v = load_vehicle(command.car);
  const auto car = vehicle::make_car(v.files, v.parameters, v.terms, v.contact);
  const crg::Surface surface = read_road(command.track_path, command.friction_path, terminal);
  std::vector<vehicle::Entrant> entrants{{&car, lap_options(order)}};
  vehicle::LapOptions& options = entrants.front().options;
  options.progress = terminal.progress();
  Live live(command.live);
  if (live.wanted()) options.on_row = [&](const recording::Table& table) { live.row(table); };
  const std::size_t every = steps_per_row(command.rate_hz, options.step.step_s, terminal);
  options.record_every = order.out_path.empty() && !live.wanted() ? 0 : every;
  vehicle::DeviceFile devices;
  if (!command.devices_path.empty()) {
    devices = vehicle::read_devices(command.devices_path);
    options.devices = &devices;
  }

  CarOptions second_options = command.car;  // its step and contact; settings are the first car's
  second_options.vehicle_path = command.second_path;
  second_options.setup_path.clear();
  second_options.settings.clear();
  vehicle::Vehicle second_v;
  std::optional<vehicle::Car<double>> second;
  if (!command.second_path.empty()) {
    second_v = load_vehicle(second_options);
    second =
        vehicle::make_car(second_v.files, second_v.parameters, second_v.terms, second_v.contact);
    vehicle::LapOptions other = lap_options(order);
    other.ahead_m = command.second_ahead_m;
    other.speed.grip_usage = command.second_grip_usage;
    other.record_every = command.second_out_path.empty() ? 0 : every;
    other.devices = options.devices;
    entrants.push_back({&*second, std::move(other)});
  }

  // Nobody said how much of the grip: what keeps the car, unless others see it drive.
  const bool is_tuned = asked.grip_usage.empty() && !second && !live.wanted();
  const LapCommand tried = command;
  std::vector<vehicle::LapResult> results;
  if (is_tuned) {
    auto tuned = vehicle::drive_laps_tuned(
        car, vehicle::Road(surface), std::move(options),
        asked.margin_m ? vehicle::Margin::as_given : vehicle::Margin::wider_where_wanted);
    order.command.grip_usage[0] = tuned.grip_usage;
    order.command.margin_m = tuned.margin_m;
    results.push_back(std::move(tuned.result));
  } else {
    results = vehicle::drive_together(entrants, vehicle::Road(surface));
  }
  const vehicle::LapResult& result = results.front();
  tell(order, tried, is_tuned, results, terminal);
  write_drive(order, order.out_path, v, command.car, second_v.read_files, result);
  if (second)
    write_drive(order, command.second_out_path, second_v, second_options, v.read_files,
                results.back());
  for (std::size_t i = 0; i < results.size(); ++i)
    if (!results[i].complete)
      throw vehicle::Error((second ? (i == 0 ? "first car: " : "second car: ") : "") +
                           results[i].problem);
  return kOk;
}

}  // namespace crgdrive
