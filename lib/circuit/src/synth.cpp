#include "circuit/synth.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>

#include "base/random.h"
#include "base/write_file.h"
#include "mesh/error.h"
#include "mesh/export_mesh.h"

namespace road {
namespace {

/// Triangles by the cells of a plan-view raster, for vertical lines through a mesh in double.
class PlanIndex {
 public:
  explicit PlanIndex(const Mesh& mesh) : mesh_(mesh) {
    Eigen::Vector2d high(-1e300, -1e300);
    low_ = {1e300, 1e300};
    for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
      low_ = low_.cwiseMin(vertex.head<2>());
      high = high.cwiseMax(vertex.head<2>());
    }
    columns_ = cell(high.x() - low_.x()) + 1;
    rows_ = cell(high.y() - low_.y()) + 1;
    begin_.assign(columns_ * rows_ + 1, 0);
    for (int pass = 0; pass < 2; ++pass) {  // count, then fill
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        Eigen::Vector2d from = mesh.vertex(t, 0).head<2>();
        Eigen::Vector2d to = from;
        for (int corner = 1; corner < 3; ++corner) {
          from = from.cwiseMin(mesh.vertex(t, corner).head<2>());
          to = to.cwiseMax(mesh.vertex(t, corner).head<2>());
        }
        for (std::size_t j = cell(from.y() - low_.y()); j <= cell(to.y() - low_.y()); ++j) {
          for (std::size_t i = cell(from.x() - low_.x()); i <= cell(to.x() - low_.x()); ++i) {
            std::size_t& slot = begin_[j * columns_ + i + (pass == 0 ? 1 : 0)];
            if (pass == 0) {
              ++slot;
            } else {
              triangle_[slot++] = static_cast<std::uint32_t>(t);
            }
          }
        }
      }
      if (pass == 0) {
        for (std::size_t k = 1; k < begin_.size(); ++k) begin_[k] += begin_[k - 1];
        triangle_.resize(begin_.back());
      }
    }
    // Filling moved every begin to the next cell's.
    for (std::size_t k = begin_.size() - 1; k > 0; --k) begin_[k] = begin_[k - 1];
    begin_[0] = 0;
  }

  /// Height of the triangle over (x, y) that is nearest to z, within `reach_m`.
  std::optional<double> nearest(double x, double y, double z, double reach_m) const {
    if (!(x >= low_.x()) || !(y >= low_.y())) return std::nullopt;
    const std::size_t i = cell(x - low_.x());
    const std::size_t j = cell(y - low_.y());
    if (i >= columns_ || j >= rows_) return std::nullopt;
    std::optional<double> best;
    double best_distance = reach_m;
    for (std::size_t k = begin_[j * columns_ + i]; k < begin_[j * columns_ + i + 1]; ++k) {
      const Eigen::Vector3d& a = mesh_.vertex(triangle_[k], 0);
      const Eigen::Vector3d ab = mesh_.vertex(triangle_[k], 1) - a;
      const Eigen::Vector3d ac = mesh_.vertex(triangle_[k], 2) - a;
      const double area = ab.x() * ac.y() - ab.y() * ac.x();
      if (area == 0.0) continue;
      const double px = x - a.x();
      const double py = y - a.y();
      const double s = (px * ac.y() - py * ac.x()) / area;
      const double t = (ab.x() * py - ab.y() * px) / area;
      constexpr double kEdge = -1e-9;  // a point on a shared edge belongs to both
      if (s < kEdge || t < kEdge || s + t > 1.0 - kEdge) continue;
      const double height = a.z() + s * ab.z() + t * ac.z();
      if (std::abs(height - z) < best_distance) {
        best_distance = std::abs(height - z);
        best = height;
      }
    }
    return best;
  }

 private:
  static std::size_t cell(double distance_m) {
    constexpr double kCellM = 2.0;
    return static_cast<std::size_t>(distance_m / kCellM);
  }

  const Mesh& mesh_;
  Eigen::Vector2d low_;
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<std::size_t> begin_;
  std::vector<std::uint32_t> triangle_;
};

class Errors {
 public:
  void add(double error_m) { errors_m_.push_back(error_m); }
  std::size_t size() const { return errors_m_.size(); }
  void summarise(double& p99_m, double& max_m) {
    if (errors_m_.empty()) return;
    std::sort(errors_m_.begin(), errors_m_.end());
    p99_m = errors_m_[(errors_m_.size() - 1) * 99 / 100];
    max_m = errors_m_.back();
  }

 private:
  std::vector<double> errors_m_;
};

const char* ending(MeshFormat format) {
  switch (format) {
    case MeshFormat::obj:
      return "obj";
    case MeshFormat::glb:
      return "glb";
    case MeshFormat::ply:
      return "ply";
    case MeshFormat::stl:
      return "stl";
  }
  return "";
}

}  // namespace

SynthError measure_mesh_error(const Circuit& circuit, const Mesh& mesh) {
  constexpr std::size_t kPoints = 20000;
  constexpr double kReachM = 0.5;
  constexpr std::uint64_t kSeed = 1;
  SynthError result;
  if (mesh.triangles.empty()) return result;
  const PlanIndex index(mesh);
  const std::vector<KerbDesign>& kerbs = circuit.design().kerbs;
  base::Random random(kSeed);
  Errors road;
  Errors kerb;
  Errors runoff;
  const auto compare = [&](double u, double v, Errors& errors) {
    const double z = true_height(circuit, u, v);
    const crg::Point2 point = position_at(circuit, u, v);
    if (const auto seen =
            index.nearest(point.x_m - mesh.origin_m.x(), point.y_m - mesh.origin_m.y(),
                          z - mesh.origin_m.z(), kReachM)) {
      errors.add(std::abs(*seen + mesh.origin_m.z() - z));
    } else {
      ++result.points_without_mesh;
    }
  };
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double u = random.uniform(0.0, circuit.length_m());
    const CrossSection cross = section_at(circuit, u);
    compare(u, random.uniform(cross.road_right_m, cross.road_left_m), road);
    const bool left = random.uniform() < 0.5;
    const double share = random.uniform();
    const double v = left ? cross.road_left_m + share * (cross.outer_left_m - cross.road_left_m)
                          : cross.road_right_m - share * (cross.road_right_m - cross.outer_right_m);
    if (true_class(circuit, u, v) == SurfaceClass::runoff) compare(u, v, runoff);
    if (!kerbs.empty()) {
      const KerbDesign& chosen = kerbs[random.below(kerbs.size())];
      const double at = random.uniform(chosen.u_begin_m, chosen.u_end_m);
      const CrossSection there = section_at(circuit, at);
      const double offset = random.uniform(0.0, chosen.width_m);
      compare(at,
              chosen.side == Side::left ? there.road_left_m + offset : there.road_right_m - offset,
              kerb);
    }
  }
  road.summarise(result.road_p99_m, result.road_max_m);
  kerb.summarise(result.kerb_p99_m, result.kerb_max_m);
  runoff.summarise(result.runoff_p99_m, result.runoff_max_m);
  return result;
}

SynthOutput write_synth(const Circuit& circuit, const std::string& output_dir,
                        const SynthOptions& options) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::create_directories(output_dir, error);
  if (error) {
    throw Error(fmt::format("{}: cannot be made ({}); give a folder that can be written",
                            output_dir, error.message()));
  }
  const fs::path dir(output_dir);
  const std::string& name = circuit.design().name;
  SynthOutput output;
  output.mesh_path = (dir / (name + "." + ending(options.format))).string();
  output.truth_path = (dir / (name + "_truth.crg")).string();
  const Mesh mesh = make_circuit_mesh(circuit, options);
  output.vertices = mesh.vertices_m.size();
  output.triangles = mesh.triangles.size();
  output.objects = mesh.objects.size();
  output.length_m = circuit.length_m();
  output.closing_error_m = circuit.closing_error_m();
  output.mesh_error = measure_mesh_error(circuit, mesh);
  export_mesh(mesh, output.mesh_path,
              {options.up == UpAxis::z ? UpAxis::z : UpAxis::y, options.unit});
  base::write_file(output.truth_path,
                   crg::to_bytes(truth_crg(circuit, options.truth_step_m), crg::Format::KDBI));
  return output;
}

}  // namespace road
