#include "vehicle/road.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <span>

namespace vehicle {
namespace {

/// Farther than this from the wheel, the answer may be the other level of a bridge.
constexpr double kOtherLevel_m = 1.5;

/// A car that left the lower road of a bridge is beside it as far as this from the grid.
constexpr double kBeside_m = 30.0;

/// Calls use(place) for every leg of the road on whose grid the point lies, or so far beside it.
template <class Use>
void each_leg(const crg::Surface& surface, double x_m, double y_m, double beside_m, Use&& use) {
  const crg::Grid& grid = surface.grid();
  const auto& v_m = grid.v_m;
  if (v_m.size() < 2) return;
  const double reach = std::max(std::abs(v_m.front()), std::abs(v_m.back())) + beside_m;
  constexpr double kStride_m = 4.0;
  const auto stride = static_cast<std::size_t>(std::max(1.0, kStride_m / grid.u_step_m));
  double last_u = -1e300;
  for (std::size_t i = 0; i < grid.rows(); i += stride) {
    // Not from reference_line(): a car that drives would wait until that is made.
    const crg::Point2 node = surface.xy_of_uv(grid.u_of(i), 0.0);
    if (std::hypot(x_m - node.x_m, y_m - node.y_m) > reach + kStride_m) continue;
    // The foot of the point on this leg, by steps along the line.
    double u = grid.u_of(i), v = 0.0;
    for (int k = 0; k < 30; ++k) {
      const crg::Point2 base = surface.xy_of_uv(u, 0.0), left = surface.xy_of_uv(u, 1.0);
      const double nx = left.x_m - base.x_m, ny = left.y_m - base.y_m;
      const double dx = x_m - base.x_m, dy = y_m - base.y_m;
      v = dx * nx + dy * ny;
      const double along = dx * ny - dy * nx;
      u += along;
      if (std::abs(along) < 1e-10) break;
    }
    if (std::abs(u - last_u) < 1e-6) continue;
    last_u = u;
    const crg::Point2 back = surface.xy_of_uv(u, v);
    if (!(std::hypot(back.x_m - x_m, back.y_m - y_m) < 1e-3)) continue;
    if (v < v_m.front() - beside_m || v > v_m.back() + beside_m) continue;
    use(crg::UV{u, v});
  }
}

constexpr float kNothing = -1e8f, kReach_m = 1.0f, kRounding_m = 1e-5f;
constexpr std::size_t kMostTogether = 16;  // lines; the last may be beside the strip

/// Lowest position of both cams over every line: they rest on the highest sample they reach, of
/// these rows and of those before. Samples far from the road under the wheel, `centre`, belong to
/// the other level of a bridge, whose edge the strip reaches; holes are not numbers. Neither lifts
/// anything.
void rest_cams_anywhere(const StripShape& shape, const Cams& cams, const float* dz,
                        crg::StripRows rows, float centre, float* front, float* rear) {
  using Floats [[gnu::vector_size(16)]] = float;
  const Floats nothing = kNothing - Floats{};
  for (std::size_t begin = 0; begin < shape.across; begin += sizeof(Floats) / sizeof(float)) {
    Floats highest_front, highest_rear;
    std::memcpy(&highest_front, front + begin, sizeof highest_front);
    std::memcpy(&highest_rear, rear + begin, sizeof highest_rear);
    for (std::size_t i = rows.begin; i < rows.end; ++i) {
      Floats row;
      std::memcpy(&row, dz + i * shape.across + begin, sizeof row);
      const Floats above = row - centre;
      const Floats z = ((above < kReach_m) & (above > -kReach_m)) ? row : nothing;
      const Floats f = z - cams.front[i], r = z - cams.rear[i];
      highest_front = f > highest_front ? f : highest_front;
      highest_rear = r > highest_rear ? r : highest_rear;
    }
    std::memcpy(front + begin, &highest_front, sizeof highest_front);
    std::memcpy(rear + begin, &highest_rear, sizeof highest_rear);
  }
}
#if defined(__x86_64__)
__attribute__((target("avx512f"))) void rest_cams_avx512(const StripShape& shape, const Cams& cams,
                                                         const float* dz, crg::StripRows rows,
                                                         float centre, float* front, float* rear) {
  const __m512 middle = _mm512_set1_ps(centre), above = _mm512_set1_ps(kReach_m),
               below = _mm512_set1_ps(-kReach_m);
  for (std::size_t begin = 0; begin < shape.across; begin += 16) {
    __m512 highest_front = _mm512_loadu_ps(front + begin),
           highest_rear = _mm512_loadu_ps(rear + begin);
    for (std::size_t i = rows.begin; i < rows.end; ++i) {
      const __m512 row = _mm512_loadu_ps(dz + i * shape.across + begin);
      const __m512 away = _mm512_sub_ps(row, middle);
      const __mmask16 near = _mm512_mask_cmp_ps_mask(_mm512_cmp_ps_mask(away, above, _CMP_LT_OQ),
                                                     away, below, _CMP_GT_OQ);
      const __m512 f = _mm512_sub_ps(row, _mm512_set1_ps(cams.front[i])),
                   r = _mm512_sub_ps(row, _mm512_set1_ps(cams.rear[i]));
      highest_front = _mm512_mask_max_ps(highest_front, near, f, highest_front);
      highest_rear = _mm512_mask_max_ps(highest_rear, near, r, highest_rear);
    }
    _mm512_storeu_ps(front + begin, highest_front);
    _mm512_storeu_ps(rear + begin, highest_rear);
  }
}
#endif

}  // namespace

RoadPoint Road::at(double x_m, double y_m, double z_near_m, std::size_t wheel,
                   RoadCursors& cursors) const noexcept {
  RoadPoint out;
  if (surface_ == nullptr) {
    out.z_m = slope_x_ * x_m + slope_y_ * y_m;
    out.dzdx = slope_x_;
    out.dzdy = slope_y_;
    out.u_m = x_m;
    out.v_m = y_m;
    return out;
  }
  crg::Ground sample = surface_->ground_at_xy(x_m, y_m, cursors.wheel[wheel]);
  if (std::abs(sample.z_m - z_near_m) > kOtherLevel_m || (!sample.valid && std::isfinite(z_near_m)))
    sample = other_leg(x_m, y_m, z_near_m, sample);
  if (!sample.valid) sample = over_seam(sample);
  if (!sample.valid)
    return beside_level(x_m, y_m, z_near_m, nearest_valid({sample.u_m, sample.v_m}));
  out.z_m = sample.z_m;
  out.dzdx = sample.dzdx;
  out.dzdy = sample.dzdy;
  out.u_m = sample.u_m;
  out.v_m = sample.v_m;
  // A closed road has no end: the millimetre between its last row and its first is road.
  const auto& v_m = surface_->grid().v_m;
  out.on_road = sample.inside ||
                (surface_->closed() && sample.v_m >= v_m.front() && sample.v_m <= v_m.back());
  out.friction = sample.friction;
  return beside_level(x_m, y_m, z_near_m, out);
}

bool Road::at_four(const std::array<crg::Point2, 4>& places, const std::array<double, 4>& z_near_m,
                   std::size_t wheel, const std::array<RoadCursors*, 4>& cursors,
                   std::array<RoadPoint*, 4> out) const noexcept {
  if (surface_ == nullptr) return false;
  crg::FourGrounds there;
  if (!surface_->ground_of_four(places,
                                {&cursors[0]->wheel[wheel], &cursors[1]->wheel[wheel],
                                 &cursors[2]->wheel[wheel], &cursors[3]->wheel[wheel]},
                                there))
    return false;
  for (std::size_t k = 0; k < 4; ++k)
    if (!(std::abs(there.z_m[k] - z_near_m[k]) <= kOtherLevel_m)) return false;
  for (std::size_t k = 0; k < 4; ++k)
    *out[k] = {there.z_m[k], there.dzdx[k], there.dzdy[k], there.friction,
               there.u_m[k], there.v_m[k],  true};
  return true;
}

std::array<double, 4> Road::heights_at(const std::array<crg::Point2, 4>& corners, double z_near_m,
                                       std::size_t wheel, RoadCursors& cursors) const noexcept {
  std::array<double, 4> z_m;
  if (surface_ != nullptr) surface_->z_at_xy(corners, cursors.corner[wheel], z_m);
  for (std::size_t k = 0; k < 4; ++k) {
    // On the grid at this level at() changes nothing.
    const double away = std::isfinite(z_near_m) ? std::abs(z_m[k] - z_near_m) : 0.0 * z_m[k];
    if (surface_ == nullptr || !(away <= kOtherLevel_m))
      z_m[k] = at(corners[k].x_m, corners[k].y_m, z_near_m, wheel, cursors).z_m;
  }
  return z_m;
}

RoadPoint Road::under_strip(double x_m, double y_m, double z_near_m, crg::Point2 heading,
                            const StripShape& shape, const Cams& cams, std::size_t wheel,
                            RoadCursors& cursors) const noexcept {
  RoadPoint point = at(x_m, y_m, z_near_m, wheel, cursors);
  if (surface_ == nullptr) return point;
  std::array<float, StripShape::kMostSamples + kMostTogether> dz;
  const std::span<float> samples(dz.data(), shape.along * shape.across);
  std::array<float, StripShape::kMostSamples + kMostTogether> front, rear;  // one per line
  std::fill_n(front.begin(), shape.across + kMostTogether, kNothing);
  std::fill_n(rear.begin(), shape.across + kMostTogether, kNothing);
  auto* rest_cams = rest_cams_anywhere;
#if defined(__x86_64__)
  if (crg::available(crg::StripKernel::Avx512)) rest_cams = rest_cams_avx512;
#endif
  // What lanes beside the last line read of the row behind the last.
  const auto pad = [&](std::size_t row) {
    std::fill_n(dz.begin() + static_cast<std::ptrdiff_t>(row * shape.across), kMostTogether, 0.0f);
  };
  float centre = 0.0f;
  const auto rest = [&](crg::StripRows rows) {
    rest_cams(shape, cams, dz.data(), rows, centre, front.data(), rear.data());
  };
  const crg::StripRows near{cams.near_begin, cams.near_end};
  crg::StripRows wanted = near;
  auto more = [&](double base_m, float before_m, float after_m) {
    centre = static_cast<float>(point.z_m - base_m);
    rest(near);
    const float lowest_front = *std::min_element(front.begin(), front.begin() + shape.across),
                lowest_rear = *std::min_element(rear.begin(), rear.begin() + shape.across);
    const auto lifts = [&](std::size_t row, float highest_m) {
      highest_m += kRounding_m;
      return highest_m - cams.front[row] > lowest_front || highest_m - cams.rear[row] > lowest_rear;
    };
    while (wanted.begin > 0 && lifts(wanted.begin - 1, before_m)) --wanted.begin;
    while (wanted.end < shape.along && lifts(wanted.end, after_m)) ++wanted.end;
    pad(wanted.end);
    return wanted;
  };
  crg::Strip strip;
  strip.x_m = x_m;
  strip.y_m = y_m;
  const double length = std::sqrt(heading.x_m * heading.x_m + heading.y_m * heading.y_m);
  const double c = heading.x_m / length, s = heading.y_m / length;
  strip.ahead = {c, s};
  strip.along = shape.along;
  strip.across = shape.across;
  strip.step_m = shape.step_m;
  pad(near.end);
  // Its own cursor: that of the point expects the wheel to go on.
  const double base_m =
      surface_->strip(strip, near, std::ref(more), samples, cursors.corner[wheel].front());
  if (!(std::abs(base_m - z_near_m) < 4.0 * kOtherLevel_m)) return point;
  rest({wanted.begin, near.begin});
  rest({near.end, wanted.end});
  double n = 0.0, height = 0.0, tilt = 0.0, sum_y = 0.0, sum_yy = 0.0, sum_yz = 0.0;
  const double middle = 0.5 * static_cast<double>(shape.across - 1);
  for (std::size_t j = 0; j < shape.across; ++j) {
    if (!(front[j] > 0.5f * kNothing) || !(rear[j] > 0.5f * kNothing)) continue;
    const double y = (static_cast<double>(j) - middle) * shape.step_m;
    const double z = 0.5 * (static_cast<double>(front[j]) + static_cast<double>(rear[j]));
    n += 1.0;
    height += z;
    tilt += static_cast<double>(front[j]) - static_cast<double>(rear[j]);
    sum_y += y;
    sum_yy += y * y;
    sum_yz += y * z;
  }
  if (n < 2.0) return point;
  const double along = tilt / (n * cams.distance_m);
  const double spread = sum_yy - sum_y * sum_y / n;
  const double across = spread > 0.0 ? (sum_yz - sum_y * height / n) / spread : 0.0;
  const double z_m = base_m + height / n - across * sum_y / n;
  if (std::abs(z_m - point.z_m) > kOtherLevel_m) return point;
  point.z_m = z_m;
  point.dzdx = along * c - across * s;
  point.dzdy = along * s + across * c;
  return point;
}

crg::Ground Road::other_leg(double x_m, double y_m, double z_near_m,
                            const crg::Ground& first) const noexcept {
  crg::Ground best = first;
  // Beside the road or over a hole, only a leg at this height; not one that passes far above.
  double distance = first.valid ? std::abs(first.z_m - z_near_m) : kOtherLevel_m;
  each_leg(*surface_, x_m, y_m, 0.0, [&](const crg::UV& place) {
    const crg::Ground sample(surface_->at_uv(place.u_m, place.v_m));
    if (!sample.valid || !sample.inside) return;
    const double away = std::abs(sample.z_m - z_near_m);
    if (away < distance) {
      distance = away;
      best = sample;
    }
  });
  return best;
}

/// A closed road has no end: what lies between its last row and its first has the height of the
/// nearer one.
crg::Ground Road::over_seam(const crg::Ground& gap) const noexcept {
  if (!surface_->closed()) return gap;
  const crg::Grid& grid = surface_->grid();
  const double u_m = std::clamp(gap.u_m, grid.u_begin_m, grid.u_of(grid.rows() - 1));
  if (u_m == gap.u_m || std::abs(u_m - gap.u_m) > grid.u_step_m) return gap;
  return crg::Ground(surface_->at_uv(u_m, gap.v_m));
}

RoadPoint Road::nearest_valid(const crg::UV& hole) const noexcept {
  RoadPoint out;
  out.on_road = false;
  out.u_m = hole.u_m;
  out.v_m = hole.v_m;
  out.z_m = std::numeric_limits<double>::quiet_NaN();
  const auto& v_m = surface_->grid().v_m;
  if (v_m.size() < 2 || !std::isfinite(hole.u_m)) return out;
  const double step = (v_m.back() - v_m.front()) / static_cast<double>(v_m.size() - 1);
  const double start = std::clamp(hole.v_m, v_m.front(), v_m.back());
  for (std::size_t i = 0; i < v_m.size(); ++i) {
    for (const double side : {-1.0, 1.0}) {
      const double v = start + side * static_cast<double>(i) * step;
      const double z = surface_->z_at_uv(hole.u_m, v);
      if (std::isfinite(z)) {
        out.z_m = z;
        return out;
      }
    }
  }
  return out;
}

/// `best`, or the height beside another leg that is nearer to this level: under a bridge, off the
/// road.
RoadPoint Road::beside_level(double x_m, double y_m, double z_near_m,
                             RoadPoint best) const noexcept {
  const auto away_m = [&](const RoadPoint& point) {
    const double away = std::abs(point.z_m - z_near_m);
    return std::isfinite(away) ? away : std::numeric_limits<double>::infinity();
  };
  // On the road and in the air over it, no other leg is meant.
  if (!std::isfinite(z_near_m) || away_m(best) <= kOtherLevel_m ||
      (best.on_road && best.z_m < z_near_m))
    return best;
  each_leg(*surface_, x_m, y_m, kBeside_m, [&](const crg::UV& place) {
    const RoadPoint point = nearest_valid(place);
    if (away_m(point) <= kOtherLevel_m && away_m(point) < away_m(best)) best = point;
  });
  return best;
}

crg::UV RoadTracker::at(double x_m, double y_m, double z_near_m) {
  const crg::Grid& grid = surface_->grid();
  const double length_m = grid.u_step_m * static_cast<double>(grid.rows() - 1);
  crg::UV best = surface_->uv_of_xy(x_m, y_m, cursor_);
  if (!std::isfinite(best.u_m)) return best;
  // A car gets no further along the road than it moves, inside a bend somewhat.
  const double reach_m = 2.0 * std::hypot(x_m - last_.x_m, y_m - last_.y_m) + 3.0;
  const auto gone = [&](const crg::UV& place) {
    const double du = place.u_m - last_.u_m;
    return std::abs(surface_->closed() ? std::remainder(du, length_m) : du);
  };
  const bool known = std::isfinite(last_.u_m);
  if (!known || gone(best) > reach_m) {
    // By history, else by height, else as the surface answers.
    double least = std::numeric_limits<double>::infinity(), least_away = least;
    crg::UV nearest = best, level = best;
    each_leg(*surface_, x_m, y_m, 0.0, [&](const crg::UV& place) {
      if (known && gone(place) < least) {
        least = gone(place);
        nearest = place;
      }
      const double away = std::abs(surface_->z_at_uv(place.u_m, place.v_m) - z_near_m);
      if (away < least_away) {
        least_away = away;
        level = place;
      }
    });
    best = least <= reach_m ? nearest : level;
  }
  last_ = {best.u_m, best.v_m, x_m, y_m};
  return best;
}

}  // namespace vehicle
