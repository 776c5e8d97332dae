#include "left_out.h"

#include <algorithm>
#include <cmath>

#include "base/interval90.h"

namespace cloud {
namespace {

constexpr std::size_t kEnoughNodes = 1000;        // nodes
constexpr std::size_t kMostLookedAt = 300'000;    // that are looked at
constexpr double kLeast2 = 1.0, kLargest2 = 4.0;  // of the factor's square

/// One node: square of the difference, variance of the points' noise and of the drift.
struct Difference {
  double square_m2 = 0.0, noise_m2 = 0.0, drift_m2 = 0.0;
};

std::size_t rows_of(const RoadFrame& frame) { return frame.rows() - (frame.closed() ? 1 : 0); }

/// Of each kLeftOutRows-th row; empty: no stretch leaves one out.
std::vector<int> passes_left_out(const RoadFrame& frame, const Drift& drift) {
  std::vector<int> out;
  bool any = false;
  for (std::size_t row = 0; row < rows_of(frame); row += kLeftOutRows) {
    const auto stretch =
        static_cast<std::size_t>(static_cast<double>(row) * frame.u_step_m() / kStretch_m);
    out.push_back(stretch < drift.apart.size() ? drift.apart[stretch].pass : -1);
    any |= out.back() >= 0;
  }
  if (!any) out.clear();
  return out;
}

PartSum less(PartSum all, const PartSum& part) {
  all.points -= part.points, all.height -= part.height;
  all.height2 = std::max(0.0, all.height2 - part.height2);
  all.range = std::max(0.0, all.range - part.range);
  return all;
}

std::vector<Difference> differences(const RoadSums& sums, const RoadFrame& frame,
                                    const Drift& drift, const Noise& noise) {
  const std::size_t columns = frame.columns(), all = sums.left_out.size();
  std::vector<Difference> out;
  for (std::size_t at = 0; at < all; at += 1 + all / (8 * kMostLookedAt)) {
    const std::size_t row = at / columns * kLeftOutRows, column = at % columns,
                      node = row * columns + column;
    const auto one = static_cast<double>(sums.left_out[at].points);
    if (one < 1.0) continue;
    const double others = static_cast<double>(sums.all[node].points) - one;
    const auto stretch =
        static_cast<std::size_t>(static_cast<double>(row) * frame.u_step_m() / kStretch_m);
    if (others < 1.0 || stretch >= drift.apart.size()) continue;
    const StretchDeviation& apart = drift.apart[stretch].deviation;
    if (!apart.seen) continue;
    const PartSum alone = sums.left_out[at], rest = less(sums.all[node], alone);
    const NodeHeight a = measured(alone, noise), b = measured(rest, noise);
    // Grass stands under both alike.
    out.push_back({(a.mean - b.mean) * (a.mean - b.mean), a.variance + b.variance,
                   variance_in_common(apart, frame, row, frame.v_m()[column])});
  }
  return out;
}

double within_90(const std::vector<Difference>& differences, double factor2) {
  std::size_t within = 0;
  for (const Difference& d : differences)
    within += d.square_m2 <= base::kNormal90 * base::kNormal90 * (factor2 * d.noise_m2 + d.drift_m2)
                  ? 1
                  : 0;
  return static_cast<double>(within) / static_cast<double>(differences.size());
}

}  // namespace

static_assert(NodeSums::kStripeRows % kLeftOutRows == 0);

RoadSums::RoadSums(const RoadFrame& frame, const Drift& drift)
    : RoadSums(frame, passes_left_out(frame, drift)) {}

RoadSums::RoadSums(const RoadFrame& frame, std::vector<int> passes)
    : all(rows_of(frame), frame.columns()),
      left_out(passes.size(), frame.columns(), NodeSums::kStripeRows / kLeftOutRows),
      columns_(frame.columns()),
      passes_(std::move(passes)) {}

void RoadSums::add(std::size_t node, int pass, float height_m, std::uint8_t range_class) {
  all.filled(node).add(height_m, range_class);
  const std::size_t row = node / columns_, at = row / kLeftOutRows;
  if (passes_.empty() || row % kLeftOutRows != 0 || pass != passes_[at]) return;
  left_out.filled(at * columns_ + node % columns_).add(height_m, range_class);
}

void RoadSums::add(const RoadSums& other) {
  all.add(other.all), left_out.add(other.left_out);
  read += other.read, used += other.used;
}

LeftOut look_at_left_out(const RoadSums& sums, const RoadFrame& frame, const Drift& drift,
                         const Noise& noise) {
  LeftOut out;
  const std::vector<Difference> seen = differences(sums, frame, drift, noise);
  out.nodes = seen.size();
  if (seen.empty()) return out;
  out.within_90 = within_90(seen, 1.0);
  // Only wider: what both have in common, such as grass, does not show between them.
  if (seen.size() < kEnoughNodes || out.within_90 >= 0.9) return out;
  double low = kLeast2, high = kLargest2;
  for (int k = 0; k < 20; ++k) {
    const double middle = std::sqrt(low * high);
    (within_90(seen, middle) < 0.9 ? low : high) = middle;
  }
  out.noise_factor = std::sqrt(std::sqrt(low * high));
  out.is_clear = within_90(seen, out.noise_factor * out.noise_factor) > 0.88;
  return out;
}

}  // namespace cloud
