#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "mesh/error.h"
#include "road/centreline.h"
#include "road/clean.h"
#include "road/roads_of.h"
#include "support/ring_strips.h"

namespace plausible_road_test {

using road::Mesh;
using ::testing::Contains;
using ::testing::HasSubstr;

/// A ring of 150 m, 12 m wide, of `pieces` that `name_of` names.
template <class NameOf>
Mesh ring(std::uint32_t pieces, const NameOf& name_of) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < pieces; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / pieces;
    for (const double radius_m : {144.0, 156.0})
      mesh.vertices_m.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), 0.0);
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % pieces);
    mesh.triangles.push_back({a, a + 1, b + 1});
    mesh.triangles.push_back({a, b + 1, b});
    mesh.object_of_triangle.insert(mesh.object_of_triangle.end(), 2, i);
    mesh.objects.push_back({name_of(i), "", ""});
  }
  return mesh;
}

TEST(PlausibleRoad, NamesThatCallLittleOfItRoadTellNothing) {
  // Two pieces on opposite sides are called road, nothing else is.
  const Mesh mesh =
      ring(120, [](std::uint32_t i) { return std::string(i % 60 < 4 ? "road" : "part"); });
  road::CleanReport report;
  const road::RoadMesh cleaned = road::clean(mesh, {}, &report);
  EXPECT_EQ(cleaned.mesh.triangles.size(), 240u);
  EXPECT_EQ(road::told_by(report), "shape");
  EXPECT_THAT(report.remarks, Contains(HasSubstr("names tell no road (2 separate roads")));
}

TEST(PlausibleRoad, NamesThatCallHalfOfItRoadAreAskedAbout) {
  const Mesh mesh =
      ring(120, [](std::uint32_t i) { return std::string(i % 60 < 30 ? "road" : "part"); });
  EXPECT_THAT([&] { road::clean(mesh); },
              ::testing::ThrowsMessage<road::Error>(HasSubstr("shape alone finds a closed road")));
}

TEST(PlausibleRoad, NamesThatCallTheVergeRoadTooAreAskedAbout) {
  Mesh mesh;
  support::add_ring_strip(mesh, "Track", -5.0, 5.0, 0.0, 0.0);
  support::add_ring_strip(mesh, "Track", -13.0, -5.0, -1.2, 0.0);
  support::add_ring_strip(mesh, "Track", 5.0, 13.0, 0.0, -1.2);
  mesh.objects[1].material = mesh.objects[2].material = "green";
  const auto doubts = [&](road::UseNames use_names) {
    road::CleanOptions options;
    options.use_names = use_names;
    road::CleanReport report;
    road::clean(mesh, options, &report);
    return report.doubts;
  };
  EXPECT_THAT(doubts(road::UseNames::automatic),
              ::testing::ElementsAre(::testing::AllOf(HasSubstr("about 26 m wide"),
                                                      HasSubstr("the road is about 10 m wide"))));
  EXPECT_THAT(doubts(road::UseNames::yes), ::testing::IsEmpty());
  EXPECT_THAT(doubts(road::UseNames::no), ::testing::IsEmpty());
  // Of one look it is another lane, a painted line between them or not.
  mesh.objects[1].material = mesh.objects[2].material = "";
  support::add_ring_strip(mesh, "Track", -0.1, 0.1, 0.01, 0.01);
  mesh.objects[3].material = "white";
  EXPECT_THAT(doubts(road::UseNames::automatic), ::testing::IsEmpty());
  // Rough, it is a verge whatever its look.
  mesh.objects[3].material = "";
  for (Eigen::Vector3d& v : mesh.vertices_m)
    if (std::abs(support::kRing_m - v.head<2>().norm()) > 6.0)
      v.z() += 0.1 * std::sin(240.0 * std::atan2(v.y(), v.x()));
  EXPECT_THAT(doubts(road::UseNames::automatic), ::testing::SizeIs(1));
  // Where little is beside it, all of it is the road that the names say.
  mesh = {};
  support::add_ring_strip(mesh, "Track", -5.0, 5.0, 0.0, 0.0);
  support::add_ring_strip(mesh, "Track", 5.0, 7.0, 0.0, -0.3);
  mesh.objects[1].material = "green";
  EXPECT_THAT(doubts(road::UseNames::automatic), ::testing::IsEmpty());
}

/// One nameless object: a road of 12 m whose halves fall by 2 and `right` from its middle, between
/// verges of 10 m.
Mesh crowned(double right) {
  Mesh mesh;
  support::add_ring_strip(mesh, "", -6.0, 0.0, -6.0 * right, 0.0);
  support::add_ring_strip(mesh, "", 0.0, 6.0, 0.0, -0.12);
  support::add_ring_strip(mesh, "", -16.0, -6.0, -6.0 * right - 1.5, -6.0 * right);
  support::add_ring_strip(mesh, "", 6.0, 16.0, -0.12, -1.6);
  mesh.objects.resize(1);
  std::fill(mesh.object_of_triangle.begin(), mesh.object_of_triangle.end(), 0);
  return mesh;
}

TEST(PlausibleRoad, ACrownedRoadWithoutNamesIsOneRoad) {
  road::CleanReport report;
  const road::RoadMesh cleaned = road::clean(crowned(0.02), {}, &report);
  EXPECT_EQ(report.kept["road"], 2u * 2u * 629u);
  EXPECT_THAT(report.doubts, ::testing::IsEmpty());
}

/// The same with half of the ring banked by up to 4 %, where one side of the crown rises.
TEST(PlausibleRoad, ACrownedRoadThatIsBankedInItsBendsIsOneRoad) {
  Mesh mesh = crowned(0.02);
  for (Eigen::Vector3d& p : mesh.vertices_m) {
    const double out_m = p.head<2>().norm() - support::kRing_m;
    p.z() += 0.04 * std::max(0.0, std::sin(std::atan2(p.y(), p.x()))) * out_m;
  }
  road::CleanReport report;
  road::clean(mesh, {}, &report);
  EXPECT_EQ(report.kept["road"], 2u * 2u * 629u);
  EXPECT_THAT(report.doubts, ::testing::IsEmpty());
}

/// One nameless object: two halves of 5 m with a ridge between them that is no crown, and a verge.
TEST(PlausibleRoad, HalfOfARoadBetweenTheOtherAndAVergeIsDoubted) {
  Mesh mesh;
  support::add_ring_strip(mesh, "", -5.0, 0.0, -0.3, 0.0);
  support::add_ring_strip(mesh, "", 0.0, 5.0, 0.0, -0.1);
  support::add_ring_strip(mesh, "", 5.0, 9.0, -0.1, -0.9);
  support::add_ring_strip(mesh, "", -9.0, -5.0, -1.2, -0.3);
  mesh.objects.resize(1);
  std::fill(mesh.object_of_triangle.begin(), mesh.object_of_triangle.end(), 0);
  road::CleanReport report;
  road::clean(mesh, {}, &report);
  EXPECT_THAT(report.doubts, Contains(HasSubstr("of two strips side by side")));
}

TEST(PlausibleRoad, AnEdgeThatFallsOnOneSideIsNoCrown) {
  road::CleanReport report;
  road::clean(crowned(0.06), {}, &report);
  EXPECT_EQ(report.kept["road"], 2u * 629u);
  EXPECT_THAT(report.doubts, Contains(HasSubstr("of two strips side by side")));
}

TEST(PlausibleRoad, TwoHalvesBetweenVergesAreOneRoadInTheFirstPlace) {
  Mesh mesh = crowned(0.02);  // banked all along: neither side of its middle falls away
  for (Eigen::Vector3d& p : mesh.vertices_m)
    p.z() += 0.08 * (p.head<2>().norm() - support::kRing_m);
  const std::vector<road::PlaceOfRoad> places = road::places_that_may_be_road(mesh, {});
  ASSERT_FALSE(places.empty());
  ASSERT_TRUE(places[0].width_m.has_value());
  EXPECT_NEAR(*places[0].width_m, 12.0, 0.1);
  road::CleanOptions options;
  options.near_m = places[0].near_m;
  options.guide_width_m = places[0].width_m;
  road::CleanReport report;
  road::clean(mesh, options, &report);
  EXPECT_EQ(report.kept["road"], 2u * 2u * 629u);
  EXPECT_THAT(report.doubts, ::testing::IsEmpty());
}

TEST(PlausibleRoad, APlaceTellsWhichStripIsMeantAndAWidthAllOfThem) {
  const Mesh mesh = crowned(0.06);
  for (const auto& [left_m, width_m, triangles] :
       {std::tuple(3.0, 0.0, 2u * 629u), {-11.0, 0.0, 2u * 629u}, {3.0, 32.0, 8u * 629u}}) {
    road::CleanOptions options;
    options.near_m = support::on_ring(10.0, left_m, 0.0).head<2>();
    if (width_m > 0.0) options.guide_width_m = width_m;
    road::CleanReport report;
    const road::RoadMesh cleaned = road::clean(mesh, options, &report);
    EXPECT_EQ(report.kept["road"], triangles) << left_m << ", " << width_m;
    EXPECT_THAT(report.doubts, ::testing::IsEmpty());
    EXPECT_TRUE(report.by_place);
    for (std::size_t t = 0; width_m == 0.0 && t < cleaned.mesh.triangles.size(); ++t) {
      if (cleaned.class_of_triangle[t] != road::SurfaceClass::road) continue;
      const Eigen::Vector3d at = cleaned.mesh.origin_m + cleaned.mesh.vertex(t, 0);
      EXPECT_NEAR(support::kRing_m - at.head<2>().norm(), left_m, 5.1);
    }
  }
}

/// A ring of 628 m in two pieces, with gaps of this length between them.
Mesh in_two_pieces(double gap_m) {
  Mesh mesh;
  for (const double begin_m : {0.0, 0.5 * support::kRingLength_m})
    support::add_ring_strip(mesh, "road", -6.0, 6.0, 0.0, 0.0, begin_m,
                            begin_m + 0.5 * support::kRingLength_m - gap_m);
  return mesh;
}

TEST(PlausibleRoad, PiecesWhoseEndsFaceEachOtherAreOneRoad) {
  const Mesh mesh = in_two_pieces(6.0);
  EXPECT_EQ(road::clean(mesh).mesh.triangles.size(), mesh.triangles.size());
  EXPECT_THAT([] { road::clean(in_two_pieces(25.0)); },
              ::testing::ThrowsMessage<road::Error>(HasSubstr("2 separate roads")));
}

/// One nameless object: level columns between these offsets.
Mesh nameless(const std::vector<double>& offsets_m) {
  Mesh mesh;
  for (std::size_t k = 0; k + 1 < offsets_m.size(); ++k)
    support::add_ring_strip(mesh, "", offsets_m[k], offsets_m[k + 1], 0.0, 0.0);
  mesh.objects.resize(1);
  std::fill(mesh.object_of_triangle.begin(), mesh.object_of_triangle.end(), 0);
  return mesh;
}

constexpr std::size_t kColumn = 2u * 629u;  // triangles

TEST(PlausibleRoad, OfColumnsInOnePlaneTheirWidthsTellNothing) {
  const Mesh mesh = nameless({-5.0, -3.5, 3.5, 5.0});
  road::CleanReport report;
  road::clean(mesh, {}, &report);
  EXPECT_THAT(report.doubts, Contains(HasSubstr("in one plane")));
  for (const auto& [width_m, columns] : {std::pair(7.0, 1u), {10.0, 3u}}) {
    road::CleanOptions options;
    options.near_m = support::on_ring(10.0, 0.5, 0.0).head<2>();
    options.guide_width_m = width_m;
    road::clean(mesh, options, &report);
    EXPECT_EQ(report.kept["road"], columns * kColumn) << width_m;
    EXPECT_THAT(report.doubts, ::testing::IsEmpty());
  }
}

TEST(PlausibleRoad, ColumnsNarrowerThanAnyRoadAreOneInOnePlane) {
  road::CleanReport report;
  road::clean(nameless({-5.0, -2.0, -0.5, 1.5, 5.0}), {}, &report);
  EXPECT_EQ(report.kept["road"], 4u * kColumn);
  EXPECT_THAT(report.doubts, ::testing::IsEmpty());
}

TEST(PlausibleRoad, AStripAsWideAsACircuitIsARoadWithoutWhatIsBeside) {
  for (const double half_m : {3.0, 5.0}) {
    road::CleanReport report;
    road::clean(nameless({-half_m, 0.0, half_m, half_m + 2.0}), {}, &report);
    EXPECT_EQ(report.kept["road"], 2u * kColumn);
    EXPECT_EQ(report.doubts.empty(), half_m == 5.0) << half_m;
  }
}

TEST(PlausibleRoad, ATwinApartFromTheRoadIsDoubted) {
  Mesh mesh = nameless({-9.5, -1.5});
  support::add_ring_strip(mesh, "", 1.5, 9.5, 0.0, 0.0);
  road::CleanOptions options;
  options.near_m = support::on_ring(10.0, 5.0, 0.0).head<2>();
  road::CleanReport report;
  road::clean(mesh, options, &report);
  EXPECT_THAT(report.doubts, ::testing::IsEmpty());
  road::clean(mesh, {}, &report);
  EXPECT_THAT(report.doubts, Contains(HasSubstr("another strip as long and wide")));
}

TEST(PlausibleRoad, HalvesBesideALineAreNoTwins) {
  Mesh mesh = nameless({-5.5, -0.1});
  support::add_ring_strip(mesh, "", 0.1, 5.5, 0.0, 0.0);
  road::CleanReport report;
  road::clean(mesh, {}, &report);
  EXPECT_THAT(report.doubts, ::testing::Not(Contains(HasSubstr("another strip as long and wide"))));
}

TEST(PlausibleRoad, CarriagewaysAlikeAreTwoRoads) {
  // What lies between them joins them into one surface, not into one road.
  Mesh mesh;
  support::add_ring_strip(mesh, "road a", -9.5, -1.5, 0.0, 0.0);
  support::add_ring_strip(mesh, "grass", -1.5, 1.5, 0.0, 0.0);
  support::add_ring_strip(mesh, "road b", 1.5, 9.5, 0.0, 0.0);
  EXPECT_THAT([&] { road::clean(mesh); }, ::testing::ThrowsMessage<road::Error>(
                                              HasSubstr("two separate roads that are alike")));
  road::CleanOptions by_names;
  by_names.use_names = road::UseNames::yes;
  const road::RoadMesh both = road::clean(mesh, by_names);
  EXPECT_THAT(
      [&] { road::trace_centreline(both); },
      ::testing::ThrowsMessage<road::Error>(HasSubstr("two separate roads that are alike")));
}

TEST(PlausibleRoad, CarriagewaysOfALargeRingAreNotOneRoadDrawnTwice) {
  // Their outlines differ by less than 2 % of their size.
  Mesh mesh;
  constexpr std::uint32_t kPieces = 240;
  for (const double inner_m : {1491.0, 1501.0}) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
    for (std::uint32_t i = 0; i < kPieces; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kPieces;
      for (const double radius_m : {inner_m, inner_m + 8.0})
        mesh.vertices_m.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), 0.0);
      const std::uint32_t a = first + 2 * i, b = first + 2 * ((i + 1) % kPieces);
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  }
  mesh.object_of_triangle.assign(mesh.triangles.size(), 0);
  mesh.objects.push_back({"road", "", ""});
  EXPECT_THAT([&] { road::clean(mesh); },
              ::testing::ThrowsMessage<road::Error>(HasSubstr("2 separate roads")));
}

TEST(PlausibleRoad, ABridgeOfAnotherNameCarriesTheNamedRoad) {
  // In a bend: the middle of the second lies 8 m beside the straight line between its ends, those
  // of the third face past each other.
  for (const auto& [name, length_m] : {std::pair<std::string, double>{"viaduct", 50.0},
                                       {"viaduct", 80.0},
                                       {"viaduct", 120.0},
                                       {"gravel", 50.0}}) {
    Mesh mesh;
    support::add_ring_strip(mesh, "road", -5.0, 5.0, 0.0, 0.0, length_m);
    support::add_ring_strip(mesh, name, -5.0, 5.0, 0.0, 0.0, 0.0, length_m);
    road::CleanReport report;
    road::clean(mesh, {}, &report);
    EXPECT_EQ(*report.road_agreement > 0.9, length_m < 60.0) << "names are believed";
    EXPECT_EQ(report.kept["road"] == mesh.triangles.size(), name == "viaduct") << name;
  }
}

}  // namespace plausible_road_test
