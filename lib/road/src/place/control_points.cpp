// Control points from their file.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "base/read_file.h"
#include "base/table_form.h"
#include "base/text_lines.h"
#include "mesh/error.h"
#include "road/align.h"

namespace road {
namespace {

/// Which column holds what.
struct Header {
  std::size_t name = 0;
  std::array<std::size_t, 6> column{};  // of x, y, z in the mesh, then in the world
  bool geographic = false;
};

constexpr std::array<const char*, 3> kMesh{"mesh_x_m", "mesh_y_m", "mesh_z_m"};
constexpr std::array<const char*, 3> kProjected{"x_m", "y_m", "z_m"};
constexpr std::array<const char*, 3> kGeographic{"lat_deg", "lon_deg", "h_m"};

std::vector<std::string> all_names() {
  std::vector<std::string> names;
  for (const auto& three : {kMesh, kProjected, kGeographic})
    names.insert(names.end(), three.begin(), three.end());
  return names;
}

/// Throws Error, `place` before it, where columns are missing.
Header read_header(const base::TableForm& form, std::string_view line, const std::string& place) {
  Header header;
  const auto take = [&](const std::array<const char*, 3>& names, std::size_t at) {
    bool found = true;
    for (std::size_t k = 0; k < 3; ++k) {
      header.column[at + k] = form.column(names[k]);
      found = found && header.column[at + k] < form.names().size();
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
  header.name = form.column("name");
  return header;
}

/// One row; `out` tells the number of the point and takes the first one's projection.
ControlPoint read_point(const std::vector<std::string_view>& cells, const base::TableForm& form,
                        const Header& header, Projection::Kind kind, const std::string& path,
                        std::size_t line, ControlPoints& out) {
  const std::string place = fmt::format("{}:{}", path, line);
  std::array<double, 6> value{};
  for (std::size_t k = 0; k < 6; ++k) {
    const std::size_t column = header.column[k];
    value[k] = form.number(cells[column], column, line, base::Gaps::refused);
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
  base::Lines lines(base::behind_byte_order_mark(text, path));
  std::string_view line;
  std::optional<base::TableForm> form;
  Header header;
  std::vector<std::string_view> cells;
  ControlPoints out;
  while (lines.next(line)) {
    if (base::is_blank_or_remark(line)) continue;
    if (!form) {
      form.emplace(line, lines.number(), path, all_names());
      header = read_header(*form, line, fmt::format("{}:{}", path, lines.number()));
      continue;
    }
    form->split(line, lines.number(), cells);
    out.points.push_back(read_point(cells, *form, header, kind, path, lines.number(), out));
  }
  if (!form)
    throw Error(
        fmt::format("{}: no header; wanted [name,]mesh_x_m,mesh_y_m,mesh_z_m,x_m,y_m,z_m", path));
  return out;
}

std::vector<ControlPoint> read_control_points(const std::string& path) {
  return read_control_point_file(path).points;
}

}  // namespace road
