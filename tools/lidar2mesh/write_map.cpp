#include "write_map.h"

#include <fmt/format.h>

#include "base/json_text.h"
#include "base/write_file.h"
#include "cloud/write_surface.h"
#include "map_report.h"
#include "road/read_mesh.h"

namespace lidar2mesh {
namespace {

/// The base's road with other heights.
crg::Crg with_heights(crg::Crg base, const crg::Grid& grid) {
  base.grid = grid;
  base.z_double_m.clear();
  return base;
}

/// The base's road with something else than heights over its nodes: nothing is added to them.
crg::Crg with_values(const crg::Crg& base, const crg::Grid& grid) {
  crg::Crg file = with_heights(base, grid);
  file.banking.clear(), file.slope.clear();
  for (const char* key : {"REFERENCE_LINE_START_Z", "REFERENCE_LINE_END_Z"})
    crg::set_value(file.road, key, 0.0);
  return file;
}

void write_road(const crg::Crg& road, const std::string& path) {
  base::write_file(path, crg::to_bytes(road, crg::Format::KRBI));
}

/// As triangles, for a file that carries nothing else.
road::Mesh mesh_of(const cloud::NodeSurface& surface) {
  road::Mesh mesh;
  mesh.origin_m = surface.origin_m, mesh.vertices_m = surface.place_m;
  mesh.triangles = surface.triangles;
  mesh.object_of_triangle.assign(mesh.triangles.size(), 0);
  mesh.objects.push_back({"road", "road", ""});
  return mesh;
}

/// refined.ply or .stl, and refined.pcd where it is wanted.
void write_surfaces(const MapCommand& command, const cloud::NodeSurface& surface,
                    const std::vector<road::InputFile>& inputs, const base::OutputSet& outputs) {
  const std::vector<std::string> comments = comments_of(inputs, command.options);
  if (command.stl)
    road::write_mesh(mesh_of(surface), outputs.staged("refined.stl"));
  else
    cloud::write_surface(surface, outputs.staged("refined.ply"), command.doubles, comments);
  if (command.pcd)
    cloud::write_surface(surface, outputs.staged("refined.pcd"), command.doubles, comments);
}

/// Returns what summary.json holds. `facts`: with every remark.
std::string write_map(const MapCommand& command, const crg::Crg& base,
                      const cloud::MapResult& result, const cloud::MapReport& facts,
                      const std::vector<road::InputFile>& inputs, const base::OutputSet& outputs,
                      Terminal& terminal) {
  const crg::Crg refined = with_heights(base, result.grid);
  write_road(refined, outputs.staged("refined.crg"));
  write_road(with_values(base, result.stddev), outputs.staged("refined.stddev.crg"));
  write_road(with_values(base, result.source), outputs.staged("refined.provenance.crg"));
  const cloud::NodeSurface surface = cloud::node_surface(refined, result.stddev);
  write_surfaces(command, surface, inputs, outputs);
  nlohmann::ordered_json out = head_of(inputs, command.options);
  if (!command.doubles)
    out["origin_m"] = {surface.origin_m.x(), surface.origin_m.y(), surface.origin_m.z()};
  out.update(nlohmann::ordered_json::parse(cloud::map_summary_json(facts)));
  const std::string summary = base::json_text(out);
  base::write_file(outputs.staged("summary.json"), summary);
  base::write_file(outputs.staged("timing.json"), cloud::map_timing_json(facts));
  if (!result.corrected.empty())
    cloud::write_trajectory(result.corrected.front(), outputs.staged("trajectory.csv"));
  if (command.report) {
    terminal.progress()("report", 0.95);
    write_road(base, outputs.staged("base.crg"));
    write_map_report(outputs, base, refined, result.source, facts, inputs, command.threads);
  }
  return summary;
}

void print_result(const MapCommand& command, const cloud::MapReport& facts,
                  const base::OutputSet& outputs, Terminal& terminal) {
  terminal.print(fmt::format("{} points read, {} used; {:.1f} % of the nodes come from points\n",
                             facts.points, facts.used, 100.0 * facts.coverage));
  if (command.correct_drift) {
    terminal.print(
        fmt::format("drift: {} after {} rounds over {} sections in {} passes\n",
                    facts.converged ? "converged"
                    : command.base.empty()
                        ? fmt::format("still moving by {:.1f} mm a round", 1e3 * facts.last_move_m)
                        : "NOT converged",
                    facts.iterations, facts.sections, facts.passes));
    if (command.base.empty())
      terminal.print(
          fmt::format("where the road lies is the trajectory's word: about {:.0f} mm in height\n",
                      1e3 * facts.typical_stddev[2]));
    if (!command.base.empty())
      terminal.print(fmt::format(
          "against the base {:.1f} -> {:.1f} mm, {:.0f} % of its cells believed\n",
          1e3 * facts.rms_before_m, 1e3 * facts.rms_after_m, 100.0 * facts.inlier_share));
    if (facts.passes > 1)
      terminal.print(fmt::format("between passes {:.1f} -> {:.1f} mm\n",
                                 1e3 * facts.pass_rms_before_m, 1e3 * facts.pass_rms_after_m));
    if (facts.left_out_nodes > 0)
      terminal.print(fmt::format(
          "one pass left out: 90 % intervals held {:.1f} % of its {} nodes; the points' own "
          "deviations were multiplied by {:.2f}\n",
          100.0 * facts.left_out_within_90, facts.left_out_nodes, facts.noise_factor));
    for (const std::string& direction : facts.unfixed)
      terminal.print(fmt::format(
          "note: {} is hardly fixed by the data (typical deviation in summary.json)\n", direction));
  }
  terminal.print(
      fmt::format("heights changed by {:.1f} mm (median), {:.1f} mm (99 %), {:.1f} mm at most\n",
                  1e3 * facts.changed_p50_m, 1e3 * facts.changed_p99_m, 1e3 * facts.changed_max_m));
  for (const std::string& remark : facts.remarks)
    terminal.print(fmt::format("note: {}\n", one_line(remark)));
  terminal.print(fmt::format("road     {}\nsummary  {}\n", outputs.path("refined.crg"),
                             outputs.path("summary.json")));
}

}  // namespace

int hand_out_map(const MapCommand& command, const crg::Crg& base, const cloud::MapResult& result,
                 const std::vector<std::string>& remarks,
                 const std::vector<road::InputFile>& inputs, base::OutputSet& outputs,
                 Terminal& terminal) {
  cloud::MapReport facts = result.report;
  facts.remarks.insert(facts.remarks.end(), remarks.begin(), remarks.end());
  const std::string summary = write_map(command, base, result, facts, inputs, outputs, terminal);
  outputs.commit("refined", {}, {"timing.json"});
  if (terminal.json)
    terminal.print(summary);
  else
    print_result(command, facts, outputs, terminal);
  if (!facts.faults.empty())
    throw command::NotValid(
        fmt::format("{}: {}; do not use this road", outputs.path("refined.crg"),
                    one_line(fmt::format("{}", fmt::join(facts.faults, "; ")))));
  return kOk;
}

}  // namespace lidar2mesh
