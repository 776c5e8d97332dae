// Walls, cars and trees: what stands on the road hides it, and the ground beside it is seen all the
// same.
#include <algorithm>
#include <cmath>

#include "collector.h"

namespace cloud {
namespace {

constexpr std::size_t kAround = 2;  // cells to all sides of an obstacle: 1 m
// Noise, drift, and feet that bulge; along the road few beams meet the same wall.
constexpr float kAlong_m = 1.0f, kAcross_m = 0.25f;
constexpr std::uint32_t kLeastOfSheet = 4;  // points

}  // namespace

void StandingBox::add(float a_m, float b_m) {
  low_a_m = std::min(low_a_m, a_m), high_a_m = std::max(high_a_m, a_m);
  low_b_m = std::min(low_b_m, b_m), high_b_m = std::max(high_b_m, b_m);
}

bool StandingBox::is_near(float a_m, float b_m) const {
  return a_m > low_a_m - kAlong_m && a_m < high_a_m + kAlong_m && b_m > low_b_m - kAcross_m &&
         b_m < high_b_m + kAcross_m;
}

bool Collector::near_obstacle(const OpenSection& open, std::size_t i, std::size_t j) const {
  for (std::size_t k = i - std::min(i, kAround); k <= std::min(i + kAround, along_ - 1); ++k)
    for (std::size_t l = j - std::min(j, kAround); l <= std::min(j + kAround, across_ - 1); ++l)
      if (open.sums[k * across_ + l].obstacle) return true;
  return false;
}

Collector::Sum Collector::ground_beside_obstacle(const Section& section, const OpenSection& open,
                                                 std::size_t cell, double noise_m) const {
  const std::size_t i = cell / across_, j = cell % across_;
  std::vector<StandingBox> standing;  // about the middle of this cell
  for (std::size_t k = i - std::min(i, 2 * kAround); k <= std::min(i + 2 * kAround, along_ - 1);
       ++k)
    for (std::size_t l = j - std::min<std::size_t>(j, 1); l <= std::min(j + 1, across_ - 1); ++l) {
      const std::int32_t tall = open.sums[k * across_ + l].tall;
      if (tall < 0) continue;
      StandingBox box = open.tall[static_cast<std::size_t>(tall)].box;
      const auto a_m = static_cast<float>((static_cast<double>(k) - static_cast<double>(i)) *
                                          kSectionCell_m),
                 b_m = static_cast<float>((static_cast<double>(l) - static_cast<double>(j)) *
                                          kSectionCell_m);
      box.low_a_m += a_m, box.high_a_m += a_m, box.low_b_m += b_m, box.high_b_m += b_m;
      standing.push_back(box);
    }
  const auto stands = [&](const EdgePoint& p) {
    return std::any_of(standing.begin(), standing.end(),
                       [&](const StandingBox& box) { return box.is_near(p.a_m, p.b_m); });
  };
  Sum left;
  for (const std::size_t reach : {std::size_t{0}, kAround}) {
    std::vector<EdgePoint> points = points_in(open, cell, reach);
    points.erase(std::remove_if(points.begin(), points.end(), stands), points.end());
    const std::vector<std::uint8_t> ground = ground_among(points, noise_m);
    if (ground.empty()) continue;
    std::size_t at = 0;  // the cell's own points come first
    for (std::int32_t k = open.sums[cell].last; k >= 0;
         k = open.points[static_cast<std::size_t>(k)].before) {
      const Fall& fall = open.points[static_cast<std::size_t>(k)].fall;
      if (stands({static_cast<float>(fall.a_m), static_cast<float>(fall.b_m), 0.0f})) continue;
      if (ground[at++] != 0) add(fall, section, left);
    }
    break;
  }
  if (const std::int32_t own = open.sums[cell].tall; own >= 0) {
    const Tall& tall = open.tall[static_cast<std::size_t>(own)];
    const double mean_m = tall.b / tall.points;
    if (tall.points >= kLeastOfSheet)
      left.sheet = {static_cast<float>(v_of(j) + mean_m),
                    static_cast<float>(std::sqrt(tall.bb / tall.points - mean_m * mean_m + 1e-8))};
  }
  if (left.points < open.sums[cell].points)
    left.cut_above_m = static_cast<float>(most_above_ground_m(noise_m));
  return left;
}

void Collector::leave_out_obstacles(const Section& section, OpenSection& open) const {
  if (std::none_of(open.tall.begin(), open.tall.end(),
                   [&](const Tall& tall) { return open.sums[tall.cell].obstacle; }))
    return;
  const LaneScatter lane = lane_of(section, open);
  std::vector<std::pair<std::size_t, Sum>> changed;  // each is judged by what its neighbours were
  for (std::size_t k = 0; k < open.sums.size(); ++k) {
    if (open.sums[k].points < 2 || !near_obstacle(open, k / across_, k % across_)) continue;
    const double noise = noise_m(section, lane, open, k);
    const Sum ground = noise > 0.0 ? ground_beside_obstacle(section, open, k, noise) : Sum();
    changed.emplace_back(k, ground);
    changed.back().second.beside = true;
    if (ground.points >= 2) continue;
    changed.back().second = open.sums[k], changed.back().second.obstacle = true;
  }
  for (const auto& [k, sum] : changed) open.sums[k] = sum;
}

}  // namespace cloud
