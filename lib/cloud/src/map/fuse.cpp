#include "fuse.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/parallel.h"
#include "base_noise.h"
#include "blend.h"
#include "no_value.h"
#include "overhang.h"

namespace cloud {
namespace {

constexpr double kGate_m =
    0.02;  // beyond the robust heights around: four times the noise of a good sensor
constexpr double kBetweenCells_m = 0.002;  // of the line between two heights
constexpr double kOfSheet = 5.0;           // of a wall's points' deviations
constexpr float kFew = 4.0f;               // points of a node
constexpr std::size_t kStripeRows = NodeSums::kStripeRows;

/// Lowest and highest robust height among a cell and its neighbours.
struct Band {
  float low = kNoValue, high = kNoValue;
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
  const auto value = [&](std::size_t place) {
    const auto at = changes.begin() + static_cast<std::ptrdiff_t>(place);
    std::nth_element(changes.begin(), at, changes.end());
    return static_cast<double>(*at);
  };
  report.changed_p50_m = value(changes.size() / 2);
  report.changed_p99_m = value(changes.size() * 99 / 100);
  report.changed_max_m = static_cast<double>(*std::max_element(changes.begin(), changes.end()));
}

/// A point of a chunk where it goes to.
struct OnNode {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t node = kNone;
  float height_m = 0.0f;
  std::uint8_t range = 0;  ///< class
  int pass = 0;
};

/// Of the drift that cannot be taken out of poses. False: beside the road then.
bool take_out_along_u(const RoadFrame& frame, const Sections& sections, const Drift& drift,
                      RoadPoint& point) {
  const auto s = std::min(static_cast<std::size_t>(point.driven_m / kSectionLength_m),
                          sections.list.size() - 1);
  const Section& section = sections.list[s];
  const Correction c = correction_at(sections, drift.correction, point.driven_m, 0);
  const Eigen::Vector3d p = section.position_m + c.head<3>() +
                            rotation_of(c, section.axes) * (point.map_m - section.position_m);
  const std::optional<GridPlace> moved = frame.project(p.x(), p.y(), point.place.row);
  if (!moved) return false;
  point.place = *moved;
  point.above_base_m = p.z() - frame.z_origin_m() - frame.height(*moved);
  return true;
}

/// How far the surface may lie beside HeightCells::at_edge(): where that goes on along a line, all
/// of a bend of the base before it may be wrong, or missing.
double off_edge_m(const RoadFrame& frame, const HeightCells& surface, std::size_t i, std::size_t j,
                  const GridPlace& place) {
  const double begin_m = surface.v_begin_m + static_cast<double>(j) * surface.cell_m;
  const bool left = place.v_m > begin_m + 0.5 * surface.cell_m;
  const std::size_t on = left ? j + 1 : j - 1;
  if (on < surface.across && std::isfinite(surface.height_m[i * surface.across + on]))
    return kBetweenCells_m;
  return kBetweenCells_m + bend_of(frame, {place.row, left ? begin_m : begin_m + surface.cell_m});
}

/// The node next to a point near the robust surface.
OnNode node_of(const RoadPoint& point, int pass, const RoadFrame& frame, const HeightCells& surface,
               const std::vector<Band>& bands) {
  std::size_t i = 0, j = 0;
  if (!surface.cell_of(point.place, i, j) ||
      !surface.holds(i, j, pass, point.place, point.above_base_m))
    return {};
  const Band& band = bands[i * surface.across + j];
  if (!(point.above_base_m > static_cast<double>(band.low) - kGate_m &&
        point.above_base_m < static_cast<double>(band.high) + kGate_m))
    return {};
  if (const Sheet& sheet = surface.sheet[i * surface.across + j];
      std::abs(point.place.v_m - static_cast<double>(sheet.v_m)) <
      kOfSheet * static_cast<double>(sheet.deviation_m))
    return {};
  if (const auto cut_m = static_cast<double>(surface.cut_above_m[i * surface.across + j]);
      cut_m > 0.0 && point.above_base_m > surface.at_edge(i, j, point.place.v_m) + cut_m +
                                              off_edge_m(frame, surface, i, j, point.place))
    return {};
  std::size_t column = 0;
  double share = 0.0;
  if (!frame.column_of(point.place.v_m, column, share)) return {};
  if (share > 0.5) ++column;
  const std::size_t rows = frame.rows() - (frame.closed() ? 1 : 0);
  std::size_t row = static_cast<std::size_t>(point.place.row + 0.5);
  if (row >= rows) row = frame.closed() ? 0 : rows - 1;
  return {static_cast<std::uint32_t>(row * frame.columns() + column),
          static_cast<float>(point.above_base_m),
          static_cast<std::uint8_t>(range_class(point.ray_m.norm())), pass};
}

/// 1: few points, and no ground.
std::vector<std::uint8_t> wild_nodes(const NodeSums& sums, const RoadFrame& frame,
                                     const MapOptions& options, const Noise& noise) {
  const auto least = static_cast<float>(options.min_points);
  const std::size_t columns = frame.columns();
  std::vector<std::uint8_t> wild(sums.size(), 0);
  const auto look = [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from * columns; k < to * columns; ++k) {
      if (!(sums[k].points >= least && sums[k].points < kFew)) continue;
      const NodeHeight around =
          between_neighbours(sums, k / columns, k % columns, frame, least, noise, {});
      wild[k] = is_wild(measured(sums[k], noise), around) ? 1 : 0;
    }
  };
  base::parallel_for(sums.size() / columns, 256, options.threads, look);
  return wild;
}

}  // namespace

RoadSums accumulate(const CloudSource& source, const RoadFrame& frame,
                    const RoadTrajectory* trajectory, const Sections& sections, const Drift& drift,
                    const HeightCells& surface, const MapOptions& options) {
  const std::size_t columns = frame.columns();
  RoadSums sums(frame, drift);
  const std::vector<Band> bands = bands_of(surface, options.threads);
  const std::size_t stripes = sums.all.stripes();
  std::vector<OnNode> on;
  std::vector<std::uint32_t> order, begin(stripes + 1);
  source([&](Cloud&& chunk) {
    on.resize(chunk.size());
    base::parallel_for(chunk.size(), 16384, options.threads, [&](std::size_t from, std::size_t to) {
      Placer place(frame, trajectory);
      RoadPoint point;
      for (std::size_t k = from; k < to; ++k) {
        on[k] = {};
        if (place(chunk, k, point) != Placed::on_road) continue;
        if (trajectory == nullptr && options.correct_drift &&
            !take_out_along_u(frame, sections, drift, point))
          continue;
        const int pass = trajectory != nullptr ? trajectory->pass[point.pose] : 0;
        on[k] = node_of(point, pass, frame, surface, bands);
      }
    });
    // By stripes of rows, so that each sum is made by one thread in the order of the points.
    std::fill(begin.begin(), begin.end(), 0u);
    for (const OnNode& point : on)
      if (point.node != OnNode::kNone) ++begin[point.node / columns / kStripeRows + 1];
    for (std::size_t s = 0; s < stripes; ++s) begin[s + 1] += begin[s];
    order.resize(begin[stripes]);
    sums.used += begin[stripes];
    sums.read += chunk.size();
    std::vector<std::uint32_t> at(begin.begin(), begin.end() - 1);
    for (std::size_t k = 0; k < on.size(); ++k)
      if (on[k].node != OnNode::kNone)
        order[at[on[k].node / columns / kStripeRows]++] = static_cast<std::uint32_t>(k);
    base::parallel_for(stripes, 1, options.threads, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = begin[from]; k < begin[to]; ++k) {
        const OnNode& point = on[order[k]];
        sums.add(point.node, point.pass, point.height_m, point.range);
      }
    });
  });
  return sums;
}

void fuse(const RoadSums& road_sums, const RoadFrame& frame, const crg::Grid& base,
          const Sections& sections, const Drift& drift, const MapOptions& options,
          MapResult& result) {
  const std::size_t columns = frame.columns(), rows = frame.rows() - (frame.closed() ? 1 : 0);
  result.grid = base, result.stddev = base, result.source = base;
  const NodeSums& sums = road_sums.all;
  const Noise noise = noise_of(sums);
  const LeftOut seen = look_at_left_out(road_sums, frame, drift, noise);
  const double noise_factor2 = seen.noise_factor * seen.noise_factor;
  result.report.left_out_nodes = seen.nodes, result.report.left_out_within_90 = seen.within_90,
  result.report.noise_factor = seen.noise_factor;
  if (!seen.is_clear)
    result.report.remarks.push_back(fmt::format(
        "one pass left out, the 90 % intervals of the others hold {:.0f} % of its nodes: passes "
        "differ by more than the points' scatter and the drift that is left explain; the stated "
        "deviations are too small",
        100.0 * seen.within_90));
  const auto least = static_cast<float>(options.min_points);
  std::vector<std::uint8_t> seen_row(rows, 0);
  for (std::size_t k = 0; k < rows * columns; ++k)
    if (sums[k].points >= least) seen_row[k / columns] = 1;
  const std::vector<std::uint8_t> wild = wild_nodes(sums, frame, options, noise);
  const BaseNoise base_noise(base, frame.closed(), [&](std::size_t k) {
    return sums[k].points >= kFew ? measured(sums[k], noise).mean
                                  : std::numeric_limits<double>::quiet_NaN();
  });
  base::parallel_for(rows, 256, options.threads, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      const StretchDeviation left = drift_left(drift, i, frame);
      const bool is_near =
          seen_row[i] + seen_row[i > 0 ? i - 1 : rows - 1] + seen_row[i + 1 < rows ? i + 1 : 0] > 0;
      for (std::size_t j = 0; j < columns; ++j) {
        const std::size_t k = i * columns + j;
        const auto set = [&](float z, double stddev, NodeSource source) {
          result.grid.z_m[k] = z, result.stddev.z_m[k] = static_cast<float>(stddev);
          result.source.z_m[k] = source == NodeSource::hole ? kNoValue : static_cast<float>(source);
        };
        const float z = base.z_m[k];
        if (!std::isfinite(z)) {
          set(z, std::numeric_limits<double>::quiet_NaN(), NodeSource::hole);
          continue;
        }
        NodeHeight node;
        const double grass_m2 = variance_of_grass(sections, frame, i, frame.v_m()[j]);
        if (sums[k].points >= least && wild[k] == 0) node = measured(sums[k], noise);
        const bool clear =
            node.source == NodeSource::lidar && sums[k].points >= kFew && grass_m2 == 0.0;
        if (is_near && !clear) {
          NodeHeight around = between_neighbours(sums, i, j, frame, least, noise, wild);
          if (node.source == NodeSource::base)
            around = better(around, along_column(sums, i, j, frame, least, noise, wild));
          node = together(node, around);
        }
        if (node.source == NodeSource::base) {
          set(z, options.base_stddev_m, node.source);
          continue;
        }
        // A mean of many points holds a little of the base's own noise, one of neighbours more.
        const double of_base_m =
            base_noise.stddev_m() * (node.source == NodeSource::lidar ? 0.1 : 0.8);
        node.mean -= base_noise.over_mean_m(i, j);
        node.variance = noise_factor2 * node.variance + grass_m2 + of_base_m * of_base_m;
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
