#include "tile_heights.h"

#include <fmt/format.h>

#include <cstring>
#include <limits>
#include <vector>

#include "base/text_lines.h"
#include "file_part.h"
#include "wish.h"

namespace view {

std::string heights_over(const crg::Surface& road, const std::string& tiles_path,
                         const TilePlace& place) {
  constexpr std::size_t kPlaceBytes = 3 * sizeof(float), kMostPoints = 1'000'000;
  const auto points = base::to_number<std::size_t>(place.points);
  if (!points || *points > kMostPoints)
    throw Refusal(400, fmt::format("points: '{}' seen, a whole number up to {} wanted",
                                   place.points, kMostPoints));
  const std::string bytes =
      part_of_file(tiles_path, place.begin, std::to_string(*points * kPlaceBytes));
  const std::size_t count = bytes.size() / kPlaceBytes;
  std::vector<float> xyz_m(3 * count), above_m(count);
  std::memcpy(xyz_m.data(), bytes.data(), bytes.size());
  const crg::Grid& grid = road.grid();
  const double u_end_m = grid.u_of(grid.rows() - 1);
  crg::Cursor cursor;
  for (std::size_t k = 0; k < count; ++k) {
    const auto map_m = [&](std::size_t axis) {
      return place.origin_m[axis] + static_cast<double>(xyz_m[3 * k + axis]);
    };
    const crg::UV at = road.uv_of_xy(map_m(0), map_m(1), cursor);
    const bool is_on = at.u_m >= grid.u_of(0) && at.u_m <= u_end_m && at.v_m >= grid.v_m.front() &&
                       at.v_m <= grid.v_m.back();
    above_m[k] = is_on ? static_cast<float>(map_m(2) - road.z_at_uv(at.u_m, at.v_m))
                       : std::numeric_limits<float>::quiet_NaN();
  }
  return {reinterpret_cast<const char*>(above_m.data()), count * sizeof(float)};
}

}  // namespace view
