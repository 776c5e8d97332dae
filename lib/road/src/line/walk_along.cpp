#include "walk_along.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "base/statistics.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Lengths along a way to its points, and of all of it.
std::vector<double> lengths_along(const std::vector<Vector3d>& points_m, bool closed) {
  std::vector<double> s_m{0.0};
  for (std::size_t i = 1; i < points_m.size() + (closed ? 1 : 0); ++i)
    s_m.push_back(s_m.back() + (points_m[i % points_m.size()] - points_m[i - 1]).head<2>().norm());
  return s_m;
}

/// Half the width that a way has at `count` evenly spaced places of it.
std::vector<double> half_widths_along(const RoadWay& way, std::size_t count) {
  const std::vector<double> s_m = lengths_along(way.points_m, way.closed);
  std::vector<double> out;
  std::size_t i = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double at_m =
        s_m.back() * static_cast<double>(k) / static_cast<double>(way.closed ? count : count - 1);
    while (i + 2 < s_m.size() && s_m[i + 1] < at_m) ++i;
    const double t = std::clamp((at_m - s_m[i]) / std::max(s_m[i + 1] - s_m[i], 1e-9), 0.0, 1.0);
    out.push_back((1.0 - t) * way.half_width_m[i] +
                  t * way.half_width_m[(i + 1) % way.half_width_m.size()]);
  }
  return out;
}

/// Places along a way, evenly spaced and smoothed over half the road's width; the ends of an open
/// way stay.
std::vector<Vector3d> smoothed(const std::vector<Vector3d>& points_m, bool closed, double spacing_m,
                               double sigma_m) {
  const std::size_t n = points_m.size();
  const std::vector<double> s_m = lengths_along(points_m, closed);
  const double length_m = s_m.back();
  const auto count = std::max<std::size_t>(
      closed ? 8 : 4, static_cast<std::size_t>(std::lround(length_m / spacing_m)));
  std::vector<Vector3d> out;
  const std::ptrdiff_t size = static_cast<std::ptrdiff_t>(n);
  std::ptrdiff_t low = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double at_m =
        length_m * static_cast<double>(k) / static_cast<double>(closed ? count : count - 1);
    // Towards the ends of an open way the window shrinks, so that it stays symmetric.
    const double reach_m =
        closed ? 3.0 * sigma_m : std::min({3.0 * sigma_m, at_m, length_m - at_m}) + 1e-9;
    const double width_m = reach_m / 3.0;
    const auto s_of = [&](std::ptrdiff_t i) {  // any number of rounds of a ring
      const std::ptrdiff_t round = i >= 0 ? i / size : -((size - 1 - i) / size);
      return s_m[static_cast<std::size_t>(i - round * size)] +
             static_cast<double>(round) * length_m;
    };
    const auto point_of = [&](std::ptrdiff_t i) {
      return points_m[static_cast<std::size_t>(((i % size) + size) % size)];
    };
    while ((closed || low > 0) && s_of(low) > at_m - reach_m) --low;
    while ((closed || low + 1 < size) && s_of(low) < at_m - reach_m) ++low;
    Vector3d sum = Vector3d::Zero();
    double weight = 0.0;
    for (std::ptrdiff_t i = low; (closed || i < size) && s_of(i) <= at_m + reach_m; ++i) {
      const double x = (s_of(i) - at_m) / std::max(width_m, 1e-9);
      const double w = std::exp(-0.5 * x * x);
      sum += w * point_of(i);
      weight += w;
    }
    if (weight > 0.0) {
      out.push_back(sum / weight);
    } else {  // between two places that are far apart: a gap
      std::ptrdiff_t i = low;
      while ((closed || i + 2 < size) && s_of(i + 1) < at_m) ++i;
      const double t =
          std::clamp((at_m - s_of(i)) / std::max(s_of(i + 1) - s_of(i), 1e-9), 0.0, 1.0);
      out.push_back((1.0 - t) * point_of(i) + t * point_of(i + 1));
    }
  }
  return out;
}

/// Middle value of the places within `reach` of i, of those that are numbers.
double running_median(const std::vector<double>& values, std::size_t i, std::size_t reach,
                      bool closed) {
  const std::size_t n = values.size();
  std::vector<double> window;
  for (std::size_t k = 0; k <= 2 * reach; ++k) {
    const std::ptrdiff_t at =
        static_cast<std::ptrdiff_t>(i + k) - static_cast<std::ptrdiff_t>(reach);
    if (!closed && (at < 0 || at >= static_cast<std::ptrdiff_t>(n))) continue;
    const double value = values[static_cast<std::size_t>((at + static_cast<std::ptrdiff_t>(n)) %
                                                         static_cast<std::ptrdiff_t>(n))];
    if (std::isfinite(value)) window.push_back(value);
  }
  if (window.empty()) return std::numeric_limits<double>::quiet_NaN();
  return base::median(std::move(window));
}

/// An open road ends where its surface ends.
void add_ends(const RaySurface& surface, Walk& walk) {
  for (const bool front : {true, false}) {
    const Station& last = front ? walk.stations.front() : walk.stations.back();
    const Vector2d direction = front ? Vector2d(-last.heading) : last.heading;
    const Vector3d end = find_edge(surface, last.centre, direction, kGapAlong_m);
    if ((end - last.centre).head<2>().norm() <= 0.1) continue;
    Station extra = last;
    extra.centre += end - last.centre;
    extra.left += end - last.centre;
    extra.right += end - last.centre;
    walk.stations.insert(front ? walk.stations.begin() : walk.stations.end(), extra);
  }
}

}  // namespace

Walk walk_along(const RaySurface& surface, const RoadWay& way, bool to_the_end, bool knows_widths) {
  const double typical_m = base::median(way.half_width_m);  // half the width
  const double step_m = std::clamp(typical_m / 2.5, 0.5, 2.0);
  Walk walk;
  walk.closed = way.closed;
  std::vector<Vector3d> middle = smoothed(way.points_m, way.closed, step_m, 0.5 * typical_m);
  const std::size_t n = middle.size();
  const std::vector<double> way_half_m =
      knows_widths ? half_widths_along(way, n) : std::vector<double>();
  const auto reach = static_cast<std::size_t>(std::ceil(5.0 * typical_m / step_m));
  for (int round = 0; round < 3; ++round) {
    const auto at = [&](std::ptrdiff_t i) -> const Vector3d& {
      const auto size = static_cast<std::ptrdiff_t>(n);
      return middle[static_cast<std::size_t>(
          way.closed ? (i + size) % size : std::clamp<std::ptrdiff_t>(i, 0, size - 1))];
    };
    std::vector<Station> stations(n);
    std::vector<double> left_m(n), right_m(n), half_m(n);
    for (std::size_t i = 0; i < n; ++i) {
      const auto k = static_cast<std::ptrdiff_t>(i);
      const Vector2d heading = (at(k + 1) - at(k - 1)).head<2>().normalized(),
                     normal = left_of(heading);
      const auto hit =
          surface.nearest_hit(middle[i].x(), middle[i].y(), middle[i].z(), 2.0 * kLayerReach_m);
      left_m[i] = right_m[i] = half_m[i] = std::numeric_limits<double>::quiet_NaN();
      stations[i].heading = heading;
      if (!hit) continue;
      const double limit_m = 2.0 * typical_m + 4.0;
      stations[i] = cross_section(surface, {middle[i].x(), middle[i].y(), hit->z_m}, heading,
                                  limit_m, limit_m);
      left_m[i] = (stations[i].left - middle[i]).head<2>().dot(normal);
      right_m[i] = -(stations[i].right - middle[i]).head<2>().dot(normal);
      half_m[i] = 0.5 * (left_m[i] + right_m[i]);
    }
    walk.stations.clear();
    std::vector<Vector3d> next(n);
    for (std::size_t i = 0; i < n; ++i) {
      const auto usual = [&](const std::vector<double>& values) {
        if (knows_widths) return way_half_m[i];
        const double value_m = running_median(values, i, reach, way.closed);
        return std::isfinite(value_m) ? value_m : typical_m;
      };
      const double half = usual(half_m);
      const Vector2d normal = left_of(stations[i].heading);
      const bool known = std::isfinite(half_m[i]);
      double left = half, right = half;
      if (known && std::abs(half_m[i] - half) < 0.1 * half + 0.1) {
        left = left_m[i], right = right_m[i];
      } else if (known) {
        const double left_off_m = std::abs(left_m[i] - usual(left_m)),
                     right_off_m = std::abs(right_m[i] - usual(right_m));
        if (std::min(left_off_m, right_off_m) < 0.3 * half + 0.3) {
          if (left_off_m < right_off_m) {
            left = left_m[i], right = 2.0 * half - left;
          } else {
            right = right_m[i], left = 2.0 * half - right;
          }
        }
      }
      Station& station = stations[i];
      const Vector2d p = middle[i].head<2>();
      const double z_m = known ? station.centre.z() : middle[i].z();
      station.left << p + left * normal, known ? station.left.z() : z_m;
      station.right << p - right * normal, known ? station.right.z() : z_m;
      station.centre << 0.5 * (station.left + station.right).head<2>(), z_m;
      next[i] = station.centre;
    }
    walk.stations = std::move(stations);
    if (round < 2) middle = smoothed(next, way.closed, step_m, step_m);
    if (middle.size() != n) break;
  }
  if (!walk.closed && to_the_end) add_ends(surface, walk);
  measure(walk);
  return walk;
}

}  // namespace road
