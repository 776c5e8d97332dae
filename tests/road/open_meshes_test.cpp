// Meshes of other simulators, as they are (../shared/data/meshes beside the checkout; skipped where absent).
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>

#include "road/centreline.h"
#include "road/clean.h"
#include "road/csv.h"
#include "road/error.h"
#include "road/plausible.h"
#include "road/read_mesh.h"
#include "support/places.h"

namespace {

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
  found.doubts = road::doubts_about(found.line, road::RaySurface(surface.mesh), mesh, report);
  return found;
}

class OpenMesh : public testing::TestWithParam<Wanted> {};

TEST_P(OpenMesh, IsFoundWhole) {
  const Wanted& wanted = GetParam();
  if (!std::filesystem::exists(mesh_path(wanted.file))) GTEST_SKIP() << mesh_path(wanted.file) << " is absent";
  const Found found = find(wanted.file);
  EXPECT_TRUE(found.line.closed);
  EXPECT_NEAR(found.line.length_m, wanted.length_m, wanted.tolerance_m);
  for (const std::string& doubt : found.doubts) ADD_FAILURE() << doubt;
  if (wanted.driveline == nullptr) return;
  const road::CsvTable driven = road::read_csv(mesh_path(wanted.driveline), {"x_m", "y_m"}, {"z_m"});
  std::size_t on_road = 0;
  for (std::size_t i = 0; i < driven.rows(); ++i) {
    const Eigen::Vector2d p(driven.value(i, 0), driven.value(i, 1));
    double nearest = std::numeric_limits<double>::infinity();  // of the distance over the half width
    const auto& points = found.line.points_m;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Eigen::Vector2d a = points[k].head<2>(), b = points[(k + 1) % points.size()].head<2>();
      const double t = std::clamp((p - a).dot(b - a) / std::max((b - a).squaredNorm(), 1e-12), 0.0, 1.0);
      nearest = std::min(nearest, (p - a - t * (b - a)).norm() / found.line.half_width_m[k]);
    }
    on_road += nearest < 1.0 ? 1 : 0;
  }
  EXPECT_GE(static_cast<double>(on_road), 0.98 * static_cast<double>(driven.rows()));
}

INSTANTIATE_TEST_SUITE_P(All, OpenMesh,
                         testing::Values(Wanted{"archracer_track.obj", 404.0, 2.0, nullptr},
                                         Wanted{"coconut_auto_track.glb", 3328.0, 6.0, nullptr},
                                         Wanted{"kia4sm.ac", 4566.0, 3.0, nullptr},
                                         Wanted{"stk_farm.b3d", 793.6, 8.0, "stk_farm_driveline.csv"},
                                         Wanted{"stk_hacienda.b3d", 1157.8, 12.0, "stk_hacienda_driveline.csv"},
                                         Wanted{"stk_islandtrack.b3d", 1392.7, 14.0, "stk_islandtrack_driveline.csv"},
                                         Wanted{"stk_startrack.b3d", 1324.9, 14.0, "stk_startrack_driveline.csv"},
                                         Wanted{"stk_city.b3d", 1364.5, 14.0, "stk_city_driveline.csv"},
                                         // Models: their area over their width.
                                         Wanted{"artudo_track.dae", 111.5, 2.5, nullptr},
                                         Wanted{"deepracer_austin_road.dae", 60.5, 1.5, nullptr},
                                         Wanted{"deepracer_monaco_road.dae", 60.8, 1.5, nullptr}),
                         [](const auto& mesh) {
                           std::string name = mesh.param.file;
                           for (char& c : name)
                             if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
                           return name;
                         });

class MeshWithoutRoad : public testing::TestWithParam<const char*> {};

TEST_P(MeshWithoutRoad, IsRefusedOrDoubted) {
  // Where the surface of the road is missing, or only painted on the ground, the tool must not praise what it finds.
  if (!std::filesystem::exists(mesh_path(GetParam()))) GTEST_SKIP() << mesh_path(GetParam()) << " is absent";
  try {
    EXPECT_FALSE(find(GetParam()).doubts.empty());
  } catch (const road::Error&) {
  }
}

INSTANTIATE_TEST_SUITE_P(All, MeshWithoutRoad,
                         testing::Values("stk_fortmagma.b3d", "stk_mansion.b3d", "stk_sandtrack.b3d", "superdrift_racetrack.glb",
                                         "pmndrs_track_draco.glb"),
                         [](const auto& mesh) {
                           std::string name = mesh.param;
                           for (char& c : name)
                             if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
                           return name;
                         });

}  // namespace
