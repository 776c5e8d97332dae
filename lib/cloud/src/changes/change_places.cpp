#include "change_places.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "base/statistics.h"
#include "change_cells.h"

namespace cloud {
namespace {

constexpr double kObject_m = 0.3;  // a change of more is no change of the surface
constexpr double kCellSigma = 3.0, kPlaceSigma = 6.0;
constexpr double kNineOfTen =
    1.2816;  // deviations by which a sum must be larger to be seen so often

/// Numbers of cells.
using Group = std::vector<std::size_t>;

/// Neighbouring cells that changed by more than chance, all up or all down.
std::vector<Group> groups_of(const std::vector<ChangeCell>& cells, double cell_m,
                             double min_change_m) {
  const auto key = [&](std::size_t k) { return key_of(cells[k].x_m, cells[k].y_m, cell_m); };
  std::unordered_map<Key, std::size_t, KeyHash> changed;
  for (std::size_t k = 0; k < cells.size(); ++k)
    if (std::abs(cells[k].change_m) >= std::max(0.3 * min_change_m, kCellSigma * cells[k].stddev_m))
      changed.emplace(key(k), k);
  std::vector<Group> groups;
  std::vector<std::uint8_t> taken(cells.size(), 0);
  for (std::size_t first = 0; first < cells.size(); ++first) {
    if (taken[first] || !changed.contains(key(first))) continue;
    Group group{first};
    taken[first] = 1;
    for (std::size_t at = 0; at < group.size(); ++at) {
      const Key here = key(group[at]);
      for (std::int64_t i = here[0] - 1; i <= here[0] + 1; ++i)
        for (std::int64_t j = here[1] - 1; j <= here[1] + 1; ++j) {
          const auto next = changed.find({i, j});
          if (next == changed.end() || taken[next->second] ||
              (cells[next->second].change_m > 0.0) != (cells[first].change_m > 0.0))
            continue;
          taken[next->second] = 1;
          group.push_back(next->second);
        }
    }
    groups.push_back(std::move(group));
  }
  return groups;
}

ChangePlace place_of(const Group& group, const std::vector<ChangeCell>& cells, double cell_m) {
  ChangePlace place;
  double weights = 0.0, pull = 0.0;
  for (const std::size_t k : group) {
    const ChangeCell& cell = cells[k];
    const double w = 1.0 / (cell.stddev_m * cell.stddev_m), size = std::abs(cell.change_m);
    place.change_m += w * cell.change_m, weights += w;
    place.x_m += size * cell.x_m, place.y_m += size * cell.y_m, place.z_m += size * cell.z_m;
    pull += size;
    if (size > std::abs(place.peak_change_m))
      place.peak_change_m = cell.change_m, place.peak_stddev_m = cell.stddev_m;
  }
  place.change_m /= weights, place.stddev_m = 1.0 / std::sqrt(weights);
  place.x_m /= pull, place.y_m /= pull, place.z_m /= pull;
  place.area_m2 = static_cast<double>(group.size()) * cell_m * cell_m;
  place.object = std::abs(place.peak_change_m) > kObject_m;
  return place;
}

/// In how many deviations the cells of a group changed, all together.
double certainty_of(const Group& group, const std::vector<ChangeCell>& cells) {
  double sigmas = 0.0;
  for (const std::size_t k : group) sigmas += std::abs(cells[k].change_m) / cells[k].stddev_m;
  return sigmas / std::sqrt(static_cast<double>(group.size()));
}

}  // namespace

std::vector<ChangePlace> places_of(const std::vector<ChangeCell>& cells, double cell_m,
                                   double min_change_m) {
  std::vector<std::pair<double, ChangePlace>> found;
  for (const Group& group : groups_of(cells, cell_m, min_change_m)) {
    const double certainty = certainty_of(group, cells);
    const ChangePlace place = place_of(group, cells, cell_m);
    if (group.size() < 2 || certainty < kPlaceSigma || std::abs(place.peak_change_m) < min_change_m)
      continue;
    found.emplace_back(certainty, place);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<ChangePlace> places;
  for (const auto& [certainty, place] : found) places.push_back(place);
  return places;
}

double smallest_told_m(const std::vector<ChangeCell>& cells, double min_change_m) {
  std::vector<double> told;
  for (const ChangeCell& cell : cells)
    told.push_back(
        std::max(min_change_m, (kPlaceSigma + kNineOfTen) / std::sqrt(2.0) * cell.stddev_m));
  return base::median_or(0.0, told);
}

}  // namespace cloud
