#include "support/street_scan.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

namespace support {
namespace {

struct Box {
  Eigen::Vector3d low, high;
};
struct Ball {
  Eigen::Vector3d middle;
  double radius;
};
struct Pole {
  double x, y, radius, height;
};

/// Distance along the ray, of length 1, to the nearest side of a box.
std::optional<double> hit(const Box& box, const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  double begin = 0.1, end = 1e9;
  for (int k = 0; k < 3; ++k) {
    const double a = (box.low[k] - from[k]) / ray[k], b = (box.high[k] - from[k]) / ray[k];
    begin = std::max(begin, std::min(a, b)), end = std::min(end, std::max(a, b));
  }
  return begin < end ? std::optional(begin) : std::nullopt;
}

std::optional<double> hit(const Pole& pole, const Eigen::Vector3d& from,
                          const Eigen::Vector3d& ray) {
  const double a = ray.x() * ray.x() + ray.y() * ray.y(), dx = from.x() - pole.x,
               dy = from.y() - pole.y, b = dx * ray.x() + dy * ray.y(),
               c = dx * dx + dy * dy - pole.radius * pole.radius, d = b * b - a * c;
  if (d < 0.0) return std::nullopt;
  const double t = (-b - std::sqrt(d)) / a, z = from.z() + t * ray.z();
  return t > 0.1 && z < pole.height ? std::optional(t) : std::nullopt;
}

std::optional<double> hit(const Ball& ball, const Eigen::Vector3d& from,
                          const Eigen::Vector3d& ray) {
  const Eigen::Vector3d d = from - ball.middle;
  const double b = d.dot(ray), c = d.squaredNorm() - ball.radius * ball.radius;
  if (b * b < c) return std::nullopt;
  const double t = -b - std::sqrt(b * b - c);
  return t > 0.1 ? std::optional(t) : std::nullopt;
}

}  // namespace

cloud::Cloud scan_street(const Eigen::Isometry3d& pose, std::uint32_t scene, std::uint32_t visit) {
  std::mt19937 street(scene), noise(1000 * scene + visit);
  const auto between = [](std::mt19937& generator, double a, double b) {
    return a + (b - a) * static_cast<double>(generator()) / 4294967296.0;
  };
  const auto normal = [&] {  // twelve uniform numbers: the same everywhere
    double sum = -6.0;
    for (int k = 0; k < 12; ++k) sum += between(noise, 0.0, 1.0);
    return sum;
  };
  std::vector<Box> boxes;
  std::vector<Pole> poles;
  std::vector<Ball> crowns;
  for (const double side : {-1.0, 1.0})
    for (double x = -60.0; x < 60.0;) {
      const double width = between(street, 6.0, 16.0), front = between(street, 7.0, 12.0),
                   depth = between(street, 6.0, 12.0), height = between(street, 4.0, 12.0);
      const double y0 = side > 0.0 ? front : -front - depth;
      boxes.push_back({{x, y0, -1.0}, {x + width, y0 + depth, height}});
      if (between(street, 0.0, 1.0) < 0.6)
        boxes.push_back({{x + 0.3 * width, side > 0.0 ? front - 1.2 : -front, -1.0},
                         {x + 0.6 * width, side > 0.0 ? front : -front + 1.2, 0.7 * height}});
      x += width + between(street, 0.0, 6.0);
    }
  for (int k = 0; k < 14; ++k)
    poles.push_back({between(street, -50.0, 50.0),
                     (k % 2 == 0 ? -1.0 : 1.0) * between(street, 5.0, 6.5),
                     between(street, 0.08, 0.25), between(street, 3.0, 8.0)});
  for (int k = 0; k < 8; ++k)
    crowns.push_back({{poles[static_cast<std::size_t>(k)].x, poles[static_cast<std::size_t>(k)].y,
                       between(street, 4.0, 6.0)},
                      between(street, 0.8, 1.8)});
  for (int k = 0; k < 8; ++k) {  // parked, half of them still there at another visit
    std::mt19937& generator = k < 4 ? street : noise;
    const double x = between(generator, -40.0, 40.0),
                 y = (k % 2 == 0 ? -1.0 : 1.0) * between(generator, 3.0, 4.0);
    boxes.push_back({{x, y - 0.9, 0.2}, {x + 4.3, y + 0.9, 1.4}});
  }
  cloud::Cloud cloud;
  const Eigen::Vector3d from = pose.translation();
  for (int beam = 0; beam < 64; ++beam)
    for (int shot = 0; shot < 900; ++shot) {
      const double up = (-24.0 + 34.0 * beam / 63.0) * std::numbers::pi / 180.0,
                   around = 2.0 * std::numbers::pi * (shot + between(noise, 0.0, 1.0)) / 900.0;
      const Eigen::Vector3d local(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around),
                                  std::sin(up));
      const Eigen::Vector3d ray = pose.linear() * local;
      // Ground: 1 % along, 2 % across to both sides.
      double best = 1e9;
      for (const double side : {-1.0, 1.0}) {
        const Eigen::Vector3d up_there(-0.01, 0.02 * side, 1.0);
        const double t = -up_there.dot(from) / up_there.dot(ray);
        if (t > 0.1 && (from.y() + t * ray.y()) * side >= 0.0) best = std::min(best, t);
      }
      const auto try_all = [&](const auto& things) {
        for (const auto& thing : things)
          if (const std::optional<double> t = hit(thing, from, ray)) best = std::min(best, *t);
      };
      try_all(boxes), try_all(poles);
      for (const Ball& crown : crowns)  // leaves: rays get into it
        if (const std::optional<double> t = hit(crown, from, ray))
          best = std::min(best, *t + between(noise, 0.0, 0.6 * crown.radius));
      if (best > 70.0) continue;
      if (between(noise, 0.0, 1.0) < 0.002) best *= between(noise, 0.1, 1.0);
      const Eigen::Vector3d p = local * (best + 0.015 * normal());
      cloud.x_m.push_back(p.x()), cloud.y_m.push_back(p.y()), cloud.z_m.push_back(p.z());
    }
  return cloud;
}

}  // namespace support
