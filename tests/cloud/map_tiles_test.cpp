// A map by tiles against the map of the whole, as they are called.
#include "cloud/map_tiles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "base/json_text.h"
#include "base/sha256.h"
#include "cloud/error.h"
#include "cloud/read_cloud.h"
#include "cloud/trajectory.h"
#include "crg/file.h"
#include "nlohmann/json.hpp"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"
#include "support/wavy_road.h"

namespace cloud {
namespace map_tiles_test {

using nlohmann::json;
using ::testing::HasSubstr;
using Words = std::vector<std::string>;

support::ToolRun lidar2mesh(const Words& words) {
  return support::run_tool(places::lidar2mesh(), words);
}

void must(const Words& words) {
  const support::ToolRun ran = lidar2mesh(words);
  ASSERT_EQ(ran.code, 0) << words.front() << ": " << ran.err;
}

void read_tiles(const std::string& tiles, int step, int count, const std::string& threads = "1") {
  for (int tile = 1; tile <= count; ++tile)
    must({"map-tile", tiles, "--step", std::to_string(step), "--tile", std::to_string(tile),
          "--threads", threads});
}

void merge(const std::string& tiles, int step, const std::string& threads = "1") {
  must({"merge", tiles, "--step", std::to_string(step), "--threads", threads});
}

/// Largest difference of values, and of these over the first ones; both have holes at the same
/// nodes.
struct Apart {
  double most = 0.0, share = 0.0;
  std::size_t values = 0;
};

Apart apart(const std::string& first, const std::string& second) {
  const crg::Grid a = crg::read(first).grid, b = crg::read(second).grid;
  Apart out;
  EXPECT_EQ(a.z_m.size(), b.z_m.size());
  for (std::size_t k = 0; k < std::min(a.z_m.size(), b.z_m.size()); ++k) {
    EXPECT_EQ(std::isfinite(a.z_m[k]), std::isfinite(b.z_m[k])) << k;
    if (!std::isfinite(a.z_m[k])) continue;
    const double by = std::abs(static_cast<double>(a.z_m[k]) - static_cast<double>(b.z_m[k]));
    out.most = std::max(out.most, by);
    out.share = std::max(out.share, by / std::abs(static_cast<double>(a.z_m[k])));
    ++out.values;
  }
  return out;
}

/// What `read` said of a step is refused wherever it is cut short, and with one byte more.
void expect_whole_readings(TiledMap& map, const std::string& reading) {
  const auto refusal = [&](const std::string& bytes) -> std::string {
    try {
      map.join(
          1, [&](std::size_t) { return bytes; }, [](const ChunkSink&) {});
    } catch (const Error& error) {
      return error.what();
    }
    return "taken";
  };
  for (std::size_t k = 0; k < 200; ++k)
    EXPECT_NE(refusal(reading.substr(0, k * reading.size() / 200)), "taken") << k;
  EXPECT_THAT(refusal(reading.substr(0, reading.size() - 1)), HasSubstr("damaged or cut short"));
  EXPECT_THAT(refusal(reading + '\0'), HasSubstr("damaged or cut short"));
}

/// A wavy road of 200 m that bends nowhere, and scans of it.
class Split : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    made_ = new support::TemporaryFolder;
    support::write_wavy_road(made_->path("road.crg"));
    must({"synth", made_->path("road.crg"), "-o", made_->path("scans"), "--u-begin-m", "20",
          "--u-end-m", "120", "--azimuths", "64", "--beams", "32", "--v-m", "-1", "1"});
  }
  static void TearDownTestSuite() { delete made_, made_ = nullptr; }
  Split() {
    std::filesystem::copy(made_->path("."), folder_.path("."),
                          std::filesystem::copy_options::recursive);
    split();
  }
  Words command(const std::string& to, const Words& more = {}, const char* tiles = "3") const {
    Words words{"split", scans_,    "--trajectory", poses_, "--road",
                road_,   "--tiles", tiles,          "-o",   to};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  void split(const Words& more = {}) const { must(command(tiles_, more)); }
  /// What one step says, with the exit code of a failure.
  static std::string refusal(const Words& words, int code = 1) {
    const support::ToolRun ran = lidar2mesh(words);
    EXPECT_EQ(ran.code, code) << ran.err;
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
    return ran.err;
  }

  static inline const support::TemporaryFolder* made_ = nullptr;  ///< a road and its scans
  const support::TemporaryFolder folder_;
  const std::string road_ = folder_.path("road.crg"), scans_ = folder_.path("scans"),
                    poses_ = folder_.path("scans/trajectory.csv"), tiles_ = folder_.path("tiles");
};

using SlowSplit = Split;

// Wanted are 0.1 mm, 1 mm and 5 %. Measured on 2026-11-25: drift to the last digit, heights within
// one unit in the last place of their float32 (0.5 um), deviations within 0.02 %: what is left is
// the order in which float32 sums are made.
TEST(SlowMapTiles, EightMakeWhatTheWholeMakes) {
  const support::TemporaryFolder folder;
  const std::string scans = folder.path("scans"), tiles = folder.path("tiles"),
                    whole = folder.path("whole"), joined = folder.path("joined");
  must({"synth", places::source() + "/tracks/kerbstone-ring/circuit.yaml", "-o", scans,
        "--u-begin-m", "180", "--u-end-m", "380", "--azimuths", "128", "--grass-m", "0.03",
        "--scenery-m", "12"});
  must({"map", scans, "--trajectory", scans + "/trajectory.csv", "--road", scans + "/base.crg",
        "--no-report", "-o", whole});
  must({"split", scans, "--trajectory", scans + "/trajectory.csv", "--road", scans + "/base.crg",
        "-o", tiles});
  for (int step = 1; step <= kTileSteps; ++step) {
    read_tiles(tiles, step, 8);
    if (step < kTileSteps) merge(tiles, step);
  }
  must({"merge", tiles, "--step", "4", "--no-report", "-o", joined});

  const json a = base::parse_json<json>(folder.read("whole/summary.json")),
             b = base::parse_json<json>(folder.read("joined/summary.json"));
  EXPECT_EQ(a["inputs"], b["inputs"]);
  for (const char* part : {"points", "registration", "drift", "remarks", "faults"})
    EXPECT_EQ(a[part], b[part]) << part;
  EXPECT_EQ(folder.read("whole/trajectory.csv"), folder.read("joined/trajectory.csv"));
  EXPECT_EQ(folder.read("whole/refined.provenance.crg"),
            folder.read("joined/refined.provenance.crg"));
  const Apart heights = apart(whole + "/refined.crg", joined + "/refined.crg"),
              sigmas = apart(whole + "/refined.stddev.crg", joined + "/refined.stddev.crg");
  EXPECT_LT(heights.most, 2e-6);
  EXPECT_LT(sigmas.share, 1e-3);

  // There was something to be equal about.
  EXPECT_GT(heights.values, 500000u);
  EXPECT_GT(a["grid"]["from_points"], 200000);
  EXPECT_GT(a["registration"]["left_out_nodes"], 5000);
  EXPECT_GT(a["registration"]["rms_before_m"], 0.01);
  EXPECT_LT(a["registration"]["rms_after_m"], 0.003);
  double most_drift_m = 0.0;
  for (const json& at : a["drift"])
    most_drift_m = std::max(most_drift_m, std::abs(at["y_m"].get<double>()));
  EXPECT_GT(most_drift_m, 0.02);
  // No tile has the whole.
  const json cut = base::parse_json<json>(folder.read("tiles/split.json"));
  ASSERT_EQ(cut["tiles"].size(), 8u);
  for (const json& tile : cut["tiles"]) {
    EXPECT_GT(tile["looked_at"]["points"], cut["points"].get<double>() / 32.0);
    EXPECT_LT(tile["looked_at"]["points"], cut["points"].get<double>() / 8.0);
  }
}

TEST_F(Split, ThreadsDoNotMatterAndAThirdLookIsMadeWhereItIsWanted) {
  const std::string other = folder_.path("other");
  must(command(other));
  for (int step = 1; step <= kTileSteps; ++step) {
    read_tiles(tiles_, step, 3, "1"), read_tiles(other, step, 3, "3");
    for (int tile = 1; tile <= 3; ++tile) {
      const std::string name = "step-" + std::to_string(step) + ".tile-" + std::to_string(tile);
      EXPECT_EQ(folder_.read("tiles/" + name), folder_.read("other/" + name)) << name;
    }
    if (step == kTileSteps) break;
    merge(tiles_, step, "1"), merge(other, step, "3");
    const std::string name = "step-" + std::to_string(step) + ".joined";
    EXPECT_EQ(folder_.read("tiles/" + name), folder_.read("other/" + name)) << name;
  }
  // The base is right, and poses are not turned back: nothing was read.
  EXPECT_LT(folder_.read("tiles/step-3.tile-1").size(), 500u);
  EXPECT_GT(folder_.read("tiles/step-2.tile-1").size(), 50000u);
  must({"merge", tiles_, "--step", "4", "--no-report", "-o", folder_.path("joined")});
  must({"map", scans_, "--trajectory", poses_, "--road", road_, "--no-report", "-o",
        folder_.path("whole")});
  EXPECT_LT(apart(folder_.path("whole/refined.crg"), folder_.path("joined/refined.crg")).most,
            1e-6);
  const json said = base::parse_json<json>(folder_.read("joined/summary.json"));
  EXPECT_EQ(said["registration"],
            base::parse_json<json>(folder_.read("whole/summary.json"))["registration"]);
  EXPECT_EQ(said["options"]["tiles"], 3);
}

// Files of two scanners that drove at the same time: the road is gone over twice, and the means of
// each 5 m are made once per file, in tiles of 10 m as in the whole.
TEST_F(SlowSplit, TwoScannersAreAsInTheWhole) {
  std::filesystem::create_directory(folder_.path("two"));
  const Cloud scan = read_cloud(scans_ + "/scan_000.ply");
  for (const std::size_t which : {0u, 1u}) {
    Cloud part;
    for (std::size_t k = which; k < scan.size(); k += 2)
      part.x_m.push_back(scan.x_m[k]), part.y_m.push_back(scan.y_m[k]),
          part.z_m.push_back(scan.z_m[k]), part.time_s.push_back(scan.time_s[k]);
    write_cloud(part, folder_.path("two/scanner" + std::to_string(which) + ".ply"));
  }
  const std::string tiles = folder_.path("ten");
  must({"map", folder_.path("two"), "--trajectory", poses_, "--road", road_, "--no-report", "-o",
        folder_.path("whole")});
  must({"split", folder_.path("two"), "--trajectory", poses_, "--road", road_, "--tiles", "10",
        "-o", tiles});
  for (int step = 1; step <= kTileSteps; ++step) {
    read_tiles(tiles, step, 10);
    if (step < kTileSteps) merge(tiles, step);
  }
  must({"merge", tiles, "--step", "4", "--no-report", "-o", folder_.path("joined")});
  const json whole = base::parse_json<json>(folder_.read("whole/summary.json")),
             joined = base::parse_json<json>(folder_.read("joined/summary.json"));
  for (const char* part : {"points", "registration", "drift"})
    EXPECT_EQ(whole[part], joined[part]) << part;
  EXPECT_LT(apart(folder_.path("whole/refined.crg"), folder_.path("joined/refined.crg")).most,
            2e-6);
}

TEST_F(Split, ReadingsAreTakenWholeOrNotAtAll) {
  const crg::Crg road = crg::read(road_);
  const Trajectory poses = read_trajectory(poses_);
  const CloudSource scans = [&](const ChunkSink& sink) {
    TileCut whole(road, poses, 1);
    read_chunks(scans_ + "/scan_000.ply", {}, [&](Cloud&& chunk) {
      chunk.classification.clear();
      for (const double time_s : chunk.time_s)
        chunk.classification.push_back(whole.next(time_s, true).visit);
      sink(std::move(chunk));
    });
  };
  std::string state;
  for (int step = 1; step <= kTileSteps; ++step) {
    TiledMap map(road, poses, {}, state);
    const std::string reading = map.read(scans, scans);
    if (map.due()) expect_whole_readings(map, reading);
    const MapResult result = map.join(
        1, [&](std::size_t) { return std::string(reading); }, scans);
    state = map.state();
    EXPECT_THROW(TiledMap(road, poses, {}, state.substr(0, state.size() - 1)), Error);
    EXPECT_EQ(result.report.left_out_nodes > 1000, step == kTileSteps);
  }
}

TEST_F(Split, MissingTilesAreNamed) {
  read_tiles(tiles_, 1, 3);
  std::filesystem::remove(tiles_ + "/step-1.tile-1");
  std::filesystem::remove(tiles_ + "/step-1.tile-3");
  EXPECT_THAT(refusal({"merge", tiles_, "--step", "1"}),
              HasSubstr("tiles 1, 3 of 3 missing in step 1; run 'lidar2mesh map-tile " + tiles_ +
                        " --step 1 --tile 1' first"));
  EXPECT_THAT(
      refusal({"map-tile", tiles_, "--step", "2", "--tile", "1"}),
      HasSubstr("step-1.joined: missing; run 'lidar2mesh merge " + tiles_ + " --step 1' first"));
  std::filesystem::remove(tiles_ + "/tile-2.looked-at-0.ply");
  EXPECT_THAT(refusal({"map-tile", tiles_, "--step", "1", "--tile", "2"}),
              HasSubstr("tile-2.looked-at-0.ply"));
}

TEST_F(Split, PointsThatWereMovedAreRefused) {
  const std::string name = "tile-1.looked-at-0.ply",
                    wanted = base::sha256(folder_.read("tiles/" + name));
  std::string text = folder_.read("tiles/" + name);
  const std::size_t head = text.find("end_header\n") + 11;
  ASSERT_THAT(text.substr(0, head),
              HasSubstr("property float x\nproperty float y\nproperty float z"));
  float z_m = 0.0F;  // of the first point
  std::memcpy(&z_m, &text[head + 8], sizeof z_m);
  z_m += 0.03F;
  std::memcpy(&text[head + 8], &z_m, sizeof z_m);
  folder_.file("tiles/" + name, text);
  EXPECT_THAT(refusal({"map-tile", tiles_, "--step", "1", "--tile", "1"}),
              HasSubstr(tiles_ + "/" + name + ": SHA-256 " + base::sha256(text) + " seen, " +
                        wanted + " wanted; run 'lidar2mesh split' again"));
  EXPECT_THAT(refusal({"merge", tiles_, "--step", "1"}), HasSubstr("missing in step 1"));
  std::filesystem::remove(tiles_ + "/manifest.json");
  EXPECT_THAT(refusal({"map-tile", tiles_, "--step", "1", "--tile", "1"}),
              HasSubstr(name + ": not named by manifest.json"));
}

TEST_F(Split, TilesOfAnotherRunAreRefused) {
  const std::string other = folder_.path("other");
  must(command(other, {"--drift-m", "0.06"}));
  read_tiles(tiles_, 1, 3);
  read_tiles(other, 1, 1);
  const std::string mine = tiles_ + "/step-1.tile-1";
  const auto overwrite = std::filesystem::copy_options::overwrite_existing;
  std::filesystem::copy_file(other + "/step-1.tile-1", mine, overwrite);
  EXPECT_THAT(refusal({"merge", tiles_, "--step", "1"}),
              HasSubstr("step-1.tile-1: of another split (other scans, base or options)"));
  EXPECT_FALSE(std::filesystem::exists(tiles_ + "/step-1.joined"));

  std::filesystem::copy_file(tiles_ + "/step-1.tile-2", mine, overwrite);
  EXPECT_THAT(refusal({"merge", tiles_, "--step", "1"}),
              HasSubstr("step-1.tile-1: of another tile: 2 seen, 1 wanted"));

  read_tiles(tiles_, 1, 1);
  merge(tiles_, 1);
  read_tiles(tiles_, 2, 3);
  std::string text = folder_.read("tiles/step-2.tile-2");
  text[text.size() - 1] ^= 1;
  folder_.file("tiles/step-2.tile-2", text);
  EXPECT_THAT(refusal({"merge", tiles_, "--step", "2"}), HasSubstr("step-2.tile-2: damaged"));
  std::filesystem::copy_file(tiles_ + "/step-1.tile-2", tiles_ + "/step-2.tile-2", overwrite);
  EXPECT_THAT(refusal({"merge", tiles_, "--step", "2"}),
              HasSubstr("step-2.tile-2: of another step: 1 seen, 2 wanted"));
  folder_.file("tiles/step-2.tile-2", "something else\n");
  EXPECT_THAT(refusal({"merge", tiles_, "--step", "2"}), HasSubstr("no file of map-tile or merge"));

  std::filesystem::copy_file(scans_ + "/truth_trajectory.csv", tiles_ + "/trajectory.csv",
                             overwrite);
  EXPECT_THAT(refusal({"map-tile", tiles_, "--step", "1", "--tile", "1"}),
              HasSubstr("trajectory.csv: not the file that was split"));
  EXPECT_THAT(refusal({"map-tile", scans_, "--step", "1", "--tile", "1"}),
              HasSubstr("split.json: no such file"));
}

TEST_F(Split, WhatCannotBeMeantIsSaid) {
  EXPECT_THAT(refusal(command(folder_.path("many"), {}, "200")),
              HasSubstr("200 tiles wanted of a drive of 40 pieces of 5 m; 1 to 40 can be made"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path("many")));
  EXPECT_THAT(refusal({"map-tile", tiles_, "--step", "1", "--tile", "4"}, 2),
              HasSubstr("--tile 4 seen;"));
  EXPECT_THAT(refusal({"merge", tiles_, "--step", "4"}, 2), HasSubstr("-o FOLDER is wanted"));
  EXPECT_THAT(refusal({"merge", tiles_, "--step", "1", "-o", folder_.path("out")}, 2),
              HasSubstr("-o is of --step 4"));
}

TEST_F(Split, ATileThatCannotBeWrittenLeavesNothingHalf) {
  read_tiles(tiles_, 1, 1);
  const std::string whole = folder_.read("tiles/step-1.tile-1");
  ASSERT_GT(whole.size(), 60000u);
  std::filesystem::remove(tiles_ + "/step-1.tile-1");
  // Refused by the system while it writes: no file may be larger than 50 kB.
  const auto refused = [&] {
    return std::system(("ulimit -c 0; ulimit -f 50; '" + places::lidar2mesh() + "' map-tile '" +
                        tiles_ + "' --step 1 --tile 1 > '" + folder_.path("out.txt") + "' 2>&1")
                           .c_str());
  };
  EXPECT_NE(refused(), 0);
  EXPECT_FALSE(std::filesystem::exists(tiles_ + "/step-1.tile-1"));
  read_tiles(tiles_, 1, 1);
  EXPECT_EQ(folder_.read("tiles/step-1.tile-1"), whole);
  EXPECT_NE(refused(), 0);
  EXPECT_EQ(folder_.read("tiles/step-1.tile-1"), whole);
  read_tiles(tiles_, 1, 1);
  for (const auto& entry : std::filesystem::directory_iterator(tiles_))
    EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr(".part"))) << "left behind";
}

// Scans that do not fit are refused as map refuses them, with what was tried.
TEST_F(Split, SaysWhatDoesNotFit) {
  Trajectory poses = read_trajectory(poses_);
  for (Eigen::Vector3d& p : poses.position_m) p.z() += 47.0;
  write_trajectory(poses, folder_.path("high.csv"));
  must({"split", scans_, "--trajectory", folder_.path("high.csv"), "--road", road_, "--tiles", "2",
        "-o", folder_.path("high")});
  read_tiles(folder_.path("high"), 1, 2);
  const std::string said = refusal({"merge", folder_.path("high"), "--step", "1"});
  EXPECT_THAT(said, HasSubstr("m above or below the base"));
  EXPECT_THAT(said, HasSubstr("tried with "));
}

}  // namespace map_tiles_test
}  // namespace cloud
