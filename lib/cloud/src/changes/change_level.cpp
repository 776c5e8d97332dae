#include "change_level.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "base/statistics.h"
#include "change_cells.h"

namespace cloud {
namespace {

/// Differences that are even over a width, and how much cells scatter about that.
struct Level {
  double base = 0.0, along_x = 0.0, along_y = 0.0, factor = 1.0;
};

/// A tilted plane through the changes of some cells, as (x, y, change, deviation) relative to a
/// middle; cells that changed lose their weight.
Level level_of(const std::vector<Eigen::Vector4d>& cells, bool tilted) {
  constexpr double kTilt = 3e-3;  // roll drifts by 2 mrad over 100 m
  Level level;
  std::vector<double> values;
  for (const Eigen::Vector4d& c : cells) values.push_back(c[2]);
  level.base = base::median_or(0.0, values);
  for (int round = 0; round < 10; ++round) {
    std::vector<double> off;
    for (const Eigen::Vector4d& c : cells)
      off.push_back(std::abs(c[2] - level.base - level.along_x * c[0] - level.along_y * c[1]) /
                    c[3]);
    level.factor = std::max(1.0, base::median_or(0.0, off) / 0.6745);
    if (!tilted) break;
    Eigen::Matrix3d h = Eigen::Vector3d(0.0, 1.0, 1.0).asDiagonal();
    h *= 1.0 / (kTilt * kTilt);
    Eigen::Vector3d b(0.0, -level.along_x / (kTilt * kTilt), -level.along_y / (kTilt * kTilt));
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const Eigen::Vector4d& c = cells[k];
      const double t = off[k] / (4.7 * level.factor);
      if (t >= 1.0) continue;
      const double deviation = c[3] * level.factor,
                   w = (1.0 - t * t) * (1.0 - t * t) / (deviation * deviation);
      const Eigen::Vector3d row(1.0, c[0], c[1]);
      h += w * row * row.transpose();
      b += w * (c[2] - level.base - level.along_x * c[0] - level.along_y * c[1]) * row;
    }
    const Eigen::Vector3d step = h.ldlt().solve(b);
    level.base += step[0], level.along_x += step[1], level.along_y += step[2];
    if (std::abs(step[0]) < 1e-6) break;
  }
  return level;
}

}  // namespace

void share_scatter(std::vector<ChangeCell>& cells, const std::vector<double>& points, double cell_m,
                   std::size_t& unclear) {
  constexpr double kNoSurface = 10.0;
  const double block_m = 32.0 * cell_m;
  std::unordered_map<Key, std::vector<double>, KeyHash> scatter;
  const auto block_of = [&](std::size_t k) { return key_of(cells[k].x_m, cells[k].y_m, block_m); };
  for (std::size_t k = 0; k < cells.size(); ++k)
    scatter[block_of(k)].push_back(cells[k].stddev_m * std::sqrt(points[k]));
  std::unordered_map<Key, double, KeyHash> typical;
  for (const auto& [key, values] : scatter) typical[key] = base::median_or(0.0, values);
  std::vector<ChangeCell> clear;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const double least = typical.at(block_of(k)) / std::sqrt(points[k]);
    if (cells[k].stddev_m > kNoSurface * least) {
      ++unclear;
      continue;
    }
    clear.push_back(cells[k]);
    clear.back().stddev_m = std::max(cells[k].stddev_m, least);
  }
  cells = std::move(clear);
}

void take_level_out(std::vector<ChangeCell>& cells, double level_m, ChangeResult& result) {
  constexpr std::size_t kFewest = 50;
  const double block_m = level_m > 0.0 ? level_m / 3.0 : 10.0;
  using Blocks = std::unordered_map<Key, std::vector<std::size_t>, KeyHash>;
  Blocks blocks;
  for (std::size_t k = 0; k < cells.size(); ++k)
    blocks[key_of(cells[k].x_m, cells[k].y_m, block_m)].push_back(k);
  const auto values = [&](const std::vector<std::size_t>& numbers, double x, double y) {
    std::vector<Eigen::Vector4d> out;
    for (const std::size_t k : numbers)
      out.emplace_back(cells[k].x_m - x, cells[k].y_m - y, cells[k].change_m, cells[k].stddev_m);
    return out;
  };
  std::vector<std::size_t> every(cells.size());
  for (std::size_t k = 0; k < every.size(); ++k) every[k] = k;
  const Level whole = level_of(values(every, 0.0, 0.0), false);
  std::unordered_map<Key, Level, KeyHash> levels;
  std::vector<double> factors;
  for (const auto& [key, unused] : blocks) {
    std::vector<std::size_t> numbers;
    for (std::int64_t i = key[0] - 1; i <= key[0] + 1; ++i)
      for (std::int64_t j = key[1] - 1; j <= key[1] + 1; ++j)
        if (const auto found = blocks.find({i, j}); found != blocks.end())
          numbers.insert(numbers.end(), found->second.begin(), found->second.end());
    std::sort(numbers.begin(), numbers.end());
    Level level = whole;
    if (numbers.size() >= kFewest)
      level = level_of(values(numbers, (static_cast<double>(key[1]) + 0.5) * block_m,
                              (static_cast<double>(key[0]) + 0.5) * block_m),
                       level_m > 0.0);
    levels[key] = level;
  }
  std::vector<double> taken;
  for (ChangeCell& cell : cells) {
    const Key home = key_of(cell.x_m, cell.y_m, block_m);
    factors.push_back(levels.at(home).factor);
    cell.stddev_m *= factors.back();
    if (!(level_m > 0.0)) continue;
    // Between the middles of the four blocks around.
    const double a = cell.y_m / block_m - 0.5, b = cell.x_m / block_m - 0.5;
    const auto i = static_cast<std::int64_t>(std::floor(a)),
               j = static_cast<std::int64_t>(std::floor(b));
    double sum = 0.0, weights = 0.0;
    for (const Key& key : {Key{i, j}, Key{i, j + 1}, Key{i + 1, j}, Key{i + 1, j + 1}}) {
      const auto found = levels.find(key);
      if (found == levels.end()) continue;
      const double w = (1.0 - std::abs(a - static_cast<double>(key[0]))) *
                           (1.0 - std::abs(b - static_cast<double>(key[1]))) +
                       1e-9;
      const Level& level = found->second;
      sum += w * (level.base +
                  level.along_x * (cell.x_m - (static_cast<double>(key[1]) + 0.5) * block_m) +
                  level.along_y * (cell.y_m - (static_cast<double>(key[0]) + 0.5) * block_m));
      weights += w;
    }
    cell.level_m = sum / weights;
    cell.change_m -= cell.level_m;
    taken.push_back(cell.level_m);
  }
  result.stddev_factor = base::median_or(0.0, factors);
  if (taken.empty()) return;
  result.level_median_m = base::median_or(0.0, taken);
  result.level_low_m = base::quantile(taken, 0.01),
  result.level_high_m = base::quantile(taken, 0.99);
}

}  // namespace cloud
