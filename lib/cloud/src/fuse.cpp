#include "fuse.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "base/statistics.h"
#include "blend.h"
#include "cloud/error.h"

namespace cloud {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr double kGate_m =
    0.02;  // beyond the robust heights around: four times the noise of a good sensor
constexpr std::size_t kStripeRows = NodeSums::kStripeRows;

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

/// How heights scatter about the mean of their node.
struct Noise {
  double typical_m = 0.0;
  double typical_m2 = 0.0, few_m2 = 0.0;  ///< its square; the same where few points fall
};

Noise noise_of(const NodeSums& sums) {
  std::vector<float> noise;
  for (std::size_t k = 0; k < sums.size(); k += 17)
    if (const NodeSum& sum = sums[k]; sum.points >= 8.0f) {
      const float mean = sum.height / sum.points;
      noise.push_back(std::sqrt(std::max(0.0f, sum.height2 / sum.points - mean * mean) *
                                sum.points / (sum.points - 1.0f)));
    }
  // Nodes with few points lie farther away, where points scatter more than where many fall.
  double few_square = 0.0, few_freedom = 0.0;
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const NodeSum& sum = sums[k];
    const auto n = static_cast<double>(sum.points);
    if (n < 2.0 || n > 3.0) continue;
    const double mean = static_cast<double>(sum.height) / n;
    few_square += std::max(0.0, static_cast<double>(sum.height2) - n * mean * mean);
    few_freedom += n - 1.0;
  }
  const bool few_tell = few_freedom >= 100.0;
  Noise out;
  out.typical_m = few_tell ? std::sqrt(few_square / few_freedom) : 0.005;
  if (noise.size() >= (few_tell ? 100u : 1u))
    out.typical_m = static_cast<double>(base::median(std::move(noise)));
  out.typical_m2 = out.typical_m * out.typical_m;
  out.few_m2 = few_tell ? std::max(out.typical_m2, few_square / few_freedom) : out.typical_m2;
  return out;
}

/// What the points say of a node: height over the base, and how uncertain it is by itself.
struct NodeHeight {
  NodeSource source = NodeSource::base;  ///< base: nothing
  double mean = 0.0, variance = 0.0;
};

/// By a node's own points.
NodeHeight measured_at(const NodeSum& sum, const Noise& noise) {
  const auto n = static_cast<double>(sum.points);
  const double mean = static_cast<double>(sum.height) / n;
  const double scatter2 = std::max(0.0, static_cast<double>(sum.height2) / n - mean * mean) * n /
                          std::max(1.0, n - 1.0);
  // Few points say little about their own scatter: the typical one counts as ten more.
  const double typical2 = n < 8.0 ? noise.few_m2 : noise.typical_m2;
  return {NodeSource::lidar, mean, ((n - 1.0) * scatter2 + 10.0 * typical2) / (n + 9.0) / n};
}

/// In a gap among nodes with at least so many points.
NodeHeight between_neighbours(const NodeSums& sums, std::size_t i, std::size_t j,
                              const RoadFrame& frame, float least, const Noise& noise) {
  const auto columns = static_cast<std::ptrdiff_t>(frame.columns()),
             rows = static_cast<std::ptrdiff_t>(frame.rows() - (frame.closed() ? 1 : 0));
  double around = 0.0, sum = 0.0, sum2 = 0.0;
  for (std::ptrdiff_t di = -1; di <= 1; ++di)
    for (std::ptrdiff_t dj = -1; dj <= 1; ++dj) {
      const std::ptrdiff_t jj = static_cast<std::ptrdiff_t>(j) + dj;
      std::ptrdiff_t ii = static_cast<std::ptrdiff_t>(i) + di;
      if (frame.closed()) ii = (ii + rows) % rows;
      if (ii < 0 || ii >= rows || jj < 0 || jj >= columns) continue;
      const NodeSum& other = sums[static_cast<std::size_t>(ii * columns + jj)];
      if (other.points < least) continue;
      const double h = static_cast<double>(other.height / other.points);
      around += 1.0, sum += h, sum2 += h * h;
    }
  if (!(around >= 4.0)) return {};
  const double mean = sum / around;
  return {NodeSource::interpolated, mean,
          std::max(0.0, sum2 / around - mean * mean) + noise.typical_m * noise.typical_m / 4.0};
}

/// Of grass too low to be told from a rough road, m^2.
float excess_at(const Sections& sections, const RoadFrame& frame, std::size_t row, double v_m) {
  const auto along = static_cast<std::size_t>(static_cast<double>(row) * frame.u_step_m() /
                                              kVergeStretch_m),
             column = static_cast<std::size_t>((v_m - frame.v_m().front()) / kSectionCell_m),
             across = static_cast<std::size_t>((frame.v_m().back() - frame.v_m().front()) /
                                               kSectionCell_m) +
                      1;
  const std::size_t k = along * across + std::min(column, across - 1);
  return k < sections.excess_m2.size() ? sections.excess_m2[k] : 0.0f;
}

/// Variance that a node's height has in common with its neighbours and with the base, which holds
/// the poses: what is left of the drift.
double variance_in_common(const StretchDeviation& left, const RoadFrame& frame, std::size_t row,
                          double v_m) {
  double in_common = 0.0;
  if (!left.seen) return in_common;
  const double lever = v_m - left.v_m;
  in_common +=
      left.var_height + 2.0 * lever * left.cov_height_slope + lever * lever * left.var_slope;
  const Eigen::Vector2d slope = frame.gradient({static_cast<double>(row), v_m}, 0.15);
  if (!slope.allFinite()) return in_common;
  const Eigen::Vector2d ahead = frame.ahead(static_cast<double>(row));
  const double along = slope.dot(ahead), across = slope.y() * ahead.x() - slope.x() * ahead.y();
  return in_common + (along * along * left.var_along + across * across * left.var_across);
}

/// The last row of a closed road is the first again.
void close_seam(const crg::Grid& base, std::size_t rows, std::size_t columns, MapResult& result) {
  for (std::size_t j = 0; j < columns; ++j) {
    const std::size_t last = rows * columns + j;
    const bool changed = result.source.z_m[j] >= static_cast<float>(NodeSource::lidar) &&
                         std::isfinite(base.z_m[last]);
    result.grid.z_m[last] =
        changed ? base.z_m[last] + (result.grid.z_m[j] - base.z_m[j]) : base.z_m[last];
    result.stddev.z_m[last] = result.stddev.z_m[j], result.source.z_m[last] = result.source.z_m[j];
  }
}

/// What nodes rest on, and how far the points moved them from the base.
void report_nodes(const crg::Grid& base, MapResult& result) {
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

}  // namespace

NodeSums::NodeSums(std::size_t rows, std::size_t columns)
    : rows_(rows),
      columns_(columns),
      in_stripe_(kStripeRows * columns),
      stripes_((rows + kStripeRows - 1) / kStripeRows) {}

NodeSums::NodeSums(const RoadFrame& frame)
    : NodeSums(frame.rows() - (frame.closed() ? 1 : 0), frame.columns()) {}

std::vector<NodeSum>& NodeSums::filled_stripe(std::size_t index) {
  std::vector<NodeSum>& stripe = stripes_[index];
  if (stripe.empty()) stripe.resize(std::min(in_stripe_, size() - index * in_stripe_));
  return stripe;
}

void NodeSums::add(const NodeSums& other) {
  if (other.rows_ != rows_ || other.columns_ != columns_)
    throw Error(fmt::format("sums of {} x {} nodes seen, {} x {} wanted: those of another road",
                            other.rows_, other.columns_, rows_, columns_));
  for (std::size_t s = 0; s < stripes_.size(); ++s) {
    const std::vector<NodeSum>& from = other.stripes_[s];
    if (from.empty()) continue;
    std::vector<NodeSum>& to = filled_stripe(s);
    for (std::size_t k = 0; k < from.size(); ++k)
      to[k].points += from[k].points, to[k].height += from[k].height,
          to[k].height2 += from[k].height2;
  }
  read += other.read, used += other.used;
}

NodeSums accumulate(const CloudSource& source, const RoadFrame& frame,
                    const RoadTrajectory* trajectory, const Sections& sections, const Drift& drift,
                    const HeightCells& surface, const MapOptions& options) {
  const std::size_t columns = frame.columns(), rows = frame.rows() - (frame.closed() ? 1 : 0);
  NodeSums sums(frame);
  const std::vector<Band> bands = bands_of(surface, options.threads);
  const std::size_t stripes = sums.stripes();
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
    sums.used += begin[stripes];
    sums.read += chunk.size();
    std::vector<std::uint32_t> at(begin.begin(), begin.end() - 1);
    for (std::size_t k = 0; k < node.size(); ++k)
      if (node[k] != kNone)
        order[at[node[k] / columns / kStripeRows]++] = static_cast<std::uint32_t>(k);
    base::parallel_for(stripes, 1, options.threads, [&](std::size_t from, std::size_t to) {
      for (std::size_t s = from; s < to; ++s) {
        if (begin[s] == begin[s + 1]) continue;
        std::vector<NodeSum>& stripe = sums.filled_stripe(s);
        for (std::size_t k = begin[s]; k < begin[s + 1]; ++k) {
          const std::uint32_t point = order[k];
          NodeSum& sum = stripe[node[point] - s * kStripeRows * columns];
          sum.points += 1.0f, sum.height += height[point],
              sum.height2 += height[point] * height[point];
        }
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
  const Noise noise = noise_of(sums);
  const auto least = static_cast<float>(options.min_points);
  base::parallel_for(rows, 256, options.threads, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      const StretchDeviation left = drift_left(drift, i, frame);
      for (std::size_t j = 0; j < columns; ++j) {
        const std::size_t k = i * columns + j;
        const auto set = [&](float z, double stddev, NodeSource source) {
          result.grid.z_m[k] = z, result.stddev.z_m[k] = static_cast<float>(stddev);
          result.source.z_m[k] = source == NodeSource::hole ? kNaN : static_cast<float>(source);
        };
        const float z = base.z_m[k];
        if (!std::isfinite(z)) {
          set(z, std::numeric_limits<double>::quiet_NaN(), NodeSource::hole);
          continue;
        }
        NodeHeight node = sums[k].points >= least
                              ? measured_at(sums[k], noise)
                              : between_neighbours(sums, i, j, frame, least, noise);
        if (node.source == NodeSource::base) {
          set(z, options.base_stddev_m, node.source);
          continue;
        }
        // Blades from nothing to twice their mean stand 1.7 deviations above the ground on average.
        node.variance += 3.0 * static_cast<double>(excess_at(sections, frame, i, frame.v_m()[j]));
        const double in_common = variance_in_common(left, frame, i, frame.v_m()[j]);
        // A base that the points contradict is as uncertain as it is wrong.
        const double base_variance = std::max(options.base_stddev_m * options.base_stddev_m,
                                              node.mean * node.mean - node.variance - in_common);
        const double weight = base_variance / (base_variance + node.variance);
        set(static_cast<float>(static_cast<double>(z) + weight * node.mean),
            std::sqrt(weight * node.variance + in_common), node.source);
      }
    }
  });
  if (options.blend_m > 0.0 && options.trust_base) blend(frame, base, options, result);
  if (frame.closed()) close_seam(base, rows, columns, result);
  report_nodes(base, result);
}

}  // namespace cloud
