#include "stands_on.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Road and ground are within 30 degrees of level; steeper than 60 degrees is a wall or a tree.
constexpr double kLevel = 0.866, kSteep = 0.5;
// Net area of what stands to one side of the ground near it, of all such area; and that area, of
// the ground's.
constexpr double kStands = 0.5, kEnoughSteep = 0.002;
constexpr double kCellsAcross = 200.0;  // of the longer side of the mesh
constexpr double kFacesAcross = 2.0;    // of a cell, at least

// A sheet lies on one that is clearly larger, at most this far from it (of the mesh's longer side);
// farther off are decks. Of the sheets' area that lies so; of the ground's.
constexpr double kLarger = 1.25, kClose = 1e-3, kOneSide = 0.8, kEnoughSheets = 0.02;

// Entries of the table of faces by cells, for each face and for few large ones; faces in one cell.
constexpr std::size_t kMostPerFace = 16, kMostCells = 1u << 20u, kMostInCell = 1u << 14u;
constexpr std::size_t kLookedAtFaces = 20'000;

struct Face {
  std::array<Vector3d, 3> corners;
  Vector3d normal;  // as long as the face is large
  double level;     // 1: flat along the line
};

/// What is needed to look at a mesh along a line; a and b are the axes of its plan.
struct Plan {
  Plan(const RawMesh& of, int along)
      : mesh(of), line(along), a((along + 1) % 3), b((along + 2) % 3) {
    for (const Vector3d& v : mesh.vertices) box.extend(v);
    extent = std::max(box.sizes()[a], box.sizes()[b]);
  }
  Face face(std::size_t t) const {
    Face f;
    for (std::size_t k = 0; k < 3; ++k) f.corners[k] = mesh.vertices[mesh.triangles[t][k]];
    f.normal = (f.corners[1] - f.corners[0]).cross(f.corners[2] - f.corners[0]) / 2.0;
    f.level = f.normal.norm() > 0.0 ? std::abs(f.normal[line]) / f.normal.norm() : kLevel - kSteep;
    return f;
  }
  Vector2d at(const Vector3d& p) const { return {p[a] - box.min()[a], p[b] - box.min()[b]}; }
  static std::int64_t cell(double x, double y) {
    return (static_cast<std::int64_t>(x) << 32) + static_cast<std::int64_t>(y);
  }

  const RawMesh& mesh;
  int line, a, b;
  Eigen::AlignedBox3d box;
  double extent = 0.0;
};

Vector3d middle(const Face& face) {
  return (face.corners[0] + face.corners[1] + face.corners[2]) / 3.0;
}

/// As long as faces of that area are on average, a few times.
double face_size(double area, std::size_t faces) {
  return kFacesAcross * std::sqrt(area / std::max<double>(1.0, static_cast<double>(faces)));
}

/// Flat faces by the cells of the plan that they touch; none where very many are long or lie on
/// each other.
class FlatFaces {
 public:
  explicit FlatFaces(const Plan& plan)
      : plan_(plan), area_of_object_(plan.mesh.objects.size(), 0.0) {
    for (std::uint32_t t = 0; t < plan.mesh.triangles.size(); ++t) {
      const Face face = plan.face(t);
      if (face.level < kLevel) continue;
      faces_.push_back(t);
      area_ += face.normal.norm();
      area_of_object_[plan.mesh.object_of_triangle[t]] += face.normal.norm();
    }
    cell_ = std::max(1e-6 * plan.extent, face_size(area_, faces_.size()));
    std::size_t room = kMostPerFace * faces_.size() + kMostCells;
    for (const std::uint32_t t : faces_) {
      Eigen::AlignedBox2d box;
      for (const Vector3d& p : plan.face(t).corners) box.extend(Vector2d(plan.at(p) / cell_));
      for (double x = std::floor(box.min().x()); x <= box.max().x(); ++x)
        for (double y = std::floor(box.min().y()); y <= box.max().y(); ++y) {
          std::vector<std::uint32_t>& here = in_cell_[Plan::cell(x, y)];
          here.push_back(t);
          if (--room == 0 || here.size() > kMostInCell) {
            in_cell_.clear();
            return;
          }
        }
    }
  }

  const std::vector<std::uint32_t>& faces() const { return faces_; }
  double area() const { return area_; }

  /// Calls use(height) for the faces of clearly larger objects over or under a place.
  template <class Use>
  void each_larger(const Vector3d& place, std::uint32_t object, Use&& use) const {
    const Vector2d at = plan_.at(place);
    const auto found =
        in_cell_.find(Plan::cell(std::floor(at.x() / cell_), std::floor(at.y() / cell_)));
    if (found == in_cell_.end()) return;
    for (const std::uint32_t t : found->second) {
      const std::uint32_t other = plan_.mesh.object_of_triangle[t];
      if (other == object || area_of_object_[other] < kLarger * area_of_object_[object]) continue;
      const Face face = plan_.face(t);
      if (!covers(face, at)) continue;
      // On the plane of the face.
      const double off = face.normal.dot(face.corners[0] - place) / face.normal[plan_.line];
      use(place[plan_.line] + off);
    }
  }

 private:
  bool covers(const Face& face, const Vector2d& at) const {
    std::array<double, 3> side{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector2d p = plan_.at(face.corners[k]), q = plan_.at(face.corners[(k + 1) % 3]);
      side[k] = (q - p).x() * (at - p).y() - (q - p).y() * (at - p).x();
    }
    const auto [least, most] = std::minmax({side[0], side[1], side[2]});
    return least >= 0.0 || most <= 0.0;
  }

  const Plan& plan_;
  std::vector<std::uint32_t> faces_;
  std::vector<double> area_of_object_;
  double area_ = 0.0, cell_ = 1.0;
  std::unordered_map<std::int64_t, std::vector<std::uint32_t>> in_cell_;
};

}  // namespace

int side_of_things(const RawMesh& mesh, int line) {
  const Plan plan(mesh, line);
  if (!(plan.extent > 0.0)) return 0;
  struct Ground {
    double area = 0.0, height = 0.0;  // the sum of area times height
  };
  std::vector<Face> flat, steep;
  double flat_area = 0.0, steep_area = 0.0, above = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Face face = plan.face(t);
    if (face.level >= kLevel) flat.push_back(face), flat_area += face.normal.norm();
    if (face.level <= kSteep) steep.push_back(face);
  }
  const double cell = std::max(plan.extent / kCellsAcross, face_size(flat_area, flat.size()));
  const auto cell_of = [&](const Face& face) {
    const Vector2d at = plan.at(middle(face)) / cell;
    return Plan::cell(std::floor(at.x()), std::floor(at.y()));
  };
  std::unordered_map<std::int64_t, Ground> cells;
  for (const Face& face : flat) {
    Ground& ground = cells[cell_of(face)];
    ground.area += face.normal.norm(), ground.height += face.normal.norm() * middle(face)[line];
  }
  for (const Face& face : steep) {
    const auto ground = cells.find(cell_of(face));
    if (ground == cells.end()) continue;
    steep_area += face.normal.norm();
    above += std::copysign(face.normal.norm(),
                           middle(face)[line] - ground->second.height / ground->second.area);
  }
  if (steep_area < kEnoughSteep * flat_area || std::abs(above) < kStands * steep_area) return 0;
  return above > 0.0 ? 1 : -1;
}

int side_of_sheets(const RawMesh& mesh, int line) {
  const Plan plan(mesh, line);
  if (!(plan.extent > 0.0) || mesh.objects.size() < 2) return 0;
  const FlatFaces flat(plan);
  double over = 0.0, under = 0.0;
  const std::size_t step = 1 + flat.faces().size() / kLookedAtFaces;
  for (std::size_t k = 0; k < flat.faces().size(); k += step) {
    const std::uint32_t t = flat.faces()[k];
    const Face face = plan.face(t);
    const Vector3d place = middle(face);
    bool lies_over = false, lies_under = false;
    flat.each_larger(place, mesh.object_of_triangle[t], [&](double height) {
      const double off = place[line] - height;
      if (std::abs(off) < kClose * plan.extent) (off > 0.0 ? lies_over : lies_under) = true;
    });
    if (lies_over == lies_under) continue;
    (lies_over ? over : under) += face.normal.norm();
  }
  if (static_cast<double>(step) * (over + under) < kEnoughSheets * flat.area() ||
      std::max(over, under) < kOneSide * (over + under))
    return 0;
  return over > under ? 1 : -1;
}

}  // namespace road
