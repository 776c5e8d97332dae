// Roughness that a recipe adds to a smooth mesh, looked at in the written road.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/json_text.h"
#include "crg/file.h"
#include "crg/surface.h"
#include "make/make_road.h"
#include "mesh/error.h"
#include "mesh/export_mesh.h"
#include "road/roughness.h"
#include "support/strip_road.h"
#include "support/temporary_folder.h"

namespace roughen_test {

using road::RecipeKey;

void set(road::Recipe& recipe, const std::string& name, const std::string& value) {
  for (const RecipeKey& key : road::recipe_keys())
    if (key.name == name) return key.set(recipe, value);
  FAIL() << "no key " << name;
}

constexpr double kRadius_m = 80.0, kLength_m = 2 * std::numbers::pi * kRadius_m;

/// A level ring of facets as short as a metre.
road::Recipe ring(const support::TemporaryFolder& folder) {
  const road::RoadMesh strip =
      support::make_strip([](double s) { return support::circle(s, kRadius_m); }, kLength_m, 1.0,
                          true, {-4, -2, 0, 2, 4}, [](double, double) { return 7.0; });
  road::export_mesh(strip.mesh, folder.path("ring.obj"));
  road::Recipe recipe = road::recipe_for_mesh(folder.path("ring.obj"));
  set(recipe, "up", "z");
  set(recipe, "unit", "m");
  set(recipe, "v_max_m", "6");
  recipe.line_is_right = true;
  return recipe;
}

struct Written {
  crg::Crg file;
  road::BuildResult result;
};
Written built(const support::TemporaryFolder& folder, const road::Recipe& recipe) {
  road::MadeRoad built = road::make_road(recipe, road::inputs_of(recipe), {});
  base::OutputSet outputs(folder.path("out"), road::kBuildCommand);
  Written out{{}, road::write(built, outputs)};
  outputs.commit(recipe.name);
  out.file = crg::read(out.result.crg_path);
  return out;
}

/// Heights along the line v over the mesh's 7 m.
std::vector<double> section_m(const crg::Crg& file, double v_m) {
  const crg::Surface surface(file);
  std::vector<double> out;
  for (std::size_t i = 0; i < file.grid.z_m.size() / file.grid.v_m.size(); ++i)
    out.push_back(
        surface.at_uv(file.grid.u_begin_m + static_cast<double>(i) * file.grid.u_step_m, v_m).z_m -
        7.0);
  return out;
}

double rms(const std::vector<double>& all) {
  double sum2 = 0.0;
  for (const double one : all) sum2 += one * one;
  return std::sqrt(sum2 / static_cast<double>(all.size()));
}

// ISO 8608, table of classes: Gd(0.1 cycle/m) of class C is 256e-6 m^3 (geometric mean), and falls
// with the square. Between 0.2 and 2 cycles/m that is a variance of 256e-8 (1 / 0.2 - 1 / 2).
TEST(Roughen, HasTheSpectrumOfItsClassAndNothingOutsideItsBand) {
  const support::TemporaryFolder folder;
  road::Recipe recipe = ring(folder);
  set(recipe, "roughness_class", "C");
  const Written road = built(folder, recipe);
  const double wanted_m = std::sqrt(256e-8 * 4.5);
  for (const double v_m : {-2.0, 0.0, 1.5}) {
    const std::vector<double> section = section_m(road.file, v_m);
    EXPECT_NEAR(rms(section), wanted_m, 0.05 * wanted_m) << "v = " << v_m;
    const auto density = road::displacement_psd({&section, 1}, road.file.grid.u_step_m);
    double inside = 0.0, outside = 0.0;
    for (std::size_t k = 0; k < density.n_cpm.size(); ++k) {
      const double n = density.n_cpm[k];
      (n > 0.18 && n < 2.1 ? inside : outside) += density.psd_m3[k];
    }
    EXPECT_LT(outside, 0.02 * inside) << "v = " << v_m;
    // Far from the ends of the band, the density itself.
    double octave = 0.0, count = 0.0;
    for (std::size_t k = 0; k < density.n_cpm.size(); ++k)
      if (density.n_cpm[k] > 0.5 && density.n_cpm[k] < 1.0)
        octave += density.psd_m3[k] * std::pow(density.n_cpm[k] / 0.1, 2), count += 1.0;
    EXPECT_NEAR(octave / count, 256e-6, 0.25 * 256e-6) << "v = " << v_m;
  }
}

TEST(Roughen, ClosesWithTheRoadAndPassesItsCheck) {
  const support::TemporaryFolder folder;
  road::Recipe recipe = ring(folder);
  set(recipe, "roughness_class", "G");  // an rms of 54 mm: more than validation lets pass
  const Written road = built(folder, recipe);
  EXPECT_TRUE(road.result.validation_failures.empty())
      << ::testing::PrintToString(road.result.validation_failures);
  // What was added is no error of the road, and leaves no room for one.
  EXPECT_LT(base::parse_json<nlohmann::json>(road.result.summary_json)
                .at("validation")
                .at("z_error_m")
                .at("max")
                .get<double>(),
            1e-5);
  const std::vector<double> section = section_m(road.file, 0.0);
  EXPECT_GT(rms(section), 0.01);
  EXPECT_NEAR(section.front(), section.back(), 1e-4);
  const std::size_t last = section.size() - 1;
  // Over the seam it bends no more than elsewhere.
  double bend_m = 0.0;
  for (std::size_t i = 1; i < last; ++i)
    bend_m = std::max(bend_m, std::abs(section[i + 1] - 2 * section[i] + section[i - 1]));
  EXPECT_LT(std::abs(section[1] - section[0] - (section[last] - section[last - 1])), bend_m);
}

TEST(Roughen, IsTheSameForAnyThreadsAndAnotherForAnotherSeed) {
  const support::TemporaryFolder folder;
  road::Recipe recipe = ring(folder);
  set(recipe, "roughness_class", "A");
  const auto with = [&](const char* threads, const char* seed) {
    set(recipe, "threads", threads);
    set(recipe, "roughness_seed", seed);
    return built(folder, recipe).file.grid.z_m;
  };
  const auto equal = [](const std::vector<float>& a, const std::vector<float>& b) {
    for (std::size_t k = 0; k < std::max(a.size(), b.size()); ++k)
      if (k >= std::min(a.size(), b.size()) || !(a[k] == b[k] || (a[k] != a[k] && b[k] != b[k])))
        return false;
    return true;
  };
  const auto one = with("1", "1");
  EXPECT_TRUE(equal(with("3", "1"), one));
  EXPECT_FALSE(equal(with("1", "2"), one));
}

TEST(Roughen, OfAStretchIsThatOfTheWholeRoad) {
  const support::TemporaryFolder folder;
  road::Recipe recipe = ring(folder);
  set(recipe, "roughness_class", "D");
  const road::MadeRoad whole = road::make_road(recipe, road::inputs_of(recipe), {});
  road::MakeOptions options;
  options.stretch = road::URange{kLength_m - 30.0, 20.0};
  const road::MadeRoad part = road::make_road(recipe, road::inputs_of(recipe), options);
  const auto& a = whole.sampled.grid;
  const auto& b = part.sampled.grid;
  ASSERT_EQ(a.v_m.size(), b.v_m.size());
  const std::size_t columns = a.v_m.size(), rows = a.z_m.size() / columns;
  const auto first = static_cast<std::size_t>(
      std::lround((part.line.u_begin_m - whole.line.u_begin_m) / whole.line.u_step_m));
  std::size_t compared = 0;
  for (std::size_t i = 0; i * columns < b.z_m.size(); ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      const float there = a.z_m[(first + i) % (rows - 1) * columns + j],
                  here = b.z_m[i * columns + j];
      if (std::isnan(there) || std::isnan(here)) continue;
      ++compared;
      EXPECT_NEAR(here, there, 2e-5);
    }
  EXPECT_GT(compared, 1000u);
}

TEST(Roughen, RefusesWavesThatGridOrRoadCannotHold) {
  const support::TemporaryFolder folder;
  const auto message = [&](const char* longest, const char* shortest) -> std::string {
    road::Recipe recipe = ring(folder);
    set(recipe, "roughness_class", "B");
    set(recipe, "roughness_longest_wave_m", longest);
    set(recipe, "roughness_shortest_wave_m", shortest);
    try {
      built(folder, recipe);
      return "";
    } catch (const road::Error& error) {
      return error.what();
    }
  };
  EXPECT_NE(message("5", "0.2").find("smaller --u-step-m"), std::string::npos);
  EXPECT_NE(message("1", "2").find("must be longer"), std::string::npos);
  EXPECT_EQ(message("5", "0.8"), "");
}

TEST(Roughen, IsOffUnlessItIsAskedFor) {
  const support::TemporaryFolder folder;
  const Written road = built(folder, ring(folder));
  EXPECT_LT(rms(section_m(road.file, 0.0)), 1e-6);
  EXPECT_NE(road.result.summary_json.find("\"roughen\": null"), std::string::npos);
}

}  // namespace roughen_test
