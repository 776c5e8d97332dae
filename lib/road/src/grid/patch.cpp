#include "road/patch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "base/statistics.h"

namespace road {

namespace {

constexpr double kAround_m = 0.3;  // road beside and before the kerb that its patch covers
constexpr double kFinest_m = 0.01;
constexpr std::size_t kLargestRefinement = 16;
constexpr std::size_t kMaxNodes = 20'000'000;  // of one patch
constexpr double kReach_m = 0.3;

/// Rows [first, last] and columns [right, left] of the road's grid.
struct Part {
  std::size_t first, last, right, left;
};

Part part_of(const crg::Grid& grid, const Kerb& kerb) {
  const auto row = [&](double u_m, double rounded) {
    return static_cast<std::size_t>(
        std::clamp(std::floor((u_m - grid.u_begin_m) / grid.u_step_m + rounded), 0.0,
                   static_cast<double>(grid.rows() - 1)));
  };
  const auto column = [&](double v_m) {
    const auto at = std::lower_bound(grid.v_m.begin(), grid.v_m.end(), v_m) - grid.v_m.begin();
    return std::min(static_cast<std::size_t>(at), grid.columns() - 1);
  };
  return {row(kerb.u_begin_m - kAround_m, 0.0), row(kerb.u_end_m + kAround_m, 1.0),
          column(kerb.v_begin_m - kAround_m), column(kerb.v_end_m + kAround_m)};
}

/// The rows of the part, each step divided into `times` equal ones.
crg::ReferenceLine divided(const crg::ReferenceLine& line, const Part& part, std::size_t times) {
  crg::ReferenceLine fine;
  fine.u_step_m = line.u_step_m / static_cast<double>(times);
  for (std::size_t i = part.first; i < part.last; ++i) {
    for (std::size_t m = 0; m < times; ++m) {
      const double t = static_cast<double>(m) / static_cast<double>(times);
      fine.x_m.push_back(line.x_m[i] + t * (line.x_m[i + 1] - line.x_m[i]));
      fine.y_m.push_back(line.y_m[i] + t * (line.y_m[i + 1] - line.y_m[i]));
      // The heading of a node is that of the step before it.
      fine.heading_rad.push_back(line.heading_rad[m == 0 && i > part.first ? i : i + 1]);
    }
  }
  fine.x_m.push_back(line.x_m[part.last]);
  fine.y_m.push_back(line.y_m[part.last]);
  fine.heading_rad.push_back(line.heading_rad[part.last]);
  return fine;
}

/// Height of the mesh near z; nothing where it has none. `is_kerb` where asked.
float height(const RaySurface& surface, const RoadMesh& road, const crg::Point2& p, double z_near_m,
             bool* is_kerb = nullptr) {
  const auto hit = surface.nearest_hit(p.x_m, p.y_m, z_near_m, kReach_m);
  if (!hit) return std::numeric_limits<float>::quiet_NaN();
  if (is_kerb != nullptr) *is_kerb = road.class_of_triangle[hit->triangle] == SurfaceClass::kerb;
  return static_cast<float>(hit->z_m);
}

/// 95 % of |grid - mesh| on the kerb midway between rows first .. last of a grid. NaN where there
/// is no kerb.
double error_between_rows(const crg::Grid& grid, const crg::ReferenceLine& line, const Part& part,
                          const RaySurface& surface, const RoadMesh& road) {
  std::vector<double> errors;
  for (std::size_t i = part.first; i < part.last; ++i) {
    for (std::size_t j = part.right; j <= part.left; ++j) {
      const double middle_m =
          0.5 * (static_cast<double>(grid.at(i, j)) + static_cast<double>(grid.at(i + 1, j)));
      if (std::isnan(middle_m)) continue;
      const crg::Point2 a = crg::node_position(line, i, grid.v_m[j]),
                        b = crg::node_position(line, i + 1, grid.v_m[j]);
      bool is_kerb = false;
      const auto z = static_cast<double>(height(
          surface, road, {0.5 * (a.x_m + b.x_m), 0.5 * (a.y_m + b.y_m)}, middle_m, &is_kerb));
      if (is_kerb) errors.push_back(std::abs(z - middle_m));
    }
  }
  if (errors.empty()) return std::numeric_limits<double>::quiet_NaN();
  return base::quantile(std::move(errors), 0.95);
}

crg::Grid sampled_patch(const crg::Grid& base, const Part& part, std::size_t times,
                        const crg::ReferenceLine& line, const RaySurface& surface,
                        const RoadMesh& road) {
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  grid.v_m.assign(base.v_m.begin() + static_cast<std::ptrdiff_t>(part.right),
                  base.v_m.begin() + static_cast<std::ptrdiff_t>(part.left) + 1);
  grid.z_m.resize(line.size() * grid.v_m.size());
  for (std::size_t i = 0; i < line.size(); ++i) {
    for (std::size_t j = 0; j < grid.v_m.size(); ++j) {
      const std::size_t row = part.first + i / times, next = std::min(row + 1, part.last);
      const double near_m = 0.5 * (static_cast<double>(base.at(row, part.right + j)) +
                                   static_cast<double>(base.at(next, part.right + j)));
      grid.at(i, j) = std::isnan(near_m)
                          ? std::numeric_limits<float>::quiet_NaN()
                          : height(surface, road, crg::node_position(line, i, grid.v_m[j]), near_m);
    }
  }
  return grid;
}

}  // namespace

std::vector<KerbPatch> patch_kerbs(const SampledGrid& sampled, const RaySurface& surface,
                                   const RoadMesh& road, const crg::ReferenceLine& line,
                                   const std::vector<Kerb>& kerbs, const PatchOptions& options) {
  std::vector<KerbPatch> patches;
  if (!(options.max_error_m > 0.0)) return patches;
  std::vector<KerbPatch> of_kerb(kerbs.size());
  base::parallel_for(kerbs.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const crg::Grid& grid = sampled.grid;
      const Part part = part_of(grid, kerbs[k]);
      if (part.last <= part.first || part.left <= part.right) continue;
      KerbPatch& patch = of_kerb[k];
      patch.error_before_m = error_between_rows(grid, line, part, surface, road);
      if (!(patch.error_before_m > options.max_error_m)) continue;
      for (std::size_t times = 2; times <= kLargestRefinement &&
                                  line.u_step_m / static_cast<double>(times) >= kFinest_m - 1e-9;
           times *= 2) {
        if ((part.last - part.first) * times * (part.left - part.right + 1) > kMaxNodes) break;
        patch.line = divided(line, part, times);
        patch.grid = sampled_patch(grid, part, times, patch.line, surface, road);
        const Part whole{0, patch.line.size() - 1, 0, patch.grid.columns() - 1};
        patch.error_m = error_between_rows(patch.grid, patch.line, whole, surface, road);
        if (patch.error_m <= options.max_error_m) break;
      }
      patch.u_begin_m = grid.u_of(part.first);
      patch.u_end_m = grid.u_of(part.last);
    }
  });
  for (KerbPatch& patch : of_kerb)
    if (patch.line.size() > 0) patches.push_back(std::move(patch));
  return patches;
}

}  // namespace road
