// Points in the order of a curve that fills space (Morton's), however many there are: sorted in
// memory run by run, kept in a file, merged.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "base/scratch_file.h"
#include "cloud/cloud.h"

namespace cloud {

/// As it lies in the file of runs.
struct TilePoint {
  double x_m = 0.0, y_m = 0.0, z_m = 0.0;  ///< map frame
  double time_s = 0.0;                     ///< NaN: none
  float intensity = 0.0f;                  ///< NaN: none
  std::uint16_t pass = 0;
  std::uint8_t classification = 0;
  float sigma_m = 0.0f;  ///< NaN: none
};
static_assert(sizeof(TilePoint) == 48);

/// Place on the curve: the bits of x, y and z in turn, the most significant first; 42 of each.
struct CurvePlace {
  std::uint64_t high = 0, low = 0;  ///< 63 bits each
  auto operator<=>(const CurvePlace&) const = default;
};

constexpr int kCurveLevels = 42;
constexpr double kRootCell_m = 1073741824.0;  ///< 2^30; the finest cell is 2^-12 m wide

/// How many levels of an octree two places have their cell in common; kCurveLevels: the same place.
int levels_in_common(const CurvePlace& a, const CurvePlace& b);

class PointRuns {
 public:
  /// The file is of 48 bytes a point, and nobody sees it. Throws Error.
  PointRuns(const std::string& scratch, std::size_t points_per_run, unsigned threads);

  /// Throws Error: a coordinate that is 1e8 m or more, or no number; no room on the disk.
  void add(const TilePoint& point);
  std::uint64_t points() const { return points_ + waiting_.size(); }

  /// All points by place, those of one place in the order in which they came.
  void in_order(const std::function<void(const TilePoint&, const CurvePlace&)>& sink);

 private:
  CurvePlace place_of(const TilePoint& point) const;
  void sort_and_write();

  std::size_t points_per_run_;
  unsigned threads_;
  base::ScratchFile file_;
  TilePoint first_;  ///< at a third of every cell that holds it, so that few borders are near
  std::vector<TilePoint> waiting_;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> runs_;  ///< begin and end, in points
  std::uint64_t points_ = 0;                                   ///< in the file
};

}  // namespace cloud
