// The whole way from the demo circuit's mesh to a file, against the circuit's exact heights.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "crg/surface.h"
#include "road/build.h"
#include "road/export_mesh.h"
#include "road/synth.h"

namespace {

using road::CrossSection;

struct Case {
  const char* label;
  road::MeshFormat format;
  road::UpAxis up;
  road::NameStyle names;
};

class DemoCircuit : public testing::TestWithParam<Case> {};

TEST_P(DemoCircuit, BuiltRoadIsWithinTwoMillimetresOfTheTruth) {
  const Case& c = GetParam();
  const std::string dir = testing::TempDir() + "kerbstone_demo_" + c.label;
  const road::Circuit circuit =
      road::read_circuit(std::string(KERBSTONE_SOURCE) + "/tracks/kerbstone-ring/circuit.yaml");
  road::SynthOptions options;
  options.format = c.format;
  options.up = c.up;
  options.names = c.names;
  options.truth_step_m = 1.0;
  const road::SynthOutput made = write_synth(circuit, dir, options);
  road::Recipe recipe = road::recipe_for_mesh(made.mesh_path);
  recipe.read.up = c.up;
  const road::BuildResult built = build_track(recipe, dir);
  const crg::Surface surface(crg::read(built.crg_path));

  // Points on the road, away from the crossing, where (x, y) alone does not say which deck is
  // meant.
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::vector<double> errors;
  std::size_t asked = 0;
  std::size_t missing = 0;
  crg::Cursor cursor;
  while (asked < 20000) {
    const double u = share(random) * circuit.length_m();
    const CrossSection cross = section_at(circuit, u);
    const double v = cross.road_right_m + share(random) * (cross.road_left_m - cross.road_right_m);
    const crg::Point2 p = position_at(circuit, u, v);
    if (uv_of_position(circuit, p.x_m, p.y_m).size() != 1) continue;
    ++asked;
    const crg::Sample sample = surface.at_xy(p.x_m, p.y_m, cursor);
    if (!sample.valid) {
      ++missing;
    } else {
      errors.push_back(std::abs(sample.z_m - true_height(circuit, u, v)));
    }
  }
  ASSERT_FALSE(errors.empty());
  std::sort(errors.begin(), errors.end());
  const double p99 = errors[errors.size() * 99 / 100];
  RecordProperty("p99_um", static_cast<int>(p99 * 1e6));
  RecordProperty("max_um", static_cast<int>(errors.back() * 1e6));
  RecordProperty("missing", static_cast<int>(missing));
  EXPECT_LE(p99, 0.002);  // measured 0.44 mm
  EXPECT_EQ(missing, 0U);
  EXPECT_LT(errors.back(), 0.005);  // measured 2.5 mm
  std::filesystem::remove_all(dir);
}

INSTANTIATE_TEST_SUITE_P(
    Exports, DemoCircuit,
    testing::Values(
        Case{"obj_plain", road::MeshFormat::obj, road::UpAxis::y, road::NameStyle::plain},
        Case{"glb_ac", road::MeshFormat::glb, road::UpAxis::y, road::NameStyle::ac},
        Case{"obj_torcs", road::MeshFormat::obj, road::UpAxis::z, road::NameStyle::torcs}),
    [](const testing::TestParamInfo<Case>& one) { return one.param.label; });

}  // namespace
