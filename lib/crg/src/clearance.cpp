#include "clearance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace crg {
namespace {

constexpr double kWindowTurn_rad = 0.6;
constexpr double kFoldShare =
    0.8;  // < cos(kWindowTurn_rad): the fold seen from anywhere in the window
constexpr double kDegenerateLean = 50.0;
// Of the reach: in shorter segments a point within reach has no certain place along, for rounding.
constexpr double kDegenerateLength = 1e-8;

struct Station {
  double x_m = 0.0, y_m = 0.0;  // middle of the run
  double cos = 1.0, sin = 0.0;  // direction there
  double span_m = 0.0;          // no point of the run is farther than this from the middle
  double turn_rad = 0.0;        // sum of |turns| inside the run and to the next
  double stretch = 1.0;         // |point - foot| / |v| at most
  double fold_left_m = 0.0, fold_right_m = 0.0;
};

double turn_between(const SegmentFrame& a, const SegmentFrame& b) {
  return std::abs(std::atan2(a.cos * b.sin - a.sin * b.cos, a.cos * b.cos + a.sin * b.sin));
}

Station make_station(std::span<const SegmentRecord> segments, std::size_t begin, std::size_t end,
                     double reach_m, bool joined) {
  Station station;
  const SegmentFrame& middle = segments[(begin + end) / 2].frame;
  station.x_m = middle.x_m;
  station.y_m = middle.y_m;
  station.cos = middle.cos;
  station.sin = middle.sin;
  station.fold_left_m = station.fold_right_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = begin; i < end; ++i) {
    const SegmentFrame& frame = segments[i].frame;
    station.span_m =
        std::max(station.span_m,
                 std::hypot(frame.x_m - station.x_m, frame.y_m - station.y_m) + frame.length_m);
    if (i + 1 < segments.size()) {
      station.turn_rad += turn_between(frame, segments[i + 1].frame);
    } else if (joined) {
      station.turn_rad += turn_between(frame, segments[0].frame);
    }
    const double lean = std::max(std::abs(frame.begin_lean), std::abs(frame.end_lean));
    station.stretch = std::max(station.stretch, std::sqrt(1.0 + lean * lean));
    // width(v) = length + v (end_lean - begin_lean) reaches zero at the fold.
    const double rate = frame.end_lean - frame.begin_lean;
    if (!(frame.length_m > kDegenerateLength * reach_m) || lean > kDegenerateLean) {
      station.fold_left_m = station.fold_right_m = 0.0;
    } else if (rate < 0.0) {
      station.fold_left_m = std::min(station.fold_left_m, frame.length_m / -rate);
    } else if (rate > 0.0) {
      station.fold_right_m = std::min(station.fold_right_m, frame.length_m / rate);
    }
  }
  return station;
}

// Stations by square of a plane grid, the squares folded into a table by hashing.
class Neighbourhood {
 public:
  Neighbourhood(const std::vector<Station>& stations, double side_m) : side_m_(side_m) {
    std::size_t buckets = 1;
    while (buckets < stations.size()) buckets *= 2;
    mask_ = buckets - 1;
    start_.assign(buckets + 1, 0);
    for (const Station& station : stations)
      ++start_[bucket(cell(station.x_m), cell(station.y_m)) + 1];
    for (std::size_t b = 0; b < buckets; ++b) start_[b + 1] += start_[b];
    items_.resize(stations.size());
    std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t k = 0; k < stations.size(); ++k) {
      const Station& station = stations[k];
      items_[next[bucket(cell(station.x_m), cell(station.y_m))]++] = {
          station.x_m, station.y_m, static_cast<std::uint32_t>(k)};
    }
  }

  struct Item {
    double x_m, y_m;
    std::uint32_t station;
  };

  // Calls visit(first, last) for ranges of items that together hold all within side_m.
  template <typename Visit>
  void around(const Station& station, Visit visit) const {
    const std::int64_t cx = cell(station.x_m), cy = cell(station.y_m);
    for (std::int64_t y = cy - 1; y <= cy + 1; ++y) {
      for (std::int64_t x = cx - 1; x <= cx + 1; ++x) {
        const std::size_t b = bucket(x, y);
        visit(items_.data() + start_[b], items_.data() + start_[b + 1]);
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
  std::vector<Item> items_;
};

// The float next to a value that is not farther from zero.
float inward(double value) {
  const float rounded = static_cast<float>(value);
  return std::abs(static_cast<double>(rounded)) > std::abs(value) ? std::nextafter(rounded, 0.0F)
                                                                  : rounded;
}

struct Window {
  std::size_t before = 0, after = 0;  // stations on either side that count as the same stretch
};

// Around a ring of `count` stations; a division for each would take longer than all the rest.
std::size_t ahead_of(std::size_t k, std::size_t steps, std::size_t count) {
  const std::size_t at = k + steps;
  return at >= count ? at - count : at;
}

Window same_stretch(const std::vector<Station>& stations, std::size_t k, double reach_m,
                    bool joined) {
  const std::size_t count = stations.size();
  const auto walk = [&](int direction) {
    std::size_t steps = 0;
    double turn = 0.0, arc = 0.0;
    std::size_t at = k;
    while (steps + 1 < count && arc < 2.5 * reach_m) {
      if (direction > 0 ? at + 1 == count : at == 0) {
        if (!joined) break;
      }
      const std::size_t next = ahead_of(at, direction > 0 ? 1 : count - 1, count);
      turn += stations[direction > 0 ? at : next].turn_rad + stations[next].turn_rad;
      if (turn > kWindowTurn_rad) break;
      arc += 2.0 * stations[next].span_m;
      at = next;
      ++steps;
    }
    return steps;
  };
  Window window{walk(-1), walk(1)};
  if (window.before + window.after + 1 > count) window.after = count - 1 - window.before;
  return window;
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
Certain before_folds(const std::vector<Station>& stations, std::size_t k, const Window& window,
                     double reach_m) {
  const std::size_t count = stations.size();
  const std::size_t first = ahead_of(k, count - window.before, count);
  Certain certain{reach_m, reach_m};
  for (std::size_t w = 0; w <= window.before + window.after; ++w) {
    const Station& other = stations[ahead_of(first, w, count)];
    certain.left_m = std::min(certain.left_m, kFoldShare * other.fold_left_m);
    certain.right_m = std::min(certain.right_m, kFoldShare * other.fold_right_m);
  }
  return certain;
}

// Not into what another station's run may claim.
void keep_from(const Station& here, const Station& other, double reach_m, Certain& certain) {
  const double dx = other.x_m - here.x_m, dy = other.y_m - here.y_m;
  const double across = -dx * here.sin + dy * here.cos;
  const double slack = here.span_m + other.span_m;
  const double growth = std::max(here.stretch, other.stretch) + here.turn_rad;
  const double squared = dx * dx + dy * dy - slack * slack;
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

// The largest of all stations.
struct Largest {
  double span_m = 0.0, stretch = 1.0;
};

Largest largest_of(const std::vector<Station>& stations) {
  Largest largest;
  for (const Station& station : stations) {
    largest.span_m = std::max(largest.span_m, station.span_m);
    largest.stretch = std::max(largest.stretch, station.stretch);
  }
  return largest;
}

// Square of the distance from which on no station can lower what is certain: there keep_from() finds
// distance^2 - slack^2 >= certain (2 (distance + growth slack) + reach (growth^2 - 1)).
double harmless_squared(const Station& here, const Largest& largest, double reach_m,
                        const Certain& certain) {
  const double most = std::max(certain.left_m, certain.right_m);
  const double slack = here.span_m + largest.span_m;
  const double growth = std::max(here.stretch, largest.stretch) + here.turn_rad;
  const double rest = 2.0 * growth * slack + reach_m * (growth * growth - 1.0);
  const double distance = most + std::sqrt(most * most + slack * slack + most * rest);
  return distance * distance * (1.0 + 1e-9);
}

// Not into what any station outside the own stretch may claim. What would cost more than `budget`
// pairs stays uncertain, as does all after it: the budget is then 0.
void keep_from_others(const std::vector<Station>& stations, std::size_t k, const Window& window,
                      const Neighbourhood& neighbourhood, const Largest& largest, double reach_m,
                      std::size_t& budget, Certain& certain) {
  const std::size_t count = stations.size();
  const Station& here = stations[k];
  const double harmless = harmless_squared(here, largest, reach_m, certain);
  using Item = Neighbourhood::Item;
  neighbourhood.around(here, [&](const Item* first, const Item* last) {
    if (static_cast<std::size_t>(last - first) > budget) {
      budget = 0;
      certain = {0.0, 0.0};
      return;
    }
    budget -= static_cast<std::size_t>(last - first);
    for (; first != last; ++first) {
      const double dx = first->x_m - here.x_m, dy = first->y_m - here.y_m;
      if (dx * dx + dy * dy >= harmless) continue;
      const std::size_t ahead = ahead_of(first->station, count - k, count);
      if (ahead <= window.after || count - ahead <= window.before) continue;
      keep_from(here, stations[first->station], reach_m, certain);
    }
  });
}

std::vector<Station> make_stations(std::span<const SegmentRecord> segments, std::size_t run,
                                   double reach_m, bool joined) {
  std::vector<Station> stations;
  for (std::size_t begin = 0; begin < segments.size(); begin += run) {
    stations.push_back(
        make_station(segments, begin, std::min(begin + run, segments.size()), reach_m, joined));
  }
  return stations;
}

// Beyond this distance no other run can compete for a point within reach_m.
double farthest_rival_m(const Largest& largest, double reach_m) {
  return reach_m * (1.0 + std::min(largest.stretch, 2.0)) + 2.0 * largest.span_m;
}

void write_certain(std::span<SegmentRecord> segments, const Certain& certain, double v_right_m,
                   double v_left_m, double reach_m) {
  const float right =
      inward(std::max(v_right_m, certain.right_m < reach_m ? -0.999 * certain.right_m : v_right_m));
  const float left =
      inward(std::min(v_left_m, certain.left_m < reach_m ? 0.999 * certain.left_m : v_left_m));
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
  const std::vector<Station> stations = make_stations(segments, run, reach_m, joined);
  const std::size_t count = stations.size();
  const Largest largest = largest_of(stations);
  const double far_m = farthest_rival_m(largest, reach_m);
  const Neighbourhood neighbourhood(stations, far_m);
  const std::vector<Prolonged> ends = prolonged_ends(segments, closing);
  // Tangled input would cost count^2; what is not measured within the budget stays uncertain.
  std::size_t budget = 4096 + 1024 * count;
  for (std::size_t k = 0; k < count; ++k) {
    const Station& here = stations[k];
    if (budget == 0 || here.stretch > 2.0 || here.turn_rad > kWindowTurn_rad) continue;
    const Window window = same_stretch(stations, k, reach_m, joined);
    Certain certain = before_folds(stations, k, window, reach_m);
    keep_from_others(stations, k, window, neighbourhood, largest, reach_m, budget, certain);
    for (const Prolonged& end : ends) {
      // Shorter than a row and part of the same stretch: no more than one cell among others.
      if (end.length_m <= u_step_m && (k <= window.before || count - 1 - k <= window.after))
        continue;
      // Near a long one nothing is certain.
      const double dx = end.middle.x_m - here.x_m, dy = end.middle.y_m - here.y_m;
      if (std::hypot(dx, dy) - 0.5 * end.length_m <= far_m) certain = {0.0, 0.0};
    }
    if (certain.left_m <= 0.0 || certain.right_m <= 0.0) continue;
    write_certain(segments.subspan(k * run, std::min(run, segments.size() - k * run)), certain,
                  v_right_m, v_left_m, reach_m);
  }
}

}  // namespace crg
