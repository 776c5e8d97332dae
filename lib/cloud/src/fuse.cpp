#include "fuse.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "base/statistics.h"

namespace cloud {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr double kGate_m =
    0.02;  // beyond the robust heights around: four times the noise of a good sensor
constexpr std::size_t kStripeRows = 64;

/// Lowest and highest robust height among a cell and its neighbours.
struct Band {
  float low = kNaN, high = kNaN;
};

std::vector<Band> bands_of(const HeightCells& surface, unsigned threads) {
  std::vector<Band> bands(surface.height_m.size());
  base::parallel_for(surface.along, 64, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t j = 0; j < surface.across; ++j) {
        Band& band = bands[i * surface.across + j];
        if (!std::isfinite(surface.height_m[i * surface.across + j])) continue;
        for (std::size_t k = i + surface.along - 1; k <= i + surface.along + 1; ++k) {
          if (!surface.closed && (k < surface.along || k >= 2 * surface.along)) continue;
          for (std::size_t l = j - std::min<std::size_t>(j, 1);
               l <= std::min(j + 1, surface.across - 1); ++l) {
            const float h = surface.height_m[k % surface.along * surface.across + l];
            if (std::isfinite(h))
              band.low = std::fmin(band.low, h), band.high = std::fmax(band.high, h);
          }
        }
      }
  });
  return bands;
}

/// Between the middles of stretches: linear.
StretchDeviation drift_left(const Drift& drift, std::size_t row, const RoadFrame& frame) {
  if (drift.stretch.empty()) return {};
  const double at = static_cast<double>(row) * frame.u_step_m() / kStretch_m - 0.5;
  const auto last = drift.stretch.size() - 1;
  const auto a = static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(last))),
             b = std::min(a + 1, last);
  const StretchDeviation &p = drift.stretch[a], &q = drift.stretch[b];
  if (!p.seen || !q.seen) return p.seen ? p : q;
  const double f = std::clamp(at - static_cast<double>(a), 0.0, 1.0), g = 1.0 - f;
  return {g * p.v_m + f * q.v_m,
          g * p.var_height + f * q.var_height,
          g * p.cov_height_slope + f * q.cov_height_slope,
          g * p.var_slope + f * q.var_slope,
          g * p.var_along + f * q.var_along,
          g * p.var_across + f * q.var_across,
          true};
}

/// Nodes without points beside such with points: the base moved by their difference from it, less
/// with the distance. Distances along edges and diagonals of the grid.
void blend(const RoadFrame& frame, const crg::Grid& base, const MapOptions& options,
           MapResult& result) {
  const auto columns = static_cast<std::ptrdiff_t>(frame.columns()),
             rows = static_cast<std::ptrdiff_t>(frame.rows() - (frame.closed() ? 1 : 0));
  constexpr float kFar = std::numeric_limits<float>::infinity();
  std::vector<float> distance(static_cast<std::size_t>(rows * columns), kFar),
      moved(distance.size());
  const auto rests_on = [&](std::size_t k, NodeSource source) {
    return result.source.z_m[k] == static_cast<float>(source);
  };
  for (std::ptrdiff_t i = 0; i < rows; ++i)
    for (std::ptrdiff_t j = 0; j < columns; ++j) {
      const auto k = static_cast<std::size_t>(i * columns + j);
      if (!rests_on(k, NodeSource::lidar) && !rests_on(k, NodeSource::interpolated)) continue;
      distance[k] = 0.0f;
      float sum = 0.0f, count = 0.0f;  // single nodes are noisy
      for (std::ptrdiff_t a = std::max<std::ptrdiff_t>(0, i - 1); a <= std::min(i + 1, rows - 1);
           ++a)
        for (std::ptrdiff_t b = std::max<std::ptrdiff_t>(0, j - 1);
             b <= std::min(j + 1, columns - 1); ++b) {
          const auto n = static_cast<std::size_t>(a * columns + b);
          if (rests_on(n, NodeSource::lidar) || rests_on(n, NodeSource::interpolated))
            sum += result.grid.z_m[n] - base.z_m[n], count += 1.0f;
        }
      moved[k] = sum / count;
    }
  const auto u_step = static_cast<float>(frame.u_step_m());
  const auto take = [&](std::ptrdiff_t i, std::ptrdiff_t j, std::ptrdiff_t from_i,
                        std::ptrdiff_t from_j) {
    if (from_j < 0 || from_j >= columns) return;
    if (frame.closed()) from_i = (from_i + rows) % rows;
    if (from_i < 0 || from_i >= rows) return;
    const auto k = static_cast<std::size_t>(i * columns + j),
               from = static_cast<std::size_t>(from_i * columns + from_j);
    const float across = static_cast<float>(frame.v_m()[static_cast<std::size_t>(j)] -
                                            frame.v_m()[static_cast<std::size_t>(from_j)]);
    const float step = std::sqrt(across * across + (from_i == i ? 0.0f : u_step * u_step));
    if (distance[from] + step < distance[k])
      distance[k] = distance[from] + step, moved[k] = moved[from];
  };
  // Forth and back; on a closed road on over the seam.
  const auto beyond =
      frame.closed() ? static_cast<std::ptrdiff_t>(options.blend_m / frame.u_step_m()) + 2 : 0;
  for (std::ptrdiff_t step = 0; step < rows + beyond; ++step) {
    const std::ptrdiff_t i = step % std::max<std::ptrdiff_t>(rows, 1);
    for (std::ptrdiff_t j = 0; j < columns; ++j)
      for (const auto& [a, b] : {std::pair{-1, -1}, {-1, 0}, {-1, 1}, {0, -1}})
        take(i, j, i + a, j + b);
    for (std::ptrdiff_t j = columns; j-- > 0;) take(i, j, i, j + 1);
  }
  for (std::ptrdiff_t step = rows + beyond; step-- > 0;) {
    const std::ptrdiff_t i = step % std::max<std::ptrdiff_t>(rows, 1);
    for (std::ptrdiff_t j = columns; j-- > 0;)
      for (const auto& [a, b] : {std::pair{1, 1}, {1, 0}, {1, -1}, {0, 1}})
        take(i, j, i + a, j + b);
    for (std::ptrdiff_t j = 0; j < columns; ++j) take(i, j, i, j - 1);
  }
  const auto width = static_cast<float>(options.blend_m);
  for (std::size_t k = 0; k < distance.size(); ++k) {
    if (!rests_on(k, NodeSource::base) || !(distance[k] < width)) continue;
    const float far = distance[k] / width, share = 1.0f - far * far * (3.0f - 2.0f * far);
    const float by = share * moved[k];
    result.grid.z_m[k] = base.z_m[k] + by;
    result.stddev.z_m[k] = std::hypot(result.stddev.z_m[k], by);  // the base is wrong beside it
    result.source.z_m[k] = static_cast<float>(NodeSource::blended);
  }
}

}  // namespace

NodeSums accumulate(const CloudSource& source, const RoadFrame& frame,
                    const RoadTrajectory* trajectory, const Sections& sections, const Drift& drift,
                    const HeightCells& surface, const MapOptions& options, MapReport& report) {
  const std::size_t columns = frame.columns(), rows = frame.rows() - (frame.closed() ? 1 : 0);
  NodeSums sums;
  sums.points.assign(rows * columns, 0.0f), sums.height.assign(rows * columns, 0.0f),
      sums.height2.assign(rows * columns, 0.0f);
  const std::vector<Band> bands = bands_of(surface, options.threads);
  const std::size_t stripes = rows / kStripeRows + 1;
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> node, order, begin(stripes + 1);
  std::vector<float> height;
  source([&](Cloud&& chunk) {
    node.assign(chunk.size(), kNone), height.resize(chunk.size());
    base::parallel_for(chunk.size(), 16384, options.threads, [&](std::size_t from, std::size_t to) {
      Placer place(frame, trajectory);
      RoadPoint point;
      for (std::size_t k = from; k < to; ++k) {
        if (place(chunk, k, point) != Placed::on_road) continue;
        if (trajectory == nullptr && options.correct_drift) {
          const auto s = std::min(static_cast<std::size_t>(point.driven_m / kSectionLength_m),
                                  sections.list.size() - 1);
          const Section& section = sections.list[s];
          const Correction c = correction_at(sections, drift.correction, point.driven_m, 0);
          const Eigen::Vector3d p =
              section.position_m + c.head<3>() +
              rotation_of(c, section.axes) * (point.map_m - section.position_m);
          const std::optional<GridPlace> moved = frame.project(p.x(), p.y(), point.place.row);
          if (!moved) continue;
          point.place = *moved;
          point.above_base_m = p.z() - frame.z_origin_m() - frame.height(*moved);
        }
        std::size_t i = 0, j = 0;
        if (!surface.cell_of(point.place, i, j)) continue;
        const Band& band = bands[i * surface.across + j];
        if (!(point.above_base_m > static_cast<double>(band.low) - kGate_m &&
              point.above_base_m < static_cast<double>(band.high) + kGate_m))
          continue;
        std::size_t column = 0;
        double share = 0.0;
        if (!frame.column_of(point.place.v_m, column, share)) continue;
        if (share > 0.5) ++column;
        std::size_t row = static_cast<std::size_t>(point.place.row + 0.5);
        if (row >= rows) row = frame.closed() ? 0 : rows - 1;
        node[k] = static_cast<std::uint32_t>(row * columns + column);
        height[k] = static_cast<float>(point.above_base_m);
      }
    });
    // By stripes of rows, so that each sum is made by one thread in the order of the points.
    std::fill(begin.begin(), begin.end(), 0u);
    for (const std::uint32_t n : node)
      if (n != kNone) ++begin[n / columns / kStripeRows + 1];
    for (std::size_t s = 0; s < stripes; ++s) begin[s + 1] += begin[s];
    order.resize(begin[stripes]);
    report.used += begin[stripes];
    report.points += chunk.size();
    std::vector<std::uint32_t> at(begin.begin(), begin.end() - 1);
    for (std::size_t k = 0; k < node.size(); ++k)
      if (node[k] != kNone)
        order[at[node[k] / columns / kStripeRows]++] = static_cast<std::uint32_t>(k);
    base::parallel_for(stripes, 1, options.threads, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = begin[from]; k < begin[to]; ++k) {
        const std::uint32_t point = order[k];
        sums.points[node[point]] += 1.0f, sums.height[node[point]] += height[point],
            sums.height2[node[point]] += height[point] * height[point];
      }
    });
  });
  return sums;
}

void fuse(const NodeSums& sums, const RoadFrame& frame, const crg::Grid& base,
          const Sections& sections, const Drift& drift, const MapOptions& options,
          MapResult& result) {
  const std::size_t columns = frame.columns(), rows = frame.rows() - (frame.closed() ? 1 : 0);
  result.grid = base, result.stddev = base, result.source = base;
  std::vector<float> noise;
  for (std::size_t k = 0; k < sums.points.size(); k += 17)
    if (sums.points[k] >= 8.0f) {
      const float mean = sums.height[k] / sums.points[k];
      noise.push_back(std::sqrt(std::max(0.0f, sums.height2[k] / sums.points[k] - mean * mean) *
                                sums.points[k] / (sums.points[k] - 1.0f)));
    }
  // Nodes with few points lie farther away, where points scatter more than where many fall.
  double few_square = 0.0, few_freedom = 0.0;
  for (std::size_t k = 0; k < sums.points.size(); ++k) {
    const auto n = static_cast<double>(sums.points[k]);
    if (n < 2.0 || n > 3.0) continue;
    const double mean = static_cast<double>(sums.height[k]) / n;
    few_square += std::max(0.0, static_cast<double>(sums.height2[k]) - n * mean * mean);
    few_freedom += n - 1.0;
  }
  const bool few_tell = few_freedom >= 100.0;
  double typical_noise = few_tell ? std::sqrt(few_square / few_freedom) : 0.005;
  if (noise.size() >= (few_tell ? 100u : 1u))
    typical_noise = static_cast<double>(base::median(std::move(noise)));
  const double noise2 = typical_noise * typical_noise,
               few_noise2 = few_tell ? std::max(noise2, few_square / few_freedom) : noise2;
  const auto least = static_cast<float>(options.min_points);
  const auto excess = [&](std::size_t row, double v) {
    const auto along = static_cast<std::size_t>(static_cast<double>(row) * frame.u_step_m() /
                                                kVergeStretch_m),
               column = static_cast<std::size_t>((v - frame.v_m().front()) / kSectionCell_m),
               across = static_cast<std::size_t>((frame.v_m().back() - frame.v_m().front()) /
                                                 kSectionCell_m) +
                        1;
    const std::size_t k = along * across + std::min(column, across - 1);
    return k < sections.excess_m2.size() ? sections.excess_m2[k] : 0.0f;
  };
  base::parallel_for(rows, 256, options.threads, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      const StretchDeviation left = drift_left(drift, i, frame);
      for (std::size_t j = 0; j < columns; ++j) {
        const std::size_t k = i * columns + j;
        const double v = frame.v_m()[j];
        const auto set = [&](float z, double stddev, NodeSource from_where) {
          result.grid.z_m[k] = z, result.stddev.z_m[k] = static_cast<float>(stddev);
          result.source.z_m[k] =
              from_where == NodeSource::hole ? kNaN : static_cast<float>(from_where);
        };
        const float z = base.z_m[k];
        if (!std::isfinite(z)) {
          set(z, std::numeric_limits<double>::quiet_NaN(), NodeSource::hole);
          continue;
        }
        double n = 0.0, mean = 0.0, variance = 0.0;
        NodeSource how = NodeSource::base;
        if (sums.points[k] >= least) {
          how = NodeSource::lidar;
          n = static_cast<double>(sums.points[k]);
          mean = static_cast<double>(sums.height[k]) / n;
          const double scatter2 =
              std::max(0.0, static_cast<double>(sums.height2[k]) / n - mean * mean) * n /
              std::max(1.0, n - 1.0);
          // Few points say little about their own scatter: the typical one counts as ten more.
          variance =
              ((n - 1.0) * scatter2 + 10.0 * (n < 8.0 ? few_noise2 : noise2)) / (n + 9.0) / n;
        } else {  // a gap among nodes with points
          double around = 0.0, sum = 0.0, sum2 = 0.0;
          for (int di = -1; di <= 1; ++di)
            for (int dj = -1; dj <= 1; ++dj) {
              const auto jj = static_cast<std::ptrdiff_t>(j) + dj;
              auto ii = static_cast<std::ptrdiff_t>(i) + di;
              if (frame.closed())
                ii = (ii + static_cast<std::ptrdiff_t>(rows)) % static_cast<std::ptrdiff_t>(rows);
              if (ii < 0 || ii >= static_cast<std::ptrdiff_t>(rows) || jj < 0 ||
                  jj >= static_cast<std::ptrdiff_t>(columns))
                continue;
              const std::size_t other =
                  static_cast<std::size_t>(ii) * columns + static_cast<std::size_t>(jj);
              if (sums.points[other] < least) continue;
              const double h = static_cast<double>(sums.height[other] / sums.points[other]);
              around += 1.0, sum += h, sum2 += h * h;
            }
          if (around >= 4.0) {
            how = NodeSource::interpolated;
            mean = sum / around;
            variance =
                std::max(0.0, sum2 / around - mean * mean) + typical_noise * typical_noise / 4.0;
          }
        }
        if (how == NodeSource::base) {
          set(z, options.base_stddev_m, how);
          continue;
        }
        // Blades from nothing to twice their mean stand 1.7 deviations above the ground on average.
        variance += 3.0 * static_cast<double>(excess(i, v));
        double in_common = 0.0;  // with the base, which holds the poses
        if (left.seen) {
          const double lever = v - left.v_m;
          in_common += left.var_height + 2.0 * lever * left.cov_height_slope +
                       lever * lever * left.var_slope;
          const Eigen::Vector2d slope = frame.gradient({static_cast<double>(i), v}, 0.15);
          if (slope.allFinite()) {
            const Eigen::Vector2d ahead = frame.ahead(static_cast<double>(i));
            const double along = slope.dot(ahead),
                         across = slope.y() * ahead.x() - slope.x() * ahead.y();
            in_common += along * along * left.var_along + across * across * left.var_across;
          }
        }
        // A base that the points contradict is as uncertain as it is wrong.
        const double base_variance = std::max(options.base_stddev_m * options.base_stddev_m,
                                              mean * mean - variance - in_common);
        const double weight = base_variance / (base_variance + variance);
        set(static_cast<float>(static_cast<double>(z) + weight * mean),
            std::sqrt(weight * variance + in_common), how);
      }
    }
  });
  if (options.blend_m > 0.0 && options.trust_base) blend(frame, base, options, result);
  if (frame.closed())  // the last row is the first again
    for (std::size_t j = 0; j < columns; ++j) {
      const std::size_t last = rows * columns + j;
      const bool changed = result.source.z_m[j] >= static_cast<float>(NodeSource::lidar) &&
                           std::isfinite(base.z_m[last]);
      result.grid.z_m[last] =
          changed ? base.z_m[last] + (result.grid.z_m[j] - base.z_m[j]) : base.z_m[last];
      result.stddev.z_m[last] = result.stddev.z_m[j],
      result.source.z_m[last] = result.source.z_m[j];
    }
  MapReport& report = result.report;
  std::vector<float> changes;
  for (std::size_t k = 0; k < result.source.z_m.size(); ++k) {
    ++report.nodes;
    const float source = result.source.z_m[k];
    if (!std::isfinite(source))
      ++report.nodes_hole;
    else if (source == static_cast<float>(NodeSource::base))
      ++report.nodes_base;
    else if (source == static_cast<float>(NodeSource::blended))
      ++report.nodes_blended;
    else {
      ++(source == static_cast<float>(NodeSource::lidar) ? report.nodes_lidar
                                                         : report.nodes_interpolated);
      changes.push_back(std::abs(result.grid.z_m[k] - base.z_m[k]));
    }
  }
  report.coverage = static_cast<double>(report.nodes_lidar) /
                    std::max(1.0, static_cast<double>(report.nodes - report.nodes_hole));
  if (changes.empty()) return;
  std::sort(changes.begin(), changes.end());
  report.changed_p50_m = static_cast<double>(changes[changes.size() / 2]);
  report.changed_p99_m = static_cast<double>(changes[changes.size() * 99 / 100]);
  report.changed_max_m = static_cast<double>(changes.back());
}

}  // namespace cloud
