#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "mesh/error.h"
#include "road/clean.h"

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

}  // namespace plausible_road_test
