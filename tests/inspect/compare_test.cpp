#include "inspect/compare.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "crg/file.h"
#include "support/oval_road.h"

namespace compare_test {

using test_support::mesh_of;
using test_support::Oval;
using test_support::oval_road;
using test_support::OvalOptions;
using test_support::plant;

const Oval& clean_oval() {
  static const Oval oval = oval_road();
  return oval;
}

struct Road {
  crg::Surface surface;
  road::HeightMap map;
  road::KerbStrips kerbs;
  explicit Road(const Oval& oval)
      : surface(crg::make_crg(oval.line, oval.grid)),
        map(road::height_map(surface)),
        kerbs(road::find_kerb_strips(map)) {}
};

TEST(Compare, TheSameRoadDiffersNowhere) {
  const Road a(clean_oval());
  const road::Comparison c =
      road::compare(a.map, a.kerbs, road::reference_of(a.surface), "other file");
  EXPECT_LT(c.abs_error_m.max, 1e-5);
  EXPECT_EQ(c.share_without_reference, 0.0);
  EXPECT_GT(c.points, 100000u);
  EXPECT_TRUE(c.findings.empty());
  EXPECT_EQ(c.kerb_cuts.size(), 4u);
  EXPECT_EQ(c.worst.size(), 10u);
}

TEST(Compare, LostKerbIsFoundInItsPlaceAgainstAMeshAndAnotherFile) {
  const Road truth(clean_oval());
  Oval flat = clean_oval();
  // 30 mm off the crest of the left kerb of the first bend, from 330 to 345 m.
  plant(flat, [](double u, double v) {
    const double across = v - 6.0;
    if (u < 330.0 || u > 345.0 || across <= 0.0 || across >= 1.0) return 0.0;
    return -0.03 * (across < 0.6 ? across / 0.6 : (1.0 - across) / 0.4);
  });
  const Road file(flat);
  const road::Mesh mesh = mesh_of(clean_oval(), 1);
  const road::RaySurface rays(mesh);
  for (const bool against_mesh : {true, false}) {
    const road::Comparison c = road::compare(
        file.map, file.kerbs,
        against_mesh ? road::reference_of(rays) : road::reference_of(truth.surface), "reference");
    ASSERT_EQ(c.findings.size(), 1u) << against_mesh;
    EXPECT_EQ(c.findings[0].kind, "kerb_loss");
    EXPECT_NEAR(c.findings[0].u_begin_m, 330.0, 1.0);
    EXPECT_NEAR(c.findings[0].u_end_m, 345.0, 1.0);
    EXPECT_NEAR(c.findings[0].value, 0.03, 0.002);
    EXPECT_NEAR(c.abs_error_m.max, 0.03, 0.003);
  }
}

TEST(Compare, AMeshOfTheSameRoadGivesNoFinding) {
  for (const char iso_class : {'B', 'C'}) {
    OvalOptions options;
    options.iso_class = iso_class;
    const Oval oval = oval_road(options);
    const Road file(oval);
    const road::Mesh mesh = mesh_of(oval, 2);
    const road::RaySurface rays(mesh);
    const road::Comparison c =
        road::compare(file.map, file.kerbs, road::reference_of(rays), "mesh");
    for (const auto& f : c.findings) ADD_FAILURE() << iso_class << " " << f.text;
    EXPECT_LT(c.abs_error_m.p99, 0.003);
    EXPECT_GT(c.abs_error_m.p99, 0.0);
  }
}

TEST(Compare, ARaisedPieceAndAMissingPieceAreFindings) {
  Oval high = clean_oval();
  plant(high, [](double u, double v) {
    return u > 500.0 && u < 510.0 && std::abs(v) < 2.0 ? 0.05 : 0.0;
  });
  const Road file(high);
  road::Mesh mesh = mesh_of(clean_oval(), 1);
  // 3 m of mesh are missing: 30 rows of 2 x 180 triangles.
  const std::size_t per_row = 2 * (clean_oval().grid.columns() - 1);
  mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(1000 * per_row),
                       mesh.triangles.begin() + static_cast<std::ptrdiff_t>(1030 * per_row));
  mesh.object_of_triangle.resize(mesh.triangles.size());
  const road::RaySurface rays(mesh);
  const road::Comparison c = road::compare(file.map, file.kerbs, road::reference_of(rays), "mesh");
  ASSERT_EQ(c.findings.size(), 3u);
  EXPECT_EQ(c.findings[0].kind, "deviation");
  EXPECT_NEAR(c.findings[0].value, 0.05, 0.001);
  EXPECT_NEAR(c.findings[0].u_begin_m, 500.0, 1.0);
  EXPECT_NEAR(c.findings[0].v_end_m, 2.0, 0.5);
  EXPECT_EQ(c.findings[1].kind, "no_reference");
  EXPECT_NEAR(c.findings[1].u_begin_m, 100.0, 1.0);
  EXPECT_NEAR(c.findings[1].value, 54.0, 10.0);
  // 0.3 % of the road: more than validation accepts.
  EXPECT_EQ(c.findings[2].kind, "no_reference");
  EXPECT_EQ(c.findings[2].severity, road::Severity::error);
  EXPECT_NEAR(c.worst[0].error_m, 0.05, 0.001);
}

TEST(Compare, OneAndManyThreadsGiveTheSame) {
  const Road file(clean_oval());
  const road::Mesh mesh = mesh_of(clean_oval(), 4);
  const road::RaySurface rays(mesh);
  road::CompareOptions one, many;
  one.threads = 1;
  many.threads = 7;
  const auto a = road::compare(file.map, file.kerbs, road::reference_of(rays), "mesh", one);
  const auto b = road::compare(file.map, file.kerbs, road::reference_of(rays), "mesh", many);
  ASSERT_EQ(a.error_m.size(), b.error_m.size());
  EXPECT_EQ(0, std::memcmp(a.error_m.data(), b.error_m.data(), a.error_m.size() * sizeof(float)));
}

/// Points on the road of the oval with the bump, 5 mm of noise, one in fifty half a metre above.
TEST(Compare, ACloudShowsWhatTheFileLacks) {
  Oval bumpy = clean_oval();
  plant(bumpy, [](double u, double) {
    return std::abs(u - 150.0) > 2.0 ? 0.0 : 0.03 * (1.0 + std::cos(M_PI * (u - 150.0) / 2.0));
  });
  const crg::Surface truth(crg::make_crg(bumpy.line, bumpy.grid));
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.005);
  std::vector<Eigen::Vector3d> points;
  for (double u = 100.0; u < 200.0; u += 0.05) {
    for (double v = -4.0; v < 4.0; v += 0.05) {
      const crg::Point2 xy = truth.xy_of_uv(u, v);
      const bool stray = points.size() % 50 == 0;
      points.emplace_back(xy.x_m, xy.y_m,
                          truth.z_at_uv(u, v) + noise(random) + (stray ? 0.5 : 0.0));
    }
  }
  const Road file(clean_oval());
  const road::ReferenceHeights cloud = road::reference_of(std::span<const Eigen::Vector3d>(points));
  // Where nothing is planted: the mean of some 70 points of 5 mm each.
  std::vector<crg::Point2> at;
  std::vector<double> known, got(200);
  for (int k = 0; k < 200; ++k) {
    const crg::Point2 xy = truth.xy_of_uv(110.0 + 0.1 * k, -3.0 + 0.03 * k);
    at.push_back({xy.x_m, xy.y_m});
    known.push_back(truth.z_at_uv(110.0 + 0.1 * k, -3.0 + 0.03 * k));
  }
  cloud(at, known, got);
  for (std::size_t k = 0; k < got.size(); ++k) EXPECT_NEAR(got[k], known[k], 0.003) << k;
  road::CompareOptions options;
  options.reference_is_truth = false;
  const road::Comparison c = road::compare(file.map, file.kerbs, cloud, "cloud", options);
  ASSERT_EQ(c.findings.size(), 1u);
  EXPECT_EQ(c.findings[0].kind, "deviation");
  EXPECT_NEAR(c.findings[0].value, -0.06, 0.006);
  EXPECT_GT(c.findings[0].u_begin_m, 147.0);
  EXPECT_LT(c.findings[0].u_end_m, 153.0);
  EXPECT_EQ(c.findings[0].severity, road::Severity::remark);
  EXPECT_GT(c.share_without_reference, 0.8);
}

}  // namespace compare_test
