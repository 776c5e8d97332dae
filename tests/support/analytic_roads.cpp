#include "support/analytic_roads.h"

#include <cmath>
#include <numbers>
#include <vector>

namespace support {
namespace {

constexpr double kPi = std::numbers::pi;

/// Quads between the lines u = us[i] (the last joins the first when closed) and v = vs[j].
void add_strip(AnalyticRoad& road, const char* object, const char* material,
               const std::vector<double>& us, const std::vector<double>& vs, bool closed) {
  const auto number = static_cast<std::uint32_t>(road.mesh.objects.size());
  const auto first = static_cast<std::uint32_t>(road.mesh.vertices_m.size());
  const auto columns = static_cast<std::uint32_t>(vs.size());
  const auto rows = static_cast<std::uint32_t>(us.size());
  road.mesh.objects.push_back({object, material, ""});
  for (const double u : us) {
    for (const double v : vs) {
      const crg::Point2 p = road.position_m(u, v);
      road.mesh.vertices_m.emplace_back(p.x_m, p.y_m, road.z_m(u, v));
    }
  }
  for (std::uint32_t i = 0; i < (closed ? rows : rows - 1); ++i) {
    for (std::uint32_t j = 0; j + 1 < columns; ++j) {
      const std::uint32_t a = first + i * columns + j;
      const std::uint32_t b = first + (i + 1) % rows * columns + j;
      road.mesh.triangles.push_back({a, b, b + 1});
      road.mesh.triangles.push_back({a, b + 1, a + 1});
      road.mesh.object_of_triangle.insert(road.mesh.object_of_triangle.end(), 2, number);
    }
  }
}

std::vector<double> steps(double begin, double end, double largest, bool with_end) {
  const int count = static_cast<int>(std::ceil((end - begin) / largest - 1e-9));
  std::vector<double> result;
  for (int i = 0; i < count + (with_end ? 1 : 0); ++i)
    result.push_back(begin + (end - begin) * i / count);
  return result;
}

}  // namespace

AnalyticRoad flat_straight(double length_m, double half_width_m, double height_m) {
  AnalyticRoad road;
  road.name = "flat_straight";
  road.length_m = length_m;
  road.half_width_m = half_width_m;
  road.z_m = [=](double, double) { return height_m; };
  road.position_m = [](double u, double v) { return crg::Point2{u, v}; };
  add_strip(road, "road", "asphalt", steps(0, length_m, 5, true),
            steps(-half_width_m, half_width_m, 2.5, true), false);
  return road;
}

AnalyticRoad banked_circle(double radius_m, double half_width_m, double banking, double facet_m) {
  AnalyticRoad road;
  road.name = "banked_circle";
  road.closed = true;
  road.length_m = 2 * kPi * radius_m;
  road.half_width_m = half_width_m;
  road.z_m = [=](double, double v) { return banking * v; };
  road.position_m = [=](double u, double v) {
    const double angle = u / radius_m;
    return crg::Point2{(radius_m - v) * std::cos(angle), (radius_m - v) * std::sin(angle)};
  };
  // A chord of the outer edge lies within its sagitta of the circle; the cone rises along that.
  const double outer_chord = facet_m * (radius_m + half_width_m) / radius_m;
  road.facet_error_m =
      std::abs(banking) * outer_chord * outer_chord / (8 * (radius_m - half_width_m));
  add_strip(road, "road", "asphalt", steps(0, road.length_m, facet_m, false),
            steps(-half_width_m, half_width_m, 2.0, true), true);
  return road;
}

AnalyticRoad wavy_straight(double length_m, double half_width_m, double amplitude_m,
                           double wavelength_m, double facet_m) {
  AnalyticRoad road;
  road.name = "wavy_straight";
  road.length_m = length_m;
  road.half_width_m = half_width_m;
  road.z_m = [=](double u, double) { return amplitude_m * std::sin(2 * kPi * u / wavelength_m); };
  road.position_m = [](double u, double v) { return crg::Point2{u, v}; };
  road.facet_error_m = amplitude_m * std::pow(2 * kPi / wavelength_m * facet_m, 2) / 8;
  add_strip(road, "road", "asphalt", steps(0, length_m, facet_m, true),
            steps(-half_width_m, half_width_m, 2.5, true), false);
  return road;
}

AnalyticRoad stadium_with_kerb(double straight_m, double radius_m, double half_width_m,
                               double kerb_height_m) {
  AnalyticRoad road;
  road.name = "stadium_with_kerb";
  road.closed = true;
  road.length_m = 2 * (straight_m + kPi * radius_m);
  road.half_width_m = half_width_m;
  road.z_m = [=](double u, double v) {
    const double t = v - half_width_m;
    if (u < 40.0 || u > 80.0 || t <= 0.0 || t >= 1.0) return 0.0;
    return kerb_height_m * (t < 0.9 ? t / 0.9 : (1.0 - t) / 0.1);
  };
  road.position_m = [=](double u, double v) {
    const double bend = kPi * radius_m;
    if (u < straight_m) return crg::Point2{u, v - radius_m};
    u -= straight_m;
    if (u < bend) {
      const double angle = u / radius_m;
      return crg::Point2{straight_m + (radius_m - v) * std::sin(angle),
                         -(radius_m - v) * std::cos(angle)};
    }
    u -= bend;
    if (u < straight_m) return crg::Point2{straight_m - u, radius_m - v};
    const double angle = (u - straight_m) / radius_m;
    return crg::Point2{-(radius_m - v) * std::sin(angle), (radius_m - v) * std::cos(angle)};
  };
  std::vector<double> us = steps(0, 40, 2, false);
  for (const double u : steps(40, 80, 2, false)) us.push_back(u);
  for (const double u : steps(80, straight_m, 2, false)) us.push_back(u);
  for (const double u : steps(straight_m, straight_m + kPi * radius_m, 1, false)) us.push_back(u);
  const double back = straight_m + kPi * radius_m;
  for (const double u : steps(back, back + straight_m, 2, false)) us.push_back(u);
  for (const double u : steps(back + straight_m, road.length_m, 1, false)) us.push_back(u);
  add_strip(road, "road", "asphalt", us, steps(-half_width_m, half_width_m, 2.5, true), true);
  add_strip(road, "kerb", "red white", steps(40, 80, 2, true),
            {half_width_m, half_width_m + 0.9, half_width_m + 1.0}, false);
  return road;
}

AnalyticRoad figure_eight(double height_m, double half_width_m, double facet_m) {
  constexpr double kA = 200.0;
  constexpr double kB = 100.0;
  AnalyticRoad road;
  road.name = "figure_eight";
  road.closed = true;
  road.half_width_m = half_width_m;
  constexpr int kPieces = 100000;  // midpoint rule on a smooth periodic function
  for (int i = 0; i < kPieces; ++i) {
    const double t = 2 * kPi * (i + 0.5) / kPieces;
    road.length_m += std::hypot(kA * std::cos(t), 2 * kB * std::cos(2 * t)) * 2 * kPi / kPieces;
  }
  const double length = road.length_m;
  road.z_m = [=](double u, double) {
    return 0.5 * height_m * (1 + std::cos(2 * kPi * u / length));
  };
  road.position_m = [=](double u, double v) {
    const double t = 2 * kPi * u / length;
    const double dx = kA * std::cos(t);
    const double dy = 2 * kB * std::cos(2 * t);
    const double norm = std::hypot(dx, dy);
    return crg::Point2{kA * std::sin(t) - v * dy / norm, kB * std::sin(2 * t) + v * dx / norm};
  };
  // u is not arc length, so facets lean against it; measured 0.25 mm with facets of 1 m.
  road.facet_error_m = 0.00026 * facet_m * facet_m;
  add_strip(road, "road", "asphalt", steps(0, length, facet_m, false),
            steps(-half_width_m, half_width_m, 2.5, true), true);
  return road;
}

}  // namespace support
