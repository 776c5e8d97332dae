// map_clouds() by several processes: the scans are cut by stretch of the road, what is read of each
// tile is summed up, and one process joins the sums. The code is that of map_clouds(), and so is
// the result: drift to the bit, heights to the rounding of float32 sums, where the points of each
// pass come in the order of time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cloud/map.h"

namespace cloud {

/// The scans are read four times: for the drift; once more with most of it taken out; a third time
/// where that turned poses much; for the heights.
inline constexpr int kTileSteps = 4;

/// Which points belong together: those measured from the same stretch of the road, whatever the
/// lap. Stretches hold about the same distance driven.
class TileCut {
 public:
  /// `tiles`: from 1 on. The trajectory is copied. Throws Error: more tiles than there are pieces
  /// of 5 m, poses beside the base.
  TileCut(const crg::Crg& base, const Trajectory& trajectory, std::size_t tiles);
  ~TileCut();
  TileCut(const TileCut&) = delete;
  TileCut& operator=(const TileCut&) = delete;

  struct Stretch {
    double u_begin_m = 0.0, u_end_m = 0.0;  ///< of the car while it measured
    double driven_m = 0.0;                  ///< in all laps
  };
  const std::vector<Stretch>& stretches() const { return stretches_; }  ///< one per tile

  struct Where {
    std::size_t tile = 0;    ///< where the trajectory has no pose: the first
    std::uint8_t visit = 0;  ///< what TiledMap::read() wants as class of a point that is looked at
  };
  /// Of the next point of all, in the order of the scans.
  Where next(double time_s, bool looked_at);

 private:
  struct Places;
  std::unique_ptr<Places> places_;
  std::vector<Stretch> stretches_;
};

/// A map before one of its steps. What it is made of must live as long.
class TiledMap {
 public:
  /// `state`: what state() was after the step before; empty: before the first. Throws Error: no
  /// such state, poses beside the base.
  TiledMap(const crg::Crg& base, const Trajectory& trajectory, const MapOptions& options,
           std::string_view state = {});
  ~TiledMap();
  TiledMap(const TiledMap&) = delete;
  TiledMap& operator=(const TiledMap&) = delete;

  int step() const;  ///< from 1 on; kTileSteps + 1 after the last
  bool due() const;  ///< false: nothing has to be read in this step

  /// What a tile's points say in this step. `looked_at`: those that count for the drift; `all`:
  /// all. Memory: the road, the trajectory and what is seen from the tile.
  std::string read(const CloudSource& looked_at, const CloudSource& all) const;

  /// Does the step with what all tiles said, in their order. Memory: as map_clouds(), and one
  /// tile's reading at a time. `scans`: all points, read only where something does not fit. The
  /// result is empty but for the last step. Throws Error as map_clouds().
  MapResult join(std::size_t tiles, const std::function<std::string(std::size_t tile)>& reading,
                 const CloudSource& scans);
  std::string state() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace cloud
