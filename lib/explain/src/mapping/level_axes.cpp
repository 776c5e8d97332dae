#include "level_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "confirm_mapping.h"
#include "map_column.h"
#include "path_fit.h"

namespace explain {
namespace {

using recording::Table;

/// What makes a column the speed along a path in m/s, and what makes the path's lengths metres.
struct Scales {
  double speed = 0.0, length = 1.0;
};

/// In m/s, km/h or mph along a path in m, dm, cm or mm; a speed of 0: in none of them. `path` is
/// the speed by the path's own lengths.
Scales scales_of(const std::vector<double>& path, const std::vector<double>& values) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isfinite(values[i]) && path[i] > 4.0) ratios.push_back(values[i] / path[i]);
  if (ratios.size() < 20) return {};
  std::vector<double> sorted = ratios;
  std::sort(sorted.begin(), sorted.end());
  const double middle = sorted[sorted.size() / 2];
  // Nine tenths of it within a fifth: not only right in the mean.
  const auto beside = std::count_if(ratios.begin(), ratios.end(), [&](double ratio) {
    return std::abs(ratio - middle) > 0.2 * std::abs(middle);
  });
  if (static_cast<double>(beside) > 0.1 * static_cast<double>(ratios.size())) return {};
  for (const double length : {1.0, 0.1, 0.01, 0.001})
    for (const double speed : {1.0, 1 / 3.6, 0.44704})
      if (std::abs(middle * speed / length - 1.0) < 0.08) return {speed, length};
  return {};
}

/// True where x_m and y_m are lengths of a path that `speed` goes along.
bool settle_lengths(const Scales& scales, const std::string& speed, Mapping& mapping) {
  if (scales.speed == 0.0) return false;
  if (scales.length == 1.0) return true;
  if (!mapping.guessed.contains("x_m") || !mapping.guessed.contains("y_m")) return false;
  for (const char* const channel : {"x_m", "y_m", "z_m"})
    if (ColumnMapping* const m = find_channel(mapping, channel);
        m != nullptr && mapping.guessed.contains(channel)) {
      m->scale *= scales.length;
      mapping.notes.push_back(
          fmt::format("{} from '{}': factor {:g}, by '{}'", channel, m->column, m->scale, speed));
    }
  return true;
}

}  // namespace

void settle_level_axes(const Table& table, const std::vector<double>& t, Mapping& mapping) {
  ColumnMapping* const y = find_channel(mapping, "y_m");
  ColumnMapping* const z = find_channel(mapping, "z_m");
  if (find_channel(mapping, "x_m") == nullptr || y == nullptr) return;
  const std::vector<double> x_m = mapped_values(mapping, table, "x_m");
  const Path beside = path_of(t, x_m, mapped_values(mapping, table, "y_m"));
  const Path across = z == nullptr ? Path{} : path_of(t, x_m, mapped_values(mapping, table, "z_m"));
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    if (!is_called(table.names[c], "vx_mps")) continue;
    if (settle_lengths(scales_of(beside.speed, table.columns[c]), table.names[c], mapping)) return;
    if (z == nullptr) continue;
    const Scales scales = scales_of(across.speed, table.columns[c]);
    if (scales.speed == 0.0 || scales.length != 1.0) continue;
    mapping.notes.push_back(fmt::format(
        "the path in '{}' and '{}' is as fast as '{}' says, with '{}' it is not: y is upwards; "
        "whether the plan is mirrored is not known: if left turns go right, turn the scale of y_m",
        find_channel(mapping, "x_m")->column, z->column, table.names[c], y->column));
    std::swap(y->channel, z->channel);
    std::erase_if(mapping.columns, [&](const ColumnMapping& m) {
      const bool of_axes = m.channel.ends_with("_rate_radps") || m.channel.ends_with("_mps2") ||
                           m.channel == "vy_mps" || m.channel == "vx_mps";
      if (of_axes && m.column != table.names[c])
        mapping.notes.push_back(fmt::format(
            "column '{}' is not used: y is upwards in this log, and the order of the car's axes "
            "is not known",
            m.column));
      return of_axes;
    });
    mapping.columns.push_back(
        {.column = table.names[c], .channel = "vx_mps", .scale = scales.speed});
    mapping.guessed.erase("vx_mps");
    return;
  }
}

void leave_out_axes_of_plane(const Table& table, const Path& path,
                             const std::vector<double>& lateral, Mapping& mapping) {
  const std::vector<double> x = mapped_values(mapping, table, "vx_mps");
  std::vector<double> both = mapped_values(mapping, table, "vy_mps");
  if (x.empty() || both.empty()) return;
  for (std::size_t i = 0; i < x.size(); ++i) both[i] = std::hypot(x[i], both[i]);
  const auto goes = [](const std::vector<double>& reference, const std::vector<double>& values) {
    return std::abs(through_zero(reference, values).correlation);
  };
  if (goes(path.speed, x) > 0.9 || goes(path.speed, both) < 0.95) return;
  const bool ax = goes(path.acceleration, mapped_values(mapping, table, "ax_mps2")) > 0.5;
  const bool ay = goes(lateral, mapped_values(mapping, table, "ay_mps2")) > 0.5;
  std::erase_if(mapping.columns, [&](const ColumnMapping& m) {
    const bool of_plane = m.channel == "vx_mps" || m.channel == "vy_mps" ||
                          (m.channel == "ax_mps2" && !ax) || (m.channel == "ay_mps2" && !ay);
    if (of_plane)
      mapping.notes.push_back(fmt::format(
          "column '{}' is not used: the path says that it lies along an axis of the plane and not "
          "of the car",
          m.column));
    return of_plane;
  });
}

}  // namespace explain
