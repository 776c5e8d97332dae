// What must survive the whole way on a real mesh: kerb profiles, and damages of the mesh.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "crg/surface.h"
#include "make/make_reported.h"
#include "make/make_track.h"
#include "mesh/error.h"
#include "mesh/export_mesh.h"
#include "mesh/ray_surface.h"
#include "support/figure.h"
#include "support/mutate_mesh.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace hard_mesh_test {

std::string torcs(const std::string& name) {
  return places::torcs_tracks() + "/road/" + name + "/" + name + ".acc";
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

TEST(HardMesh, KerbProfilesSurviveEveryStage) {
  const std::string path = torcs("aalborg");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent (apt install torcs-data)";
  const support::TemporaryFolder folder;
  road::Recipe recipe = road::recipe_for_mesh(path);
  recipe.smooth.window_u_m = 1.0;  // every stage has its turn
  const auto built = road::make_track(recipe, folder.path("refined"));
  recipe.kerb.max_extra_columns_share = 0.0;
  const auto plain = road::make_track(recipe, folder.path("plain"));
  const double ratio = static_cast<double>(std::filesystem::file_size(built.crg_path)) /
                       static_cast<double>(std::filesystem::file_size(plain.crg_path));

  const road::RaySurface mesh(road::read_mesh(path));
  const auto kerbs = base::parse_json<nlohmann::json>(built.summary_json)["kerb"]["kerbs"];
  ASSERT_GT(kerbs.size(), 10u);
  const auto profile_errors = [&](const std::string& crg_path, bool at_edges) {
    const crg::Surface road(crg::read(crg_path));
    std::vector<double> errors;
    for (const auto& kerb : kerbs) {
      const double u0 = kerb["u_begin_m"], u1 = kerb["u_end_m"], v0 = kerb["v_begin_m"],
                   v1 = kerb["v_end_m"];
      for (const double station : {0.1, 0.3, 0.5, 0.7, 0.9}) {
        const double u = u0 + station * (u1 - u0);
        // 1 cm steps over the kerb and 10 cm beside it on both sides.
        for (double v = v0 - 0.1; v <= v1 + 0.1; v += 0.01) {
          const double z = road.z_at_uv(u, v);
          if (std::isnan(z) || (at_edges && std::min(std::abs(v - v0), std::abs(v - v1)) > 0.05))
            continue;
          const crg::Point2 p = road.xy_of_uv(u, v);
          const auto hit = mesh.nearest_hit(p.x_m, p.y_m, z, 0.5);
          if (hit) errors.push_back(std::abs(hit->z_m - z));
        }
      }
    }
    return errors;
  };
  const auto refined = profile_errors(built.crg_path, false),
             unrefined = profile_errors(plain.crg_path, false);
  const auto edges = profile_errors(built.crg_path, true),
             edges_unrefined = profile_errors(plain.crg_path, true);
  std::printf(
      "within 5 cm of the kerbs' outermost edges, %zu points: p90 %.2f, p95 %.2f mm; unrefined p90 "
      "%.2f, p95 %.2f mm\n",
      edges.size(), 1e3 * quantile(edges, 0.9), 1e3 * quantile(edges, 0.95),
      1e3 * quantile(edges_unrefined, 0.9), 1e3 * quantile(edges_unrefined, 0.95));
  std::printf("aalborg, %zu kerbs, %zu points: unrefined p95 %.2f mm; file %.3f times as large\n",
              kerbs.size(), refined.size(), 1e3 * quantile(unrefined, 0.95), ratio);
  support::figure("p95_mm", 1e3 * quantile(refined, 0.95));
  support::figure("p99_mm", 1e3 * quantile(refined, 0.99));
  support::figure("largest_mm", 1e3 * quantile(refined, 1.0));
  EXPECT_GT(refined.size(), 5000u);
  EXPECT_LE(quantile(refined, 0.95), 2e-3);
  EXPECT_LE(ratio, 1.5);
}

TEST(HardMesh, JitterAndMissingOrDoubledTrianglesMakeNoNewFailure) {
  const std::string path = torcs("g-track-3");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent (apt install torcs-data)";
  const support::TemporaryFolder folder;
  const road::Mesh mesh = road::read_mesh(path);
  const auto whole = base::parse_json<nlohmann::json>(
      road::make_track(road::recipe_for_mesh(path), folder.path("whole")).summary_json);
  road::Mesh damaged = support::jitter(mesh, 1e-3, 7);
  damaged = support::delete_triangles(std::move(damaged), 0.005, 8);
  damaged = support::duplicate_triangles(std::move(damaged), 0.005, 9);
  for (const char* ending : {"obj", "stl"}) {
    const std::string file = folder.path(std::string("damaged.") + ending);
    road::export_mesh(damaged, file, {road::UpAxis::z, road::Unit::m});
    road::Recipe recipe = road::recipe_for_mesh(file);
    recipe.read.up = road::UpAxis::z;
    const auto built = road::make_track(recipe, folder.path(ending));
    const auto s = base::parse_json<nlohmann::json>(built.summary_json);
    EXPECT_TRUE(built.validation_failures.empty())
        << ending << ": " << built.validation_failures.front();
    EXPECT_EQ(s["reference_line"]["closed"], whole["reference_line"]["closed"]);
    const double length = whole["reference_line"]["length_m"];
    EXPECT_NEAR(s["reference_line"]["length_m"].get<double>(), length, 5e-4 * length) << ending;
    // Where several triangles beside each other are gone nothing is invented.
    EXPECT_GT(s["grid"]["holes"].get<int>(), whole["grid"]["holes"].get<int>()) << ending;
    // By shape, run-off ends at a hole and doubled triangles count as scenery. Measured against the
    // whole mesh with names: 2.3 % fewer nodes, 1.3 % with names.
    EXPECT_GT(s["grid"]["nodes_with_z"].get<double>(),
              0.97 * whole["grid"]["nodes_with_z"].get<double>())
        << ending;
    if (std::string(ending) == "obj") {
      EXPECT_GT(s["clean"]["triangles_dropped_by_reason"].value("duplicate", 0), 5);
    }
    support::figure_of_case("z_p99_mm", 1e3 * s["validation"]["z_error_m"]["p99"].get<double>());
    support::figure_of_case("holes", s["grid"]["holes"].get<int>());
    EXPECT_LE(s["validation"]["z_error_m"]["p99"].get<double>(), 1.5e-3) << ending;
  }
}

/// What happens to a mesh on its way through other programs.
struct Form {
  const char* name;
  const char* ending;
  bool named, torn;
  double dropped;
};

TEST(SlowHardMesh, EveryTrackInEveryForm) {
  const std::string tracks = places::torcs_tracks();
  if (!std::filesystem::exists(tracks)) GTEST_SKIP() << tracks << " is absent (torcs-data)";
  std::ifstream table(places::source() + "/tests/bench/roads/torcs.csv");
  std::size_t seen = 0;
  for (std::string row; std::getline(table, row);) {
    const std::size_t comma = row.find(".acc,");
    if (comma == std::string::npos) continue;
    const std::string name = row.substr(0, comma + 4);
    const double length_m = std::stod(row.substr(comma + 5));
    const road::Mesh mesh = road::read_mesh(fmt::format("{}/{}", tracks, name));
    for (const Form& form :
         {Form{"nameless", "obj", false, false, 0.0},
          Form{"vertices apart, 0.3 mm", "obj", true, true, 0.0},
          Form{"0.2 % dropped", "obj", true, false, 0.002}, Form{"stl", "stl", false, false, 0.0},
          Form{"stl, 0.2 % dropped", "stl", false, false, 0.002}}) {
      const support::TemporaryFolder folder;
      road::Mesh changed = form.named ? mesh : support::strip_names(mesh);
      if (form.torn) changed = support::jitter(std::move(changed), 3e-4, 7, true);
      if (form.dropped > 0.0)
        changed = support::delete_triangles(std::move(changed), form.dropped, 8);
      const std::string file = folder.path(std::string("track.") + form.ending);
      road::export_mesh(changed, file, {road::UpAxis::z, road::Unit::m});
      ++seen;
      try {
        const auto built =
            road::make_reported({file, folder.path("road"), true, false, {{"up", "z"}}});
        EXPECT_EQ(road::why_not_usable(built), "") << name << ", " << form.name;
        const auto s = base::parse_json<nlohmann::json>(built.result.summary_json);
        EXPECT_NEAR(s["reference_line"]["length_m"].get<double>(), length_m, 3e-3 * length_m)
            << name << ", " << form.name;
        EXPECT_LE(s["validation"]["z_error_m"]["p99"].get<double>(), 1e-3)
            << name << ", " << form.name;
      } catch (const road::Error& error) {
        ADD_FAILURE() << name << ", " << form.name << ": " << error.what();
      }
    }
  }
  EXPECT_EQ(seen, 26u * 5u);
}

}  // namespace hard_mesh_test
