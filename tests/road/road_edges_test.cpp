#include "road/road_edges.h"

#include <gtest/gtest.h>

#include <limits>

namespace road_edges_test {

constexpr std::size_t kRows = 120, kBegin = 50, kEnd = 70;  // of the piece that ends elsewhere
constexpr double kStep_m = 0.5;

/// Amid a piece of 10 m, the left edge of a straight road from -4.5 to `usual_left_m` whose left
/// side ends at `piece_left_m` there; what is driven from `lane_m` on lies beside it all along.
double left_edge_m(double piece_left_m, double lane_m = 9.0, double usual_left_m = 4.5) {
  crg::ReferenceLine line;
  line.u_step_m = kStep_m;
  road::Centreline centreline;
  road::SampledGrid sampled;
  sampled.grid.u_step_m = kStep_m;
  for (double v_m = -6.0; v_m < 6.1; v_m += kStep_m) sampled.grid.v_m.push_back(v_m);
  for (std::size_t i = 0; i < kRows; ++i) {
    line.x_m.push_back(kStep_m * static_cast<double>(i));
    line.y_m.push_back(0.0);
    line.heading_rad.push_back(0.0);
    centreline.points_m.emplace_back(line.x_m.back(), 0.0, 0.0);
    centreline.half_width_m.push_back(4.6);
    const double left_m = i >= kBegin && i < kEnd ? piece_left_m : usual_left_m;
    for (const double v_m : sampled.grid.v_m) {
      const bool on_road = (v_m > -4.6 && v_m < left_m + 0.1) || v_m > lane_m - 0.1;
      sampled.grid.z_m.push_back(on_road ? 0.0f : std::numeric_limits<float>::quiet_NaN());
      sampled.provenance.push_back(on_road ? road::Provenance::mesh : road::Provenance::none);
      sampled.surface_class.push_back(road::SurfaceClass::road);
    }
  }
  centreline.length_m = line.x_m.back();
  return road::road_edges(sampled, line, centreline, {}).left_m[(kBegin + kEnd) / 2];
}

TEST(RoadEdges, APieceThatIsLostBelongsToTheRoad) { EXPECT_EQ(left_edge_m(3.0), 4.5); }

// Any edge that is not parallel to the line goes from one column to the next somewhere.
TEST(RoadEdges, OneColumnLessIsTheEdgeItself) { EXPECT_EQ(left_edge_m(4.0), 4.0); }

TEST(RoadEdges, ALaneBehindAWedgeIsBeyondTheEdge) {
  EXPECT_EQ(left_edge_m(4.5, 5.5), 4.5);
  EXPECT_EQ(left_edge_m(4.0, 5.0, 4.0), 4.0)
      << "within the half width, which is measured with the lane";
}

}  // namespace road_edges_test
