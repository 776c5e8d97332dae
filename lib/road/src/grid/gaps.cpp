#include "road/gaps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/parallel.h"
#include "mesh/ray_surface.h"
#include "u_ranges.h"

namespace road {

namespace {

// From a place in a crack, to meet its sides: a crack of 3 cm is always found, none beyond 7 cm.
constexpr std::array<double, 4> kAside_m{0.001, 0.003, 0.01, 0.035};
constexpr double kCrackStep_m = 0.02;  // between its sides
constexpr double kCrackOff_m = 0.1;    // from the height of the row
constexpr double kLowest_m =
    0.05;  // what lies lower is the ground itself, a millimetre or a kerb off
constexpr double kHighest_m = 3.0;  // what begins higher spans the track
constexpr double kBeside_m = 0.5;   // from the gap: what stands here too is no wall
constexpr double kWidest_m = 1.0;   // of a gap; sampling ends the surface at wider ones

struct Row {
  SampledGrid& sampled;
  const crg::ReferenceLine& line;
  const RaySurface& everything;
  std::size_t i;

  std::size_t node(std::ptrdiff_t j) const {
    return i * sampled.grid.columns() + static_cast<std::size_t>(j);
  }
  Provenance provenance(std::ptrdiff_t j) const { return sampled.provenance[node(j)]; }
  double v_m(std::ptrdiff_t j) const { return sampled.grid.v_m[static_cast<std::size_t>(j)]; }
  double z_m(std::ptrdiff_t j) const { return static_cast<double>(sampled.grid.z_m[node(j)]); }

  bool stands_above(double at_v_m, double ground_m) const {
    const crg::Point2 p = crg::node_position(line, i, at_v_m);
    const double middle_m = ground_m + 0.5 * (kLowest_m + kHighest_m);
    return everything.nearest_hit(p.x_m, p.y_m, middle_m, 0.5 * (kHighest_m - kLowest_m))
        .has_value();
  }

  bool is_wall(std::ptrdiff_t inner, std::ptrdiff_t outer) const {
    const auto is_road = [&](std::ptrdiff_t j) {
      return sampled.surface_class[node(j)] == SurfaceClass::road;
    };
    if (std::abs(v_m(outer) - v_m(inner)) > kWidest_m || (is_road(inner) && is_road(outer)))
      return false;
    const std::ptrdiff_t step = outer > inner ? 1 : -1;
    const double beside_m = kBeside_m * static_cast<double>(step);
    if (stands_above(v_m(inner) - beside_m, z_m(inner)) &&
        stands_above(v_m(outer) + beside_m, z_m(outer)))
      return false;
    for (std::ptrdiff_t j = inner + step; j != outer; j += step) {
      const double t = (v_m(j) - v_m(inner)) / (v_m(outer) - v_m(inner));
      if (stands_above(v_m(j), z_m(inner) + t * (z_m(outer) - z_m(inner)))) return true;
    }
    return false;
  }

  /// Whether the row ended at a wall on this side.
  bool end_side(std::ptrdiff_t start, std::ptrdiff_t step) {
    const auto columns = static_cast<std::ptrdiff_t>(sampled.grid.columns());
    std::ptrdiff_t inner = -1;
    for (std::ptrdiff_t j = start; j >= 0 && j < columns; j += step) {
      if (provenance(j) != Provenance::mesh) continue;
      if (inner >= 0 && std::abs(j - inner) > 1 && is_wall(inner, j)) {
        for (std::ptrdiff_t k = inner + step; k >= 0 && k < columns; k += step) {
          sampled.grid.z_m[node(k)] = std::numeric_limits<float>::quiet_NaN();
          sampled.provenance[node(k)] = Provenance::none;
        }
        return true;
      }
      inner = j;
    }
    return false;
  }
};

}  // namespace

std::optional<std::array<SurfaceHit, 2>> sides_of_crack(const RaySurface& surface,
                                                        const Eigen::Vector3d& at_m,
                                                        const Eigen::Vector2d& across) {
  for (const double aside_m : kAside_m) {
    for (const auto& [dx, dy] : {std::pair{across.x(), across.y()}, {across.y(), -across.x()}}) {
      const auto a = surface.nearest_hit(at_m.x() - aside_m * dx, at_m.y() - aside_m * dy, at_m.z(),
                                         kCrackOff_m);
      const auto b = surface.nearest_hit(at_m.x() + aside_m * dx, at_m.y() + aside_m * dy, at_m.z(),
                                         kCrackOff_m);
      if (a && b && std::abs(a->z_m - b->z_m) <= kCrackStep_m) return std::array{*a, *b};
    }
  }
  return std::nullopt;
}

void count_nodes(const SampledGrid& sampled, SampleReport& report) {
  const std::size_t rows = sampled.grid.rows(), columns = sampled.grid.columns();
  report.nodes_with_z = report.filled = report.holes = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    std::size_t with_z = 0, first = columns, last = 0;
    for (std::size_t j = 0; j < columns; ++j) {
      const Provenance provenance = sampled.provenance[i * columns + j];
      if (provenance == Provenance::none) continue;
      report.filled += provenance == Provenance::filled ? 1 : 0;
      first = std::min(first, j);
      last = j;
      ++with_z;
    }
    report.nodes_with_z += with_z;
    if (with_z > 0) report.holes += last - first + 1 - with_z;
  }
}

void close_cracks(SampledGrid& sampled, const RaySurface& surface, const RoadMesh& road,
                  const crg::ReferenceLine& line, SampleReport& report) {
  if (report.holes == 0) return;
  const std::size_t rows = sampled.grid.rows(), columns = sampled.grid.columns();
  for (std::size_t i = 0; i < rows; ++i) {
    std::size_t known = columns;  // the last node of the row with a height
    for (std::size_t j = 0; j < columns; ++j) {
      const std::size_t node = i * columns + j;
      if (sampled.provenance[node] == Provenance::none) continue;
      for (std::size_t k = known + 1; k < j; ++k) {
        const auto& v_m = sampled.grid.v_m;
        const double t = (v_m[k] - v_m[known]) / (v_m[j] - v_m[known]),
                     from = sampled.grid.at(i, known), to = sampled.grid.at(i, j);
        const crg::Point2 p = crg::node_position(line, i, v_m[k]),
                          q = crg::node_position(line, i, v_m[k] + 1.0);
        const auto sides = sides_of_crack(surface, {p.x_m, p.y_m, from + t * (to - from)},
                                          {q.x_m - p.x_m, q.y_m - p.y_m});
        if (!sides) continue;
        const std::size_t open = i * columns + k;
        sampled.grid.z_m[open] = static_cast<float>(0.5 * ((*sides)[0].z_m + (*sides)[1].z_m));
        sampled.provenance[open] = Provenance::filled;
        sampled.surface_class[open] = road.class_of_triangle[(*sides)[0].triangle];
      }
      known = j;
    }
  }
  count_nodes(sampled, report);
}

void end_at_walls(SampledGrid& sampled, const crg::ReferenceLine& line, const Mesh& everything,
                  unsigned threads, SampleReport& report) {
  if (report.filled == 0 && report.holes == 0) return;
  const RaySurface surface(everything);
  const std::size_t rows = sampled.grid.rows(), columns = sampled.grid.columns();
  const auto& v_m = sampled.grid.v_m;
  const auto middle = std::min(std::lower_bound(v_m.begin(), v_m.end(), 0.0) - v_m.begin(),
                               static_cast<std::ptrdiff_t>(columns) - 1);
  std::vector<char> ended(rows, 0);
  base::parallel_for(rows, 256, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Row row{sampled, line, surface, i};
      const bool left = row.end_side(middle, 1), right = row.end_side(middle, -1);
      ended[i] = left || right ? 1 : 0;
    }
  });
  report.walls = ranges_of(ended, line.u_step_m);
  if (report.walls.empty()) return;
  count_nodes(sampled, report);
}

}  // namespace road
