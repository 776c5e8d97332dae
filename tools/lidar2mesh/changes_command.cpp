#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/output_set.h"
#include "base/write_file.h"
#include "cloud/changes.h"
#include "cloud/pcl.h"
#include "commands.h"
#include "report/change_map.h"

namespace lidar2mesh {
namespace {

using Json = nlohmann::ordered_json;

/// `remarks`: of the last reading.
cloud::CloudSource campaign_source(const std::string& path, const std::string& unit,
                                   std::vector<std::string>& remarks) {
  cloud::CloudReadOptions read;
  read.metres_per_unit = metres_per_unit(unit);
  return [files = cloud::cloud_files(path), read, &remarks](const cloud::ChunkSink& sink) {
    remarks.clear();
    for (const std::string& file : files)
      for (const std::string& remark : cloud::read_chunks(file, read, sink).remarks)
        remarks.push_back(fmt::format("{}: {}", file, remark));
  };
}

/// Both campaigns as wholes, in one frame.
cloud::Cloud whole(const cloud::CloudSource& source) {
  cloud::Cloud out;
  source([&](cloud::Cloud&& chunk) {
    if (out.size() == 0) out.origin_m = chunk.origin_m;
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      const Eigen::Vector3d p = chunk.point(i) + (chunk.origin_m - out.origin_m);
      out.x_m.push_back(p.x()), out.y_m.push_back(p.y()), out.z_m.push_back(p.z());
    }
  });
  return out;
}

std::string csv_of(const cloud::ChangeResult& result) {
  std::string text =
      "place,x_m,y_m,z_m,area_m2,change_m,stddev_m,peak_change_m,peak_stddev_m,kind\n";
  for (std::size_t k = 0; k < result.places.size(); ++k) {
    const cloud::ChangePlace& p = result.places[k];
    text += fmt::format("{},{:.3f},{:.3f},{:.3f},{:.4f},{:.5f},{:.5f},{:.5f},{:.5f},{}\n", k + 1,
                        p.x_m, p.y_m, p.z_m, p.area_m2, p.change_m, p.stddev_m, p.peak_change_m,
                        p.peak_stddev_m, p.object ? "object" : "surface");
  }
  return text;
}

Json json_of(const cloud::ChangeResult& result, const std::vector<cloud::OctreeChange>& cubes) {
  Json places = Json::array(), alone = Json::array();
  for (const cloud::ChangePlace& p : result.places)
    places.push_back({{"x_m", p.x_m},
                      {"y_m", p.y_m},
                      {"z_m", p.z_m},
                      {"area_m2", p.area_m2},
                      {"change_m", p.change_m},
                      {"stddev_m", p.stddev_m},
                      {"peak_change_m", p.peak_change_m},
                      {"peak_stddev_m", p.peak_stddev_m},
                      {"kind", p.object ? "object" : "surface"}});
  for (const cloud::OctreeChange& c : cubes)
    alone.push_back({{"x_m", c.x_m},
                     {"y_m", c.y_m},
                     {"z_m", c.z_m},
                     {"points", c.points},
                     {"kind", c.appeared ? "appeared" : "vanished"}});
  return {{"cell_m", result.cell_m},
          {"old_points", result.old_points},
          {"new_points", result.new_points},
          {"cells", result.cells.size()},
          {"old_alone", result.old_alone},
          {"new_alone", result.new_alone},
          {"unclear", result.unclear},
          {"level_median_m", result.level_median_m},
          {"level_low_m", result.level_low_m},
          {"level_high_m", result.level_high_m},
          {"stddev_factor", result.stddev_factor},
          {"smallest_told_m", result.smallest_told_m},
          {"places", places},
          {"cubes", alone},
          {"remarks", result.remarks}};
}

std::string picture_of(const cloud::ChangeResult& result, double min_change_m) {
  std::vector<report::ChangeSquare> squares;
  for (const cloud::ChangeCell& cell : result.cells)
    squares.push_back({cell.x_m, cell.y_m, cell.change_m});
  std::vector<report::ChangeMark> marks;
  double most = 2.0 * min_change_m;
  for (const cloud::ChangePlace& place : result.places) {
    marks.push_back({place.x_m, place.y_m, std::sqrt(place.area_m2 / 3.14159)});
    if (!place.object) most = std::max(most, std::abs(place.peak_change_m));
  }
  return report::change_map_png(
      squares, result.cell_m, marks, std::min(most, 0.1),
      fmt::format("Change of height, new less old: {} places, cells of {:g} m", marks.size(),
                  result.cell_m));
}

}  // namespace

int run_changes(const ChangesCommand& command, Terminal& terminal) {
  if (command.octree_m > 0.0) cloud::require_pcl("--voxel-m");
  cloud::ChangeOptions options;
  options.cell_m = command.cell_m, options.min_change_m = command.min_change_m,
  options.level_m = command.level_m, options.progress = terminal.progress();
  std::vector<std::string> of_before, of_after;
  const cloud::CloudSource before = campaign_source(command.before, command.unit, of_before),
                           after = campaign_source(command.after, command.unit, of_after);
  base::OutputSet outputs(command.output_dir, "lidar2mesh changes");
  cloud::ChangeResult result = cloud::find_changes(before, after, options);
  for (const std::vector<std::string>* const remarks : {&of_before, &of_after})
    result.remarks.insert(result.remarks.end(), remarks->begin(), remarks->end());
  std::vector<cloud::OctreeChange> cubes;
  if (command.octree_m > 0.0)
    cubes = cloud::octree_changes(whole(before), whole(after), command.octree_m, 5);
  const std::string json = base::json_text(json_of(result, cubes));
  base::write_file(outputs.staged("changes.csv"), csv_of(result));
  base::write_file(outputs.staged("changes.json"), json);
  base::write_file(outputs.staged("changes.png"), picture_of(result, command.min_change_m));
  outputs.commit("changes");
  if (terminal.json) {
    terminal.print(json);
    return kOk;
  }
  terminal.print(fmt::format("{} cells of {:g} m in common; in half of them {:.0f} mm are told\n",
                             result.cells.size(), result.cell_m, 1e3 * result.smallest_told_m));
  terminal.print(fmt::format("{} places changed\n", result.places.size()));
  for (std::size_t k = 0; k < std::min<std::size_t>(20, result.places.size()); ++k) {
    const cloud::ChangePlace& p = result.places[k];
    terminal.print(fmt::format("  {:3}  x {:.2f}  y {:.2f}  {:8.2f} m2  {:+8.1f} +- {:.1f} mm{}\n",
                               k + 1, p.x_m, p.y_m, p.area_m2, 1e3 * p.peak_change_m,
                               1e3 * p.peak_stddev_m, p.object ? "  object" : ""));
  }
  if (command.octree_m > 0.0)
    terminal.print(fmt::format("{} cubes of {:g} m hold points of one campaign alone\n",
                               cubes.size(), command.octree_m));
  for (const std::string& remark : result.remarks)
    terminal.print(fmt::format("note: {}\n", one_line(remark)));
  terminal.print(fmt::format("places   {}\nmap      {}\n", outputs.path("changes.csv"),
                             outputs.path("changes.png")));
  return kOk;
}

}  // namespace lidar2mesh
