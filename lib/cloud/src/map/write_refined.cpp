#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/one_line.h"
#include "base/write_file.h"
#include "changed_map.h"
#include "cloud/refine.h"
#include "cloud/write_surface.h"
#include "map_report.h"
#include "mesh/read_mesh.h"
#include "report/track_report.h"

namespace cloud {
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
road::Mesh mesh_of(const NodeSurface& surface) {
  road::Mesh mesh;
  mesh.origin_m = surface.origin_m, mesh.vertices_m = surface.place_m;
  mesh.triangles = surface.triangles;
  mesh.object_of_triangle.assign(mesh.triangles.size(), 0);
  mesh.objects.push_back({"road", "road", ""});
  return mesh;
}

/// refined.ply, .stl and .pcd, as wanted.
void write_surfaces(const RefineRequest& request, const NodeSurface& surface,
                    const std::vector<road::InputFile>& inputs, const base::OutputSet& outputs) {
  const std::vector<std::string> comments = comments_of(request.program, inputs, request.options);
  for (const std::string& format : request.format) {
    const std::string path = outputs.staged("refined." + format);
    if (format == "stl")
      road::write_mesh(mesh_of(surface), path);
    else
      write_surface(surface, path, request.doubles, comments);
  }
}

/// Ground that changed between passes, a place a line.
std::string changes_csv(const std::vector<ChangedPlace>& places) {
  std::string text = "place,old_until_pass,u_begin_m,u_end_m,v_begin_m,v_end_m,area_m2,change_m\n";
  for (std::size_t k = 0; k < places.size(); ++k) {
    const ChangedPlace& p = places[k];
    text += fmt::format("{},{},{:.2f},{:.2f},{:.2f},{:.2f},{:.2f},{:.5f}\n", k + 1, p.pass + 1,
                        p.u_begin_m, p.u_end_m, p.v_begin_m, p.v_end_m, p.area_m2, p.change_m);
  }
  return text;
}

/// Heights, deviations and sources, called NAME.crg, NAME.stddev.crg, NAME.provenance.crg.
void write_roads(const crg::Crg& road, const crg::Grid& stddev, const crg::Grid& source,
                 const std::string& name, const base::OutputSet& outputs) {
  write_road(road, outputs.staged(name + ".crg"));
  write_road(with_values(road, stddev), outputs.staged(name + ".stddev.crg"));
  write_road(with_values(road, source), outputs.staged(name + ".provenance.crg"));
}

/// Where the ground changed, and with campaigns what it was before.
void write_changes(const crg::Crg& base, const MapResult& result, const base::OutputSet& outputs) {
  if (result.report.changed.empty()) return;
  base::write_file(outputs.staged("changes.csv"), changes_csv(result.report.changed));
  if (!result.older) return;
  const OlderRoad& older = *result.older;
  write_roads(with_heights(base, older.grid), older.stddev, older.source, "older", outputs);
  if (const std::string png = changed_map_png(base, result, older); !png.empty())
    base::write_file(outputs.staged("changes.png"), png);
}

}  // namespace

Refined write_refined(const RefineRequest& request, const crg::Crg& base, const MapResult& result,
                      const std::vector<std::string>& remarks,
                      const std::vector<road::InputFile>& inputs, base::OutputSet& outputs,
                      const base::Progress& progress) {
  Refined out;
  out.facts = result.report;
  out.facts.remarks.insert(out.facts.remarks.end(), remarks.begin(), remarks.end());
  const crg::Crg refined = with_heights(base, result.grid);
  write_roads(refined, result.stddev, result.source, "refined", outputs);
  const NodeSurface surface = node_surface(refined, result.stddev);
  write_surfaces(request, surface, inputs, outputs);
  std::optional<Eigen::Vector3d> origin_m;
  if (!request.doubles) origin_m = surface.origin_m;
  out.summary_json = joined_summary(head_json(request.program, inputs, request.options), origin_m,
                                    map_summary_json(out.facts));
  base::write_file(outputs.staged("summary.json"), out.summary_json);
  base::write_file(outputs.staged("timing.json"), map_timing_json(out.facts));
  write_changes(base, result, outputs);
  if (!result.corrected.empty())
    write_trajectory(result.corrected.front(), outputs.staged("trajectory.csv"));
  if (request.report) {
    if (progress) progress("report", 0.95);
    write_road(base, outputs.staged("base.crg"));
    write_map_report(outputs, base, refined, result, out.facts, inputs, request.threads);
    out.json_path = outputs.path("report.json");
    if (report::page_available()) out.page_path = outputs.path("report.html");
  }
  out.crg_path = outputs.path("refined.crg");
  out.summary_path = outputs.path("summary.json");
  outputs.commit("refined", {}, {"timing.json"});
  return out;
}

std::string why_not_usable(const Refined& refined) {
  if (refined.facts.faults.empty()) return "";
  return fmt::format("{}: {}; do not use this road", refined.crg_path,
                     base::one_line(fmt::format("{}", fmt::join(refined.facts.faults, "; "))));
}

}  // namespace cloud
