#include "change_cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "base/statistics.h"
#include "cloud/error.h"

namespace cloud {
namespace {

constexpr std::size_t kMostCells = 20'000'000;
constexpr std::size_t kKept = 64;    // points of one campaign in a cell
constexpr double kFinest_m = 0.25;   // cell, found
constexpr std::size_t kWanted = 12;  // points of each in half of the cells

void require_room(std::size_t cells, double cell_m) {
  if (cells > kMostCells)
    throw Error(fmt::format(
        "the clouds cover more than {} million cells of {:g} m; is the unit right? If so, give a "
        "larger cell (--cell-m)",
        kMostCells / 1'000'000, cell_m));
}

}  // namespace

Key key_of(double x_m, double y_m, double cell_m) {
  return {static_cast<std::int64_t>(std::floor(y_m / cell_m)),
          static_cast<std::int64_t>(std::floor(x_m / cell_m))};
}

std::string Box::text() const {
  return fmt::format("x {:.1f} to {:.1f}, y {:.1f} to {:.1f} m", low.x(), high.x(), low.y(),
                     high.y());
}

double cell_for(const CloudSource& before, const CloudSource& after) {
  using Counts = std::unordered_map<Key, std::array<std::uint32_t, 2>, KeyHash>;
  Counts counts;
  for (const std::size_t k : {0u, 1u}) {
    Box unused;
    read_all(k == 0 ? before : after, unused, [&](const Eigen::Vector3d& p) {
      ++counts[key_of(p.x(), p.y(), kFinest_m)][k];
      require_room(counts.size(), kFinest_m);
    });
  }
  double cell_m = kFinest_m;
  for (;; cell_m *= 2.0) {
    std::vector<double> fewer;
    for (const auto& [key, count] : counts)
      if (count[0] > 0 && count[1] > 0) fewer.push_back(std::min(count[0], count[1]));
    if (cell_m >= 16.0 || (!fewer.empty() && base::median(fewer) >= static_cast<double>(kWanted)))
      return cell_m;
    Counts coarser;
    for (const auto& [key, count] : counts)
      for (const std::size_t k : {0u, 1u}) coarser[{key[0] >> 1, key[1] >> 1}][k] += count[k];
    counts = std::move(coarser);
  }
}

void hold(HeldCells& cells, const Eigen::Vector3d& p, double cell_m, std::size_t which) {
  const Key key = key_of(p.x(), p.y(), cell_m);
  const auto [found, is_new] = cells.try_emplace(key);
  Held& cell = found->second;
  if (is_new) {
    require_room(cells.size(), cell_m);
    cell.z0_m = p.z();
  }
  const Eigen::Vector3f local(
      static_cast<float>(p.x() - (static_cast<double>(key[1]) + 0.5) * cell_m),
      static_cast<float>(p.y() - (static_cast<double>(key[0]) + 0.5) * cell_m),
      static_cast<float>(p.z() - cell.z0_m));
  std::vector<Eigen::Vector3f>& points = cell.points[which];
  const std::uint32_t number = cell.seen[which]++;
  if (points.size() < kKept) {
    points.push_back(local);
    return;
  }
  base::Random random(KeyHash()(key) + number);
  const auto at = static_cast<std::size_t>(random.uniform() * static_cast<double>(number + 1));
  if (at < kKept) points[at] = local;
}

}  // namespace cloud
