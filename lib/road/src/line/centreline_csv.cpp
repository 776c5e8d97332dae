#include <fmt/format.h>

#include "base/csv.h"
#include "base/write_file.h"
#include "border_curve.h"
#include "mesh/error.h"
#include "road/centreline.h"

namespace road {

using Eigen::Vector3d;

void write_centreline_csv(const Centreline& centreline, const std::string& path) {
  std::string text = "x_m,y_m,z_m,half_width_m\n";
  const auto row = [&](std::size_t i) {
    const Vector3d& p = centreline.points_m[i];
    text += fmt::format("{:.4f},{:.4f},{:.4f},{:.4f}\n", p.x(), p.y(), p.z(),
                        centreline.half_width_m[i]);
  };
  for (std::size_t i = 0; i < centreline.points_m.size(); ++i) row(i);
  if (centreline.closed) row(0);  // a repeated first row says that the line is closed
  base::write_file(path, text);
}

Centreline read_centreline_csv(const std::string& path) {
  const base::CsvTable table = base::read_csv(path, {"x_m", "y_m"}, {"z_m", "half_width_m"});
  Centreline line;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const auto value = [&](std::size_t column) {
      return table.present[column] ? table.value(i, column) : 0.0;
    };
    line.points_m.emplace_back(value(0), value(1), value(2));
    line.half_width_m.push_back(value(3));
    if (!line.points_m.back().allFinite())
      throw Error(fmt::format("{}:{}: no value of z_m; fill it in, or take the column out", path,
                              table.line[i]));
  }
  if (line.points_m.size() >= 2 &&
      (line.points_m.front() - line.points_m.back()).head<2>().norm() < 1e-3) {
    line.closed = true;
    line.points_m.pop_back();
    line.half_width_m.pop_back();
  }
  if (line.points_m.size() < 4) {
    throw Error(
        fmt::format("{}: {} stations; a centreline needs at least 4", path, line.points_m.size()));
  }
  line.length_m = curve_length_m(line.points_m, line.closed);
  return line;
}

}  // namespace road
