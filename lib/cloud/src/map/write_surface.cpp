#include "cloud/write_surface.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>

#include "base/ending.h"
#include "base/one_line.h"
#include "base/write_file.h"
#include "cloud/error.h"
#include "cloud/road_frame.h"

namespace cloud {
namespace {

constexpr std::uint32_t kNone = 0xffffffff;

template <typename T>
void put(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

/// The next node with a height on one side, or the node itself.
Eigen::Vector3d beside(const RoadFrame& frame, std::size_t row, std::size_t column, int rows,
                       int columns) {
  const auto n = static_cast<std::ptrdiff_t>(frame.rows()),
             m = static_cast<std::ptrdiff_t>(frame.columns());
  std::ptrdiff_t i = static_cast<std::ptrdiff_t>(row) + rows;
  const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(column) + columns;
  if (frame.closed()) i = (i + n - 1) % (n - 1);
  const bool there =
      i >= 0 && i < n && j >= 0 && j < m &&
      std::isfinite(frame.node(static_cast<std::size_t>(i), static_cast<std::size_t>(j)));
  const std::size_t a = there ? static_cast<std::size_t>(i) : row,
                    b = there ? static_cast<std::size_t>(j) : column;
  const Eigen::Vector2d p = frame.node_position(a, frame.v_m()[b]);
  return {p.x(), p.y(), static_cast<double>(frame.node(a, b))};
}

Eigen::Vector3f normal_at(const RoadFrame& frame, std::size_t row, std::size_t column) {
  const Eigen::Vector3d along =
                            beside(frame, row, column, 1, 0) - beside(frame, row, column, -1, 0),
                        across =
                            beside(frame, row, column, 0, 1) - beside(frame, row, column, 0, -1);
  Eigen::Vector3d normal = along.cross(across);
  // Alone along or across: level in the other direction.
  if (along.isZero() || across.isZero()) {
    const Eigen::Vector3d one = along + across;
    normal = one.isZero() ? Eigen::Vector3d::UnitZ()
                          : one.cross(Eigen::Vector3d::UnitZ().cross(one)).eval();
  }
  return normal.normalized().cast<float>();
}

/// The header, without the triangles' part of a .ply where there are none.
std::string head_of_surface(const NodeSurface& surface, bool pcd, bool doubles,
                            const std::vector<std::string>& comments) {
  std::string notes;
  const char* const mark = pcd ? "# " : "comment ";
  if (!doubles && !surface.origin_m.isZero())
    notes = fmt::format("{}origin_m {} {} {}\n", mark, surface.origin_m.x(), surface.origin_m.y(),
                        surface.origin_m.z());
  for (const std::string& comment : comments) notes += mark + base::one_line(comment) + "\n";
  const std::size_t count = surface.place_m.size();
  if (pcd) {
    const int size = doubles ? 8 : 4;
    return fmt::format(
        "# .PCD v0.7 - Point Cloud Data file format\n{}VERSION 0.7\nFIELDS x y z normal_x normal_y "
        "normal_z sigma\nSIZE {} {} {} 4 4 4 4\nTYPE F F F F F F F\nCOUNT 1 1 1 1 1 1 1\nWIDTH {}\n"
        "HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
        notes, size, size, size, count, count);
  }
  const char* const type = doubles ? "double" : "float";
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\n{}element vertex {}\nproperty {} x\nproperty {} y\n"
      "property {} z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float "
      "sigma\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
      notes, count, type, type, type, surface.triangles.size());
}

}  // namespace

NodeSurface node_surface(const crg::Crg& road, const crg::Grid& stddev, std::size_t most_nodes) {
  const RoadFrame frame(road);
  const std::size_t columns = frame.columns(), rows = frame.rows();
  if (stddev.z_m.size() != rows * columns)
    throw Error(fmt::format("{} standard deviations seen for {} x {} nodes; one a node wanted",
                            stddev.z_m.size(), rows, columns));
  const std::size_t every = rows * columns / std::max<std::size_t>(1, most_nodes) + 1;
  NodeSurface surface;
  const Eigen::Vector2d first = frame.node_position(0, 0.0);
  surface.origin_m = {std::round(first.x()), std::round(first.y()), std::round(frame.z_origin_m())};
  const double height = frame.z_origin_m() - surface.origin_m.z();
  std::vector<std::uint32_t> before(columns), now(columns);
  for (std::size_t i = 0;; i = std::min(i + every, rows - 1)) {
    for (std::size_t j = 0; j < columns; ++j) {
      now[j] = kNone;
      const auto z = static_cast<double>(frame.node(i, j));
      if (!std::isfinite(z)) continue;
      const Eigen::Vector2d p = frame.node_position(i, frame.v_m()[j]);
      now[j] = static_cast<std::uint32_t>(surface.place_m.size());
      surface.place_m.emplace_back(p.x() - surface.origin_m.x(), p.y() - surface.origin_m.y(),
                                   z + height);
      surface.normal.push_back(normal_at(frame, i, j));
      surface.stddev_m.push_back(stddev.z_m[i * columns + j]);
    }
    for (std::size_t j = 0; i > 0 && j + 1 < columns; ++j) {
      const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (a != kNone && b != kNone && c != kNone) surface.triangles.push_back({a, b, c});
      };
      add(before[j], now[j], before[j + 1]);
      add(before[j + 1], now[j], now[j + 1]);
    }
    if (i + 1 >= rows) break;
    std::swap(before, now);
  }
  return surface;
}

void write_surface(const NodeSurface& surface, const std::string& path, bool doubles,
                   const std::vector<std::string>& comments) {
  const std::string ending = base::ending_of(path);
  if (ending != ".ply" && ending != ".pcd")
    throw Error(fmt::format("{}: ending '{}' seen; .ply or .pcd wanted", path, ending));
  base::FileWriter file(path);
  std::string bytes = head_of_surface(surface, ending == ".pcd", doubles, comments);
  const auto flush = [&](std::size_t above) {
    if (bytes.size() <= above) return;
    file.append(bytes);
    bytes.clear();
  };
  constexpr std::size_t kAtOnce = 1u << 22;
  for (std::size_t i = 0; i < surface.place_m.size(); ++i) {
    for (int k = 0; k < 3; ++k)
      if (doubles)
        put(bytes, surface.origin_m[k] + surface.place_m[i][k]);
      else
        put(bytes, static_cast<float>(surface.place_m[i][k]));
    for (int k = 0; k < 3; ++k) put(bytes, surface.normal[i][k]);
    put(bytes, surface.stddev_m[i]);
    flush(kAtOnce);
  }
  for (std::size_t i = 0; ending == ".ply" && i < surface.triangles.size(); ++i) {
    put(bytes, std::uint8_t{3});
    for (const std::uint32_t index : surface.triangles[i]) put(bytes, index);
    flush(kAtOnce);
  }
  flush(0);
  file.commit();
}

}  // namespace cloud
