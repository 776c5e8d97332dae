#include "bow.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/statistics.h"

namespace cloud {
namespace {

constexpr double kBlock_m = 5.0;           // of the road, whose heights are one
constexpr std::size_t kFewestBlocks = 10;  // 50 m
constexpr int kBowRounds = 10;
constexpr double kMostLeft = 0.25;  // of the range, by which four fifths of the blocks may be off
constexpr double kTold_m = 0.01;
constexpr double kTooMuch = 1.5;  // times the base's stated deviation

struct Block {
  Eigen::Vector2d at_m = Eigen::Vector2d::Zero();
  double u_m = 0.0, height_m = 0.0;
};

/// Median across the road of what two places as far to the left and right have in common: a wrong
/// banking has none. NaN without such places.
double middle_of(const HeightCells& cells, std::size_t row) {
  std::vector<double> pairs;
  const double sides = -2.0 * cells.v_begin_m / cells.cell_m;  // in cells, if as wide to the right
  for (std::size_t j = 0; j < cells.across; ++j) {
    const double mirrored = std::round(sides - static_cast<double>(j) - 1.0);
    if (!(mirrored >= static_cast<double>(j) && mirrored < static_cast<double>(cells.across)))
      continue;
    const float* const heights = cells.height_m.data() + row * cells.across;
    const float sum = heights[j] + heights[static_cast<std::size_t>(mirrored)];
    if (std::isfinite(sum)) pairs.push_back(0.5 * static_cast<double>(sum));
  }
  return base::median_or(std::numeric_limits<double>::quiet_NaN(), std::move(pairs));
}

/// Medians over blocks of those across the road.
std::vector<Block> blocks_of(const HeightCells& cells, const RoadFrame& frame) {
  const auto rows = static_cast<std::size_t>(std::max(1.0, std::round(kBlock_m / cells.cell_m)));
  std::vector<Block> blocks;
  for (std::size_t begin = 0; begin < cells.along; begin += rows) {
    const std::size_t end = std::min(begin + rows, cells.along);
    std::vector<double> heights;
    for (std::size_t i = begin; i < end; ++i) {
      const double height_m = middle_of(cells, i);
      if (std::isfinite(height_m)) heights.push_back(height_m);
    }
    if (2 * heights.size() < rows) continue;
    const double middle = 0.5 * static_cast<double>(begin + end) * cells.cell_rows;
    const auto row = std::min(static_cast<std::size_t>(middle), frame.rows() - 1);
    blocks.push_back({frame.node_position(row, 0.0),
                      frame.u_begin_m() + static_cast<double>(row) * frame.u_step_m(),
                      base::median(std::move(heights))});
  }
  return blocks;
}

/// Constant, plane and second order at each block, in halves of the extent.
Eigen::MatrixXd terms_of(const std::vector<Block>& blocks) {
  Eigen::Vector2d low = blocks.front().at_m, high = low;
  for (const Block& block : blocks)
    low = low.cwiseMin(block.at_m), high = high.cwiseMax(block.at_m);
  const Eigen::Vector2d middle = 0.5 * (low + high);
  const double half = 0.5 * std::max((high - low).maxCoeff(), 1.0);
  Eigen::MatrixXd terms(static_cast<Eigen::Index>(blocks.size()), 6);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const Eigen::Vector2d p = (blocks[k].at_m - middle) / half;
    terms.row(static_cast<Eigen::Index>(k)) << 1.0, p.x(), p.y(), p.x() * p.x(), p.x() * p.y(),
        p.y() * p.y();
  }
  return terms;
}

/// Least squares by weights; what the places do not tell apart is kept small.
Eigen::VectorXd fitted(const Eigen::MatrixXd& terms, const Eigen::VectorXd& heights_m,
                       const Eigen::VectorXd& weights) {
  Eigen::MatrixXd normal = terms.transpose() * weights.asDiagonal() * terms;
  normal.diagonal().array() += 1e-6 * weights.sum();
  const Eigen::VectorXd right = terms.transpose() * weights.cwiseProduct(heights_m);
  return terms * normal.ldlt().solve(right);
}

double share_of(const Eigen::VectorXd& values, double share) {
  std::vector<double> sizes;
  for (const double value : values) sizes.push_back(std::abs(value));
  return base::quantile(sizes, share);
}

}  // namespace

Bow bow_of(const HeightCells& cells, const RoadFrame& frame) {
  const std::vector<Block> blocks = blocks_of(cells, frame);
  if (blocks.size() < kFewestBlocks) return {};
  const Eigen::MatrixXd terms = terms_of(blocks);
  Eigen::VectorXd heights_m(static_cast<Eigen::Index>(blocks.size()));
  for (std::size_t k = 0; k < blocks.size(); ++k)
    heights_m[static_cast<Eigen::Index>(k)] = blocks[k].height_m;
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(heights_m.size()), surface;
  for (int round = 0; round < kBowRounds; ++round) {  // Tukey's weights
    surface = fitted(terms, heights_m, weights);
    const Eigen::VectorXd off = heights_m - surface;
    const double gate_m = 4.685 * std::max(1e-3, share_of(off, 0.5) / 0.6745);
    weights = (1.0 - (off / gate_m).array().square()).max(0.0).square();
  }
  Eigen::Index low = 0, high = 0;
  const double range_m = surface.maxCoeff(&high) - surface.minCoeff(&low);
  if (share_of(heights_m - surface, 0.8) > kMostLeft * range_m) return {};
  return {range_m, blocks[static_cast<std::size_t>(low)].u_m,
          blocks[static_cast<std::size_t>(high)].u_m};
}

void look_at_bow(const Bow& bow, const MapOptions& options, MapReport& report) {
  if (!(bow.range_m >= kTold_m)) return;
  const bool too_much = bow.range_m > kTooMuch * options.base_stddev_m;
  const std::string text = fmt::format(
      "the cloud bends or tilts against the base as a whole by {:.0f} mm, from its lowest at u "
      "{:.0f} m to its highest at u {:.0f} m: a dome of the cloud, as drones make without control "
      "points, or the base's own; without a trajectory nothing tells which, and {}",
      1e3 * bow.range_m, bow.low_u_m, bow.high_u_m,
      options.correct_drift ? "the road follows the base in part" : "the road follows the cloud");
  if (too_much)
    report.faults.push_back(
        text +
        "; compare heights with control points; if the base is known to be off by so much, "
        "say so (--base-stddev-m)");
  else
    report.remarks.push_back(text);
}

}  // namespace cloud
