// Control points from their file.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "base/read_file.h"
#include "base/text_lines.h"
#include "mesh/error.h"
#include "road/align.h"

namespace road {
namespace {

constexpr std::size_t kNoColumn = std::string_view::npos;

/// Which column holds what.
struct Header {
  std::size_t columns = 0, name = kNoColumn;
  std::array<std::size_t, 6> column{};  // of x, y, z in the mesh, then in the world
  bool geographic = false;
};

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t comma = line.find(',');
    std::string_view cell = line.substr(0, comma);
    while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
    while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t')) cell.remove_suffix(1);
    cells.push_back(cell);
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

/// Throws Error, `place` before it, where columns are missing.
Header read_header(std::string_view line, const std::string& place) {
  constexpr std::array<const char*, 3> kMesh{"mesh_x_m", "mesh_y_m", "mesh_z_m"};
  constexpr std::array<const char*, 3> kProjected{"x_m", "y_m", "z_m"};
  constexpr std::array<const char*, 3> kGeographic{"lat_deg", "lon_deg", "h_m"};
  const std::vector<std::string_view> cells = cells_of(line);
  Header header;
  header.columns = cells.size();
  const auto find = [&](std::string_view name) {
    return static_cast<std::size_t>(std::find(cells.begin(), cells.end(), name) - cells.begin());
  };
  const auto take = [&](const std::array<const char*, 3>& names, std::size_t at) {
    bool found = true;
    for (std::size_t k = 0; k < 3; ++k) {
      header.column[at + k] = find(names[k]);
      found = found && header.column[at + k] < header.columns;
    }
    return found;
  };
  const bool mesh = take(kMesh, 0);
  const bool projected = take(kProjected, 3);
  header.geographic = !projected && take(kGeographic, 3);
  if (!mesh || (!projected && !header.geographic)) {
    throw Error(
        fmt::format("{}: header '{}'; wanted [name,]mesh_x_m,mesh_y_m,mesh_z_m and "
                    "x_m,y_m,z_m or lat_deg,lon_deg,h_m",
                    place, line.substr(0, 120)));
  }
  if (find("name") < header.columns) header.name = find("name");
  return header;
}

/// One row; `out` tells the number of the point and takes the first one's projection.
ControlPoint read_point(const std::vector<std::string_view>& cells, const Header& header,
                        Projection::Kind kind, const std::string& place, ControlPoints& out) {
  if (cells.size() < header.columns) {
    throw Error(fmt::format("{}: {} cells; wanted {} as in the header", place, cells.size(),
                            header.columns));
  }
  std::array<double, 6> value{};
  for (std::size_t k = 0; k < 6; ++k) {
    const auto number = base::to_number<double>(cells[header.column[k]]);
    if (!number || !std::isfinite(*number)) {
      throw Error(
          fmt::format("{}: '{}'; wanted a number: a control point needs all six coordinates", place,
                      cells[header.column[k]]));
    }
    value[k] = *number;
  }
  ControlPoint point;
  point.name = header.name < cells.size() && !cells[header.name].empty()
                   ? std::string(cells[header.name])
                   : fmt::format("point {}", out.points.size() + 1);
  point.mesh_m = {value[0], value[1], value[2]};
  point.global_m = {value[3], value[4], value[5]};
  if (!header.geographic) return point;
  try {
    if (out.points.empty()) out.projection = projection_at(kind, value[3], value[4]);
    if (std::abs(value[3]) > 90.0) utm_zone(value[3], value[4]);
    const Eigen::Vector2d plane = project(out.projection, value[3], value[4]);
    point.global_m = {plane.x(), plane.y(), value[5]};
    out.latitude_longitude_deg.emplace_back(value[3], value[4]);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", place, error.what()));
  }
  return point;
}

}  // namespace

ControlPoints read_control_point_file(const std::string& path, Projection::Kind kind) {
  const std::string text = base::read_file(path);
  base::Lines lines(text);
  std::string_view line;
  std::optional<Header> header;
  ControlPoints out;
  while (lines.next(line)) {
    if (lines.number() == 1 && line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);
    if (line.find_first_not_of(" \t") == std::string_view::npos || line.starts_with('#')) continue;
    const std::string place = fmt::format("{}:{}", path, lines.number());
    if (header)
      out.points.push_back(read_point(cells_of(line), *header, kind, place, out));
    else
      header = read_header(line, place);
  }
  if (!header)
    throw Error(
        fmt::format("{}: no header; wanted [name,]mesh_x_m,mesh_y_m,mesh_z_m,x_m,y_m,z_m", path));
  return out;
}

std::vector<ControlPoint> read_control_points(const std::string& path) {
  return read_control_point_file(path).points;
}

}  // namespace road
