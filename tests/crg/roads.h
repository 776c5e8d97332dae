// Roads with known shape for the tests of lib/crg.
#pragma once

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "crg/file.h"

namespace crg::test {

/// A line that starts at (x, y, heading) and follows curvature(u), nodes exactly one step apart.
inline ReferenceLine line_along(std::size_t rows, double u_step_m,
                                const std::function<double(double)>& curvature, double x_m = 0.0,
                                double y_m = 0.0, double heading_rad = 0.0) {
  ReferenceLine line;
  line.u_step_m = u_step_m;
  line.x_m = {x_m};
  line.y_m = {y_m};
  line.heading_rad = {heading_rad};
  double heading = heading_rad;
  for (std::size_t i = 1; i < rows; ++i) {
    const double u = static_cast<double>(i) * u_step_m;
    if (i > 1) heading += curvature(u - u_step_m) * u_step_m;
    line.heading_rad.push_back(heading);
    line.x_m.push_back(line.x_m.back() + u_step_m * std::cos(heading));
    line.y_m.push_back(line.y_m.back() + u_step_m * std::sin(heading));
  }
  return line;
}

/// A closed circuit of given length and mean radius whose radius varies with lobes; the last row
/// repeats the first, about a millimetre before it.
inline ReferenceLine circuit(std::size_t rows, double radius_m, double lobe, int lobes) {
  constexpr double kTwoPi = 2.0 * std::numbers::pi;
  const auto point = [&](double t) {
    const double r = radius_m * (1.0 + lobe * std::cos(lobes * t));
    return Point2{r * std::cos(t), r * std::sin(t)};
  };
  // Walk along the curve in equal chords; bisect on the chord so that the end meets the start.
  const auto walk = [&](double step) {
    ReferenceLine line;
    line.u_step_m = step;
    double t = 0.0;
    Point2 p = point(0.0);
    line.x_m = {p.x_m};
    line.y_m = {p.y_m};
    for (std::size_t i = 1; i < rows; ++i) {
      double lo = t, hi = t + 4.0 * step / radius_m / (1.0 - std::abs(lobe));
      for (int k = 0; k < 60; ++k) {
        const double mid = 0.5 * (lo + hi);
        const Point2 q = point(mid);
        (std::hypot(q.x_m - p.x_m, q.y_m - p.y_m) < step ? lo : hi) = mid;
      }
      t = 0.5 * (lo + hi);
      p = point(t);
      line.x_m.push_back(p.x_m);
      line.y_m.push_back(p.y_m);
    }
    line.u_begin_m = t;  // misused to return the angle reached
    return line;
  };
  double lo = 0.5 * kTwoPi * radius_m / static_cast<double>(rows), hi = 6.0 * lo;
  for (int k = 0; k < 50; ++k) {
    const double mid = 0.5 * (lo + hi);
    (walk(mid).u_begin_m < kTwoPi ? lo : hi) = mid;
  }
  // A millimetre less in total leaves the gap that the C API wants.
  const double step = lo - 1e-3 / static_cast<double>(rows - 1);
  ReferenceLine line = walk(step);
  line.u_begin_m = 0.0;
  line.closed = true;
  line.heading_rad.assign(rows, 0.0);
  for (std::size_t i = 1; i < rows; ++i) {
    line.heading_rad[i] = std::atan2(line.y_m[i] - line.y_m[i - 1], line.x_m[i] - line.x_m[i - 1]);
    if (i > 1) {
      line.heading_rad[i] = line.heading_rad[i - 1] +
                            std::remainder(line.heading_rad[i] - line.heading_rad[i - 1], kTwoPi);
    }
  }
  line.heading_rad[0] = line.heading_rad[1];
  return line;
}

/// Heights z(u, v) over `line`, columns every v_step from v_right to v_left.
inline Grid grid_of(const ReferenceLine& line, double v_right_m, double v_left_m,
                    std::size_t columns, const std::function<double(double, double)>& z) {
  Grid grid;
  grid.u_begin_m = line.u_begin_m;
  grid.u_step_m = line.u_step_m;
  for (std::size_t j = 0; j < columns; ++j) {
    grid.v_m.push_back(v_right_m + (v_left_m - v_right_m) * static_cast<double>(j) /
                                       static_cast<double>(columns - 1));
  }
  for (std::size_t i = 0; i < line.size(); ++i) {
    for (double v : grid.v_m) grid.z_m.push_back(static_cast<float>(z(grid.u_of(i), v)));
  }
  return grid;
}

/// A directory of its own for each test, removed afterwards.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "crg_test_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace crg::test
