#include "wide_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/statistics.h"

namespace road {
namespace {

using Eigen::Vector2d;

constexpr double kMuchWider = 1.6, kWideIsDoubted = 0.01;  // of the usual width; of the rows
constexpr double kOneSided =
    0.5;                         // of what is more than the usual half: a lane beside shifts by all
constexpr double kRough = 2.0;   // times the guide's usual distance from the middle
constexpr double kAbrupt = 0.8;  // of the usual half width within twice so many rows:
constexpr std::ptrdiff_t kAbruptRows = 2;

/// Whether the width changes at a row as no road does: by much within a few rows.
bool is_abrupt(const GuideRows& all, std::size_t i) {
  const auto n = static_cast<std::ptrdiff_t>(all.rows.size());
  const auto half_m = [&](std::ptrdiff_t at) {
    at = all.closed ? (at % n + n) % n : std::clamp<std::ptrdiff_t>(at, 0, n - 1);
    return all.rows[static_cast<std::size_t>(at)].half_width_m;
  };
  const auto here = static_cast<std::ptrdiff_t>(i);
  return std::abs(half_m(here + kAbruptRows) - half_m(here - kAbruptRows)) >
         kAbrupt * all.usual_half_m;
}

}  // namespace

std::optional<std::string> much_wider(const GuideRows& all) {
  std::vector<double> beside_m;
  for (const GuideRow& row : all.rows)
    if (row.is_usual) beside_m.push_back(row.middle_m);
  if (beside_m.empty()) return {};
  const double usual_m = base::median(beside_m);
  for (double& b : beside_m) b = std::abs(b - usual_m);
  const double rough_m = kRough * base::median(std::move(beside_m));  // the guide's own errors
  const std::size_t n = all.rows.size();
  const auto is_wide = [&](std::size_t i) {
    return all.rows[i].has_surface && all.rows[i].half_width_m > kMuchWider * all.usual_half_m;
  };
  const auto is_one_sided = [&](const GuideRow& row) {
    const double more_m = row.half_width_m - all.usual_half_m;
    return std::abs(row.middle_m - usual_m) > kOneSided * more_m + std::min(rough_m, 0.25 * more_m);
  };
  std::size_t wide = 0, at = 0;
  double widest_m = 0.0;
  for (std::size_t begin = 0, end = 0; begin < n; begin = end + 1) {
    for (end = begin; end < n && is_wide(end);) ++end;
    const bool is_abrupt_here =
        end > begin && (is_abrupt(all, begin) || is_abrupt(all, std::min(end, n - 1)));
    for (std::size_t i = begin; i < end; ++i) {
      if (!is_abrupt_here && !is_one_sided(all.rows[i])) continue;
      ++wide;
      if (all.rows[i].half_width_m > widest_m) widest_m = all.rows[i].half_width_m, at = i;
    }
  }
  if (static_cast<double>(wide) <= kWideIsDoubted * static_cast<double>(all.rows.size())) return {};
  const Vector2d& place = all.rows[at].at_m;
  return fmt::format(
      "along {:.0f} m of the guide what looks like road is more than {} times as wide as usual "
      "({:.1f} m), {:.1f} m at ({:.1f}, {:.1f}), on one side only or all at once: a pit lane or an "
      "apron may be taken for road there; give the road's width (--guide-width-m W), then its "
      "middle "
      "is the guide's at such places, or, if the line is right all the same, say so with "
      "--line-is-right",
      static_cast<double>(wide) * all.step_m, kMuchWider, 2.0 * all.usual_half_m, 2.0 * widest_m,
      place.x(), place.y());
}

}  // namespace road
