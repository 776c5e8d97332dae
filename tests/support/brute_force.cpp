#include "support/brute_force.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace support {

namespace {

constexpr double kCell_m = 4.0;

long long cell(double x, double y) {
  return (static_cast<long long>(std::floor(x / kCell_m)) << 32) ^
         (static_cast<long long>(std::floor(y / kCell_m)) & 0xffffffffLL);
}

template <typename Visit>
void for_cells(const Eigen::AlignedBox2d& box, const Visit& visit) {
  for (double x = std::floor(box.min().x() / kCell_m); x <= std::floor(box.max().x() / kCell_m);
       ++x) {
    for (double y = std::floor(box.min().y() / kCell_m); y <= std::floor(box.max().y() / kCell_m);
         ++y) {
      visit(cell((x + 0.5) * kCell_m, (y + 0.5) * kCell_m));
    }
  }
}

}  // namespace

BruteForce::BruteForce(const road::Mesh& mesh) : mesh_(mesh) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Eigen::AlignedBox2d box;
    for (int k = 0; k < 3; ++k)
      box.extend(Eigen::Vector2d((mesh.origin_m + mesh.vertex(t, k)).head<2>()));
    for_cells(box, [&](long long c) { triangles_of_cell_[c].push_back(t); });
  }
}

std::vector<double> BruteForce::heights(double x_m, double y_m) const {
  std::vector<double> result;
  const auto found = triangles_of_cell_.find(cell(x_m, y_m));
  if (found == triangles_of_cell_.end()) return result;
  for (const std::size_t t : found->second) {
    const Eigen::Vector3d a = mesh_.vertex(t, 0), b = mesh_.vertex(t, 1), c = mesh_.vertex(t, 2);
    const double x = x_m - mesh_.origin_m.x(), y = y_m - mesh_.origin_m.y();
    const double area = (b.x() - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (b.y() - a.y());
    if (std::abs(area) < 1e-12) continue;
    const double wb = ((x - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (y - a.y())) / area;
    const double wc = ((b.x() - a.x()) * (y - a.y()) - (x - a.x()) * (b.y() - a.y())) / area;
    constexpr double kEdge = 1e-9;
    if (wb < -kEdge || wc < -kEdge || wb + wc > 1.0 + kEdge) continue;
    result.push_back(mesh_.origin_m.z() + a.z() + wb * (b.z() - a.z()) + wc * (c.z() - a.z()));
  }
  return result;
}

std::optional<double> BruteForce::nearest(double x_m, double y_m, double z_m) const {
  std::optional<double> best;
  for (const double z : heights(x_m, y_m)) {
    if (!best || std::abs(z - z_m) < std::abs(*best - z_m)) best = z;
  }
  return best;
}

void BruteForce::find_folds(double angle_deg) {
  // Vertices on a 1 mm lattice count as one.
  std::map<std::array<long long, 3>, std::size_t> welded;
  std::vector<std::size_t> weld(mesh_.vertices_m.size());
  for (std::size_t i = 0; i < weld.size(); ++i) {
    const auto& p = mesh_.vertices_m[i];
    const std::array<long long, 3> key{std::llround(p.x() * 1e3), std::llround(p.y() * 1e3),
                                       std::llround(p.z() * 1e3)};
    weld[i] = welded.emplace(key, i).first->second;
  }
  struct Side {
    std::size_t triangle;
  };
  std::map<std::pair<std::size_t, std::size_t>, std::vector<Side>> sides;
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t a = weld[mesh_.triangles[t][k]], b = weld[mesh_.triangles[t][(k + 1) % 3]];
      if (a != b) sides[std::minmax(a, b)].push_back({t});
    }
  }
  const auto normal = [&](std::size_t t) -> Eigen::Vector3d {
    const Eigen::Vector3d n =
        (mesh_.vertex(t, 1) - mesh_.vertex(t, 0)).cross(mesh_.vertex(t, 2) - mesh_.vertex(t, 0));
    return n.z() < 0.0 ? Eigen::Vector3d(-n.normalized()) : Eigen::Vector3d(n.normalized());
  };
  const double cosine = std::cos(angle_deg * M_PI / 180.0);
  for (const auto& [edge, touching] : sides) {
    bool folded = touching.size() < 2;
    for (std::size_t i = 1; i < touching.size() && !folded; ++i) {
      folded = normal(touching[0].triangle).dot(normal(touching[i].triangle)) < cosine;
    }
    if (!folded) continue;
    const Edge e{mesh_.origin_m + mesh_.vertices_m[edge.first],
                 mesh_.origin_m + mesh_.vertices_m[edge.second]};
    Eigen::AlignedBox2d box(Eigen::Vector2d(e.a.head<2>().cwiseMin(e.b.head<2>())),
                            Eigen::Vector2d(e.a.head<2>().cwiseMax(e.b.head<2>())));
    box.extend(Eigen::Vector2d(box.min().array() - 1.0))
        .extend(Eigen::Vector2d(box.max().array() + 1.0));
    for_cells(box, [&](long long c) { folds_of_cell_[c].push_back(e); });
  }
}

bool BruteForce::near_fold(double x_m, double y_m, double z_m, double distance_m) const {
  const auto found = folds_of_cell_.find(cell(x_m, y_m));
  if (found == folds_of_cell_.end()) return false;
  const Eigen::Vector2d p(x_m, y_m);
  return std::any_of(found->second.begin(), found->second.end(), [&](const Edge& e) {
    const Eigen::Vector2d d = (e.b - e.a).head<2>();
    const double t =
        std::clamp((p - e.a.head<2>()).dot(d) / std::max(d.squaredNorm(), 1e-12), 0.0, 1.0);
    return (p - (e.a.head<2>() + t * d)).norm() <= distance_m &&
           std::abs(e.a.z() + t * (e.b.z() - e.a.z()) - z_m) < 1.0;
  });
}

}  // namespace support
