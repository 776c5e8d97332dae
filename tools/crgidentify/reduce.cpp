#include "identify/reduce.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/json_text.h"
#include "base/one_line.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "commands.h"
#include "identify/proving_road.h"
#include "vehicle/road_file.h"
#include "vehicle/vehicle_file.h"

namespace crgidentify {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// control.yaml -> control, for its neighbours.
std::string stem_of(const std::string& path) {
  const fs::path p(path);
  return (p.parent_path() / p.stem()).string();
}

ordered_json part_json(const identify::PartError& e) {
  return {{"what", e.name}, {"rms_share", e.rms}, {"largest_share", e.most},
          {"of", e.of},     {"unit", e.unit},     {"rows", e.rows}};
}

ordered_json model_json(const identify::LapError::Model& lap, const identify::PartError& limit,
                        const std::string& refused) {
  return {{"lap_ay_rms_share", lap.ay_rms},
          {"lap_ay_95_share", lap.ay_95},
          {"lap_yaw_moment_rms_nm", lap.yaw_rms_nm},
          {"lap_load_rms_share", lap.load_rms},
          {"limit_rms_share", limit.rms},
          {"limit_largest_share", limit.most},
          {"refused", refused}};
}

std::string reduction_said(const identify::Reduction& r, const identify::LapError& lap) {
  std::string out = fmt::format(
      "{} runs of the full car, {:.0f} to {:.0f} m/s, {} settled moments\n"
      "{:52} {:>8} {:>8}\n",
      r.runs, r.least_mps, r.most_mps, r.moments, "difference from the full car on the rig", "rms",
      "largest");
  const auto line = [&](const identify::PartError& e) {
    out += fmt::format("{:52} {:7.2f}% {:7.2f}%  of {:.4g} {}\n", e.name, 100.0 * e.rms,
                       100.0 * e.most, e.of, e.unit);
  };
  for (const auto& e : r.parts) line(e);
  line(r.ellipse_error);
  line(r.limit_single);
  line(r.limit_double);
  out += fmt::format(
      "lap of {:.1f} s at {:.0f} % of the grip, {} rows ({} on kerbs, {} at speeds that the rig "
      "had not, {} with sliding "
      "wheels left out), largest "
      "ay {:.1f} m/s2:\n",
      lap.lap_s, 100.0 * lap.grip_usage, lap.rows, lap.on_kerbs, lap.other_speeds, lap.sliding,
      lap.largest_ay_mps2);
  for (const auto& [name, m] : {std::pair{"single-track", lap.single}, {"double-track", lap.two}})
    out += fmt::format(
        "  {}: ay {:.2f} % rms, {:.2f} % at 95 % of the rows; yaw moment {:.0f} N m rms; loads "
        "{:.1f} % rms\n",
        name, 100.0 * m.ay_rms, 100.0 * m.ay_95, m.yaw_rms_nm, 100.0 * m.load_rms);
  return out + fmt::format(
                   "  loads of the wheels without the share of banks {:.1f} %, of dips and crests "
                   "{:.1f} % rms\n",
                   100.0 * lap.load_rms_without_bank, 100.0 * lap.load_rms_without_vertical);
}

}  // namespace

int reduce(const ReduceCommand& command, Terminal& terminal) {
  terminal.start("reading");
  const vehicle::Vehicle v =
      vehicle::read_vehicle(command.vehicle_path, command.setup_path, command.settings);
  const vehicle::Car<double> car = make_car(v.files, v.parameters, v.terms, v.contact);
  std::optional<crg::Surface> surface;
  if (command.track_path.empty()) {
    surface.emplace(identify::proving_road());
  } else {
    vehicle::RoadFiles files = vehicle::read_road(command.track_path, "");
    if (!files.remark.empty()) terminal.remark(files.remark);
    surface.emplace(std::move(files.surface));
  }
  identify::ReduceOptions options = command.options;
  options.least_mps = command.speed_mps[0];
  options.most_mps = command.speed_mps[1];
  options.progress = terminal.progress();
  const identify::Reduction r = identify::reduce_car(car, options);
  const identify::LapError lap =
      identify::compare_on_lap(car, r, vehicle::Road(*surface), terminal.progress());
  const identify::ReduceBounds bounds{command.most_share[0], command.most_share[1]};
  std::string settings;
  for (const std::string& setting : command.settings) settings += " --set " + setting;
  const std::string source = base::one_line(
      fmt::format("reduced from {} (sha256 {}){}; lap of {}", command.vehicle_path,
                  base::sha256_of_file(command.vehicle_path), settings,
                  command.track_path.empty() ? "the built-in proving road" : command.track_path));
  const std::string stem = stem_of(command.out_path);
  base::write_file(command.out_path, identify::control_yaml(r, lap, bounds, source));
  if (command.out_path != "-") {  // standard output takes one file
    base::write_file(stem + ".h", identify::control_header(r, lap, bounds, source));
    base::write_file(stem + "_axles.csv", identify::axles_csv(r));
    base::write_file(stem + "_border.csv", identify::border_csv(r));
  }
  const std::string single = why_refused(r, lap, bounds, false),
                    both = why_refused(r, lap, bounds, true);
  if (terminal.json) {
    ordered_json json{{"control", command.out_path},
                      {"header", stem + ".h"},
                      {"runs", r.runs},
                      {"lap_s", lap.lap_s},
                      {"grip_usage", lap.grip_usage},
                      {"largest_ay_mps2", lap.largest_ay_mps2},
                      {"single_track", model_json(lap.single, r.limit_single, single)},
                      {"double_track", model_json(lap.two, r.limit_double, both)},
                      {"parts", ordered_json::array()}};
    for (const auto& e : r.parts) json["parts"].push_back(part_json(e));
    json["parts"].push_back(part_json(r.ellipse_error));
    terminal.print(base::json_text(json));
  } else {
    terminal.print(
        reduction_said(r, lap) +
        fmt::format("-> {0}, {1}.h, {1}_axles.csv, {1}_border.csv\n", command.out_path, stem));
  }
  if (!single.empty() || !both.empty())
    throw command::NotValid(fmt::format("{}: refused: {}{}{}", command.out_path, single,
                                        !single.empty() && !both.empty() ? "; " : "", both));
  return kOk;
}

}  // namespace crgidentify
