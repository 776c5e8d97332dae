// Rain in the air: its drops are no obstacles, and no ground.
#include <algorithm>
#include <cmath>

#include "base/statistics.h"
#include "collector.h"

namespace cloud {
namespace {

// Of the points around that reach the ground: an obstacle hides it, rain does not.
constexpr double kMostDrops = 0.12;
// Drops over the gate for points that reach the ground: a quarter or so of all drops in the air.
constexpr double kRain = 0.0002;

}  // namespace

void Collector::Sum::take_away(const Sum& other) {
  x -= other.x, y -= other.y, z -= other.z;
  driven -= other.driven, driven2 -= other.driven2;
  height -= other.height, height2 -= other.height2;
  a -= other.a, b -= other.b, aa -= other.aa, ab -= other.ab, bb -= other.bb;
  ah -= other.ah, bh -= other.bh, sine2 -= other.sine2;
  points -= other.points;
}

void Collector::find_obstacles(OpenSection& open) const {
  for (const Tall& tall : open.tall) {
    const std::size_t i = tall.cell / across_, j = tall.cell % across_;
    double above = 0.0, ground = 0.0;
    for (std::size_t a = i - std::min<std::size_t>(i, 1); a <= std::min(i + 1, along_ - 1); ++a)
      for (std::size_t b = j - std::min<std::size_t>(j, 1); b <= std::min(j + 1, across_ - 1);
           ++b) {
        const Sum& sum = open.sums[a * across_ + b];
        if (sum.tall >= 0) above += open.tall[static_cast<std::size_t>(sum.tall)].points;
        ground += sum.points;
      }
    open.sums[tall.cell].obstacle = above > kMostDrops * ground;
  }
}

void Collector::leave_out_drops(const Section& section, OpenSection& open) const {
  double drops = 0.0, ground = 0.0;
  for (const Tall& tall : open.tall) drops += open.sums[tall.cell].obstacle ? 0.0 : tall.points;
  if (!(drops > 0.0)) return;
  for (const Sum& sum : open.sums) ground += sum.obstacle ? 0.0 : sum.points;
  if (!(drops > kRain * ground)) return;
  for (Sum& sum : open.sums)
    if (sum.points >= 4 && !sum.obstacle) leave_out_drops(section, open, sum);
}

void Collector::leave_out_drops(const Section& section, const OpenSection& open, Sum& sum) const {
  std::vector<double> heights_m;
  Sum far, rest = sum;
  const auto each = [&](const auto& what) {
    for (std::int32_t k = sum.last_stray; k >= 0;) {
      const KeptPoint& point = open.points[static_cast<std::size_t>(k)];
      what(point.fall), k = point.stray_before;
    }
  };
  each([&](const Fall& fall) { heights_m.push_back(fall.height_m), add(fall, section, far); });
  rest.take_away(far);
  // Those that were no strays lie together.
  heights_m.insert(heights_m.end(), rest.points, rest.points > 0 ? rest.height / rest.points : 0.0);
  const double middle_m = base::median(std::move(heights_m));
  far = {};
  each([&](const Fall& fall) {
    if (std::abs(fall.height_m - middle_m) > kStray_m) add(fall, section, far);
  });
  if (3 * far.points > std::max(3u, sum.points)) return;
  sum.take_away(far);
}

}  // namespace cloud
