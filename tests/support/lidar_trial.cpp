#include "support/lidar_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "circuit/circuit.h"
#include "support/places.h"

namespace support {
namespace {

constexpr double kDegree = 0.017453292519943295;

road::CircuitDesign design(bool is_truth) {
  road::CircuitDesign circuit =
      road::read_circuit(places::source() + "/tracks/kerbstone-ring/circuit.yaml").design();
  for (const double u : {420.0, 446.0, 585.0, 612.0, 780.0, 830.0}) {
    road::BumpDesign bump;
    bump.u_m = u, bump.v_m = u < 600.0 ? -2.0 : 1.5;
    bump.length_m = 3.0, bump.width_m = 3.0, bump.height_m = 0.02;
    if (is_truth) circuit.bumps.push_back(bump);
  }
  if (is_truth) return circuit;
  for (std::size_t k = 0; k < circuit.banking.u_m.size(); ++k)
    if (circuit.banking.u_m[k] > 500.0 && circuit.banking.u_m[k] < 530.0)
      circuit.banking.value[k] -= std::tan(kDegree);
  for (road::KerbDesign& kerb : circuit.kerbs)
    if (kerb.u_begin_m == 640.0) kerb.height_m -= 0.03;
  return circuit;
}

}  // namespace

TrialRoads trial_roads(double step_m) {
  return {road::truth_crg(road::Circuit(design(true)), step_m),
          road::truth_crg(road::Circuit(design(false)), step_m)};
}

TrialError measure_trial(const TrialRoads& roads, const cloud::MapResult& result,
                         const cloud::Trajectory& truth, double u_begin_m, double u_end_m) {
  const road::Circuit circuit(design(true));
  const crg::Grid &wanted = roads.truth.grid, &base = roads.base.grid;
  // Both files have the same reference line up to its own height: compare heights over the line.
  const crg::ReferenceLine line = crg::integrate_reference_line(roads.truth),
                           base_line = crg::integrate_reference_line(roads.base);
  const auto lift = [](const crg::ReferenceLine& l, std::size_t i, double v) {
    return (l.z_m.empty() ? 0.0 : l.z_m[i]) + (l.banking.empty() ? 0.0 : l.banking[i] * v);
  };
  TrialError error;
  std::vector<double> errors, kerbs;
  double sum2 = 0.0, base2 = 0.0;
  std::size_t covered = 0, within = 0;
  for (std::size_t i = 0; i < wanted.rows(); ++i) {
    const double u = wanted.u_of(i);
    const road::CrossSection section = road::section_at(circuit, std::min(u, circuit.length_m()));
    const bool inside = u > u_begin_m && u < u_end_m;
    double n = 0.0, sv = 0.0, svv = 0.0, se = 0.0, sve = 0.0, crest = 0.0, crest_wanted = 0.0,
           edge = 0.0, edge_wanted = 0.0;
    bool kerb_seen = false;
    for (std::size_t j = 0; j < wanted.columns(); ++j) {
      const double v = wanted.v_m[j];
      const float source = result.source.at(i, j);
      if (!std::isfinite(source) || source == static_cast<float>(cloud::NodeSource::blended))
        continue;
      if (source < static_cast<float>(cloud::NodeSource::lidar)) {
        error.changed_outside +=
            std::isfinite(base.at(i, j)) && result.grid.at(i, j) != base.at(i, j) ? 1 : 0;
        continue;
      }
      if (!inside) continue;
      const double z = static_cast<double>(result.grid.at(i, j)) + lift(base_line, i, v),
                   z_true = static_cast<double>(wanted.at(i, j)) + lift(line, i, v);
      const double e = z - z_true;
      ++covered;
      within += std::abs(e) <= 1.645 * static_cast<double>(result.stddev.at(i, j)) ? 1 : 0;
      if (u > 645.0 && u < 725.0 && v > section.road_left_m - 0.3 &&
          v < section.road_left_m + 1.5) {
        if (v < section.road_left_m) edge = z, edge_wanted = z_true;
        if (!kerb_seen || z_true > crest_wanted) crest_wanted = z_true, crest = z, kerb_seen = true;
      }
      if (v < section.road_right_m || v > section.road_left_m) continue;
      errors.push_back(std::abs(e));
      sum2 += e * e;
      const double b = static_cast<double>(base.at(i, j)) + lift(base_line, i, v) - z_true;
      base2 += b * b;
      n += 1, sv += v, svv += v * v, se += e, sve += v * e;
    }
    if (n > 30.0)
      error.banking_error_rad =
          std::max(error.banking_error_rad, std::abs((n * sve - sv * se) / (n * svv - sv * sv)));
    if (kerb_seen) kerbs.push_back(std::abs((crest - edge) - (crest_wanted - edge_wanted)));
    if (kerb_seen)
      error.kerb_error_m =
          std::max(error.kerb_error_m, std::abs((crest - edge) - (crest_wanted - edge_wanted)));
  }
  std::sort(errors.begin(), errors.end());
  std::sort(kerbs.begin(), kerbs.end());
  if (!kerbs.empty()) error.kerb_p95_m = kerbs[kerbs.size() * 95 / 100];
  error.road_nodes = errors.size();
  if (!errors.empty()) {
    error.z_rmse_m = std::sqrt(sum2 / static_cast<double>(errors.size()));
    error.base_rmse_m = std::sqrt(base2 / static_cast<double>(errors.size()));
    error.z_p99_m = errors[errors.size() * 99 / 100], error.z_max_m = errors.back();
  }
  error.within_90 =
      static_cast<double>(within) / std::max<double>(1.0, static_cast<double>(covered));
  if (!result.corrected.empty()) {
    const cloud::Trajectory& poses = result.corrected.front();
    double xy2 = 0.0, z2 = 0.0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Eigen::Vector3d d = poses.position_m[i] - truth.position_m[i];
      error.drift_x_m = std::max(error.drift_x_m, std::abs(d.x())),
      error.drift_y_m = std::max(error.drift_y_m, std::abs(d.y())),
      error.drift_z_m = std::max(error.drift_z_m, std::abs(d.z()));
      xy2 += 0.5 * d.head<2>().squaredNorm(), z2 += d.z() * d.z();
    }
    error.drift_rms_xy_m = std::sqrt(xy2 / static_cast<double>(poses.size())),
    error.drift_rms_z_m = std::sqrt(z2 / static_cast<double>(poses.size()));
  }
  return error;
}

std::string describe(const TrialError& e) {
  return fmt::format(
      "road nodes {}: z rmse {:.2f} mm, p99 {:.2f} mm, max {:.2f} mm (base: rmse {:.2f} mm)\n"
      "banking error {:.4f} deg, kerb error {:.2f} mm\n"
      "drift left: x {:.1f}, y {:.1f}, z {:.1f} mm at most; rms {:.1f} mm in x and y, {:.1f} mm in "
      "z\n"
      "90 % intervals cover {:.1f} %; nodes changed outside coverage: {}\n",
      e.road_nodes, 1e3 * e.z_rmse_m, 1e3 * e.z_p99_m, 1e3 * e.z_max_m, 1e3 * e.base_rmse_m,
      e.banking_error_rad / kDegree, 1e3 * e.kerb_error_m, 1e3 * e.drift_x_m, 1e3 * e.drift_y_m,
      1e3 * e.drift_z_m, 1e3 * e.drift_rms_xy_m, 1e3 * e.drift_rms_z_m, 100.0 * e.within_90,
      e.changed_outside);
}

}  // namespace support
