// The whole way from a mesh to a checked CRG, on the project's own demo circuit with its exact
// answers.
#include "make/make_track.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "base/json_text.h"
#include "base/sha256.h"
#include "circuit/circuit.h"
#include "circuit/synth.h"
#include "crg/surface.h"
#include "mesh/export_mesh.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/ring_strips.h"
#include "support/temporary_folder.h"

namespace make_track_test {

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

const road::Circuit& demo() {
  static const road::Circuit circuit =
      road::read_circuit(places::source() + "/tracks/kerbstone-ring/circuit.yaml");
  return circuit;
}

/// The demo circuit built once from the given kind of mesh.
struct MadeRoad {
  std::shared_ptr<support::TemporaryFolder> folder = std::make_shared<support::TemporaryFolder>();
  road::BuildResult result;
  std::unique_ptr<crg::Surface> road;
  nlohmann::json summary;
};

MadeRoad build_demo(road::SynthOptions options) {
  options.truth_step_m = 5.0;  // the exact heights are asked of the circuit, not of the file
  MadeRoad built;
  const std::string dir = built.folder->path("demo");
  const auto synth = road::write_synth(demo(), dir, options);
  road::Recipe recipe = road::recipe_for_mesh(synth.mesh_path);
  recipe.read.up = options.up;
  recipe.read.unit = options.unit;
  built.result = road::make_track(recipe, dir + "/out");
  built.road = std::make_unique<crg::Surface>(crg::read(built.result.crg_path));
  built.summary = base::parse_json<nlohmann::json>(built.result.summary_json);
  return built;
}

/// As it is written without a word, built once.
const MadeRoad& plain_demo() {
  static const MadeRoad built = build_demo({});
  return built;
}

/// |file - truth| at random places of one class between the nodes; places without a height are
/// counted.
struct Compared {
  std::vector<double> error_m;
  std::size_t missing = 0;
};

Compared compare(const MadeRoad& built, road::SurfaceClass wanted, std::size_t points) {
  const crg::ReferenceLine& line = built.road->reference_line();
  const crg::Grid& grid = built.road->grid();
  Compared result;
  std::mt19937_64 random(11);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  const double length_m = line.u_step_m * static_cast<double>(line.size() - 1);
  const double start_u_m = road::uv_of_position(demo(), line.x_m[0], line.y_m[0]).at(0).u_m;
  for (std::size_t tries = 0;
       result.error_m.size() + result.missing < points && tries < 200 * points; ++tries) {
    const double u = length_m * uniform(),
                 v = grid.v_m.front() + (grid.v_m.back() - grid.v_m.front()) * uniform();
    const crg::Point2 p = built.road->xy_of_uv(u, v);
    const double z = built.road->z_at_uv(u, v);
    // Where the track crosses itself two places have this x, y: the one on this leg is meant. (The
    // middle of the road is up to some metres shorter or longer than the design's reference curve.)
    std::optional<double> truth;
    for (const auto& place : road::uv_of_position(demo(), p.x_m, p.y_m)) {
      const bool this_leg =
          std::abs(std::remainder(place.u_m - start_u_m - u, demo().length_m())) < 100.0;
      if (!this_leg || road::true_class(demo(), place.u_m, place.v_m) != wanted) continue;
      truth = road::true_height(demo(), place.u_m, place.v_m);
    }
    if (!truth) continue;
    if (std::isnan(z)) {
      ++result.missing;
      continue;
    }
    result.error_m.push_back(std::abs(z - *truth));
  }
  return result;
}

/// Pairs of neighbouring nodes along u that differ by more than any slope or kerb allows.
std::size_t jumps(const crg::Grid& grid) {
  std::size_t count = 0;
  for (std::size_t i = 0; i + 1 < grid.rows(); ++i) {
    for (std::size_t j = 0; j < grid.columns(); ++j)
      count += std::abs(grid.at(i + 1, j) - grid.at(i, j)) > 0.5f ? 1 : 0;
  }
  return count;
}

void expect_true_road(const MadeRoad& built, const char* name, std::size_t most_missing = 0) {
  const Compared road = compare(built, road::SurfaceClass::road, 20000);
  ASSERT_EQ(road.error_m.size() + road.missing, 20000u);
  SCOPED_TRACE(name);
  support::figure("z_p99_mm", 1e3 * quantile(road.error_m, 0.99));
  support::figure("z_largest_mm", 1e3 * quantile(road.error_m, 1.0));
  EXPECT_LE(quantile(road.error_m, 0.99), 0.002);
  EXPECT_EQ(jumps(built.road->grid()), 0u);
  EXPECT_LE(road.missing, most_missing);
  EXPECT_NEAR(built.summary["reference_line"]["length_m"].get<double>() / demo().length_m(), 1.0,
              0.005)
      << "the middle of the road is not the design's reference curve where the two widths differ";
  EXPECT_TRUE(built.summary["reference_line"]["closed"].get<bool>());
  EXPECT_TRUE(built.result.validation_failures.empty());
}

TEST(Build, TheDemoCircuitWithNames) { expect_true_road(plain_demo(), "obj, named"); }

TEST(SlowBuild, TheDemoCircuitWithoutNames) {
  expect_true_road(
      build_demo(
          {.format = road::MeshFormat::stl, .up = road::UpAxis::z, .names = road::NameStyle::none}),
      "stl, nameless",
      100);  // measured 45 of 20,000: shape alone tells the last decimetre of asphalt from grass
             // less surely
}

TEST(SlowBuild, TheDemoCircuitInFeetFromGlb) {
  expect_true_road(
      build_demo(
          {.format = road::MeshFormat::glb, .unit = road::Unit::ft, .names = road::NameStyle::ac}),
      "glb, feet");
}

TEST(SlowBuild, TheDemoCircuitWithTorcsNamesAndZUp) {
  expect_true_road(build_demo({.up = road::UpAxis::z, .names = road::NameStyle::torcs}),
                   "obj, TORCS names");
}

TEST(SlowBuild, TheDemoCircuitInCoarseFacets) {
  // validate compares with the mesh; the truth is farther: 10 m over a crest of 500 m radius sag by
  // 25 mm, 0.3 m of sagitta on 16 % of banking by 48 mm.
  const auto built = build_demo({.ring_step_m = 10, .column_step_m = 5, .max_sagitta_m = 0.3});
  EXPECT_TRUE(built.summary["reference_line"]["closed"].get<bool>());
  EXPECT_TRUE(built.result.validation_failures.empty());
  EXPECT_LE(quantile(compare(built, road::SurfaceClass::road, 5000).error_m, 0.99), 0.1);
}

TEST(Build, SaysWhatItDid) {
  const auto& built = plain_demo();
  const auto& s = built.summary;
  for (const char* path :
       {"/reference_line/length_m", "/reference_line/closed", "/grid/nodes", "/grid/holes",
        "/grid/u_step_m", "/validation/z_error_m/p50", "/validation/z_error_m/p95",
        "/validation/z_error_m/p99", "/validation/z_error_m/max"}) {
    EXPECT_TRUE(s.contains(nlohmann::json::json_pointer(path))) << path;
  }
  EXPECT_EQ(s["grid"]["nodes"].get<std::size_t>(), built.road->grid().z_m.size());
  EXPECT_NEAR(s["grid"]["u_step_m"].get<double>(), 0.1, 1e-4);
  EXPECT_LE(s["validation"]["z_error_m"]["p99"].get<double>(), 0.002);
  EXPECT_GT(s["kerb"]["cells"].get<std::size_t>(), 0u);
  for (const auto* file :
       {&built.result.crg_path, &built.result.stl_path, &built.result.centreline_path,
        &built.result.summary_path, &built.result.picture_path, &built.result.classes_path}) {
    EXPECT_TRUE(std::filesystem::exists(*file)) << *file;
  }
  EXPECT_GT(
      base::parse_json<nlohmann::json>(built.result.timing_json)["seconds"]["total"].get<double>(),
      0.0);
  // Nothing else lies in the folder but timing, manifest, the world file of the classes and the
  // cleaned mesh: no temporary files.
  const std::filesystem::path dir = std::filesystem::path(built.result.crg_path).parent_path();
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(dir),
                          std::filesystem::directory_iterator{}),
            10);
}

TEST(Build, TheRoadSaysWhatItWasMadeOf) {
  const support::TemporaryFolder folder;
  road::Mesh mesh;
  support::add_ring_strip(mesh, "road", -5.0, 5.0, 0.0, 0.0);
  road::export_mesh(mesh, folder.path("ring.obj"), {road::UpAxis::z, road::Unit::m});
  road::Recipe recipe = road::recipe_for_mesh(folder.path("ring.obj"));
  recipe.read.up = road::UpAxis::z;
  const crg::Crg file = crg::read(road::make_track(recipe, folder.path("out")).crg_path);
  const std::vector<std::string> wanted{"mesh: ring.obj, SHA-256",
                                        "  " + base::sha256_of_file(folder.path("ring.obj"))};
  ASSERT_EQ(file.comment.size(), 3u);
  EXPECT_TRUE(file.comment[0].starts_with("made by Kerbstone, crgbuild "));
  EXPECT_EQ(file.comment[1], wanted[0]);
  EXPECT_EQ(file.comment[2], wanted[1]);
}

TEST(Build, KnowsNoRoadBesideTheRoad) {
  const auto& built = plain_demo();
  for (const double v : {-200.0, -40.0, 40.0, 200.0})
    EXPECT_TRUE(std::isnan(built.road->z_at_uv(100.0, v))) << v;
  crg::Cursor cursor;
  EXPECT_FALSE(built.road->at_xy(5000.0, 5000.0, cursor).valid);
}

TEST(SlowBuild, RepeatsItselfToTheByte) {
  const auto a = build_demo({});
  const std::string crg = bytes_of(a.result.crg_path), stl = bytes_of(a.result.stl_path);
  const auto b = build_demo({});  // into the same folder
  EXPECT_TRUE(crg == bytes_of(b.result.crg_path));
  EXPECT_TRUE(stl == bytes_of(b.result.stl_path));
}

TEST(SlowBuild, MovesTheTrackByItsAlignmentWithoutChangingItsShape) {
  const support::TemporaryFolder folder;
  const std::string dir = folder.path("demo");
  const auto synth = road::write_synth(demo(), dir, {.truth_step_m = 5.0});
  road::Recipe recipe = road::recipe_for_mesh(synth.mesh_path);
  recipe.read.up = road::UpAxis::y;
  const auto plain = road::make_track(recipe, dir + "/plain");
  recipe.T_global_mesh = road::RotoTranslation{0.7, {691'000.0, 5'334'000.0, 512.0}};
  const auto moved = road::make_track(recipe, dir + "/moved");
  const crg::Surface a(crg::read(plain.crg_path)), b(crg::read(moved.crg_path));
  EXPECT_TRUE(moved.validation_failures.empty());
  for (double u = 5.0; u < 2000.0; u += 97.3) {
    const crg::Point2 p = a.xy_of_uv(u, 1.3), q = b.xy_of_uv(u, 1.3);
    EXPECT_NEAR(q.x_m, std::cos(0.7) * p.x_m - std::sin(0.7) * p.y_m + 691'000.0, 1e-5);
    EXPECT_NEAR(q.y_m, std::sin(0.7) * p.x_m + std::cos(0.7) * p.y_m + 5'334'000.0, 1e-5);
    EXPECT_NEAR(b.z_at_uv(u, 1.3), a.z_at_uv(u, 1.3) + 512.0, 5e-5);
  }
}

}  // namespace make_track_test
