#include "locator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "clearance.h"
#include "crg/huge_pages.h"
#include "float_rounding.h"

namespace crg {
namespace {

constexpr std::size_t kLeafSegments = 32;
constexpr int kMaxDepth = 48;

// Whether the end of one segment and the beginning of the next are cut by the same line.
bool share_mitre(const SegmentFrame& a, const SegmentFrame& b) {
  const Point2 end{a.end_lean() * a.cos - a.sin, a.end_lean() * a.sin + a.cos};
  const Point2 begin{b.begin_lean * b.cos - b.sin, b.begin_lean * b.sin + b.cos};
  const double cross = end.x_m * begin.y_m - end.y_m * begin.x_m;
  const double dot = end.x_m * begin.x_m + end.y_m * begin.y_m;
  return dot > 0.0 && std::abs(cross) < 1e-9 * dot;
}

// Also their memory.
void drop_first(std::vector<double>& values, std::size_t count) {
  values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count));
  values.shrink_to_fit();
}

}  // namespace

struct Locator::Best {
  Place place;
  double outside_m = std::numeric_limits<double>::infinity();
  double distance_m = std::numeric_limits<double>::infinity();

  void offer(const Place& candidate, double candidate_outside_m, double candidate_distance_m) {
    const bool better =
        candidate_outside_m < outside_m ||
        (candidate_outside_m == outside_m &&
         (candidate_distance_m < distance_m ||
          (candidate_distance_m == distance_m && candidate.segment < place.segment)));
    if (!better) return;
    place = candidate;
    outside_m = candidate_outside_m;
    distance_m = candidate_distance_m;
  }
};

std::vector<SegmentRecord> segment_records(ReferenceLine& line) {
  const std::size_t segments = line.size() - 1;
  std::vector<SegmentRecord> records;
  reserve_huge(records, segments + 1);
  const Point2 last_mitre = mitre_direction(line, segments);
  Point2 mitre = mitre_direction(line, 0);
  std::size_t dropped = 0;  // of the line's rows
  for (std::size_t i = 0; i < segments; ++i) {
    if (i == segments / 2) {
      drop_first(line.x_m, i);
      drop_first(line.y_m, i);
      dropped = i;
    }
    const Point2 next = i + 1 == segments ? last_mitre : mitre_direction(line, i + 1 - dropped);
    records.push_back({segment_frame(line, i - dropped, mitre, next)});
    mitre = next;
  }
  records.push_back({segment_frame(line, segments - 1 - dropped, mitre, mitre)});
  SegmentFrame& last = records.back().frame;
  last.x_m = line.x_m.back();
  last.y_m = line.y_m.back();
  drop_first(line.x_m, line.x_m.size());
  drop_first(line.y_m, line.y_m.size());
  return records;
}

Locator::Locator(std::vector<SegmentRecord> records, double u_step_m, double v_right_m,
                 double v_left_m, bool joined, const Closing& closing)
    : records_(std::move(records)),
      segments_(records_.size() - 1),
      v_right_m_(v_right_m),
      v_left_m_(v_left_m),
      reach_m_(std::max(std::abs(v_right_m), std::abs(v_left_m))),
      joined_(joined),
      closing_(closing) {
  const std::span<SegmentRecord> of_segments(records_.data(), segments_);
  measure_clearance(of_segments, v_right_m, v_left_m, u_step_m, joined_, closing_);
  coarse_ = CoarseIndex(of_segments, reach_m_);
  make_boxes();
}

void Locator::make_boxes() {
  const std::size_t leaves = (segments_ + kLeafSegments - 1) / kLeafSegments;
  std::size_t width = 1;
  while (width < leaves) width *= 2;
  first_leaf_ = width - 1;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  boxes_.assign(2 * width - 1, {kInfinity, -kInfinity, kInfinity, -kInfinity, 1.0F});
  for (std::size_t leaf = 0; leaf < leaves; ++leaf) boxes_[first_leaf_ + leaf] = box_of(leaf);
  for (std::size_t k = first_leaf_; k-- > 0;) {
    const Box& a = boxes_[2 * k + 1];
    const Box& b = boxes_[2 * k + 2];
    boxes_[k] = {std::min(a.x_min_m, b.x_min_m), std::max(a.x_max_m, b.x_max_m),
                 std::min(a.y_min_m, b.y_min_m), std::max(a.y_max_m, b.y_max_m),
                 std::max(a.stretch, b.stretch)};
  }
}

Locator::Box Locator::box_of(std::size_t leaf) const {
  const std::size_t begin = leaf * kLeafSegments, end = std::min(begin + kLeafSegments, segments_);
  const SegmentFrame& first = records_[begin].frame;
  double x_min_m = first.x_m, x_max_m = first.x_m, y_min_m = first.y_m, y_max_m = first.y_m;
  double stretch = 1.0;
  for (std::size_t i = begin; i < end; ++i) {
    const SegmentFrame &frame = records_[i].frame, &next = records_[i + 1].frame;
    x_min_m = std::min(x_min_m, next.x_m);
    x_max_m = std::max(x_max_m, next.x_m);
    y_min_m = std::min(y_min_m, next.y_m);
    y_max_m = std::max(y_max_m, next.y_m);
    const double lean = std::max(std::abs(frame.begin_lean), std::abs(frame.end_lean()));
    // At a reversal the two segments have different mitre lines, see search_leaf().
    const double slack = i + 1 < segments_ && !share_mitre(frame, next) ? 1.5 : 1.0;
    stretch = std::max(stretch, slack * std::sqrt(1.0 + lean * lean));
  }
  return {float_below(x_min_m), float_above(x_max_m), float_below(y_min_m), float_above(y_max_m),
          float_above(stretch)};
}

double Locator::outside(double v_m) const noexcept {
  return std::max({0.0, v_m - v_left_m_, v_right_m_ - v_m});
}

// Walks from the hint; true when it ends in a cell that is certain to be the answer.
bool Locator::locate_near(double x_m, double y_m, std::size_t hint, double farthest,
                          Place& place) const noexcept {
  const std::size_t segments = segments_;
  std::size_t i = std::min(hint, segments - 1);
  for (int step = 0; step < 8; ++step) {
    const SegmentFrame& frame = records_[i].frame;
    const Local local(frame, x_m, y_m);
    const double width = frame.width(local.v_m);
    if (!(width > 0.0)) return false;
    const double fraction = local.past_begin_m / width;
    const bool behind =
        fraction > 1.0 - kNearMitre && Local(records_[i + 1].frame, x_m, y_m).past_begin_m >= 0.0;
    if (fraction >= 0.0 && !behind) {
      if (!(fraction < 1.0 + kNearMitre) || !records_[i].certain(local.v_m)) return false;
      place = {i, std::min(fraction, 1.0), local.v_m, 0.0};
      return true;
    }
    // A straight line says little about places far along a curved one.
    if (!(std::abs(fraction) < farthest)) return false;
    const auto jump = behind ? std::max<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(fraction), 1)
                             : static_cast<std::ptrdiff_t>(fraction) - 1;
    auto next = static_cast<std::ptrdiff_t>(i) + jump;
    const auto count = static_cast<std::ptrdiff_t>(segments);
    if (next < 0 || next >= count) {
      if (joined_) {
        next = ((next % count) + count) % count;
      } else {
        if (i == 0 || i == segments - 1) return false;
        next = std::clamp<std::ptrdiff_t>(next, 0, count - 1);
      }
    }
    i = static_cast<std::size_t>(next);
  }
  return false;
}

void Locator::search_leaf(std::size_t leaf, double x_m, double y_m, Best& best) const noexcept {
  const std::size_t end = std::min((leaf + 1) * kLeafSegments, segments_);
  Local here(records_[leaf * kLeafSegments].frame, x_m, y_m);
  for (std::size_t i = leaf * kLeafSegments; i < end; ++i) {
    const Local next(records_[i + 1].frame, x_m, y_m);
    if (here.past_begin_m >= 0.0 && next.past_begin_m < 0.0) {
      const double width = records_[i].frame.width(here.v_m);
      const double fraction = width > 0.0 ? std::min(here.past_begin_m / width, 1.0) : 0.0;
      // Where the line turns back on itself, the end of one cell is not the beginning of the next,
      // and a point between the two belongs to neither: it counts as outside by its distance.
      const double excess = here.past_begin_m - fraction * width;
      if (width > 0.0 && excess <= 1e-6 * width) {
        best.offer({i, fraction, here.v_m, 0.0}, outside(here.v_m), std::abs(here.v_m));
      } else {
        best.offer({i, fraction, here.v_m, 0.0}, std::hypot(excess, outside(here.v_m)),
                   std::hypot(excess, here.v_m));
      }
    }
    here = next;
  }
}

// Before the first and behind the last mitre line the road goes straight on.
void Locator::search_ends(double x_m, double y_m, Best& best) const noexcept {
  const auto offer = [&](std::size_t segment, double fraction, double beyond_m, double v_m,
                         double allowed_m) {
    const double excess = std::max(0.0, std::abs(beyond_m) - allowed_m);
    best.offer({segment, fraction, v_m, beyond_m}, std::hypot(excess, outside(v_m)),
               std::hypot(excess, v_m));
  };
  const Local start(records_.front().frame, x_m, y_m);
  if (start.past_begin_m < 0.0)
    offer(0, 0.0, start.past_begin_m, start.v_m, closing_.before_start_m);
  const Local end(records_.back().frame, x_m, y_m);
  if (end.past_begin_m >= 0.0) {
    offer(records_.size() - 2, 1.0, end.past_begin_m, end.v_m, closing_.after_end_m);
  }
}

Place Locator::search(double x_m, double y_m) const noexcept {
  Best best;
  search_ends(x_m, y_m, best);
  const auto distance = [&](const Box& box) {
    const double dx = std::max(
        {0.0, static_cast<double>(box.x_min_m) - x_m, x_m - static_cast<double>(box.x_max_m)});
    const double dy = std::max(
        {0.0, static_cast<double>(box.y_min_m) - y_m, y_m - static_cast<double>(box.y_max_m)});
    // |point - foot| <= stretch |v| for the foot of the point on its segment.
    return std::sqrt(dx * dx + dy * dy) / static_cast<double>(box.stretch) * (1.0 - 1e-12);
  };
  struct Entry {
    std::size_t box;
    double distance_m;
  };
  Entry stack[kMaxDepth];
  int depth = 0;
  stack[depth++] = {0, distance(boxes_[0])};
  while (depth > 0) {
    const Entry entry = stack[--depth];
    const double least_outside = std::max(0.0, entry.distance_m - reach_m_);
    if (least_outside > best.outside_m) continue;
    if (best.outside_m == 0.0 && entry.distance_m > best.distance_m) continue;
    if (entry.box >= first_leaf_) {
      if (boxes_[entry.box].x_min_m <= boxes_[entry.box].x_max_m)
        search_leaf(entry.box - first_leaf_, x_m, y_m, best);
      continue;
    }
    Entry a{2 * entry.box + 1, distance(boxes_[2 * entry.box + 1])};
    Entry b{2 * entry.box + 2, distance(boxes_[2 * entry.box + 2])};
    if (a.distance_m < b.distance_m) std::swap(a, b);
    stack[depth++] = a;
    stack[depth++] = b;
  }
  return best.place;
}

Place Locator::locate_from(double x_m, double y_m, Cursor& cursor) const noexcept {
  return locate_from(x_m, y_m, cursor, [](std::size_t, float) {});
}

}  // namespace crg
