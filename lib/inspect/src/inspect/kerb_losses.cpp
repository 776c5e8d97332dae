#include "kerb_losses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "map_rows.h"

namespace road {
namespace {

/// Of the rows of the map that the reference is looked at on.
std::size_t stride_of(const HeightMap& map) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(0.5 / map.line.u_step_m + 0.5));
}

/// By how much the file's crest lies lower than the reference's on one row of a kerb.
double loss_at(const HeightMap& map, const HeightMap& reference, const KerbRow& row,
               std::size_t stride) {
  const auto [v_low, v_high] = std::minmax(row.v_begin_m, row.v_end_m);
  float crest_file = -std::numeric_limits<float>::infinity(), crest_reference = crest_file;
  for (std::size_t j = 0; j < map.columns(); ++j) {
    if (map.v_m[j] < v_low - 0.01 || map.v_m[j] > v_high + 0.01) continue;
    const float file = map.at(row.row * stride, j), other = reference.at(row.row, j);
    if (std::isnan(file) || std::isnan(other)) continue;
    crest_file = std::max(crest_file, file);
    crest_reference = std::max(crest_reference, other);
  }
  if (crest_reference > -std::numeric_limits<float>::infinity())
    return static_cast<double>(crest_reference - crest_file);
  return 0.0;
}

/// A stretch of a kerb that lies lower in the file.
struct Loss {
  std::size_t first, last;  // of the kerb's rows
  double worst_m = 0.0, v_low_m, v_high_m;
};

std::vector<Loss> losses_along(const HeightMap& map, const HeightMap& reference,
                               const std::vector<KerbRow>& rows, double least_m) {
  std::vector<Loss> losses;
  bool open = false;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double loss = loss_at(map, reference, rows[k], stride_of(map));
    if (!(loss >= least_m)) {
      open = false;
      continue;
    }
    const auto [v_low, v_high] = std::minmax(rows[k].v_begin_m, rows[k].v_end_m);
    if (!open) losses.push_back({k, k, 0.0, v_low, v_high});
    open = true;
    Loss& last = losses.back();
    last.last = k;
    last.worst_m = std::max(last.worst_m, loss);
    last.v_low_m = std::min(last.v_low_m, v_low);
    last.v_high_m = std::max(last.v_high_m, v_high);
  }
  return losses;
}

}  // namespace

Finding make_finding(const char* kind, double value, const char* unit, Severity severity,
                     std::string text) {
  Finding f;
  f.kind = kind;
  f.value = value;
  f.unit = unit;
  f.severity = severity;
  f.text = std::move(text);
  return f;
}

ReferenceKerbs kerbs_of_reference(const HeightMap& map, const ReferenceHeights& reference,
                                  const CompareOptions& options) {
  ReferenceKerbs out;
  const std::size_t stride = stride_of(map);
  out.map.v_m = map.v_m;
  out.map.z_base_m = map.z_base_m;
  out.map.line.u_begin_m = map.line.u_begin_m;
  out.map.line.u_step_m = map.line.u_step_m * static_cast<double>(stride);
  for (std::size_t i = 0; i < map.rows(); i += stride) {
    out.map.line.x_m.push_back(map.line.x_m[i]);
    out.map.line.y_m.push_back(map.line.y_m[i]);
    out.map.line.heading_rad.push_back(map.line.heading_rad[i]);
  }
  if (out.map.rows() < 2) return out;
  const std::size_t columns = map.columns();
  out.map.z_m.assign(out.map.rows() * columns, std::numeric_limits<float>::quiet_NaN());
  base::parallel_for(out.map.rows(), 32, options.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<crg::Point2> points(columns);
    std::vector<double> z(columns), z_reference(columns);
    for (std::size_t i = begin; i < end; ++i) {
      const RowLine line = line_of(map, place_of(map, map.u_of(i * stride)));
      for (std::size_t j = 0; j < columns; ++j) {
        points[j] = line.at(map.v_m[j]);
        z[j] = map.z_base_m + static_cast<double>(map.at(i * stride, j));
      }
      reference(points, z, z_reference);
      for (std::size_t j = 0; j < columns; ++j)
        out.map.at(i, j) = static_cast<float>(z_reference[j] - map.z_base_m);
    }
  });
  out.kerbs = find_kerb_strips(out.map);
  return out;
}

void find_kerb_losses(const HeightMap& map, const ReferenceKerbs& reference,
                      const std::string& name, const CompareOptions& options, Comparison& result) {
  for (std::size_t s = 0; s < reference.kerbs.strips.size(); ++s) {
    const std::vector<KerbRow>& rows = reference.kerbs.rows[s];
    for (const Loss& loss : losses_along(map, reference.map, rows, options.min_kerb_loss_m)) {
      const double u_begin_m = reference.map.u_of(rows[loss.first].row),
                   u_end_m = reference.map.u_of(rows[loss.last].row);
      if (u_end_m - u_begin_m + reference.map.line.u_step_m < options.min_kerb_loss_length_m)
        continue;
      Finding f = make_finding(
          "kerb_loss", loss.worst_m, "m",
          loss.worst_m > options.max_deviation_m && options.reference_is_truth ? Severity::error
                                                                               : Severity::remark,
          fmt::format(
              "The {} kerb is up to {:.0f} mm lower than in the {} from u = {:.1f} m to {:.1f} m",
              reference.kerbs.strips[s].left ? "left" : "right", 1000.0 * loss.worst_m, name,
              u_begin_m, u_end_m));
      f.u_begin_m = u_begin_m;
      f.u_end_m = u_end_m;
      f.v_begin_m = loss.v_low_m;
      f.v_end_m = loss.v_high_m;
      result.findings.push_back(std::move(f));
    }
  }
}

}  // namespace road
