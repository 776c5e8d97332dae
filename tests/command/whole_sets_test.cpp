// What a killed command leaves: whoever reads then sees the old set whole, the new one whole, or a
// refusal; the next run leaves its own set and nothing else. KERBSTONE_HEAVY=1 for 504 kills
// (docs/evidence.md).
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>

#include "support/figure.h"
#include "support/mesh_files.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace whole_sets_test {

namespace fs = std::filesystem;
using cli::Folder;
using support::run_tool, support::ToolRun;
using Words = std::vector<std::string>;
using Files = std::map<std::string, std::string>;

/// The program of that name and the words behind it.
ToolRun run(const Words& words, const support::ToolOptions& options = {}) {
  for (const support::Tool& tool : support::all_tools())
    if (tool.name == words.front())
      return run_tool(tool.path, {words.begin() + 1, words.end()}, options);
  return {};
}

void make(const Words& words) {
  const ToolRun ran = run(words);
  ASSERT_EQ(ran.code, 0) << words[0] << " " << words[1] << ": " << ran.err;
}

/// In words, what begins with @ lies in the folder of the test.
Words placed(const Folder& folder, Words words) {
  for (std::string& word : words)
    if (word.starts_with("@")) word = folder / word.substr(1);
  return words;
}

void make_meshes(const Folder& folder) {
  road::Mesh mesh = support::small_road();
  cli::write(folder / "a.obj", support::as_obj(mesh));
  for (auto& v : mesh.vertices_m) v.z() *= 1.5;
  cli::write(folder / "b.obj", support::as_obj(mesh));
  cli::write(folder / "points.csv", "u_m,v_m\n1,0\n");
}

void make_scans(const Folder& folder) {
  make(placed(folder,
              {"lidar2mesh", "synth", places::source() + "/tracks/kerbstone-ring/circuit.yaml",
               "-o", "@scans", "--u-begin-m", "380", "--u-end-m", "390", "--laps", "1",
               "--azimuths", "128", "--beams", "16", "--cars", "0"}));
  make(placed(folder, {"crgbuild", "crop", "@scans/truth.crg", "-o", "@base.crg", "--u-begin-m",
                       "360", "--u-end-m", "410"}));
  cli::write(folder / "points.csv", "u_m,v_m\n383,0\n");
}

/// Two that differ in what a point counts for, all but their last step.
void make_tiles(const Folder& folder) {
  make_scans(folder);
  for (const auto& [name, stddev_m] : {std::pair{"@a", "0.02"}, {"@b", "0.05"}}) {
    make(placed(folder,
                {"lidar2mesh", "split", "@scans", "--trajectory", "@scans/truth_trajectory.csv",
                 "--road", "@base.crg", "--tiles", "1", "--base-stddev-m", stddev_m, "-o", name}));
    for (const char* step : {"1", "2", "3", "4"}) {
      make(placed(folder, {"lidar2mesh", "map-tile", name, "--step", step, "--tile", "1"}));
      if (step[0] != '4') make(placed(folder, {"lidar2mesh", "merge", name, "--step", step}));
    }
  }
}

/// A car whose stated wheels are too small, and rows of its log.
void make_logs(const Folder& folder) {
  ASSERT_EQ(run_tool(places::make_trials(), {"--scenario", "radius", folder.path(), "1"}).code, 0);
  const std::string log = cli::read(folder / "radius/run.csv");
  const auto rows = [&](int count) {
    std::size_t at = 0;
    for (int row = 0; row < count; ++row) at = log.find('\n', at) + 1;
    return log.substr(0, at);
  };
  cli::write(folder / "a.csv", rows(520));
  cli::write(folder / "b.csv", rows(600));
  cli::write(folder / "c.csv", rows(150));
  cli::write(folder / "d.csv", rows(170));
}

/// A command that writes @out: over the set that `before` leaves runs `after`. What reads the set
/// finds a copy at @seen, and may write @read.
struct Row {
  const char* name;
  void (*prepare)(const Folder& folder);
  Words command, before, after;
  std::vector<Words> readers;
};

const Words kBuild{"crgbuild", "build",  "-o", "@out",       "--name", "road",       "--up",
                   "z",        "--unit", "m",  "--u-step-m", "0.5",    "--v-step-m", "0.5"};
const Words kMap{"lidar2mesh", "map",       "@scans", "--trajectory", "@scans/truth_trajectory.csv",
                 "--road",     "@base.crg", "-o",     "@out"};
const Words kSplit{
    "lidar2mesh", "split",     "@scans", "--trajectory", "@scans/truth_trajectory.csv",
    "--road",     "@base.crg", "-o",     "@out"};
const Words kExplain{"crgexplain",
                     "run",
                     "--road",
                     "@radius/track.crg",
                     "--car",
                     "@radius/vehicle.yaml",
                     "--skip-simulation",
                     "--nulls",
                     "100",
                     "-o",
                     "@out"};
const Words kForces{"crgidentify",
                    "forces",
                    "@c.csv",
                    "@d.csv",
                    "--car",
                    "@radius/vehicle.yaml",
                    "--road",
                    "@radius/track.crg",
                    "--noise-rounds",
                    "0",
                    "-o",
                    "@out"};
const std::vector<Words> kReadRefined{
    {"crgbuild", "info", "@seen/refined.crg", "--json"},
    {"crgbuild", "query", "@seen/refined.crg", "--points", "@points.csv", "-o", "-"},
    {"lidar2mesh", "info", "@seen/refined.ply", "--json"}};

const std::vector<Row> kRows{
    {"crgbuild_build",
     make_meshes,
     kBuild,
     {"@a.obj", "--friction"},
     {"@b.obj"},
     {{"crgbuild", "info", "@seen/road.crg", "--json"},
      {"crgbuild", "query", "@seen/road.crg", "--points", "@points.csv", "-o", "-"},
      {"crgbuild", "report", "@seen/road.crg", "-o", "@read", "--json"}}},
    {"lidar2mesh_map",
     make_scans,
     kMap,
     {"--base-stddev-m", "0.02", "--format", "ply,pcd"},
     {"--base-stddev-m", "0.05"},
     kReadRefined},
    {"lidar2mesh_split",
     make_scans,
     kSplit,
     {"--tiles", "2"},
     {"--tiles", "1", "--base-stddev-m", "0.05"},
     {{"lidar2mesh", "map-tile", "@seen", "--step", "1", "--tile", "1", "--json"}}},
    {"lidar2mesh_merge",
     make_tiles,
     {"lidar2mesh", "merge", "--step", "4", "-o", "@out"},
     {"@a", "--format", "ply,pcd"},
     {"@b"},
     kReadRefined},
    {"crgexplain_run",
     make_logs,
     kExplain,
     {"--log", "@a.csv"},
     {"--log", "@b.csv"},
     {{"crgdrive", "poles", "--car", "@seen/vehicle.yaml", "--json"}}},
    {"crgidentify_forces",
     make_logs,
     kForces,
     {"--tyre-k", "360"},
     {"--tyre-k", "340"},
     {{"crgexplain", "map", "@seen/c_forces.csv", "--list", "-o", "@read"},
      {"crgexplain", "map", "@seen/d_forces.csv", "--list", "-o", "@read"}}},
};

/// Every file of a folder, hidden ones too, but for what differs from run to run.
Files files_in(const std::string& folder) {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    files[fs::relative(entry.path(), folder).string()] =
        entry.is_regular_file() ? cli::read(entry.path()) : "no file";
  files.erase("timing.json");
  return files;
}

std::string names_of(const Files& files) {
  std::string names;
  for (const auto& [name, bytes] : files) names += name + " ";
  return names;
}

class WholeSets : public ::testing::TestWithParam<Row> {
 protected:
  enum Side { kOld, kNew };

  Words words(Side side) const {
    Words all = GetParam().command;
    const Words& more = side == kOld ? GetParam().before : GetParam().after;
    all.insert(all.end(), more.begin(), more.end());
    return placed(folder_, all);
  }
  /// What each reader says of the set as it lies there.
  std::vector<ToolRun> read_all() const {
    std::vector<ToolRun> said;
    for (const Words& reader : GetParam().readers) {
      for (const char* name : {"seen", "read"}) fs::remove_all(folder_ / name);
      if (fs::exists(folder_ / "out"))
        fs::copy(folder_ / "out", folder_ / "seen", fs::copy_options::recursive);
      said.push_back(run(placed(folder_, reader)));
      // Nobody's word for it: the files that it wrote.
      for (const char* name : {"seen/step-1.tile-1", "read/report.json"})
        if (cli::exists(folder_ / name)) said.back().out += cli::read(folder_ / name);
    }
    return said;
  }
  /// One set made where none was, how long it took, and what is read of it.
  void make_undisturbed(Side side) {
    const auto begin = std::chrono::steady_clock::now();
    const ToolRun ran = run(words(side));
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    seconds_ = std::min(seconds_, took.count());
    ASSERT_TRUE(ran.code == 0 || ran.code == 3) << ran.code << " " << ran.err;
    code_[side] = ran.code;
    files_[side] = files_in(folder_ / "out");
    said_[side] = read_all();
    for (const ToolRun& said : said_[side])
      ASSERT_TRUE(said.code == 0 || said.code == 3) << said.err;
    fs::rename(folder_ / "out", folder_ / (side == kOld ? "old" : "new"));
  }
  /// All readers see one set, or are refused in a line.
  void expect_one_set_seen(const std::string& when) const {
    std::set<Side> seen;
    const std::vector<ToolRun> said = read_all();
    for (std::size_t k = 0; k < said.size(); ++k) {
      const auto is_of = [&](Side side) {
        return said[k].code == said_[side][k].code && said[k].out == said_[side][k].out;
      };
      if (is_of(kOld) && is_of(kNew)) continue;
      if (is_of(kOld) || is_of(kNew)) {
        seen.insert(is_of(kOld) ? kOld : kNew);
        continue;
      }
      EXPECT_NE(said[k].code, 0) << when << ", reader " << k << " saw neither set";
      EXPECT_EQ(std::count(said[k].err.begin(), said[k].err.end(), '\n'), 1)
          << when << ": " << said[k].err;
    }
    EXPECT_LE(seen.size(), 1u) << when << ": readers saw two sets";
  }
  /// The files themselves are one set, or the manifest tells whoever asks it.
  bool is_half() const {
    const Files files = files_in(folder_ / "out");
    const auto is_there = [&](const auto& file) {
      const auto found = files.find(file.first);
      return found != files.end() && found->second == file.second;
    };
    const auto is_whole = [&](Side side) {
      return std::all_of(files_[side].begin(), files_[side].end(), is_there);
    };
    return !is_whole(kOld) && !is_whole(kNew);
  }
  bool manifest_says_so() const {
    return cli::read(folder_ / "out/manifest.json").find("\"complete\": false") !=
           std::string::npos;
  }
  void kill(const support::ToolOptions& options, const std::string& when) {
    fs::remove_all(folder_ / "out");
    fs::copy(folder_ / "old", folder_ / "out", fs::copy_options::recursive);
    killed_ += run(words(kNew), options).code == 137 ? 1 : 0;
    EXPECT_TRUE(!is_half() || manifest_says_so()) << when << ": files of two runs";
    half_ += is_half() ? 1 : 0;
    expect_one_set_seen(when);
    const ToolRun again = run(words(kNew));
    EXPECT_EQ(again.code, code_[kNew]) << when << ": " << again.err;
    const Files files = files_in(folder_ / "out");
    EXPECT_EQ(names_of(files), names_of(files_[kNew])) << when;
    for (const auto& [name, bytes] : files_[kNew])
      EXPECT_TRUE(files.contains(name) && files.at(name) == bytes) << when << ": " << name;
  }

  Folder folder_;
  double seconds_ = 1e9;
  std::array<int, 2> code_{};
  std::array<Files, 2> files_;
  std::array<std::vector<ToolRun>, 2> said_;
  int killed_ = 0, half_ = 0;
};

TEST_P(WholeSets, KilledAtAnyMomentOneIsSeenAndTheNextRunLeavesItsOwn) {
  GetParam().prepare(folder_);
  if (HasFatalFailure()) return;
  for (const Side side : {kOld, kNew}) {
    make_undisturbed(side);
    if (HasFatalFailure()) return;
  }
  bool differ = false;
  for (std::size_t k = 0; k < said_[kOld].size(); ++k)
    differ = differ || said_[kOld][k].out != said_[kNew][k].out;
  EXPECT_TRUE(differ) << "no reader could tell one set from the other";
  // Half of them over all of the run, half from when all is made and files move in.
  const int kills = std::getenv("KERBSTONE_HEAVY") != nullptr ? 42 : 1;
  for (int k = 0; k < kills && !HasFailure(); ++k) {
    const double share = (k + 0.5) / kills;
    kill({.signal_after_s = share * seconds_, .signal = 9},
         fmt::format("killed after {:.3f} of {:.3f} s", share * seconds_, seconds_));
    kill({.signal_after_s = 2e-3 * share,
          .signal = 9,
          .signal_once_exists = folder_ / "out/.kerbstone.new/manifest.json"},
         fmt::format("killed {:.3f} ms after all was made", 2.0 * share));
  }
  // A run that was alone is over sooner than the two that were timed beside others.
  for (double share = 0.25; killed_ == 0 && share > 0.005 && !HasFailure(); share /= 2)
    kill({.signal_after_s = share * seconds_, .signal = 9},
         fmt::format("killed after {:.3f} of {:.3f} s", share * seconds_, seconds_));
  support::figure("killed", killed_), support::figure("while_files_moved", half_);
  EXPECT_GE(killed_, kills);
}

TEST(Forces, OfOtherLogsStayInTheFolder) {
  const Folder folder;
  make_logs(folder);
  for (const char* log : {"@c.csv", "@d.csv"})
    EXPECT_EQ(
        run(placed(folder, {"crgidentify", "forces", log, "--car", "@radius/vehicle.yaml", "--road",
                            "@radius/track.crg", "--noise-rounds", "0", "-o", "@out"}))
            .code,
        3);  // the stated wheels are seen to be wrong
  const std::string manifest = cli::read(folder / "out/manifest.json");
  for (const char* name : {"c_forces.csv", "d_forces.csv"}) {
    EXPECT_TRUE(cli::exists(folder / ("out/" + std::string(name)))) << name;
    EXPECT_NE(manifest.find(name), std::string::npos) << name;
  }
}

void PrintTo(const Row& row, std::ostream* out) { *out << row.name; }

std::string name_of_row(const ::testing::TestParamInfo<Row>& row) { return row.param.name; }

INSTANTIATE_TEST_SUITE_P(Of, WholeSets, ::testing::Values(kRows[0], kRows[2]), name_of_row);
INSTANTIATE_TEST_SUITE_P(SlowOf, WholeSets,
                         ::testing::Values(kRows[1], kRows[3], kRows[4], kRows[5]), name_of_row);

}  // namespace whole_sets_test
