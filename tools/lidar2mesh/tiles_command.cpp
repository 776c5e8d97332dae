#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/json_text.h"
#include "base/output_set.h"
#include "base/write_file.h"
#include "cloud/error.h"
#include "cloud/read_cloud.h"
#include "cloud/tiles.h"
#include "cloud/trajectory.h"
#include "commands.h"

namespace lidar2mesh {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kPoints = "points.tiles";
constexpr std::size_t kMostPasses = std::numeric_limits<std::uint16_t>::max();

void require_few(std::size_t passes, const char* what) {
  if (passes > kMostPasses)
    throw cloud::Error(fmt::format("{} {} seen, at most {} wanted; make tiles of a part of them",
                                   passes, what, kMostPasses));
}

/// A file, or the stretch of a trajectory between two gaps.
struct Pass {
  std::string path;
  double begin_s = 0.0, end_s = 0.0;  ///< of a trajectory
};

/// Into the map frame; points without a pose are left out.
class Placer {
 public:
  explicit Placer(const TilesCommand& command)
      : poses_(
            cloud::read_trajectory(command.trajectory, cloud::sensor_in_poses(command.extrinsic))) {
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      if (passes.empty() || poses_.piece[k] != poses_.piece[k - 1])
        passes.push_back({command.trajectory, poses_.time_s[k], poses_.time_s[k]});
      passes.back().end_s = poses_.time_s[k];
    }
    require_few(passes.size(), "pieces of the trajectory");
  }

  /// Points of one pass after another.
  void place(const cloud::Cloud& cloud, const cloud::PassSink& sink) {
    if (cloud.time_s.size() != cloud.size())
      throw cloud::Error(
          "the points have no time, and --trajectory wants one of each; leave it out for a cloud "
          "in the map frame");
    cloud::Cloud placed;
    int pass = 0;
    const auto hand_on = [&] {
      if (placed.size() > 0) sink(std::exchange(placed, {}), static_cast<std::uint16_t>(pass));
    };
    for (std::size_t k = 0; k < cloud.size(); ++k) {
      cloud::PosedInstant pose;
      if (!cloud::pose_at(poses_, cloud.time_s[k], hint_, pose)) {
        ++without_pose;
        continue;
      }
      const int now = poses_.piece[hint_] - poses_.piece.front();
      if (now != pass) hand_on();
      pass = now;
      const Eigen::Vector3d p =
          pose.position_m + pose.orientation * (cloud.origin_m + cloud.point(k));
      placed.x_m.push_back(p.x()), placed.y_m.push_back(p.y()), placed.z_m.push_back(p.z());
      placed.time_s.push_back(cloud.time_s[k]);
      if (!cloud.intensity.empty()) placed.intensity.push_back(cloud.intensity[k]);
      if (!cloud.classification.empty()) placed.classification.push_back(cloud.classification[k]);
      if (!cloud.sigma_m.empty()) placed.sigma_m.push_back(cloud.sigma_m[k]);
    }
    hand_on();
  }

  std::size_t without_pose = 0;
  std::vector<Pass> passes;

 private:
  cloud::Trajectory poses_;
  std::size_t hint_ = 0;
};

std::vector<std::string> files_of(const TilesCommand& command) {
  std::vector<std::string> files;
  for (const std::string& cloud : command.clouds)
    for (const std::string& file : cloud::cloud_files(cloud)) files.push_back(file);
  require_few(files.size(), "files");
  return files;
}

Json list_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json fields_of(const cloud::TileSet& set) {
  Json fields = Json::array();
  const auto add = [&](bool is_there, const char* name, const char* type, int values) {
    if (is_there) fields.push_back({{"name", name}, {"type", type}, {"values", values}});
  };
  add(set.has_time, "time_s", "f64", 1);
  add(true, "xyz_m", "f32", 3);
  add(set.has_intensity, "intensity", "f32", 1);
  add(set.has_sigma, "sigma_m", "f32", 1);
  add(true, "pass", "u16", 1);
  add(set.has_class, "class", "u8", 1);
  return fields;
}

Json levels_of(const cloud::TileSet& set) {
  std::vector<std::pair<std::uint64_t, std::uint64_t>> levels;  // tiles, points
  for (const cloud::Tile& tile : set.tiles) {
    const auto level = static_cast<std::size_t>(tile.level);
    if (level >= levels.size()) levels.resize(level + 1);
    ++levels[level].first, levels[level].second += tile.points;
  }
  Json out = Json::array();
  double spacing_m = set.spacing_m;
  for (const auto& [tiles, points] : levels) {
    out.push_back({{"spacing_m", spacing_m}, {"tiles", tiles}, {"points", points}});
    spacing_m /= 2.0;
  }
  return out;
}

/// Without the list of tiles.
Json summary_of(const cloud::TileSet& set, const std::vector<Pass>& passes) {
  Json classes = Json::object(), list = Json::array();
  for (const auto& [number, points] : set.points_of_class) classes[std::to_string(number)] = points;
  for (std::size_t k = 0; k < passes.size(); ++k) {
    const auto found = set.points_of_pass.find(static_cast<int>(k));
    list.push_back({{"path", passes[k].path},
                    {"points", found == set.points_of_pass.end() ? 0 : found->second}});
    if (passes[k].end_s > passes[k].begin_s)
      list.back()["time_s"] = {passes[k].begin_s, passes[k].end_s};
  }
  Json low = Json::array(), high = Json::array();
  for (const cloud::MostValues& most : set.most_m)
    low.push_back(most.low), high.push_back(most.high);
  const auto range = [](bool is_there, double from, double to) {
    return is_there ? Json{from, to} : Json();
  };
  return {{"points", set.points},
          {"unit", "m"},
          {"min_m", list_of(set.min_m)},
          {"max_m", list_of(set.max_m)},
          {"most_min_m", low},
          {"most_max_m", high},
          {"intensity", range(set.has_intensity, set.most_intensity.low, set.most_intensity.high)},
          {"sigma_m", range(set.has_sigma, set.most_sigma_m.low, set.most_sigma_m.high)},
          {"time_s", range(set.has_time, set.time_begin_s, set.time_end_s)},
          {"classes", classes},
          {"passes", list},
          {"levels", levels_of(set)},
          {"file", kPoints},
          {"bytes", set.bytes},
          {"fields", fields_of(set)}};
}

Json tiles_of(const cloud::TileSet& set) {
  Json tiles = Json::array();
  for (const cloud::Tile& tile : set.tiles) {
    Json row = {tile.level, tile.begin, tile.points};
    for (const Eigen::Vector3d& v : {tile.origin_m, tile.min_m, tile.max_m})
      for (int k = 0; k < 3; ++k) row.push_back(v[k]);
    tiles.push_back(row);
  }
  return tiles;
}

/// Every file, in the order of their names; a file, or a piece of the trajectory, is a pass.
cloud::PassSource pass_source(const TilesCommand& command, const std::vector<std::string>& files,
                              Placer* placer, const base::Progress& progress,
                              std::vector<std::string>& remarks) {
  return [&, placer](const cloud::PassSink& sink) {
    cloud::CloudReadOptions read;
    read.metres_per_unit = metres_per_unit(command.unit);
    std::size_t points = 0;
    for (std::size_t k = 0; k < files.size(); ++k) {
      read.progress = [&](double share) {
        progress("read",
                 0.5 * (static_cast<double>(k) + share) / static_cast<double>(files.size()));
      };
      const cloud::CloudReadReport report =
          cloud::read_chunks(files[k], read, [&](cloud::Cloud&& chunk) {
            points += chunk.size();
            if (placer != nullptr)
              placer->place(chunk, sink);
            else
              sink(std::move(chunk), static_cast<std::uint16_t>(k));
          });
      for (const std::string& remark : report.remarks)
        remarks.push_back(fmt::format("{}: {}", files[k], remark));
    }
    if (placer == nullptr || placer->without_pose == 0) return;
    if (placer->without_pose == points)
      throw cloud::Error(
          "no point has a pose: their times lie outside the trajectory's (GPS seconds of the week "
          "against UTC?)");
    remarks.push_back(
        fmt::format("{} points outside the trajectory's time were left out", placer->without_pose));
  };
}

}  // namespace

int run_tiles(const TilesCommand& command, Terminal& terminal) {
  const std::vector<std::string> files = files_of(command);
  std::optional<Placer> placer;
  std::vector<Pass> passes;
  if (!command.trajectory.empty())
    passes = placer.emplace(command).passes;
  else
    for (const std::string& file : files) passes.push_back({.path = file});
  base::OutputSet outputs(command.output_dir, "lidar2mesh tiles");
  std::vector<road::InputFile> inputs;
  for (const std::string& file : files)
    for (const road::InputFile& each : hashed("cloud", file)) inputs.push_back(each);
  for (const road::InputFile& each : hashed("trajectory", command.trajectory))
    inputs.push_back(each);
  std::vector<std::string> remarks;
  const base::Progress progress = terminal.progress();
  cloud::TileOptions options;
  options.threads = command.threads;
  options.progress = [&](double share) { progress("write", 0.5 + 0.5 * share); };
  const cloud::TileSet set = cloud::write_tiles(
      pass_source(command, files, placer ? &*placer : nullptr, progress, remarks),
      outputs.staged(kPoints), outputs.staged("sorted"), options);
  Json index = head_of(inputs, command.options);
  index.update(summary_of(set, passes));
  index["remarks"] = remarks;
  const Json said = index;
  index["tile_columns"] = {"level",      "begin",      "points",  "origin_x_m",
                           "origin_y_m", "origin_z_m", "min_x_m", "min_y_m",
                           "min_z_m",    "max_x_m",    "max_y_m", "max_z_m"};
  index["tiles"] = tiles_of(set);
  base::write_file(outputs.staged("tiles.json"), base::json_text(index, -1));
  outputs.commit("tiles");
  if (terminal.json) {
    terminal.print(base::json_text(said));
    return kOk;
  }
  terminal.print(fmt::format("points: {}, tiles: {}, levels: {}\n", set.points, set.tiles.size(),
                             said["levels"].size()));
  for (const std::string& remark : remarks)
    terminal.print(fmt::format("note: {}\n", one_line(remark)));
  terminal.print(
      fmt::format("index    {}\npoints   {}\n", outputs.path("tiles.json"), outputs.path(kPoints)));
  return kOk;
}

}  // namespace lidar2mesh
