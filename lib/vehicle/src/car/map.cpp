#include "vehicle/map.h"

#include <fmt/format.h>

#include <cmath>

#include "vehicle/error.h"

namespace vehicle {
namespace {

void check_axis(const std::vector<double>& axis, const std::string& name, const char* which) {
  for (std::size_t i = 0; i < axis.size(); ++i) {
    if (!std::isfinite(axis[i]))
      throw Error(fmt::format("{}: value {} of the {} axis is not finite", name, i + 1, which));
    if (i > 0 && !(axis[i] > axis[i - 1]))
      throw Error(fmt::format("{}: the {} axis must ascend; value {} is {}, the one before {}",
                              name, which, i + 1, axis[i], axis[i - 1]));
  }
}

void check_values(const std::vector<double>& values, const std::string& name) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      throw Error(fmt::format("{}: value {} of the map is not finite", name, i + 1));
}

}  // namespace

void check_map(const Map1& map, const std::string& name) {
  if (map.x.size() != map.y.size())
    throw Error(fmt::format("{}: {} places but {} values", name, map.x.size(), map.y.size()));
  check_axis(map.x, name, "first");
  check_values(map.y, name);
}

void check_map(const Map2& map, const std::string& name) {
  if (map.x.size() * map.y.size() != map.z.size())
    throw Error(fmt::format("{}: axes of {} and {} places but {} values", name, map.x.size(),
                            map.y.size(), map.z.size()));
  check_axis(map.x, name, "first");
  check_axis(map.y, name, "second");
  check_values(map.z, name);
}

}  // namespace vehicle
