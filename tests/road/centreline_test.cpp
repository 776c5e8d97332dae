#include "road/centreline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>

#include "mesh/error.h"
#include "support/ring_strips.h"
#include "support/strip_road.h"
#include "support/temporary_folder.h"

namespace centreline_test {

using road::SurfaceClass;
using support::circle;
using support::flat;
using support::make_strip;

road::RoadMesh ring(double radius_m, const std::vector<double>& v_m = {-4, 4},
                    double step_m = 5.0) {
  return make_strip([=](double s) { return circle(s, radius_m); }, 2 * M_PI * radius_m, step_m,
                    true, v_m, flat);
}

/// Two meshes in one.
void append(road::RoadMesh& to, const road::RoadMesh& from) {
  const auto base = static_cast<std::uint32_t>(to.mesh.vertices_m.size());
  for (const auto& p : from.mesh.vertices_m)
    to.mesh.vertices_m.emplace_back(p + from.mesh.origin_m - to.mesh.origin_m);
  for (auto t : from.mesh.triangles) {
    for (auto& i : t) i += base;
    to.mesh.triangles.push_back(t);
    to.mesh.object_of_triangle.push_back(0);
  }
  to.class_of_triangle.insert(to.class_of_triangle.end(), from.class_of_triangle.begin(),
                              from.class_of_triangle.end());
}

double signed_area(const road::Centreline& line) {
  double area = 0.0;
  for (std::size_t i = 0; i < line.points_m.size(); ++i) {
    const auto &a = line.points_m[i], &b = line.points_m[(i + 1) % line.points_m.size()];
    area += 0.5 * (a.x() * b.y() - b.x() * a.y());
  }
  return area;
}

TEST(Centreline, FindsTheMiddleOfARing) {
  const auto line = trace_centreline(ring(100.0));
  EXPECT_TRUE(line.closed);
  // Stations are taken at mesh vertices, where the ring is exact; chords between them do not count.
  EXPECT_NEAR(line.length_m, 2 * M_PI * 100.0, 2e-3);  // measured 1.0e-3: chords of the curve
  for (std::size_t i = 0; i < line.points_m.size(); ++i) {
    EXPECT_NEAR(line.points_m[i].head<2>().norm(), 100.0, 1e-3) << i;
    EXPECT_NEAR(line.half_width_m[i], 4.0, 1e-3) << i;
  }
}

TEST(Centreline, AnOpenRoadBeginsWhereItIsWholeFromEdgeToEdge) {
  auto road = make_strip(support::straight, 200.0, 5.0, false, {-4, 0, 4}, flat);
  road.mesh.vertices_m[1].x() = 0.2;  // its end is cut askew
  road.mesh.vertices_m[2].x() = 0.4;
  const auto line = trace_centreline(road);
  ASSERT_FALSE(line.closed);
  EXPECT_GT(line.points_m.front().x(), 0.39);
  EXPECT_LT(line.points_m.front().x(), 0.45);
  EXPECT_NEAR(line.points_m.back().x(), 200.0, 0.05);
}

TEST(Centreline, KeepsToTheMiddleWhereOneSideIsDrawnByOneLongEdge) {
  // Two straights of 60 m and two half circles; the outer side of the straights has no vertex but
  // at its ends, the inner one has one each metre.
  constexpr double kStraight_m = 60.0, kRadius_m = 20.0, kHalf_m = 4.0;
  road::RoadMesh road;
  auto& mesh = road.mesh;
  mesh.objects.push_back({"road", "", ""});
  const auto add = [&](double x, double y) {
    mesh.vertices_m.emplace_back(x, y, 0.0);
    return static_cast<std::uint32_t>(mesh.vertices_m.size() - 1);
  };
  const auto triangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh.triangles.push_back({a, b, c});
    mesh.object_of_triangle.push_back(0);
  };
  for (const double turn : {1.0, -1.0}) {  // one half, and the same turned by 180 degrees
    const auto place = [&](double x, double y) { return add(turn * x, turn * y); };
    const double in_m = kRadius_m - kHalf_m, out_m = kRadius_m + kHalf_m;
    const auto begin = place(-0.5 * kStraight_m, -out_m), end = place(0.5 * kStraight_m, -out_m);
    std::uint32_t last = place(-0.5 * kStraight_m, -in_m);
    for (int i = 1; i <= 60; ++i) {
      const auto next = place(i - 0.5 * kStraight_m, -in_m);
      triangle(i <= 30 ? begin : end, next, last);
      if (i == 30) triangle(begin, end, next);
      last = next;
    }
    std::uint32_t outer = end;
    for (int i = 1; i <= 60; ++i) {
      const double angle = M_PI * i / 60.0, c = std::sin(angle), s = -std::cos(angle);
      const auto inner_next = place(0.5 * kStraight_m + in_m * c, in_m * s),
                 outer_next = place(0.5 * kStraight_m + out_m * c, out_m * s);
      triangle(outer, outer_next, inner_next);
      triangle(outer, inner_next, last);
      outer = outer_next, last = inner_next;
    }
  }
  road.class_of_triangle.assign(mesh.triangles.size(), SurfaceClass::road);
  const auto line = trace_centreline(road);
  EXPECT_TRUE(line.closed);
  EXPECT_NEAR(line.length_m, 2.0 * kStraight_m + 2.0 * M_PI * kRadius_m, 0.3);
  for (std::size_t i = 0; i < line.points_m.size(); ++i) {
    const double x_m = std::max(0.0, std::abs(line.points_m[i].x()) - 0.5 * kStraight_m);
    EXPECT_NEAR(std::hypot(x_m, line.points_m[i].y()), kRadius_m, 0.1) << i;
    EXPECT_NEAR(line.half_width_m[i], kHalf_m, 0.1) << i;
  }
}

TEST(Centreline, PassesThroughTheMiddleOfSidewaysSteps) {
  // Two halves of a ring that meet 6 cm beside each other: the borders step, the line must not
  // swing out.
  road::RoadMesh road;
  support::add_ring_strip(road.mesh, "road", -5.0, 5.0, 0.0, 0.0, 0.0, 300.0);
  support::add_ring_strip(road.mesh, "road", -4.94, 5.06, 0.0, 0.0, 300.0, support::kRingLength_m);
  road.class_of_triangle.assign(road.mesh.triangles.size(), SurfaceClass::road);
  const auto line = trace_centreline(road);
  EXPECT_TRUE(line.closed);
  for (std::size_t i = 0; i < line.points_m.size(); ++i) {
    EXPECT_NEAR(line.points_m[i].head<2>().norm(), 99.97, 0.04) << i;
    EXPECT_NEAR(line.half_width_m[i], 5.0, 0.04) << i;
  }
}

TEST(Centreline, IsTheMiddleOfTheRoadNotOfKerbAndRunOff) {
  const auto road = make_strip([](double s) { return circle(s, 80.0); }, 2 * M_PI * 80.0, 4.0, true,
                               {-15, -5, -4, 4, 5.5, 7}, flat,
                               [](double v) {
                                 if (std::abs(v) < 4) return SurfaceClass::road;
                                 return std::abs(v) < 6 ? SurfaceClass::kerb : SurfaceClass::runoff;
                               });
  for (const auto& p : trace_centreline(road).points_m) EXPECT_NEAR(p.head<2>().norm(), 80.0, 1e-3);
}

TEST(Centreline, GoesCounterClockwiseAndBackOnRequest) {
  road::CentrelineOptions options;
  EXPECT_GT(signed_area(trace_centreline(ring(60.0), options)), 0.0);
  options.reverse = true;
  EXPECT_LT(signed_area(trace_centreline(ring(60.0), options)), 0.0);
}

TEST(Centreline, StartsWhereAsked) {
  road::CentrelineOptions options;
  options.start_near_m = Eigen::Vector2d(0.0, -120.0);
  const auto line = trace_centreline(ring(100.0), options);
  EXPECT_NEAR(line.points_m[0].x(), 0.0, 0.05);
  EXPECT_NEAR(line.points_m[0].y(), -100.0, 0.01);
  EXPECT_NEAR(line.length_m, 2 * M_PI * 100.0, 2e-3);
}

TEST(Centreline, FollowsAnOpenRoadToItsEndsAndSaysThatItIsOpen) {
  const auto line =
      trace_centreline(make_strip(support::straight, 300.0, 10.0, false, {-3, 3}, flat));
  EXPECT_FALSE(line.closed);
  EXPECT_NEAR(line.length_m, 300.0, 0.05);
  for (const auto& p : line.points_m) EXPECT_NEAR(p.y(), 0.0, 2e-3);
}

TEST(Centreline, FollowsTheLowerAndTheUpperLegOfAFigureEight) {
  // A lemniscate-like eight that crosses itself 8.8 m apart.
  const double size_m = 150.0;
  const auto plan = [&](double s) -> support::PlanPoint {
    const double t = s / size_m;
    return {size_m * std::sin(t), size_m * std::sin(t) * std::cos(t),
            std::atan2(std::cos(2 * t), std::cos(t))};
  };
  const auto road = make_strip(plan, 2 * M_PI * size_m, 2.0, true, {-5, 0, 5},
                               [&](double s, double) { return 4.4 * std::cos(s / size_m); });
  const auto line = trace_centreline(road);
  ASSERT_TRUE(line.closed);
  double expected_m = 0.0;
  for (int i = 0; i < 100000; ++i) {
    const auto a = plan(2 * M_PI * size_m * i / 100000.0),
               b = plan(2 * M_PI * size_m * (i + 1) / 100000.0);
    expected_m += std::hypot(b.x_m - a.x_m, b.y_m - a.y_m);
  }
  EXPECT_NEAR(line.length_m / expected_m, 1.0, 2e-4);
  for (std::size_t i = 0; i + 1 < line.points_m.size(); ++i) {
    EXPECT_LT(std::abs(line.points_m[i + 1].z() - line.points_m[i].z()), 0.5)
        << "changed the deck at station " << i;
  }
}

TEST(Centreline, SurvivesHolesAndCracks) {
  auto road = ring(100.0, {-4, -1, 1, 4}, 5.0);
  // Every 40th triangle goes, and so does a whole cross-section.
  road::RoadMesh damaged = road;
  damaged.mesh.triangles.clear();
  damaged.mesh.object_of_triangle.clear();
  damaged.class_of_triangle.clear();
  for (std::size_t t = 0; t < road.mesh.triangles.size(); ++t) {
    if (t % 40 == 7 || (t >= 120 && t < 126)) continue;
    damaged.mesh.triangles.push_back(road.mesh.triangles[t]);
    damaged.mesh.object_of_triangle.push_back(0);
    damaged.class_of_triangle.push_back(road.class_of_triangle[t]);
  }
  const auto line = trace_centreline(damaged);
  EXPECT_TRUE(line.closed);
  EXPECT_NEAR(line.length_m, 2 * M_PI * 100.0, 0.05);
  for (const auto& p : line.points_m) EXPECT_NEAR(p.head<2>().norm(), 100.0, 0.15);
}

TEST(Centreline, PassesAPitLaneThatBranchesOff) {
  auto road = make_strip([](double s) { return circle(s, 120.0); }, 2 * M_PI * 120.0, 3.0, true,
                         {-6, 6}, flat);
  // A lane 6 m wide leaves at a tangent.
  append(road, make_strip(
                   [](double s) {
                     return support::PlanPoint{121.0, s, M_PI / 2};
                   },
                   90.0, 3.0, false, {-3, 3}, flat));
  const auto line = trace_centreline(road);
  ASSERT_TRUE(line.closed);
  EXPECT_NEAR(line.length_m, 2 * M_PI * 120.0, 5.0);
}

/// A triangle with corners of this radius between straights of 100 m.
support::PlanPoint triangle(double s_m, double radius_m) {
  const double arc_m = 2.0 * M_PI / 3.0 * radius_m, side_m = 100.0 + arc_m;
  double x_m = 0.0, y_m = 0.0, heading = 0.0;
  const auto go = [&](double length_m) {
    x_m += length_m * std::cos(heading), y_m += length_m * std::sin(heading);
  };
  const auto turn = [&](double length_m) {
    const double angle = length_m / radius_m;
    x_m += radius_m * (std::sin(heading + angle) - std::sin(heading));
    y_m += radius_m * (std::cos(heading) - std::cos(heading + angle));
    heading += angle;
  };
  for (; s_m >= side_m; s_m -= side_m) go(100.0), turn(arc_m);
  go(std::min(s_m, 100.0));
  if (s_m > 100.0) turn(s_m - 100.0);
  return {x_m, y_m, heading};
}

TEST(Centreline, RoundsHairpinsWithoutAnInnerRadius) {
  // The inner border of every corner is one vertex.
  const double radius_m = 4.0, length_m = 300.0 + 2.0 * M_PI * radius_m;
  const auto road = make_strip([&](double s) { return triangle(s, radius_m); }, length_m,
                               length_m / 600.0, true, {-4, 4}, flat);
  const auto line = trace_centreline(road);
  ASSERT_TRUE(line.closed);
  EXPECT_NEAR(line.length_m, length_m, 0.01 * length_m);
}

TEST(Centreline, TracesAModelAsItTracesTheRealThing) {
  auto model = ring(100.0);
  for (auto& p : model.mesh.vertices_m) p /= 20.0;
  model.mesh.origin_m = {3.0, -2.0, 1.0};
  const auto line = trace_centreline(model), whole = trace_centreline(ring(100.0));
  ASSERT_TRUE(line.closed);
  EXPECT_NEAR(line.length_m, whole.length_m / 20.0, 1e-4);
  for (std::size_t i = 0; i < line.points_m.size(); ++i) {
    EXPECT_NEAR((line.points_m[i] - model.mesh.origin_m).head<2>().norm(), 5.0, 1e-4);
    EXPECT_NEAR(line.half_width_m[i], 0.2, 1e-4);
  }
}

TEST(Centreline, DrivesOnTheTopOfADeckNotOnItsUnderside) {
  auto road = ring(100.0);
  auto underside = ring(100.0);
  for (auto& p : underside.mesh.vertices_m) p.z() -= 1.0;
  append(road, underside);
  const auto line = trace_centreline(road);
  ASSERT_TRUE(line.closed);
  for (const auto& p : line.points_m) EXPECT_NEAR(p.z(), 0.0, 1e-3);
}

TEST(Centreline, TakesTheLongerWayRoundAShortCut) {
  // The short-cut is a chord of the ring, as wide as the ring.
  auto road = ring(100.0, {-4, 4}, 2.0);
  append(road, make_strip(
                   [](double s) {
                     return support::PlanPoint{-86.0 + s, 50.0, 0.0};
                   },
                   172.0, 4.0, false, {-4, 4}, flat));
  const auto line = trace_centreline(road);
  ASSERT_TRUE(line.closed);
  EXPECT_NEAR(line.length_m, 2 * M_PI * 100.0, 5.0);
}

TEST(Centreline, RefusesTwoCircuitsUnlessToldWhich) {
  auto road = ring(100.0);
  append(road, make_strip(
                   [](double s) {
                     auto p = circle(s, 90.0);
                     p.x_m += 500.0;
                     return p;
                   },
                   2 * M_PI * 90.0, 5.0, true, {-4, 4}, flat));
  try {
    trace_centreline(road);
    FAIL() << "no error";
  } catch (const road::Error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("two separate roads"),
                                             testing::HasSubstr("start_near_m")));
  }
  road::CentrelineOptions options;
  options.start_near_m = Eigen::Vector2d(590.0, 0.0);
  EXPECT_NEAR(trace_centreline(road, options).length_m, 2 * M_PI * 90.0, 0.01);
}

TEST(Centreline, RefusesASurfaceThatIsNoStrip) {
  const auto square = make_strip(support::straight, 400.0, 50.0, false, {-200, 200}, flat);
  EXPECT_THROW(trace_centreline(square), road::Error);
  EXPECT_THROW(trace_centreline(road::RoadMesh{}), road::Error);
}

TEST(Centreline, EndsOnAnyHeapOfSlabs) {
  // Layers that meet at every angle: cells of the road's graph see each other one way only.
  for (unsigned seed = 66; seed <= 72; ++seed) {  // 69 went on for ever
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    road::RoadMesh heap;
    heap.mesh.objects.resize(1);
    for (int k = 0; k < 60; ++k) {
      const Eigen::Vector3d at(uniform(0, 80), uniform(0, 80), uniform(0, 3));
      const double turn = uniform(0, 2 * M_PI), slope = uniform(-0.3, 0.3);
      const Eigen::Vector3d along(std::cos(turn), std::sin(turn), slope),
          across(-std::sin(turn), std::cos(turn), uniform(-0.1, 0.1));
      const auto first = static_cast<std::uint32_t>(heap.mesh.vertices_m.size());
      const double length_m = uniform(5, 40), width_m = uniform(2, 10);
      for (const auto& [a, b] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}})
        heap.mesh.vertices_m.emplace_back(at + a * length_m * along + b * width_m * across);
      heap.mesh.triangles.push_back({first, first + 1, first + 2});
      heap.mesh.triangles.push_back({first, first + 2, first + 3});
    }
    heap.mesh.object_of_triangle.assign(heap.mesh.triangles.size(), 0);
    heap.class_of_triangle.assign(heap.mesh.triangles.size(), SurfaceClass::road);
    try {
      trace_centreline(heap);
    } catch (const road::Error&) {  // a line or a refusal, but an end
    }
  }
}

TEST(Centreline, CsvKeepsStationsAndClosure) {
  const auto line = trace_centreline(ring(100.0));
  const support::TemporaryFolder folder;
  const std::string path = folder.path("centreline.csv");
  write_centreline_csv(line, path);
  const auto again = road::read_centreline_csv(path);
  EXPECT_TRUE(again.closed);
  ASSERT_EQ(again.points_m.size(), line.points_m.size());
  for (std::size_t i = 0; i < line.points_m.size(); ++i)
    EXPECT_LT((again.points_m[i] - line.points_m[i]).norm(), 1e-4);
  EXPECT_NEAR(again.length_m, line.length_m, 1e-2);
}

}  // namespace centreline_test
