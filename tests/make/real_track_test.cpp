// Real tracks of the Debian package torcs-data, end to end, against their designed edges and
// against an independent ray caster. Skipped, and said so, where the meshes or the designed edges
// are absent.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "base/csv.h"
#include "base/json_text.h"
#include "crg/surface.h"
#include "make/make_track.h"
#include "support/brute_force.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/temporary_folder.h"
#include "support/torcs_track.h"

namespace real_track_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Edges {
  std::vector<Vector3d> left, right;
  double length_m = 0.0;

  Vector2d centre(std::size_t i) const { return 0.5 * (left[i] + right[i]).head<2>(); }
};

Edges read_edges(const std::string& path) {
  const auto table = base::read_csv(
      path, {"s_m", "left_x_m", "left_y_m", "left_z_m", "right_x_m", "right_y_m", "right_z_m"});
  Edges edges;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    edges.left.emplace_back(table.value(i, 1), table.value(i, 2), table.value(i, 3));
    edges.right.emplace_back(table.value(i, 4), table.value(i, 5), table.value(i, 6));
  }
  edges.length_m = table.value(table.rows() - 1, 0);
  edges.left.pop_back();  // the last station is the first again
  edges.right.pop_back();
  return edges;
}

double distance_to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d d = b - a;
  const double t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-12), 0.0, 1.0);
  return (p - a - t * d).norm();
}

bool inside_quad(const Vector2d& p, const std::array<Vector2d, 4>& quad) {
  bool left = true, right = true;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector2d e = quad[(k + 1) % 4] - quad[k], d = p - quad[k];
    const double side = e.x() * d.y() - e.y() * d.x();
    left = left && side >= 0;
    right = right && side <= 0;
  }
  return left || right;
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

class RealTrack : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    mesh_path_ = places::torcs_tracks() + "/road/" + GetParam() + "/" + GetParam() + ".acc";
    edges_path_ = places::data() + "/torcs_truth/" + GetParam() + ".csv";
    for (const auto& path : {mesh_path_, edges_path_}) {
      if (!std::filesystem::exists(path))
        GTEST_SKIP() << path << " is absent (apt install torcs-data; data beside the checkout)";
    }
    dir_ = folder_.path(GetParam());
  }

  road::Recipe recipe() const { return road::recipe_for_mesh(mesh_path_); }

  support::TemporaryFolder folder_;
  std::string mesh_path_, edges_path_, dir_;
};

TEST_P(RealTrack, HoldsItsBounds) {
  const auto result = road::make_track(recipe(), dir_);
  const Edges edges = read_edges(edges_path_);
  const crg::Surface road(crg::read(result.crg_path));
  const crg::ReferenceLine& line = road.reference_line();
  const crg::Grid& grid = road.grid();
  const road::Mesh mesh = road::read_mesh(mesh_path_);
  const road::Mesh drivable = support::drivable_by_name(mesh);
  support::BruteForce ruler(drivable);
  ruler.find_folds(10.0);

  support::figure(
      "z_largest_with_folds_mm",
      1e3 * base::parse_json<nlohmann::json>(result.summary_json)["validation"]["z_error_m"]["max"]
                .get<double>());
  EXPECT_TRUE(line.closed);
  const double length_m = line.u_step_m * static_cast<double>(line.size() - 1);
  std::printf("%s: length %.3f m, designed %.3f m (%+.4f %%)\n", GetParam(), length_m,
              edges.length_m, 100 * (length_m / edges.length_m - 1));
  EXPECT_NEAR(length_m / edges.length_m, 1.0, 0.0005);

  // Reference line against the designed centre, from the centre's stations to the line.
  std::vector<double> off;
  for (std::size_t i = 0; i < edges.left.size(); ++i) {
    double best = 1e9;
    for (std::size_t k = 0; k + 1 < line.size(); ++k) {
      if (std::abs(line.x_m[k] - edges.centre(i).x()) +
              std::abs(line.y_m[k] - edges.centre(i).y()) >
          3.0)
        continue;
      best = std::min(best, distance_to_segment(edges.centre(i), {line.x_m[k], line.y_m[k]},
                                                {line.x_m[k + 1], line.y_m[k + 1]}));
    }
    off.push_back(best);
  }
  std::printf("  reference line to designed centre: p50 %.4f  p99 %.4f  max %.4f m\n",
              quantile(off, 0.5), quantile(off, 0.99), quantile(off, 1.0));
  EXPECT_LE(quantile(off, 0.99), 0.15);

  // Every grid node between the designed edges has a height.
  std::size_t inside = 0, with_z = 0;
  std::size_t near = 0;  // station near the row, followed along u in either direction
  const std::size_t stations = edges.left.size();
  for (std::size_t i = 0; i < grid.rows(); i += 2) {
    const Vector2d p(line.x_m[i], line.y_m[i]);
    if (i == 0) {
      for (std::size_t k = 0; k < stations; ++k) {
        if ((edges.centre(k) - p).norm() < (edges.centre(near) - p).norm()) near = k;
      }
    }
    for (const std::size_t step : {std::size_t{1}, stations - 1}) {
      while ((edges.centre((near + step) % stations) - p).norm() < (edges.centre(near) - p).norm())
        near = (near + step) % stations;
    }
    for (std::size_t j = 0; j < grid.columns(); ++j) {
      const crg::Point2 node = crg::node_position(line, i, grid.v_m[j]);
      bool on_road = false;
      for (std::size_t k = near + stations - 2; k <= near + stations + 1 && !on_road; ++k) {
        const std::size_t a = k % stations, b = (k + 1) % stations;
        on_road =
            inside_quad({node.x_m, node.y_m}, {edges.left[a].head<2>(), edges.left[b].head<2>(),
                                               edges.right[b].head<2>(), edges.right[a].head<2>()});
      }
      if (!on_road) continue;
      ++inside;
      with_z += std::isnan(grid.at(i, j)) ? 0 : 1;
    }
  }
  std::printf("  nodes between the designed edges: %zu, with z %.4f %%\n", inside,
              100.0 * static_cast<double>(with_z) / static_cast<double>(inside));
  EXPECT_GT(inside, grid.rows() / 2 * 80);
  EXPECT_GE(static_cast<double>(with_z) / static_cast<double>(inside), 0.9995);

  // Heights at random points between the nodes against the independent caster.
  std::mt19937_64 random(7);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  std::vector<double> errors;
  std::size_t left_out = 0, off_mesh = 0;
  while (errors.size() + left_out + off_mesh < 20000) {
    const double u = length_m * uniform(),
                 v = grid.v_m.front() + (grid.v_m.back() - grid.v_m.front()) * uniform();
    const double z = road.z_at_uv(u, v);
    if (std::isnan(z)) continue;
    const crg::Point2 p = road.xy_of_uv(u, v);
    if (ruler.near_fold(p.x_m, p.y_m, z, 0.2)) {
      ++left_out;
      continue;
    }
    const auto truth = ruler.nearest(p.x_m, p.y_m, z);
    if (!truth) {
      ++off_mesh;
      continue;
    }
    errors.push_back(std::abs(z - *truth));
  }
  const double share_out = static_cast<double>(left_out) / 20000.0;
  support::figure("z_largest_mm", 1e3 * quantile(errors, 1.0));
  EXPECT_LE(quantile(errors, 0.99), 0.0015);
  EXPECT_LE(quantile(errors, 1.0), 0.015);
  EXPECT_LE(share_out, 0.05);
  EXPECT_EQ(off_mesh, 0u);

  // No node on anything but a surface to drive on, and none on another deck.
  std::size_t wrong = 0, jumps = 0, checked = 0;
  for (std::size_t i = 0; i + 1 < grid.rows(); i += 11) {
    for (std::size_t j = 0; j < grid.columns(); j += 3) {
      const auto z = static_cast<double>(grid.at(i, j));
      if (std::isnan(z)) continue;
      ++checked;
      const double height_m = z + (line.z_m.empty() ? 0.0 : line.z_m[i]);
      const crg::Point2 p = crg::node_position(line, i, grid.v_m[j]);
      const auto truth = ruler.nearest(p.x_m, p.y_m, height_m);
      // A node within a millimetre of the border may fall on either side of it.
      const auto beside = truth ? truth : ruler.nearest(p.x_m + 1e-3, p.y_m + 1e-3, height_m);
      if (!beside || std::abs(*beside - height_m) > 0.01)
        wrong += ruler.near_fold(p.x_m, p.y_m, height_m, 0.02) ? 0 : 1;
      const auto next = static_cast<double>(grid.at(i + 1, j));
      if (!std::isnan(next) && std::abs(next - z) > 0.5) ++jumps;
    }
  }
  std::printf("  nodes checked %zu, not on a surface to drive on %zu, jumps to another deck %zu\n",
              checked, wrong, jumps);
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(jumps, 0u);

  // The seam.
  double step_m = 0.0;
  for (std::size_t j = 0; j < grid.columns(); ++j) {
    const float a = grid.at(0, j), b = grid.at(grid.rows() - 1, j);
    EXPECT_EQ(std::isnan(a), std::isnan(b));
    if (!std::isnan(a) && !std::isnan(b))
      step_m = std::max(step_m, static_cast<double>(std::abs(a - b)));
  }
  const double turn =
      std::abs(std::remainder(line.heading_rad[1] - line.heading_rad.back(), 2 * M_PI));
  support::figure("seam_mm", 1e3 * step_m);
  support::figure("seam_mrad", 1e3 * turn);
  EXPECT_LE(step_m, 1e-3);
  EXPECT_LE(turn, 5e-4);
}

TEST_P(RealTrack, IsTheSameForAnyNumberOfThreads) {
  const auto bytes = [](const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  };
  std::vector<std::string> built;
  for (const unsigned threads : {1u, 3u}) {
    auto r = recipe();
    r.sample.threads = r.kerb.threads = r.smooth.threads = threads;
    r.smooth.window_u_m = 0.5;
    const auto result = road::make_track(r, dir_ + "_" + std::to_string(threads));
    built.push_back(bytes(result.crg_path) + bytes(result.stl_path) +
                    bytes(result.centreline_path) + bytes(result.picture_path));
  }
  EXPECT_GT(built[0].size(), 1'000'000u);
  EXPECT_TRUE(built[0] == built[1]);
}

INSTANTIATE_TEST_SUITE_P(Torcs, RealTrack, testing::Values("aalborg"));
INSTANTIATE_TEST_SUITE_P(SlowTorcs, RealTrack, testing::Values("g-track-1", "e-track-3"),
                         [](const auto& parameter) {
                           std::string name = parameter.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace real_track_test
