#include "node_height.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/interval90.h"
#include "base/statistics.h"
#include "cloud/error.h"

namespace cloud {

namespace {

constexpr double kAsADefault_m = 0.005;      // a good sensor's range noise, where nothing tells
constexpr std::size_t kEnough = 30;          // pairs of points of a class: 12 % either way
constexpr double kSlopeHeld = 0.1;           // as few nodes, one step away, do that are level
constexpr std::size_t kLeastAround = 4;      // nodes with points, of eight
constexpr double kAlong_m = 2.5;             // to a node before, and to one behind
constexpr double kUneven_m = 0.005;          // beyond this an edge lies between them
constexpr std::size_t kMostNodes = 200'000;  // of all classes

/// Deviation of one point by what nine of ten pairs in a node lie apart: 90 % intervals hold then,
/// whatever few wild ones there are.
double by_pairs_m2(std::vector<float>&& half_squares_m2) {
  const auto at = half_squares_m2.begin() +
                  static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(half_squares_m2.size()));
  std::nth_element(half_squares_m2.begin(), at, half_squares_m2.end());
  return static_cast<double>(*at) / (base::kNormal90 * base::kNormal90);
}

}  // namespace

std::size_t range_class(double range_m) {
  const double octaves = std::log2(std::max(range_m, 1.0));
  return std::min(static_cast<std::size_t>(4.0 * octaves), kRanges - 1);
}

NodeSums::NodeSums(std::size_t rows, std::size_t columns, std::size_t stripe_rows)
    : rows_(rows),
      columns_(columns),
      in_stripe_(stripe_rows * columns),
      stripes_((rows + stripe_rows - 1) / stripe_rows) {}

std::vector<NodeSum>& NodeSums::filled_stripe(std::size_t index) {
  std::vector<NodeSum>& stripe = stripes_[index];
  if (stripe.empty()) stripe.resize(std::min(in_stripe_, size() - index * in_stripe_));
  return stripe;
}

void NodeSums::add(const NodeSums& other) {
  if (other.rows_ != rows_ || other.columns_ != columns_ || other.in_stripe_ != in_stripe_)
    throw Error(fmt::format("sums of {} x {} nodes seen, {} x {} wanted: those of another road",
                            other.rows_, other.columns_, rows_, columns_));
  for (std::size_t s = 0; s < stripes_.size(); ++s) {
    const std::vector<NodeSum>& from = other.stripes_[s];
    if (from.empty()) continue;
    std::vector<NodeSum>& to = filled_stripe(s);
    for (std::size_t k = 0; k < from.size(); ++k) to[k].add(from[k]);
  }
}

PartSum::PartSum(const NodeSum& sum)
    : points(static_cast<double>(sum.points)),
      height(static_cast<double>(sum.height)),
      height2(static_cast<double>(sum.height2)),
      range(static_cast<double>(sum.range)) {}

Noise noise_of(const NodeSums& sums) {
  std::vector<float> many;
  std::array<std::vector<float>, kRanges> pairs;
  std::vector<float> all_pairs;
  const std::size_t nodes = sums.size(), every = 1 + nodes / (20 * kMostNodes);
  for (std::size_t k = 0; k < nodes; k += every) {
    const NodeSum& sum = sums[k];
    const float n = sum.points, mean = sum.height / n;
    if (n >= 8.0f && k % 17 == 0)
      many.push_back(std::sqrt(std::max(0.0f, sum.height2 / n - mean * mean) * n / (n - 1.0f)));
    if (n != 2.0f) continue;
    const float half_square = std::max(0.0f, sum.height2 - n * mean * mean);
    pairs[std::min<std::size_t>(sum.range / 2, kRanges - 1)].push_back(half_square);
    all_pairs.push_back(half_square);
  }
  const bool pairs_tell = all_pairs.size() >= kEnough;
  double mean_square_m2 = 0.0;
  for (const float half_square : all_pairs)
    mean_square_m2 += static_cast<double>(half_square) / static_cast<double>(all_pairs.size());
  const double all_m2 =
      pairs_tell ? by_pairs_m2(std::move(all_pairs)) : kAsADefault_m * kAsADefault_m;
  Noise out;
  out.typical_m2 = all_m2;
  double least_m2 = 0.0;
  if (many.size() >= (pairs_tell ? kEnough : 1)) {
    const auto typical_m = static_cast<double>(base::median(std::move(many)));
    out.typical_m2 = typical_m * typical_m;
    least_m2 = std::max(out.typical_m2, mean_square_m2);
  }
  std::array<bool, kRanges> found{};
  for (std::size_t c = 0; c < kRanges; ++c)
    if (found[c] = pairs[c].size() >= kEnough; found[c])
      out.few_m2[c] = by_pairs_m2(std::move(pairs[c]));
  // Classes with few pairs take the nearest one's.
  const std::array<double, kRanges> known = out.few_m2;
  for (std::size_t c = 0; c < kRanges; ++c) {
    if (found[c]) continue;
    out.few_m2[c] = pairs_tell ? all_m2 : out.typical_m2;
    for (std::size_t away = 1; away < kRanges; ++away) {
      const bool nearer = c >= away && found[c - away],
                 farther = c + away < kRanges && found[c + away];
      if (!nearer && !farther) continue;
      out.few_m2[c] = nearer ? known[c - away] : known[c + away];
      break;
    }
  }
  // Where many points fall elsewhere, few fall beside the road: on grass too low to be told, which
  // stands as high as it scatters. One measure then for all of few, whatever their range.
  if (least_m2 > 0.0) out.few_m2.fill(least_m2);
  return out;
}

NodeHeight measured(const PartSum& sum, const Noise& noise) {
  const double n = sum.points, mean = sum.height / n;
  const double scatter2 = std::max(0.0, sum.height2 / n - mean * mean) * n / std::max(1.0, n - 1.0);
  // Few points say little about their own scatter: the typical one counts as ten more.
  const auto range = std::min(static_cast<std::size_t>(sum.range / n), kRanges - 1);
  const double typical2 = n < 8.0 ? noise.few_m2[range] : noise.typical_m2;
  return {NodeSource::lidar, mean, ((n - 1.0) * scatter2 + 10.0 * typical2) / (n + 9.0) / n};
}

namespace {

/// A node beside another: 1, rows, columns from that.
struct Neighbour {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  NodeHeight height;
};

/// The plane of some nodes, and what they scatter about it, m^2 together.
struct NodePlane {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();
  double scatter_m2 = 0.0;

  explicit NodePlane(const std::vector<Neighbour>& nodes) {
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Neighbour& node : nodes)
      normal += node.at * node.at.transpose(), right += node.height.mean * node.at;
    Eigen::Matrix3d held = normal;
    held.diagonal().tail<2>().array() += kSlopeHeld;
    plane = held.ldlt().solve(right);
    for (const Neighbour& node : nodes) scatter_m2 += std::pow(above(node), 2);
  }
  double above(const Neighbour& node) const { return node.height.mean - plane.dot(node.at); }
};

/// Without the highest of the nodes, if the others have a plane that it has no part in.
NodePlane plane_of(std::vector<Neighbour>& nodes) {
  NodePlane plane(nodes);
  if (nodes.size() <= kLeastAround) return plane;
  std::vector<Neighbour> others = nodes;
  others.erase(std::max_element(
      others.begin(), others.end(),
      [&](const Neighbour& a, const Neighbour& b) { return plane.above(a) < plane.above(b); }));
  NodePlane without(others);
  if (without.scatter_m2 > 0.1 * plane.scatter_m2) return plane;
  nodes = std::move(others);
  return without;
}

}  // namespace

NodeHeight between_neighbours(const NodeSums& sums, std::size_t row, std::size_t column,
                              const RoadFrame& frame, float least, const Noise& noise,
                              const std::vector<std::uint8_t>& wild) {
  const auto columns = static_cast<std::ptrdiff_t>(frame.columns()),
             rows = static_cast<std::ptrdiff_t>(frame.rows() - (frame.closed() ? 1 : 0));
  std::vector<Neighbour> nodes;
  nodes.reserve(8);
  for (std::ptrdiff_t di = -1; di <= 1; ++di)
    for (std::ptrdiff_t dj = -1; dj <= 1; ++dj) {
      const std::ptrdiff_t jj = static_cast<std::ptrdiff_t>(column) + dj;
      std::ptrdiff_t ii = static_cast<std::ptrdiff_t>(row) + di;
      if (frame.closed()) ii += ii < 0 ? rows : ii >= rows ? -rows : 0;
      if (ii < 0 || ii >= rows || jj < 0 || jj >= columns || (di == 0 && dj == 0)) continue;
      const auto k = static_cast<std::size_t>(ii * columns + jj);
      if (sums[k].points >= least && (wild.empty() || wild[k] == 0))
        nodes.push_back(
            {{1.0, static_cast<double>(di), static_cast<double>(dj)}, measured(sums[k], noise)});
    }
  if (nodes.size() < kLeastAround) return {};
  const NodePlane fit = plane_of(nodes);
  const auto around = static_cast<double>(nodes.size());
  double own = 0.0, mean = 0.0, mean2 = 0.0;
  for (const Neighbour& node : nodes)
    own += node.height.variance / around, mean += node.height.mean / around,
        mean2 += node.height.mean * node.height.mean / around;
  const Eigen::Array2d place = fit.normal.col(0).tail<2>() / around,  // from the node, in steps
      place2 = fit.normal.diagonal().tail<2>().array() / around - place.square();
  // What the neighbours scatter beyond their own noise is the base's error that goes on from one to
  // the next, as a slope or in one step: half of it in the middle of them. Where they lie to one
  // side their plane may not go on.
  const double uneven = std::max(0.0, mean2 - mean * mean - own),
               off_plane = std::max(0.0, fit.scatter_m2 / (around - 2.0) - own),
               aside = (place.square() / place2.max(0.1)).sum(), sloped = fit.plane[0] - mean;
  // On which side of an edge the node lies they do not tell.
  if (uneven > std::max(2.0 * kUneven_m * kUneven_m, 4.0 * own)) return {};
  return {NodeSource::interpolated, fit.plane[0],
          own / around * (1.0 + aside) + 0.5 * uneven + aside * off_plane + 0.25 * sloped * sloped};
}

NodeHeight along_column(const NodeSums& sums, std::size_t row, std::size_t column,
                        const RoadFrame& frame, float least, const Noise& noise,
                        const std::vector<std::uint8_t>& wild) {
  const auto rows = static_cast<std::ptrdiff_t>(frame.rows() - (frame.closed() ? 1 : 0)),
             reach = static_cast<std::ptrdiff_t>(kAlong_m / frame.u_step_m());
  const auto nearest = [&](std::ptrdiff_t way, double& far) -> NodeHeight {
    for (std::ptrdiff_t step = 1; step <= std::min(reach, rows - 1); ++step) {
      std::ptrdiff_t i = static_cast<std::ptrdiff_t>(row) + way * step;
      if (frame.closed()) i = (i + rows) % rows;
      if (i < 0 || i >= rows) break;
      const std::size_t k = static_cast<std::size_t>(i) * frame.columns() + column;
      if (!(sums[k].points >= least) || (!wild.empty() && wild[k] != 0)) continue;
      far = static_cast<double>(step);
      return measured(sums[k], noise);
    }
    return {};
  };
  double back = 1.0, forth = 1.0;
  const NodeHeight a = nearest(-1, back), b = nearest(1, forth);
  if (a.source == NodeSource::base || b.source == NodeSource::base) return {};
  const double share = back / (back + forth), apart = b.mean - a.mean;
  // What they lie apart beyond their noise may come anywhere between them: evenly, over that width.
  return {NodeSource::interpolated, a.mean + share * apart,
          (1.0 - share) * (1.0 - share) * a.variance + share * share * b.variance +
              std::max(0.0, apart * apart - a.variance - b.variance) / 12.0};
}

NodeHeight better(const NodeHeight& a, const NodeHeight& b) {
  if (a.source == NodeSource::base || b.source == NodeSource::base)
    return a.source == NodeSource::base ? b : a;
  return b.variance < a.variance ? b : a;
}

NodeHeight together(const NodeHeight& node, const NodeHeight& around) {
  if (node.source == NodeSource::base || around.source == NodeSource::base)
    return node.source == NodeSource::base ? around : node;
  const double share = around.variance / (node.variance + around.variance);
  return {node.source, share * node.mean + (1.0 - share) * around.mean, share * node.variance};
}

bool is_wild(const NodeHeight& node, const NodeHeight& around) {
  const double above = node.mean - around.mean;
  return around.source != NodeSource::base && above > 0.0 &&
         above * above > 9.0 * (node.variance + around.variance);
}

double variance_of_grass(const Sections& sections, const RoadFrame& frame, std::size_t row,
                         double v_m) {
  const std::size_t k = verge_column(frame, static_cast<double>(row), v_m);
  // Blades from nothing to twice their mean stand 1.7 deviations above the ground on average.
  return k < sections.excess_m2.size() ? 3.0 * static_cast<double>(sections.excess_m2[k]) : 0.0;
}

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

}  // namespace cloud
