// Meshes of other simulators, as they are (../shared/data/meshes beside the checkout; skipped where
// absent).
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <random>

#include "base/csv.h"
#include "crg/edit.h"
#include "crg/file.h"
#include "crg/surface.h"
#include "inspect/validate.h"
#include "make/make_track.h"
#include "make/plausible.h"
#include "make/recipe.h"
#include "mesh/error.h"
#include "mesh/ray_surface.h"
#include "mesh/read_mesh.h"
#include "road/centreline.h"
#include "road/clean.h"
#include "road/reference_line.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace open_meshes_test {

struct Wanted {
  const char* file;
  double length_m;     ///< known from the game's own driveline, or by hand
  double tolerance_m;  ///< drivelines cut corners; so do makers
  const char* driveline;
};

struct Found {
  road::Centreline line;
  std::vector<std::string> doubts;
};

std::string mesh_path(const std::string& file) { return places::data() + "/meshes/" + file; }

Found find(const std::string& file) {
  const road::Mesh mesh = road::read_mesh(mesh_path(file));
  road::CleanReport report;
  const road::RoadMesh surface = road::clean(mesh, {}, &report);
  Found found{road::trace_centreline(surface), {}};
  found.doubts =
      road::doubts_about(found.line, road::RaySurface(surface.mesh), surface.mesh, mesh, report);
  return found;
}

/// Share of the driven points that lie nearer to the line than half its width.
double on_road(const base::CsvTable& driven, const road::Centreline& line) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < driven.rows(); ++i) {
    const Eigen::Vector2d p(driven.value(i, 0), driven.value(i, 1));
    double nearest =
        std::numeric_limits<double>::infinity();  // of the distance over the half width
    const auto& points = line.points_m;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Eigen::Vector2d a = points[k].head<2>(), b = points[(k + 1) % points.size()].head<2>();
      const double t =
          std::clamp((p - a).dot(b - a) / std::max((b - a).squaredNorm(), 1e-12), 0.0, 1.0);
      nearest = std::min(nearest, (p - a - t * (b - a)).norm() / line.half_width_m[k]);
    }
    count += nearest < 1.0 ? 1 : 0;
  }
  return static_cast<double>(count) / static_cast<double>(driven.rows());
}

class OpenMesh : public testing::TestWithParam<Wanted> {};

TEST_P(OpenMesh, IsFoundWhole) {
  const Wanted& wanted = GetParam();
  if (!std::filesystem::exists(mesh_path(wanted.file)))
    GTEST_SKIP() << mesh_path(wanted.file) << " is absent";
  const Found found = find(wanted.file);
  support::figure("length_percent", 100.0 * std::abs(found.line.length_m / wanted.length_m - 1.0));
  EXPECT_TRUE(found.line.closed);
  EXPECT_NEAR(found.line.length_m, wanted.length_m, wanted.tolerance_m);
  for (const std::string& doubt : found.doubts) ADD_FAILURE() << doubt;
  if (wanted.driveline == nullptr) return;
  const base::CsvTable driven =
      base::read_csv(mesh_path(wanted.driveline), {"x_m", "y_m"}, {"z_m"});
  EXPECT_GE(on_road(driven, found.line), 0.98);
}

TEST_P(OpenMesh, HasTheHeightsOfItsMesh) {
  const std::string path = mesh_path(GetParam().file);
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent";
  const support::TemporaryFolder folder;
  const road::Recipe recipe = road::recipe_for_mesh(path);
  const road::BuildResult built = road::make_track(recipe, folder.path("out"));
  // The road alone: beside it lie folds and torn borders that 0.1 m steps do not follow.
  const Found found = find(GetParam().file);
  const double half_m =
      0.9 * *std::min_element(found.line.half_width_m.begin(), found.line.half_width_m.end());
  crg::CropOptions options;
  options.v_right_m = -half_m;
  options.v_left_m = half_m;
  const crg::Surface road_alone(crg::crop(crg::read(built.crg_path), options));
  const road::ValidateReport report =
      road::validate(road_alone, road::RaySurface(road::read_mesh(path)));
  support::figure("z_p99_mm", 1e3 * report.z_error_m.p99);
  EXPECT_LE(report.z_error_m.p99, 5e-4);
  EXPECT_EQ(report.points_without_mesh, 0u);
}

std::string with_letters_alone(std::string name) {
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
}
std::string name_of(const testing::TestParamInfo<Wanted>& mesh) {
  return with_letters_alone(mesh.param.file);
}
std::string name_of_file(const testing::TestParamInfo<const char*>& mesh) {
  return with_letters_alone(mesh.param);
}

// One of each format.
INSTANTIATE_TEST_SUITE_P(Some, OpenMesh,
                         testing::Values(Wanted{"archracer_track.obj", 387.0, 2.0, nullptr},
                                         Wanted{"coconut_auto_track.glb", 3328.0, 6.0, nullptr},
                                         Wanted{"stk_startrack.b3d", 1324.9, 14.0,
                                                "stk_startrack_driveline.csv"},
                                         // A model: its area over its width.
                                         Wanted{"deepracer_austin_road.dae", 60.5, 1.5, nullptr}),
                         name_of);
INSTANTIATE_TEST_SUITE_P(
    SlowOthers, OpenMesh,
    testing::Values(Wanted{"kia4sm.ac", 4566.0, 3.0, nullptr},
                    Wanted{"stk_farm.b3d", 793.6, 8.0, "stk_farm_driveline.csv"},
                    Wanted{"stk_hacienda.b3d", 1157.8, 12.0, "stk_hacienda_driveline.csv"},
                    Wanted{"stk_islandtrack.b3d", 1392.7, 14.0, "stk_islandtrack_driveline.csv"},
                    Wanted{"stk_city.b3d", 1364.5, 14.0, "stk_city_driveline.csv"},
                    Wanted{"artudo_track.dae", 111.5, 2.5, nullptr},
                    Wanted{"deepracer_monaco_road.dae", 60.8, 1.5, nullptr}),
    name_of);

/// Every third point of a driveline, each moved by up to 1.5 m.
road::Guide disturbed(const base::CsvTable& driven, bool with_heights) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < driven.rows(); i += 3) {
    const double turn = 2.0 * std::numbers::pi * share(random),
                 off_m = 1.5 * std::sqrt(share(random));
    points.emplace_back(driven.value(i, 0) + off_m * std::cos(turn),
                        driven.value(i, 1) + off_m * std::sin(turn),
                        with_heights ? driven.value(i, 2) : std::nan(""));
  }
  return road::guide_along(points);
}

class GuidedMesh : public testing::TestWithParam<const char*> {};

TEST_P(GuidedMesh, IsRightOrItsMissingSurfaceIsSaid) {
  const std::string name = GetParam();
  if (!std::filesystem::exists(mesh_path("stk_" + name + ".b3d"))) GTEST_SKIP() << "absent";
  const base::CsvTable driven =
      base::read_csv(mesh_path("stk_" + name + "_driveline.csv"), {"x_m", "y_m"}, {"z_m"});
  const road::Mesh mesh = road::read_mesh(mesh_path("stk_" + name + ".b3d"));
  for (const bool with_heights : {false, true}) {
    road::CleanOptions options;
    options.guide = disturbed(driven, with_heights);
    EXPECT_TRUE(options.guide->closed);
    if (name == "fortmagma" || name == "mansion") {
      EXPECT_THROW(road::clean(mesh, options), road::NotUsable);
      continue;
    }
    const road::Centreline line = road::trace_centreline(road::clean(mesh, options));
    EXPECT_TRUE(line.closed);
    EXPECT_GE(on_road(driven, line), 0.98);
    if (!with_heights) continue;
    for (std::size_t i = 0; i < driven.rows(); ++i) {
      const Eigen::Vector3d p(driven.value(i, 0), driven.value(i, 1), driven.value(i, 2));
      double dz = 1e9;  // where the road crosses itself the other deck may lie nearer in plan
      for (std::size_t k = 0; k < line.points_m.size(); ++k) {
        const Eigen::Vector3d a = line.points_m[k],
                              ab = line.points_m[(k + 1) % line.points_m.size()] - a;
        const double t = std::clamp(
            (p - a).head<2>().dot(ab.head<2>()) / std::max(ab.head<2>().squaredNorm(), 1e-12), 0.0,
            1.0);
        if ((p - a - t * ab).head<2>().norm() < 1.5 * line.half_width_m[k] + 1.0)
          dz = std::min(dz, std::abs(p.z() - a.z() - t * ab.z()));
      }
      EXPECT_LT(dz, 3.0) << "another layer at " << p.transpose();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, GuidedMesh,
                         testing::Values("city", "farm", "hacienda", "islandtrack", "startrack",
                                         "sandtrack", "fortmagma", "mansion"),
                         [](const auto& mesh) { return std::string(mesh.param); });

TEST(Network, HasARoadAlongALineDrawnOnItsPicture) {
  if (!std::filesystem::exists(mesh_path("mcity.obj"))) GTEST_SKIP() << "absent";
  // Round the test town, drawn by hand on a picture of its materials, metres off.
  const std::vector<Eigen::Vector2d> drawn = {
      {37, 346},    {60, 402},    {110, 405},   {160, 398},  {220, 370},   {255, 328},
      {240, 280},   {190, 170},   {150, 75},    {138, -20},  {137, -127},  {150, -230},
      {155, -300},  {140, -360},  {100, -385},  {10, -400},  {-110, -414}, {-170, -400},
      {-190, -354}, {-190, -245}, {-184, -120}, {-172, -27}, {-167, 64},   {-150, 110},
      {-110, 150},  {-60, 165},   {-18, 200},   {25, 208},   {37, 240},    {37, 290}};
  std::vector<Eigen::Vector3d> points_m;
  for (const Eigen::Vector2d& p : drawn) points_m.emplace_back(p.x(), p.y(), std::nan(""));
  road::MeshReadOptions read;
  read.scale = 0.254;
  const road::Mesh mesh = road::read_mesh(mesh_path("mcity.obj"), read);
  road::CleanOptions options;
  options.guide = road::guide_along(points_m);
  road::CleanReport report;
  const road::RoadMesh surface = road::clean(mesh, options, &report);
  const road::Centreline line = road::trace_centreline(surface);
  EXPECT_TRUE(line.closed);
  EXPECT_NEAR(line.length_m, 2213.0, 22.0);  // on the picture, 1 %
  EXPECT_TRUE(
      road::doubts_about(line, road::RaySurface(surface.mesh), surface.mesh, mesh, report).empty());
  EXPECT_NO_THROW(road::fit_reference_line(line));
  for (const Eigen::Vector2d& p : drawn) {
    double nearest_m = 1e9;
    for (const Eigen::Vector3d& q : line.points_m)
      nearest_m = std::min(nearest_m, (q.head<2>() - p).norm());
    EXPECT_LT(nearest_m, 15.0) << p.transpose() << ": it was drawn up to 13 m off, in bends";
  }
}

TEST(Network, HasARouteRoundALoopOfACloverleaf) {
  if (!std::filesystem::exists(mesh_path("cloverleaf.obj"))) GTEST_SKIP() << "absent";
  road::MeshReadOptions read;
  read.unit = road::Unit::inch;
  const road::Mesh mesh = road::read_mesh(mesh_path("cloverleaf.obj"), read);
  road::CleanOptions options;
  options.route_m = {{-150.0, -12.0}, {12.0, -150.0}};  // eastwards, round the loop, southwards
  road::CleanReport report;
  const road::RoadMesh surface = road::clean(mesh, options, &report);
  const road::Centreline line = road::trace_centreline(surface);
  EXPECT_FALSE(line.closed);
  EXPECT_TRUE(
      road::doubts_about(line, road::RaySurface(surface.mesh), surface.mesh, mesh, report).empty());
  EXPECT_NO_THROW(road::fit_reference_line(line));
  double highest_m = 0.0, lowest_y_m = 0.0;
  for (const Eigen::Vector3d& p : line.points_m)
    highest_m = std::max(highest_m, p.z()), lowest_y_m = std::min(lowest_y_m, p.y());
  EXPECT_NEAR(highest_m, 5.5, 0.5) << "over the bridge";
  EXPECT_LT(lowest_y_m, -140.0);
  EXPECT_NEAR(line.length_m, 367.0, 10.0);
}

class MeshWithoutRoad : public testing::TestWithParam<const char*> {};

TEST_P(MeshWithoutRoad, IsRefusedOrDoubted) {
  // Where the surface of the road is missing, or only painted on the ground, the tool must not
  // praise what it finds.
  if (!std::filesystem::exists(mesh_path(GetParam())))
    GTEST_SKIP() << mesh_path(GetParam()) << " is absent";
  try {
    EXPECT_FALSE(find(GetParam()).doubts.empty());
  } catch (const road::Error&) {
  }
}

INSTANTIATE_TEST_SUITE_P(Some, MeshWithoutRoad,
                         testing::Values("stk_fortmagma.b3d", "superdrift_racetrack.glb"),
                         name_of_file);
INSTANTIATE_TEST_SUITE_P(SlowOthers, MeshWithoutRoad,
                         testing::Values("stk_mansion.b3d", "stk_sandtrack.b3d",
                                         "pmndrs_track_draco.glb"),
                         name_of_file);

}  // namespace open_meshes_test
