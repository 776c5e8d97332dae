#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "inspect/export_road.h"
#include "inspect/height_map.h"
#include "inspect/kerb_strips.h"
#include "mesh/error.h"

namespace road {
namespace {

constexpr std::size_t kMostTriangles = 5'000'000;
constexpr double kNear_m = 1e4;  ///< where 32 bits are 0.5 mm apart at most
constexpr std::uint32_t kNone = 0xffffffff;

/// Whether a kerb covers (row, v): the nearest looked-at row tells.
std::vector<std::vector<std::pair<double, double>>> kerbs_of_rows(const HeightMap& map) {
  std::vector<std::vector<std::pair<double, double>>> of_row(map.rows());
  for (const std::vector<KerbRow>& rows : find_kerb_strips(map).rows)
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (std::isnan(rows[k].v_begin_m)) continue;
      const std::size_t end = k + 1 < rows.size() ? rows[k + 1].row : rows[k].row + 1;
      const auto [low, high] = std::minmax(rows[k].v_begin_m, rows[k].v_end_m);
      for (std::size_t row = rows[k].row; row < std::min(end, map.rows()); ++row)
        of_row[row].emplace_back(low, high);
    }
  return of_row;
}

}  // namespace

Mesh surface_mesh(const crg::Surface& road, double step_m, Eigen::Vector3d& origin_m) {
  const HeightMap map = height_map(road);
  const auto every =
      static_cast<std::size_t>(std::max(1.0, std::round(step_m / map.line.u_step_m)));
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row + 1 < map.rows(); row += every) rows.push_back(row);
  rows.push_back(map.rows() - 1);
  const std::size_t most = 2 * (rows.size() - 1) * (map.columns() - 1);
  if (most > kMostTriangles)
    throw Error(fmt::format(
        "{} rows of {} columns are up to {} triangles; at most {} are written; give --step-m "
        "{:.2g}",
        rows.size(), map.columns(), most, kMostTriangles,
        1.1 * step_m * static_cast<double>(most) / static_cast<double>(kMostTriangles)));
  origin_m.setZero();
  if (std::abs(map.line.x_m[0]) > kNear_m || std::abs(map.line.y_m[0]) > kNear_m)
    origin_m = {std::round(map.line.x_m[0]), std::round(map.line.y_m[0]), 0.0};
  Mesh mesh;
  mesh.objects = {{"road", "road", "", LinearColour{0.06, 0.06, 0.065}},
                  {"kerb", "kerb", "", LinearColour{0.45, 0.03, 0.03}}};
  const auto kerbs = kerbs_of_rows(map);
  std::vector<std::uint32_t> before(map.columns(), kNone), here(map.columns(), kNone);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::size_t row = rows[k];
    for (std::size_t j = 0; j < map.columns(); ++j) {
      here[j] = kNone;
      const float z_m = map.at(row, j);
      if (std::isnan(z_m)) continue;
      here[j] = static_cast<std::uint32_t>(mesh.vertices_m.size());
      const crg::Point2 p = crg::node_position(map.line, row, map.v_m[j]);
      mesh.vertices_m.push_back(Eigen::Vector3d(p.x_m, p.y_m, map.z_base_m + z_m) - origin_m);
    }
    for (std::size_t j = 0; k > 0 && j + 1 < map.columns(); ++j) {
      const double v_m = 0.5 * (map.v_m[j] + map.v_m[j + 1]);
      const auto& beside = kerbs[rows[k - 1]];
      const bool is_kerb = std::any_of(beside.begin(), beside.end(), [&](const auto& kerb) {
        return v_m > kerb.first && v_m < kerb.second;
      });
      const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (a == kNone || b == kNone || c == kNone) return;
        mesh.triangles.push_back({a, b, c});
        mesh.object_of_triangle.push_back(is_kerb ? 1U : 0U);
      };
      // v ascends to the left of u: this way round the triangles look up.
      if (before[j + 1] != kNone && here[j] != kNone) {
        add(before[j], here[j], before[j + 1]);
        add(before[j + 1], here[j], here[j + 1]);
      } else {
        add(before[j], here[j], here[j + 1]);
        add(before[j], here[j + 1], before[j + 1]);
      }
    }
    std::swap(before, here);
  }
  if (mesh.triangles.empty()) throw Error("the file has no road: every cell of its grid is empty");
  return mesh;
}

}  // namespace road
