// Edges as surveys draw them: in latitude and longitude, and not quite closed.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "crg/surface.h"
#include "mesh/error.h"
#include "road/edges.h"
#include "road/track_crg.h"
#include "support/temporary_folder.h"

namespace edge_files_test {

using road::Edge;
using road::EdgeRoad;
using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

/// 90 points, as far as they are not left out.
Edge circle(double radius_m, int points) {
  Edge edge;
  for (int i = 0; i < points; ++i) {
    const double angle = 2.0 * kPi * i / 90.0;
    edge.points_m.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), 0.0);
  }
  return edge;
}

TEST(EdgeFiles, OneLineWithoutWidthsIsRefusedWithWhatIsMissing) {
  const support::TemporaryFolder folder;
  const std::string line = folder.file(
      "line.geojson",
      R"({"type":"LineString","coordinates":[[14.7,47.2],[14.701,47.2],[14.702,47.2],[14.703,47.2]]})");
  try {
    road::read_edges_of_line(line);
    FAIL() << "a road without width";
  } catch (const road::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("says no width; wanted the left and the right edge"));
  }
}

TEST(EdgeFiles, LatitudeAndLongitudeAreReadAsTheyAreDrawn) {
  // A ring of 100 m about a place in Austria; 1 degree of latitude and longitude there in metres by
  // the series of the ellipsoid WGS84.
  const double latitude_deg = 47.22, longitude_deg = 14.765,
               latitude_rad = latitude_deg * kPi / 180.0;
  const double north_m = 111132.954 - 559.822 * std::cos(2.0 * latitude_rad) +
                         1.175 * std::cos(4.0 * latitude_rad),
               east_m = 111412.84 * std::cos(latitude_rad) - 93.5 * std::cos(3.0 * latitude_rad);
  const support::TemporaryFolder folder;
  std::string left, right, csv = "lat_deg,lon_deg,h_m\n";
  for (int i = 0; i < 90; ++i) {
    const double angle = 2.0 * kPi * i / 90.0;
    const auto at = [&](double radius_m) {
      return fmt::format("{:.9f},{:.9f},{}", longitude_deg + radius_m * std::cos(angle) / east_m,
                         latitude_deg + radius_m * std::sin(angle) / north_m, 680.0);
    };
    left += at(96.0) + " ", right += at(104.0) + " ";
    csv += fmt::format("{:.9f},{:.9f},680\n", latitude_deg + 104.0 * std::sin(angle) / north_m,
                       longitude_deg + 104.0 * std::cos(angle) / east_m);
  }
  const auto kml = [](const std::string& line) {
    return "<kml><Placemark><LineString><coordinates>" + line +
           "</coordinates></LineString></Placemark></kml>";
  };
  const std::string left_path = folder.file("left.kml", kml(left));
  for (const std::string& right_path :
       {folder.file("right.kml", kml(right)), folder.file("right.csv", csv)}) {
    const road::EdgePlaces places = road::read_edges(left_path, right_path);
    EXPECT_TRUE(places.left.has_z && places.right.has_z);
    const EdgeRoad built = road_between_edges(places.left, places.right);
    EXPECT_NEAR(built.centreline.length_m, 2.0 * kPi * 100.0, 0.05);
    const Eigen::Vector2d start =
        road::unproject(places.projection, {built.line.x_m.front(), built.line.y_m.front()});
    EXPECT_NEAR(start.x(), latitude_deg, 1e-6);
    EXPECT_NEAR(start.y(), longitude_deg + 100.0 / east_m, 1e-6);
    EXPECT_NEAR(crg::Surface(road::track_crg(built.line, built.sampled.grid)).z_at_uv(50.0, 1.0),
                680.0, 1e-3);
  }
  EXPECT_THAT([&] { road::read_edges(left_path, folder.file("x.csv", "x_m,y_m\n1,2\n")); },
              ::testing::ThrowsMessage<road::Error>(HasSubstr("same coordinates")));
}

TEST(EdgeFiles, MetresCountWhereAFileHasBoth) {
  const support::TemporaryFolder folder;
  std::string text = "x_m,y_m,lat_deg,lon_deg\n";
  for (int i = 0; i < 10; ++i) text += fmt::format("{},8,47.2,14.7\n", 10 * i);
  const std::string path = folder.file("both.csv", text);
  const road::EdgePlaces places = road::read_edges(path, path);
  EXPECT_EQ(places.projection.kind, road::Projection::Kind::none);
  EXPECT_EQ(places.left.points_m[3].x(), 30.0);
}

TEST(EdgeFiles, ARingWithAGapStaysOpenWhereThatIsWanted) {
  Edge left = circle(96.0, 88), right = circle(104.0, 88);
  road::EdgesReport report;
  road_between_edges(left, right, {}, &report);
  EXPECT_TRUE(report.closed);
  EXPECT_THAT(report.remarks, ::testing::Contains(HasSubstr("20.1 m from its last point")));
  left.keep_open = right.keep_open = true;
  const EdgeRoad open = road_between_edges(left, right, {}, &report);
  EXPECT_FALSE(report.closed);
  EXPECT_NEAR(open.centreline.length_m, 2.0 * kPi * 100.0 * 87.0 / 90.0, 0.3);
}

}  // namespace edge_files_test
