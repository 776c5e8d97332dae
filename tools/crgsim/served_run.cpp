// What serve and race share: a unit's options from what was said, and what is told of its run.
#include "served_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <functional>
#include <memory>
#include <utility>

#include "base/error.h"
#include "crg/file.h"
#include "crg/surface.h"
#include "road/projection.h"
#include "sim/dds.h"
#include "sim/unpack.h"

namespace crgsim {
namespace {

/// Between which durations how many steps took.
nlohmann::ordered_json histogram(const sim::ServeCounts& counts) {
  nlohmann::ordered_json bins = nlohmann::ordered_json::array();
  for (std::size_t k = 0; k < counts.bins.size(); ++k)
    bins.push_back(
        {{"up_to_s", k < sim::kStepBins_s.size() ? nlohmann::ordered_json(sim::kStepBins_s[k])
                                                 : nlohmann::ordered_json()},
         {"steps", counts.bins[k]}});
  return bins;
}

/// Where on the Earth the places of a road's map lie, by its header.
std::function<std::array<double, 2>(double, double)> map_of(const crg::Crg& road,
                                                            const std::string& road_path,
                                                            bool has_to_say) {
  const road::Projection projection = road::read_projection(road);
  if (projection.kind == road::Projection::Kind::none && !has_to_say) return {};
  if (projection.kind == road::Projection::Kind::none)
    throw base::Error(road_path +
                      ": its header does not say where on the Earth it lies; give it control "
                      "points: crgbuild align ROAD --control-points FILE -o NEW");
  return [projection](double x_m, double y_m) {
    const Eigen::Vector2d at = road::unproject(projection, {x_m, y_m});
    return std::array{at.x(), at.y()};
  };
}

}  // namespace

sim::ServeOptions options_of(const ServeCommand& command) {
  sim::ServeOptions options;
  if (command.dds) {
    sim::require_dds("--dds");
    options.dds_domain = command.domain;
    options.topic_prefix = command.topic_prefix;
  }
  options.socket_path = command.socket_path;
  options.udp_port = command.udp_port;
  options.commands = command.commands;
  options.measurements = command.measurements;
  options.recorded = command.recorded;
  options.inputs = read_inputs(command.inputs_path);
  if (!command.devices_path.empty())
    options.devices = vehicle::read_signal_sensors(command.devices_path);
  options.devices.seed = command.seed.value_or(options.devices.seed);
  const bool drives_on_it = !command.road_path.empty() && sim::is_vehicle_file(command.unit_path);
  if (drives_on_it)
    options.starts.emplace_back("road", std::filesystem::absolute(command.road_path).string());
  if (!command.road_path.empty()) {
    crg::Crg road = crg::read(command.road_path);
    options.to_latitude_longitude_deg =
        map_of(road, command.road_path, options.devices.road.empty() && !drives_on_it);
    if (!options.devices.road.empty())
      options.road = std::make_shared<const crg::Surface>(std::move(road));
  }
  for (const std::string& start : command.starts)
    options.starts.push_back(assignment("--set", start));
  for (const std::string& text : command.safe) {
    const auto [name, value] = assignment("--safe", text);
    double number = 0.0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (error != std::errc() || end != value.data() + value.size())
      throw command::UsageError("--safe " + text + ": NAME=NUMBER wanted");
    options.safe.emplace_back(name, number);
  }
  for (const std::string& opponent : command.opponents)
    options.opponents.push_back(sim::read_opponent(opponent));
  options.safe_after_s = command.safe_after_s;
  options.stop_s = command.stop_s;
  options.step_s = command.step_s;
  options.every = command.every;
  options.lockstep = command.lockstep;
  options.speed_up = command.speed_up;
  options.patience_s = command.patience_s;
  options.limits = command.limits;
  return options;
}

std::string ending_of(const sim::ServeRun& run) {
  const sim::ServeCounts& c = run.counts;
  return !run.failed.empty() ? "by an error"
         : c.is_parked       ? "parked"
         : c.ended_by_unit   ? "by the unit"
         : c.asked_to_end    ? "by a command"
         : c.silent          ? "because no command came"
                             : "at its stop";
}

nlohmann::ordered_json json_of(const sim::ServeRun& run) {
  const sim::ServeCounts& c = run.counts;
  const double steps = static_cast<double>(std::max<std::uint64_t>(c.steps, 1));
  return {{"ended", ending_of(run)},
          {"steps", c.steps},
          {"measurements", run.rows()},
          {"commands", c.commands},
          {"broken_commands", c.broken},
          {"old_commands", c.old},
          {"clipped_commands", c.clipped},
          {"parked", c.parked},
          {"unit_says", run.log},
          {"flooded_steps", c.flooded},
          {"safe_steps", c.safe_steps},
          {"resets", c.resets},
          {"late_sights", c.late_sights},
          {"left_out_sights", c.left_out_sights},
          {"late_steps", c.late},
          {"latest_s", c.latest_s},
          {"mean_step_s", c.step_sum_s / steps},
          {"longest_step_s", c.longest_step_s},
          {"step_histogram", histogram(c)},
          {"real_time_scheduling", c.real_time_scheduled}};
}

std::string summary_of(const sim::ServeRun& run, double step_s) {
  const sim::ServeCounts& c = run.counts;
  return fmt::format(
             "ended {} after {:g} s: {} steps, {} measurements, {} commands taken, {} old, {} "
             "broken\n",
             ending_of(run), static_cast<double>(c.steps) * step_s, c.steps, run.rows(), c.commands,
             c.old, c.broken) +
         fmt::format(
             "a step takes {:.1f} us, the longest {:.1f} us; {} began more than 2 ms late, the "
             "latest "
             "{:.2f} ms; the safe input acted in {} steps\n",
             1e6 * c.step_sum_s / static_cast<double>(std::max<std::uint64_t>(c.steps, 1)),
             1e6 * c.longest_step_s, c.late, 1e3 * c.latest_s, c.safe_steps);
}

bool is_sound(const sim::ServeRun& run) {
  return !run.counts.silent && !run.counts.is_parked && run.failed.empty() &&
         run.not_finite.empty();
}

std::vector<std::string> remarks_of(const sim::ServeRun& run) {
  const sim::ServeCounts& c = run.counts;
  std::vector<std::string> out;
  if (c.broken > 0)
    out.push_back(fmt::format("{} commands were refused, the first because of {}", c.broken,
                              run.first_broken));
  if (c.clipped > 0)
    out.push_back(
        fmt::format("{} commands had a value beyond its bounds, which was taken at the "
                    "bound",
                    c.clipped));
  if (c.parked > 0)
    out.push_back(
        fmt::format("the unit failed {} times and stood still until a reset, the first "
                    "time because of {}",
                    c.parked, run.first_parked));
  constexpr std::size_t kMostLines = 10;
  for (std::size_t k = 0; k < std::min(run.log.size(), kMostLines); ++k)
    out.push_back("the unit says: " + run.log[k]);
  if (run.log.size() > kMostLines)
    out.push_back(fmt::format("the unit says {} more lines", run.log.size() - kMostLines));
  if (run.failed.empty() && !run.refused.empty()) out.push_back(refused_remark(run.refused));
  if (!run.not_finite.empty())
    out.push_back(run.not_finite + ", the first value that is no finite number");
  if (c.late_sights + c.left_out_sights > 0)
    out.push_back(fmt::format(
        "what sensors saw of the road came {} times after its time, and {} looks were left out; "
        "fewer beams, a lower rate_hz or a longer delay_s",
        c.late_sights, c.left_out_sights));
  return out;
}

}  // namespace crgsim
