#include "row_walk.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "crg/huge_pages.h"
#include "wide.h"

namespace road {

namespace {

constexpr std::size_t kLanes = kWalkRows;
constexpr float kRayStart_m =
    2.0f;  // above the predicted road: lower than any bridge, Embree's best precision
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr std::array<float, kLanes> kNoLimit{};

/// NaN without hit.
float height_m(const RayPacket16& rays, std::size_t k) {
  return static_cast<std::int32_t>(rays.geometry[k]) < 0 ? kNone
                                                         : rays.z_top_m[k] - rays.depth_m[k];
}

}  // namespace

RowWalk::RowWalk(const RoadMesh& road, const RaySurface& surface, const crg::ReferenceLine& line,
                 const RowGuide& guide, const RowLimits& limits, const SampleOptions& options,
                 SampledGrid& out)
    : road_(road),
      surface_(surface),
      line_(line),
      guide_(guide),
      limits_(limits),
      options_(options),
      out_(out),
      v_m_(out.grid.v_m.data()),
      columns_(out.grid.columns()),
      origin_z_m_(surface.origin_m().z()) {}

RowsReached RowWalk::sample(std::size_t first_row, std::size_t rows) {
  start_rows(first_row, rows);
  RowsReached reached;
  wide([&]() __attribute__((always_inline)) { reached = walk_all(); });
  leave_out_empty_columns(reached);
  return reached;
}

void RowWalk::start_rows(std::size_t first_row, std::size_t rows) {
  first_row_ = first_row;
  rows_ = rows;
  const Eigen::Vector3d& origin = surface_.origin_m();
  for (std::size_t k = 0; k < rows_; ++k) {
    const std::size_t row = first_row + k;
    const crg::Point2 q = crg::node_position(line_, row, 1.0);
    const crg::Point2 p = row + 1 < line_.size() ? crg::Point2{line_.x_m[row], line_.y_m[row]}
                                                 : crg::node_position(line_, row, 0.0);
    x0_m_[k] = p.x_m - origin.x();
    y0_m_[k] = p.y_m - origin.y();
    normal_x_[k] = q.x_m - p.x_m;
    normal_y_[k] = q.y_m - p.y_m;
    start_z_m_[k] = static_cast<float>(guide_.z_m[first_row + k] - origin.z());
  }
  z_m_ = out_.grid.z_m.data() + first_row * columns_;
  class_ = out_.surface_class.data() + first_row * columns_;
}

void RowWalk::start_side(Side& side, std::size_t column, std::ptrdiff_t step,
                         const float* limit_m) {
  side.limit_m = limit_m;
  side.column = static_cast<std::ptrdiff_t>(column);
  side.end = step < 0 ? -1 : static_cast<std::ptrdiff_t>(columns_);
  side.step = step;
  side.last_z_m = start_z_m_;
  side.last_v_m.fill(0.0);
  side.cut.fill(false);
  side.all_near_v_m = kNone;
  side.triangle = Ints16{} - 1;  // of none
  side.packet.active.fill(0);
  std::fill_n(side.packet.active.begin(), rows_, -1);
  find_nearest_limit(side);
}

[[gnu::always_inline]] inline RowsReached RowWalk::walk_all() {
  const std::size_t middle = columns_ / 2;
  Side side;
  RowsReached reached;
  // The line itself first, so that both sides start from what it found, as exactly as the grid
  // holds it.
  start_side(side, middle, 0, kNoLimit.data());
  cast(side);
  take(side);
  for (std::size_t k = 0; k < rows_; ++k) {
    const auto z = static_cast<float>(static_cast<double>(z_m_[middle * rows_ + k]) + origin_z_m_);
    if (!std::isnan(z)) start_z_m_[k] = static_cast<float>(static_cast<double>(z) - origin_z_m_);
  }
  for (const bool left : {true, false}) {
    start_side(side, left ? middle + 1 : middle - 1, left ? 1 : -1,
               (left ? limits_.left_m : limits_.right_m).data() + first_row_);
    while (cast(side)) take(side);
    (left ? reached.left_cut : reached.right_cut) = side.cut;
    (left ? reached.end_column : reached.first_column) =
        static_cast<std::size_t>(left ? side.column : side.column + 1);
  }
  return reached;
}

/// False when the side has come to its end.
[[gnu::always_inline]] inline bool RowWalk::cast(Side& side) {
  if (side.column == side.end) return false;
  const double v_m = v_m_[side.column];
  if (std::abs(v_m) > side.nearest_limit_m && !end_rows(side, v_m)) return false;
  RayPacket16& rays = side.packet;
  const auto places = [v_m](const double* start_m, const double* normal, float* out_m)
      __attribute__((always_inline)) {
    const Floats8 low = __builtin_convertvector(
        lanes<const Doubles8>(start_m) + v_m * lanes<const Doubles8>(normal), Floats8);
    const Floats8 high = __builtin_convertvector(
        lanes<const Doubles8>(start_m + 8) + v_m * lanes<const Doubles8>(normal + 8), Floats8);
    lanes<Floats16>(out_m) =
        __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  };
  places(x0_m_.data(), normal_x_.data(), rays.x_m.data());
  places(y0_m_.data(), normal_y_.data(), rays.y_m.data());
  lanes<Floats16>(rays.z_top_m.data()) = side.last_z_m + kRayStart_m;
  lanes<Floats16>(rays.depth_m.data()) = Floats16{} + 2.0f * kRayStart_m;
  lanes<Ints16>(rays.geometry.data()) = Ints16{} - 1;
  surface_.cast_prepared(rays);
  return true;
}

/// The rows whose limit lies before v_m end. False when none is left.
bool RowWalk::end_rows(Side& side, double v_m) const {
  update_last_v(side);
  for (std::size_t k = 0; k < rows_; ++k) {
    if (side.packet.active[k] == 0 || std::abs(v_m) <= static_cast<double>(side.limit_m[k]))
      continue;
    side.packet.active[k] = 0;
    side.cut[k] = std::abs(v_m - side.last_v_m[k]) < 2.0 * *options_.v_step_m;
  }
  find_nearest_limit(side);
  return side.nearest_limit_m >= 0.0;
}

[[gnu::always_inline]] inline void RowWalk::take(Side& side) {
  if (take_if_all_near(side)) {
    side.all_near_v_m = v_m_[side.column];
  } else {
    update_last_v(side);
    take_one_by_one(side);
  }
  side.column += side.step;
}

void RowWalk::update_last_v(Side& side) const {
  if (!std::isnan(side.all_near_v_m)) side.last_v_m.fill(side.all_near_v_m);
  side.all_near_v_m = kNone;
}

void RowWalk::find_nearest_limit(Side& side) const {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < rows_; ++k) {
    if (side.packet.active[k] != 0)
      nearest_m = std::min(nearest_m, static_cast<double>(side.limit_m[k]));
  }
  side.nearest_limit_m = std::isinf(nearest_m) ? -1.0 : nearest_m;
}

/// False, and nothing taken, when a row misses or steps.
[[gnu::always_inline]] inline bool RowWalk::take_if_all_near(Side& side) {
  const auto& missed = lanes<const Ints16>(
      side.packet.geometry.data());  // all bits where nothing was hit, which is a NaN
  const Floats16 hit_z_m = lanes<const Floats16>(side.packet.z_top_m.data()) -
                           lanes<const Floats16>(side.packet.depth_m.data());
  const auto z_m = reinterpret_cast<Floats16>(reinterpret_cast<Ints16>(hit_z_m) | missed);
  const auto& triangle = lanes<const Ints16>(side.packet.triangle.data());
  // The bits of floats without sign are in the order of the floats, NaN last.
  const auto step = std::bit_cast<std::int32_t>(static_cast<float>(*options_.max_step_m));
  const Ints16 change =
      reinterpret_cast<Ints16>(z_m - side.last_z_m) & std::numeric_limits<std::int32_t>::max();
  const Ints16 far = (step - change) & std::numeric_limits<std::int32_t>::min(),
               other = triangle ^ side.triangle;
  const auto column = static_cast<std::size_t>(side.column);
  SurfaceClass* surface_class = class_ + column * kLanes;
  if (!any(far | other)) {
    std::memcpy(surface_class, side.surface_class, kLanes);
  } else {
    if (any(far)) return false;
    side.triangle = triangle;
    for (std::size_t k = 0; k < kLanes; ++k)
      surface_class[k] = road_.class_of_triangle[side.packet.triangle[k]];
  }
  side.surface_class = surface_class;
  side.last_z_m = z_m;
  std::memcpy(z_m_ + column * kLanes, &z_m, sizeof z_m);
  return true;
}

void RowWalk::take_one_by_one(Side& side) {
  const auto column = static_cast<std::size_t>(side.column);
  const double v_m = v_m_[column];
  float* z_m = z_m_ + column * rows_;
  std::fill_n(z_m, rows_, kNone);
  bool ended = false;
  for (std::size_t k = 0; k < rows_; ++k) {
    if (side.packet.active[k] == 0) continue;
    const double gap_m = std::abs(v_m - side.last_v_m[k]);
    // Across a gap the surface may have climbed with any slope a road has.
    const double reach_m = *options_.max_step_m + 0.5 * std::max(0.0, gap_m - *options_.v_step_m);
    float z = height_m(side.packet, k);
    std::uint32_t triangle = side.packet.triangle[k];
    if (!(std::abs(z - side.last_z_m[k]) <= static_cast<float>(reach_m)) && !std::isnan(z)) {
      const auto& origin = surface_.origin_m();
      const auto other =
          surface_.nearest_hit(static_cast<double>(side.packet.x_m[k]) + origin.x(),
                               static_cast<double>(side.packet.y_m[k]) + origin.y(),
                               static_cast<double>(side.last_z_m[k]) + origin.z(), reach_m);
      z = other ? static_cast<float>(other->z_m - origin.z()) : kNone;
      if (other) triangle = other->triangle;
    }
    if (!std::isnan(z)) {
      z_m[k] = side.last_z_m[k] = z;
      class_[column * rows_ + k] = road_.class_of_triangle[triangle];
      side.last_v_m[k] = v_m;
    } else if (gap_m > *options_.max_gap_m + *options_.v_step_m &&
               std::abs(v_m) > guide_.half_width_m[first_row_ + k]) {
      side.packet.active[k] =
          0;  // outside the known road, a gap ends the surface; inside it is a hole
      ended = true;
    }
  }
  if (ended) find_nearest_limit(side);
}

void RowWalk::leave_out_empty_columns(RowsReached& reached) const {
  const auto empty = [&](std::size_t column) {
    return std::all_of(z_m_ + column * rows_, z_m_ + (column + 1) * rows_,
                       [](float z) { return std::isnan(z); });
  };
  while (!reached.empty() && empty(reached.first_column)) ++reached.first_column;
  while (!reached.empty() && empty(reached.end_column - 1)) --reached.end_column;
}

namespace {

using Floats4 [[gnu::vector_size(16)]] = float;
using Bytes16 [[gnu::vector_size(16)]] = char;

/// A square of kN x kN values, read `from_step` apart, mirrored at its diagonal and written
/// `to_step` apart; kN of them are 16 bytes.
template <typename Vector, typename T, std::size_t... i>
[[gnu::always_inline]] inline void mirror(const T* from, std::size_t from_step, T* to,
                                          std::size_t to_step, std::index_sequence<i...>) {
  constexpr std::size_t kN = sizeof...(i);
  Vector square[kN], next[kN];
#pragma GCC unroll 16
  for (std::size_t k = 0; k < kN; ++k)
    std::memcpy(&square[k], from + k * from_step, sizeof(Vector));
    // Each time the two halves are interleaved, value by value, until every value has come round to
    // its place.
#pragma GCC unroll 16
  for (std::size_t done = 1; done < kN; done *= 2) {
#pragma GCC unroll 16
    for (std::size_t k = 0; k < kN / 2; ++k) {
      next[2 * k] = __builtin_shufflevector(square[k], square[k + kN / 2], (i / 2 + i % 2 * kN)...);
      next[2 * k + 1] =
          __builtin_shufflevector(square[k], square[k + kN / 2], (kN / 2 + i / 2 + i % 2 * kN)...);
    }
#pragma GCC unroll 16
    for (std::size_t k = 0; k < kN; ++k) square[k] = next[k];
  }
#pragma GCC unroll 16
  for (std::size_t k = 0; k < kN; ++k) std::memcpy(to + k * to_step, &square[k], sizeof(Vector));
}

/// `rows` rows of `columns` nodes from nodes that lie column by column.
template <typename Vector, typename T>
[[gnu::always_inline]] inline void turn(const T* from, std::size_t rows, std::size_t columns,
                                        T* to) {
  constexpr std::size_t kN = sizeof(Vector) / sizeof(T);
  if (rows == kLanes && columns >= kN) {
    for (std::size_t j = 0; j < columns; j += kN) {
      j = std::min(j, columns - kN);  // the last squares overlap those before them
      for (std::size_t k = 0; k < kLanes; k += kN) {
        mirror<Vector>(from + j * kLanes + k, kLanes, to + k * columns + j, columns,
                       std::make_index_sequence<kN>{});
      }
    }
  } else {
    for (std::size_t k = 0; k < rows; ++k) {
      for (std::size_t j = 0; j < columns; ++j) to[k * columns + j] = from[j * rows + k];
    }
  }
}

}  // namespace

void turn_into_rows(SampledGrid& out, std::size_t rows, const std::vector<RowsReached>& reached,
                    std::size_t first_column, std::size_t end_column, double origin_z_m) {
  const std::size_t all_rows = out.grid.rows(), columns = out.grid.columns(),
                    kept = end_column - first_column;
  std::vector<float> z_m(kept * kLanes);
  std::vector<SurfaceClass> surface_class(kept * kLanes);
  crg::reserve_huge(out.provenance, all_rows * kept);
  wide([&]() __attribute__((always_inline)) {
    for (std::size_t first = 0; first < rows; first += kLanes) {
      const std::size_t count = std::min(kLanes, rows - first), nodes = kept * count;
      const RowsReached& ends = reached[first / kLanes];
      const std::size_t begin = ends.empty() ? 0 : (ends.first_column - first_column) * count;
      const std::size_t end = ends.empty() ? 0 : (ends.end_column - first_column) * count;
      // A copy, because the rows come to lie where these or earlier columns were.
      const float* found = &out.grid.z_m[first * columns + first_column * count];
      const SurfaceClass* found_class = &out.surface_class[first * columns + first_column * count];
      std::fill_n(z_m.begin(), begin, kNone);
      for (std::size_t i = begin; i < end; ++i)
        z_m[i] = static_cast<float>(static_cast<double>(found[i]) + origin_z_m);
      std::fill(z_m.begin() + end, z_m.end(), kNone);
      std::fill_n(surface_class.begin(), begin, SurfaceClass{});
      std::copy(found_class + begin, found_class + end, surface_class.begin() + begin);
      std::fill(surface_class.begin() + end, surface_class.end(), SurfaceClass{});

      // The next columns come near while these are turned.
      for (std::size_t i = begin; i < end; i += 16)
        __builtin_prefetch(found + i + columns * kLanes);
      for (std::size_t i = begin; i < end; i += 64)
        __builtin_prefetch(found_class + i + columns * kLanes);
      out.provenance.resize(first * kept + nodes);
      float* z = &out.grid.z_m[first * kept];
      Provenance* provenance = &out.provenance[first * kept];
      turn<Floats4>(z_m.data(), count, kept, z);
      turn<Bytes16>(surface_class.data(), count, kept, &out.surface_class[first * kept]);
      for (std::size_t i = 0; i < nodes; ++i)
        provenance[i] = std::isnan(z[i]) ? Provenance::none : Provenance::mesh;
    }
  });
  const auto first = out.grid.v_m.begin() + static_cast<std::ptrdiff_t>(first_column);
  out.grid.v_m = {first, first + static_cast<std::ptrdiff_t>(kept)};
  out.grid.z_m.resize(all_rows * kept);
  out.provenance.resize(all_rows * kept);
  out.surface_class.resize(all_rows * kept);
}

}  // namespace road
