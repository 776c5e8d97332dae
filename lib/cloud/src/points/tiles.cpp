#include "cloud/tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "base/statistics.h"
#include "base/write_file.h"
#include "cloud/error.h"
#include "point_runs.h"

namespace cloud {
namespace {

/// A level's spacing is the side of its cells over 2^7.
constexpr int kSpacingLevels = 7, kDeepest = kCurveLevels - kSpacingLevels;
/// A cell with no more points is one tile; a tile of fewer is part of that around it; one of more
/// is written as several.
constexpr std::size_t kLeaf = 20'000, kFew = 2'000, kMostOfTile = 65'536;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

using TilePoints = std::vector<TilePoint>;

void append(TilePoints& to, TilePoints&& from) {
  if (to.empty())
    to = std::move(from);
  else
    to.insert(to.end(), from.begin(), from.end());
  from = {};
}

/// Every so many-th value, so many that they stay below a bound.
class Sample {
 public:
  void add(double value) {
    if (seen_++ % stride_ != 0 || !std::isfinite(value)) return;
    values_.push_back(value);
    if (values_.size() < kMost) return;
    for (std::size_t k = 0; 2 * k < values_.size(); ++k) values_[k] = values_[2 * k];
    values_.resize(kMost / 2);
    stride_ *= 2;
  }
  MostValues most() {
    if (values_.empty()) return {};
    std::sort(values_.begin(), values_.end());
    const std::size_t last = values_.size() - 1, hundredth = values_.size() / 100;
    return {values_[hundredth], values_[last - hundredth]};
  }

 private:
  static constexpr std::size_t kMost = 1u << 17;
  std::vector<double> values_;
  std::uint64_t seen_ = 0, stride_ = 1;
};

double median(const TilePoints& points, double TilePoint::*axis) {
  std::vector<double> values(points.size());
  std::transform(points.begin(), points.end(), values.begin(),
                 [&](const TilePoint& p) { return p.*axis; });
  return base::median(std::move(values));
}

class Tiler {
 public:
  Tiler(const std::string& path, TileSet& set) : file_(path), set_(set) {}

  /// By place.
  void add(const TilePoint& point, const CurvePlace& place) {
    note(point);
    if (!before_) {  // the first: where the second tells what it is first of
      before_ = first_place_ = place, first_ = point;
      return;
    }
    const int common = levels_in_common(place, *before_);
    if (first_) put(*first_, common), first_.reset();
    for (int depth = kDeepest; depth > common; --depth) close(depth);
    put(point, common);
    before_ = place;
  }

  void finish() {
    if (first_) put(*first_, kCurveLevels);
    for (int depth = kDeepest; depth > 0; --depth) close(depth);
    Node& root = at(0);
    int depth = 0;
    if (root.split) {
      split(0);
      if (root.own.size() < kFew) depth = coarsest();
    } else {  // one tile: of the smallest cell that holds all
      depth = std::min(levels_in_common(first_place_, *before_), kDeepest);
      for (TilePoints& small : root.small) append(root.own, std::move(small));
    }
    write(root.own, depth);
    file_.commit();
    set_.bytes = bytes_;
    const int least = coarsest();
    for (Tile& tile : set_.tiles) tile.level -= least;
    set_.spacing_m = std::ldexp(kRootCell_m, -least - kSpacingLevels);
    for (std::size_t k = 0; k < 3; ++k) set_.most_m[k] = samples_[k].most();
    set_.most_intensity = samples_[3].most();
    set_.most_sigma_m = samples_[4].most();
  }

 private:
  /// The cell of its depth that the points are in now.
  struct Node {
    TilePoints own;                 ///< of its level
    std::vector<TilePoints> small;  ///< cells in it that are one tile each, if it has to be split
    std::size_t held = 0;           ///< points of both
    bool split = false;             ///< it has more than one tile
  };

  Node& at(int depth) { return nodes_[static_cast<std::size_t>(depth)]; }

  /// To the coarsest level in a cell of whose spacing it is the first.
  void put(const TilePoint& point, int common) {
    const int depth = std::clamp(common + 1 - kSpacingLevels, 0, kDeepest);
    Node& node = at(depth);
    node.own.push_back(point);
    ++node.held;
    if (node.held > kLeaf && !node.split) split(depth);
    if (node.own.size() >= kMostOfTile) write(node.own, depth);
  }

  void split(int depth) {
    Node& node = at(depth);
    node.split = true;
    for (TilePoints& small : node.small) {
      if (small.size() < kFew)
        append(node.own, std::move(small));
      else
        write(small, depth + 1);
    }
    node.small.clear();
    if (node.own.size() >= kMostOfTile) write(node.own, depth);
  }

  int coarsest() const {
    int least = kDeepest;
    for (const Tile& tile : set_.tiles) least = std::min(least, tile.level);
    return least;
  }

  /// The points leave this cell; what it holds goes to a tile or to the cell around it.
  void close(int depth) {
    Node &node = at(depth), &around = at(depth - 1);
    if (node.split) {
      split(depth);
      if (node.own.size() < kFew)
        append(around.own, std::move(node.own));
      else
        write(node.own, depth);
      split(depth - 1);
    } else if (node.held > 0) {
      TilePoints all = std::move(node.own);
      for (TilePoints& small : node.small) append(all, std::move(small));
      around.held += all.size();
      around.small.push_back(std::move(all));
      if (around.split || around.held > kLeaf) split(depth - 1);
    }
    node = {};
  }

  void note(const TilePoint& p) {
    const double values[] = {p.x_m, p.y_m, p.z_m, p.intensity, p.sigma_m};
    for (std::size_t k = 0; k < 5; ++k) samples_[k].add(values[k]);
  }

  /// The points as one tile, or several of kMostOfTile at most; they are gone then.
  void write(TilePoints& points, int depth) {
    for (std::size_t begin = 0; begin < points.size(); begin += kMostOfTile) {
      const std::size_t end = std::min(points.size(), begin + kMostOfTile);
      write_one(TilePoints(points.begin() + static_cast<std::ptrdiff_t>(begin),
                           points.begin() + static_cast<std::ptrdiff_t>(end)),
                depth);
    }
    points = {};
  }

  void write_one(const TilePoints& points, int depth) {
    Tile tile;
    tile.level = depth, tile.begin = bytes_,
    tile.points = static_cast<std::uint32_t>(points.size());
    // Where most points are: float32 is fine there, however far a stray one may be.
    tile.origin_m = {std::round(median(points, &TilePoint::x_m)),
                     std::round(median(points, &TilePoint::y_m)),
                     std::round(median(points, &TilePoint::z_m))};
    tile.min_m = tile.max_m = {points[0].x_m, points[0].y_m, points[0].z_m};
    std::string bytes;
    bytes.reserve(bytes_of_tile(set_, points.size()));
    const auto put = [&](auto value) {
      char raw[sizeof value];
      std::memcpy(raw, &value, sizeof value);
      bytes.append(raw, sizeof value);
    };
    if (set_.has_time)
      for (const TilePoint& p : points) put(p.time_s);
    for (const TilePoint& p : points) {
      const Eigen::Vector3d place(p.x_m, p.y_m, p.z_m);
      tile.min_m = tile.min_m.cwiseMin(place), tile.max_m = tile.max_m.cwiseMax(place);
      for (int k = 0; k < 3; ++k) put(static_cast<float>(place[k] - tile.origin_m[k]));
    }
    if (set_.has_intensity)
      for (const TilePoint& p : points) put(p.intensity);
    if (set_.has_sigma)
      for (const TilePoint& p : points) put(p.sigma_m);
    for (const TilePoint& p : points) put(p.pass);
    if (set_.has_class)
      for (const TilePoint& p : points) put(p.classification);
    bytes.resize(bytes_of_tile(set_, points.size()), '\0');
    file_.append(bytes);
    bytes_ += bytes.size();
    set_.tiles.push_back(tile);
  }

  base::FileWriter file_;
  TileSet& set_;
  std::uint64_t bytes_ = 0;
  std::vector<Node> nodes_ = std::vector<Node>(kDeepest + 1);  ///< by depth
  std::array<Sample, 5> samples_;
  std::optional<CurvePlace> before_;
  CurvePlace first_place_;
  std::optional<TilePoint> first_;
};

/// Notes what the set is to say of a chunk, and hands on its points.
void take(const Cloud& chunk, std::uint16_t pass, PointRuns& runs, TileSet& set) {
  if (chunk.size() == 0) return;
  if (runs.points() == 0) {
    set.min_m.setConstant(std::numeric_limits<double>::infinity());
    set.max_m = -set.min_m;
    set.time_begin_s = set.min_m.x(), set.time_end_s = -set.min_m.x();
  }
  set.has_time |= !chunk.time_s.empty(), set.has_intensity |= !chunk.intensity.empty();
  set.has_class |= !chunk.classification.empty(), set.has_sigma |= !chunk.sigma_m.empty();
  set.points_of_pass[pass] += chunk.size();
  for (std::size_t i = 0; i < chunk.size(); ++i) {
    const Eigen::Vector3d p = chunk.origin_m + chunk.point(i);
    TilePoint point{
        p.x(), p.y(), p.z(), kNaN, static_cast<float>(kNaN), pass, 0, static_cast<float>(kNaN)};
    if (!chunk.time_s.empty()) {
      point.time_s = chunk.time_s[i];
      if (std::isfinite(point.time_s)) {
        set.time_begin_s = std::min(set.time_begin_s, point.time_s);
        set.time_end_s = std::max(set.time_end_s, point.time_s);
      }
    }
    if (!chunk.intensity.empty()) point.intensity = chunk.intensity[i];
    if (!chunk.classification.empty()) point.classification = chunk.classification[i];
    if (!chunk.sigma_m.empty()) point.sigma_m = chunk.sigma_m[i];
    ++set.points_of_class[point.classification];
    set.min_m = set.min_m.cwiseMin(p), set.max_m = set.max_m.cwiseMax(p);
    runs.add(point);
  }
}

}  // namespace

std::uint64_t bytes_of_tile(const TileSet& set, std::uint64_t points) {
  const std::uint64_t of_point = (set.has_time ? 8u : 0u) + 12u + (set.has_intensity ? 4u : 0u) +
                                 (set.has_sigma ? 4u : 0u) + 2u + (set.has_class ? 1u : 0u);
  return (points * of_point + 7) / 8 * 8;
}

TileSet write_tiles(const PassSource& source, const std::string& path, const std::string& scratch,
                    const TileOptions& options) {
  TileSet set;
  PointRuns runs(scratch, options.points_per_run, options.threads);
  source([&](Cloud&& chunk, std::uint16_t pass) { take(chunk, pass, runs, set); });
  set.points = runs.points();
  if (set.points == 0) throw Error("no points to make tiles of");
  if (!(set.time_begin_s <= set.time_end_s)) {  // none, or none that is a number
    set.has_time = false;
    set.time_begin_s = set.time_end_s = 0.0;
  }
  if (!set.has_class) set.points_of_class.clear();
  Tiler tiler(path, set);
  std::uint64_t done = 0;
  runs.in_order([&](const TilePoint& point, const CurvePlace& place) {
    tiler.add(point, place);
    if (++done % (1u << 20) == 0 && options.progress)
      options.progress(static_cast<double>(done) / static_cast<double>(set.points));
  });
  tiler.finish();
  std::uint64_t written = 0;
  for (const Tile& tile : set.tiles) written += tile.points;
  if (written != set.points)
    throw Error(fmt::format("{}: {} points read, {} in tiles; the program is wrong, please report",
                            path, set.points, written));
  return set;
}

}  // namespace cloud
