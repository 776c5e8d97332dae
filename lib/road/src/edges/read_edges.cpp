// Edges as files hold them.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <fstream>
#include <optional>
#include <string>
#include <utility>

#include "base/csv.h"
#include "mesh/error.h"
#include "road/edges.h"
#include "road/guide.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLargest_m = 1e8;

/// The positions of a file in latitude and longitude; nothing where it has x_m and y_m.
std::optional<GuideFile> geographic(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(4096, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  const std::size_t first = head.find_first_not_of("\xEF\xBB\xBF \t\r\n");
  if (first == std::string::npos ||
      (head[first] != '<' && head[first] != '{' && head.find("lat_deg") == std::string::npos))
    return std::nullopt;
  GuideFile found = read_guide(path);
  return found.geographic ? std::optional(std::move(found)) : std::nullopt;
}

Edge placed(const std::string& path, const GuideFile& file, const Projection& projection,
            bool has_z) {
  Edge edge;
  edge.path = path;
  edge.has_z = has_z;
  for (const Vector3d& p : file.points) {
    const Vector2d at = project(projection, p.x(), p.y());
    edge.points_m.emplace_back(at.x(), at.y(), has_z ? p.z() : 0.0);
  }
  return edge;
}

}  // namespace

Edge read_edge(const std::string& path) {
  const base::CsvTable table = base::read_csv(path, {"x_m", "y_m"}, {"z_m"});
  Edge edge;
  edge.path = path;
  edge.has_z = table.present[2];
  for (std::size_t i = 0; i < table.rows(); ++i) {
    for (std::size_t j = 0; j < (edge.has_z ? 3u : 2u); ++j) {
      const double value = table.value(i, j);
      if (!(std::abs(value) <= kLargest_m)) {
        throw Error(fmt::format("{}:{}: {} is {}; wanted a number of metres, at most 1e8", path,
                                table.line[i],
                                j == 0   ? "x_m"
                                : j == 1 ? "y_m"
                                         : "z_m",
                                value));
      }
    }
    edge.points_m.emplace_back(table.value(i, 0), table.value(i, 1),
                               edge.has_z ? table.value(i, 2) : 0.0);
    edge.line.push_back(table.line[i]);
  }
  if (edge.points_m.size() < 4) {
    throw Error(
        fmt::format("{}: {} points; wanted at least 4 along the edge", path, edge.points_m.size()));
  }
  return edge;
}

EdgePlaces read_edges(const std::string& left_path, const std::string& right_path) {
  const std::optional<GuideFile> left = geographic(left_path), right = geographic(right_path);
  if (left.has_value() != right.has_value())
    throw Error(fmt::format(
        "{} holds latitude and longitude, {} does not; wanted both edges in the same coordinates",
        left ? left_path : right_path, left ? right_path : left_path));
  if (!left) return {read_edge(left_path), read_edge(right_path), {}};
  const Projection projection =
      projection_at(Projection::Kind::tm, left->points.front().x(), left->points.front().y());
  bool has_z = true;
  for (const GuideFile* file : {&*left, &*right})
    for (const Vector3d& p : file->points) has_z = has_z && std::isfinite(p.z());
  return {placed(left_path, *left, projection, has_z),
          placed(right_path, *right, projection, has_z), projection};
}

std::pair<Edge, Edge> read_edges_of_line(const std::string& path) {
  if (geographic(path))
    throw Error(fmt::format(
        "{}: one line in latitude and longitude, which says no width; wanted the left and the "
        "right edge as two files, or one CSV with x_m,y_m,w_tr_right_m,w_tr_left_m",
        path));
  const base::CsvTable table = base::read_csv(path, {"x_m", "y_m", "w_tr_right_m", "w_tr_left_m"});
  const std::size_t n = table.rows();
  if (n < 4) throw Error(fmt::format("{}: {} points; wanted at least 4 along the line", path, n));
  const auto at = [&](std::size_t i) {
    return Eigen::Vector2d(table.value(i, 0), table.value(i, 1));
  };
  // A line that comes round to its start has a direction over it, too.
  const bool closed = (at(0) - at(n - 1)).norm() < 3.0 * (at(1) - at(0)).norm();
  std::pair<Edge, Edge> edges;
  edges.first.path = edges.second.path = path;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < 4; ++j)
      if (!(std::abs(table.value(i, j)) <= kLargest_m) || (j > 1 && table.value(i, j) < 0.0))
        throw Error(fmt::format(
            "{}:{}: {} is {}; wanted a number of metres, at most 1e8, and no width below 0", path,
            table.line[i], std::array{"x_m", "y_m", "w_tr_right_m", "w_tr_left_m"}[j],
            table.value(i, j)));
    const std::size_t before = i > 0 ? i - 1 : closed ? n - 1 : 0;
    const std::size_t after = i + 1 < n ? i + 1 : closed ? 0 : i;
    const Eigen::Vector2d along = at(after) - at(before);
    if (!(along.norm() > 0.0))
      throw Error(fmt::format("{}:{}: the points beside it lie at one place; no direction there",
                              path, table.line[i]));
    const Eigen::Vector2d left = Eigen::Vector2d(-along.y(), along.x()).normalized();
    const Eigen::Vector2d l = at(i) + table.value(i, 3) * left,
                          r = at(i) - table.value(i, 2) * left;
    edges.first.points_m.emplace_back(l.x(), l.y(), 0.0);
    edges.second.points_m.emplace_back(r.x(), r.y(), 0.0);
    edges.first.line.push_back(table.line[i]);
    edges.second.line.push_back(table.line[i]);
  }
  return edges;
}

}  // namespace road
