#include "nearby_road.h"

#include <algorithm>
#include <cmath>

namespace sim {
namespace {

constexpr double kStretch_m = 25.0;
constexpr double kAlong_m = 0.2, kAcross_m = 0.05;  ///< triangles are no smaller
constexpr std::size_t kMostHeld = 64;               ///< stretches that rays need no longer
constexpr double kBeside_m = 0.5;  ///< a triangle is that near to the road that it stands for
constexpr double kOnTheRoad_m = 1e-7;

}  // namespace

NearbyRoad::NearbyRoad(std::shared_ptr<const crg::Surface> surface) : surface_(std::move(surface)) {
  const crg::Grid& grid = surface_->grid();
  for (const double v_m : grid.v_m)
    if (v_m_.empty() || v_m - v_m_.back() >= kAcross_m - 1e-9) v_m_.push_back(v_m);
  if (v_m_.back() < grid.v_m.back()) v_m_.push_back(grid.v_m.back());
  stride_ = static_cast<std::size_t>(std::max(1.0, std::round(kAlong_m / grid.u_step_m)));
  const auto rows = std::max<std::size_t>(
      stride_, stride_ * static_cast<std::size_t>(kStretch_m /
                                                  (grid.u_step_m * static_cast<double>(stride_))));
  for (std::size_t first = 0; first + 1 < grid.rows(); first += rows) {
    Stretch stretch;
    stretch.first_row = first;
    stretch.last_row = std::min(first + rows, grid.rows() - 1);
    stretch.low_x_m = stretch.low_y_m = std::numeric_limits<double>::infinity();
    stretch.high_x_m = stretch.high_y_m = -std::numeric_limits<double>::infinity();
    for (std::size_t row = first;; row = std::min(row + stride_, stretch.last_row)) {
      for (const double v_m : {grid.v_m.front(), grid.v_m.back()}) {
        const crg::Point2 at = surface_->xy_of_uv(grid.u_of(row), v_m);
        stretch.low_x_m = std::min(stretch.low_x_m, at.x_m);
        stretch.high_x_m = std::max(stretch.high_x_m, at.x_m);
        stretch.low_y_m = std::min(stretch.low_y_m, at.y_m);
        stretch.high_y_m = std::max(stretch.high_y_m, at.y_m);
      }
      if (row == stretch.last_row) break;
    }
    stretches_.push_back(std::move(stretch));
  }
}

void NearbyRoad::make(Stretch& stretch) const {
  const crg::Grid& grid = surface_->grid();
  road::Mesh mesh;
  mesh.objects = {{}};
  const crg::Point2 begin = surface_->xy_of_uv(grid.u_of(stretch.first_row), 0.0);
  mesh.origin_m = {begin.x_m, begin.y_m, 0.0};
  const auto columns = static_cast<std::uint32_t>(v_m_.size());
  std::vector<bool> is_road;
  std::uint32_t rows = 0;
  for (std::size_t row = stretch.first_row;; row = std::min(row + stride_, stretch.last_row)) {
    for (const double v_m : v_m_) {
      const crg::Point2 at = surface_->xy_of_uv(grid.u_of(row), v_m);
      const double z_m = surface_->z_at_uv(grid.u_of(row), v_m);
      is_road.push_back(std::isfinite(z_m));
      mesh.vertices_m.emplace_back(at.x_m - begin.x_m, at.y_m - begin.y_m,
                                   is_road.back() ? z_m : 0.0);
    }
    ++rows;
    if (row == stretch.last_row) break;
  }
  for (std::uint32_t i = 0; i + 1 < rows; ++i)
    for (std::uint32_t j = 0; j + 1 < columns; ++j) {
      const std::uint32_t a = i * columns + j, b = a + columns;
      for (const std::array<std::uint32_t, 3>& corners :
           {std::array<std::uint32_t, 3>{a, b, a + 1}, {a + 1, b, b + 1}})
        if (std::all_of(corners.begin(), corners.end(), [&](auto k) { return is_road[k]; }))
          mesh.triangles.push_back(corners);
    }
  mesh.object_of_triangle.assign(mesh.triangles.size(), 0);
  stretch.surface = std::make_unique<const road::RaySurface>(mesh);
}

void NearbyRoad::look_around(const Eigen::Vector3d& from_m, double reach_m) {
  ++looks_;
  near_.clear();
  for (Stretch& stretch : stretches_) {
    const double dx_m =
        std::max({stretch.low_x_m - from_m.x(), from_m.x() - stretch.high_x_m, 0.0});
    const double dy_m =
        std::max({stretch.low_y_m - from_m.y(), from_m.y() - stretch.high_y_m, 0.0});
    // Between rows the border of a bend lies a little outside the box of its nodes.
    if (!(std::hypot(dx_m, dy_m) <= reach_m + kBeside_m)) continue;
    if (!stretch.surface) make(stretch);
    stretch.used = looks_;
    near_.push_back(&stretch);
  }
  forget_the_oldest();
}

void NearbyRoad::forget_the_oldest() {
  std::vector<Stretch*> unused;
  for (Stretch& stretch : stretches_)
    if (stretch.surface && stretch.used != looks_) unused.push_back(&stretch);
  if (unused.size() <= kMostHeld) return;
  std::sort(unused.begin(), unused.end(),
            [](const Stretch* a, const Stretch* b) { return a->used > b->used; });
  for (std::size_t k = kMostHeld; k < unused.size(); ++k) unused[k]->surface.reset();
}

std::size_t NearbyRoad::stretches_held() const {
  return static_cast<std::size_t>(
      std::count_if(stretches_.begin(), stretches_.end(),
                    [](const Stretch& stretch) { return stretch.surface != nullptr; }));
}

std::optional<road::RayHit> NearbyRoad::first_hit(const road::Ray& ray, double nearest_m,
                                                  double reach_m) {
  std::optional<road::RayHit> first;
  for (const Stretch* const stretch : near_) {
    const auto hit = stretch->surface->first_hit(ray, nearest_m, first ? first->range_m : reach_m);
    if (hit) first = hit;
  }
  if (first) first = onto_the_road(ray, *first);
  return first;
}

road::RayHit NearbyRoad::onto_the_road(const road::Ray& ray, const road::RayHit& hit) {
  // Newton along the ray. Where it leads away (another leg of a crossing, the far side of a kerb),
  // the triangle stands.
  road::RayHit out = hit;
  for (int k = 0; k < 12; ++k) {
    const Eigen::Vector3d at = ray.from_m + out.range_m * ray.direction;
    const crg::Sample road = surface_->at_xy(at.x(), at.y(), cursor_);
    if (!road.valid) return hit;
    const double above_m = at.z() - road.z_m;
    const double sinks =
        ray.direction.z() - road.dzdx * ray.direction.x() - road.dzdy * ray.direction.y();
    if (std::abs(above_m) < kOnTheRoad_m) {
      out.normal = {road.normal_x, road.normal_y, road.normal_z};
      return out;
    }
    if (std::abs(sinks) < 1e-6) return hit;
    out.range_m -= above_m / sinks;
    if (!(std::abs(out.range_m - hit.range_m) < kBeside_m)) return hit;
  }
  return hit;
}

}  // namespace sim
