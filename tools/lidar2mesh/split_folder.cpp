#include "split_folder.h"

#include <fmt/format.h>

#include <filesystem>

#include "base/json_text.h"
#include "base/output_set.h"
#include "base/read_file.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "cloud/error.h"
#include "cloud/read_cloud.h"
#include "crg/options.h"

namespace lidar2mesh {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLargestSplitFile = 64u << 20;

/// Where a file that jobs leave for each other begins: a line of JSON.
struct Head {
  std::string run, before, sha256;
  std::size_t step = 0, tile = 0, bytes = 0;
};

Head take_head(const std::string& path, std::string& text) {
  const std::size_t end = text.find('\n');
  try {
    if (end == std::string::npos || end > 4096) throw cloud::Error("no head");
    const Json json = base::parse_json<Json>(text.substr(0, end));
    Head head{.run = json.at("run").get<std::string>(),
              .before = json.at("before").get<std::string>(),
              .sha256 = json.at("sha256").get<std::string>(),
              .step = json.at("step").get<std::size_t>(),
              .tile = json.at("tile").get<std::size_t>(),
              .bytes = json.at("bytes").get<std::size_t>()};
    text.erase(0, end + 1);
    return head;
  } catch (const std::exception&) {
    throw cloud::Error(path + ": no file of map-tile or merge");
  }
}

}  // namespace

std::string points_name(std::size_t tile, PointPart part, std::size_t number) {
  return fmt::format("tile-{}.{}-{}.ply", tile,
                     part == PointPart::looked_at ? "looked-at" : "others", number);
}
std::string reading_name(int step, std::size_t tile) {
  return fmt::format("step-{}.tile-{}", step, tile);
}
std::string joined_name(int step) { return fmt::format("step-{}.joined", step); }

std::string SplitFolder::name_of(const Slot& slot) {
  return slot.tile == kAllTiles ? joined_name(slot.step) : reading_name(slot.step, slot.tile);
}

/// What makes it.
std::string SplitFolder::command_for(const Slot& slot) const {
  return slot.tile == kAllTiles ? fmt::format("lidar2mesh merge {} --step {}", folder_, slot.step)
                                : fmt::format("lidar2mesh map-tile {} --step {} --tile {}", folder_,
                                              slot.step, slot.tile);
}

Json settings_of(const MapCommand& command) {
  return {{"extrinsic", command.extrinsic}, {"base_stddev_m", command.base_stddev_m},
          {"drift_m", command.drift_m},     {"drift_rad", command.drift_rad},
          {"gate_m", command.gate_m},       {"min_points", command.min_points},
          {"edge_m", command.edge_m},       {"no_grass", command.no_grass}};
}

SplitFolder::SplitFolder(const std::string& folder) : folder_(folder) {
  const std::string file = path(kSplitFile);
  if (!std::filesystem::exists(file))
    throw cloud::Error(file + ": no such file; a folder that 'lidar2mesh split' made is wanted");
  const std::string text = base::read_file(file, kLargestSplitFile);
  // Another program may read the same scans another way.
  run_ = base::sha256(text + base::sha256_of_program());
  MapCommand command;
  std::string base_sha256, trajectory_sha256;
  try {
    const Json json = base::parse_json<Json>(text);
    for (const Json& input : json.at("inputs"))
      inputs_.push_back({input.at("role").get<std::string>(), input.at("path").get<std::string>(),
                         input.at("sha256").get<std::string>()});
    for (const auto& [name, value] : json.at("options").items())
      options_.emplace_back(name, value.is_null()     ? ""
                                  : value.is_string() ? value.get<std::string>()
                                                      : base::dump_json(value));
    remarks_ = json.at("remarks").get<std::vector<std::string>>();
    const Json& set = json.at("settings");
    command.extrinsic = set.at("extrinsic").get<std::vector<double>>();
    set.at("base_stddev_m").get_to(command.base_stddev_m);
    set.at("drift_m").get_to(command.drift_m), set.at("drift_rad").get_to(command.drift_rad);
    set.at("gate_m").get_to(command.gate_m), set.at("min_points").get_to(command.min_points);
    set.at("edge_m").get_to(command.edge_m), set.at("no_grass").get_to(command.no_grass);
    for (const Json& tile : json.at("tiles")) {
      Points& points = points_.emplace_back();
      int part = 0;
      for (const char* name : {"looked_at", "others"}) {
        tile.at(name).at("points").get_to(points.count[part]);
        tile.at(name).at("files").get_to(points.files[part++]);
      }
    }
    base_sha256 = json.at("base_sha256").get<std::string>();
    trajectory_sha256 = json.at("trajectory_sha256").get<std::string>();
  } catch (const Json::exception& error) {
    throw cloud::Error(
        fmt::format("{}: not as 'lidar2mesh split' writes it: {}", file, error.what()));
  }
  for (const auto& [name, sha256] :
       {std::pair{kSplitBase, base_sha256}, {kSplitTrajectory, trajectory_sha256}})
    if (base::sha256_of_file(path(name)) != sha256)
      throw cloud::Error(path(name) +
                         ": not the file that was split; run 'lidar2mesh split' again");
  if (const auto files = base::files_of_set(folder)) sha256_ = *files;
  base_ = crg::apply_modifiers(crg::read(path(kSplitBase)));
  trajectory_ =
      cloud::read_trajectory(path(kSplitTrajectory), cloud::sensor_in_poses(command.extrinsic));
  map_options_ = cloud::map_options(command);
}

cloud::CloudSource SplitFolder::points(std::size_t tile, bool all) const {
  return [this, tile, all](const cloud::ChunkSink& sink) {
    cloud::CloudReadOptions read;
    read.metres_per_unit = 1.0;
    for (const PointPart part : {PointPart::looked_at, PointPart::others}) {
      if (part == PointPart::others && !all) continue;
      const auto k = static_cast<std::size_t>(part);
      std::size_t seen = 0;
      for (std::size_t n = 0; n < points_[tile - 1].files[k]; ++n) {
        check_points(points_name(tile, part, n));
        seen += cloud::read_chunks(path(points_name(tile, part, n)), read, sink).points;
      }
      if (seen != points_[tile - 1].count[k])
        throw cloud::Error(
            fmt::format("{}: {} points seen, {} wanted; run 'lidar2mesh split' again",
                        path(points_name(tile, part, 0)), seen, points_[tile - 1].count[k]));
    }
  };
}

void SplitFolder::check_points(const std::string& name) const {
  const auto stored = sha256_.find(name);
  if (stored == sha256_.end())
    throw cloud::Error(fmt::format(
        "{}: not named by manifest.json beside it; run 'lidar2mesh split' again", path(name)));
  base::check_sha256(path(name), stored->second, "run 'lidar2mesh split' again");
}

std::string SplitFolder::load(const Slot& slot) const {
  const std::string file = path(name_of(slot)), to_do = command_for(slot);
  if (!std::filesystem::exists(file))
    throw cloud::Error(fmt::format("{}: missing; run '{}' first", file, to_do));
  std::string text = base::read_file(file);
  const Head head = take_head(file, text);
  const auto refuse = [&](const std::string& what, const auto& seen, const auto& wanted) {
    throw cloud::Error(fmt::format("{}: {}: {} seen, {} wanted; run '{}' again", file, what,
                                   fmt::format("{:.12}", fmt::format("{}", seen)),
                                   fmt::format("{:.12}", fmt::format("{}", wanted)), to_do));
  };
  if (head.run != run_)
    refuse("of another split (other scans, base or options), or by another build of lidar2mesh",
           head.run, run_);
  if (head.step != static_cast<std::size_t>(slot.step))
    refuse("of another step", head.step, slot.step);
  if (head.tile != slot.tile) refuse("of another tile", head.tile, slot.tile);
  if (const std::string before = hash_before(slot.step); head.before != before)
    refuse("made after another run of the step before", head.before, before);
  if (head.bytes != text.size()) refuse("damaged, bytes", text.size(), head.bytes);
  if (const std::string sha256 = base::sha256(text); head.sha256 != sha256)
    refuse("damaged, SHA-256", sha256, head.sha256);
  return text;
}

void SplitFolder::save(const Slot& slot, const std::string& bytes) const {
  const Json head = {{"run", run_},           {"step", slot.step},
                     {"tile", slot.tile},     {"before", hash_before(slot.step)},
                     {"bytes", bytes.size()}, {"sha256", base::sha256(bytes)}};
  base::FileWriter file(path(name_of(slot)));
  file.append(base::dump_json(head) + "\n");
  file.append(bytes);
  file.commit();
}

std::string SplitFolder::hash_before(int step) const {
  if (step == 1 || !std::filesystem::exists(path(joined_name(step - 1)))) return "";
  const std::string file = path(joined_name(step - 1));
  std::string text = base::read_file(file);
  return take_head(file, text).sha256;
}

std::string SplitFolder::state_before(int step) const {
  return step == 1 ? "" : load({step - 1, kAllTiles});
}

std::string SplitFolder::reading(int step, std::size_t tile) const { return load({step, tile}); }

void SplitFolder::require_readings(int step) const {
  std::vector<std::size_t> missing;
  for (std::size_t tile = 1; tile <= tiles(); ++tile)
    if (!std::filesystem::exists(path(reading_name(step, tile)))) missing.push_back(tile);
  if (!missing.empty())
    throw cloud::Error(fmt::format("{}: tile{} {} of {} missing in step {}; run '{}' first",
                                   folder_, missing.size() == 1 ? "" : "s",
                                   fmt::join(missing, ", "), tiles(), step,
                                   command_for({step, missing.front()})));
}

void SplitFolder::write_reading(int step, std::size_t tile, const std::string& bytes) const {
  save({step, tile}, bytes);
}

void SplitFolder::write_state(int step, const std::string& bytes) const {
  save({step, kAllTiles}, bytes);
}

}  // namespace lidar2mesh
