#include "start_of_line.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "border_curve.h"
#include "stations.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDrawIn_m = 0.02;   // an end goes in by this at a time, and this much further
constexpr double kNearlyAll = 0.98;  // of the width has to have surface at an end

/// The begin of a line, drawn in to where the road has surface from edge to edge.
void draw_in_begin(const RaySurface& surface, std::vector<Vector3d>& points,
                   std::vector<double>& half_width_m) {
  const Vector2d first = (points[1] - points[0]).head<2>(),
                 next = (points[2] - points[1]).head<2>();
  const double half_m = half_width_m[0];
  // The line's direction at its very end, half a chord before the first chord's middle.
  const double bend_rad = angle_between(first, next) * first.norm() / (first.norm() + next.norm());
  const Vector2d ahead = (Eigen::Rotation2Dd(-bend_rad) * first).normalized();
  const Vector2d across = kNearlyAll * half_m * left_of(ahead);
  const auto hit = [&](const Vector2d& at) {
    return surface.nearest_hit(at.x(), at.y(), points[0].z(), kLayerReach_m);
  };
  double in_m = 0.0;
  while (in_m < half_m) {
    const Vector2d at = points[0].head<2>() + in_m * ahead;
    if (hit(at) && hit(at + across) && hit(at - across)) break;
    in_m += kDrawIn_m;
  }
  if (in_m == 0.0 || in_m >= half_m) return;
  const Vector2d at = points[0].head<2>() + (in_m + kDrawIn_m) * ahead;
  while (points.size() > 4 && (points[1].head<2>() - at).dot(ahead) < 0.25 * first.norm()) {
    points.erase(points.begin());
    half_width_m.erase(half_width_m.begin());
  }
  const auto there = hit(at);
  points[0] = Vector3d(at.x(), at.y(), there ? there->z_m : points[0].z());
}

}  // namespace

std::size_t middle_of_longest_straight(const std::vector<Vector3d>& points) {
  const std::size_t n = points.size();
  const auto xy = [&](std::size_t i) -> Vector2d { return points[i % n].head<2>(); };
  std::size_t best_begin = 0, best_end = 0;
  double best_m = -1.0;
  std::size_t end = 1;
  double length_m = (xy(1) - xy(0)).norm();
  for (std::size_t begin = 0; begin < n; ++begin) {
    if (end <= begin) {
      end = begin + 1;
      length_m = (xy(end) - xy(begin)).norm();
    }
    const Vector2d first = xy(begin + 1) - xy(begin);
    while (end - begin < n - 1 && std::abs(angle_between(first, xy(end + 1) - xy(end))) < 0.05) {
      length_m += (xy(end + 1) - xy(end)).norm();
      ++end;
    }
    if (length_m > best_m + 1e-6) {
      best_m = length_m;
      best_begin = begin;
      best_end = end;
    }
    length_m -= (xy(begin + 1) - xy(begin)).norm();
  }
  // The station nearest to half of the stretch.
  double half_m = 0.5 * best_m;
  std::size_t i = best_begin;
  while (i + 1 < best_end && half_m > (xy(i + 1) - xy(i)).norm())
    half_m -= (xy(i + 1) - xy(i)).norm(), ++i;
  return i % n;
}

void rotate_to(Centreline& line, std::size_t first) {
  const auto offset = static_cast<std::ptrdiff_t>(first);
  std::rotate(line.points_m.begin(), line.points_m.begin() + offset, line.points_m.end());
  std::rotate(line.half_width_m.begin(), line.half_width_m.begin() + offset,
              line.half_width_m.end());
}

void draw_in_ends(const RaySurface& surface, Centreline& line) {
  for (int end = 0; end < 2; ++end) {
    draw_in_begin(surface, line.points_m, line.half_width_m);
    std::reverse(line.points_m.begin(), line.points_m.end());
    std::reverse(line.half_width_m.begin(), line.half_width_m.end());
  }
}

void start_at(Centreline& line, const Vector2d& p) {
  const BorderCurve curve = curve_through(line.points_m, line.closed);
  double best_m = std::numeric_limits<double>::infinity();
  std::size_t segment = 0;
  double share = 0.0;
  for (std::size_t i = 0; i < curve.segments(); ++i) {
    for (int k = 0; k <= 16; ++k) {
      const double d = (curve.at(i, k / 16.0).first.head<2>() - p).norm();
      if (d < best_m) {
        best_m = d;
        segment = i;
        share = k / 16.0;
      }
    }
  }
  double lo = std::max(0.0, share - 1.0 / 16), hi = std::min(1.0, share + 1.0 / 16);
  for (int k = 0; k < 60; ++k) {
    const double a = lo + (hi - lo) / 3, b = hi - (hi - lo) / 3;
    if ((curve.at(segment, a).first.head<2>() - p).norm() <
        (curve.at(segment, b).first.head<2>() - p).norm()) {
      hi = b;
    } else {
      lo = a;
    }
  }
  share = 0.5 * (lo + hi);
  const std::size_t next = curve.next(segment);
  const double length_m = (line.points_m[next] - line.points_m[segment]).head<2>().norm();
  std::size_t first = share < 0.5 ? segment : next;
  if (std::min(share, 1.0 - share) * length_m > 0.5) {
    const Vector3d point = curve.at(segment, share).first;
    const double half_m =
        line.half_width_m[segment] + share * (line.half_width_m[next] - line.half_width_m[segment]);
    first = segment + 1;
    line.points_m.insert(line.points_m.begin() + static_cast<std::ptrdiff_t>(first), point);
    line.half_width_m.insert(line.half_width_m.begin() + static_cast<std::ptrdiff_t>(first),
                             half_m);
  } else {
    line.points_m[first] = curve.at(segment, share).first;
  }
  rotate_to(line, first);
}

}  // namespace road
