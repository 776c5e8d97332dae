#include "row_walk.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "wide.h"

namespace road {

namespace {

constexpr std::size_t kLanes = kWalkRows;
constexpr float kRayStart_m = 2.0f;  // above the predicted road: lower than any bridge, Embree's best precision
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr std::array<float, kLanes> kNoLimit{};

/// Four neighbouring columns of four rows become four columns of each row.
[[gnu::always_inline]] inline void transpose(const float* column, float* row, std::size_t row_length) {
  using Four = float __attribute__((vector_size(16)));
  Four a, b, c, d;
  std::memcpy(&a, column, 16);
  std::memcpy(&b, column + kLanes, 16);
  std::memcpy(&c, column + 2 * kLanes, 16);
  std::memcpy(&d, column + 3 * kLanes, 16);
  const Four ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5), ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Four cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5), cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  const std::array<Four, 4> rows{
      __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5), __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7),
      __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5), __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7)};
  for (std::size_t k = 0; k < 4; ++k) std::memcpy(row + k * row_length, &rows[k], 16);
}

/// Most tiles are whole and of one class: then every byte is as the one before it.
[[gnu::always_inline]] inline bool alike(const void* bytes, std::size_t size) {
  return std::memcmp(bytes, static_cast<const char*>(bytes) + 1, size - 1) == 0;
}

}  // namespace

RowWalk::RowWalk(const RoadMesh& road, const RaySurface& surface, const crg::ReferenceLine& line, const RowGuide& guide,
                 const RowLimits& limits, const SampleOptions& options, SampledGrid& out)
    : road_(road), surface_(surface), line_(line), guide_(guide), limits_(limits), options_(options), out_(out),
      v_m_(out.grid.v_m), origin_z_m_(surface.origin_m().z()), z_m_(v_m_.size()), class_(v_m_.size()), whole_(v_m_.size()) {
  left_.packet.max_depth_m = right_.packet.max_depth_m = 2.0f * kRayStart_m;
}

RowsCut RowWalk::sample(std::size_t first_row, std::size_t rows) {
  start_rows(first_row, rows);
  wide([&]() __attribute__((always_inline)) {
    walk_all();
    write();
  });
  return {left_.cut, right_.cut};
}

void RowWalk::start_rows(std::size_t first_row, std::size_t rows) {
  first_row_ = first_row;
  rows_ = rows;
  const Eigen::Vector3d& origin = surface_.origin_m();
  for (std::size_t k = 0; k < rows_; ++k) {
    const crg::Point2 p = crg::node_position(line_, first_row + k, 0.0), q = crg::node_position(line_, first_row + k, 1.0);
    x0_m_[k] = p.x_m - origin.x();
    y0_m_[k] = p.y_m - origin.y();
    normal_x_[k] = q.x_m - p.x_m;
    normal_y_[k] = q.y_m - p.y_m;
    start_z_m_[k] = static_cast<float>(guide_.z_m[first_row + k] - origin.z());
  }
  Heights none;
  none.fill(kNone);
  std::fill(z_m_.begin(), z_m_.end(), none);
  std::fill(class_.begin(), class_.end(), Classes{});
  std::fill(whole_.begin(), whole_.end(), 0);
  // Casting takes long enough for the memory of these rows to come near.
  const std::size_t first = first_row * v_m_.size(), end = first + rows * v_m_.size();
  for (std::size_t node = first; node < end; node += 16) __builtin_prefetch(&out_.grid.z_m[node], 1);
  for (std::size_t node = first; node < end; node += 64) {
    __builtin_prefetch(&out_.provenance[node], 1);
    __builtin_prefetch(&out_.surface_class[node], 1);
  }
}

void RowWalk::start_side(Side& side, std::size_t column, std::ptrdiff_t step, const float* limit_m) {
  side.limit_m = limit_m;
  side.column = static_cast<std::ptrdiff_t>(column);
  side.step = step;
  side.last_z_m = start_z_m_;
  side.last_v_m.fill(0.0);
  side.cut.fill(false);
  side.all_near = false;
  side.triangle.fill(std::numeric_limits<std::uint32_t>::max());
  side.packet.active.fill(0);
  for (std::size_t k = 0; k < rows_; ++k) side.packet.active[k] = -1;
  find_nearest_limit(side);
}

[[gnu::always_inline]] inline void RowWalk::walk_all() {
  const std::size_t middle = v_m_.size() / 2;
  // The line itself first, so that both sides start from what it found, as exactly as the grid holds it.
  start_side(left_, middle, 0, kNoLimit.data());
  cast(left_);
  take(left_);
  for (std::size_t k = 0; k < rows_; ++k) {
    const auto z = static_cast<float>(static_cast<double>(z_m_[middle][k]) + origin_z_m_);
    if (!std::isnan(z)) start_z_m_[k] = static_cast<float>(static_cast<double>(z) - origin_z_m_);
  }
  start_side(left_, middle + 1, 1, limits_.left_m.data() + first_row_);
  start_side(right_, middle - 1, -1, limits_.right_m.data() + first_row_);
  // In turns: the processor begins one cast while it finishes the other, whose result is not needed at once.
  bool left = cast(left_), right = cast(right_);
  while (left || right) {
    if (left) {
      take(left_);
      left = cast(left_);
    }
    if (right) {
      take(right_);
      right = cast(right_);
    }
  }
}

/// False when the side has come to its end.
[[gnu::always_inline]] inline bool RowWalk::cast(Side& side) {
  if (side.column < 0 || side.column >= static_cast<std::ptrdiff_t>(v_m_.size())) return false;
  const double v_m = v_m_[static_cast<std::size_t>(side.column)];
  if (std::abs(v_m) > side.nearest_limit_m) {
    update_last_v(side);
    for (std::size_t k = 0; k < rows_; ++k) {
      if (side.packet.active[k] == 0 || std::abs(v_m) <= static_cast<double>(side.limit_m[k])) continue;
      side.packet.active[k] = 0;
      side.cut[k] = std::abs(v_m - side.last_v_m[k]) < 2.0 * options_.v_step_m;
    }
    find_nearest_limit(side);
  }
  if (std::isinf(side.nearest_limit_m)) return false;
  RayPacket16& rays = side.packet;
  for (std::size_t k = 0; k < kLanes; ++k) rays.x_m[k] = static_cast<float>(x0_m_[k] + v_m * normal_x_[k]);
  for (std::size_t k = 0; k < kLanes; ++k) rays.y_m[k] = static_cast<float>(y0_m_[k] + v_m * normal_y_[k]);
  for (std::size_t k = 0; k < kLanes; ++k) rays.z_top_m[k] = side.last_z_m[k] + kRayStart_m;
  surface_.cast_down(rays);
  return true;
}

[[gnu::always_inline]] inline void RowWalk::take(Side& side) {
  if (take_if_all_near(side)) {
    side.all_near = true;
    side.before_m = v_m_[static_cast<std::size_t>(side.column)];
  } else {
    update_last_v(side);
    take_one_by_one(side);
    find_nearest_limit(side);
  }
  side.column += side.step;
}

void RowWalk::update_last_v(Side& side) const {
  if (side.all_near) side.last_v_m.fill(side.before_m);
  side.all_near = false;
}

void RowWalk::find_nearest_limit(Side& side) const {
  side.nearest_limit_m = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < rows_; ++k) {
    if (side.packet.active[k] != 0) side.nearest_limit_m = std::min(side.nearest_limit_m, static_cast<double>(side.limit_m[k]));
  }
}

/// False, and nothing taken, when a row misses or steps.
[[gnu::always_inline]] inline bool RowWalk::take_if_all_near(Side& side) {
  const RayPacket16& rays = side.packet;
  const auto step_m = static_cast<float>(options_.max_step_m);
  std::int32_t near = -1;
  std::uint32_t other = 0;
  for (std::size_t k = 0; k < kLanes; ++k) near &= -static_cast<std::int32_t>(std::abs(rays.z_m[k] - side.last_z_m[k]) <= step_m);
  for (std::size_t k = 0; k < kLanes; ++k) other |= rays.triangle[k] ^ side.triangle[k];
  if (near == 0) return false;
  const auto column = static_cast<std::size_t>(side.column);
  for (std::size_t k = 0; k < kLanes; ++k) side.last_z_m[k] = rays.z_m[k];
  for (std::size_t k = 0; k < kLanes; ++k) z_m_[column][k] = rays.z_m[k];
  if (other != 0) {
    for (std::size_t k = 0; k < kLanes; ++k) side.triangle[k] = rays.triangle[k];
    for (std::size_t k = 0; k < kLanes; ++k) class_[column][k] = road_.class_of_triangle[rays.triangle[k]];
  } else {
    class_[column] = class_[side.class_column];
  }
  side.class_column = column;
  whole_[column] = 1;
  return true;
}

void RowWalk::take_one_by_one(Side& side) {
  const auto column = static_cast<std::size_t>(side.column);
  const double v_m = v_m_[column];
  for (std::size_t k = 0; k < rows_; ++k) {
    if (side.packet.active[k] == 0) continue;
    const double gap_m = std::abs(v_m - side.last_v_m[k]);
    // Across a gap the surface may have climbed with any slope a road has.
    const double reach_m = options_.max_step_m + 0.5 * std::max(0.0, gap_m - options_.v_step_m);
    float z = side.packet.z_m[k];
    std::uint32_t triangle = side.packet.triangle[k];
    if (!(std::abs(z - side.last_z_m[k]) <= static_cast<float>(reach_m)) && !std::isnan(z)) {
      const auto& origin = surface_.origin_m();
      const auto other = surface_.nearest_hit(static_cast<double>(side.packet.x_m[k]) + origin.x(),
                                              static_cast<double>(side.packet.y_m[k]) + origin.y(),
                                              static_cast<double>(side.last_z_m[k]) + origin.z(), reach_m);
      z = other ? static_cast<float>(other->z_m - origin.z()) : kNone;
      if (other) triangle = other->triangle;
    }
    if (!std::isnan(z)) {
      z_m_[column][k] = side.last_z_m[k] = z;
      class_[column][k] = road_.class_of_triangle[triangle];
      side.last_v_m[k] = v_m;
    } else if (gap_m > options_.max_gap_m + options_.v_step_m && std::abs(v_m) > guide_.half_width_m[first_row_ + k]) {
      side.packet.active[k] = 0;  // outside the known road, a gap ends the surface; inside it is a hole
    }
  }
}

[[gnu::always_inline]] inline void RowWalk::write() {
  const std::size_t columns = v_m_.size();
  for (std::size_t first = 0; first < columns; first += kLanes) {
    // The last tile overlaps the one before it: whole tiles are faster.
    if (first + kLanes > columns && columns >= kLanes) first = columns - kLanes;
    write_tile(first, std::min(kLanes, columns - first));
  }
}

[[gnu::always_inline]] inline void RowWalk::write_tile(std::size_t first, std::size_t width) {
  const std::size_t columns = v_m_.size(), first_node = first_row_ * columns + first;
  float* z_m = out_.grid.z_m.data() + first_node;
  SurfaceClass* surface_class = out_.surface_class.data() + first_node;
  Provenance* provenance = out_.provenance.data() + first_node;

  alignas(64) std::array<Heights, kLanes> z;
  for (std::size_t j = 0; j < width; ++j) {
    for (std::size_t k = 0; k < kLanes; ++k) z[j][k] = static_cast<float>(static_cast<double>(z_m_[first + j][k]) + origin_z_m_);
  }
  const bool full = width == kLanes && rows_ == kLanes;
  if (full) {
    for (std::size_t j = 0; j < kLanes; j += 4) {
      for (std::size_t k = 0; k < kLanes; k += 4) transpose(z[j].data() + k, z_m + k * columns + j, columns);
    }
  } else {
    for (std::size_t k = 0; k < rows_; ++k) {
      for (std::size_t j = 0; j < width; ++j) z_m[k * columns + j] = z[j][k];
    }
  }
  const bool whole = full && whole_[first] != 0 && alike(&whole_[first], width);
  const bool one_class = full && alike(class_[first].data(), width * kLanes);
  for (std::size_t k = 0; k < rows_; ++k) {
    const std::size_t node = k * columns;
    if (whole) {
      std::memset(provenance + node, static_cast<int>(Provenance::mesh), kLanes);
    } else {
      for (std::size_t j = 0; j < width; ++j) provenance[node + j] = std::isnan(z[j][k]) ? Provenance::none : Provenance::mesh;
    }
    if (one_class) {
      std::memset(surface_class + node, static_cast<int>(class_[first][0]), kLanes);
    } else {
      for (std::size_t j = 0; j < width; ++j) surface_class[node + j] = class_[first + j][k];
    }
  }
}

}  // namespace road
