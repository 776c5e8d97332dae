#include "residuals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/parallel.h"

namespace road {
namespace {

/// Rows before and behind, how far they lie away, and their weights in the value at 0 of the
/// least-squares quadratic; its linear part drops out by symmetry (the offsets are symmetric to
/// within one stride).
struct Shoulders {
  std::vector<std::ptrdiff_t> offsets;
  std::vector<double> weights, distance_m;
};

Shoulders shoulders_of(double step_m, std::size_t stride) {
  Shoulders s;
  const auto near = static_cast<std::ptrdiff_t>(kShoulderNear_m / step_m),
             far = static_cast<std::ptrdiff_t>(kShoulderFar_m / step_m);
  double count = 0.0, s2 = 0.0, s4 = 0.0;
  for (std::ptrdiff_t k = -far; k <= far; k += static_cast<std::ptrdiff_t>(stride)) {
    if (std::abs(k) < near) continue;
    const double d = static_cast<double>(k) * step_m;
    s.offsets.push_back(k);
    s.distance_m.push_back(d);
    count += 1.0, s2 += d * d, s4 += d * d * d * d;
  }
  double sum = 0;
  for (const double d : s.distance_m) {
    s.weights.push_back((s4 - s2 * d * d) / (count * s4 - s2 * s2));
    sum += s.weights.back();
  }
  for (double& w : s.weights) w /= sum;
  return s;
}

/// The row at an offset; nothing beyond the ends of an open road.
std::optional<std::size_t> row_at(const HeightMap& map, std::size_t row, std::ptrdiff_t offset,
                                  bool closed) {
  const auto period = static_cast<std::ptrdiff_t>(map.rows() - 1);
  std::ptrdiff_t at = static_cast<std::ptrdiff_t>(row) + offset;
  if (closed) at = (at % period + period) % period;
  if (at < 0 || at >= static_cast<std::ptrdiff_t>(map.rows())) return std::nullopt;
  return static_cast<std::size_t>(at);
}

/// The quadratics of all columns at one row, where no height is missing; false where the road ends.
bool fit_row(const HeightMap& map, std::size_t row, const Shoulders& shoulders, bool closed,
             std::vector<double>& base) {
  std::fill(base.begin(), base.end(), 0.0);
  for (std::size_t k = 0; k < shoulders.offsets.size(); ++k) {
    const auto at = row_at(map, row, shoulders.offsets[k], closed);
    if (!at) return false;
    const float* z = map.z_m.data() + *at * map.columns();
    const double w = shoulders.weights[k];
    for (std::size_t j = 0; j < base.size(); ++j) base[j] += w * static_cast<double>(z[j]);
  }
  return true;
}

/// Where heights are missing before or behind: the same quadratic through those that are there.
std::optional<double> fit_what_is_there(const HeightMap& map, std::size_t row, std::size_t column,
                                        const Shoulders& shoulders, bool closed) {
  double m[5] = {}, t[3] = {};
  std::size_t before = 0, behind = 0;
  for (std::size_t k = 0; k < shoulders.offsets.size(); ++k) {
    const auto at = row_at(map, row, shoulders.offsets[k], closed);
    if (!at) continue;
    const double height = map.at(*at, column), s = shoulders.distance_m[k];
    if (std::isnan(height)) continue;
    (s < 0 ? before : behind) += 1;
    double power = 1.0;
    for (int p = 0; p < 5; ++p, power *= s) m[p] += power;
    t[0] += height, t[1] += s * height, t[2] += s * s * height;
  }
  const std::size_t enough = shoulders.offsets.size() * 3 / 10;
  if (before < enough || behind < enough) return std::nullopt;
  const double det = m[0] * (m[2] * m[4] - m[3] * m[3]) - m[1] * (m[1] * m[4] - m[3] * m[2]) +
                     m[2] * (m[1] * m[3] - m[2] * m[2]);
  return (t[0] * (m[2] * m[4] - m[3] * m[3]) - m[1] * (t[1] * m[4] - m[3] * t[2]) +
          m[2] * (t[1] * m[3] - m[2] * t[2])) /
         det;
}

}  // namespace

Residuals residuals(const HeightMap& map, const FindingOptions& options) {
  Residuals r;
  const double step_m = map.line.u_step_m;
  if (step_m > 1.0 || map.rows() < 8) return r;
  const auto stride = std::max<std::size_t>(1, static_cast<std::size_t>(0.2 / step_m + 0.5));
  for (std::size_t i = 0; i < map.rows(); i += stride) r.row.push_back(i);
  for (std::size_t j = 0; j < map.columns(); ++j) {
    if (r.column.empty() || map.v_m[j] - map.v_m[r.column.back()] > 0.19) r.column.push_back(j);
  }
  const Shoulders shoulders = shoulders_of(step_m, stride);
  r.z_m.assign(r.row.size() * r.column.size(), std::numeric_limits<float>::quiet_NaN());
  base::parallel_for(r.row.size(), 256, options.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<double> base(map.columns());
    for (std::size_t a = begin; a < end; ++a) {
      const bool inside = fit_row(map, r.row[a], shoulders, options.closed, base);
      for (std::size_t b = 0; b < r.column.size(); ++b) {
        const std::size_t j = r.column[b];
        const double z = map.at(r.row[a], j);
        if (std::isnan(z)) continue;
        std::optional<double> fitted;
        if (inside && !std::isnan(base[j]))
          fitted = base[j];
        else
          fitted = fit_what_is_there(map, r.row[a], j, shoulders, options.closed);
        if (fitted) r.z_m[a * r.column.size() + b] = static_cast<float>(z - *fitted);
      }
    }
  });
  return r;
}

void leave_out_kerbs(const HeightMap& map, const KerbStrips& kerbs, Residuals& r) {
  const double margin_u_m = kShoulderFar_m + 1.0, margin_v_m = 0.4;
  const double step_m = map.u_of(r.row.size() > 1 ? r.row[1] : 1) - map.u_of(r.row[0]);
  for (const std::vector<KerbRow>& rows : kerbs.rows) {
    const double begin_m = map.u_of(rows.front().row) - margin_u_m,
                 end_m = map.u_of(rows.back().row) + margin_u_m;
    std::size_t k = 0;
    const auto first = static_cast<std::size_t>(
        std::max(0.0, std::floor((begin_m - map.line.u_begin_m) / step_m)));
    for (std::size_t a = first; a < r.row.size() && map.u_of(r.row[a]) <= end_m; ++a) {
      // The kerb as it lies between 10 m before and 10 m behind this row.
      double low = std::numeric_limits<double>::infinity(), high = -low;
      while (k < rows.size() && map.u_of(rows[k].row) < map.u_of(r.row[a]) - margin_u_m) ++k;
      for (std::size_t q = std::min(k, rows.size() - 1); q < rows.size(); ++q) {
        if (q > k && map.u_of(rows[q].row) > map.u_of(r.row[a]) + margin_u_m) break;
        low = std::min({low, rows[q].v_begin_m, rows[q].v_end_m});
        high = std::max({high, rows[q].v_begin_m, rows[q].v_end_m});
      }
      for (std::size_t b = 0; b < r.column.size(); ++b) {
        const double v_m = map.v_m[r.column[b]];
        if (v_m > low - margin_v_m && v_m < high + margin_v_m)
          r.z_m[a * r.column.size() + b] = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
}

}  // namespace road
