#include "clearance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "float_rounding.h"

namespace crg {
namespace {

constexpr double kWindowTurn_rad = 0.6;
constexpr double kFoldShare =
    0.8;  // < cos(kWindowTurn_rad): the fold seen from anywhere in the window
constexpr double kDegenerateLean = 50.0;
// Of the reach: in shorter segments a point within reach has no certain place along, for rounding.
constexpr double kDegenerateLength = 1e-8;

// What a run of segments may claim, rounded so that less becomes certain. There are as many as a
// fourth of the rows while a road becomes ready: hence floats, and no more copies from the segments
// than a first look needs.
struct Station {
  float span_m;    // no point of the run is farther than this from the middle
  float turn_rad;  // sum of |turns| inside the run and to the next
  float stretch;   // |point - foot| / |v| at most
  float fold_left_m, fold_right_m;
  float x_m, y_m;  // of the middle, from the line's first node: for a first look, not exact
};

struct Stations {
  std::span<const SegmentRecord> segments;
  std::size_t run;  // segments of a station; the last one may have fewer
  std::vector<Station> of = {};

  std::size_t size() const { return of.size(); }
  const Station& operator[](std::size_t k) const { return of[k]; }
  /// Its first node is the middle of the station.
  const SegmentFrame& middle(std::size_t k) const {
    const std::size_t begin = k * run, end = std::min(begin + run, segments.size());
    return segments[(begin + end) / 2].frame;
  }
};

double turn_between(const SegmentFrame& a, const SegmentFrame& b) {
  return std::abs(std::atan2(a.cos * b.sin - a.sin * b.cos, a.cos * b.cos + a.sin * b.sin));
}

Station make_station(const Stations& stations, std::size_t k, double reach_m, bool joined) {
  const std::span<const SegmentRecord> segments = stations.segments;
  const SegmentFrame& middle = stations.middle(k);
  double span_m = 0.0, turn_rad = 0.0, stretch = 1.0;
  double fold_left_m = std::numeric_limits<double>::infinity(), fold_right_m = fold_left_m;
  const std::size_t end = std::min((k + 1) * stations.run, segments.size());
  for (std::size_t i = k * stations.run; i < end; ++i) {
    const SegmentFrame& frame = segments[i].frame;
    // Not std::hypot: where a square is too large nothing becomes certain.
    const double dx = frame.x_m - middle.x_m, dy = frame.y_m - middle.y_m;
    span_m = std::max(span_m, std::sqrt(dx * dx + dy * dy) + frame.length_m);
    if (i + 1 < segments.size()) {
      turn_rad += turn_between(frame, segments[i + 1].frame);
    } else if (joined) {
      turn_rad += turn_between(frame, segments[0].frame);
    }
    const double lean = std::max(std::abs(frame.begin_lean), std::abs(frame.end_lean()));
    stretch = std::max(stretch, std::sqrt(1.0 + lean * lean));
    // width(v) = length + v (end_lean - begin_lean) reaches zero at the fold.
    const double rate = frame.lean_change;
    if (!(frame.length_m > kDegenerateLength * reach_m) || lean > kDegenerateLean) {
      fold_left_m = fold_right_m = 0.0;
    } else if (rate < 0.0) {
      fold_left_m = std::min(fold_left_m, frame.length_m / -rate);
    } else if (rate > 0.0) {
      fold_right_m = std::min(fold_right_m, frame.length_m / rate);
    }
  }
  return {float_above(span_m),
          float_above(turn_rad),
          float_above(stretch),
          float_below(fold_left_m),
          float_below(fold_right_m),
          float_below(middle.x_m - segments[0].frame.x_m),
          float_below(middle.y_m - segments[0].frame.y_m)};
}

// Of all stations.
struct Extremes {
  double largest_span_m = 0.0, largest_stretch = 1.0;
  double nearest_fold_m = std::numeric_limits<double>::infinity();
  double farthest_m = 0.0;  // from the first node, of either coordinate
};

Extremes extremes_of(const Stations& stations) {
  Extremes of;
  for (const Station& station : stations.of) {
    of.largest_span_m = std::max<double>(of.largest_span_m, station.span_m);
    of.largest_stretch = std::max<double>(of.largest_stretch, station.stretch);
    of.nearest_fold_m =
        std::min<double>(of.nearest_fold_m, std::min(station.fold_left_m, station.fold_right_m));
    of.farthest_m =
        std::max<double>(of.farthest_m, std::max(std::abs(station.x_m), std::abs(station.y_m)));
  }
  return of;
}

// Stations one after the other, first to before last.
struct Run {
  std::size_t first = 0, last = 0;
};

// Stations by square of a plane grid, as runs that stay within one square; the squares folded into
// a table by hashing.
class Neighbourhood {
 public:
  Neighbourhood(const Stations& stations, double side_m) : side_m_(side_m) {
    std::size_t buckets = 1;
    while (buckets < stations.size()) buckets *= 2;
    mask_ = buckets - 1;
    std::vector<Run> runs;
    std::vector<std::size_t> bucket_of;
    std::int64_t x = 0, y = 0;
    for (std::size_t k = 0; k < stations.size(); ++k) {
      const std::int64_t here_x = cell(stations.middle(k).x_m),
                         here_y = cell(stations.middle(k).y_m);
      if (runs.empty() || here_x != x || here_y != y) {
        x = here_x;
        y = here_y;
        runs.push_back({k, k});
        bucket_of.push_back(bucket(x, y));
      }
      runs.back().last = k + 1;
    }
    start_.assign(buckets + 1, 0);
    for (const std::size_t b : bucket_of) ++start_[b + 1];
    for (std::size_t b = 0; b < buckets; ++b) start_[b + 1] += start_[b];
    runs_.resize(runs.size());
    std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t r = 0; r < runs.size(); ++r) runs_[next[bucket_of[r]]++] = runs[r];
  }

  // Calls visit(runs) for lists of runs that together hold all stations within side_m of a place.
  template <typename Visit>
  void around(double x_m, double y_m, Visit visit) const {
    const std::int64_t cx = cell(x_m), cy = cell(y_m);
    for (std::int64_t y = cy - 1; y <= cy + 1; ++y) {
      for (std::int64_t x = cx - 1; x <= cx + 1; ++x) {
        const std::size_t b = bucket(x, y);
        visit(std::span(runs_.data() + start_[b], runs_.data() + start_[b + 1]));
      }
    }
  }

 private:
  std::int64_t cell(double value) const {
    return static_cast<std::int64_t>(std::floor(std::clamp(value / side_m_, -4e18, 4e18)));
  }
  std::size_t bucket(std::int64_t x, std::int64_t y) const {
    std::uint64_t hash = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ULL ^
                         static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4FULL;
    hash ^= hash >> 29;
    return static_cast<std::size_t>(hash & mask_);
  }

  double side_m_;
  std::uint64_t mask_ = 0;
  std::vector<std::uint32_t> start_;
  std::vector<Run> runs_;
};

struct Window {
  std::uint32_t before = 0, after = 0;  // stations on either side that count as the same stretch
};

// Of something of every station, over all before it; going round again behind the last one.
class Sums {
 public:
  Sums(const Stations& stations, float Station::*what) : of_(stations.size() + 1) {
    for (std::size_t k = 0; k < stations.size(); ++k)
      of_[k + 1] = of_[k] + static_cast<double>(stations[k].*what);
  }
  double operator[](std::size_t k) const {
    return k < of_.size() ? of_[k] : of_.back() + of_[k - (of_.size() - 1)];
  }

 private:
  std::vector<double> of_;
};

// The windows of all stations: as far as the road has turned little and is not long before the last
// one. What is added up along a window is never negative, so both its ends move on with k.
std::vector<Window> same_stretches(const Stations& stations, double reach_m, bool joined) {
  const std::size_t count = stations.size();
  const Sums turn(stations, &Station::turn_rad), span(stations, &Station::span_m);
  const auto same = [&](double turned, double spans) {
    return turned <= kWindowTurn_rad && 2.0 * spans < 2.5 * reach_m;
  };
  std::vector<Window> windows(count);
  std::size_t begin = joined ? 1 : count, end = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t at = k + count;
    begin = std::max(begin, at - (count - 1));
    while (begin < at && !same(2.0 * (turn[at] - turn[begin]), span[at] - span[begin + 1])) ++begin;
    end = std::max(end, k);
    const std::size_t last = joined ? k + count - 1 : count - 1;
    while (end < last && same(turn[end + 1] - turn[k] + (turn[end + 2] - turn[k + 1]),
                              span[end + 1] - span[k + 1]))
      ++end;
    windows[k] = {static_cast<std::uint32_t>(at - begin),
                  static_cast<std::uint32_t>(std::min(end - k, count - 1 - (at - begin)))};
  }
  return windows;
}

// The end of a closed track prolonged over its gap: it competes like a cell.
struct Prolonged {
  Point2 middle;
  double length_m;
};

std::vector<Prolonged> prolonged_ends(std::span<const SegmentRecord> segments,
                                      const Closing& closing) {
  const SegmentFrame &at_start = segments.front().frame, &at_end = segments.back().frame;
  std::vector<Prolonged> ends;
  if (closing.before_start_m > 0.0)
    ends.push_back({at_start.point(-0.5 * closing.before_start_m, 0.0), closing.before_start_m});
  if (closing.after_end_m > 0.0)
    ends.push_back(
        {at_end.point(at_end.length_m + 0.5 * closing.after_end_m, 0.0), closing.after_end_m});
  return ends;
}

// |v| up to which a point is certain, on either side.
struct Certain {
  double left_m, right_m;
};

// Up to the folds of the own stretch.
Certain before_folds(const Stations& stations, std::size_t k, const Window& window,
                     const Extremes& extremes, double reach_m) {
  Certain certain{reach_m, reach_m};
  if (kFoldShare * extremes.nearest_fold_m >= reach_m) return certain;
  const std::size_t count = stations.size();
  for (std::size_t w = 0; w <= window.before + window.after; ++w) {
    const Station& other = stations[(k + count - window.before + w) % count];
    certain.left_m = std::min(certain.left_m, kFoldShare * other.fold_left_m);
    certain.right_m = std::min(certain.right_m, kFoldShare * other.fold_right_m);
  }
  return certain;
}

// Not into what another station's run may claim.
void keep_from(const Station& here, const Station& other, double distance_squared, double across,
               double reach_m, Certain& certain) {
  const double slack = double{here.span_m} + other.span_m;
  const double growth = double{std::max(here.stretch, other.stretch)} + here.turn_rad;
  const double squared = distance_squared - slack * slack;
  // |other - point|^2 > (growth |v| + slack)^2 for all |v| up to the bound.
  const auto lower = [&](double& certain_m, double side) {
    const double rate = 2.0 * (side * across + growth * slack) + reach_m * (growth * growth - 1.0);
    if (squared <= 0.0) {
      certain_m = 0.0;
    } else if (squared < certain_m * rate * (1.0 + 1e-12)) {  // else no division is needed to see
      certain_m = std::min(certain_m, squared / rate);
    }
  };
  lower(certain.left_m, 1.0);
  lower(certain.right_m, -1.0);
}

// Square of the distance from which on no station can lower what is certain: there keep_from()
// finds distance^2 - slack^2 >= certain (2 (distance + growth slack) + reach (growth^2 - 1)).
double harmless_squared(const Station& here, const Extremes& extremes, double reach_m,
                        const Certain& certain) {
  const double most = std::max(certain.left_m, certain.right_m);
  const double slack = here.span_m + extremes.largest_span_m;
  const double growth = std::max<double>(here.stretch, extremes.largest_stretch) + here.turn_rad;
  const double rest = 2.0 * growth * slack + reach_m * (growth * growth - 1.0);
  const double distance = most + std::sqrt(most * most + slack * slack + most * rest);
  return distance * distance * (1.0 + 1e-9);
}

// Not into what any station outside the own stretch may claim. What would cost more than `budget`
// pairs stays uncertain, as does all after it: the budget is then 0.
void keep_from_others(const Stations& stations, std::size_t k, const Window& window,
                      const Neighbourhood& neighbourhood, const Extremes& extremes, double reach_m,
                      std::size_t& budget, Certain& certain) {
  const std::size_t count = stations.size();
  const Station& here = stations[k];
  const SegmentFrame& middle = stations.middle(k);
  const double harmless = harmless_squared(here, extremes, reach_m, certain);
  // By the floats of both: what lies farther than this certainly is harmless.
  const double far_m = (std::sqrt(harmless) + 0x1p-20 * extremes.farthest_m) * (1.0 + 1e-5);
  const float far_squared = float_above(far_m * far_m);
  const auto keep_from_all = [&](std::size_t first, std::size_t last) {
    for (; first < last; ++first) {
      const float ex = stations[first].x_m - here.x_m, ey = stations[first].y_m - here.y_m;
      if (ex * ex + ey * ey > far_squared) continue;
      const SegmentFrame& other = stations.middle(first);
      const double dx = other.x_m - middle.x_m, dy = other.y_m - middle.y_m;
      const double squared = dx * dx + dy * dy;
      if (squared < harmless)
        keep_from(here, stations[first], squared, dy * middle.cos - dx * middle.sin, reach_m,
                  certain);
    }
  };
  // The window, which may lie over the seam.
  const std::size_t begin = k >= window.before ? k - window.before : k + count - window.before;
  const std::size_t behind = k + window.after + 1, end = behind > count ? behind - count : behind;
  neighbourhood.around(middle.x_m, middle.y_m, [&](std::span<const Run> runs) {
    std::size_t pairs = 0;
    for (const Run& run : runs) pairs += run.last - run.first;
    if (pairs > budget) {
      budget = 0;
      certain = {0.0, 0.0};
      return;
    }
    budget -= pairs;
    for (const Run& run : runs) {
      if (begin < end) {
        keep_from_all(run.first, std::min(run.last, begin));
        keep_from_all(std::max(run.first, end), run.last);
      } else {
        keep_from_all(std::max(run.first, end), std::min(run.last, begin));
      }
    }
  });
}

Stations make_stations(std::span<const SegmentRecord> segments, std::size_t run, double reach_m,
                       bool joined) {
  Stations stations{.segments = segments, .run = run};
  const std::size_t count = (segments.size() + run - 1) / run;
  stations.of.reserve(count);
  for (std::size_t k = 0; k < count; ++k)
    stations.of.push_back(make_station(stations, k, reach_m, joined));
  return stations;
}

// Beyond this distance no other run can compete for a point within reach_m.
double farthest_rival_m(const Extremes& extremes, double reach_m) {
  return reach_m * (1.0 + std::min(extremes.largest_stretch, 2.0)) + 2.0 * extremes.largest_span_m;
}

void write_certain(std::span<SegmentRecord> segments, const Certain& certain, double v_right_m,
                   double v_left_m, double reach_m) {
  const float right = float_inward(
      std::max(v_right_m, certain.right_m < reach_m ? -0.999 * certain.right_m : v_right_m));
  const float left = float_inward(
      std::min(v_left_m, certain.left_m < reach_m ? 0.999 * certain.left_m : v_left_m));
  for (SegmentRecord& segment : segments) {
    segment.certain_right_m = right;
    segment.certain_left_m = left;
  }
}

}  // namespace

void measure_clearance(std::span<SegmentRecord> segments, double v_right_m, double v_left_m,
                       double u_step_m, bool joined, const Closing& closing) {
  const double reach_m = std::max(std::abs(v_right_m), std::abs(v_left_m));
  std::size_t run = 1;
  while (run < (1U << 20U) && u_step_m * static_cast<double>(2 * run) <= reach_m / 16.0) run *= 2;
  const Stations stations = make_stations(segments, run, reach_m, joined);
  const std::size_t count = stations.size();
  const Extremes extremes = extremes_of(stations);
  const double far_m = farthest_rival_m(extremes, reach_m);
  const std::vector<Window> windows = same_stretches(stations, reach_m, joined);
  const Neighbourhood neighbourhood(stations, far_m);
  const std::vector<Prolonged> ends = prolonged_ends(segments, closing);
  // Tangled input would cost count^2; what is not measured within the budget stays uncertain.
  std::size_t budget = 4096 + 1024 * count;
  for (std::size_t k = 0; k < count; ++k) {
    const Station& here = stations[k];
    if (budget == 0 || here.stretch > 2.0 || here.turn_rad > kWindowTurn_rad) continue;
    const Window& window = windows[k];
    Certain certain = before_folds(stations, k, window, extremes, reach_m);
    keep_from_others(stations, k, window, neighbourhood, extremes, reach_m, budget, certain);
    for (const Prolonged& end : ends) {
      // Shorter than a row and part of the same stretch: no more than one cell among others.
      if (end.length_m <= u_step_m && (k <= window.before || count - 1 - k <= window.after))
        continue;
      // Near a long one nothing is certain.
      const SegmentFrame& middle = stations.middle(k);
      const double dx = end.middle.x_m - middle.x_m, dy = end.middle.y_m - middle.y_m;
      if (std::hypot(dx, dy) - 0.5 * end.length_m <= far_m) certain = {0.0, 0.0};
    }
    if (certain.left_m <= 0.0 || certain.right_m <= 0.0) continue;
    write_certain(segments.subspan(k * run, std::min(run, segments.size() - k * run)), certain,
                  v_right_m, v_left_m, reach_m);
  }
}

}  // namespace crg
