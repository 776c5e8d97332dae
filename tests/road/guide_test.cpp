#include "road/guide.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <random>

#include "make/make_track.h"
#include "make/place.h"
#include "make/plausible.h"
#include "make/question.h"
#include "mesh/error.h"
#include "mesh/ray_surface.h"
#include "mesh/read_mesh.h"
#include "road/centreline.h"
#include "road/clean.h"
#include "road/reference_line.h"
#include "support/places.h"
#include "support/ring_strips.h"
#include "support/temporary_folder.h"

namespace guide_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kTurn = 2.0 * std::numbers::pi;

std::string refusal(const std::function<void()>& run) {
  try {
    run();
  } catch (const road::Error& error) {
    return error.what();
  }
  return "";
}

/// Strips side by side along a way, all in one object, told apart by material only.
struct World {
  road::Mesh mesh;

  std::uint32_t material(const std::string& name) {
    for (std::uint32_t k = 0; k < mesh.objects.size(); ++k)
      if (mesh.objects[k].material == name) return k;
    mesh.objects.push_back({"Track", name, ""});
    return static_cast<std::uint32_t>(mesh.objects.size() - 1);
  }

  void add(const Vector3d& a, const Vector3d& b, const Vector3d& c, std::uint32_t object) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
    mesh.vertices_m.insert(mesh.vertices_m.end(), {a, b, c});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.object_of_triangle.push_back(object);
  }

  /// Between two offsets from a way, which is given by place and left normal at each t of [0, 1].
  void strip(const std::function<Vector3d(double t, double offset_m)>& way, double right_m,
             double left_m, const std::string& name, double begin = 0.0, double end = 1.0,
             int pieces = 360) {
    const std::uint32_t object = material(name);
    for (int k = 0; k < pieces; ++k) {
      const double s = begin + (end - begin) * k / pieces,
                   t = begin + (end - begin) * (k + 1) / pieces;
      const Vector3d a = way(s, right_m), b = way(t, right_m), c = way(t, left_m),
                     d = way(s, left_m);
      add(a, b, c, object);
      add(a, c, d, object);
    }
  }
};

double radius_m(double t) { return 120.0 + 20.0 * std::sin(3.0 * kTurn * t); }

/// A hilly circuit about the origin; to the left is inwards.
Vector3d ring(double t, double offset_m) {
  const double r = radius_m(t) - offset_m, x = r * std::cos(kTurn * t), y = r * std::sin(kTurn * t);
  return {x, y, 0.03 * x + std::sin(0.05 * y)};
}

/// Asphalt 10 m wide in grass, and beside it a second road as wide, of the same asphalt.
World park() {
  World world;
  world.strip(ring, 5.0, 25.0, "m1");
  world.strip(ring, -5.0, 5.0, "m2");
  world.strip(ring, -12.0, -5.0, "m1");
  world.strip(ring, -22.0, -12.0, "m2");
  world.strip(ring, -40.0, -22.0, "m1");
  return world;
}

/// Points metres off the middle of a road of the ring.
road::Guide sketch(double offset_m, double error_m, unsigned seed, int points = 40) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> anywhere(-error_m, error_m);
  std::vector<Vector3d> rough;
  for (int k = 0; k < points; ++k) {
    Vector3d p = ring(static_cast<double>(k) / points, offset_m);
    rough.emplace_back(p.x() + anywhere(random), p.y() + anywhere(random), std::nan(""));
  }
  return road::guide_along(rough);
}

road::Centreline trace(const road::Mesh& mesh, const road::Guide& guide,
                       std::optional<double> width_m = {}) {
  road::CleanOptions options;
  options.guide = guide;
  options.guide_width_m = width_m;
  road::CentrelineOptions line_options;
  line_options.guide_width_m = width_m;
  return road::trace_centreline(road::clean(mesh, options), line_options);
}

/// How far a line leaves the middle of the ring's road at this offset, in plan and in height.
std::pair<double, double> off_m(const road::Centreline& line, double offset_m) {
  double plan = 0.0, height = 0.0;
  for (const Vector3d& p : line.points_m) {
    double nearest = 1e9, dz = 0.0;
    for (int k = 0; k < 3600; ++k) {
      const Vector3d q = ring(k / 3600.0, offset_m);
      const double d = (p - q).head<2>().norm();
      if (d < nearest) nearest = d, dz = std::abs(p.z() - q.z());
    }
    plan = std::max(plan, nearest), height = std::max(height, dz);
  }
  return {plan, height};
}

TEST(Guide, DecidesBetweenRoadsOfOneMaterialAndItsErrorsDoNotEnterTheLine) {
  const World world = park();
  for (const double offset_m : {0.0, -17.0}) {
    for (const unsigned seed : {1u, 2u}) {
      const road::Centreline line = trace(world.mesh, sketch(offset_m, 2.0, seed));
      EXPECT_TRUE(line.closed);
      const auto [plan, height] = off_m(line, offset_m);
      // The strip's facets reach across it: its middle lies up to 0.0025 / m * (10 m)^2 / 8 = 31 mm
      // off the hill.
      EXPECT_LT(plan, 0.2) << "road at " << offset_m << ", sketch " << seed;
      EXPECT_LT(height, 0.05);
      // Offsets are along the radius, which lies up to 27 degrees off the normal.
      EXPECT_GT(*std::min_element(line.half_width_m.begin(), line.half_width_m.end()),
                5.0 * std::cos(0.47) - 0.1);
      EXPECT_LT(*std::max_element(line.half_width_m.begin(), line.half_width_m.end()), 5.1);
    }
  }
}

TEST(Guide, GivesTheDirectionAndTheBeginning) {
  const World world = park();
  road::Guide guide = sketch(0.0, 1.0, 3);
  std::reverse(guide.points_m.begin(), guide.points_m.end());
  const road::Centreline line = trace(world.mesh, guide);
  EXPECT_LT((line.points_m.front() - guide.points_m.front()).head<2>().norm(), 3.0);
  double turn = 0.0;
  for (std::size_t i = 0; i + 1 < line.points_m.size(); ++i)
    turn += line.points_m[i].x() * line.points_m[i + 1].y() -
            line.points_m[i].y() * line.points_m[i + 1].x();
  EXPECT_LT(turn, 0.0) << "clockwise, as the guide";
}

TEST(Guide, OfAPartGivesAnOpenRoad) {
  const World world = park();
  road::Guide guide = sketch(0.0, 1.0, 4);
  guide.points_m.resize(20);
  guide = road::guide_along(guide.points_m);
  EXPECT_FALSE(guide.closed);
  const road::Centreline line = trace(world.mesh, guide);
  EXPECT_FALSE(line.closed);
  EXPECT_LT(off_m(line, 0.0).first, 0.3);
}

TEST(Guide, OverMissingSurfaceIsRefusedWithThePlaceAndDoubtedWhenItIsLess) {
  World most;
  most.strip(ring, -5.0, 5.0, "m2", 0.0, 0.55);
  most.strip(ring, 5.0, 25.0, "m1", 0.0, 0.55);
  try {
    trace(most.mesh, sketch(0.0, 1.0, 5));
    FAIL() << "45 % of the surface are missing";
  } catch (const road::NotUsable& error) {
    EXPECT_THAT(error.what(), HasSubstr("the surface is missing along 4"));
    EXPECT_THAT(error.what(), HasSubstr("begins at ("));
  }
  World some;
  some.strip(ring, -5.0, 5.0, "m2", 0.0, 0.88);
  some.strip(ring, 5.0, 25.0, "m1", 0.0, 0.88);
  road::CleanOptions options;
  options.guide = sketch(0.0, 1.0, 6);
  road::CleanReport report;
  const road::RoadMesh road = road::clean(some.mesh, options, &report);
  const road::Centreline line = road::trace_centreline(road);
  const auto doubts =
      road::doubts_about(line, road::RaySurface(road.mesh), road.mesh, some.mesh, report);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_THAT(doubts[0], HasSubstr("the surface is missing along 1"));
}

TEST(Guide, OverGroundThatTellsNothingNeedsAWidth) {
  World plain;
  plain.strip([](double t, double offset_m) { return Vector3d(600.0 * t - 300.0, offset_m, 0.0); },
              -300.0, 300.0, "m", 0.0, 1.0, 20);
  const road::Guide guide = sketch(0.0, 0.0, 7);
  EXPECT_THAT(refusal([&] { trace(plain.mesh, guide); }), HasSubstr("--guide-width-m"));
  road::CleanOptions options;
  options.guide = guide;
  options.guide_width_m = 8.0;
  road::CleanReport report;
  road::clean(plain.mesh, options, &report);
  ASSERT_EQ(report.doubts.size(), 1u) << "nobody but the guide knows";
  EXPECT_THAT(report.doubts[0], HasSubstr("along 100 % of the guide nothing but the guide tells"));
  const road::Centreline line = trace(plain.mesh, guide, 8.0);
  EXPECT_TRUE(line.closed);
  EXPECT_LT(off_m(line, 0.0).first, 0.5) << "the guide itself";
  EXPECT_DOUBLE_EQ(line.half_width_m.front(), 4.0);
}

TEST(Guide, AndRouteAreNotGivenTogetherNorAWidthAlone) {
  const World world = park();
  road::CleanOptions options;
  options.guide = sketch(0.0, 1.0, 1);
  options.route_m = {{0, 0}, {1, 1}};
  EXPECT_THAT(refusal([&] { road::clean(world.mesh, options); }), HasSubstr("give one of them"));
  options = {};
  options.guide_width_m = 8.0;
  EXPECT_THAT(refusal([&] { road::clean(world.mesh, options); }),
              HasSubstr("give --guide FILE too"));
}

TEST(Guide, OfLatitudesComesBackThroughTheControlPoints) {
  const support::TemporaryFolder folder;
  const road::UtmZone zone{32, true};
  const auto global = [](const Vector3d& p) {  // turned by 90 degrees and moved
    return Vector3d(500000.0 - p.y(), 5400000.0 + p.x(), p.z() + 300.0);
  };
  std::string control = "mesh_x_m,mesh_y_m,mesh_z_m,lat_deg,lon_deg,h_m\n",
              rough = "lat_deg,lon_deg\n";
  for (const Vector3d& p : {Vector3d(0, 0, 0), Vector3d(200, 0, 1), Vector3d(0, 150, 2)}) {
    const Vector3d q = global(p);
    const Vector2d at = road::from_utm(zone, q.head<2>());
    control +=
        fmt::format("{},{},{},{:.10f},{:.10f},{}\n", p.x(), p.y(), p.z(), at.x(), at.y(), q.z());
  }
  for (int k = 0; k < 30; ++k) {
    const Vector2d at = road::from_utm(zone, global(ring(k / 30.0, 0.0)).head<2>());
    rough += fmt::format("{:.10f},{:.10f}\n", at.x(), at.y());
  }
  road::Recipe recipe;
  recipe.guide_path = folder.file("rough.csv", rough);
  EXPECT_THAT(refusal([&] { road::place_guide(recipe, road::place_mesh(recipe)); }),
              HasSubstr("--control-points"));
  recipe.control_points_path = folder.file("control.csv", control);
  const auto guide = road::place_guide(recipe, road::place_mesh(recipe));
  ASSERT_TRUE(guide);
  ASSERT_EQ(guide->points_m.size(), 30u);
  EXPECT_TRUE(guide->closed);
  for (int k = 0; k < 30; ++k)
    EXPECT_LT((guide->points_m[static_cast<std::size_t>(k)] - ring(k / 30.0, 0.0)).head<2>().norm(),
              0.01)
        << k;
}

TEST(Guide, KeepsToTheSideThatGoesOnWhereTheOtherIsWide) {
  for (const bool inside : {true, false}) {
    World world;
    world.strip(ring, -5.0, 5.0, "m2");
    world.strip(ring, inside ? 5.0 : -12.0, inside ? 12.0 : -5.0, "m2", 0.4, 0.55);
    world.strip(ring, 5.0, 30.0, "m1");
    world.strip(ring, -40.0, -5.0, "m1");
    for (std::size_t t = 0; t < world.mesh.triangles.size(); ++t)
      if (world.mesh.objects[world.mesh.object_of_triangle[t]].material == "m1")
        for (const std::uint32_t v : world.mesh.triangles[t]) world.mesh.vertices_m[v].z() -= 0.02;
    const road::Centreline line = trace(world.mesh, sketch(0.0, 1.5, 3));
    EXPECT_LT(off_m(line, 0.0).first, 0.5) << (inside ? "inside" : "outside");
  }
}

TEST(Guide, BetweenApronsOfTheSameAsphaltKeepsToWhatIsCalledRoadElseIsDoubted) {
  for (const bool named : {true, false}) {
    World world;
    world.mesh.objects = {{named ? "road" : "", "", "t7.png"},
                          {named ? "apron" : "", "", "t7.png"},
                          {"", "", "t8.png"}};
    const auto strip = [&](std::uint32_t object, double right_m, double left_m, double end) {
      const std::size_t first = world.mesh.triangles.size();
      world.strip(ring, right_m, left_m, "", 0.0, end, 240);
      for (std::size_t t = first; t < world.mesh.triangles.size(); ++t)
        world.mesh.object_of_triangle[t] = object;
    };
    strip(0, -5.0, 5.0, 1.0);
    strip(1, -13.0, -5.0, 0.3);
    strip(1, 5.0, 13.0, 0.3);
    strip(2, 13.0, 25.0, 1.0);
    strip(2, -40.0, -13.0, 1.0);
    road::CleanOptions options;
    options.guide = sketch(0.0, 1.0, 3);
    road::CleanReport report;
    road::clean(world.mesh, options, &report);
    if (named) {
      EXPECT_TRUE(report.doubts.empty()) << report.doubts[0];
      EXPECT_LT(off_m(trace(world.mesh, *options.guide), 0.0).first, 0.3);
      continue;
    }
    ASSERT_EQ(report.doubts.size(), 1u);
    EXPECT_THAT(report.doubts[0], HasSubstr("times as wide as usual"));
    // The way out that is named.
    options.guide_width_m = 10.0;
    road::clean(world.mesh, options, &report);
    EXPECT_TRUE(report.doubts.empty()) << report.doubts[0];
    EXPECT_LT(off_m(trace(world.mesh, *options.guide, 10.0), 0.0).first, 0.3) << "measured 0.13";
  }
}

TEST(Guide, ARoofIsNotTheRoadWhereItsOwnLookIsRare) {
  // Under a roof along 3 % of the lap the road has looks of its own, each along half of that.
  World world;
  world.mesh.objects = {{"road", "", "t7.png"},
                        {"road in", "", "t8.png"},
                        {"road out", "", "t9.png"},
                        {"shed", "", "t6.png"}};
  const auto roof = [](double t, double offset_m) {
    return Vector3d(ring(t, offset_m) + Vector3d(0.0, 0.0, 6.0));
  };
  const auto strip = [&](std::uint32_t object, const auto& way, double half_m, double begin,
                         double end, int pieces) {
    const std::size_t first = world.mesh.triangles.size();
    world.strip(way, -half_m, half_m, "", begin, end, pieces);
    for (std::size_t t = first; t < world.mesh.triangles.size(); ++t)
      world.mesh.object_of_triangle[t] = object;
  };
  strip(0, ring, 5.0, 0.0, 0.3, 120);
  strip(1, ring, 5.0, 0.3, 0.315, 6);
  strip(2, ring, 5.0, 0.315, 0.33, 6);
  strip(0, ring, 5.0, 0.33, 1.0, 240);
  strip(3, roof, 4.0, 0.3, 0.33, 12);
  const road::Centreline line = trace(world.mesh, sketch(0.0, 1.0, 3));
  const auto [plan_m, height_m] = off_m(line, 0.0);
  EXPECT_LT(plan_m, 0.3);
  EXPECT_LT(height_m, 0.3);
}

TEST(Guide, SandThatTheRoadLeadsThroughIsNotTheRoad) {
  // Sand 22 m wide under the road along a third of the lap, 50 mm below it and wider to the left.
  World world;
  world.strip(ring, -5.0, 5.0, "m2");
  world.strip(ring, 5.0, 25.0, "m1");
  world.strip(ring, -40.0, -5.0, "m1");
  const auto sand = [](double t, double offset_m) {
    return Vector3d(ring(t, offset_m) - Vector3d(0.0, 0.0, 0.05));
  };
  // In three, so that its facets stay below the asphalt on the hills; they are wider than it.
  for (const auto& [right_m, left_m] : {std::pair{-8.0, -2.0}, {-2.0, 6.0}, {6.0, 14.0}})
    world.strip(sand, right_m, left_m, "m3", 0.1, 0.43, 120);
  road::CleanOptions options;
  options.guide = sketch(0.0, 1.0, 3);
  road::CleanReport report;
  road::clean(world.mesh, options, &report);
  EXPECT_TRUE(report.doubts.empty()) << report.doubts[0];
  const road::Centreline line = trace(world.mesh, *options.guide);
  EXPECT_LT(off_m(line, 0.0).first, 0.3) << "measured 0.10";
  EXPECT_LT(*std::max_element(line.half_width_m.begin(), line.half_width_m.end()), 5.2);
}

TEST(Guide, GroundAsHighAsTheRoadIsNotPaint) {
  // Facets of sand 22 m wide, 50 mm below the asphalt at their ends: on the hills their middles lie
  // as high as it, as paint does.
  World world;
  world.strip(ring, -5.0, 5.0, "m2");
  world.strip(ring, 5.0, 25.0, "m1");
  world.strip(ring, -40.0, -5.0, "m1");
  const auto sand = [](double t, double offset_m) {
    return Vector3d(ring(t, offset_m) - Vector3d(0.0, 0.0, 0.05));
  };
  world.strip(sand, -8.0, 14.0, "m3", 0.1, 0.43, 120);
  const road::Centreline line = trace(world.mesh, sketch(0.0, 1.0, 3));
  EXPECT_LT(off_m(line, 0.0).first, 0.3);
}

TEST(Guide, WaterUnderABridgeIsNotTheRoad) {
  // One large triangle 8 m below, whose middle lies under the middle of the road.
  World world;
  world.strip(ring, -5.0, 5.0, "m2");
  const Vector3d middle = ring(0.3, 0.0) - Vector3d(0.0, 0.0, 8.0);
  world.add(middle + Vector3d(60.0, 0.0, 0.0), middle + Vector3d(-30.0, 50.0, 0.0),
            middle + Vector3d(-30.0, -50.0, 0.0), world.material("m4"));
  const road::Centreline line = trace(world.mesh, sketch(0.0, 1.0, 3));
  EXPECT_TRUE(line.closed);
  EXPECT_LT(off_m(line, 0.0).first, 0.3) << "measured 0.10";
}

TEST(Guide, ARoadThatGrowsWideOnBothSidesIsNotDoubted) {
  // From 10 to 22 m and back, over 80 m each way; 60 m as wide.
  World world;
  const auto half_m = [](double t) {
    return 5.0 + 6.0 * std::clamp(std::min(t - 0.3, 0.58 - t) / 0.1, 0.0, 1.0);
  };
  const auto scaled = [&](double t, double share) { return ring(t, share * half_m(t)); };
  world.strip(scaled, -1.0, 1.0, "m2");
  road::CleanOptions options;
  options.guide = sketch(0.0, 1.0, 3);
  road::CleanReport report;
  road::clean(world.mesh, options, &report);
  EXPECT_TRUE(report.doubts.empty()) << report.doubts[0];
  EXPECT_LT(off_m(trace(world.mesh, *options.guide), 0.0).first, 0.3) << "measured 0.10";
}

TEST(Guide, FollowsTheRightDeckOfACrossing) {
  // A figure of eight, 8 m apart in height where it crosses itself.
  const auto eight = [](double t, double offset_m) {
    const auto middle = [](double s) {
      return Vector3d(150.0 * std::sin(kTurn * s), 90.0 * std::sin(2.0 * kTurn * s),
                      4.0 * std::cos(kTurn * s));
    };
    const Vector3d p = middle(t), q = middle(t + 1e-5);
    const Vector2d along = (q - p).head<2>().normalized();
    return Vector3d(p.x() - offset_m * along.y(), p.y() + offset_m * along.x(), p.z());
  };
  World world;
  world.strip(eight, -4.0, 4.0, "m2", 0.0, 1.0, 720);
  world.strip(eight, 4.0, 10.0, "m1", 0.0, 1.0, 720);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> anywhere(-1.0, 1.0);
  std::vector<Vector3d> rough;
  for (int k = 0; k < 60; ++k) {
    const Vector3d p = eight(k / 60.0, 0.0);
    rough.emplace_back(p.x() + anywhere(random), p.y() + anywhere(random), std::nan(""));
  }
  const road::Centreline line = trace(world.mesh, road::guide_along(rough));
  EXPECT_TRUE(line.closed);
  for (const Vector3d& p : line.points_m) {
    double best = 1e9;
    for (int k = 0; k < 2000; ++k) best = std::min(best, (p - eight(k / 2000.0, 0.0)).norm());
    EXPECT_LT(best, 0.5) << p.transpose();
  }
}

TEST(GuideLap, OfSeveralLapsIsOne) {
  std::vector<Vector3d> driven;
  for (int k = -40; k < 0; ++k)
    driven.emplace_back(k * 5.0 + 60.0, -180.0, 0.0);  // out of the pits
  for (int k = 0; k < 1000; ++k) driven.push_back(ring(k / 400.0, 2.0 * std::sin(0.037 * k)));
  const road::Guide lap = road::guide_along(driven);
  EXPECT_TRUE(lap.closed);
  double length_m = 0.0;
  for (std::size_t i = 1; i < lap.points_m.size(); ++i)
    length_m += (lap.points_m[i] - lap.points_m[i - 1]).head<2>().norm();
  double once_m = 0.0;
  for (int k = 0; k < 400; ++k)
    once_m += (ring((k + 1) / 400.0, 0.0) - ring(k / 400.0, 0.0)).head<2>().norm();
  EXPECT_GT(length_m, 0.95 * once_m);
  EXPECT_LT(length_m, 1.05 * once_m);
}

// A whole race: more laps than a lap is part of the way.
TEST(GuideLap, OfManyLapsIsOneToo) {
  std::vector<Vector3d> driven;
  for (int k = 0; k < 30 * 200; ++k) driven.push_back(ring(k / 200.0, 2.0 * std::sin(0.013 * k)));
  const road::Guide lap = road::guide_along(driven);
  ASSERT_TRUE(lap.closed);
  double length_m = 0.0;
  for (std::size_t i = 1; i < lap.points_m.size(); ++i)
    length_m += (lap.points_m[i] - lap.points_m[i - 1]).head<2>().norm();
  EXPECT_NEAR(length_m, 790.0, 40.0);  // measured along the ring
}

TEST(GuideLap, OfAHelixIsTheWholeWay) {
  std::vector<Vector3d> up;
  for (int k = 0; k < 200; ++k)
    up.emplace_back(40.0 * std::cos(kTurn * k / 60.0), 40.0 * std::sin(kTurn * k / 60.0), 0.1 * k);
  for (int k = 0; k < 200; ++k) up.emplace_back(up.back().x() + 5.0, up.back().y(), 20.0);
  EXPECT_FALSE(road::guide_along(up).closed);
  EXPECT_GT(road::guide_along(up).points_m.size(), 350u);
  EXPECT_THAT(refusal([] {
                road::guide_along({{0, 0, 0}, {0, 0, 0}, {1, 0, 0}});
              }),
              HasSubstr("2 different positions"));
}

TEST(GuideFile, IsReadInEveryFormat) {
  const support::TemporaryFolder folder;
  const auto points = [&](const std::string& name, const std::string& text) {
    return road::read_guide(folder.file(name, text));
  };
  const road::GuideFile csv =
      points("a.csv", "# by hand\nspeed,x_m,y_m\n1,10,20\n2,11,21\n3,12,22.5\n");
  EXPECT_FALSE(csv.geographic);
  ASSERT_EQ(csv.points.size(), 3u);
  EXPECT_DOUBLE_EQ(csv.points[2].y(), 22.5);
  EXPECT_TRUE(std::isnan(csv.points[2].z()));
  const road::GuideFile commas = points("d.csv", "x_m;y_m\r\n1;10,5\r\n2;20,5\r\n3;30,5\r\n");
  EXPECT_FALSE(commas.geographic);
  EXPECT_DOUBLE_EQ(commas.points[2].y(), 30.5);
  const std::vector<road::GuideFile> same{
      points("b.csv", "lat_deg,lon_deg,h_m\n45.5,9.25,100\n45.6,9.35,101\n45.7,9.45,102\n"),
      points("c.csv", "latitude,longitude,height\n45.5,9.25,100\n45.6,9.35,101\n45.7,9.45,102\n"),
      points("d.gpx",
             "<?xml version=\"1.0\"?><gpx><wpt lat=\"1\" lon=\"1\"/><trk><trkseg><trkpt "
             "lat=\"45.5\" lon=\"9.25\"><ele>100</ele></trkpt>"
             "<trkpt lat=\"45.6\" lon=\"9.35\"/></trkseg><trkseg><trkpt lat=\"45.7\" "
             "lon=\"9.45\"/></trkseg></trk></gpx>"),
      points(
          "e.kml",
          "<kml "
          "xmlns=\"http://www.opengis.net/kml/"
          "2.2\"><Document><Placemark><Point><coordinates>1,2,3</coordinates></Point></Placemark>"
          "<Placemark><LineString><coordinates> 9.25,45.5,100 9.35,45.6,101\n9.45,45.7,102 "
          "</coordinates></LineString></Placemark></Document></kml>"),
      points(
          "f.geojson",
          R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":{"type":"LineString",
                             "coordinates":[[9.25,45.5,100],[9.35,45.6],[9.45,45.7]]}}]})"),
  };
  for (std::size_t k = 0; k < same.size(); ++k) {
    EXPECT_TRUE(same[k].geographic);
    ASSERT_EQ(same[k].points.size(), 3u) << k;
    EXPECT_DOUBLE_EQ(same[k].points[0].x(), 45.5) << k;
    EXPECT_DOUBLE_EQ(same[k].points[2].y(), 9.45) << k;
    EXPECT_DOUBLE_EQ(same[k].points[0].z(), 100.0) << k;
  }
}

TEST(GuideFile, MayBeTheLogOfACar) {
  const support::TemporaryFolder folder;
  // As loggers export: lines before the header, a line of units, a receiver that has no fix yet.
  const std::string log = folder.file(
      "run.csv",
      "Session,Sunday\n\n\"Time\",\"GPS Latitude\",\"GPS Longitude\",\"Speed\"\n"
      "\"s\",\"deg\",\"deg\",\"km/h\"\n"
      "0.0,0,0,0\n0.1,45.5,9.25,50\n0.2,45.6,9.35,51\n0.3,45.7,9.45,52\n0.4,45.8,9.55,53\n");
  const road::GuideFile found = road::read_guide(log);
  EXPECT_TRUE(found.geographic);
  ASSERT_EQ(found.points.size(), 4u);
  EXPECT_DOUBLE_EQ(found.points[1].x(), 45.6);
  EXPECT_DOUBLE_EQ(found.points[1].y(), 9.35);
  const std::string own = folder.file(
      "own.csv", "t,pe,pn,lo,la\n0,1,2,0.1,0.8\n1,2,4,0.2,0.9\n2,3,,0.3,1.0\n3,4,8,0.4,1.1\n");
  EXPECT_THAT(refusal([&] { road::read_guide(own); }), HasSubstr("--mapping FILE"));
  const auto mapped = [&](const std::string& columns) {
    return road::read_guide(own, folder.file("mapping.yaml", "version: 1\ncolumns:\n" + columns));
  };
  const road::GuideFile flat =
      mapped("  pe: {channel: x_m, scale: 10, offset: 5}\n  pn: {channel: y_m}\n");
  EXPECT_FALSE(flat.geographic);
  ASSERT_EQ(flat.points.size(), 3u) << "a row without a place is none";
  EXPECT_DOUBLE_EQ(flat.points[2].x(), 45.0);
  EXPECT_DOUBLE_EQ(flat.points[2].y(), 8.0);
  const road::GuideFile round =
      mapped("  la: {channel: latitude_rad}\n  lo: {channel: longitude_rad}\n");
  EXPECT_TRUE(round.geographic);
  ASSERT_EQ(round.points.size(), 4u);
  EXPECT_NEAR(round.points[1].x(), 51.566, 1e-3);
  EXPECT_NEAR(round.points[1].y(), 11.459, 1e-3);
  EXPECT_THAT(refusal([&] { mapped("  t: {channel: time_s}\n"); }), HasSubstr("maps no place"));
  EXPECT_THAT(refusal([&] { mapped("  east: {channel: x_m}\n  pn: {channel: y_m}\n"); }),
              HasSubstr("no column \"east\""));
}

TEST(GuideFile, MayBeTheLogOfAnybodysCar) {
  const std::string folder = places::data() + "/recordings/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  for (const char* name : {"road_america_run1.vbo", "racechrono_tianma_lap9.csv"}) {
    const road::GuideFile guide = road::read_guide(folder + name);
    EXPECT_TRUE(guide.geographic) << name;
    EXPECT_GT(guide.points.size(), 1000u) << name;
    // Both circuits lie within a box of 0.05 degrees, Road America in the west.
    for (const Vector3d& p : guide.points) {
      EXPECT_NEAR(p.x(), guide.points.front().x(), 0.05) << name;
      EXPECT_NEAR(p.y(), guide.points.front().y(), 0.05) << name;
    }
  }
  EXPECT_NEAR(road::read_guide(folder + "road_america_run1.vbo").points.front().y(), -87.99, 0.05);
}

TEST(GuideFile, ThatIsNoneIsRefused) {
  const support::TemporaryFolder folder;
  const auto refused = [&](const std::string& name, const std::string& text) {
    return refusal([&] { road::read_guide(folder.file(name, text)); });
  };
  EXPECT_THAT(refused("a.csv", "u,v\n1,2\n"), HasSubstr("x_m"));
  EXPECT_THAT(refused("b.csv", "x_m,y_m\n1,2\n"), HasSubstr("1 positions"));
  EXPECT_THAT(refused("b.csv", "x_m,y_m\n0,0,0,0\n60,0,6,0\n"), HasSubstr("b.csv:2: "));
  EXPECT_THAT(refused("c.gpx", "<gpx><trk></gpx>"), HasSubstr("c.gpx:1: no XML"));
  EXPECT_THAT(refused("d.kml", "<kml></kml>"), HasSubstr("without a track"));
  EXPECT_THAT(refused("e.json", "{\"type\":"), HasSubstr("no GeoJSON"));
  EXPECT_THAT(refused("f.json", R"({"type":"LineString","coordinates":[[500,1],[2,2],[3,3]]})"),
              HasSubstr("latitude and longitude in degrees"));
  EXPECT_THAT(refused("g.json", "{\"a\":" + std::string(5000, '[') + std::string(5000, ']') + "}"),
              HasSubstr("without a LineString"));
}

/// Streets of 8 m every 100 m, three by three.
World town() {
  World world;
  for (int k = 0; k < 3; ++k) {
    world.strip(
        [k](double t, double offset_m) {
          return Vector3d(240.0 * t - 20.0, 100.0 * k + offset_m, 0.0);
        },
        -4.0, 4.0, "asphalt", 0.0, 1.0, 60);
    world.strip(
        [k](double t, double offset_m) {
          return Vector3d(100.0 * k - offset_m, 240.0 * t - 20.0, 0.0);
        },
        -4.0, 4.0, "asphalt", 0.0, 1.0, 60);
  }
  world.strip([](double t, double offset_m) { return Vector3d(400.0 * t - 100.0, offset_m, -0.3); },
              -100.0, 300.0, "grass", 0.0, 1.0, 20);
  return world;
}

/// A ring of columns between these offsets, without any names.
road::Mesh nameless_ring(const std::function<Vector3d(double t, double offset_m)>& way,
                         const std::vector<double>& offsets_m, double scale = 1.0) {
  World world;
  for (std::size_t k = 0; k + 1 < offsets_m.size(); ++k)
    world.strip(way, offsets_m[k], offsets_m[k + 1], "", 0.0, 1.0, 120);
  world.mesh.objects[0] = {};
  for (Vector3d& p : world.mesh.vertices_m) p *= scale;
  return world.mesh;
}

TEST(ShapeAlone, DoubtsALaneOfWhatIsAllOneRoad) {
  const auto round = [](double t, double offset_m) {
    const double r = 120.0 - offset_m;
    return Vector3d(r * std::cos(kTurn * t), r * std::sin(kTurn * t), 0.0);
  };
  const road::Mesh mesh = nameless_ring(round, {-6.5, -5.5, 0.0, 6.5});
  road::CleanReport report;
  const road::RoadMesh surface = road::clean(mesh, {}, &report);
  const road::Centreline line = road::trace_centreline(surface);
  const auto doubts =
      road::doubts_about(line, road::RaySurface(surface.mesh), surface.mesh, mesh, report);
  double widest_m = 0.0;
  for (const double half_m : line.half_width_m) widest_m = std::max(widest_m, 2.0 * half_m);
  ASSERT_LT(widest_m, 7.0) << "columns of different widths: shape takes one of them";
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_THAT(doubts[0], HasSubstr("may be one lane of it"));
  // The way out that is named.
  std::vector<Vector3d> points;
  for (int k = 0; k < 40; ++k) points.push_back(round(k / 40.0, 0.5));
  const road::Centreline whole = trace(mesh, road::guide_along(points));
  EXPECT_TRUE(whole.closed);
  EXPECT_NEAR(2.0 * whole.half_width_m[whole.half_width_m.size() / 2], 13.0, 0.1);
}

TEST(Plausible, NamesThatFindAClosedRoadOutweighTheLongerRingOfAVerge) {
  World world;
  world.strip(ring, -5.0, 5.0, "asphalt");
  world.strip(ring, 5.0, 13.0, "asphalt", 0.0, 0.3, 108);  // an apron
  world.strip(ring, 13.0, 25.0, "grass");
  world.strip(ring, -40.0, -5.0, "grass");
  road::CleanReport report;
  const road::RoadMesh surface = road::clean(world.mesh, {}, &report);
  EXPECT_TRUE(report.by_names);
  const road::Centreline line = road::trace_centreline(surface);
  EXPECT_LT(off_m(line, 0.0).first, 0.3) << "the side without the apron tells; measured 0.12";
  // Shape alone takes the verge, and says what it is called.
  road::CleanOptions by_shape;
  by_shape.use_names = road::UseNames::no;
  const road::RoadMesh shaped = road::clean(world.mesh, by_shape, &report);
  const auto doubts =
      road::doubts_about(road::trace_centreline(shaped), road::RaySurface(shaped.mesh), shaped.mesh,
                         world.mesh, report);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_THAT(doubts[0], HasSubstr("is called 'grass' in the mesh"));
}

TEST(Plausible, AnOpenRoadByNamesAsLongAsTheVergeThatShapeFindsIsNoPart) {
  // A road in a slope, whose upper bank is wider than it.
  const auto slope = [](double t, double offset_m) {
    Vector3d p = ring(t, offset_m);
    p.z() += 0.5 * (std::max(0.0, -2.0 - offset_m) - std::max(0.0, offset_m - 2.0));
    return p;
  };
  const auto doubts_with = [&](double named_until) {
    World world;
    world.strip(slope, -2.0, 2.0, "asphalt", 0.0, named_until, 200);
    if (named_until < 0.8) world.strip(slope, -2.0, 2.0, "rock", named_until, 0.8, 40);
    world.strip(slope, -7.0, -2.0, "rock", 0.0, 0.8, 288);
    world.strip(slope, 2.0, 5.0, "rock", 0.0, 0.8, 288);
    for (road::MeshObject& object : world.mesh.objects) object.name = object.material;
    road::CleanReport report;
    const road::RoadMesh surface = road::clean(world.mesh, {}, &report);
    EXPECT_LT(*report.road_agreement, 0.5);
    std::string all;
    for (const std::string& doubt :
         road::doubts_about(road::trace_centreline(surface), road::RaySurface(surface.mesh),
                            surface.mesh, world.mesh, report))
      all += doubt;
    return all;
  };
  EXPECT_EQ(doubts_with(0.8), "");
  EXPECT_NE(doubts_with(0.74), "");
}

TEST(Plausible, DoubtsAStripAtTheRimOfFlatGround) {
  road::Centreline line;
  line.closed = true;
  line.length_m = support::kRingLength_m;
  for (double s_m = 0.0; s_m < support::kRingLength_m; s_m += 5.0) {
    line.points_m.push_back(support::on_ring(s_m, 0.0, 0.0));
    line.half_width_m.push_back(5.0);
  }
  const auto doubts_on = [&](double right_m, double left_m) {
    road::Mesh ground;
    support::add_ring_strip(ground, "", right_m, left_m, 0.0, 0.0);
    road::CleanReport report;  // by shape
    report.class_of_triangle.assign(ground.triangles.size(), road::SurfaceClass::road);
    std::string all;
    for (const std::string& doubt :
         road::doubts_about(line, road::RaySurface(ground), ground, ground, report))
      all += doubt;
    return all;
  };
  EXPECT_THAT(doubts_on(-5.0, 20.0), HasSubstr("at the rim of flat ground"));
  EXPECT_THAT(doubts_on(-20.0, 5.0), HasSubstr("at the rim of flat ground"));
  EXPECT_EQ(doubts_on(-20.0, 20.0), "") << "ground on both sides is what roads have";
  EXPECT_EQ(doubts_on(-5.0, 5.0), "") << "a road alone";
}

TEST(Plausible, DoubtsARoadThatIsMuchWiderInPlaces) {
  // A paddock on both sides, called asphalt as the road is: nothing tells where the road ends.
  World world;
  world.strip(ring, -5.0, 5.0, "asphalt");
  world.strip(ring, 5.0, 13.0, "asphalt", 0.0, 0.3, 108);
  world.strip(ring, -13.0, -5.0, "asphalt", 0.0, 0.3, 108);
  road::CleanReport report;
  const road::RoadMesh surface = road::clean(world.mesh, {}, &report);
  const auto doubts =
      road::doubts_about(road::trace_centreline(surface), road::RaySurface(surface.mesh),
                         surface.mesh, world.mesh, report);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_THAT(doubts[0], HasSubstr("times as wide as usual (9.8 m), 26.0 m at"));
  EXPECT_THAT(doubts[0], HasSubstr("--guide FILE"));
}

TEST(ShapeAlone, DoubtsAStripThatMayBeTheVergeOfAnother) {
  const auto oval = [](double t, double offset_m) {  // a tenth longer than wide
    const Vector2d p(330.0 * std::cos(kTurn * t), 300.0 * std::sin(kTurn * t));
    const Vector2d inwards =
        -Vector2d(p.x() / (330.0 * 330.0), p.y() / (300.0 * 300.0)).normalized();
    const Vector2d q = p + offset_m * inwards;
    return Vector3d(q.x(), q.y(), 0.0);
  };
  const auto doubts_of = [&](const std::vector<double>& offsets_m) {
    const road::Mesh mesh = nameless_ring(oval, offsets_m);
    road::CleanReport report;
    const road::RoadMesh surface = road::clean(mesh, {}, &report);
    EXPECT_FALSE(report.by_names);
    return road::doubts_about(road::trace_centreline(surface), road::RaySurface(surface.mesh),
                              surface.mesh, mesh, report);
  };
  // A road of 10 m between verges, or beside one: the wider strip is taken.
  for (const std::vector<double>& offsets_m :
       {std::vector{-20.0, -5.0, 0.0, 5.0, 20.0}, std::vector{-5.0, 0.0, 5.0, 20.0}}) {
    const auto doubts = doubts_of(offsets_m);
    ASSERT_EQ(doubts.size(), 1u);
    EXPECT_THAT(doubts[0], HasSubstr("may be the road and this one its verge"));
    EXPECT_THAT(doubts[0], HasSubstr("--guide FILE"));
  }
  // With narrow ones on both sides, or on one side, it is the road.
  EXPECT_TRUE(doubts_of({-9.0, -5.0, 0.0, 5.0, 9.0}).empty());
  EXPECT_TRUE(doubts_of({-5.0, 0.0, 5.0, 9.0}).empty());
}

TEST(ShapeAlone, DoubtsARoadThatTheMeshCallsWater) {
  road::Mesh mesh = nameless_ring(ring, {-4.0, 0.0, 4.0});
  const auto doubts_as = [&](const std::string& material) {
    for (road::MeshObject& object : mesh.objects) object.material = material;
    road::CleanReport report;
    const road::RoadMesh surface = road::clean(mesh, {}, &report);
    EXPECT_FALSE(report.by_names);
    return road::doubts_about(road::trace_centreline(surface), road::RaySurface(surface.mesh),
                              surface.mesh, mesh, report);
  };
  EXPECT_TRUE(doubts_as("Material.001").empty());
  EXPECT_TRUE(doubts_as("Freshwater").empty()) << "the beginning of a word, or none";
  const auto doubts = doubts_as("Water_deep");
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_THAT(doubts[0], HasSubstr("is called 'Water_deep'"));
}

TEST(ShapeAlone, TakesAllOfASmallRing) {
  const road::Mesh mesh = nameless_ring(ring, {-1.0, -0.2, 1.5}, 0.3);
  const road::Centreline line = road::trace_centreline(road::clean(mesh));
  EXPECT_TRUE(line.closed);
  EXPECT_NEAR(2.0 * line.half_width_m[line.half_width_m.size() / 2], 0.75, 0.08)
      << "radial; across the road it is a little less";
  EXPECT_DOUBLE_EQ(road::automatic_step_m(line), 0.01) << "a fortieth is 0.019";
}

TEST(Route, LeadsThroughANetwork) {
  const World world = town();
  road::CleanOptions options;
  options.route_m = {{0, 50}, {50, 100}, {100, 50}, {50, 0}, {0, 50}};
  const road::Centreline line = road::trace_centreline(road::clean(world.mesh, options));
  EXPECT_TRUE(line.closed);
  EXPECT_NEAR(line.length_m, 400.0, 40.0) << "around one block, corners cut";
  for (const Vector3d& p : line.points_m) {
    EXPECT_GT(p.x(), -5.0);
    EXPECT_LT(p.x(), 105.0);
    EXPECT_GT(p.y(), -5.0);
    EXPECT_LT(p.y(), 105.0);
  }
  options.route_m = {{0, 50}, {5000, 100}};
  EXPECT_THAT(refusal([&] { road::clean(world.mesh, options); }),
              HasSubstr("point 2 of the route"));
}

TEST(Question, AboutTwoRingsHasTwoAnswersThatLeadOn) {
  const support::TemporaryFolder folder;
  World world;
  world.strip(ring, -5.0, 5.0, "asphalt");
  world.strip(
      [](double t, double offset_m) {
        return Vector3d(ring(t, offset_m) + Vector3d(400.0, 0.0, 0.0));
      },
      -4.0, 4.0, "asphalt");
  road::write_mesh(world.mesh, folder.path("rings.obj"), "");
  road::Recipe recipe = road::recipe_for_mesh(folder.path("rings.obj"));
  std::vector<road::Candidate> answers;
  try {
    road::make_track(recipe, folder.path("out"));
    FAIL() << "there are two roads";
  } catch (const road::Question& question) {
    answers = question.candidates();
    EXPECT_THAT(question.what(),
                HasSubstr("which road is meant? " + folder.path("out/rings.question.png") +
                          " shows 2 that could be"));
  }
  EXPECT_TRUE(std::filesystem::exists(folder.path("out/rings.question.png")));
  EXPECT_FALSE(std::filesystem::exists(folder.path("out/rings.crg")));
  ASSERT_EQ(answers.size(), 2u);
  for (const road::Candidate& answer : answers) {
    EXPECT_TRUE(answer.closed);
    ASSERT_TRUE(answer.flags.starts_with("--route "));
    for (const road::RecipeKey& key : road::recipe_keys())
      if (key.name == "route") key.set(recipe, answer.flags.substr(8));
    const road::BuildResult built = road::make_track(recipe, folder.path("out"));
    EXPECT_TRUE(built.validation_failures.empty());
    const road::Centreline line = road::read_centreline_csv(built.centreline_path);
    EXPECT_NEAR(line.length_m, answer.length_m, 0.5);
    EXPECT_FALSE(std::filesystem::exists(folder.path("out/rings.question.png"))) << "answered";
  }
}

}  // namespace guide_test
