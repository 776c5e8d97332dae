#include "road/projection.h"

#include <fmt/format.h>

#include <GeographicLib/Constants.hpp>
#include <GeographicLib/TransverseMercator.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <cctype>
#include <charconv>
#include <cmath>
#include <utility>

#include "mesh/error.h"

namespace road {

namespace {

base::Answer<UtmZone> try_utm_zone(double latitude_deg, double longitude_deg) {
  if (!(std::abs(latitude_deg) <= 90.0) || !(std::abs(longitude_deg) <= 540.0)) {
    return base::Refusal(fmt::format(
        "latitude {} and longitude {} degrees; wanted at most 90 and 180; are they swapped?",
        latitude_deg, longitude_deg));
  }
  const int number = GeographicLib::UTMUPS::StandardZone(latitude_deg, longitude_deg);
  if (number < GeographicLib::UTMUPS::MINUTMZONE) {
    return base::Refusal(
        fmt::format("latitude {} degrees has no UTM zone; wanted 80 S to 84 N; give projected "
                    "coordinates x_m,y_m,z_m",
                    latitude_deg));
  }
  return UtmZone{number, latitude_deg >= 0.0};
}

base::Answer<Eigen::Vector2d> try_to_utm(const UtmZone& zone, double latitude_deg,
                                         double longitude_deg) {
  try {
    int number = 0;
    bool north = false;
    double x = 0.0, y = 0.0;
    GeographicLib::UTMUPS::Forward(latitude_deg, longitude_deg, number, north, x, y, zone.number);
    // Beyond the equator the zone's own false northing counts on.
    if (north != zone.north) y += north ? 10e6 : -10e6;
    return Eigen::Vector2d(x, y);
  } catch (const GeographicLib::GeographicErr& error) {
    return base::Refusal(fmt::format(
        "latitude {}, longitude {} degrees in UTM zone {}: {}; give points of one place",
        latitude_deg, longitude_deg, zone.number, error.what()));
  }
}

}  // namespace

UtmZone utm_zone(double latitude_deg, double longitude_deg) {
  return try_utm_zone(latitude_deg, longitude_deg).or_throw();
}

Eigen::Vector2d to_utm(const UtmZone& zone, double latitude_deg, double longitude_deg) {
  return try_to_utm(zone, latitude_deg, longitude_deg).or_throw();
}

Eigen::Vector2d from_utm(const UtmZone& zone, const Eigen::Vector2d& easting_northing_m) {
  try {
    double latitude_deg = 0.0, longitude_deg = 0.0;
    GeographicLib::UTMUPS::Reverse(zone.number, zone.north, easting_northing_m.x(),
                                   easting_northing_m.y(), latitude_deg, longitude_deg);
    return {latitude_deg, longitude_deg};
  } catch (const GeographicLib::GeographicErr& error) {
    throw Error(fmt::format("({:.1f}, {:.1f}) m in UTM zone {}{}: {}", easting_northing_m.x(),
                            easting_northing_m.y(), zone.number, zone.north ? 'N' : 'S',
                            error.what()));
  }
}

std::vector<crg::HeaderEntry> projection_header(const UtmZone& zone) {
  const double a = GeographicLib::Constants::WGS84_a();
  const double b = a * (1.0 - GeographicLib::Constants::WGS84_f());
  return {{"GELL_NM", 0.0, "WGS84"},
          {"GELL_A", a, ""},
          {"GELL_B", b, ""},
          {"LELL_NM", 0.0, "WGS84"},
          {"LELL_A", a, ""},
          {"LELL_B", b, ""},
          {"TRAN_NM", 0.0, "NOP"},
          {"PROJ_NM", 0.0, fmt::format("UTM_{:02}{}", zone.number, zone.north ? 'N' : 'S')}};
}

std::vector<crg::HeaderEntry> geographic_header(const UtmZone& zone,
                                                const crg::ReferenceLine& line) {
  std::vector<crg::HeaderEntry> entries;
  for (const auto& [which, i] :
       {std::pair<const char*, std::size_t>{"START", 0}, {"END", line.size() - 1}}) {
    const Eigen::Vector2d lat_lon = from_utm(zone, {line.x_m[i], line.y_m[i]});
    entries.push_back({fmt::format("REFERENCE_LINE_{}_LON", which), lat_lon.y(), ""});
    entries.push_back({fmt::format("REFERENCE_LINE_{}_LAT", which), lat_lon.x(), ""});
    entries.push_back(
        {fmt::format("REFERENCE_LINE_{}_ALT", which), line.z_m.empty() ? 0.0 : line.z_m[i], ""});
  }
  return entries;
}

namespace {

const GeographicLib::TransverseMercator& unit_scale_mercator() {
  static const GeographicLib::TransverseMercator mercator(GeographicLib::Constants::WGS84_a(),
                                                          GeographicLib::Constants::WGS84_f(), 1.0);
  return mercator;
}

}  // namespace

base::Answer<Projection> try_projection_at(Projection::Kind kind, double latitude_deg,
                                           double longitude_deg) {
  Projection projection;
  projection.kind = kind;
  const auto zone = try_utm_zone(latitude_deg, longitude_deg);
  if (!zone) return zone.refusal();
  projection.zone = *zone;
  projection.latitude_deg = latitude_deg;
  projection.longitude_deg = longitude_deg;
  return projection;
}

base::Answer<Eigen::Vector2d> try_project(const Projection& projection, double latitude_deg,
                                          double longitude_deg) {
  if (projection.kind == Projection::Kind::utm)
    return try_to_utm(projection.zone, latitude_deg, longitude_deg);
  if (!(std::abs(latitude_deg) <= 90.0) ||
      !(std::abs(std::remainder(longitude_deg - projection.longitude_deg, 360.0)) < 30.0)) {
    return base::Refusal(fmt::format(
        "latitude {}, longitude {} degrees; wanted positions around {}, {}: give points of one "
        "place",
        latitude_deg, longitude_deg, projection.latitude_deg, projection.longitude_deg));
  }
  double x = 0.0, y = 0.0, x0 = 0.0, y0 = 0.0;
  unit_scale_mercator().Forward(projection.longitude_deg, latitude_deg, longitude_deg, x, y);
  unit_scale_mercator().Forward(projection.longitude_deg, projection.latitude_deg,
                                projection.longitude_deg, x0, y0);
  return Eigen::Vector2d(x, y - y0);
}

Projection projection_at(Projection::Kind kind, double latitude_deg, double longitude_deg) {
  return try_projection_at(kind, latitude_deg, longitude_deg).or_throw();
}

Eigen::Vector2d project(const Projection& projection, double latitude_deg, double longitude_deg) {
  return try_project(projection, latitude_deg, longitude_deg).or_throw();
}

void write_projection(const Projection& projection, const crg::ReferenceLine& line,
                      crg::Crg& file) {
  if (projection.kind == Projection::Kind::none) return;
  file.projection = projection_header(projection.zone);
  if (projection.kind == Projection::Kind::utm) {
    const std::vector<crg::HeaderEntry> ends = geographic_header(projection.zone, line);
    file.road.insert(file.road.end(), ends.begin(), ends.end());
    return;
  }
  file.projection.back().text = "TM";
  file.projection.push_back({"PROJ_F0", 1.0, ""});
  file.projection.push_back({"PROJ_P0", projection.latitude_deg, ""});
  file.projection.push_back({"PROJ_L0", projection.longitude_deg, ""});
  file.projection.push_back({"PROJ_E0", 0.0, ""});
  file.projection.push_back({"PROJ_N0", 0.0, ""});
  double x0 = 0.0, y0 = 0.0;
  unit_scale_mercator().Forward(projection.longitude_deg, projection.latitude_deg,
                                projection.longitude_deg, x0, y0);
  for (const auto& [which, i] :
       {std::pair<const char*, std::size_t>{"START", 0}, {"END", line.size() - 1}}) {
    double latitude_deg = 0.0, longitude_deg = 0.0;
    unit_scale_mercator().Reverse(projection.longitude_deg, line.x_m[i], line.y_m[i] + y0,
                                  latitude_deg, longitude_deg);
    file.road.push_back({fmt::format("REFERENCE_LINE_{}_LON", which), longitude_deg, ""});
    file.road.push_back({fmt::format("REFERENCE_LINE_{}_LAT", which), latitude_deg, ""});
    file.road.push_back(
        {fmt::format("REFERENCE_LINE_{}_ALT", which), line.z_m.empty() ? 0.0 : line.z_m[i], ""});
  }
}

namespace {

/// The text of an entry, upper case; empty where there is none.
std::string text_of(const std::vector<crg::HeaderEntry>& entries, const std::string& key) {
  std::string text;
  for (const crg::HeaderEntry& entry : entries)
    if (entry.key == key) text = entry.text;
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

Projection read_projection(const crg::Crg& file) {
  Projection projection;
  const std::string name = text_of(file.projection, "PROJ_NM");
  if (name == "TM") {
    const auto value = [&](const char* key, double usual) {
      return crg::find_value(file.projection, key).value_or(usual);
    };
    const double latitude_deg = value("PROJ_P0", NAN), longitude_deg = value("PROJ_L0", NAN);
    // Written by others about another origin, or with another scale: not understood here.
    if (value("PROJ_F0", 1.0) != 1.0 || value("PROJ_E0", 0.0) != 0.0 ||
        value("PROJ_N0", 0.0) != 0.0 || !(std::abs(latitude_deg) <= 80.0) ||
        !(std::abs(longitude_deg) <= 360.0))
      return projection;
    return projection_at(Projection::Kind::tm, latitude_deg, longitude_deg);
  }
  int number = 0;
  const bool is_utm =
      name.size() == 7 && name.starts_with("UTM_") &&
      std::from_chars(name.data() + 4, name.data() + 6, number).ptr == name.data() + 6 &&
      number >= 1 && number <= 60 && (name[6] == 'N' || name[6] == 'S');
  if (!is_utm) return projection;
  projection.kind = Projection::Kind::utm;
  projection.zone = {number, name[6] == 'N'};
  return projection;
}

Eigen::Vector2d unproject(const Projection& projection, const Eigen::Vector2d& map_m) {
  if (projection.kind == Projection::Kind::utm) return from_utm(projection.zone, map_m);
  double x0 = 0.0, y0 = 0.0, latitude_deg = 0.0, longitude_deg = 0.0;
  unit_scale_mercator().Forward(projection.longitude_deg, projection.latitude_deg,
                                projection.longitude_deg, x0, y0);
  unit_scale_mercator().Reverse(projection.longitude_deg, map_m.x(), map_m.y() + y0, latitude_deg,
                                longitude_deg);
  return {latitude_deg, longitude_deg};
}

std::string proj_text(const Projection& projection) {
  if (projection.kind == Projection::Kind::utm)
    return fmt::format("+proj=utm +zone={}{} +datum=WGS84 +units=m +no_defs",
                       projection.zone.number, projection.zone.north ? "" : " +south");
  return fmt::format(
      "+proj=tmerc +lat_0={} +lon_0={} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs",
      projection.latitude_deg, projection.longitude_deg);
}

}  // namespace road
