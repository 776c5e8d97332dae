#include "recording/place.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "base/error.h"

namespace recording {
namespace {

/// A point of the WGS84 ellipsoid in Earth-centred coordinates.
std::array<double, 3> earth_centred(double latitude_rad, double longitude_rad) {
  constexpr double kEquator_m = 6378137.0, kFlattening = 1.0 / 298.257223563;
  constexpr double kEccentricity2 = kFlattening * (2.0 - kFlattening);
  const double s = std::sin(latitude_rad), c = std::cos(latitude_rad);
  const double radius_m = kEquator_m / std::sqrt(1.0 - kEccentricity2 * s * s);
  return {radius_m * c * std::cos(longitude_rad), radius_m * c * std::sin(longitude_rad),
          radius_m * (1.0 - kEccentricity2) * s};
}

const ColumnMapping* find(const Mapping& mapping, const char* channel) {
  for (const ColumnMapping& map : mapping.columns)
    if (map.channel == channel) return &map;
  return nullptr;
}

}  // namespace

void put_on_plane(Table& log, Mapping& mapping, const std::string& name) {
  const ColumnMapping* const latitude = find(mapping, "latitude_rad");
  const ColumnMapping* const longitude = find(mapping, "longitude_rad");
  if (latitude == nullptr || longitude == nullptr || find(mapping, "x_m") != nullptr ||
      find(mapping, "y_m") != nullptr)
    return;
  const std::vector<double>* const phi = log.find(latitude->column);
  const std::vector<double>* const lambda = log.find(longitude->column);
  if (phi == nullptr || lambda == nullptr) return;  // refused by name elsewhere
  if (!mapping.has_origin)
    throw base::Error(
        fmt::format("{}: latitudes, but {} has no origin_latitude_deg and "
                    "origin_longitude_deg; crgexplain map proposes them",
                    name, mapping.path.empty() ? "the mapping" : mapping.path));
  const double degree = std::numbers::pi / 180.0;
  const double phi0 = mapping.origin_latitude_deg * degree,
               lambda0 = mapping.origin_longitude_deg * degree;
  const std::array<double, 3> origin = earth_centred(phi0, lambda0);
  const double turn_c = std::cos(mapping.place_turn_rad), turn_s = std::sin(mapping.place_turn_rad);
  std::vector<double> x(phi->size()), y(phi->size());
  for (std::size_t i = 0; i < phi->size(); ++i) {
    const auto p = earth_centred((*phi)[i] * latitude->scale + latitude->offset,
                                 (*lambda)[i] * longitude->scale + longitude->offset);
    const double dx = p[0] - origin[0], dy = p[1] - origin[1], dz = p[2] - origin[2];
    const double east = -std::sin(lambda0) * dx + std::cos(lambda0) * dy;
    const double outward = std::cos(lambda0) * dx + std::sin(lambda0) * dy;
    const double north = -std::sin(phi0) * outward + std::cos(phi0) * dz;
    x[i] = turn_c * east - turn_s * north + mapping.place_x_m;
    y[i] = turn_s * east + turn_c * north + mapping.place_y_m;
  }
  const double delay_s = latitude->delay_s, low_pass_s = latitude->low_pass_s;
  const bool held = latitude->held;
  std::erase_if(mapping.columns, [](const ColumnMapping& map) {
    return map.channel == "latitude_rad" || map.channel == "longitude_rad";
  });
  const auto add = [&](std::string column, const char* channel, std::vector<double> values) {
    while (log.find(column) != nullptr) column += '\'';
    mapping.columns.push_back({column, channel, 1.0, 0.0, delay_s, low_pass_s, held});
    log.add(column, std::move(values));
  };
  add("east of origin", "x_m", std::move(x));
  add("north of origin", "y_m", std::move(y));
}

}  // namespace recording
