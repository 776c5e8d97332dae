#include "explain/mapping.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "column_words.h"
#include "confirm_mapping.h"
#include "level_axes.h"
#include "map_column.h"
#include "recording/look.h"
#include "recording/place.h"

namespace explain {
namespace {

using recording::Table;

constexpr std::size_t kFewestRows = 50;

/// The origin of a plane for latitudes and longitudes: the same for all logs of one place, nearly
/// always.
void choose_origin(const std::vector<double>& latitude_rad,
                   const std::vector<double>& longitude_rad, Mapping& mapping) {
  const auto middle = [](std::vector<double> values) {
    std::erase_if(values, [](double v) { return !std::isfinite(v); });
    if (values.empty()) return std::nan("");
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), at, values.end());
    return std::round(*at / kDegree * 100.0) / 100.0;
  };
  mapping.origin_latitude_deg = middle(latitude_rad);
  mapping.origin_longitude_deg = middle(longitude_rad);
  mapping.has_origin =
      std::abs(mapping.origin_latitude_deg) <= 90 && std::abs(mapping.origin_longitude_deg) <= 360;
}

struct Place {
  std::vector<double> x_m, y_m;
};

/// Latitude and longitude on a plane, whose origin goes into the mapping; nothing where they are
/// none.
std::optional<Place> on_plane(const Table& table, const std::string& name, Mapping& mapping) {
  choose_origin(mapped_values(mapping, table, "latitude_rad"),
                mapped_values(mapping, table, "longitude_rad"), mapping);
  if (!mapping.has_origin) return std::nullopt;
  Table with = table;
  recording::Mapping plane = mapping;
  recording::put_on_plane(with, plane, name);
  const Place place{with.columns[with.columns.size() - 2], with.columns.back()};
  mapping.notes.push_back(
      fmt::format("x_m, y_m: from latitude and longitude, east and north of {:.2f}, {:.2f} "
                  "degrees; place_turn_rad, place_x_m and place_y_m bring them to a road's frame",
                  mapping.origin_latitude_deg, mapping.origin_longitude_deg));
  return place;
}

/// Rows with a place that is another than the one before.
std::vector<std::size_t> fresh_rows(const Place& place) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < place.x_m.size(); ++i)
    if (std::isfinite(place.x_m[i]) && std::isfinite(place.y_m[i]) &&
        (out.empty() || place.x_m[i] != place.x_m[out.back()] ||
         place.y_m[i] != place.y_m[out.back()]))
      out.push_back(i);
  return out;
}

std::vector<double> at_rows(const std::vector<double>& values,
                            const std::vector<std::size_t>& rows) {
  std::vector<double> out;
  out.reserve(rows.size());
  for (const std::size_t row : rows) out.push_back(values[row]);
  return out;
}

/// What has a speed only can still be driven by; the tools that want a place say so.
void want_columns(const Table& table, bool placed, Mapping& mapping) {
  if (find_channel(mapping, "time_s") == nullptr)
    mapping.missing.push_back(
        fmt::format("no clock: none of the {} columns is known as time_s", table.names.size()));
  if (!placed && find_channel(mapping, "vx_mps") == nullptr)
    mapping.missing.push_back(
        fmt::format("no place and no speed: none of the {} columns is known as x_m and y_m, "
                    "latitude_rad and longitude_rad, or vx_mps",
                    table.names.size()));
}

/// Where no column is called a clock: the one that runs as one.
void take_running_clock(const Table& table, Mapping& mapping) {
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    if (find_channel(mapping, "time_s") != nullptr) return;
    if (!recording::is_time_that_runs(table.names[c], table.columns[c])) continue;
    std::erase_if(mapping.notes, [&](const std::string& note) {
      return note.starts_with(fmt::format("column '{}' is not used", table.names[c]));
    });
    map_clock(table, c, mapping);
  }
}

}  // namespace

Mapping identity_mapping(const Table& table) {
  Mapping mapping;
  const auto& known = analysed_channels();
  for (const std::string& name : table.names)
    if (std::find(known.begin(), known.end(), name) != known.end()) {
      mapping.columns.push_back({.column = name, .channel = name});
      // Samples of motion that repeat the one before exactly are no measurements.
      const bool motion = name.ends_with("mps") || name.ends_with("radps") ||
                          name.ends_with("mps2");  // a place may stay on a straight along an axis
      const double repeats = recording::share_held(*table.find(name));
      if (motion && repeats > 0.3) {
        mapping.columns.back().held = true;
        mapping.notes.push_back(
            fmt::format("'{}': {:.0f} % of the samples repeat the one before: taken for missing",
                        name, 100.0 * repeats));
      }
    }
  return mapping;
}

Mapping propose_mapping(const Table& table, const std::string& name) {
  Mapping mapping;
  std::set<std::string> taken;
  const auto has_numbers = [&](std::size_t c) {
    return std::any_of(table.columns[c].begin(), table.columns[c].end(),
                       [](double v) { return std::isfinite(v); });
  };
  for (const bool numbers : {true, false})  // words give a channel that nothing else does
    for (std::size_t c = 0; c < table.names.size(); ++c)
      if (has_numbers(c) == numbers) map_column(table, c, taken, mapping);
  take_running_clock(table, mapping);
  settle_pressures(mapping);
  const auto find = [&](const char* channel) { return find_channel(mapping, channel); };
  const bool by_satellites = find("latitude_rad") != nullptr && find("longitude_rad") != nullptr &&
                             find("x_m") == nullptr && find("y_m") == nullptr;
  const bool placed = by_satellites || (find("x_m") != nullptr && find("y_m") != nullptr);
  if (table.rows() < kFewestRows)
    mapping.missing.push_back(
        fmt::format("{} rows: a log of at least {} is wanted", table.rows(), kFewestRows));
  want_columns(table, placed, mapping);
  if (!mapping.missing.empty()) return mapping;
  std::vector<double> t = mapped_values(mapping, table, "time_s");
  settle_level_axes(table, t, mapping);
  confirm_travels(table, t, mapping);
  if (!by_satellites)
    std::erase_if(mapping.columns, [](const ColumnMapping& m) {
      return m.channel == "latitude_rad" || m.channel == "longitude_rad";
    });
  const auto place = by_satellites ? on_plane(table, name, mapping)
                                   : std::optional(Place{mapped_values(mapping, table, "x_m"),
                                                         mapped_values(mapping, table, "y_m")});
  if (!place) {
    mapping.missing.emplace_back("no latitude and longitude within their bounds");
    return mapping;
  }
  if (!placed) {
    mapping.notes.push_back(
        "no place in this log: signs are not confirmed, and steering, whose ratio is not known, is "
        "not used; crgexplain run and crgdrive replay want a place");
    std::erase_if(mapping.columns,
                  [](const ColumnMapping& m) { return m.channel.starts_with("steer"); });
    confirm_without_place(table, t, mapping);
    confirm_wheels(table, mapping);
    return mapping;
  }
  const std::vector<std::size_t> fixes = fresh_rows(*place);
  if (fixes.size() < kFewestRows || fixes.size() > place->x_m.size() * 7 / 10) {
    confirm_mapping(table, t, recording::fill_gaps(t, place->x_m),
                    recording::fill_gaps(t, place->y_m), by_satellites, mapping);
    confirm_wheels(table, mapping);
    return mapping;
  }
  // Between the fixes the path says nothing of turning.
  Table at_fixes = table;
  for (std::vector<double>& column : at_fixes.columns) column = at_rows(column, fixes);
  t = at_rows(t, fixes);
  confirm_mapping(at_fixes, t, at_rows(place->x_m, fixes), at_rows(place->y_m, fixes),
                  by_satellites, mapping);
  confirm_wheels(table, mapping);
  return mapping;
}

}  // namespace explain
