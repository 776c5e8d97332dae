#include "guide_rows.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "base/parallel.h"
#include "base/statistics.h"
#include "road_graph.h"
#include "stations.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kUsualReach_m =
    30.0;  // to both sides; lengths below are for this reach and shrink with it
constexpr double kReachShare =
    0.025;  // of the guide's length: a circuit has no room for wider roads,
constexpr double kReachShareOpen = 0.1;  // a piece of a road has
constexpr double kSmallestReach_m = 1.0;
constexpr double kRowsPerReach = 15.0, kRaysPerReach = 60.0;
constexpr double kBeside = 0.25;  // of the reach: how far the guide may lie beside the road
constexpr double kHeadroom_m = 1.8;
constexpr double kBetweenLayers_m = 0.7;
constexpr double kLayer_m = 1.0;
constexpr double kGapAcross_m = 1.0;  // painted lines, cracks
constexpr double kStep_m = 0.15;      // up or down between two rays, besides the slope
constexpr double kSteepest = 0.6, kCrease = 0.35;
// What a layer costs, for each row.
constexpr double kMissing = 4.0, kOtherLook = 3.5, kNarrow = 1.5, kPerMetre = 2.0,
                 kPerMetreOfGuide = 0.3, kMostOfGuide = 5.0;
constexpr double kSlopeFree = 0.2;
constexpr std::size_t kAround = 12;  // rows to both sides that tell what is usual
constexpr std::size_t kFarAround =
    100;                             // and what is usual where a wide place is longer than those
constexpr std::ptrdiff_t kNear = 6;  // rows to both sides: their middles lie on one line,
constexpr double kJump = 0.3;        // of half the width beside it at most
constexpr double kWide = 1.2, kNotWide = 1.1, kFullyWide = 0.9;
constexpr double kQuiet = 0.3;  // of a widening on the side where the road goes on as before

/// Points on the centripetal Catmull-Rom curve through the guide (Yuksel et al. 2011), evenly
/// spaced; z is linear in between.
std::vector<Vector3d> resampled(const Guide& guide, double step_m) {
  const std::vector<Vector3d>& p = guide.points_m;
  const auto n = static_cast<std::ptrdiff_t>(p.size());
  const auto at = [&](std::ptrdiff_t i) -> Vector2d {
    if (guide.closed) return p[static_cast<std::size_t>((i % n + n) % n)].head<2>();
    if (i < 0) return 2.0 * p[0].head<2>() - p[1].head<2>();
    if (i >= n)
      return 2.0 * p[static_cast<std::size_t>(n - 1)].head<2>() -
             p[static_cast<std::size_t>(n - 2)].head<2>();
    return p[static_cast<std::size_t>(i)].head<2>();
  };
  std::vector<Vector3d> fine;
  for (std::ptrdiff_t i = 0; i < (guide.closed ? n : n - 1); ++i) {
    const Vector2d a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
    const double ab = std::sqrt(std::max((b - a).norm(), 1e-9)),
                 bc = std::sqrt(std::max((c - b).norm(), 1e-9)),
                 cd = std::sqrt(std::max((d - c).norm(), 1e-9));
    const double zb = p[static_cast<std::size_t>(i)].z(),
                 zc = p[static_cast<std::size_t>((i + 1) % n)].z();
    const auto pieces =
        static_cast<int>(std::clamp((c - b).norm() / step_m * 4.0, 1.0, 100000.0)) + 1;
    for (int k = 0; k < pieces; ++k) {
      const double t = ab + bc * k / pieces;
      const Vector2d a1 = (ab - t) / ab * a + t / ab * b,
                     a2 = (ab + bc - t) / bc * b + (t - ab) / bc * c,
                     a3 = (ab + bc + cd - t) / cd * c + (t - ab - bc) / cd * d;
      const Vector2d b1 = (ab + bc - t) / (ab + bc) * a1 + t / (ab + bc) * a2,
                     b2 = (ab + bc + cd - t) / (bc + cd) * a2 + (t - ab) / (bc + cd) * a3;
      const Vector2d q = (ab + bc - t) / bc * b1 + (t - ab) / bc * b2;
      fine.emplace_back(q.x(), q.y(), zb + (zc - zb) * k / pieces);
    }
  }
  fine.push_back(guide.closed ? fine.front() : p.back());
  std::vector<double> s_m{0.0};
  for (std::size_t i = 1; i < fine.size(); ++i)
    s_m.push_back(s_m.back() + (fine[i] - fine[i - 1]).head<2>().norm());
  const auto count =
      std::max<std::size_t>(4, static_cast<std::size_t>(std::lround(s_m.back() / step_m)));
  std::vector<Vector3d> even;
  std::size_t k = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double here_m =
        s_m.back() * static_cast<double>(i) / static_cast<double>(guide.closed ? count : count - 1);
    while (k + 2 < s_m.size() && s_m[k + 1] < here_m) ++k;
    const double t = std::clamp((here_m - s_m[k]) / std::max(s_m[k + 1] - s_m[k], 1e-12), 0.0, 1.0);
    even.push_back(fine[k] + t * (fine[k + 1] - fine[k]));
  }
  return even;
}

struct Layer {
  double z_m = 0.0, cost = 0.0;
};

/// Layers of the surface near one row, each with what speaks against it.
std::vector<Layer> layers_at(const GuideRow& row, const GuideRows& all, double scale,
                             const RaySurface& surface, const LooksLikeRoad& looks_like_road) {
  struct Hit {
    double z_m, beside_m;
    bool looks;
  };
  std::vector<Hit> hits;
  constexpr int kOffsets = 5;
  for (int k = -kOffsets; k <= kOffsets; ++k) {
    const double offset_m = kBeside * all.reach_m * k / kOffsets;
    const Vector2d p = row.at_m + offset_m * left_of(row.heading);
    double roof_m = std::numeric_limits<double>::infinity();
    for (const SurfaceHit& hit : surface.all_hits(p.x(), p.y())) {  // from high to low
      const double room_m = roof_m - hit.z_m;
      if (room_m > 0.05 * scale && room_m < kHeadroom_m * scale) continue;
      roof_m = hit.z_m;
      hits.push_back({hit.z_m, std::abs(offset_m), looks_like_road(hit.triangle)});
    }
  }
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.z_m < b.z_m; });
  std::vector<Layer> layers;
  for (std::size_t i = 0, j = 0; i < hits.size(); i = j) {
    double looks = 0.0;
    std::size_t nearest = i;
    for (j = i;
         j < hits.size() && (j == i || hits[j].z_m - hits[j - 1].z_m < kBetweenLayers_m * scale);
         ++j) {
      looks += hits[j].looks ? 1.0 : 0.0;
      if (hits[j].beside_m < hits[nearest].beside_m || (hits[j].looks && !hits[nearest].looks))
        nearest = j;
    }
    const double share = std::min(1.0, static_cast<double>(j - i) / (2 * kOffsets + 1));
    layers.push_back(
        {hits[nearest].z_m,
         kNarrow * (1.0 - share) + kOtherLook * (1.0 - looks / static_cast<double>(j - i))});
  }
  return layers;
}

/// The cheapest way through the layers of all rows; NaN where it is best to have none.
std::vector<double> best_layers(const std::vector<std::vector<Layer>>& layers, double step_m,
                                double scale) {
  const std::size_t n = layers.size();
  std::vector<std::vector<double>> cost(n);
  std::vector<std::vector<std::size_t>> from(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t states = layers[i].size() + 1;  // the last: none
    cost[i].assign(states, std::numeric_limits<double>::infinity());
    from[i].assign(states, 0);
    for (std::size_t k = 0; k < states; ++k) {
      const double own = k + 1 == states ? kMissing : layers[i][k].cost;
      if (i == 0) {
        cost[i][k] = own;
        continue;
      }
      for (std::size_t j = 0; j < cost[i - 1].size(); ++j) {
        double change = 0.0;
        if (k + 1 < states && j + 1 < cost[i - 1].size())
          change = kPerMetre *
                   std::max(0.0, std::abs(layers[i][k].z_m - layers[i - 1][j].z_m) -
                                     kSlopeFree * step_m) /
                   scale;
        if (cost[i - 1][j] + change + own < cost[i][k])
          cost[i][k] = cost[i - 1][j] + change + own, from[i][k] = j;
      }
    }
  }
  std::vector<double> z_m(n, std::numeric_limits<double>::quiet_NaN());
  std::size_t k = static_cast<std::size_t>(
      std::min_element(cost[n - 1].begin(), cost[n - 1].end()) - cost[n - 1].begin());
  for (std::size_t i = n; i-- > 0;) {
    if (k < layers[i].size()) z_m[i] = layers[i][k].z_m;
    k = from[i][k];
  }
  return z_m;
}

/// Fills what is NaN from the nearest known values on both sides; all zero where nothing is known.
void fill_between(std::vector<double>& values, bool closed) {
  const std::size_t n = values.size();
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < n; ++i)
    if (std::isfinite(values[i])) known.push_back(i);
  if (known.empty()) return void(std::fill(values.begin(), values.end(), 0.0));
  const std::vector<double> old = values;
  for (std::size_t i = 0; i < n; ++i) {
    if (std::isfinite(old[i])) continue;
    const auto after = std::upper_bound(known.begin(), known.end(), i);
    const bool has_after = after != known.end(), has_before = after != known.begin();
    if (!closed && !(has_after && has_before)) {
      values[i] = old[has_after ? *after : known.back()];
      continue;
    }
    const std::size_t b = has_after ? *after : known.front(),
                      a = has_before ? *(after - 1) : known.back();
    const auto forward = static_cast<double>((i + n - a) % n),
               span = static_cast<double>((b + n - a) % n);
    values[i] = span > 0.0 ? old[a] + (old[b] - old[a]) * forward / span : old[a];
  }
}

/// From `from_m` (offset) outwards: how far the road goes on.
struct Side {
  double offset_m = 0.0;
  bool ends = false;
};
Side side_of(const GuideRow& row, const GuideRows& all, double scale, const RaySurface& surface,
             const LooksLikeRoad& looks_like_road, double from_m, double from_z_m, double sign) {
  const Vector2d normal = left_of(row.heading);
  Side side{from_m, false};
  double z_m = from_z_m, slope = 0.0;
  bool has_slope = false;
  for (double offset_m = from_m + sign * all.across_m; std::abs(offset_m) <= all.reach_m;
       offset_m += sign * all.across_m) {
    const double out_m = std::abs(offset_m - side.offset_m);
    const Vector2d p = row.at_m + offset_m * normal;
    const auto hit = surface.nearest_hit(p.x(), p.y(), z_m + slope * out_m, kLayer_m * scale);
    bool goes_on = hit && looks_like_road(hit->triangle);
    if (goes_on) {
      const double steep = (hit->z_m - z_m) / out_m;
      const double step_m = std::abs(hit->z_m - z_m - slope * out_m);
      const bool steps = step_m > kStep_m * scale + (has_slope ? kCrease : kSteepest) * out_m;
      goes_on = !steps && std::abs(steep) < kSteepest;
      if (!goes_on) {
        side.ends = true;
        return side;
      }
      slope = has_slope ? 0.7 * slope + 0.3 * steep : steep;
      has_slope = true;
      side.offset_m = offset_m;
      z_m = hit->z_m;
    } else if (out_m > kGapAcross_m * scale) {
      side.ends = true;
      return side;
    }
  }
  return side;
}

/// Sides of one row, from the place nearest to the guide that is road; none there: no surface.
void measure(GuideRow& row, const GuideRows& all, double scale, const RaySurface& surface,
             const LooksLikeRoad& looks_like_road) {
  if (!row.has_surface) return;
  const Vector2d normal = left_of(row.heading);
  const int most = static_cast<int>(kBeside * all.reach_m / all.across_m);
  for (int k = 0; k <= 2 * most; ++k) {
    const int steps = (k + 1) / 2;  // 0, -1, 1, -2, 2, ...
    const double offset_m = all.across_m * steps * (k % 2 == 0 ? 1.0 : -1.0);
    const Vector2d p = row.at_m + offset_m * normal;
    const auto hit = surface.nearest_hit(p.x(), p.y(), row.z_m, kLayer_m * scale);
    if (!hit || !looks_like_road(hit->triangle)) continue;
    const Side left = side_of(row, all, scale, surface, looks_like_road, offset_m, hit->z_m, 1.0);
    const Side right = side_of(row, all, scale, surface, looks_like_road, offset_m, hit->z_m, -1.0);
    row.left_m = left.offset_m, row.ends_left = left.ends;
    row.right_m = right.offset_m, row.ends_right = right.ends;
    return;
  }
  row.has_surface = false;
}

/// Whether a row knows both sides of the road.
bool measured(const GuideRow& row) {
  return row.ends_left && row.ends_right && row.left_m > row.right_m;
}

double half_of(const GuideRow& row) { return 0.5 * (row.left_m - row.right_m); }

/// Half the width in the middle of the rows within `around`; NaN where none knows it.
double usual_half(const GuideRows& all, std::size_t i, std::size_t around) {
  const auto n = static_cast<std::ptrdiff_t>(all.rows.size());
  std::vector<double> near_m;
  for (std::size_t k = 0; k <= 2 * around; ++k) {
    const auto at = static_cast<std::ptrdiff_t>(i + k) - static_cast<std::ptrdiff_t>(around);
    if (!all.closed && (at < 0 || at >= n)) continue;
    const GuideRow& other = all.rows[static_cast<std::size_t>(((at % n) + n) % n)];
    if (measured(other)) near_m.push_back(half_of(other));
  }
  return near_m.empty() ? std::numeric_limits<double>::quiet_NaN()
                        : base::median(std::move(near_m));
}

/// Where the road is wide on one side only (a lay-by, an apron, a pit lane of its own asphalt), it
/// ends there as far from its other side as before and after. Wide places longer than the rows from
/// which it is told what is usual stay as they are.
void narrow_wide_places(GuideRows& all) {
  const std::size_t n = all.rows.size();
  if (n <= 2 * kFarAround) return;
  std::vector<double> usual_m(n);
  for (std::size_t i = 0; i < n; ++i)
    usual_m[i] = std::min(usual_half(all, i, kFarAround), all.usual_half_m);
  const auto wide = [&](std::size_t i) {
    return measured(all.rows[i]) && half_of(all.rows[i]) > kWide * usual_m[i];
  };
  const auto narrow = [&](std::size_t i) {
    return measured(all.rows[i]) && half_of(all.rows[i]) < kNotWide * usual_m[i];
  };
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = i > 0 ? i - 1 : n - 1;
    if (!wide(i) || wide(before) || (i == 0 && !all.closed)) continue;
    // From the last row before that is not wide to the first after it.
    std::size_t length = 0, back = 1, on = 0;
    for (std::size_t k = 0; k < 2 * kFarAround && !narrow((i + k) % n); ++k) length = on = k + 1;
    while (back < kFarAround && !narrow((i + n - back) % n)) ++back;
    if (length == 2 * kFarAround || back == kFarAround) continue;
    if (!all.closed && (back > i || i + on >= n)) continue;
    const GuideRow &first = all.rows[(i + n - back) % n], &last = all.rows[(i + on) % n];
    std::vector<double> halves_m;
    for (std::size_t k = 0; k < length; ++k)
      if (measured(all.rows[(i + k) % n])) halves_m.push_back(half_of(all.rows[(i + k) % n]));
    const double full_m = kFullyWide * base::median(halves_m);
    std::size_t begin = 0, end = length - 1;
    while (begin < end && !(half_of(all.rows[(i + begin) % n]) >= full_m)) ++begin;
    while (end > begin && !(half_of(all.rows[(i + end) % n]) >= full_m)) --end;
    const auto out_left = [&](std::size_t k, const GuideRow& from) {
      return all.rows[(i + k) % n].left_m - from.left_m;
    };
    const auto out_right = [&](std::size_t k, const GuideRow& from) {
      return from.right_m - all.rows[(i + k) % n].right_m;
    };
    const auto quiet = [&](const auto& out, const auto& other) {
      return std::abs(out(begin, first)) < kQuiet * other(begin, first) &&
             std::abs(out(end, last)) < kQuiet * other(end, last);
    };
    const bool hold_left = quiet(out_left, out_right), hold_right = quiet(out_right, out_left);
    if (!hold_left && !hold_right) continue;
    const double span = static_cast<double>(on + back);
    const double first_m = half_of(first), last_m = half_of(last);
    for (std::size_t k = 1; k < on + back; ++k) {
      GuideRow& row = all.rows[(i + n - back + k) % n];
      if (!measured(row)) continue;
      const double t = static_cast<double>(k) / span;
      const double width_m =
          std::min(row.left_m - row.right_m, 2.0 * ((1.0 - t) * first_m + t * last_m));
      if (hold_left)
        row.right_m = row.left_m - width_m;
      else
        row.left_m = row.right_m + width_m;
      row.is_narrowed = true;
    }
  }
}

/// Whether a middle jumps from those of its neighbours, or has hardly any: at junctions.
bool is_restless(const std::vector<double>& middle_m, std::size_t i, double half_width_m,
                 bool closed, double scale) {
  const auto n = static_cast<std::ptrdiff_t>(middle_m.size());
  std::vector<double> near_m;
  std::size_t rows = 0;
  for (std::ptrdiff_t k = -kNear; k <= kNear; ++k) {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(i) + k;
    if (!closed && (at < 0 || at >= n)) continue;
    ++rows;
    const double value_m = middle_m[static_cast<std::size_t>(((at % n) + n) % n)];
    if (std::isfinite(value_m)) near_m.push_back(value_m);
  }
  if (3 * near_m.size() < rows) return true;
  return std::abs(middle_m[i] - base::median(std::move(near_m))) >
         kJump * half_width_m + 0.1 * scale;
}

/// Middle and width of every row, from itself where it is like its neighbours, else from them.
void settle(GuideRows& all, double scale) {
  const std::size_t n = all.rows.size();
  std::vector<double> halves_m, middle_m(n, std::numeric_limits<double>::quiet_NaN());
  for (const GuideRow& row : all.rows)
    if (measured(row)) halves_m.push_back(half_of(row));
  if (halves_m.empty()) return;
  all.usual_half_m = base::median(halves_m);
  narrow_wide_places(all);
  for (std::size_t i = 0; i < n; ++i) {
    GuideRow& row = all.rows[i];
    const double near_m = usual_half(all, i, kAround);
    row.half_width_m = std::isfinite(near_m) ? near_m : all.usual_half_m;
    row.is_usual = measured(row) && std::abs(half_of(row) - row.half_width_m) <
                                        0.25 * row.half_width_m + 0.1 * scale;
    if (row.is_usual) middle_m[i] = 0.5 * (row.left_m + row.right_m);
  }
  const std::vector<double> first_m = middle_m;
  std::vector<double> half_m(n, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < n; ++i) {
    GuideRow& row = all.rows[i];
    row.is_usual = row.is_usual && !is_restless(first_m, i, row.half_width_m, all.closed, scale);
    if (row.is_usual)
      half_m[i] = row.half_width_m;
    else
      middle_m[i] = std::numeric_limits<double>::quiet_NaN();
  }
  if (std::none_of(all.rows.begin(), all.rows.end(),
                   [](const GuideRow& row) { return row.is_usual; }))
    return;
  fill_between(middle_m, all.closed);
  fill_between(half_m, all.closed);
  for (std::size_t i = 0; i < n; ++i)
    all.rows[i].middle_m = middle_m[i], all.rows[i].half_width_m = half_m[i];
}

/// Where the rows stand, before anything is measured; their z is the guide's.
GuideRows empty_rows(const Guide& guide) {
  GuideRows all;
  all.closed = guide.closed;
  double length_m = 0.0;
  for (std::size_t i = 1; i < guide.points_m.size(); ++i)
    length_m += (guide.points_m[i] - guide.points_m[i - 1]).head<2>().norm();
  all.reach_m = std::clamp((guide.closed ? kReachShare : kReachShareOpen) * length_m,
                           kSmallestReach_m, kUsualReach_m);
  all.across_m = all.reach_m / kRaysPerReach;
  const std::vector<Vector3d> curve = resampled(guide, all.reach_m / kRowsPerReach);
  const std::size_t n = curve.size();
  all.step_m = (curve[1] - curve[0]).head<2>().norm();
  all.rows.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = i > 0 ? i - 1 : (guide.closed ? n - 1 : 0),
                      after = i + 1 < n ? i + 1 : (guide.closed ? 0 : i);
    all.rows[i].at_m = curve[i].head<2>();
    all.rows[i].z_m = curve[i].z();
    all.rows[i].heading = (curve[after] - curve[before]).head<2>().normalized();
  }
  return all;
}

}  // namespace

GuideRows rows_along(const Guide& guide, const RaySurface& surface,
                     const LooksLikeRoad& looks_like_road) {
  GuideRows all = empty_rows(guide);
  const double scale = all.reach_m / kUsualReach_m;
  const std::size_t n = all.rows.size();
  std::vector<std::vector<Layer>> layers(n);
  base::parallel_for(n, 16, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      layers[i] = layers_at(all.rows[i], all, scale, surface, looks_like_road);
  });
  // The guide's heights may begin elsewhere: where there is only one layer they tell from where.
  std::vector<double> above_m;
  for (std::size_t i = 0; i < n; ++i)
    if (layers[i].size() == 1 && std::isfinite(all.rows[i].z_m))
      above_m.push_back(layers[i][0].z_m - all.rows[i].z_m);
  if (!above_m.empty()) {
    const double shift_m = base::median(std::move(above_m));
    for (std::size_t i = 0; i < n; ++i)
      for (Layer& layer : layers[i])
        if (std::isfinite(all.rows[i].z_m))
          layer.cost +=
              std::min(kMostOfGuide,
                       kPerMetreOfGuide * std::abs(layer.z_m - all.rows[i].z_m - shift_m) / scale);
  }
  std::vector<double> z_m = best_layers(layers, all.step_m, scale);
  for (std::size_t i = 0; i < n; ++i) all.rows[i].has_surface = std::isfinite(z_m[i]);
  fill_between(z_m, guide.closed);
  base::parallel_for(n, 16, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      all.rows[i].z_m = z_m[i];
      measure(all.rows[i], all, scale, surface, looks_like_road);
    }
  });
  for (std::size_t i = 0; i < n; ++i)
    if (!all.rows[i].has_surface) z_m[i] = std::numeric_limits<double>::quiet_NaN();
  fill_between(z_m, guide.closed);
  for (std::size_t i = 0; i < n; ++i) all.rows[i].z_m = z_m[i];
  settle(all, scale);
  return all;
}

void set_width(GuideRows& all, double width_m) {
  all.usual_half_m = 0.5 * width_m;
  for (GuideRow& row : all.rows) {
    if (row.is_usual && std::abs(row.half_width_m - 0.5 * width_m) < 0.125 * width_m) continue;
    row.is_usual = false;
    row.half_width_m = 0.5 * width_m;
    row.middle_m = 0.0;
  }
}

LookShares look_shares(const Guide& guide, const RaySurface& surface,
                       const std::vector<std::uint32_t>& look_of_triangle, std::size_t looks) {
  const GuideRows all = empty_rows(guide);
  const std::vector<double> none(looks, 0.0);
  LookShares shares{none, none, none, none, {}};
  std::vector<double> rows_with(looks, 0.0), inside(looks, 0.0), outside(looks, 0.0);
  const auto looks_at = [&](const GuideRow& row, double offset) {
    const Vector2d p = row.at_m + offset * all.reach_m * left_of(row.heading);
    std::vector<LookShares::Seen> seen;
    for (const SurfaceHit& hit : surface.all_hits(p.x(), p.y()))
      seen.push_back({look_of_triangle[hit.triangle], hit.z_m});
    return seen;
  };
  const auto count = [](const std::vector<LookShares::Seen>& seen, std::vector<double>& into) {
    for (std::size_t i = 0; i < seen.size(); ++i)
      if (std::none_of(seen.begin(), seen.begin() + static_cast<std::ptrdiff_t>(i),
                       [&](const LookShares::Seen& s) { return s.look == seen[i].look; }))
        into[seen[i].look] += 1.0;
  };
  for (const GuideRow& row : all.rows) {
    inside = outside = none;
    for (int k = -2; k <= 2; ++k) {
      shares.places.push_back(looks_at(row, 0.035 * k));
      count(shares.places.back(), inside);
    }
    for (int k = 0; k < 5; ++k)
      for (const double sign : {-1.0, 1.0}) count(looks_at(row, sign * (0.5 + 0.125 * k)), outside);
    for (std::size_t look = 0; look < looks; ++look) {
      shares.inside[look] += inside[look];
      shares.outside[look] += outside[look];
      if (inside[look] == 0.0) continue;
      rows_with[look] += 1.0;
      shares.outside_there[look] += outside[look];
    }
  }
  const auto rows = static_cast<double>(all.rows.size());
  for (std::size_t look = 0; look < looks; ++look) {
    shares.outside_there[look] /= 10.0 * std::max(1.0, rows_with[look]);
    shares.inside_there[look] = shares.inside[look] / (5.0 * std::max(1.0, rows_with[look]));
    shares.inside[look] /= 5.0 * rows;
    shares.outside[look] /= 10.0 * rows;
  }
  return shares;
}

}  // namespace road
