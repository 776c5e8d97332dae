#include "vehicle/road_file.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "vehicle/error.h"

namespace vehicle {

RoadFiles read_road(const std::string& track_path, const std::string& friction_path) {
  std::string remark;
  crg::SurfaceOptions options;
  if (!friction_path.empty()) {
    constexpr double kMost = 3.0;  // as environment.road_grip
    options.friction_map = crg::read(friction_path);
    const crg::Grid& grid = options.friction_map->grid;
    std::size_t holes = 0;
    for (std::size_t i = 0; i < grid.z_m.size(); ++i) {
      const double grip = grid.z_m[i];
      if (std::isnan(grip)) {
        ++holes;
      } else if (!(grip >= 0.0 && grip <= kMost)) {
        throw Error(fmt::format(
            "{}: grip factor {:g} at row {}, column {}; wanted 0 to {:g}: heights of this file are "
            "factors on the tyres' grip",
            friction_path, grip, i / grid.columns(), i % grid.columns(), kMost));
      }
    }
    if (holes > 0 && holes == grid.z_m.size())
      throw Error(friction_path + ": no grip factor at all, every value is empty");
    if (holes > 0)
      remark =
          fmt::format("{}: {:.1f} % of the grip factors are empty; there it is 1", friction_path,
                      100.0 * static_cast<double>(holes) / static_cast<double>(grid.z_m.size()));
  }
  return {crg::Surface(crg::read(track_path), std::move(options)), std::move(remark)};
}

}  // namespace vehicle
