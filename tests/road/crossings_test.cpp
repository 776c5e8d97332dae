#include "road/crossings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "mesh/error.h"
#include "road/edges.h"
#include "road/reference_line.h"
#include "road/sample.h"
#include "support/strip_road.h"

namespace crossings_test {

constexpr double kSize_m = 150.0;

/// An eight that crosses itself square in plan at its parameter 0 and half way, `gap_m` apart in
/// height.
road::RoadMesh eight(double gap_m) {
  const auto plan = [](double s) -> support::PlanPoint {
    const double t = s / kSize_m;
    return {kSize_m * std::sin(t), kSize_m * std::sin(t) * std::cos(t),
            std::atan2(std::cos(2 * t), std::cos(t))};
  };
  return support::make_strip(plan, 2 * M_PI * kSize_m, 2.0, true, {-5, 0, 5},
                             [=](double s, double) { return 0.5 * gap_m * std::cos(s / kSize_m); });
}

struct Built {
  crg::ReferenceLine line;
  road::SampledGrid sampled;
  road::SampleReport report;
};

Built build(const road::RoadMesh& mesh, const road::SampleOptions& options = {}) {
  road::CentrelineOptions start;
  start.start_near_m = Eigen::Vector2d(kSize_m, 0.0);
  const auto centreline = road::trace_centreline(mesh, start);
  Built built;
  built.line = road::fit_reference_line(centreline);
  built.sampled = road::sample_grid(mesh, road::RaySurface(mesh.mesh), built.line, centreline,
                                    options, &built.report);
  return built;
}

TEST(Crossings, ALevelCrossingKeepsBothLegsAndIsSaid) {
  const Built built = build(eight(0.0));
  // From the tip of one leaf the two ways to the middle are a quarter and three quarters of the
  // length.
  const double length_m = built.line.u_step_m * static_cast<double>(built.line.size() - 1);
  ASSERT_EQ(built.report.crossings.size(), 1u);
  const road::Crossing& crossing = built.report.crossings[0];
  EXPECT_NEAR(crossing.u_first_m, 0.25 * length_m, 1.5);
  EXPECT_NEAR(crossing.u_second_m, 0.75 * length_m, 1.5);
  EXPECT_NEAR(crossing.height_m, 0.0, 1e-4);
  EXPECT_THAT(describe(crossing), testing::HasSubstr("lies level with"));
  EXPECT_EQ(built.report.holes, 0u);
  for (std::size_t i = 0; i < built.line.size(); ++i) {
    for (std::size_t j = 0; j < built.sampled.grid.columns(); ++j) {
      if (std::abs(built.sampled.grid.v_m[j]) > 4.8) continue;
      ASSERT_NEAR(built.sampled.grid.at(i, j), 0.0, 1e-4) << i << " " << j;
    }
  }
}

TEST(Crossings, ABridgeHasItsHeight) {
  const Built built = build(eight(8.8));
  ASSERT_EQ(built.report.crossings.size(), 1u);
  EXPECT_NEAR(std::abs(built.report.crossings[0].height_m), 8.8, 0.02);
  EXPECT_THAT(describe(built.report.crossings[0]),
              testing::AnyOf(testing::HasSubstr("8.8 m below"), testing::HasSubstr("8.8 m above")));
}

TEST(Crossings, ARoundRoadHasNone) {
  crg::ReferenceLine line;
  line.u_step_m = 0.1;
  line.closed = true;
  for (int i = 0; i <= 3600; ++i) {
    const double angle = 2 * M_PI * i / 3600.0;
    line.x_m.push_back(57.3 * std::cos(angle));
    line.y_m.push_back(57.3 * std::sin(angle));
  }
  EXPECT_TRUE(road::find_crossings(line, std::vector<double>(line.size(), 0.0)).empty());
  line.closed = false;  // its ends meet, which is no crossing of two places
  EXPECT_LE(road::find_crossings(line, std::vector<double>(line.size(), 0.0)).size(), 1u);
}

TEST(Sample, RefusesARoadNarrowerThanTwoSteps) {
  road::SampleOptions options;
  options.v_step_m = 6.0;
  try {
    build(eight(0.0), options);
    FAIL() << "a road of 10 m took steps of 6 m";
  } catch (const road::Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("wanted at least two steps across, 12 m"));
  }
}

TEST(Sample, RefusesStepsThatFloat32DoesNotResolve) {
  // 50 km from the middle of the mesh float32 snaps to 4 mm.
  road::RoadMesh mesh =
      support::make_strip(support::straight, 400.0, 10.0, false, {-5, 5}, support::flat);
  for (auto& vertex : mesh.mesh.vertices_m) vertex.x() += 50000.0;
  road::RoadMesh far = mesh;
  far.mesh.vertices_m.emplace_back(-50400.0, 0.0, 0.0);
  far.mesh.vertices_m.emplace_back(-50400.0, 1.0, 0.0);
  far.mesh.vertices_m.emplace_back(-50399.0, 0.0, 0.0);
  const auto n = static_cast<std::uint32_t>(mesh.mesh.vertices_m.size());
  far.mesh.triangles.push_back({n, n + 1, n + 2});
  far.mesh.object_of_triangle.push_back(0);
  far.class_of_triangle.push_back(road::SurfaceClass::road);
  const auto centreline = road::trace_centreline(mesh);
  road::ReferenceLineOptions fine;
  fine.u_step_m = 0.01;
  const auto line = road::fit_reference_line(centreline, fine);
  try {
    road::sample_grid(far, road::RaySurface(far.mesh), line, centreline);
    FAIL() << "took steps of 10 mm where float32 snaps to 4 mm";
  } catch (const road::Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("where float32 resolves 0.00391 m"));
  }
}

}  // namespace crossings_test
