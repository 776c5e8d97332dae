#include "mesh/ray_surface.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ray_surface_test {

/// A square of side 2 * half_m around (x, y) with z = z0 + slope * (x - x0).
void add_square(road::Mesh& mesh, double x_m, double y_m, double half_m, double z_m,
                double slope = 0.0) {
  const auto base = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (const double dy : {-half_m, half_m}) {
    for (const double dx : {-half_m, half_m})
      mesh.vertices_m.emplace_back(x_m + dx, y_m + dy, z_m + slope * dx);
  }
  mesh.triangles.push_back({base, base + 1, base + 2});
  mesh.triangles.push_back({base + 2, base + 1, base + 3});
  mesh.object_of_triangle.insert(mesh.object_of_triangle.end(), 2, 0);
  mesh.objects = {{}};
}

TEST(RaySurface, ListsAllLayersFromHighToLowAndMergesTwins) {
  road::Mesh mesh;
  add_square(mesh, 0, 0, 10, 5.0);
  add_square(mesh, 0, 0, 10, 5.0004);  // a twin closer than 1 mm
  add_square(mesh, 0, 0, 10, -3.0);
  add_square(mesh, 0, 0, 10, 12.0);
  const road::RaySurface surface(mesh);
  const auto hits = surface.all_hits(1.0, 2.0);
  ASSERT_EQ(hits.size(), 3u);
  EXPECT_NEAR(hits[0].z_m, 12.0, 1e-5);
  EXPECT_NEAR(hits[1].z_m, 5.0, 5e-4);
  EXPECT_NEAR(hits[2].z_m, -3.0, 1e-5);
  EXPECT_TRUE(surface.all_hits(11.0, 0.0).empty());
}

TEST(RaySurface, TakesTheLayerNearestToThePrediction) {
  road::Mesh mesh;
  add_square(mesh, 0, 0, 10, 0.0);
  add_square(mesh, 0, 0, 10, 1.5);
  const road::RaySurface surface(mesh);
  EXPECT_NEAR(surface.nearest_hit(0, 0, 0.6, 1.0)->z_m, 0.0, 1e-6);
  EXPECT_NEAR(surface.nearest_hit(0, 0, 0.9, 1.0)->z_m, 1.5, 1e-6);
  EXPECT_FALSE(surface.nearest_hit(0, 0, 5.0, 1.0).has_value());
}

TEST(RaySurface, KeepsMillimetresAtUtmCoordinates) {
  road::Mesh mesh;
  mesh.origin_m = {691'234.5, 5'334'567.25, 512.0};
  add_square(mesh, 0, 0, 100, 0.0, 0.03);
  const road::RaySurface surface(mesh);
  const auto hit = surface.nearest_hit(691'234.5 + 37.123, 5'334'567.25 - 20.0, 513.0, 3.0);
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(hit->z_m, 512.0 + 0.03 * 37.123, 1e-5);
}

TEST(RaySurface, RaysInAnyDirectionHitWhereGeometrySays) {
  road::Mesh mesh;
  mesh.origin_m = {691'234.5, 5'334'567.25, 512.0};
  add_square(mesh, 0, 0, 100, 0.0);
  add_square(mesh, 0, 0, 100, -3.0);  // behind the first
  const road::RaySurface surface(mesh);
  const double down_rad = 0.05, height_m = 1.5;
  const Eigen::Vector3d at = mesh.origin_m + Eigen::Vector3d(-20.0, 4.0, height_m);
  for (const double azimuth_rad : {0.0, 0.7, -1.2}) {
    const road::Ray ray{at,
                        {std::cos(down_rad) * std::cos(azimuth_rad),
                         std::cos(down_rad) * std::sin(azimuth_rad), -std::sin(down_rad)}};
    const auto hit = surface.first_hit(ray, 0.1, 60.0);
    ASSERT_TRUE(hit.has_value());
    EXPECT_NEAR(hit->range_m, height_m / std::sin(down_rad), 1e-4);
    EXPECT_NEAR(std::abs(hit->normal.z()), 1.0, 1e-6);
    EXPECT_FALSE(surface.first_hit(ray, 0.1, 20.0).has_value()) << "beyond its reach";
    const auto second = surface.first_hit(ray, 31.0, 100.0);
    ASSERT_TRUE(second.has_value());
    EXPECT_NEAR(second->range_m, (height_m + 3.0) / std::sin(down_rad), 2e-4);
  }
  EXPECT_FALSE(surface.first_hit({at, {0.0, 0.0, 1.0}}, 0.1, 60.0).has_value()) << "to the sky";
}

TEST(RaySurface, PacketsAnswerLikeSingleRaysAndLeaveInactiveLanesOut) {
  road::Mesh mesh;
  add_square(mesh, 0, 0, 5, 0.0, 0.1);
  const road::RaySurface surface(mesh);
  road::RayPacket16 packet{};
  for (std::size_t i = 0; i < 16; ++i) {
    packet.x_m[i] = static_cast<float>(i) - 6.0f - static_cast<float>(surface.origin_m().x());
    packet.y_m[i] = 1.0f - static_cast<float>(surface.origin_m().y());
    packet.z_top_m[i] = 2.0f;
    packet.active[i] = i == 8 ? 0 : -1;
  }
  surface.cast_down(packet);
  for (std::size_t i = 0; i < 16; ++i) {
    const auto single = surface.nearest_hit(static_cast<double>(i) - 6.0, 1.0, 0.0, 2.0);
    EXPECT_EQ(std::isnan(packet.z_m[i]), !single.has_value() || i == 8) << i;
    if (single && i != 8) {
      EXPECT_NEAR(packet.z_m[i], single->z_m, 1e-6) << i;
    }
  }
}

// Whatever width of packets the processor has: a lane that is left out must not be written.
TEST(RaySurface, LanesLeftOutAreNotCast) {
  road::Mesh mesh;
  add_square(mesh, 0, 0, 10, 0.0);
  const road::RaySurface surface(mesh);
  for (std::size_t active = 0; active <= 16; ++active) {
    road::RayPacket16 packet{};
    packet.z_top_m.fill(2.0f);
    for (std::size_t i = 0; i < 16; ++i) packet.active[i] = i < active ? -1 : 0;
    surface.cast_down(packet);
    for (std::size_t i = 0; i < 16; ++i)
      EXPECT_EQ(std::isnan(packet.z_m[i]), i >= active) << active << " active, lane " << i;
  }
}

TEST(RaySurface, AnEmptyMeshHasNoHits) {
  const road::RaySurface surface(road::Mesh{});
  EXPECT_TRUE(surface.all_hits(0, 0).empty());
  EXPECT_FALSE(surface.nearest_hit(0, 0, 0, 10).has_value());
}

}  // namespace ray_surface_test
