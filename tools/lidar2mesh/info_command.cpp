#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "cloud/read_cloud.h"
#include "commands.h"

namespace lidar2mesh {

namespace {

nlohmann::ordered_json numbers_of(const std::string& path, const cloud::CloudFacts& facts) {
  const cloud::CloudReadReport& read = facts.read;
  nlohmann::ordered_json classes = nlohmann::ordered_json::object();
  for (const auto& [number, points] : facts.points_of_class)
    classes[std::to_string(number)] = points;
  return {{"path", path},
          {"format", read.format},
          {"points", read.points},
          {"not_finite", read.not_finite},
          {"min_m", {facts.min_m.x(), facts.min_m.y(), facts.min_m.z()}},
          {"max_m", {facts.max_m.x(), facts.max_m.y(), facts.max_m.z()}},
          {"unit", read.unit},
          {"metres_per_unit", read.metres_per_unit},
          {"metres_per_height_unit", read.metres_per_height_unit},
          {"unit_from_file", read.unit_from_file},
          {"coordinate_system", read.coordinate_system},
          {"resolution_m", facts.resolution_m},
          {"has_time", facts.has_time},
          {"has_intensity", facts.has_intensity},
          {"classes", classes},
          {"remarks", read.remarks}};
}

void print_facts(const std::string& path, const cloud::CloudFacts& facts, Terminal& terminal) {
  const cloud::CloudReadReport& read = facts.read;
  terminal.print(fmt::format("{}: {}, {} points\n", path, read.format, read.points));
  for (int k = 0; k < 3; ++k)
    terminal.print(fmt::format("  {}  {:.3f} to {:.3f} m, resolution {:.2g} m\n", "xyz"[k],
                               facts.min_m[k], facts.max_m[k],
                               facts.resolution_m[static_cast<std::size_t>(k)]));
  terminal.print(fmt::format("  unit of the file: {}{}\n", one_line(read.unit),
                             read.unit_from_file ? " (from its coordinate system)" : ""));
  if (!read.coordinate_system.empty())
    terminal.print(fmt::format("  coordinate system: {}\n", one_line(read.coordinate_system)));
  if (facts.has_time)
    terminal.print(
        fmt::format("  time {:.3f} to {:.3f} s\n", facts.time_begin_s, facts.time_end_s));
  for (const auto& [number, points] : facts.points_of_class)
    terminal.print(fmt::format("  class {}: {} points\n", number, points));
  for (const std::string& remark : read.remarks)
    terminal.print(fmt::format("  note: {}\n", one_line(remark)));
}

}  // namespace

int run_info(const InfoCommand& command, Terminal& terminal) {
  cloud::CloudReadOptions options;
  options.metres_per_unit = metres_per_unit(command.unit);
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  const std::vector<std::string> paths = cloud::cloud_files(command.cloud);
  double done = 0.0;
  const base::Progress progress = terminal.progress();
  options.progress = [&](double share) {
    progress("read", (done + share) / static_cast<double>(paths.size()));
  };
  for (const std::string& path : paths) {
    const cloud::CloudFacts facts = cloud::describe(path, options);
    if (terminal.json)
      all.push_back(numbers_of(path, facts));
    else
      print_facts(path, facts, terminal);
    done += 1.0;
  }
  const bool is_folder = std::filesystem::is_directory(command.cloud);
  if (terminal.json) terminal.print(base::json_text(is_folder ? all : all.front()));
  return kOk;
}

}  // namespace lidar2mesh
