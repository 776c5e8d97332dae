#include <fmt/format.h>

#include <array>
#include <cmath>

#include "base/ending.h"
#include "base/json_text.h"
#include "base/output_set.h"
#include "base/read_file.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "cloud/error.h"
#include "cloud/map_tiles.h"
#include "split_folder.h"

namespace lidar2mesh {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostWaiting = 2'000'000;  // points of all tiles, 32 bytes each

/// The points of all tiles on their way to files. What counts for the drift is decided here, as
/// map_clouds() does by the order of the points.
class TileFiles {
 public:
  TileFiles(const base::OutputSet& outputs, std::size_t tiles) : outputs_(outputs), parts_(tiles) {}

  void add(const cloud::TileCut::Where& where, PointPart part, const cloud::Cloud& chunk,
           std::size_t k) {
    const std::size_t tile = where.tile;
    Part& to = parts_[tile][static_cast<std::size_t>(part)];
    cloud::Cloud& waiting = to.waiting;
    if (waiting.size() > 0 && waiting.origin_m != chunk.origin_m) write(tile, part);
    waiting.origin_m = chunk.origin_m;
    waiting.x_m.push_back(chunk.x_m[k]), waiting.y_m.push_back(chunk.y_m[k]),
        waiting.z_m.push_back(chunk.z_m[k]);
    waiting.time_s.push_back(chunk.time_s[k]);
    if (part == PointPart::looked_at) waiting.classification.push_back(where.visit);
    ++to.points, ++waiting_;
    if (waiting_ >= kMostWaiting) write_largest();
  }

  void finish() {
    for (std::size_t tile = 0; tile < parts_.size(); ++tile)
      for (const PointPart part : {PointPart::looked_at, PointPart::others}) write(tile, part);
  }

  Json counts(std::size_t tile, PointPart part) const {
    const Part& of = parts_[tile][static_cast<std::size_t>(part)];
    return {{"points", of.points}, {"files", of.files}};
  }

 private:
  struct Part {
    cloud::Cloud waiting;
    std::size_t points = 0, files = 0;
  };

  void write_largest() {
    std::size_t most = 0, tile = 0, part = 0;
    for (std::size_t i = 0; i < parts_.size(); ++i)
      for (std::size_t j = 0; j < 2; ++j)
        if (parts_[i][j].waiting.size() > most)
          most = parts_[i][j].waiting.size(), tile = i, part = j;
    write(tile, static_cast<PointPart>(part));
  }

  void write(std::size_t tile, PointPart part) {
    Part& of = parts_[tile][static_cast<std::size_t>(part)];
    if (of.waiting.size() == 0) return;
    // Not one bit may be lost.
    const auto short_enough = [](const std::vector<double>& values) {
      return std::all_of(values.begin(), values.end(), [](double value) {
        return static_cast<double>(static_cast<float>(value)) == value;
      });
    };
    const bool floats = short_enough(of.waiting.x_m) && short_enough(of.waiting.y_m) &&
                        short_enough(of.waiting.z_m);
    cloud::write_cloud(of.waiting, outputs_.staged(points_name(tile + 1, part, of.files++)),
                       !floats);
    waiting_ -= of.waiting.size();
    of.waiting = {};
  }

  const base::OutputSet& outputs_;
  std::vector<std::array<Part, 2>> parts_;
  std::size_t waiting_ = 0;
};

/// As it is where it is a road; a road made of a mesh is written.
void write_base(const MapCommand& command, const crg::Crg& base, const std::string& path) {
  base::write_file(path, base::ending_of(command.base) == ".crg"
                             ? base::read_file(command.base)
                             : crg::to_bytes(base, crg::Format::KRBI));
}

std::size_t cut(const cloud::CloudSource& source, cloud::TileCut& cut, std::size_t every,
                TileFiles& files) {
  std::size_t points = 0;
  source([&](cloud::Cloud&& chunk) {
    if (chunk.time_s.size() != chunk.size())
      throw cloud::Error(
          "the points have no time, so they cannot be placed on the trajectory; a property 'time' "
          "is wanted");
    for (std::size_t k = 0; k < chunk.size(); ++k) {
      const bool looked_at = k % every == 0;
      files.add(cut.next(chunk.time_s[k], looked_at),
                looked_at ? PointPart::looked_at : PointPart::others, chunk, k);
    }
    points += chunk.size();
  });
  files.finish();
  return points;
}

}  // namespace

int run_split(const SplitCommand& command, Terminal& terminal) {
  const MapCommand& map = command.map;
  const std::vector<std::string> clouds = cloud::scan_files(map);
  std::vector<road::InputFile> inputs = cloud::inputs_of(map, false);
  const cloud::Trajectory trajectory =
      cloud::read_trajectory(map.trajectory, cloud::sensor_in_poses(map.extrinsic));
  want_outliers(map.outliers);
  const cloud::FilterOptions filter = cloud::filter_options(map.outliers, map.voxel_m);
  base::OutputSet outputs(map.output_dir, "lidar2mesh split");
  const crg::Crg base = cloud::read_base(map, inputs);
  write_base(map, base, outputs.staged(kSplitBase));
  base::write_file(outputs.staged(kSplitTrajectory), base::read_file(map.trajectory));

  cloud::TileCut tile_cut(base, trajectory, static_cast<std::size_t>(command.tiles));
  cloud::MapScans scans(map, clouds, terminal.progress());
  scans.enter("split", 0.0, 1.0);
  cloud::FilterReport left_out;
  TileFiles files(outputs, tile_cut.stretches().size());
  const auto every = static_cast<std::size_t>(cloud::map_options(map).estimate_every);
  const std::size_t points =
      cut(filter.wanted() ? cloud::filtered(scans.source(), &trajectory, filter, &left_out)
                          : scans.source(),
          tile_cut, every, files);

  Json out = head_of(inputs, map.options);
  out["points"] = points;
  Json tiles = Json::array();
  for (std::size_t tile = 0; tile < tile_cut.stretches().size(); ++tile) {
    const cloud::TileCut::Stretch& stretch = tile_cut.stretches()[tile];
    tiles.push_back({{"u_begin_m", stretch.u_begin_m},
                     {"u_end_m", stretch.u_end_m},
                     {"driven_m", stretch.driven_m},
                     {"looked_at", files.counts(tile, PointPart::looked_at)},
                     {"others", files.counts(tile, PointPart::others)}});
  }
  out["tiles"] = tiles;
  out["settings"] = settings_of(map);
  out["base_sha256"] = base::sha256_of_file(outputs.staged(kSplitBase));
  out["trajectory_sha256"] = base::sha256_of_file(outputs.staged(kSplitTrajectory));
  out["remarks"] = cloud::remarks_of(scans.remarks(), filter, left_out);
  const std::string text = base::json_text(out);
  base::write_file(outputs.staged(kSplitFile), text);
  outputs.commit("split");
  if (terminal.json) {
    terminal.print(text);
    return kOk;
  }
  terminal.print(fmt::format("{} points in {} tiles\nsplit    {}\n", points, tiles.size(),
                             outputs.path(kSplitFile)));
  return kOk;
}

}  // namespace lidar2mesh
