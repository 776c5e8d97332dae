#include "road/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/json_text.h"
#include "base/sha256.h"
#include "base/statistics.h"
#include "road/error.h"

namespace road {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Recipe& recipe) {
  Json out = Json::object();
  for (const RecipeKey& key : recipe_keys()) {
    const std::string text = key.show(recipe);
    if (text.empty())
      out[key.name] = nullptr;
    else if (key.is_text || !Json::accept(text))  // "automatic" in place of a number
      out[key.name] = text;
    else
      out[key.name] = Json::parse(text);
  }
  return out;
}

Json json_of(const std::vector<InputFile>& inputs) {
  Json out = Json::array();
  for (const InputFile& file : inputs)
    out.push_back({{"role", file.role}, {"path", file.path}, {"sha256", file.sha256}});
  return out;
}

Json json_of(const MeshReadReport& report) {
  return {{"up", report.up},
          {"unit", report.unit},
          {"scale", report.scale},
          {"vertices", report.vertices},
          {"triangles", report.triangles},
          {"objects", report.objects},
          {"coordinate_resolution_m", report.coordinate_resolution_m},
          {"remarks", report.remarks}};
}

Json json_of(const CleanReport& report) {
  return {{"triangles_in", report.triangles_in},
          {"triangles_kept", report.triangles_kept},
          {"triangles_kept_by_class", report.kept},
          {"triangles_dropped_by_reason", report.dropped},
          {"by_names", report.by_names},
          {"by_guide", report.by_guide},
          {"road_agreement", report.road_agreement ? Json(*report.road_agreement) : Json(nullptr)},
          {"vertices_welded", report.vertices_welded},
          {"weld_tolerance_m", report.weld_tolerance_m},
          {"vertices_snapped", report.vertices_snapped},
          {"snap_tolerance_m", report.snap_tolerance_m},
          {"faces_turned", report.faces_turned},
          {"bridging_triangles", report.bridging_triangles},
          {"non_manifold_edges", report.non_manifold_edges},
          {"boundary_loops", report.boundary_loops},
          {"components", report.components},
          {"remarks", report.remarks}};
}

Json json_of(const CentrelineReport& report) {
  return {{"stations", report.stations},
          {"length_m", report.length_m},
          {"closed", report.closed},
          {"width_min_m", report.width_min_m},
          {"width_median_m", report.width_median_m},
          {"width_max_m", report.width_max_m}};
}

Json json_of(const ReferenceLineReport& report) {
  return {{"length_m", report.length_m},
          {"closed", report.closed},
          {"closing_gap_m", report.closing_gap_m},
          {"heading_step_at_seam_rad", report.heading_step_at_seam_rad},
          {"fit_residual_p99_m", report.fit_residual_p99_m},
          {"fit_residual_max_m", report.fit_residual_max_m},
          {"min_radius_m", report.min_radius_m}};
}

Json json_of(const std::vector<URange>& ranges) {
  Json out = Json::array();
  for (const URange& range : ranges)
    out.push_back({{"u_begin_m", range.u_begin_m}, {"u_end_m", range.u_end_m}});
  return out;
}

Json json_of(const SampleReport& report) {
  Json crossings = Json::array(), remarks = Json::array();
  for (const Crossing& crossing : report.crossings) {
    crossings.push_back({{"u_first_m", crossing.u_first_m},
                         {"u_second_m", crossing.u_second_m},
                         {"height_m", crossing.height_m}});
    remarks.push_back(describe(crossing));
  }
  return {{"nodes", report.nodes},
          {"nodes_with_z", report.nodes_with_z},
          {"filled", report.filled},
          {"holes", report.holes},
          {"folds", json_of(report.folds)},
          {"neighbours", json_of(report.neighbours)},
          {"walls", json_of(report.walls)},
          {"crossings", crossings},
          {"remarks", remarks}};
}

Json json_of(const KerbReport& report) {
  Json kerbs = Json::array();
  for (const Kerb& kerb : report.kerbs)
    kerbs.push_back({{"u_begin_m", kerb.u_begin_m},
                     {"u_end_m", kerb.u_end_m},
                     {"v_begin_m", kerb.v_begin_m},
                     {"v_end_m", kerb.v_end_m},
                     {"height_m", kerb.height_m}});
  return {{"cells", report.cells}, {"columns_added", report.columns_added}, {"kerbs", kerbs}};
}

Json json_of(const SmoothReport& report, const SmoothOptions& options) {
  Json bands = Json::array();
  for (const SmoothedBand& band : report.bands)
    bands.push_back(
        {{"n_cpm", band.n_cpm}, {"before_m3", band.before_m3}, {"after_m3", band.after_m3}});
  return {{"window_m", options.window_u_m},
          {"window_v_m", options.window_v_m},
          {"largest_change_road_m", report.largest_change_road_m},
          {"largest_change_u_m", report.largest_change_u_m},
          {"largest_change_v_m", report.largest_change_v_m},
          {"largest_change_kerb_m", report.largest_change_kerb_m},
          {"nodes_at_bound", report.nodes_at_bound},
          {"halved_waves_m", report.halved_waves_m ? Json{report.halved_waves_m->shortest_m,
                                                          report.halved_waves_m->longest_m}
                                                   : Json(nullptr)},
          {"wheel_path_psd", bands}};
}

Json json_of(const Placement& placement) {
  const AlignReport& report = placement.align;
  const Eigen::Vector3d& t = report.T_global_mesh.translation_m;
  Json projection = nullptr;
  if (placement.projection.kind == Projection::Kind::utm)
    projection = fmt::format("UTM_{:02}{}", placement.projection.zone.number,
                             placement.projection.zone.north ? 'N' : 'S');
  if (placement.projection.kind == Projection::Kind::tm)
    projection = fmt::format("TM about {}, {} deg", placement.projection.latitude_deg,
                             placement.projection.longitude_deg);
  Json tilt_and_scale = nullptr;
  if (!report.tilt_and_scale.is_identity()) {
    const Eigen::Vector3d& about = report.tilt_and_scale.about_m;
    const Eigen::Matrix3d rows =
        report.tilt_and_scale.linear.transpose();  // Eigen counts down the columns
    tilt_and_scale = {{"about_m", {about.x(), about.y(), about.z()}},
                      {"linear", std::vector<double>(rows.data(), rows.data() + 9)}};
  }
  return {{"by", placement.by},
          {"yaw_deg", report.T_global_mesh.yaw_rad * 180.0 / std::numbers::pi},
          {"translation_m", {t.x(), t.y(), t.z()}},
          {"points", placement.point_names},
          {"residual_m", report.residual_m},
          {"rms_m", report.rms_m},
          {"outliers", report.outliers},
          {"tilt_and_scale", tilt_and_scale},
          {"tilt_rad", report.tilt_rad},
          {"scale", report.scale},
          {"projection", projection}};
}

Json json_of(const GridReport& report) {
  return {{"rows", report.rows},
          {"columns", report.columns},
          {"nodes", report.nodes},
          {"nodes_with_z", report.nodes_with_z},
          {"holes", report.holes},
          {"u_begin_m", report.u_begin_m},
          {"u_end_m", report.u_end_m},
          {"u_step_m", report.u_step_m},
          {"v_min_m", report.v_min_m},
          {"v_max_m", report.v_max_m},
          {"v_step_min_m", report.v_step_min_m},
          {"v_step_max_m", report.v_step_max_m},
          {"z_min_m", report.z_min_m},
          {"z_max_m", report.z_max_m},
          {"width_min_m", report.width_min_m},
          {"width_median_m", report.width_median_m},
          {"width_max_m", report.width_max_m}};
}

Json json_of(const GeoEnds& ends) {
  const auto point = [](const std::optional<GeoPoint>& p) {
    if (!p) return Json(nullptr);
    return Json{{"latitude_deg", p->latitude_deg},
                {"longitude_deg", p->longitude_deg},
                {"height_m", p->height_m ? Json(*p->height_m) : Json(nullptr)}};
  };
  if (!ends.start && !ends.end) return nullptr;
  return {{"start", point(ends.start)}, {"end", point(ends.end)}};
}

Json json_of(const ValidateReport& report, const ValidateLimits& limits) {
  const std::vector<std::string> failures = validation_failures(report, limits);
  const ErrorQuantiles& z = report.z_error_m;
  Json rough = Json::array();
  for (const RoughPlace& place : report.rough_places) {
    rough.push_back({{"u_begin_m", place.u_begin_m},
                     {"u_end_m", place.u_end_m},
                     {"v_min_m", place.v_min_m},
                     {"v_max_m", place.v_max_m},
                     {"largest_error_m", place.largest_error_m},
                     {"worst_u_m", place.worst_u_m},
                     {"worst_v_m", place.worst_v_m},
                     {"reason", place.reason}});
  }
  return {{"passed", failures.empty()},
          {"failures", failures},
          {"points", report.points},
          {"points_without_mesh", report.points_without_mesh},
          {"z_error_m", {{"p50", z.p50}, {"p95", z.p95}, {"p99", z.p99}, {"max", z.max}}},
          {"mean_error_m", report.mean_error_m},
          {"worst_u_m", report.worst_u_m},
          {"worst_v_m", report.worst_v_m},
          {"seam_z_step_m", report.seam_z_step_m},
          {"seam_heading_step_rad", report.seam_heading_step_rad},
          {"rough_places", rough},
          {"remarks", report.remarks}};
}

}  // namespace

std::string program_name() { return fmt::format("crgbuild {}", KERBSTONE_VERSION); }

namespace {

/// What every summary begins and ends with.
template <class Summary>
Json head_of(const Summary& summary) {
  Json out;
  out["schema"] = 1;
  out["program"] = program_name();
  out["versions"] = {{"compiler", KERBSTONE_COMPILER},
                     {"assimp", KERBSTONE_ASSIMP},
                     {"cgal", KERBSTONE_CGAL},
                     {"embree", KERBSTONE_EMBREE}};
  out["name"] = summary.recipe.name;
  out["inputs"] = json_of(summary.inputs);
  return out;
}

template <class Summary>
std::string finished(Json& out, const Summary& summary) {
  if constexpr (requires { summary.outputs; }) {
    Json outputs = Json::array();
    for (const InputFile& file : summary.outputs)
      outputs.push_back({{"role", file.role}, {"file", file.path}, {"sha256", file.sha256}});
    out["outputs"] = outputs;
  }
  // Object names of a mesh need not be UTF-8.
  return base::json_text(out);
}

}  // namespace

CentrelineReport describe(const Centreline& centreline) {
  CentrelineReport report;
  report.stations = centreline.points_m.size();
  report.length_m = centreline.length_m;
  report.closed = centreline.closed;
  const std::vector<double>& half = centreline.half_width_m;
  if (half.empty()) return report;
  report.width_median_m = 2.0 * base::median(half);
  const auto [low, high] = std::minmax_element(half.begin(), half.end());
  report.width_min_m = 2.0 * *low;
  report.width_max_m = 2.0 * *high;
  return report;
}

GeoEnds geo_ends(const crg::Crg& file) {
  const auto end = [&](const std::string& which) -> std::optional<GeoPoint> {
    const auto value = [&](const char* key) {
      return crg::find_value(file.road, "REFERENCE_LINE_" + which + key);
    };
    const auto latitude = value("_LAT"), longitude = value("_LON");
    if (!latitude || !longitude) return std::nullopt;
    return GeoPoint{*latitude, *longitude, value("_ALT")};
  };
  return {end("START"), end("END")};
}

GridReport describe(const crg::Grid& grid, const crg::ReferenceLine& line) {
  GridReport report;
  report.rows = grid.rows();
  report.columns = grid.columns();
  report.nodes = report.rows * report.columns;
  report.u_begin_m = grid.u_begin_m;
  report.u_step_m = grid.u_step_m;
  report.z_min_m = report.z_max_m = report.width_min_m = report.width_median_m =
      report.width_max_m = std::numeric_limits<double>::quiet_NaN();
  if (report.nodes == 0) return report;
  report.u_end_m = grid.u_of(report.rows - 1);
  report.v_min_m = grid.v_m.front();
  report.v_max_m = grid.v_m.back();
  if (report.columns > 1) {
    report.v_step_min_m = std::numeric_limits<double>::infinity();
    for (std::size_t j = 1; j < report.columns; ++j) {
      const double step = grid.v_m[j] - grid.v_m[j - 1];
      report.v_step_min_m = std::min(report.v_step_min_m, step);
      report.v_step_max_m = std::max(report.v_step_max_m, step);
    }
  }
  double low = std::numeric_limits<double>::infinity(), high = -low;
  std::vector<double> widths;
  for (std::size_t i = 0; i < report.rows; ++i) {
    const double line_z = line.z_m.empty() ? 0.0 : line.z_m[i],
                 banking = line.banking.empty() ? 0.0 : line.banking[i];
    const float* row = grid.z_m.data() + i * report.columns;
    std::size_t with_z = 0, first = report.columns, last = 0;
    for (std::size_t j = 0; j < report.columns; ++j) {
      if (std::isnan(row[j])) continue;
      ++with_z;
      first = std::min(first, j);
      last = j;
      const double z = static_cast<double>(row[j]) + line_z + banking * grid.v_m[j];
      low = std::min(low, z);
      high = std::max(high, z);
    }
    report.nodes_with_z += with_z;
    if (with_z == 0) continue;
    report.holes += last - first + 1 - with_z;
    widths.push_back(grid.v_m[last] - grid.v_m[first]);
  }
  if (report.nodes_with_z == 0) return report;
  report.z_min_m = low;
  report.z_max_m = high;
  std::sort(widths.begin(), widths.end());
  report.width_min_m = widths.front();
  report.width_median_m = widths[widths.size() / 2];
  report.width_max_m = widths.back();
  return report;
}

namespace {

std::string text_of(const Json& json) { return base::json_text(json); }

}  // namespace

std::string json_text(const SmoothReport& report, const SmoothOptions& options) {
  return text_of(json_of(report, options));
}
std::string json_text(const GeoEnds& ends) { return text_of(json_of(ends)); }
std::string json_text(const Placement& placement) { return text_of(json_of(placement)); }
std::string json_text(const ValidateReport& report, const ValidateLimits& limits) {
  return text_of(json_of(report, limits));
}

std::string summary_json(const BuildSummary& summary) {
  Json out = head_of(summary);
  out["recipe"] = json_of(summary.recipe);
  out["read"] = json_of(summary.read);
  out["clean"] = json_of(summary.clean);
  out["centreline"] = json_of(summary.centreline);
  out["reference_line"] = json_of(summary.reference_line);
  out["sample"] = json_of(summary.sample);
  out["kerb"] = json_of(summary.kerb);
  out["smooth"] = json_of(summary.smooth, summary.recipe.smooth);
  out["patches"] = Json::array();
  for (const PatchFile& patch : summary.patches)
    out["patches"].push_back({{"file", patch.file},
                              {"u_begin_m", patch.u_begin_m},
                              {"u_end_m", patch.u_end_m},
                              {"v_begin_m", patch.v_begin_m},
                              {"v_end_m", patch.v_end_m},
                              {"u_step_m", patch.u_step_m},
                              {"z_error_p95_before_m", patch.error_before_m},
                              {"z_error_p95_m", patch.error_m}});
  out["friction"] = summary.friction_file.empty()
                        ? Json(nullptr)
                        : Json{{"file", summary.friction_file}, {"nodes", summary.friction.nodes}};
  out["align"] = summary.placement ? json_of(*summary.placement) : Json(nullptr);
  out["grid"] = json_of(summary.grid);
  out["wgs84"] = json_of(summary.wgs84);
  out["validation"] = json_of(summary.validate, limits_of(summary));
  return finished(out, summary);
}

std::string timing_json(const std::vector<StageSeconds>& seconds, double seconds_total) {
  Json stages = Json::object();
  for (const StageSeconds& stage : seconds) stages[stage.stage] = stage.seconds;
  stages["total"] = seconds_total;
  return text_of({{"schema", 1}, {"seconds", stages}, {"peak_memory_mb", peak_memory_mb()}});
}

namespace {

/// Empty for a file that cannot be read, as MeshFile has it.
std::string sha256_if_there(const std::string& path) {
  try {
    return base::sha256_of_file(path);
  } catch (const Error&) {
    return "";
  }
}

}  // namespace

std::optional<std::string> unchanged_summary(const std::string& path, const BuildSummary& fresh) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  // Whatever else lies under this name is no reason not to build.
  try {
    Json old = Json::parse(text);
    // What the mesh refers to is known only once it has been read: the list of then, as it is now.
    Json& inputs = old.at("inputs");
    for (std::size_t i = inputs.size(); i-- > 0;) {
      if (inputs[i].at("role") != kMeshFile) continue;
      if (inputs[i].at("sha256") != sha256_if_there(inputs[i].at("path").get<std::string>()))
        return std::nullopt;
      inputs.erase(i);
    }
    const Json head = head_of(fresh);
    for (const auto& [key, value] : head.items())
      if (old.at(key) != value) return std::nullopt;
    if (old.at("recipe") != json_of(fresh.recipe)) return std::nullopt;
    failures_in_summary(text);
    return text;
  } catch (const Json::exception&) {
    return std::nullopt;
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::vector<std::string> failures_in_summary(const std::string& summary_json) {
  return Json::parse(summary_json).at("validation").at("failures").get<std::vector<std::string>>();
}

std::string edges_summary_json(const EdgesSummary& summary) {
  const EdgesReport& edges = summary.edges;
  Json out = head_of(summary);
  out["u_step_m"] = summary.recipe.options.u_step_m;
  out["v_step_m"] = summary.recipe.options.v_step_m;
  out["edges"] = {{"left_points", edges.left_points},
                  {"right_points", edges.right_points},
                  {"dropped_points", edges.dropped_points},
                  {"has_z", edges.has_z},
                  {"right_reversed", edges.right_reversed},
                  {"width_min_m", edges.width_min_m},
                  {"width_median_m", edges.width_median_m},
                  {"width_max_m", edges.width_max_m},
                  {"point_error_p99_m", edges.point_error_p99_m},
                  {"point_error_max_m", edges.point_error_max_m},
                  {"edge_gap_median_m", edges.edge_gap_median_m},
                  {"edge_gap_max_m", edges.edge_gap_max_m},
                  {"folds", json_of(edges.folds)},
                  {"remarks", edges.remarks}};
  out["reference_line"] = {{"length_m", summary.line_length_m},
                           {"closed", edges.closed},
                           {"start_offset_m", edges.start_offset_m}};
  out["grid"] = json_of(summary.grid);
  return finished(out, summary);
}

ValidateLimits limits_of(const BuildSummary& summary) {
  ValidateLimits limits = summary.recipe.limits;
  if (summary.centreline.length_m > 0.0)
    limits.max_share_without_mesh += summary.clean.bridged_m / summary.centreline.length_m;
  return limits;
}

std::vector<std::string> validation_failures(const ValidateReport& report,
                                             const ValidateLimits& limits) {
  std::vector<std::string> failures;
  if (report.points == 0) {
    failures.push_back(
        "no point of the file could be compared with the mesh: do the file and the mesh share a "
        "frame?");
    return failures;
  }
  if (!(report.z_error_m.p99 <= limits.max_z_error_p99_m))
    failures.push_back(
        fmt::format("1 % of the points are more than {:.4g} m from the mesh, at most {:.4g} m "
                    "wanted; the worst is {:.4g} m at u = {:.2f} m, v = {:.2f} m",
                    report.z_error_m.p99, limits.max_z_error_p99_m, report.z_error_m.max,
                    report.worst_u_m, report.worst_v_m));
  const double share = static_cast<double>(report.points_without_mesh) /
                       static_cast<double>(report.points + report.points_without_mesh);
  if (share > limits.max_share_without_mesh)
    failures.push_back(fmt::format("{} of {} points have a height where the mesh has no surface",
                                   report.points_without_mesh,
                                   report.points + report.points_without_mesh));
  if (!(report.seam_z_step_m <= limits.max_seam_z_step_m))
    failures.push_back(
        fmt::format("the height steps by {:.4g} m at the seam, at most {:.4g} m wanted",
                    report.seam_z_step_m, limits.max_seam_z_step_m));
  failures.insert(failures.end(), report.doubts.begin(), report.doubts.end());
  return failures;
}

double peak_memory_mb() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word)
    if (word == "VmHWM:") {
      double kib = 0.0;
      status >> kib;
      return kib * 1024.0 / 1e6;
    }
  return 0.0;
}

}  // namespace road
