#include "stage_json.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "base/json_text.h"

namespace road {

Json json_of(const Recipe& recipe) {
  Json out = Json::object();
  for (const RecipeKey& key : recipe_keys()) {
    if (key.name == "threads") continue;  // any number writes the same bytes, here too
    const std::string text = key.show(recipe);
    if (text.empty())
      out[key.name] = nullptr;
    else if (key.is_text || !Json::accept(text))  // "automatic" in place of a number
      out[key.name] = text;
    else
      out[key.name] = base::parse_json<Json>(text);
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
          {"up_why", report.up_why},
          {"mirrored", report.mirrored},
          {"unit", report.unit},
          {"unit_taken", report.unit_taken},
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
          {"told_by", told_by(report)},
          {"road_agreement", report.road_agreement ? Json(*report.road_agreement) : Json(nullptr)},
          {"vertices_welded", report.vertices_welded},
          {"weld_tolerance_m", report.weld_tolerance_m},
          {"vertices_snapped", report.vertices_snapped},
          {"snap_tolerance_m", report.snap_tolerance_m},
          {"faces_turned", report.faces_turned},
          {"bridging_triangles", report.bridging_triangles},
          {"holes_closed", report.holes_closed},
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
  const auto cut = [&](const char* side, const std::vector<URange>& ranges) {
    if (ranges.empty()) return;
    double length_m = 0.0;
    for (const URange& range : ranges) length_m += range.u_end_m - range.u_begin_m;
    remarks.push_back(fmt::format(
        "beyond the {} edge of the road the surface is not whole and ends early along {:.1f} m, in "
        "{} place{} from u = {:.1f} m on",
        side, length_m, ranges.size(), ranges.size() == 1 ? "" : "s", ranges.front().u_begin_m));
  };
  cut("left", report.cut_left);
  cut("right", report.cut_right);
  return {{"nodes", report.nodes},
          {"nodes_with_z", report.nodes_with_z},
          {"filled", report.filled},
          {"holes", report.holes},
          {"folds", json_of(report.folds)},
          {"neighbours", json_of(report.neighbours)},
          {"walls", json_of(report.walls)},
          {"cut_left", json_of(report.cut_left)},
          {"cut_right", json_of(report.cut_right)},
          {"crossings", crossings},
          {"remarks", remarks}};
}

Json json_of(const RoadEdges& edges, double u_step_m) {
  if (edges.empty()) return nullptr;
  const auto every = static_cast<std::size_t>(std::max(1.0, std::round(1.0 / u_step_m)));
  const auto some = [&](const std::vector<double>& v_m) {
    Json list = Json::array();
    for (std::size_t i = 0; i < v_m.size(); i += every)
      list.push_back(std::round(1e4 * v_m[i]) / 1e4);
    return list;
  };
  Json changes = {{"row", Json::array()}, {"right_m", Json::array()}, {"left_m", Json::array()}};
  for (std::size_t i = 0; i < edges.left_m.size(); ++i) {
    if (i > 0 && edges.left_m[i] == edges.left_m[i - 1] && edges.right_m[i] == edges.right_m[i - 1])
      continue;
    changes["row"].push_back(i);
    changes["right_m"].push_back(edges.right_m[i]);
    changes["left_m"].push_back(edges.left_m[i]);
  }
  return {{"every_rows", every},
          {"right_m", some(edges.right_m)},
          {"left_m", some(edges.left_m)},
          {"changes", changes}};
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
          {"road_points", report.road_points},
          {"road_points_without_mesh", report.road_points_without_mesh},
          {"road_error_p99_m", report.road_error_p99_m},
          {"z_error_m", {{"p50", z.p50}, {"p95", z.p95}, {"p99", z.p99}, {"max", z.max}}},
          {"mean_error_m", report.mean_error_m},
          {"worst_u_m", report.worst_u_m},
          {"worst_v_m", report.worst_v_m},
          {"seam_z_step_m", report.seam_z_step_m},
          {"seam_heading_step_rad", report.seam_heading_step_rad},
          {"rough_places", rough},
          {"remarks", report.remarks}};
}

std::string json_text(const GeoEnds& ends) { return base::json_text(json_of(ends)); }
std::string json_text(const Placement& placement) { return base::json_text(json_of(placement)); }
std::string json_text(const ValidateReport& report, const ValidateLimits& limits) {
  return base::json_text(json_of(report, limits));
}

}  // namespace road
