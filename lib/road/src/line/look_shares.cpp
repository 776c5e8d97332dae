#include "look_shares.h"

#include <algorithm>
#include <cstddef>

#include "guide_curve.h"
#include "stations.h"

namespace road {

LookShares look_shares(const Guide& guide, const RaySurface& surface,
                       const std::vector<std::uint32_t>& look_of_triangle, std::size_t looks) {
  const GuideRows all = empty_rows(guide);
  const std::vector<double> none(looks, 0.0);
  LookShares shares{none, none, none, none, {}};
  std::vector<double> rows_with(looks, 0.0), inside(looks, 0.0), outside(looks, 0.0);
  const auto looks_at = [&](const GuideRow& row, double offset) {
    const Eigen::Vector2d p = row.at_m + offset * all.reach_m * left_of(row.heading);
    std::vector<LookShares::Seen> seen;
    for (const SurfaceHit& hit : surface.all_hits(p.x(), p.y()))
      seen.push_back({look_of_triangle[hit.triangle], hit.z_m});
    return seen;
  };
  const auto count = [](const std::vector<LookShares::Seen>& seen, std::vector<double>& into) {
    for (std::size_t i = 0; i < seen.size(); ++i)
      if (std::none_of(seen.begin(), seen.begin() + static_cast<std::ptrdiff_t>(i),
                       [&](const LookShares::Seen& s) { return s.look == seen[i].look; }))
        into[seen[i].look] += 1.0;
  };
  for (const GuideRow& row : all.rows) {
    inside = outside = none;
    for (int k = -2; k <= 2; ++k) {
      shares.places.push_back(looks_at(row, 0.035 * k));
      count(shares.places.back(), inside);
    }
    for (int k = 0; k < 5; ++k)
      for (const double sign : {-1.0, 1.0}) count(looks_at(row, sign * (0.5 + 0.125 * k)), outside);
    for (std::size_t look = 0; look < looks; ++look) {
      shares.inside[look] += inside[look];
      shares.outside[look] += outside[look];
      if (inside[look] == 0.0) continue;
      rows_with[look] += 1.0;
      shares.outside_there[look] += outside[look];
    }
  }
  const auto rows = static_cast<double>(all.rows.size());
  for (std::size_t look = 0; look < looks; ++look) {
    shares.outside_there[look] /= 10.0 * std::max(1.0, rows_with[look]);
    shares.inside_there[look] = shares.inside[look] / (5.0 * std::max(1.0, rows_with[look]));
    shares.inside[look] /= 5.0 * rows;
    shares.outside[look] /= 10.0 * rows;
  }
  return shares;
}

}  // namespace road
