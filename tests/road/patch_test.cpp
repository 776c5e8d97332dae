#include "road/patch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "crg/patches.h"
#include "make/make_track.h"
#include "mesh/export_mesh.h"
#include "road/reference_line.h"
#include "support/strip_road.h"
#include "support/temporary_folder.h"

namespace patch_test {

using road::SurfaceClass;

/// Height of a kerb's teeth: 25 mm, one every 0.25 m, a sharp rise and a long fall.
double tooth_m(double s) {
  const double part = s / 0.25 - std::floor(s / 0.25);
  return 0.025 * (part < 0.2 ? part / 0.2 : (1.0 - part) / 0.8);
}

/// A straight road 10 m wide with a kerb of 1 m on its left from 20 to 40 m.
double height_m(double s, double v) {
  const bool on_kerb = v > 5.0 && s >= 20.0 && s <= 40.0;
  return 0.01 * s + (on_kerb ? tooth_m(s) : 0.0);
}

/// As one mesh with rings of 5 cm, so that every tooth has its corners; the kerb is an object of
/// its own, and beside the road there is nothing else.
road::RoadMesh with_kerb(double heading_rad, double length_m,
                         const std::function<double(double, double)>& z) {
  const auto plan = [=](double s) -> support::PlanPoint {
    return {s * std::cos(heading_rad), s * std::sin(heading_rad), heading_rad};
  };
  const road::RoadMesh strip = support::make_strip(
      plan, length_m, 0.05, false, {-5, 0, 5, 5.005, 6}, z,
      [](double v) { return v > 5.0 ? SurfaceClass::kerb : SurfaceClass::road; });
  road::RoadMesh mesh;
  mesh.mesh.vertices_m = strip.mesh.vertices_m;
  mesh.mesh.objects = {{"road", "asphalt", ""}, {"kerb", "kerb", ""}};
  for (std::size_t t = 0; t < strip.mesh.triangles.size(); ++t) {
    const bool kerb = strip.class_of_triangle[t] == SurfaceClass::kerb;
    const double s = strip.mesh.vertices_m[strip.mesh.triangles[t][0]].dot(
        Eigen::Vector3d(std::cos(heading_rad), std::sin(heading_rad), 0.0));
    if (kerb && (s < 20.0 || s > 40.0)) continue;
    mesh.mesh.triangles.push_back(strip.mesh.triangles[t]);
    mesh.mesh.object_of_triangle.push_back(kerb ? 1 : 0);
    mesh.class_of_triangle.push_back(strip.class_of_triangle[t]);
  }
  return mesh;
}

/// 95 % of |z - truth| at random places on the kerb.
double error_p95_m(const std::function<double(double, double)>& z_at_xy, double heading_rad) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> along(20.5, 39.5), across(5.1, 5.9);
  std::vector<double> errors;
  for (int k = 0; k < 5000; ++k) {
    const double s = along(random), v = across(random);
    const double x = s * std::cos(heading_rad) - v * std::sin(heading_rad),
                 y = s * std::sin(heading_rad) + v * std::cos(heading_rad);
    errors.push_back(std::abs(z_at_xy(x, y) - height_m(s, v)));
  }
  std::sort(errors.begin(), errors.end());
  return errors[errors.size() * 95 / 100];
}

TEST(Patch, TeethBetweenTheRowsGetAFinerRoadThatCarriesThem) {
  const support::TemporaryFolder folder;
  const double heading_rad = 0.4;
  const std::string obj = folder.path("teeth.obj");
  road::export_mesh(with_kerb(heading_rad, 70.0, height_m).mesh, obj);
  road::Recipe recipe = road::recipe_for_mesh(obj);
  recipe.read.up = road::UpAxis::z;
  recipe.read.unit = road::Unit::m;
  recipe.validate.points = 2000;
  const auto built = road::make_track(recipe, folder.path("out"));
  ASSERT_FALSE(built.patches_path.empty());
  const crg::PatchedSurface patched(crg::read_patch_index(built.patches_path));
  const crg::Surface plain(crg::read(built.crg_path));
  crg::Cursor a, b;
  const double without_m =
      error_p95_m([&](double x, double y) { return plain.z_at_xy(x, y, a); }, heading_rad);
  const double with_m =
      error_p95_m([&](double x, double y) { return patched.z_at_xy(x, y, b); }, heading_rad);
  std::printf(
      "teeth of 25 mm every 0.25 m: 95 %% within %.2f mm of the mesh without patch, %.2f mm with "
      "it\n",
      1e3 * without_m, 1e3 * with_m);
  EXPECT_GT(without_m, 0.004);
  EXPECT_LT(with_m, 0.002);
  // The road beside it is as it was.
  EXPECT_DOUBLE_EQ(patched.z_at_xy(30.0 * std::cos(heading_rad), 30.0 * std::sin(heading_rad), b),
                   plain.z_at_xy(30.0 * std::cos(heading_rad), 30.0 * std::sin(heading_rad), a));
  // Without patches the index of the first build goes.
  recipe.patch.max_error_m = 0.0;
  const auto again = road::make_track(recipe, folder.path("out"));
  EXPECT_TRUE(again.patches_path.empty());
  EXPECT_FALSE(std::filesystem::exists(built.patches_path));
}

TEST(Patch, ASmoothKerbNeedsNone) {
  const road::RoadMesh mesh =
      with_kerb(0.0, 150.0, [](double, double v) { return v > 5.001 ? 0.05 : 0.0; });
  const road::RaySurface surface(mesh.mesh);
  const auto centreline = road::trace_centreline(mesh);
  const auto line = road::fit_reference_line(centreline);
  road::KerbReport report;
  const auto sampled = road::refine_kerbs(road::sample_grid(mesh, surface, line, centreline),
                                          surface, mesh, line, {}, &report);
  ASSERT_FALSE(report.kerbs.empty());
  EXPECT_TRUE(road::patch_kerbs(sampled, surface, mesh, line, report.kerbs).empty());
}

}  // namespace patch_test
