#include "guide_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string_view>
#include <vector>

#include "base/letters.h"
#include "mesh/error.h"
#include "recording/log.h"
#include "recording/log_table.h"
#include "recording/recording.h"

namespace road {
namespace {

constexpr double kHeightUnknown = std::numeric_limits<double>::quiet_NaN();

const recording::Channel* channel_called(const recording::Log& log,
                                         std::initializer_list<std::string_view> names) {
  // Of a channel of a topic, "/fix.latitude", the last part.
  const auto field = [](const std::string& name) {
    return name.starts_with('/') ? name.substr(name.rfind('.') + 1) : name;
  };
  for (const std::string_view name : names)
    for (const recording::Channel& channel : log.channels)
      if (base::letters_of(field(channel.name)) == name) return &channel;
  return nullptr;
}

/// Degrees in one unit of the channel; none: the unit is no angle.
std::optional<double> degrees_in(const std::string& unit) {
  const std::string word = base::letters_of(unit);
  if (word == "rad") return 180.0 / std::numbers::pi;
  if (word.empty() || word.starts_with("deg")) return 1.0;
  return std::nullopt;
}

const std::vector<double>* mapped(const recording::Table& log, const recording::Mapping& mapping,
                                  std::string_view channel, const std::string& path,
                                  const recording::ColumnMapping** how) {
  for (const recording::ColumnMapping& column : mapping.columns) {
    if (column.channel != channel) continue;
    *how = &column;
    const std::vector<double>* values = log.find(column.column);
    if (values == nullptr)
      throw Error(fmt::format("{}: no column \"{}\", which {} maps to {}", path, column.column,
                              mapping.path, channel));
    return values;
  }
  return nullptr;
}

}  // namespace

GuideFile guide_of_log(const std::string& path) {
  const recording::Log log = recording::in_rows(recording::read_log(path), path);
  const recording::Channel* const latitude =
      channel_called(log, {"latitude", "lat", "gpslatitude", "gpslat"});
  const recording::Channel* const longitude =
      channel_called(log, {"longitude", "long", "lon", "gpslongitude", "gpslong", "gpslon"});
  const std::optional<double> degrees =
      latitude == nullptr || longitude == nullptr || latitude->unit != longitude->unit
          ? std::nullopt
          : degrees_in(latitude->unit);
  if (!degrees)
    throw Error(fmt::format(
        "{}: a log ({}) without channels called latitude and longitude, in degrees or radians; "
        "--mapping FILE (guide_mapping in a recipe) says which columns are the place",
        path, log.format));
  GuideFile guide;
  guide.geographic = true;
  for (std::size_t i = 0; i < std::min(latitude->values.size(), longitude->values.size()); ++i) {
    const double phi_deg = *degrees * latitude->values[i],
                 lambda_deg = *degrees * longitude->values[i];
    // A receiver that sees no satellites yet writes zeros.
    if (std::isfinite(phi_deg) && std::isfinite(lambda_deg) && (phi_deg != 0 || lambda_deg != 0))
      guide.points.emplace_back(phi_deg, lambda_deg, kHeightUnknown);
  }
  return guide;
}

GuideFile guide_of_log(const std::string& path, const std::string& mapping_path) {
  const recording::Mapping mapping = recording::read_mapping(mapping_path);
  const recording::Table log = recording::read_log_table(path);
  const recording::ColumnMapping *first = nullptr, *second = nullptr, *third = nullptr;
  GuideFile guide;
  const std::vector<double>* a = mapped(log, mapping, "x_m", path, &first);
  const std::vector<double>* b = mapped(log, mapping, "y_m", path, &second);
  const std::vector<double>* c = mapped(log, mapping, "z_m", path, &third);
  if (a == nullptr || b == nullptr) {
    guide.geographic = true;
    a = mapped(log, mapping, "latitude_rad", path, &first);
    b = mapped(log, mapping, "longitude_rad", path, &second);
    c = nullptr;
  }
  if (a == nullptr || b == nullptr)
    throw Error(fmt::format(
        "{}: maps no place; a guide wants columns for x_m and y_m, or for latitude_rad and "
        "longitude_rad",
        mapping_path));
  const double to_degrees = guide.geographic ? 180.0 / std::numbers::pi : 1.0;
  const auto value = [](const recording::ColumnMapping& how, double x) {
    return how.scale * x + how.offset;
  };
  for (std::size_t i = 0; i < a->size(); ++i) {
    if (!std::isfinite((*a)[i]) || !std::isfinite((*b)[i])) continue;
    guide.points.emplace_back(to_degrees * value(*first, (*a)[i]),
                              to_degrees * value(*second, (*b)[i]),
                              c == nullptr ? kHeightUnknown : value(*third, (*c)[i]));
  }
  return guide;
}

}  // namespace road
