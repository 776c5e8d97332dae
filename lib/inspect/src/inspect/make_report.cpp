#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/sha256.h"
#include "crg/check.h"
#include "crg/surface.h"
#include "inspect/compare.h"
#include "inspect/height_map.h"
#include "inspect/kerb_strips.h"
#include "inspect/write_report.h"
#include "mesh/error.h"
#include "mesh/ray_surface.h"
#include "report/track_report.h"
#include "report_curves.h"
#include "report_facts.h"
#include "report_sheets.h"
#include "report_views.h"

namespace road {
namespace {

/// Kerbs found on the mesh in the form of those found by shape.
KerbStrips strips_of(const std::vector<Kerb>& kerbs) {
  KerbStrips result;
  for (const Kerb& kerb : kerbs) {
    const bool left = kerb.v_begin_m + kerb.v_end_m > 0.0;
    const auto [inner_m, outer_m] =
        left ? std::pair(kerb.v_begin_m, kerb.v_end_m) : std::pair(kerb.v_end_m, kerb.v_begin_m);
    result.strips.push_back({kerb.u_begin_m, kerb.u_end_m, left, inner_m, outer_m, kerb.height_m,
                             kerb.v_end_m - kerb.v_begin_m, kerb.u_highest_m});
  }
  return result;
}

void add_input(const char* role, const std::string& path, const ReportRequest& request,
               report::TrackReport& report) {
  report.inputs.push_back({role, shown_path(path, request), base::sha256_of_file(path)});
}

/// Where the mesh lies, and how it was tilted and scaled before.
struct MeshPlace {
  RotoTranslation T_global_mesh;
  TiltAndScale tilt_and_scale;
};

/// Fits the control points where there are some, and shows them.
MeshPlace place_mesh(const ReportRequest& request, report::TrackReport& report) {
  if (request.control_points.empty()) return {request.T_global_mesh, {}};
  const AlignReport aligned = fit_alignment(request.control_points, request.align);
  for (std::size_t k = 0; k < request.control_points.size(); ++k) {
    const ControlPoint& point = request.control_points[k];
    const bool left_out = std::find(aligned.outliers.begin(), aligned.outliers.end(), point.name) !=
                          aligned.outliers.end();
    report.control_points.push_back(
        {point.name, point.global_m.x(), point.global_m.y(), aligned.residual_m[k], left_out});
  }
  return {aligned.T_global_mesh, aligned.tilt_and_scale};
}

/// Everything that there is to compare with, and what came out.
struct Compared {
  Comparisons comparisons;
  std::optional<ValidateReport> validated;
  std::string mesh_up;  ///< as in ReportRequest
  std::optional<crg::Surface> before;
};

/// The road that the report is about, in the forms that its parts look at.
struct Road {
  const crg::Surface& surface;
  const HeightMap& map;
  const KerbStrips& kerbs;
  const RoadEdges& edges;
  /// For the comparison with the mesh; empty where a build has judged that.
  std::optional<ValidateLimits> limits;
};

void compare_with(const std::string& key, const std::string& name,
                  const ReferenceHeights& reference, const Road& road, bool is_truth,
                  unsigned threads, Comparisons& comparisons,
                  std::span<const PlaceError> known = {}) {
  CompareOptions options;
  options.max_cells = 600'000;  // 2.4 MB of the page each
  options.reference_is_truth = is_truth;
  options.edges = road.edges;
  options.limits = road.limits;
  options.threads = threads;
  comparisons.emplace_back(key, compare(road.map, road.kerbs, reference, name, options, known));
}

void compare_with_mesh(const Road& road, const ReportRequest& request, Compared& compared,
                       report::TrackReport& report) {
  const MeshPlace place = place_mesh(request, report);
  if (request.mesh == nullptr && request.mesh_path.empty()) return;
  compared.mesh_up = request.mesh_up;
  std::optional<Mesh> mesh;
  if (request.mesh == nullptr) {
    MeshReadReport read;
    mesh = read_mesh(request.mesh_path, request.read, &read);
    compared.mesh_up = read.up + ", " + read.up_why;
    apply_to_mesh(place.tilt_and_scale, *mesh);
  }
  if (!request.mesh_path.empty()) add_input("mesh", request.mesh_path, request, report);
  const RaySurface rays(request.mesh != nullptr ? *request.mesh : *mesh);
  ValidateOptions validation = request.validate;
  validation.T_global_mesh = place.T_global_mesh;
  validation.threads = request.threads;
  compared.validated =
      request.validated ? *request.validated : validate(road.surface, rays, validation);
  const ValidateReport& validated = *compared.validated;
  report.rough_limit_m = validation.named_error_m;
  std::vector<PlaceError> known{
      {validated.worst_u_m, validated.worst_v_m, validated.worst_error_m}};
  for (const RoughPlace& p : validated.rough_places) {
    report.rough_places.push_back(
        {p.u_begin_m, p.u_end_m, p.v_min_m, p.v_max_m, p.largest_error_m, p.reason});
    known.push_back({p.worst_u_m, p.worst_v_m, p.worst_error_m});
  }
  compare_with("mesh", "mesh", reference_of(rays, place.T_global_mesh), road, true, request.threads,
               compared.comparisons, known);
  // The numbers of the map's cells would be others than those of the validation; one of both is
  // told.
  Comparison& told = compared.comparisons.back().second;
  told.points = validated.points;
  told.mean_error_m = validated.mean_error_m;
  told.abs_error_m = validated.z_error_m;
}

Compared compare_all(const Road& road, const ReportRequest& request, report::TrackReport& report) {
  Compared compared;
  compare_with_mesh(road, request, compared, report);
  const auto compare_change = [&](const std::string& key, const std::string& name,
                                  const ReferenceHeights& reference) {
    compare_with(key, name, reference, road, false, request.threads, compared.comparisons);
  };
  if (!request.against_path.empty()) {
    const crg::Surface against(crg::read(request.against_path));
    add_input("against", request.against_path, request, report);
    compare_change("against", file_name(request.against_path), reference_of(against));
  }
  if (!request.cloud_path.empty())
    compare_change("cloud", "cloud", reference_of(request.cloud_points_m));
  if (request.before != nullptr || !request.before_path.empty()) {
    compared.before.emplace(request.before != nullptr
                                ? crg::Surface(*request.before)
                                : crg::Surface(crg::read(request.before_path)));
    if (request.before == nullptr) add_input("before", request.before_path, request, report);
    compare_change("before", "road before refinement", reference_of(*compared.before));
    // That smoothing moved the road is its purpose; that it took a kerb away is not.
    std::erase_if(compared.comparisons.back().second.findings,
                  [](const Finding& f) { return f.kind != "kerb_loss"; });
  }
  return compared;
}

/// What the format's rules say of the file: findings, or notes where the road can be used.
void add_checked(const crg::CheckReport& checked, const HeightMap& map,
                 std::vector<Finding>& findings, report::TrackReport& report) {
  for (const crg::Finding& c : checked.findings) {
    // That lateral cuts would meet where nobody has road is no fault of the road; where there are
    // heights it is a fold, and a finding of its own.
    if (c.severity == crg::Severity::Note || c.rule.starts_with("curvature.")) {
      report.notes.push_back(fmt::format("{}: {}", c.rule, c.message));
      continue;
    }
    Finding f;
    f.kind = "file";
    f.u_begin_m = c.row ? map.u_of(std::min(*c.row, map.rows() - 1)) : map.line.u_begin_m;
    f.u_end_m = c.row ? f.u_begin_m : map.u_end_m();
    f.v_begin_m = map.v_m.front();
    f.v_end_m = map.v_m.back();
    f.value = static_cast<double>(c.count);
    f.unit = "1";
    f.severity = c.severity == crg::Severity::Error ? Severity::error : Severity::remark;
    f.text = fmt::format("{}: {}", c.rule, c.message);
    findings.push_back(std::move(f));
  }
}

/// What the build that made the road says against its use.
void add_failures(const std::vector<std::string>& failures, const HeightMap& map,
                  std::vector<Finding>& findings) {
  for (const std::string& failure : failures)
    findings.push_back({"validation", map.line.u_begin_m, map.u_end_m(), map.v_m.front(),
                        map.v_m.back(), 1.0, "1", Severity::error, failure});
}

void add_findings(const std::vector<Finding>& findings, report::TrackReport& report) {
  report.verdict = to_string(verdict_of(findings));
  for (const Finding& f : findings) {
    report.findings.push_back({f.kind, to_string(f.severity), f.u_begin_m, f.u_end_m, f.v_begin_m,
                               f.v_end_m, f.value, f.unit, f.text});
  }
}

void add_comparisons(const Comparisons& comparisons, const ReportRequest& request,
                     report::TrackReport& report) {
  for (const auto& [key, comparison] : comparisons) {
    const std::string reference = key == "mesh"      ? file_name(request.mesh_path)
                                  : key == "against" ? file_name(request.against_path)
                                  : key == "cloud"   ? file_name(request.cloud_path)
                                                     : "before refinement";
    report.comparisons.push_back(view_of(comparison, key, reference));
  }
}

}  // namespace

report::TrackReport make_report(const ReportRequest& request) {
  report::TrackReport report;
  report.title = request.title.empty() ? file_name(request.crg_path) : request.title;
  report.command_line = request.command_line;
  report.notes = request.remarks;
  add_input("road", request.crg_path, request, report);

  crg::Crg stored = crg::read(request.crg_path);
  const crg::CheckReport checked = crg::check(stored);
  const crg::Surface surface(std::move(stored));
  const crg::Crg& file = surface.file();
  const HeightMap map = height_map(surface);
  const std::vector<RowExtent> extents = row_extents(map);
  if (request.provenance != nullptr && request.provenance->size() != map.z_m.size()) {
    throw Error(fmt::format("{}: {} values of provenance for {} nodes", request.crg_path,
                            request.provenance->size(), map.z_m.size()));
  }
  if (!request.edges.empty() && request.edges.left_m.size() != map.rows())
    throw Error(fmt::format("{}: edges of {} rows for {} rows", request.crg_path,
                            request.edges.left_m.size(), map.rows()));
  const KerbStrips by_shape = find_kerb_strips(map);
  const KerbStrips kerbs = request.kerbs ? strips_of(*request.kerbs) : by_shape;
  FindingOptions finding_options;
  finding_options.closed = map.line.closed;
  finding_options.edges = request.edges;
  finding_options.threads = request.threads;
  std::vector<Finding> findings = find_defects(map, by_shape, finding_options);
  add_failures(request.failures, map, findings);

  const Compared compared =
      compare_all({surface, map, kerbs, request.edges,
                   request.validated ? std::nullopt : std::optional(request.limits)},
                  request, report);
  std::optional<crg::Surface> grip;
  if (!request.grip_path.empty()) {
    grip.emplace(crg::read(request.grip_path));
    add_input("grip", request.grip_path, request, report);
  }
  for (const auto& [key, comparison] : compared.comparisons)
    findings.insert(findings.end(), comparison.findings.begin(), comparison.findings.end());
  mark_beyond(request.edges, map, findings);
  add_checked(checked, map, findings, report);
  const AlongU along = along_u(map, extents);
  add_published(map, along, request, findings, report);
  std::stable_sort(findings.begin(), findings.end(),
                   [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
  add_findings(findings, report);
  add_rules(finding_options, request.limits, findings, compared.validated, report);
  add_looked_for(finding_options, compared.comparisons, report);

  report.closed = map.line.closed;
  add_curves(map, along, compared.comparisons, report);
  add_facts(map, along, file, request, kerbs, compared.validated, report);
  if (!compared.mesh_up.empty()) report.facts.push_back({"Up in the mesh", compared.mesh_up});
  if (!request.mesh_unit.empty()) report.facts.push_back({"Unit of the mesh", request.mesh_unit});
  add_header(file, report);
  report.sheet =
      whole_road(map, along, compared.comparisons, grip ? &*grip : nullptr, request.provenance);
  add_windows(map, findings, kerbs, report);
  add_detail(map, report);
  add_kerbs(map, kerbs, compared.comparisons, report);
  const double middle_m = middle_of_road(map, extents);
  add_roughness(map, middle_m, false, report);
  if (compared.before) add_roughness(height_map(*compared.before), middle_m, true, report);
  add_comparisons(compared.comparisons, request, report);
  for (const ReportSource& source : request.sources)
    report.inputs.push_back({source.role, source.path, source.sha256});
  report.versions.push_back({"Kerbstone", KERBSTONE_VERSION});
  report.versions.push_back({"Report schema", "1"});
  return report;
}

}  // namespace road
