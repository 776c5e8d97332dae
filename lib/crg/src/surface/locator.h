// Where a map point lies on the road: (x, y) -> cell of the reference line and place in it.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "closing.h"
#include "coarse_index.h"
#include "crg/surface.h"
#include "line_geometry.h"

namespace crg {

/// Place of a point. fraction is 0 at the first node of the segment, 1 at the second; below 0 or
/// above 1 only before the first and behind the last segment, where beyond_m tells how far (< 0,
/// > 0).
struct Place {
  std::size_t segment = 0;
  double fraction = 0.0;
  double v_m = 0.0;
  double beyond_m = 0.0;
};

/// Of all cells that hold the point, the one where it is least outside [v_right, v_left], then the
/// one with the smallest |v|, then the first. Cell i holds a point that lies on or behind mitre
/// line i and before mitre line i + 1. The extensions before the start and behind the end count as
/// outside by their length. Every finite point has a place.
class Locator {
 public:
  Locator() = default;
  /// `records`: segment_records() of the line; the rest says what else there is of it.
  Locator(std::vector<SegmentRecord> records, double u_step_m, double v_right_m, double v_left_m,
          bool joined, const Closing& closing);

  /// Starts from the cursor and moves it; a good cursor is fast, the answer is the same for all.
  Place locate(double x_m, double y_m, Cursor& cursor) const noexcept {
    Place place;
    if (!locate_ahead(x_m, y_m, cursor, place)) [[unlikely]]
      place = locate_from(x_m, y_m, cursor);
    return place;
  }
  /// The common case: the cell predicted from the last step of the cursor certainly holds the
  /// point, which then lies within the v range. Otherwise false, and nothing is changed.
  bool locate_ahead(double x_m, double y_m, Cursor& cursor, Place& place) const noexcept;
  /// The same for a known segment.
  bool locate_on(std::size_t segment, double x_m, double y_m, Place& place) const noexcept;
  /// The segment that a straight line leads to, seen from a given one: a guess for points near it.
  std::size_t straight_from(std::size_t segment, double segments_per_m, double x_m,
                            double y_m) const noexcept;
  /// Anywhere. `on_guess(segment, v_m)` is told where the search will go on after a jump, so that
  /// the caller can fetch what it will need there.
  Place locate_from(double x_m, double y_m, Cursor& cursor) const noexcept;
  template <typename OnGuess>
  Place locate_from(double x_m, double y_m, Cursor& cursor, const OnGuess& on_guess) const noexcept;

  /// Where a search for a point would begin, and its v there; kNone where the tables know nothing.
  CoarseIndex::Guess guess(double x_m, double y_m) const noexcept {
    return coarse_.guess(x_m, y_m);
  }
  const SegmentRecord* records() const { return records_.data(); }
  std::size_t segments() const { return segments_; }

 private:
  struct Box {  // rounded outwards
    float x_min_m, x_max_m, y_min_m, y_max_m;
    float stretch;
  };
  struct Best;

  void make_boxes();
  Box box_of(std::size_t leaf) const;
  bool locate_near(double x_m, double y_m, std::size_t hint, double farthest,
                   Place& place) const noexcept;
  Place search(double x_m, double y_m) const noexcept;
  void search_leaf(std::size_t leaf, double x_m, double y_m, Best& best) const noexcept;
  void search_ends(double x_m, double y_m, Best& best) const noexcept;
  double outside(double v_m) const noexcept;

  std::vector<SegmentRecord> records_;  ///< one per segment, and one for the last node
  std::size_t segments_ = 0;
  CoarseIndex coarse_;
  std::vector<Box> boxes_;  ///< binary tree, children of k at 2k + 1 and 2k + 2
  std::size_t first_leaf_ = 0;
  double v_right_m_ = 0.0, v_left_m_ = 0.0, reach_m_ = 0.0;
  bool joined_ = false;
  Closing closing_;
};

/// One for every segment of the line, and one for its last node. Nothing is certain yet. Takes the
/// nodes out of the line, the first half of them half-way: whole beside all records they would be
/// the most memory that a road takes while it becomes ready.
std::vector<SegmentRecord> segment_records(ReferenceLine& line);

/// A point in the frame of a segment.
struct Local {
  double s_m, v_m;
  double past_begin_m;  ///< > 0 behind the mitre line at the segment's first node

  Local(const SegmentFrame& frame, double x_m, double y_m) {
    const double dx = x_m - frame.x_m, dy = y_m - frame.y_m;
    s_m = dx * frame.cos + dy * frame.sin;
    v_m = dy * frame.cos - dx * frame.sin;
    past_begin_m = s_m - v_m * frame.begin_lean;
  }
};

inline constexpr double kNearMitre =
    1e-6;  // fraction of a cell: nearer than that both sides are asked

/// What a cursor's numbers are more than positions. So large a number has its bits at fixed places:
/// the segment is read from them with a shift and taken off with a mask, where a conversion would
/// pass between two kinds of registers. The fraction has 19 bits.
inline constexpr double kCursorBias = 12884901888.0;  // 1.5 * 2^33
inline constexpr int kFractionBits = 19;
inline constexpr std::uint64_t kSegmentMask = ~std::uint64_t{0} << kFractionBits;

/// Where the next query is expected, modulo 2^32: beyond all segments for a new cursor.
inline std::uint32_t segment_ahead(const Cursor& cursor) noexcept {
  return static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(cursor.ahead) >> kFractionBits);
}
/// The beginning of that segment, as a cursor counts.
inline double begin_ahead(const Cursor& cursor) noexcept {
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(cursor.ahead) & kSegmentMask);
}
/// Whether the last step led to a smaller segment number.
inline bool leads_back(const Cursor& cursor) noexcept {
  return std::bit_cast<std::int64_t>(cursor.ahead) < std::bit_cast<std::int64_t>(cursor.last);
}

/// As if the last query had been there and the next were expected `advance` segments further on.
inline Cursor cursor_at(double position, double advance = 0.0) noexcept {
  return {position + kCursorBias, position + advance + kCursorBias};
}

inline Cursor middle_of(std::size_t segment) noexcept {
  return cursor_at(static_cast<double>(segment) + 0.5);
}

inline bool is_new(const Cursor& cursor) noexcept { return cursor.ahead == Cursor{}.ahead; }

inline bool Locator::locate_on(std::size_t segment, double x_m, double y_m,
                               Place& place) const noexcept {
  const SegmentRecord& record = records_[segment];
  const SegmentFrame& frame = record.frame;
  const Local local(frame, x_m, y_m);
  const double fraction = local.past_begin_m / frame.width(local.v_m);
  // What is certain lies where the cell is not folded, so the width is positive. NaN fails too.
  // As whole numbers the bits of doubles that are not negative keep their order.
  if (std::bit_cast<std::uint64_t>(fraction) >= std::bit_cast<std::uint64_t>(1.0 - kNearMitre) ||
      !record.surely_certain(local.v_m)) [[unlikely]]
    return false;
  place.segment = segment;
  place.fraction = fraction;
  place.v_m = local.v_m;
  place.beyond_m = 0.0;
  return true;
}

inline std::size_t Locator::straight_from(std::size_t segment, double segments_per_m, double x_m,
                                          double y_m) const noexcept {
  constexpr double kFar = 64.0;
  const double ahead = Local(records_[segment].frame, x_m, y_m).past_begin_m * segments_per_m;
  if (!(std::abs(ahead) < kFar)) return segment;
  // Cut off, not rounded: what is added first keeps it above 0.
  const std::size_t next = segment + static_cast<std::size_t>(ahead + kFar);
  constexpr auto kBack = static_cast<std::size_t>(kFar);
  return next >= kBack && next - kBack < segments_ ? next - kBack : segment;
}

inline bool Locator::locate_ahead(double x_m, double y_m, Cursor& cursor,
                                  Place& place) const noexcept {
  const std::size_t i = segment_ahead(cursor);
  if (i >= segments_ || !locate_on(i, x_m, y_m, place)) [[unlikely]]
    return false;
  const double now = begin_ahead(cursor) + place.fraction;
  cursor.ahead = now + (now - cursor.last);  // once more as far
  cursor.last = now;
  return true;
}

template <typename OnGuess>
Place Locator::locate_from(double x_m, double y_m, Cursor& cursor,
                           const OnGuess& on_guess) const noexcept {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kMax = std::numeric_limits<double>::max();
  // Farther than this from the cursor, the tables are faster than walking.
  constexpr double kWalk = 32.0;
  if (!(std::abs(x_m) <= kMax && std::abs(y_m) <= kMax)) return {0, 0.0, kNaN, kNaN};
  Place place;
  bool found = false;
  if (!is_new(cursor)) {
    const auto expected = static_cast<std::int32_t>(segment_ahead(cursor));
    found = locate_near(x_m, y_m, static_cast<std::size_t>(std::max(expected, 0)), kWalk, place);
  }
  if (!found) {
    const CoarseIndex::Guess guess = coarse_.guess(x_m, y_m);
    if (guess.segment != CoarseIndex::kNone) {
      on_guess(guess.segment, guess.v_m);
      found = locate_on(guess.segment, x_m, y_m, place) ||
              locate_near(x_m, y_m, guess.segment, 4096.0, place);
    }
  }
  if (!found) place = search(x_m, y_m);
  const double position = static_cast<double>(place.segment) + place.fraction;
  const double moved = position + kCursorBias - cursor.last;
  cursor = cursor_at(position, std::abs(moved) < 64.0 ? moved : 0.0);
  return place;
}

}  // namespace crg
