// The folder that `split` makes: what it holds, and what jobs leave in it for each other.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cloud/map.h"
#include "cloud/map_tiles.h"
#include "cloud/trajectory.h"
#include "commands.h"
#include "crg/file.h"
#include "inspect/input_file.h"

namespace lidar2mesh {

/// Of a tile's points: whether they are looked at for the drift.
enum class PointPart { looked_at, others };

inline constexpr const char* kSplitFile = "split.json";
inline constexpr const char* kSplitBase = "base.crg";
inline constexpr const char* kSplitTrajectory = "trajectory.csv";

/// Names in the folder. Tiles and steps count from 1.
std::string points_name(std::size_t tile, PointPart part, std::size_t number);
std::string reading_name(int step, std::size_t tile);
std::string joined_name(int step);

/// What map-tile and merge want to know of a map's options, for split.json.
nlohmann::ordered_json settings_of(const MapCommand& command);

/// A folder that was split, read back and checked.
class SplitFolder {
 public:
  /// Throws cloud::Error: none, damaged, or base or trajectory are not those that were split.
  explicit SplitFolder(const std::string& folder);

  std::size_t tiles() const { return points_.size(); }
  const crg::Crg& base() const { return base_; }
  const cloud::Trajectory& trajectory() const { return trajectory_; }
  const std::vector<road::InputFile>& inputs() const { return inputs_; }
  const Options& options() const { return options_; }
  const std::vector<std::string>& remarks() const { return remarks_; }
  /// As they were given to `split`; the threads are another matter.
  const cloud::MapOptions& map_options() const { return map_options_; }
  /// Part of a tile's points, or all. It throws cloud::Error where points are missing. Valid as
  /// long as this is.
  cloud::CloudSource points(std::size_t tile, bool all) const;

  /// What was left before a step; empty before the first. Throws cloud::Error: missing, damaged, of
  /// another split or another build.
  std::string state_before(int step) const;
  /// What a tile said in a step, from the state that lies there now; throws as above.
  std::string reading(int step, std::size_t tile) const;
  /// Throws cloud::Error where readings of the step are missing, with the numbers of all these
  /// tiles.
  void require_readings(int step) const;
  /// Each file appears whole or not at all.
  void write_reading(int step, std::size_t tile, const std::string& bytes) const;
  void write_state(int step, const std::string& bytes) const;
  std::string path(const std::string& name) const { return folder_ + "/" + name; }

 private:
  struct Points {
    std::size_t count[2], files[2];
  };
  static constexpr std::size_t kAllTiles = 0;
  struct Slot {
    int step = 1;
    std::size_t tile = kAllTiles;  ///< from 1 on; kAllTiles: what they are joined to
  };
  static std::string name_of(const Slot& slot);
  std::string command_for(const Slot& slot) const;
  /// Throws Error where a file of points is not the one that `split` wrote.
  void check_points(const std::string& name) const;
  std::string load(const Slot& slot) const;
  void save(const Slot& slot, const std::string& bytes) const;
  /// Of the state before a step; empty where there is none.
  std::string hash_before(int step) const;

  std::string folder_, run_;
  std::map<std::string, std::string> sha256_;  ///< of the files that `split` wrote
  std::vector<Points> points_;
  std::vector<road::InputFile> inputs_;
  Options options_;
  std::vector<std::string> remarks_;
  cloud::MapOptions map_options_;
  crg::Crg base_;
  cloud::Trajectory trajectory_;
};

}  // namespace lidar2mesh
