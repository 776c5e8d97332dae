// Roads between edges whose shape is known in closed form, and the surveyed circuits beside the
// checkout.
#include "road/edges.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <numbers>

#include "crg/surface.h"
#include "make/make_track.h"
#include "mesh/error.h"
#include "road/track_crg.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace road {
namespace edges_test {

using Eigen::Vector3d;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

/// Points of `at` for t in [0, 1), `count` of them.
Edge edge_of(const std::string& name, int count, const std::function<Vector3d(double)>& at,
             bool with_z = false) {
  Edge edge;
  edge.path = name;
  edge.has_z = with_z;
  for (int i = 0; i < count; ++i) {
    edge.points_m.push_back(at(static_cast<double>(i) / count));
    edge.line.push_back(static_cast<std::size_t>(i) + 2);
  }
  return edge;
}

Edge circle(const std::string& name, double radius_m, int count, double start_rad = 0.0,
            double direction = 1.0) {
  return edge_of(name, count, [=](double t) {
    const double a = start_rad + direction * 2.0 * kPi * t;
    return Vector3d(radius_m * std::cos(a), radius_m * std::sin(a), 0.0);
  });
}

Edge straight(const std::string& name, double y_m, double from_m = 0.0, double to_m = 300.0,
              int count = 61) {
  return edge_of(name, count, [=](double t) {
    return Vector3d(from_m + (to_m - from_m) * t * count / (count - 1), y_m, 0.0);
  });
}

crg::Surface surface_of(const EdgeRoad& road) {
  return crg::Surface(track_crg(road.line, road.sampled.grid));
}

std::string refusal(const Edge& left, const Edge& right, const EdgeOptions& options = {}) {
  try {
    road_between_edges(left, right, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Edges, CirclesGiveTheCircleBetweenThem) {
  // Counter-clockwise: the left edge is the inner one. Points 2 m and 3.1 m apart do not
  // correspond.
  EdgesReport report;
  const EdgeRoad road =
      road_between_edges(circle("l", 44.0, 138, 0.3), circle("r", 56.0, 113, 2.0), {}, &report);
  EXPECT_TRUE(report.closed);
  // Chords of 0.1 m on a radius of 50 m are 5e-5 m shorter than the arc per lap; the fit leaves
  // less than 1 mm.
  EXPECT_NEAR(road.line.u_step_m * static_cast<double>(road.line.size() - 1), 2.0 * kPi * 50.0,
              2e-3);
  for (std::size_t i = 0; i < road.line.size(); ++i)
    ASSERT_NEAR(std::hypot(road.line.x_m[i], road.line.y_m[i]), 50.0, 1e-3);
  EXPECT_NEAR(road.line.heading_rad[0], 0.3 + kPi / 2.0, 1e-3);
  EXPECT_NEAR(std::atan2(road.line.y_m[0], road.line.x_m[0]), 0.3,
              0.008 / 50.0);  // 5 mm of margin at the seam; measured: 6.1 mm
  // The edge lies within a millimetre of where it was measured, on both sides, all round.
  const crg::Surface surface = surface_of(road);
  crg::Cursor cursor;
  for (int k = 0; k < 1000; ++k) {
    const double a = 2.0 * kPi * k / 1000.0;
    for (const double inside : {44.002, 55.998})
      ASSERT_TRUE(surface.at_xy(inside * std::cos(a), inside * std::sin(a), cursor).valid)
          << inside << " at " << a;
    for (const double outside : {43.997, 56.003})
      ASSERT_FALSE(surface.at_xy(outside * std::cos(a), outside * std::sin(a), cursor).valid)
          << outside << " at " << a;
  }
  EXPECT_LE(report.point_error_max_m, 1e-4);
  EXPECT_NEAR(report.width_min_m, 12.0, 1e-3);
  EXPECT_NEAR(report.width_max_m, 12.0, 1e-3);
}

/// A banked oval: the middle is an ellipse, the half width varies, both edges on its exact normals.
struct Oval {
  static constexpr double a_m = 150.0, b_m = 90.0;
  static Vector3d at(double t, double side) {
    const double w = 2.0 * kPi * t, x = a_m * std::cos(w), y = b_m * std::sin(w);
    const double dx = -a_m * std::sin(w), dy = b_m * std::cos(w), length = std::hypot(dx, dy);
    const double half = side * (6.0 + std::sin(2.0 * w));
    return {x - half * dy / length, y + half * dx / length, 2.0 * std::sin(w) - 0.05 * half};
  }
  static double length_m() {
    double length = 0.0;
    constexpr int kPieces = 200'000;
    for (int i = 0; i < kPieces; ++i)
      length += (at((i + 1.0) / kPieces, 0.0) - at(static_cast<double>(i) / kPieces, 0.0))
                    .head<2>()
                    .norm();
    return length;
  }
};

TEST(Edges, BankedOvalOfVaryingWidth) {
  const Edge left = edge_of(
      "l", 401, [](double t) { return Oval::at(t, 1.0); }, true);
  const Edge right = edge_of(
      "r", 377, [](double t) { return Oval::at(std::fmod(t + 0.37, 1.0), -1.0); }, true);
  EdgesReport report;
  const EdgeRoad road = road_between_edges(left, right, {}, &report);
  EXPECT_TRUE(report.closed);
  EXPECT_TRUE(report.has_z);
  // Where the width changes, "half way on a normal" is not quite the ellipse: 0.05 % of the length.
  EXPECT_NEAR(road.line.u_step_m * static_cast<double>(road.line.size() - 1), Oval::length_m(),
              5e-4 * Oval::length_m());
  const crg::Surface surface = surface_of(road);
  crg::Cursor cursor;
  double worst_z = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const double t = (k + 0.5) / 2000.0;
    const Vector3d l = Oval::at(t, 1.0), r = Oval::at(t, -1.0);
    const Vector3d across = (l - r) / (l - r).head<2>().norm();
    for (const double share : {0.1, 0.5, 0.9}) {
      const Vector3d p = r + share * (l - r);
      const crg::Sample sample = surface.at_xy(p.x(), p.y(), cursor);
      ASSERT_TRUE(sample.valid);
      worst_z = std::max(worst_z, std::abs(sample.z_m - p.z()));
    }
    // The outermost nodes lie inside the edge, at most a quarter step across.
    for (const double side : {1.0, -1.0}) {
      const Vector3d edge = side > 0.0 ? l : r;
      const Vector3d in = edge - side * 0.027 * across, out = edge + side * 0.003 * across;
      ASSERT_TRUE(surface.at_xy(in.x(), in.y(), cursor).valid) << "t = " << t << ", side " << side;
      ASSERT_FALSE(surface.at_xy(out.x(), out.y(), cursor).valid)
          << "t = " << t << ", side " << side;
    }
  }
  // The normals of the line are not those of the ellipse where the width changes: heights differ by
  // the slope along (0.02) times the shift between the two (centimetres). Measured: 1.4 mm.
  EXPECT_LT(worst_z, 3e-3);
  EXPECT_LE(report.edge_gap_max_m, 0.0251);
  std::printf("oval: z within %.2f mm, edge gap %.1f mm, given points within %.3f mm\n",
              1e3 * worst_z, 1e3 * report.edge_gap_max_m, 1e3 * report.point_error_max_m);
}

TEST(Edges, OpenRoadStartsAndEndsWithItsEdges) {
  EdgesReport report;
  const EdgeRoad road =
      road_between_edges(straight("l", 4.0), straight("r", -3.0, -2.0, 280.0, 17), {}, &report);
  EXPECT_FALSE(report.closed);
  EXPECT_NEAR(road.line.x_m[0], 0.0, 1e-3);
  EXPECT_NEAR(road.line.y_m[0], 0.5, 1e-3);
  EXPECT_NEAR(road.line.x_m.back(), 280.0, 0.11);
  EXPECT_NEAR(road.line.heading_rad[0], 0.0, 1e-6);
  EXPECT_THAT(report.remarks, ::testing::Contains(HasSubstr("l: the last 20.")));
  EXPECT_NEAR(report.width_min_m, 7.0, 1e-6);
  EXPECT_LT(report.edge_gap_max_m, 2.1e-3);
}

TEST(Edges, RightInTheOtherDirectionGivesTheSameRoad) {
  EdgesReport report;
  const Edge left = circle("l", 44.0, 138), right = circle("r", 56.0, 160, 1.0),
             against = circle("r", 56.0, 160, 1.0, -1.0);
  const EdgeRoad forward = road_between_edges(left, right),
                 backward = road_between_edges(left, against, {}, &report);
  EXPECT_TRUE(report.right_reversed);
  ASSERT_EQ(forward.line.size(), backward.line.size());
  for (std::size_t i = 0; i < forward.line.size(); ++i)
    ASSERT_NEAR(forward.line.x_m[i], backward.line.x_m[i], 1e-6);
}

TEST(Edges, FigureEightKeepsToItsOwnEdges) {
  const auto edge = [](double side) {
    return edge_of(side > 0 ? "l" : "r", 500 + static_cast<int>(side), [=](double t) {
      const double w = 2.0 * kPi * t, dx = 200.0 * std::cos(w), dy = 200.0 * std::cos(2.0 * w),
                   length = std::hypot(dx, dy);
      return Vector3d(200.0 * std::sin(w) - side * 5.0 * dy / length,
                      100.0 * std::sin(2.0 * w) + side * 5.0 * dx / length, 0.0);
    });
  };
  EdgesReport report;
  road_between_edges(edge(1.0), edge(-1.0), {}, &report);
  EXPECT_TRUE(report.closed);
  EXPECT_NEAR(report.width_min_m, 10.0, 5e-3);
  EXPECT_NEAR(report.width_max_m, 10.0, 5e-3);
}

TEST(Edges, RepeatedPointsAndASecondLapAreLeftOut) {
  Edge left = circle("l", 44.0, 138), right = circle("r", 56.0, 160);
  right.points_m.insert(right.points_m.begin() + 40, right.points_m[40]);
  left.points_m.push_back(left.points_m.front());  // the first row again
  for (int i = 0; i < 30; ++i)
    right.points_m.push_back(circle("r", 56.0, 160).points_m[static_cast<std::size_t>(i)]);
  EdgesReport report;
  const EdgeRoad road = road_between_edges(left, right, {}, &report);
  EXPECT_TRUE(report.closed);
  EXPECT_EQ(report.dropped_points, 32u);
  EXPECT_NEAR(road.line.u_step_m * static_cast<double>(road.line.size() - 1), 2.0 * kPi * 50.0,
              2e-3);
}

// Positions of a receiver that lost its satellites.
TEST(Edges, PointsThatStickOutAreLeftOutAndSaid) {
  Edge left = circle("l", 44.0, 138);
  const Edge right = circle("r", 56.0, 160);
  left.points_m[50] += Vector3d(60.0, 60.0, 0.0);
  for (int i = 90; i < 93; ++i)
    left.points_m[static_cast<std::size_t>(i)] *= 1.1 + 0.05 * static_cast<double>(i - 90);
  EdgesReport report;
  const EdgeRoad road = road_between_edges(left, right, {}, &report);
  EXPECT_EQ(report.dropped_points, 4u);
  ASSERT_EQ(report.remarks.size(), 2u);
  EXPECT_THAT(report.remarks[0], HasSubstr("l:52: a point left out"));
  EXPECT_THAT(report.remarks[1], HasSubstr("l:92: 3 points left out"));
  // Half the sagitta of the 8 m that are missing.
  for (std::size_t i = 0; i < road.line.size(); ++i)
    ASSERT_NEAR(std::hypot(road.line.x_m[i], road.line.y_m[i]), 50.0, 0.09);
}

TEST(Edges, AStretchMuchWiderThanUsualIsSaid) {
  Edge left = straight("l", 4.0);
  for (Vector3d& p : left.points_m)
    if (p.x() > 90.0 && p.x() < 130.0) p.y() += 15.0 * std::sin(kPi * (p.x() - 90.0) / 40.0);
  EdgesReport report;
  road_between_edges(left, straight("r", -4.0), {}, &report);
  ASSERT_EQ(report.remarks.size(), 1u);
  EXPECT_THAT(report.remarks[0], HasSubstr("times as usual: do points stick out there?"));
}

TEST(Edges, UtmCoordinatesCostNothing) {
  Edge left = circle("l", 44.0, 138, 0.3), right = circle("r", 56.0, 113, 2.0);
  for (Edge* edge : {&left, &right})
    for (Vector3d& p : edge->points_m) p += Vector3d(500'000.0, 5'400'000.0, 0.0);
  const EdgeRoad road = road_between_edges(left, right);
  for (std::size_t i = 0; i < road.line.size(); ++i)
    ASSERT_NEAR(std::hypot(road.line.x_m[i] - 500'000.0, road.line.y_m[i] - 5'400'000.0), 50.0,
                1e-3);
}

TEST(Edges, RefusesWhatCannotBeARoad) {
  const Edge left = circle("left.csv", 44.0, 138), right = circle("right.csv", 56.0, 160);
  EXPECT_THAT(refusal(right, left),
              AllOf(HasSubstr("left.csv lies on the left of right.csv"), HasSubstr("exchange")));
  Edge half = right;
  half.points_m.resize(80);
  EXPECT_THAT(refusal(left, half),
              AllOf(HasSubstr("left.csv is closed"), HasSubstr("right.csv is open")));
  Edge crossing = straight("right.csv", -3.0);
  for (Vector3d& p : crossing.points_m)
    if (p.x() > 100.0 && p.x() < 120.0) p.y() = 5.0;
  EXPECT_THAT(refusal(straight("left.csv", 4.0), crossing),
              AllOf(HasSubstr("edges cross"), HasSubstr("from u = 105.")));
  EXPECT_THAT(refusal(straight("left.csv", 0.1), straight("right.csv", 0.0)),
              AllOf(HasSubstr("0.100 m wide"), HasSubstr("two steps")));
  Edge stray = left;
  std::reverse(stray.points_m.begin() + 45, stray.points_m.begin() + 60);
  EXPECT_THAT(refusal(stray, right),
              AllOf(HasSubstr("left.csv:4"), HasSubstr("turns back on itself")));
  EXPECT_THAT(refusal(left, circle("right.csv", 400.0, 1000)), HasSubstr("m apart"));
  Edge high = right;
  high.has_z = true;
  EXPECT_THAT(refusal(left, high), HasSubstr("right.csv has a column z_m"));
  EXPECT_THAT(refusal(left, right, {0.1, 0.1, 100'000}), HasSubstr("more than the limit"));
}

TEST(Edges, FilesAreRefusedWithTheirLine) {
  const support::TemporaryFolder folder;
  const auto refused = [&](const std::string& text) -> std::string {
    try {
      read_edge(folder.file("edge.csv", text));
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refused("x_m,y_m\n0,0\n1,0\nnan,0\n3,0\n"),
              HasSubstr("edge.csv:4: column 'x_m' holds no number"));
  EXPECT_THAT(refused("x_m,y_m\n0,0\n1,1e12\n2,0\n3,0\n"),
              HasSubstr("edge.csv:3: y_m is 1000000000000"));
  EXPECT_THAT(refused("x_m,y_m\n0,0\n1,\n2,0\n3,0\n"),
              HasSubstr("edge.csv:3: column 'y_m' is empty"));
  EXPECT_THAT(refused("x_m,y_m\n0,0\n1,b\n2,0\n"), HasSubstr("edge.csv:3"));
  EXPECT_THAT(refused("x_m,y_m\n0,0\n1,0\n"), HasSubstr("edge.csv: 2 points; wanted at least 4"));
  EXPECT_THAT(refused("x,y\n0,0\n"), HasSubstr("no column 'x_m'"));
  EXPECT_THAT(refused("x_m,y_m,z_m\n0,0,1\n1,0,inf\n2,0,1\n3,0,1\n"),
              HasSubstr("edge.csv:3: column 'z_m' holds 'inf'"));
}

TEST(Edges, NamesAreWhatBothFilesShare) {
  EXPECT_EQ(name_of_edges("a/circuit_a_left.csv", "b/circuit_a_right.csv"), "circuit_a");
  EXPECT_EQ(name_of_edges("track_inner.csv", "track_inlet.csv"), "track");
  EXPECT_EQ(name_of_edges("left.csv", "right.csv"), "road");
  EXPECT_EQ(name_of_edges("l/spa.csv", "r/spa.csv"), "spa");
}

/// A polyline whose corners are rounded, in points 0.5 m apart.
Edge rounded(const std::vector<Eigen::Vector2d>& corners, const std::vector<double>& radius_m) {
  Edge edge;
  edge.path = "rounded";
  const auto add = [&](const Eigen::Vector2d& p) { edge.points_m.emplace_back(p.x(), p.y(), 0.0); };
  Eigen::Vector2d from = corners.front();
  const auto straight = [&](const Eigen::Vector2d& to) {
    const int steps = std::max(1, static_cast<int>((to - from).norm() / 0.5));
    for (int k = 0; k < steps; ++k) add(from + (to - from) * k / steps);
    from = to;
  };
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    const Eigen::Vector2d in = (corners[i] - corners[i - 1]).normalized(),
                          out = (corners[i + 1] - corners[i]).normalized();
    const double turn = std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
    const double r = radius_m[i - 1], cut_m = r * std::tan(0.5 * std::abs(turn));
    straight(corners[i] - cut_m * in);
    const Eigen::Vector2d left(-in.y(), in.x());
    const Eigen::Vector2d centre = from + std::copysign(r, turn) * left;
    const int steps = std::max(4, static_cast<int>(r * std::abs(turn) / 0.5));
    for (int k = 0; k < steps; ++k)
      add(centre + Eigen::Rotation2Dd(turn * k / steps) * (from - centre));
    from = corners[i] + cut_m * out;
  }
  straight(corners.back());
  add(corners.back());
  return edge;
}

TEST(Edges, AChicaneWhoseCornersAreTighterThanHalfTheRoad) {
  // A road of 9.5 m that turns left by 90 degrees and 32 m on right again; its corners are rounded
  // with 2.5 to 4 m, so that it is 15 m wide in them.
  const Edge left = rounded({{0, 9.5}, {60.5, 9.5}, {60.5, 41.5}, {130, 41.5}}, {2.5, 4.0});
  const Edge right = rounded({{0, 0}, {70, 0}, {70, 32}, {130, 32}}, {4.0, 2.5});
  const EdgeRoad road = road_between_edges(left, right);
  const double length_m = road.line.u_step_m * static_cast<double>(road.line.size() - 1);
  // Between the way along the corners and the shortest that keeps off the edges.
  EXPECT_GT(length_m, 65.25 + 32.0 + 64.75 - 2.0 * 9.5);
  EXPECT_LT(length_m, 65.25 + 32.0 + 64.75);
  for (std::size_t i = 0; i < road.line.size(); ++i) {
    const Eigen::Vector2d p(road.line.x_m[i], road.line.y_m[i]);
    for (const Edge* edge : {&left, &right}) {
      double nearest_m = 1e9;
      for (const Eigen::Vector3d& q : edge->points_m)
        nearest_m = std::min(nearest_m, (q.head<2>() - p).norm());
      EXPECT_GT(nearest_m, 3.5) << p.transpose();
      EXPECT_LT(nearest_m, 8.5) << p.transpose();
    }
  }
}

TEST(Edges, SurveyedCircuits) {
  struct Case {
    const char *left, *right;
    double length_m;  // middle of the two given lengths, which differ by 2 pi times the mean width
  };
  for (const Case& c :
       {Case{"edges/circuit_a_left.csv", "edges/circuit_a_right.csv", 0.5 * (3942.0 + 3858.2)},
        Case{"edges/circuit_b_left.csv", "edges/circuit_b_right.csv", 0.5 * (4261.2 + 4349.6)},
        Case{"recordings/putnam_inner_bound.csv", "recordings/putnam_outer_bound.csv",
             0.5 * (2881.5 + 2824.1)}}) {
    const std::string data = places::data() + "/";
    if (!std::filesystem::exists(data + c.left)) GTEST_SKIP() << "no " << data << c.left;
    const Edge left = read_edge(data + c.left), right = read_edge(data + c.right);
    EdgesReport report;
    const EdgeRoad road = road_between_edges(left, right, {}, &report);
    EXPECT_TRUE(report.closed);
    EXPECT_NEAR(road.line.u_step_m * static_cast<double>(road.line.size() - 1), c.length_m,
                2e-3 * c.length_m);
    EXPECT_LE(report.point_error_max_m, 1e-3) << c.left;  // measured: 0.4 mm
    EXPECT_LE(report.edge_gap_max_m, 0.0251) << c.left;
    EXPECT_TRUE(report.folds.empty());
    const crg::Surface surface = surface_of(road);
    crg::Cursor cursor;
    const crg::UV first = surface.uv_of_xy(left.points_m[0].x(), left.points_m[0].y(), cursor);
    EXPECT_NEAR(first.u_m, 0.0, 0.02) << c.left;
    EXPECT_GT(first.v_m, 3.0);
    EXPECT_NEAR(surface.uv_of_xy(left.points_m[5].x(), left.points_m[5].y(), cursor).u_m, 8.0, 6.0);
    std::printf("%s: %.1f m, given points within %.2f mm, edge gap median %.1f mm, max %.1f mm\n",
                c.left, road.line.u_step_m * static_cast<double>(road.line.size() - 1),
                1e3 * report.point_error_max_m, 1e3 * report.edge_gap_median_m,
                1e3 * report.edge_gap_max_m);
  }
}

/// Of a closed edge, straight between its points.
double distance_m(const Eigen::Vector2d& at, const Edge& edge) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < edge.points_m.size(); ++k) {
    const Eigen::Vector2d a = edge.points_m[k].head<2>();
    const Eigen::Vector2d ab = edge.points_m[(k + 1) % edge.points_m.size()].head<2>() - a;
    const double share = std::clamp((at - a).dot(ab) / std::max(ab.squaredNorm(), 1e-12), 0.0, 1.0);
    nearest_m = std::min(nearest_m, (a + share * ab - at).norm());
  }
  return nearest_m;
}

TEST(Edges, CircuitsOfOthers) {
  struct Case {
    std::string name;
    double length_m, share;  // as published with the file; how near the road comes to it
  };
  for (const Case& c : {Case{"fl_zolder", 3995.7, 5e-3}, Case{"fl_pau_ville", 2761.9, 5e-3},
                        Case{"fl_senato_3d", 377.1, 1e-3}, Case{"fl_mugello_3d", 5252.6, 1e-3},
                        Case{"iac_monza", 5792.4, 1e-3}, Case{"mount_panorama", 6232.7, 1e-3}}) {
    const std::string path = places::data() + "/edges2/" + c.name;
    if (!std::filesystem::exists(path + "_left.csv")) GTEST_SKIP() << "no " << path;
    EdgeOptions coarse;
    coarse.u_step_m = 0.5;
    const Edge left = read_edge(path + "_left.csv"), right = read_edge(path + "_right.csv");
    const EdgeRoad road = road_between_edges(left, right, coarse);
    EXPECT_TRUE(road.line.closed) << c.name;
    for (std::size_t i = 0; i < road.line.size(); i += 4) {
      const Eigen::Vector2d at(road.line.x_m[i], road.line.y_m[i]);
      EXPECT_NEAR(distance_m(at, left), distance_m(at, right), 1.0)
          << c.name << ": off the middle by half of it at u = " << 0.5 * static_cast<double>(i);
    }
    EXPECT_NEAR(road.line.u_step_m * static_cast<double>(road.line.size() - 1), c.length_m,
                c.share * c.length_m)
        << c.name;
  }
}

}  // namespace edges_test
}  // namespace road
