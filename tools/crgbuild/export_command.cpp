// A road in a format of other programs, and what that format cannot hold.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "base/ending.h"
#include "base/json_text.h"
#include "base/write_file.h"
#include "commands.h"
#include "crg/file.h"
#include "crg/surface.h"
#include "inspect/export_road.h"
#include "inspect/height_raster.h"
#include "inspect/matlab_file.h"
#include "inspect/track_widths.h"
#include "make/summary.h"
#include "mesh/error.h"
#include "mesh/export_mesh.h"

namespace crgbuild {
namespace {

namespace fs = std::filesystem;

/// Largest distance between neighbouring columns: by so much a width can be short.
double widest_column_m(const crg::Grid& grid) {
  double widest = 0.0;
  for (std::size_t j = 1; j < grid.columns(); ++j)
    widest = std::max(widest, grid.v_m[j] - grid.v_m[j - 1]);
  return widest;
}

/// `file` as a file in the folder of `output` names it: what lies there is moved together with it.
std::string seen_from(const std::string& output, const std::string& file) {
  if (file.empty()) return {};
  const fs::path folder = output == "-" ? fs::current_path() : fs::absolute(output).parent_path();
  const fs::path near = fs::absolute(file).lexically_proximate(folder);
  return near.generic_string();
}

/// What was written, as it is told.
struct Written {
  std::string what;
  nlohmann::ordered_json facts;
  std::vector<std::string> lost;
};

Written write_tum(const crg::Surface& road, const ExportCommand& command) {
  const std::string& output = command.output;
  const road::RoadEdges edges = road::built_beside(command.crg).smooth;
  const auto widths = road::track_widths(road.reference_line(), road.grid(), edges);
  base::write_file(output, road::track_widths_csv(widths));
  const double short_m = edges.empty() ? widest_column_m(road.grid()) : 0.0;
  return {edges.empty()
              ? fmt::format("{} points; widths end at a column, up to {:.3f} m inside the edge",
                            widths.size(), short_m)
              : fmt::format("{} points; widths end at the edges in summary.json", widths.size()),
          {{"points", widths.size()}, {"width_short_by_at_most_m", short_m}},
          {"heights", "banking", "kerbs", "road beyond holes"}};
}

Written write_mesh(const crg::Surface& road, const ExportCommand& command) {
  const std::string ending = base::ending_of(command.output);
  if (ending != ".glb" && ending != ".obj" && ending != ".ply" && ending != ".stl")
    throw road::Error(fmt::format(
        "{}: the ending of the output says which format triangles are written in; wanted .glb, "
        ".obj, .ply or .stl",
        command.output));
  Eigen::Vector3d origin_m;
  const road::Mesh mesh = road::surface_mesh(road, command.step_m, origin_m);
  road::MeshExportOptions options;
  options.up = ending == ".glb" ? road::UpAxis::y : road::UpAxis::z;  // the rule of glTF
  road::export_mesh(mesh, command.output, options);
  std::string what =
      fmt::format("{} triangles, {} up", mesh.triangles.size(), ending == ".glb" ? "y" : "z");
  if (!origin_m.isZero())
    what += fmt::format("; add ({}, {}) m for map coordinates", origin_m.x(), origin_m.y());
  return {std::move(what),
          {{"triangles", mesh.triangles.size()}, {"origin_m", {origin_m.x(), origin_m.y()}}},
          {fmt::format("what lies between rows {} m apart", command.step_m)}};
}

/// Two files, for no height map says where it lies: the facts first, so that no map is without.
Written write_heightmap(const crg::Surface& road, const ExportCommand& command) {
  const std::string ending = base::ending_of(command.output);
  if (ending != ".png" && ending != ".raw")
    throw road::Error(fmt::format(
        "{}: the ending of the output says which format heights are written in; wanted .png or "
        ".raw",
        command.output));
  const road::HeightRaster raster = road::height_raster(road, command.step_m);
  const road::RasterLoss loss = road::raster_loss(raster, road);
  const std::string beside = command.output + ".json";
  nlohmann::ordered_json facts = {{"version", 1},
                                  {"file", fs::path(command.output).filename().string()},
                                  {"columns", raster.columns},
                                  {"rows", raster.rows},
                                  {"rows_go", "south"},
                                  {"cell_m", raster.cell_m},
                                  {"x_m", raster.x_m},
                                  {"y_m", raster.y_m},
                                  {"z_m", raster.z_m},
                                  {"z_step_m", raster.z_step_m},
                                  {"no_road", 0}};
  if (ending == ".raw") facts["byte_order"] = "little";
  base::write_file(beside, base::json_text(facts));
  base::write_file(command.output,
                   ending == ".png" ? road::png_bytes(raster) : road::raw_bytes(raster));
  std::vector<std::string> lost{
      fmt::format("{:.2f} mm at samples", 1e3 * loss.at_samples_m),
      fmt::format("{:.1f} mm at most between them, {:.2f} mm in the mean (root of squares)",
                  1e3 * loss.between_samples_m, 1e3 * loss.rms_m),
      fmt::format("{:.1f} % of the road, within a sample of its edges", 1e2 * loss.nodes_without),
      fmt::format("{:.2f} % of the road, below or above another leg",
                  1e2 * loss.nodes_of_other_legs)};
  return {fmt::format("{} x {} samples {} m apart, levels of {:.4g} mm; where it lies: {}",
                      raster.columns, raster.rows, raster.cell_m, 1e3 * raster.z_step_m, beside),
          {{"facts", beside},
           {"columns", raster.columns},
           {"rows", raster.rows},
           {"z_step_m", raster.z_step_m},
           {"error_between_samples_m", loss.between_samples_m},
           {"error_rms_m", loss.rms_m},
           {"nodes_without_share", loss.nodes_without},
           {"nodes_of_other_legs_share", loss.nodes_of_other_legs}},
          std::move(lost)};
}

Written write_mat(const crg::Surface& road, const std::string& output) {
  const std::string bytes = road::matlab_file(road);
  base::write_file(output, bytes);
  return {
      fmt::format("{} bytes; x_m, y_m, heading_rad, v_m, z_m(row, column), u_begin_m, u_step_m, "
                  "closed",
                  bytes.size()),
      {{"bytes", bytes.size()}},
      {"the header's texts, options and projection"}};
}

Written write_text(const crg::Surface& road, const ExportCommand& command) {
  const std::string name = fs::path(command.crg).stem().string();
  const road::NamedFiles files{seen_from(command.output, command.crg),
                               seen_from(command.output, command.friction_crg)};
  const std::string& format = command.format;
  const auto made = format == "xodr"
                        ? road::opendrive(road, name, files, road::built_beside(command.crg).smooth)
                    : format == "rdf"     ? road::road_data_file(files, 1.0)
                    : format == "geojson" ? road::plan_geojson(road)
                    : format == "kml"     ? road::plan_kml(road, name)
                                          : road::plan_svg(road);
  base::write_file(command.output, made.text);
  return {fmt::format("{} bytes", made.text.size()), {{"bytes", made.text.size()}}, made.lost};
}

/// The format of a file of this name, by its ending; empty: none of them.
std::string export_format_of(const std::string& output) {
  static const std::map<std::string, std::string> kByEnding = {
      {".xodr", "xodr"},     {".rdf", "rdf"},  {".glb", "mesh"},        {".obj", "mesh"},
      {".ply", "mesh"},      {".stl", "mesh"}, {".geojson", "geojson"}, {".json", "geojson"},
      {".kml", "kml"},       {".svg", "svg"},  {".csv", "tum"},         {".png", "heightmap"},
      {".raw", "heightmap"}, {".mat", "mat"}};
  const auto known = kByEnding.find(base::ending_of(output));
  return known == kByEnding.end() ? "" : known->second;
}

}  // namespace

int run_export(const ExportCommand& asked, Terminal& terminal) {
  ExportCommand command = asked;
  if (command.format.empty()) command.format = export_format_of(command.output);
  if (command.format.empty())
    throw UsageError("the ending of " + command.output + " says no format; give --format");
  if (!command.friction_crg.empty() && command.format != "xodr" && command.format != "rdf")
    throw UsageError("--grip goes with .xodr and .rdf: the other formats name no CRG");
  const crg::Surface road(crg::read(command.crg));
  if (!command.friction_crg.empty()) crg::read(command.friction_crg);  // that it is one
  const std::string& format = command.format;
  const Written written = format == "tum"         ? write_tum(road, command)
                          : format == "mesh"      ? write_mesh(road, command)
                          : format == "heightmap" ? write_heightmap(road, command)
                          : format == "mat"       ? write_mat(road, command.output)
                                                  : write_text(road, command);
  if (terminal.json) {
    nlohmann::ordered_json out;
    out["file"] = command.output;
    out["format"] = format;
    out.update(written.facts);
    out["lost"] = written.lost;
    terminal.print(base::json_text(out));
  } else {
    terminal.print(fmt::format(
        "{}\nlost     {}\nfile     {}\n", written.what,
        written.lost.empty() ? "nothing" : fmt::format("{}", fmt::join(written.lost, "; ")),
        command.output));
  }
  return kOk;
}

}  // namespace crgbuild
