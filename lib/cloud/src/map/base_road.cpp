#include "cloud/base_road.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/parallel.h"
#include "base/statistics.h"
#include "cloud/error.h"
#include "cloud/road_frame.h"
#include "no_value.h"
#include "road/reference_line.h"
#include "road/track_crg.h"

namespace cloud {
namespace {

constexpr double kCell_m = 0.5;
constexpr double kSticksOut_m = 0.15;  // of the cells around: cars, noise far below

/// Heights of cells along the road, NaN where no point fell.
struct Cells {
  std::size_t along = 0, across = 0;
  bool closed = false;
  double rows_each = 1.0;  ///< of the grid, per cell along the road
  std::vector<float> z;
  float at(std::ptrdiff_t i, std::ptrdiff_t j) const {
    const auto n = static_cast<std::ptrdiff_t>(along);
    if (closed) i = (i % n + n) % n;
    if (i < 0 || i >= n || j < 0 || j >= static_cast<std::ptrdiff_t>(across)) return kNoValue;
    return z[static_cast<std::size_t>(i) * across + static_cast<std::size_t>(j)];
  }
  std::uint32_t number_at(const GridPlace& place, double v_max_m) const {
    const auto i = std::min(static_cast<std::size_t>(place.row / rows_each), along - 1),
               j = static_cast<std::size_t>((place.v_m + v_max_m) / kCell_m);
    return static_cast<std::uint32_t>(i * across + std::min(j, across - 1));
  }
};

/// The median of the 5 x 5 around takes the place of what sticks out of it.
void calm(Cells& cells, unsigned threads) {
  const Cells before = cells;
  base::parallel_for(cells.along, 64, threads, [&](std::size_t from, std::size_t to) {
    std::vector<float> around;
    for (std::size_t i = from; i < to; ++i)
      for (std::size_t j = 0; j < cells.across; ++j) {
        float& z = cells.z[i * cells.across + j];
        if (!std::isfinite(z)) continue;
        around.clear();
        for (std::ptrdiff_t a = -2; a <= 2; ++a)
          for (std::ptrdiff_t b = -2; b <= 2; ++b) {
            const float h =
                before.at(static_cast<std::ptrdiff_t>(i) + a, static_cast<std::ptrdiff_t>(j) + b);
            if (std::isfinite(h)) around.push_back(h);
          }
        const float middle = base::median(around);
        if (std::abs(static_cast<double>(z - middle)) > kSticksOut_m) z = middle;
      }
  });
}

/// Means of 1 m x 1 m, twice: a road whose own noise does not pull views of it apart. Holes beside
/// the road are filled as far as that reaches.
crg::Grid smoothed(const crg::Grid& grid, bool closed, unsigned threads) {
  constexpr double kReach_m = 0.5;
  const auto rows = static_cast<std::ptrdiff_t>(grid.rows()),
             columns = static_cast<std::ptrdiff_t>(grid.columns());
  const auto along = static_cast<std::ptrdiff_t>(kReach_m / grid.u_step_m + 0.5),
             across = static_cast<std::ptrdiff_t>(kReach_m / (grid.v_m[1] - grid.v_m[0]) + 0.5);
  crg::Grid from = grid, to = grid;
  const auto pass = [&](const auto& mean_at) {
    base::parallel_for(grid.rows(), 64, threads, [&](std::size_t begin, std::size_t end) {
      for (auto i = static_cast<std::ptrdiff_t>(begin); i < static_cast<std::ptrdiff_t>(end); ++i)
        for (std::ptrdiff_t j = 0; j < columns; ++j)
          to.z_m[static_cast<std::size_t>(i * columns + j)] = mean_at(i, j);
    });
    std::swap(from.z_m, to.z_m);
  };
  struct Mean {
    double sum = 0.0, count = 0.0;
    void add(float z) {
      if (std::isfinite(z)) sum += static_cast<double>(z), count += 1.0;
    }
    float value() const { return count > 0.0 ? static_cast<float>(sum / count) : kNoValue; }
  };
  for (int round = 0; round < 2; ++round) {
    pass([&](std::ptrdiff_t i, std::ptrdiff_t j) {
      // As far to one side as to the other, so that grades stay.
      const std::ptrdiff_t reach = closed ? along : std::min({along, i, rows - 1 - i});
      Mean mean;
      for (std::ptrdiff_t k = i - reach; k <= i + reach; ++k) {
        const std::ptrdiff_t row = closed ? (k + rows - 1) % (rows - 1) : k;
        mean.add(from.z_m[static_cast<std::size_t>(row * columns + j)]);
      }
      return mean.value();
    });
    pass([&](std::ptrdiff_t i, std::ptrdiff_t j) {
      const std::ptrdiff_t reach = std::min({across, j, columns - 1 - j});
      Mean mean;
      for (std::ptrdiff_t k = j - reach; k <= j + reach; ++k)
        mean.add(from.z_m[static_cast<std::size_t>(i * columns + k)]);
      return mean.value();
    });
  }
  return from;
}

/// Of height 0, as wide as the options want it.
crg::Grid flat_grid(const crg::ReferenceLine& reference, const BaseRoadOptions& options) {
  crg::Grid grid;
  grid.u_begin_m = 0.0, grid.u_step_m = reference.u_step_m;
  const auto half = static_cast<int>(options.v_max_m / options.v_step_m + 0.5);
  for (int j = -half; j <= half; ++j) grid.v_m.push_back(options.v_step_m * j);
  grid.z_m.assign(reference.x_m.size() * grid.v_m.size(), 0.0f);
  return grid;
}

/// Of a line, per row of the road along it.
struct LineHeights {
  double origin_m = 0.0;  ///< of its beginning; heights of cells are relative to it
  std::vector<double> z_m;
};

std::vector<double> heights_along(const road::Centreline& line, const RoadFrame& frame) {
  std::vector<double> z_m(frame.rows());
  std::size_t next = 0;
  for (std::size_t i = 0; i < z_m.size(); ++i) {
    const Eigen::Vector2d p = frame.node_position(i, 0.0);
    while (next + 1 < line.points_m.size() && (line.points_m[next + 1].head<2>() - p).norm() <=
                                                  (line.points_m[next].head<2>() - p).norm())
      ++next;
    z_m[i] = line.points_m[next].z();
  }
  return z_m;
}

/// Cells along the road without a point yet.
Cells empty_cells(const RoadFrame& frame, const BaseRoadOptions& options) {
  Cells cells;
  cells.closed = frame.closed();
  cells.along = std::max<std::size_t>(1, static_cast<std::size_t>(frame.length_m() / kCell_m));
  cells.across = static_cast<std::size_t>(2.0 * options.v_max_m / kCell_m) + 1;
  cells.rows_each = static_cast<double>(frame.rows() - 1) / static_cast<double>(cells.along);
  cells.z.assign(cells.along * cells.across, kNoValue);
  return cells;
}

/// Where the sensor was, as rows of the road; legs that cross do not mix.
std::vector<double> rows_of_poses(const Trajectory& trajectory, const RoadFrame& frame) {
  std::vector<double> rows;
  double row = 0.0;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const Eigen::Vector3d& p = trajectory.position_m[i];
    std::optional<GridPlace> place;
    if (!begins_drive(trajectory, i)) place = frame.project(p.x(), p.y(), row);
    if (!place) place = frame.project(p.x(), p.y(), frame.nearest_row(p.x(), p.y()));
    if (place) row = place->row;
    rows.push_back(row);
  }
  return rows;
}

/// A point in the map frame and where to look for its place; negative: anywhere.
struct Posed {
  Eigen::Vector3d map_m;
  double row = -1.0;
};

/// Brings the points of a chunk into the map frame, one after the other.
class Poser {
 public:
  /// `trajectory` null: they are there already.
  Poser(const Trajectory* trajectory, const std::vector<double>& pose_rows)
      : trajectory_(trajectory), pose_rows_(pose_rows) {}
  /// `last_row`: of the point before. Nothing outside the trajectory's time.
  std::optional<Posed> operator()(const Cloud& chunk, std::size_t k, double last_row) {
    const Eigen::Vector3d p = chunk.origin_m + chunk.point(k);
    if (trajectory_ == nullptr) return Posed{p, last_row};
    PosedInstant pose;
    if (!pose_at(*trajectory_, chunk.time_s[k], hint_, pose)) return std::nullopt;
    return Posed{pose.position_m + pose.turned(p), pose_rows_[hint_]};
  }

 private:
  const Trajectory* trajectory_;
  const std::vector<double>& pose_rows_;
  std::size_t hint_ = 0;
};

/// Place on the road, no farther beside its line than that. `search`: where it is not near the row,
/// anywhere on the road.
std::optional<GridPlace> place_of(const Posed& point, const RoadFrame& frame, double v_max_m,
                                  bool search) {
  const double x = point.map_m.x(), y = point.map_m.y();
  std::optional<GridPlace> place;
  if (point.row >= 0.0) place = frame.project(x, y, point.row);
  if (search && (!place || std::abs(place->v_m) > v_max_m))
    place = frame.project(x, y, frame.nearest_row(x, y));
  if (place && std::abs(place->v_m) > v_max_m) place.reset();
  return place;
}

/// The lowest point of each cell, of those about as high as the line. Throws Error where hardly any
/// are, or without times that a trajectory wants.
Cells lowest_of(const CloudSource& scans, const RoadFrame& frame, const LineHeights& line,
                const Trajectory* trajectory, const BaseRoadOptions& options) {
  struct Seen {
    std::uint32_t cell;
    float z;
  };
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  Cells cells = empty_cells(frame, options);
  std::vector<double> pose_rows;
  if (trajectory != nullptr) pose_rows = rows_of_poses(*trajectory, frame);
  std::vector<Seen> seen;
  std::size_t points = 0, found = 0;
  scans([&](Cloud&& chunk) {
    if (trajectory != nullptr && chunk.time_s.empty())
      throw Error(
          "the points have no time, so they cannot be placed on the trajectory; a property 'time' "
          "is wanted, or --frame map for a registered cloud");
    seen.assign(chunk.size(), {kNone, 0.0f});
    base::parallel_for(chunk.size(), 16384, options.threads, [&](std::size_t from, std::size_t to) {
      Poser pose(trajectory, pose_rows);
      double row = -1.0;
      for (std::size_t k = from; k < to; ++k) {
        const std::optional<Posed> point = pose(chunk, k, row);
        if (!point) continue;
        const std::optional<GridPlace> place =
            place_of(*point, frame, options.v_max_m, trajectory == nullptr);
        if (!place) continue;
        row = place->row;
        const double z = point->map_m.z(),
                     above = z - line.z_m[static_cast<std::size_t>(place->row)];
        if (!(above > -options.below_m && above < options.above_m)) continue;
        seen[k] = {cells.number_at(*place, options.v_max_m), static_cast<float>(z - line.origin_m)};
      }
    });
    points += chunk.size();
    for (const Seen& s : seen)
      if (s.cell != kNone) cells.z[s.cell] = std::fmin(cells.z[s.cell], s.z), ++found;
  });
  if (found < 100)
    throw Error(
        fmt::format("{} of {} points lie within {} m beside the line and {} m under it; frame, "
                    "clock or unit of "
                    "line and points differ",
                    found, points, options.v_max_m, options.below_m));
  return cells;
}

/// Between the middles of the four cells around; NaN where these hardly have any.
float between_cells(const Cells& cells, double along, double across, double origin_m) {
  const double i = std::floor(along), j = std::floor(across), on = along - i, beside = across - j;
  double sum = 0.0, weights = 0.0;
  for (int m = 0; m < 2; ++m)
    for (int n = 0; n < 2; ++n) {
      const float z =
          cells.at(static_cast<std::ptrdiff_t>(i) + m, static_cast<std::ptrdiff_t>(j) + n);
      const double w = (m == 0 ? 1.0 - on : on) * (n == 0 ? 1.0 - beside : beside);
      if (std::isfinite(z)) sum += w * static_cast<double>(z), weights += w;
    }
  return weights > 0.2 ? static_cast<float>(sum / weights + origin_m) : kNoValue;
}

/// Heights of all nodes; the last row of a closed road is its first.
void fill_grid(const Cells& cells, const BaseRoadOptions& options, double origin_m,
               crg::Grid& grid) {
  const std::size_t rows = grid.rows(), columns = grid.columns();
  base::parallel_for(rows, 64, options.threads, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i)
      for (std::size_t j = 0; j < columns; ++j)
        grid.z_m[i * columns + j] =
            between_cells(cells, static_cast<double>(i) / cells.rows_each - 0.5,
                          (grid.v_m[j] + options.v_max_m) / kCell_m - 0.5, origin_m);
  });
  if (cells.closed)
    for (std::size_t j = 0; j < columns; ++j) grid.z_m[(rows - 1) * columns + j] = grid.z_m[j];
}

}  // namespace

road::Centreline driven_line(const Trajectory& trajectory) {
  constexpr double kApart_m = 2.0, kBack_m = 10.0;
  road::Centreline line;
  double driven = 0.0;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    if (i > 0 && begins_drive(trajectory, i)) break;
    if (i > 0) driven += (trajectory.position_m[i] - trajectory.position_m[i - 1]).norm();
    const Eigen::Vector3d& p = trajectory.position_m[i];
    if (!line.points_m.empty() && (p - line.points_m.back()).norm() < kApart_m) continue;
    const Eigen::Vector2d back = (p - trajectory.position_m[0]).head<2>();
    const Eigen::Vector3d ahead = trajectory.orientation[0] * Eigen::Vector3d::UnitX();
    // Round: near the beginning again, and driving past it.
    if (driven > 100.0 && back.norm() < kBack_m && back.dot(ahead.head<2>()) > -kApart_m) {
      line.closed = true;
      break;
    }
    line.points_m.push_back(p), line.half_width_m.push_back(5.0);
  }
  if (driven < 20.0)
    throw Error(fmt::format(
        "the trajectory's first piece is {:.1f} m long; 20 m wanted to put a road along", driven));
  line.length_m = driven;
  return line;
}

crg::Crg base_from_points(const CloudSource& scans, const road::Centreline& line,
                          const Trajectory* trajectory, const BaseRoadOptions& options) {
  road::ReferenceLineOptions line_options;
  line_options.u_step_m = options.u_step_m;
  const crg::ReferenceLine reference = road::fit_reference_line(line, line_options);
  crg::Grid grid = flat_grid(reference, options);
  const RoadFrame frame(road::track_crg(reference, grid));  // flat: only its (u, v) is used
  const LineHeights heights{line.points_m.front().z(), heights_along(line, frame)};
  Cells cells = lowest_of(scans, frame, heights, trajectory, options);
  calm(cells, options.threads);
  fill_grid(cells, options, heights.origin_m, grid);
  return road::track_crg(reference, std::move(grid));
}

MapResult map_without_base(const CloudSource& scans, const crg::Crg& first,
                           const Trajectory* trajectory, MapOptions options) {
  options.trust_base = false, options.base_stddev_m = 1.0;
  crg::Crg road = first;
  const auto refine = [&](const crg::Grid& from) {
    road.grid = smoothed(from, RoadFrame(first).closed(), options.threads);
    return map_clouds(scans, road, trajectory, options);
  };
  MapResult result = refine(first.grid);
  // The first road is rough: what the points seem to say about place and course of the whole is its
  // roughness. Once more on the road that they made.
  if (trajectory != nullptr && options.correct_drift) result = refine(result.grid);
  for (std::size_t k = 0; k < result.grid.z_m.size(); ++k)
    if (!(result.source.z_m[k] > static_cast<float>(NodeSource::base)))
      result.grid.z_m[k] = result.stddev.z_m[k] = result.source.z_m[k] = kNoValue;
  result.report.nodes_hole += result.report.nodes_base, result.report.nodes_base = 0;
  result.report.coverage =
      static_cast<double>(result.report.nodes_lidar) /
      std::max<double>(1.0, static_cast<double>(result.report.nodes - result.report.nodes_hole));
  return result;
}

}  // namespace cloud
