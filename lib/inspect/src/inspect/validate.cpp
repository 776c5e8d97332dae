#include "inspect/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "crg/surface.h"
#include "mesh/error.h"
#include "mesh/ray_surface.h"
#include "rough_places.h"

namespace road {

namespace {

/// Uniform in [0, 1), the same on every machine (std::uniform_real_distribution is not).
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

ErrorQuantiles quantiles(std::vector<double>& errors) {
  if (errors.empty()) return {};
  std::sort(errors.begin(), errors.end());
  const auto at = [&](double share) {
    return errors[static_cast<std::size_t>(share * static_cast<double>(errors.size() - 1))];
  };
  return {at(0.50), at(0.95), at(0.99), errors.back()};
}

void check_seam(const crg::Surface& road, const RoadEdges& edges, ValidateReport& report) {
  const crg::ReferenceLine& line = road.reference_line();
  const crg::Grid& grid = road.grid();
  if (!line.closed || grid.rows() < 2) return;
  const std::size_t last = grid.rows() - 1;
  for (std::size_t j = 0; j < grid.columns(); ++j) {
    if (!edges.has(0, grid.v_m[j])) continue;
    const auto step = static_cast<double>(std::abs(grid.at(last, j) - grid.at(0, j)));
    if (step > report.seam_z_step_m) report.seam_z_step_m = step;
  }
  // What is left of the turn from the last segment to the first after the turn that the line itself
  // makes there, half of that at each of its two neighbouring corners.
  const std::size_t n = line.size();
  if (n < 4) return;
  const double at_seam = std::remainder(line.heading_rad[1] - line.heading_rad[n - 1], 2.0 * M_PI);
  const double before =
      std::remainder(line.heading_rad[n - 1] - line.heading_rad[n - 2], 2.0 * M_PI);
  const double after = std::remainder(line.heading_rad[2] - line.heading_rad[1], 2.0 * M_PI);
  report.seam_heading_step_rad = std::abs(at_seam - 0.5 * (before + after));
}

}  // namespace

ValidateReport validate(const std::string& crg_path, const Mesh& original,
                        const ValidateOptions& options) {
  return validate(crg::Surface(crg::read(crg_path)), RaySurface(original), options);
}

ValidateReport validate(const crg::Surface& road, const RaySurface& mesh,
                        const ValidateOptions& options) {
  const crg::Grid& grid = road.grid();
  if (grid.rows() < 2 || grid.columns() < 2)
    throw Error(fmt::format("{}: a grid of {} x {} nodes has no area to compare",
                            road.file().source, grid.rows(), grid.columns()));

  ValidateReport report;
  check_seam(road, options.edges, report);
  std::mt19937_64 random(options.seed);
  std::vector<double> errors, road_errors;
  std::vector<RoughPoint> rough;
  double sum = 0.0;
  std::size_t over_cracks = 0;
  const auto remember = [&](double u_m, double v_m, double error) {
    if (std::abs(error) <= std::abs(report.worst_error_m)) return;
    report.worst_u_m = u_m;
    report.worst_v_m = v_m;
    report.worst_error_m = error;
  };
  const double u_length_m = static_cast<double>(grid.rows() - 1) * grid.u_step_m;
  // Points fall evenly over the box of the grid; those without road do not count, but bound the
  // tries.
  for (std::size_t tries = 0;
       tries < 50 * options.points &&
       errors.size() + report.points_without_mesh + over_cracks < options.points;
       ++tries) {
    const double u_m = grid.u_begin_m + u_length_m * uniform(random);
    const double v_m = grid.v_m.front() + (grid.v_m.back() - grid.v_m.front()) * uniform(random);
    if (std::isnan(road.z_at_uv(u_m, v_m))) continue;
    const auto found = error_at(road, mesh, options, u_m, v_m);
    const bool on_road =
        options.edges.has(static_cast<std::size_t>((u_m - grid.u_begin_m) / grid.u_step_m), v_m);
    if (!found && is_over_crack(road, mesh, options, u_m, v_m)) {
      ++over_cracks;
      continue;
    }
    if (!found) {
      ++report.points_without_mesh;
      report.road_points_without_mesh += on_road ? 1 : 0;
      continue;
    }
    const double error = *found;
    if (std::abs(error) > options.named_error_m) rough.push_back({u_m, v_m, error});
    if (on_road) road_errors.push_back(std::abs(error));
    sum += error;
    errors.push_back(std::abs(error));
    remember(u_m, v_m, error);
  }
  if (over_cracks > 0)
    report.remarks.push_back(fmt::format(
        "{} of {} points lie over cracks of the mesh of a few centimetres, closed in the file",
        over_cracks, errors.size() + report.points_without_mesh + over_cracks));
  report.points = errors.size();
  if (!errors.empty()) report.mean_error_m = sum / static_cast<double>(errors.size());
  report.z_error_m = quantiles(errors);
  report.road_points = road_errors.size();
  report.road_error_p99_m = quantiles(road_errors).p99;
  report.rough_places = find_rough_places(road, mesh, options, std::move(rough));
  for (const RoughPlace& place : report.rough_places)
    remember(place.worst_u_m, place.worst_v_m, place.worst_error_m);
  if (report.points > 0) report.z_error_m.max = std::abs(report.worst_error_m);
  const std::size_t fell = report.points + report.points_without_mesh + over_cracks;
  if (fell < options.points) {
    report.remarks.push_back(
        fmt::format("only {} of {} random points fell on the road", fell, options.points));
  }
  return report;
}

}  // namespace road
