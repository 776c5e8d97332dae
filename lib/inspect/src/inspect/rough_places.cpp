#include "rough_places.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.h"
#include "road/gaps.h"

namespace road {

namespace {

constexpr double kJoin_m = 2.0;  // points of one reason closer than this along u are one stretch
constexpr double kTwoSurfacesApart_m = 0.01;
constexpr double kNodeOff_m = 0.005;  // a node this far from the mesh is not on it
constexpr std::size_t kCellsPerRow =
    16;  // looked at in a row; evenly spread where more of them bend
constexpr std::size_t kPlacesBack = 64;  // how many stretches may be open at once
constexpr double kSweep_m = 0.5;         // along u between rows of which every cell is looked at

struct Place3 {
  double x_m, y_m, z_m;
};

/// Where (u, v) of the file is in the frame of the mesh; z NaN where the file has no height.
Place3 on_mesh(const crg::Surface& road, const ValidateOptions& options, double u_m, double v_m) {
  const crg::Point2 p = road.xy_of_uv(u_m, v_m);
  const auto& shift = options.T_global_mesh.translation_m;
  const double cosine = std::cos(options.T_global_mesh.yaw_rad),
               sine = std::sin(options.T_global_mesh.yaw_rad);
  const double dx = p.x_m - shift.x(), dy = p.y_m - shift.y();
  return {cosine * dx + sine * dy, -sine * dx + cosine * dy, road.z_at_uv(u_m, v_m) - shift.z()};
}

/// Rows and columns before and after (u, v).
struct Cell {
  std::array<double, 2> u_m, v_m;
};

Cell cell_at(const crg::Grid& grid, double u_m, double v_m) {
  const auto row = std::clamp(std::floor((u_m - grid.u_begin_m) / grid.u_step_m), 0.0,
                              static_cast<double>(grid.rows() - 2));
  const auto above = std::upper_bound(grid.v_m.begin() + 1, grid.v_m.end() - 1, v_m);
  return {{grid.u_begin_m + row * grid.u_step_m, grid.u_begin_m + (row + 1.0) * grid.u_step_m},
          {*(above - 1), *above}};
}

std::string reason_at(const crg::Surface& road, const RaySurface& mesh,
                      const ValidateOptions& options, const RoughPoint& point) {
  const Cell cell = cell_at(road.grid(), point.u_m, point.v_m);
  std::vector<Place3> places{on_mesh(road, options, point.u_m, point.v_m)};
  for (const double u : cell.u_m) {
    for (const double v : cell.v_m) places.push_back(on_mesh(road, options, u, v));
  }
  bool nodes_off = false;
  for (const Place3& place : places) {
    if (std::isnan(place.z_m)) continue;
    std::vector<double> near;
    for (const SurfaceHit& hit : mesh.all_hits(place.x_m, place.y_m)) {
      if (std::abs(hit.z_m - place.z_m) <= options.reach_m) near.push_back(hit.z_m);
    }
    if (near.size() > 1 && near.front() - near.back() > kTwoSurfacesApart_m)
      return "the mesh has two surfaces, one above the other";
    const bool is_node = &place != &places.front();
    nodes_off =
        nodes_off || (is_node && (near.empty() || std::abs(near.front() - place.z_m) > kNodeOff_m));
  }
  return nodes_off ? "the file's own nodes are off the mesh (filled, smoothed or wrong)"
                   : "the mesh steps or folds between neighbouring nodes, which are on it";
}

/// The middle of every cell of row i against the mesh, 16 at once: finds what leaves the nodes
/// even, as a wall whose foot was filled.
void sweep_row(const crg::Surface& road, const RaySurface& mesh, const ValidateOptions& options,
               std::size_t i, RayPacket16& packet, std::vector<RoughPoint>& found) {
  const crg::Grid& grid = road.grid();
  const double u_m = grid.u_of(i) + 0.5 * grid.u_step_m;
  // A row is straight: two places of it give all.
  const Place3 middle = on_mesh(road, options, u_m, 0.0), one = on_mesh(road, options, u_m, 1.0);
  const Eigen::Vector3d& origin = mesh.origin_m();
  packet.max_depth_m = static_cast<float>(2.0 * options.reach_m);
  std::array<double, 16> v_m{}, z_m{};
  std::size_t count = 0;
  const auto cast = [&] {
    for (std::size_t k = 0; k < 16; ++k) packet.active[k] = k < count ? -1 : 0;
    mesh.cast_down(packet);
    for (std::size_t k = 0; k < count; ++k) {
      const double hit_m = static_cast<double>(packet.z_m[k]) + origin.z();
      if (std::abs(hit_m - z_m[k]) <= options.named_error_m) continue;
      // Something above, or nothing.
      const double error = error_at(road, mesh, options, u_m, v_m[k]).value_or(0.0);
      if (std::abs(error) > options.named_error_m) found.push_back({u_m, v_m[k], error});
    }
    count = 0;
  };
  for (std::size_t j = 0; j + 1 < grid.columns(); ++j) {
    const double v = 0.5 * (grid.v_m[j] + grid.v_m[j + 1]), z = road.z_at_uv(u_m, v);
    if (std::isnan(z)) continue;
    v_m[count] = v;
    z_m[count] = z - options.T_global_mesh.translation_m.z();
    packet.x_m[count] = static_cast<float>(middle.x_m + v * (one.x_m - middle.x_m) - origin.x());
    packet.y_m[count] = static_cast<float>(middle.y_m + v * (one.y_m - middle.y_m) - origin.y());
    packet.z_top_m[count] = static_cast<float>(z_m[count] + options.reach_m - origin.z());
    if (++count == 16) cast();
  }
  if (count > 0) cast();
}

/// Deviation of node b from the line through its neighbours a and c; 0 where one is missing.
double bend(double at_a, double a, double at_b, double b, double at_c, double c) {
  const double deviation = std::abs(b - (a + (c - a) * (at_b - at_a) / (at_c - at_a)));
  return std::isnan(deviation) ? 0.0 : deviation;
}

}  // namespace

std::optional<double> error_at(const crg::Surface& road, const RaySurface& mesh,
                               const ValidateOptions& options, double u_m, double v_m) {
  const Place3 place = on_mesh(road, options, u_m, v_m);
  if (std::isnan(place.z_m)) return std::nullopt;
  const auto hit = mesh.nearest_hit(place.x_m, place.y_m, place.z_m, options.reach_m);
  if (!hit) return std::nullopt;
  return place.z_m - hit->z_m;
}

bool is_over_crack(const crg::Surface& road, const RaySurface& mesh, const ValidateOptions& options,
                   double u_m, double v_m) {
  const Place3 place = on_mesh(road, options, u_m, v_m),
               aside = on_mesh(road, options, u_m, v_m + 1.0);
  return sides_of_crack(mesh, {place.x_m, place.y_m, place.z_m},
                        {aside.x_m - place.x_m, aside.y_m - place.y_m})
      .has_value();
}

std::vector<RoughPlace> find_rough_places(const crg::Surface& road, const RaySurface& mesh,
                                          const ValidateOptions& options,
                                          std::vector<RoughPoint> known) {
  const crg::Grid& grid = road.grid();
  const std::size_t rows = grid.rows(), columns = grid.columns();
  const double screen_m = options.named_error_m / 3.0;
  const auto z = [&](std::size_t i, std::size_t j) { return static_cast<double>(grid.at(i, j)); };
  const auto bends_at = [&](std::size_t i, std::size_t j) {
    const bool across = j > 0 && j + 1 < columns &&
                        bend(grid.v_m[j - 1], z(i, j - 1), grid.v_m[j], z(i, j), grid.v_m[j + 1],
                             z(i, j + 1)) > screen_m;
    return across || (i > 0 && i + 1 < rows &&
                      bend(0.0, z(i - 1, j), 1.0, z(i, j), 2.0, z(i + 1, j)) > screen_m);
  };
  const std::size_t sweep =
      std::max<std::size_t>(1, static_cast<std::size_t>(kSweep_m / grid.u_step_m + 1e-9));
  std::vector<std::vector<RoughPoint>> of_row(rows);
  base::parallel_for(rows - 1, 256, options.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<std::size_t> bent;
    RayPacket16 packet;
    for (std::size_t i = begin; i < end; ++i) {
      if (i % sweep == 0) sweep_row(road, mesh, options, i, packet, of_row[i]);
      bent.clear();
      for (std::size_t j = 0; j + 1 < columns; ++j) {
        if (bends_at(i, j) || bends_at(i, j + 1) || bends_at(i + 1, j) || bends_at(i + 1, j + 1))
          bent.push_back(j);
      }
      const std::size_t stride = bent.size() / kCellsPerRow + 1;
      // Another of them in every row, so that neighbouring rows together look at all.
      for (std::size_t k = i % stride; k < bent.size(); k += stride) {
        const std::size_t j = bent[k];
        RoughPoint worst{0.0, 0.0, 0.0};
        for (const double s : {0.15, 0.5, 0.85}) {
          for (const double t : {0.15, 0.5, 0.85}) {
            const double u = grid.u_of(i) + s * grid.u_step_m,
                         v = grid.v_m[j] + t * (grid.v_m[j + 1] - grid.v_m[j]);
            const double error = error_at(road, mesh, options, u, v).value_or(0.0);
            if (std::abs(error) > std::abs(worst.error_m)) worst = {u, v, error};
          }
        }
        if (std::abs(worst.error_m) > options.named_error_m) of_row[i].push_back(worst);
      }
    }
  });
  for (const auto& points : of_row) known.insert(known.end(), points.begin(), points.end());
  std::stable_sort(known.begin(), known.end(),
                   [](const RoughPoint& a, const RoughPoint& b) { return a.u_m < b.u_m; });

  std::vector<RoughPlace> places;
  for (const RoughPoint& point : known) {
    const std::string reason = reason_at(road, mesh, options, point);
    const auto oldest =
        places.rbegin() + static_cast<std::ptrdiff_t>(std::min(places.size(), kPlacesBack));
    auto place = std::find_if(places.rbegin(), oldest, [&](const RoughPlace& p) {
      return p.reason == reason && point.u_m - p.u_end_m <= kJoin_m &&
             point.v_m > p.v_min_m - kJoin_m && point.v_m < p.v_max_m + kJoin_m;
    });
    if (place == oldest) {
      places.push_back({point.u_m, point.u_m, point.v_m, point.v_m, std::abs(point.error_m), reason,
                        point.u_m, point.v_m, point.error_m});
      continue;
    }
    place->u_end_m = point.u_m;
    place->v_min_m = std::min(place->v_min_m, point.v_m);
    place->v_max_m = std::max(place->v_max_m, point.v_m);
    if (std::abs(point.error_m) <= place->largest_error_m) continue;
    place->largest_error_m = std::abs(point.error_m);
    place->worst_u_m = point.u_m;
    place->worst_v_m = point.v_m;
    place->worst_error_m = point.error_m;
  }
  return places;
}

}  // namespace road
