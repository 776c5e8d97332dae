#include "road/stretch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "make/make_road.h"
#include "mesh/error.h"
#include "mesh/export_mesh.h"
#include "support/strip_road.h"
#include "support/temporary_folder.h"

namespace road {
namespace stretch_test {

crg::ReferenceLine circle(double step_m, std::size_t nodes, bool closed) {
  crg::ReferenceLine line;
  line.u_step_m = step_m;
  line.closed = closed;
  for (std::size_t i = 0; i < nodes; ++i) {
    const double angle = 2.0 * M_PI * static_cast<double>(i) / static_cast<double>(nodes - 1);
    line.x_m.push_back(std::cos(angle));
    line.y_m.push_back(std::sin(angle));
    line.heading_rad.push_back(angle);
  }
  return line;
}

TEST(Stretch, HasTheRowsFromOnePlaceToAnother) {
  const crg::ReferenceLine line = circle(0.5, 201, true);
  const RowRange rows = rows_between(line, 10.0, 20.2);
  EXPECT_EQ(rows.first, 20u);
  EXPECT_EQ(rows.count, 22u);  // 10.0 to 20.5
  const crg::ReferenceLine part = line_of_rows(line, rows);
  EXPECT_EQ(part.size(), 22u);
  EXPECT_FALSE(part.closed);
  EXPECT_EQ(part.u_begin_m, 10.0);
  EXPECT_EQ(part.x_m[3], line.x_m[23]);
  EXPECT_EQ(part.heading_rad[3], line.heading_rad[23]);
}

TEST(Stretch, GoesOverTheStartOfAClosedLine) {
  const crg::ReferenceLine line = circle(0.5, 201, true);
  const RowRange rows = rows_between(line, 98.0, 1.0);
  const crg::ReferenceLine part = line_of_rows(line, rows);
  // 98.0, 98.5, 99.0, 99.5, 0, 0.5, 1.0: the last node of the line is its first.
  ASSERT_EQ(part.size(), 7u);
  EXPECT_EQ(part.x_m[3], line.x_m[199]);
  EXPECT_EQ(part.x_m[4], line.x_m[0]);
  EXPECT_EQ(part.heading_rad[4], line.heading_rad[200]) << "of the step before it";
  EXPECT_EQ(part.x_m[6], line.x_m[2]);
  EXPECT_THROW(rows_between(circle(0.5, 201, false), 98.0, 1.0), Error);
}

TEST(Stretch, OutsideTheLineThereIsNone) {
  const crg::ReferenceLine line = circle(0.5, 201, true);
  EXPECT_THROW(rows_between(line, 200.0, 300.0), Error);
  EXPECT_THROW(rows_between(line, -20.0, -10.0), Error);
  EXPECT_THROW(rows_between(line, 10.0, 10.2), Error);
  EXPECT_THROW(rows_between(line, std::nan(""), 10.0), Error);
  EXPECT_EQ(rows_between(line, -1e9, 1e9).count, 201u);
}

/// A ring of 60 m radius with a ridge.
RoadMesh ring() {
  return support::make_strip(
      [](double s) { return support::circle(s, 60.0); }, 2 * M_PI * 60.0, 1.0, true,
      {-6, -3, 0, 3, 4, 4.01, 5, 5.01, 6},
      [](double, double v) { return 0.004 * v + (v > 4.005 && v < 5.005 ? 0.05 : 0.0); });
}

/// Nodes whose heights differ between rows of the whole grid (of a closed road, or of an open one
/// that does not end there) and the grid of a stretch; rows at its
/// ends have no neighbours to lean on.
struct Compared {
  std::size_t nodes = 0, differ = 0;
};
Compared compare(const crg::Grid& whole, const crg::Grid& part) {
  const auto first =
      static_cast<std::size_t>(std::lround((part.u_begin_m - whole.u_begin_m) / whole.u_step_m));
  Compared out;
  for (std::size_t i = 1; i + 1 < part.rows(); ++i) {
    // Nor have the first and the last row of the whole, not even where it is closed.
    if ((first + i) % (whole.rows() - 1) == 0) continue;
    for (std::size_t j = 0; j < whole.columns(); ++j) {
      const float z = whole.at((first + i) % (whole.rows() - 1), j);
      const auto at = std::find(part.v_m.begin(), part.v_m.end(), whole.v_m[j]);
      const float same = at == part.v_m.end()
                             ? std::nanf("")
                             : part.at(i, static_cast<std::size_t>(at - part.v_m.begin()));
      out.nodes += std::isnan(z) ? 0 : 1;
      // A ray that meets the edge of two triangles may take either.
      out.differ += (std::isnan(z) && std::isnan(same)) || std::abs(z - same) < 1e-5F ? 0 : 1;
    }
  }
  return out;
}

TEST(Stretch, HasTheNodesOfTheWholeRoadAlsoOverTheStart) {
  const RoadMesh mesh = ring();
  const Centreline centreline = trace_centreline(mesh);
  const crg::ReferenceLine line = fit_reference_line(centreline);
  const RaySurface surface(mesh.mesh);
  const SampledGrid whole = sample_grid(mesh, surface, line, centreline);
  for (const auto& [begin_m, end_m] : {std::pair{20.0, 40.0}, {365.0, 10.0}}) {
    const SampledGrid part =
        sample_rows(mesh, surface, line, rows_between(line, begin_m, end_m), centreline);
    const Compared compared = compare(whole.grid, part.grid);
    EXPECT_EQ(compared.differ, 0u) << begin_m;
    EXPECT_GT(compared.nodes, 10'000u) << begin_m;
  }
}

TEST(Stretch, IsBuiltWithTheHeightsOfTheWholeBuild) {
  const support::TemporaryFolder folder;
  const RoadMesh strip =
      support::make_strip(support::straight, 150.0, 0.5, false, {-4, -3, -2, -1, 0, 1, 2, 3, 4},
                          [](double s, double v) { return 0.02 * s + 0.001 * v * v; });
  export_mesh(strip.mesh, folder.path("strip.obj"));
  Recipe recipe = recipe_for_mesh(folder.path("strip.obj"));
  recipe.read.up = UpAxis::z;
  recipe.read.unit = Unit::m;
  recipe.line_is_right = true;
  const MadeRoad whole = make_road(recipe, inputs_of(recipe), {});
  MakeOptions options;
  options.stretch = {60.0, 80.0};
  const MadeRoad part = make_road(recipe, inputs_of(recipe), options);
  ASSERT_EQ(part.sampled.grid.rows(), 201u);
  EXPECT_EQ(part.line.size(), 201u);
  EXPECT_NEAR(part.line.u_begin_m, 60.0, 1e-9);
  const Compared compared = compare(whole.sampled.grid, part.sampled.grid);
  EXPECT_EQ(compared.differ, 0u);
  EXPECT_GT(compared.nodes, 10'000u);
  recipe.trajectory_path = folder.file("lap.csv", "x_m,y_m,z_m\n0,0,0\n1,0,0\n");
  EXPECT_THROW(make_road(recipe, inputs_of(recipe), options), Error);
}

}  // namespace stretch_test
}  // namespace road
