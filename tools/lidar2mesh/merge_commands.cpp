#include <fmt/format.h>

#include <optional>

#include "base/json_text.h"
#include "base/output_set.h"
#include "cloud/error.h"
#include "split_folder.h"

namespace lidar2mesh {
namespace {

using Json = nlohmann::ordered_json;

cloud::MapOptions options_for(const SplitFolder& split, unsigned threads,
                              const base::Progress& progress) {
  cloud::MapOptions options = split.map_options();
  options.threads = threads, options.progress = progress;
  return options;
}

/// What a step did that is not the last one.
void print_step(const SplitFolder& split, const std::string& file, int step, bool due,
                Terminal& terminal) {
  if (terminal.json)
    terminal.print(base::json_text(Json{{"step", step}, {"due", due}, {"file", split.path(file)}}));
  else
    terminal.print(fmt::format("step {}{}\nfile     {}\n", step,
                               due ? "" : ": nothing to do, poses were hardly turned",
                               split.path(file)));
}

}  // namespace

int run_map_tile(const MapTileCommand& command, Terminal& terminal) {
  const SplitFolder split(command.folder);
  const auto tile = static_cast<std::size_t>(command.tile);
  if (tile > split.tiles())
    throw command::UsageError(
        fmt::format("--tile {} seen; {} has tiles 1 to {}", tile, command.folder, split.tiles()));
  const cloud::TiledMap map(split.base(), split.trajectory(),
                            options_for(split, command.threads, terminal.progress()),
                            split.state_before(command.step));
  const bool due = map.due();
  split.write_reading(command.step, tile,
                      map.read(split.points(tile, false), split.points(tile, true)));
  print_step(split, reading_name(command.step, tile), command.step, due, terminal);
  return kOk;
}

int run_merge(const MergeCommand& command, Terminal& terminal) {
  const bool last = command.step == cloud::kTileSteps;
  if (last == command.map.output_dir.empty())
    throw command::UsageError(last ? "the last step makes the road: -o FOLDER is wanted"
                                   : fmt::format("-o is of --step {}", cloud::kTileSteps));
  const SplitFolder split(command.folder);
  split.require_readings(command.step);
  std::optional<base::OutputSet> outputs;
  if (last) outputs.emplace(command.map.output_dir, "lidar2mesh merge");
  cloud::TiledMap map(split.base(), split.trajectory(),
                      options_for(split, command.map.threads, terminal.progress()),
                      split.state_before(command.step));
  const bool due = map.due();
  const cloud::CloudSource all = [&](const cloud::ChunkSink& sink) {
    for (std::size_t tile = 1; tile <= split.tiles(); ++tile) split.points(tile, true)(sink);
  };
  const cloud::MapResult result = map.join(
      split.tiles(), [&](std::size_t k) { return split.reading(command.step, k + 1); }, all);
  if (!last) {
    split.write_state(command.step, map.state());
    print_step(split, joined_name(command.step), command.step, due, terminal);
    return kOk;
  }
  MapCommand made = command.map;
  made.base = split.path(kSplitBase);
  made.options = split.options();
  made.options.insert(made.options.end(), command.map.options.begin(), command.map.options.end());
  made.program = program();
  return show_map(made,
                  cloud::write_refined(made, split.base(), result, split.remarks(), split.inputs(),
                                       *outputs, terminal.progress()),
                  terminal);
}

}  // namespace lidar2mesh
