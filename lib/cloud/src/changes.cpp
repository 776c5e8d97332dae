#include "cloud/changes.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

#include "base/random.h"
#include "base/statistics.h"
#include "cloud/error.h"

namespace cloud {
namespace {

constexpr std::size_t kMostCells = 20'000'000, kFewestCells = 100;
constexpr std::size_t kKept = 64;    // points of one campaign in a cell
constexpr double kFinest_m = 0.25;   // cell, found
constexpr std::size_t kWanted = 12;  // points of each in half of the cells
constexpr double kObject_m = 0.3;    // a change of more is no change of the surface
constexpr double kCellSigma = 3.0, kPlaceSigma = 6.0;
constexpr double kNineOfTen =
    1.2816;  // deviations by which a sum must be larger to be seen so often
constexpr double kLeastScatter_m = 1e-3;  // of points about a plane: rounding of coordinates

using Key = std::array<std::int64_t, 2>;  ///< row (y), column (x)
struct KeyHash {
  std::size_t operator()(const Key& key) const {
    std::uint64_t mixed = 0;
    for (const std::int64_t part : key)
      mixed = (mixed ^ static_cast<std::uint64_t>(part)) * 0x9e3779b97f4a7c15u,
      mixed ^= mixed >> 32;
    return static_cast<std::size_t>(mixed);
  }
};

struct Box {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()),
                  high = -low;
  std::string text() const {
    return fmt::format("x {:.1f} to {:.1f}, y {:.1f} to {:.1f} m", low.x(), high.x(), low.y(),
                       high.y());
  }
};

/// Each point in the map frame; counts, and grows the box.
template <typename Each>
std::size_t read_all(const CloudSource& source, Box& box, const Each& each) {
  std::size_t points = 0;
  source([&](Cloud&& chunk) {
    points += chunk.size();
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      const Eigen::Vector3d p = chunk.origin_m + chunk.point(i);
      box.low = box.low.cwiseMin(p), box.high = box.high.cwiseMax(p);
      each(p);
    }
  });
  return points;
}

Key key_of(const Eigen::Vector3d& p, double cell_m) {
  return {static_cast<std::int64_t>(std::floor(p.y() / cell_m)),
          static_cast<std::int64_t>(std::floor(p.x() / cell_m))};
}

void require_room(std::size_t cells, double cell_m) {
  if (cells > kMostCells)
    throw Error(fmt::format(
        "the clouds cover more than {} million cells of {:g} m; is the unit right? If so, give a "
        "larger cell (--cell-m)",
        kMostCells / 1'000'000, cell_m));
}

/// The cell in half of which, of those with points of both, there are kWanted of each.
double cell_for(const CloudSource& before, const CloudSource& after) {
  using Counts = std::unordered_map<Key, std::array<std::uint32_t, 2>, KeyHash>;
  Counts counts;
  for (const std::size_t k : {0u, 1u}) {
    Box unused;
    read_all(k == 0 ? before : after, unused, [&](const Eigen::Vector3d& p) {
      ++counts[key_of(p, kFinest_m)][k];
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

/// What a cell keeps of its points, relative to its corner and first height.
struct Held {
  double z0_m = 0.0;
  std::array<std::vector<Eigen::Vector3f>, 2> points;
  std::array<std::uint32_t, 2> seen{};
};

using HeldCells = std::unordered_map<Key, Held, KeyHash>;

/// The first kKept points, then each of the later ones in place of any with the right chance: a
/// fair draw, the same for the same cloud.
void hold(HeldCells& cells, const Eigen::Vector3d& p, double cell_m, std::size_t which) {
  const Key key = key_of(p, cell_m);
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

/// Heights of both campaigns at the middle of a cell, with one slope.
struct Fit {
  bool done = false;
  double old_m = 0.0, change_m = 0.0, stddev_m = 0.0;
  double points = 0.0;  ///< that count: twice the harmonic mean of both campaigns'
};

/// From that share of the heights on.
Fit fit_from(const Held& cell, double share) {
  constexpr std::size_t kFewest = 4;
  Fit fit;
  if (std::min(cell.points[0].size(), cell.points[1].size()) < kFewest) return fit;
  struct Point {
    double x, y, z;
    std::size_t which;
  };
  std::vector<Point> all;
  Eigen::Vector4d plane = Eigen::Vector4d::Zero();  // old, new, slopes along x and y
  for (const std::size_t k : {0u, 1u}) {
    std::vector<double> heights;
    for (const Eigen::Vector3f& p : cell.points[k]) {
      all.push_back(
          {static_cast<double>(p.x()), static_cast<double>(p.y()), static_cast<double>(p.z()), k});
      heights.push_back(static_cast<double>(p.z()));
    }
    plane[static_cast<Eigen::Index>(k)] = base::quantile(heights, share);
  }
  const auto residual = [&](const Point& p) {
    return p.z - plane[static_cast<Eigen::Index>(p.which)] - plane[2] * p.x - plane[3] * p.y;
  };
  for (int round = 0; round < 10; ++round) {
    // Scatter of those near each surface: something high in the cell must not widen the gate.
    std::array<double, 2> scatter{};
    for (const std::size_t k : {0u, 1u}) {
      std::vector<double> off;
      for (const Point& p : all)
        if (p.which == k) off.push_back(std::abs(residual(p)));
      // Of the nearer two thirds: a third may be of something else.
      scatter[k] = std::max(kLeastScatter_m, base::quantile(off, 0.45) / 0.6);
    }
    Eigen::Matrix4d h = Eigen::Matrix4d::Zero();
    Eigen::Vector4d b = Eigen::Vector4d::Zero();
    std::array<double, 2> square{}, weight{};
    for (const Point& p : all) {
      const double r = residual(p), t = r / (4.7 * scatter[p.which]);
      if (std::abs(t) < 1.0) {
        const double w = (1.0 - t * t) * (1.0 - t * t);
        square[p.which] += w * r * r, weight[p.which] += w;
      }
    }
    if (std::min(weight[0], weight[1]) < 0.5 * static_cast<double>(kFewest)) return fit;
    // What lies on the surface scatters by this: the weights took a tenth away, the plane two
    // points.
    std::array<double, 2> variance{};
    for (const std::size_t k : {0u, 1u})
      variance[k] = std::max(kLeastScatter_m * kLeastScatter_m,
                             1.1 * square[k] / std::max(1.0, weight[k] - 2.0));
    for (const Point& p : all) {
      const double r = residual(p), t = r / (4.7 * scatter[p.which]);
      if (std::abs(t) >= 1.0) continue;
      const Eigen::Vector4d row(p.which == 0 ? 1.0 : 0.0, p.which == 1 ? 1.0 : 0.0, p.x, p.y);
      const double precision = (1.0 - t * t) * (1.0 - t * t) / variance[p.which];
      h += precision * row * row.transpose();
      b += precision * r * row;
    }
    // A slope of more than 1 or so is a wall: held loosely.
    h(2, 2) += 1.0, h(3, 3) += 1.0;
    b[2] -= plane[2], b[3] -= plane[3];
    const Eigen::LDLT<Eigen::Matrix4d> solver(h);
    const Eigen::Vector4d step = solver.solve(b);
    plane += step;
    if (round == 9 || step.cwiseAbs().maxCoeff() < 1e-6) {
      const Eigen::Vector4d difference(-1.0, 1.0, 0.0, 0.0);
      fit.stddev_m = std::sqrt(std::max(0.0, difference.dot(solver.solve(difference))));
      fit.points = 2.0 / (1.0 / weight[0] + 1.0 / weight[1]);
      // The weights choose what agrees; where much does not, as in grass, it agrees by choice.
      double spread = 1.0;
      for (const std::size_t k : {0u, 1u}) {
        std::vector<double> off;
        for (const Point& p : all)
          if (p.which == k) off.push_back(std::abs(residual(p)));
        spread = std::max(spread, base::quantile(off, 0.6) / 0.842 / std::sqrt(variance[k]));
      }
      fit.stddev_m *= spread;
      break;
    }
  }
  fit.old_m = cell.z0_m + plane[0], fit.change_m = plane[1] - plane[0];
  fit.done = std::isfinite(fit.change_m) && fit.stddev_m > 0.0;
  return fit;
}

/// From low and from the middle: where these differ, as on cars and grass, the cell says little.
Fit fit_cell(const Held& cell) {
  Fit fit = fit_from(cell, 0.25);
  if (!fit.done) return fit;
  for (const double share : {0.4, 0.55}) {
    const Fit other = fit_from(cell, share);
    fit.done &= other.done;
    fit.stddev_m = std::hypot(fit.stddev_m, other.change_m - fit.change_m);
  }
  return fit;
}

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

/// A dozen points may scatter little by chance: no cell's points count as better than half of those
/// around do. Cells that scatter ten times as much show no surface (cars that passed): they go.
void share_scatter(std::vector<ChangeCell>& cells, const std::vector<double>& points, double cell_m,
                   std::size_t& unclear) {
  constexpr double kNoSurface = 10.0;
  const double block_m = 32.0 * cell_m;
  std::unordered_map<Key, std::vector<double>, KeyHash> scatter;
  const auto block_of = [&](std::size_t k) {
    return key_of({cells[k].x_m, cells[k].y_m, 0.0}, block_m);
  };
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

/// Takes out of the cells what is even over options.level_m; scales their deviations.
void take_level_out(std::vector<ChangeCell>& cells, double level_m, ChangeResult& result) {
  constexpr std::size_t kFewest = 50;
  const double block_m = level_m > 0.0 ? level_m / 3.0 : 10.0;
  using Blocks = std::unordered_map<Key, std::vector<std::size_t>, KeyHash>;
  Blocks blocks;
  for (std::size_t k = 0; k < cells.size(); ++k)
    blocks[key_of({cells[k].x_m, cells[k].y_m, 0.0}, block_m)].push_back(k);
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
    const Key home = key_of({cell.x_m, cell.y_m, 0.0}, block_m);
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

/// Neighbouring cells that changed the same way.
std::vector<ChangePlace> places_of(const std::vector<ChangeCell>& cells, double cell_m,
                                   double min_change_m) {
  std::unordered_map<Key, std::size_t, KeyHash> changed;
  for (std::size_t k = 0; k < cells.size(); ++k)
    if (std::abs(cells[k].change_m) >= std::max(0.3 * min_change_m, kCellSigma * cells[k].stddev_m))
      changed.emplace(key_of({cells[k].x_m, cells[k].y_m, 0.0}, cell_m), k);
  std::vector<std::pair<double, ChangePlace>> found;
  std::vector<std::uint8_t> taken(cells.size(), 0);
  for (std::size_t first = 0; first < cells.size(); ++first) {
    const auto key = [&](std::size_t k) {
      return key_of({cells[k].x_m, cells[k].y_m, 0.0}, cell_m);
    };
    if (taken[first] || !changed.contains(key(first))) continue;
    std::vector<std::size_t> group{first};
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
    ChangePlace place;
    double weights = 0.0, sigmas = 0.0, pull = 0.0;
    for (const std::size_t k : group) {
      const ChangeCell& cell = cells[k];
      const double w = 1.0 / (cell.stddev_m * cell.stddev_m), size = std::abs(cell.change_m);
      place.change_m += w * cell.change_m, weights += w;
      sigmas += size / cell.stddev_m;
      place.x_m += size * cell.x_m, place.y_m += size * cell.y_m, place.z_m += size * cell.z_m;
      pull += size;
      if (size > std::abs(place.peak_change_m))
        place.peak_change_m = cell.change_m, place.peak_stddev_m = cell.stddev_m;
    }
    const auto n = static_cast<double>(group.size());
    place.change_m /= weights, place.stddev_m = 1.0 / std::sqrt(weights);
    place.x_m /= pull, place.y_m /= pull, place.z_m /= pull;
    place.area_m2 = n * cell_m * cell_m;
    place.object = std::abs(place.peak_change_m) > kObject_m;
    const double together = sigmas / std::sqrt(n);
    if (group.size() < 2 || together < kPlaceSigma || std::abs(place.peak_change_m) < min_change_m)
      continue;
    found.emplace_back(together, place);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<ChangePlace> places;
  for (const auto& [together, place] : found) places.push_back(place);
  return places;
}

}  // namespace

ChangeResult find_changes(const CloudSource& before, const CloudSource& after,
                          const ChangeOptions& options) {
  ChangeResult result;
  const auto stage = [&](const char* name, double share) {
    if (options.progress) options.progress(name, share);
  };
  stage("look at the points", 0.0);
  result.cell_m = options.cell_m > 0.0 ? options.cell_m : cell_for(before, after);
  stage("read", 0.3);
  HeldCells held;
  Box old_box, new_box;
  result.old_points =
      read_all(before, old_box, [&](const Eigen::Vector3d& p) { hold(held, p, result.cell_m, 0); });
  stage("read", 0.5);
  result.new_points =
      read_all(after, new_box, [&](const Eigen::Vector3d& p) { hold(held, p, result.cell_m, 1); });
  stage("heights", 0.7);
  std::vector<Key> keys;
  for (const auto& [key, cell] : held) keys.push_back(key);
  std::sort(keys.begin(), keys.end());
  std::vector<double> points;
  for (const Key& key : keys) {
    const Held& cell = held.at(key);
    const Fit fit = fit_cell(cell);
    if (!fit.done) {
      result.old_alone += cell.points[0].size() > cell.points[1].size() ? 1 : 0;
      result.new_alone += cell.points[0].size() < cell.points[1].size() ? 1 : 0;
      continue;
    }
    ChangeCell& out = result.cells.emplace_back();
    out.x_m = (static_cast<double>(key[1]) + 0.5) * result.cell_m;
    out.y_m = (static_cast<double>(key[0]) + 0.5) * result.cell_m;
    points.push_back(fit.points);
    out.z_m = fit.old_m, out.change_m = fit.change_m, out.stddev_m = fit.stddev_m;
  }
  if (result.cells.size() < kFewestCells)
    throw Error(fmt::format(
        "{} cells of {:g} m in common, {} wanted: old {}, new {}; is one of them in another frame "
        "or "
        "unit, or still in the sensor's frame?",
        result.cells.size(), result.cell_m, kFewestCells, old_box.text(), new_box.text()));
  stage("changes", 0.9);
  share_scatter(result.cells, points, result.cell_m, result.unclear);
  take_level_out(result.cells, options.level_m, result);
  result.places = places_of(result.cells, result.cell_m, options.min_change_m);
  std::vector<double> told;
  for (const ChangeCell& cell : result.cells)
    told.push_back(std::max(options.min_change_m,
                            (kPlaceSigma + kNineOfTen) / std::sqrt(2.0) * cell.stddev_m));
  result.smallest_told_m = base::median_or(0.0, told);
  if (result.smallest_told_m > 1.5 * options.min_change_m)
    result.remarks.push_back(fmt::format(
        "in half of the cells a place of two must change by {:.0f} mm or more to be told: the "
        "points "
        "are too few or scatter too much for {:.0f} mm; larger cells (--cell-m) tell less, wider",
        1e3 * result.smallest_told_m, 1e3 * options.min_change_m));
  const double range = result.level_high_m - result.level_low_m;
  if (options.level_m > 0.0 && range > options.min_change_m)
    result.remarks.push_back(
        fmt::format("the campaigns differ slowly by {:.0f} to {:.0f} mm, which was taken out: "
                    "drift, or a change "
                    "wider than {:g} m (--level-m 0 keeps it)",
                    1e3 * result.level_low_m, 1e3 * result.level_high_m, 0.5 * options.level_m));
  return result;
}

}  // namespace cloud
