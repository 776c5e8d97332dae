// lidar2mesh as it is called.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <set>

#include "base/json_text.h"
#include "cloud/read_cloud.h"
#include "cloud/road_frame.h"
#include "crg/file.h"
#include "nlohmann/json.hpp"
#include "support/places.h"
#include "support/temporary_folder.h"
#include "support/wavy_road.h"

namespace cloud {
namespace command_test {

using ::testing::HasSubstr;

struct Ran {
  int code = -1;
  std::string out, err;
};

/// `before` is shell in front of the program.
Ran lidar2mesh(const support::TemporaryFolder& folder, const std::string& arguments,
               const std::string& before = "") {
  const std::string command = before + " \"" + places::lidar2mesh() + "\" " + arguments + " > '" +
                              folder.path("out.txt") + "' 2> '" + folder.path("err.txt") + "'";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, folder.read("out.txt"),
          folder.read("err.txt")};
}

TEST(SlowCommand, TheMeshItWritesIsABaseForTheNextRun) {
  const support::TemporaryFolder folder;
  support::write_wavy_road(folder.path("road.crg"));
  const auto at = [&](const char* name) { return "'" + folder.path(name) + "'"; };
  Ran ran = lidar2mesh(folder, "synth " + at("road.crg") + " -o " + at("scans") +
                                   " --u-begin-m 20 --u-end-m 180 --azimuths 128 --v-m -1 1");
  ASSERT_EQ(ran.code, 0) << ran.err;
  const std::string scans = at("scans") + " --trajectory " + at("scans/trajectory.csv");
  ran = lidar2mesh(folder, "map " + scans + " --road " + at("road.crg") + " -o " + at("first"));
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto report = base::parse_json<nlohmann::json>(folder.read("first/report.json"));
  ASSERT_EQ(report["extra"].size(), 3u);
  EXPECT_EQ(report["extra"][1]["title"], "The trajectory's drift");
  EXPECT_EQ(report["comparisons"][0]["key"], "against");

  ran = lidar2mesh(folder, "map " + scans + " --road " + at("first/refined.ply") + " -o " +
                               at("second") + " --format stl --no-report");
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_TRUE(std::filesystem::exists(folder.path("second/refined.stl")));
  EXPECT_FALSE(std::filesystem::exists(folder.path("second/refined.ply")));
  const auto summary = base::parse_json<nlohmann::json>(folder.read("second/summary.json"));
  EXPECT_TRUE(summary["registration"]["converged"]);
  EXPECT_LT(summary["registration"]["rms_after_m"], 0.004);
  EXPECT_GT(summary["grid"]["from_points"], 50000);

  ran = lidar2mesh(folder, "map " + scans + " --road " + at("first/refined.ply") +
                               " --unit cm -o " + at("third"));
  EXPECT_EQ(ran.code, 1);
  EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
  EXPECT_FALSE(std::filesystem::exists(folder.path("third/refined.crg")));

  ran = lidar2mesh(folder, "map " + scans + " -o " + at("points_alone") + " --v-max-m 4");
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_GT(crg::read(folder.path("points_alone/refined.crg")).grid.rows(), 1500u);

  // Into the folder of an earlier map: what this one does not make goes, and the set is whole.
  ran = lidar2mesh(folder, "map " + scans + " --road " + at("road.crg") + " -o " + at("first") +
                               " --format stl --no-report");
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_FALSE(std::filesystem::exists(folder.path("first/refined.ply")));
  EXPECT_FALSE(std::filesystem::exists(folder.path("first/report.html")));
  std::set<std::string> listed{"manifest.json"}, there;
  const auto manifest = base::parse_json<nlohmann::json>(folder.read("first/manifest.json"));
  for (const auto& file : manifest["files"]) listed.insert(file["file"].get<std::string>());
  for (const auto& entry : std::filesystem::directory_iterator(folder.path("first")))
    there.insert(entry.path().filename().string());
  EXPECT_EQ(there, listed);
}

TEST(Command, InfoOfAFolderIsOneJsonArray) {
  const support::TemporaryFolder folder;
  std::filesystem::create_directory(folder.path("scans"));
  for (const char* name : {"scans/a.xyz", "scans/b.xyz"}) folder.file(name, "0 0 0\n1 2 3\n");
  const auto info = [&](const char* of) {
    const Ran ran = lidar2mesh(folder, "info '" + folder.path(of) + "' --json");
    EXPECT_EQ(ran.code, 0) << ran.err;
    return base::parse_json<nlohmann::json>(ran.out);
  };
  const auto all = info("scans");
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[1]["path"], folder.path("scans/b.xyz"));
  EXPECT_EQ(all[0], info("scans/a.xyz"));
}

TEST(Command, ADriftThatDoesNotConvergeIsNotValid) {
  const support::TemporaryFolder folder;
  support::write_wavy_road(folder.path("road.crg"));
  const auto at = [&](const char* name) { return "'" + folder.path(name) + "'"; };
  // Few points with 20 cm of noise.
  Ran ran = lidar2mesh(
      folder, "synth " + at("road.crg") + " -o " + at("scans") +
                  " --u-begin-m 40 --u-end-m 80 --azimuths 16 --beams 8 --noise-m 0.2 --cars 0");
  ASSERT_EQ(ran.code, 0) << ran.err;
  for (const char* flag : {"", " --json", " --quiet"}) {
    ran = lidar2mesh(folder, "map " + at("scans") + " --trajectory " + at("scans/trajectory.csv") +
                                 " --road " + at("road.crg") + " --drift-m 1 --drift-rad 0.05 -o " +
                                 at("out") + flag);
    EXPECT_EQ(ran.code, 3) << flag;
    EXPECT_THAT(ran.err, HasSubstr("out/refined.crg: the drift had not converged after ")) << flag;
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
  }
  EXPECT_FALSE(base::parse_json<nlohmann::json>(
      folder.read("out/summary.json"))["registration"]["converged"]);
  const auto report = base::parse_json<nlohmann::json>(folder.read("out/report.json"));
  EXPECT_EQ(report["verdict"], "not_usable");
  EXPECT_EQ(report["findings"][0]["kind"], "registration");
  EXPECT_THAT(report["findings"][1]["text"].get<std::string>(), HasSubstr("tried with "));
}

TEST(Command, AFullDiskLeavesNoHalfFile) {
  const support::TemporaryFolder folder;
  support::write_wavy_road(folder.path("road.crg"));
  const auto at = [&](const char* name) { return "'" + folder.path(name) + "'"; };
  Ran ran = lidar2mesh(folder, "synth " + at("road.crg") + " -o " + at("scans") +
                                   " --laps 1 --u-begin-m 20 --u-end-m 80 --azimuths 64");
  ASSERT_EQ(ran.code, 0) << ran.err;
  // Files of more than 64 KB are refused by the system as on a full disk.
  ran = lidar2mesh(folder,
                   "map " + at("scans") + " --trajectory " + at("scans/trajectory.csv") +
                       " --road " + at("road.crg") + " -o " + at("out"),
                   "ulimit -f 64;");
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.err, HasSubstr("refined.crg"));
  EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
  EXPECT_FALSE(std::filesystem::exists(folder.path("out"))) << "something was left behind";
}

/// The long options that a command's help tells of, less those that have no bearing on results.
std::set<std::string> options_of(const support::TemporaryFolder& folder,
                                 const std::string& command) {
  const std::string help = lidar2mesh(folder, command + " --help").out;
  std::set<std::string> options;
  for (std::size_t at = help.find("--"); at != std::string::npos; at = help.find("--", at + 2)) {
    const std::size_t end = help.find_first_not_of("abcdefghijklmnopqrstuvwxyz-", at + 2);
    options.insert(help.substr(at + 2, end - at - 2));
  }
  for (const char* other : {"help", "quiet", "json", "version", "threads", "output", "road",
                            "centreline", "trajectory"})
    options.erase(other);
  return options;
}

TEST(Command, OutputsNameWhatTheyRestOn) {
  const support::TemporaryFolder folder;
  support::write_wavy_road(folder.path("road.crg"));
  const auto at = [&](const char* name) { return "'" + folder.path(name) + "'"; };
  Ran ran = lidar2mesh(folder, "synth " + at("road.crg") + " -o " + at("scans") +
                                   " --u-end-m 40 --azimuths 64 --laps 1 --json");
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto made = base::parse_json<nlohmann::json>(ran.out);
  const auto hash = [&](const std::string& name) {
    EXPECT_EQ(std::system(("sha256sum '" + folder.path(name) + "' > " + at("hash.txt")).c_str()),
              0);
    return folder.read("hash.txt").substr(0, 64);
  };
  const auto expect_inputs = [&](const nlohmann::json& summary,
                                 std::vector<std::pair<std::string, std::string>> role_and_name) {
    ASSERT_EQ(summary["inputs"].size(), role_and_name.size()) << summary["inputs"];
    for (std::size_t k = 0; k < role_and_name.size(); ++k) {
      EXPECT_EQ(summary["inputs"][k]["role"], role_and_name[k].first);
      EXPECT_EQ(summary["inputs"][k]["path"], folder.path(role_and_name[k].second));
      EXPECT_EQ(summary["inputs"][k]["sha256"], hash(role_and_name[k].second));
    }
  };
  const auto expect_options = [&](const nlohmann::json& summary, const std::string& command) {
    std::set<std::string> named;
    for (const auto& [name, value] : summary["options"].items()) named.insert(name);
    // Those that no help shows are named as well.
    EXPECT_THAT(named, ::testing::IsSupersetOf(options_of(folder, command))) << command;
    EXPECT_THAT(summary["program"].get<std::string>(), ::testing::StartsWith("lidar2mesh "));
  };
  expect_inputs(made, {{"road", "road.crg"}});
  expect_options(made, "synth");
  EXPECT_EQ(made["options"]["v-m"], nlohmann::json());
  EXPECT_EQ(made["options"]["azimuths"], 64);
  EXPECT_EQ(made["options"]["noise-m"], 0.005);

  ran = lidar2mesh(folder, "map " + at("scans") + " --trajectory " + at("scans/trajectory.csv") +
                               " --road " + at("road.crg") + " --gate-m 0.4 -o " + at("out"));
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto summary = base::parse_json<nlohmann::json>(folder.read("out/summary.json"));
  expect_inputs(summary, {{"scan", "scans/scan_000.ply"},
                          {"trajectory", "scans/trajectory.csv"},
                          {"base", "road.crg"}});
  expect_options(summary, "map");
  EXPECT_EQ(summary["options"]["gate-m"], 0.4);
  EXPECT_EQ(summary["options"]["base-stddev-m"], 0.02);
  EXPECT_EQ(summary["options"]["no-report"], false);
  const auto page = base::parse_json<nlohmann::json>(folder.read("out/report.json"));
  EXPECT_THAT(base::dump_json(page["inputs"]), HasSubstr(hash("scans/scan_000.ply")));

  ran = lidar2mesh(folder, "ground " + at("scans/scan_000.ply") + " -o " + at("g.ply") + " --json");
  ASSERT_EQ(ran.code, 0) << ran.err;
  expect_inputs(base::parse_json<nlohmann::json>(ran.out), {{"cloud", "scans/scan_000.ply"}});
  expect_options(base::parse_json<nlohmann::json>(ran.out), "ground");
  EXPECT_THAT(folder.read("g.ply").substr(0, 1000),
              HasSubstr("\ncomment input cloud " + hash("scans/scan_000.ply") + " "));
  EXPECT_THAT(folder.read("g.ply").substr(0, 1000),
              HasSubstr("\ncomment options {\"doubles\":false,\"unit\":null,"
                        "\"method\":\"own\",\"cell-m\":1"));
  ran = lidar2mesh(folder, "register " + at("g.ply") + " " + at("scans/scan_000.ply") + " --json");
  ASSERT_EQ(ran.code, 0) << ran.err;
  expect_inputs(base::parse_json<nlohmann::json>(ran.out),
                {{"target", "g.ply"}, {"source", "scans/scan_000.ply"}});
  expect_options(base::parse_json<nlohmann::json>(ran.out), "register");
}

TEST(Command, RangePointsAndNodesAreAsTold) {
  const support::TemporaryFolder folder;
  support::write_wavy_road(folder.path("road.crg"));
  const auto at = [&](const char* name) { return "'" + folder.path(name) + "'"; };
  Ran ran = lidar2mesh(folder, "synth " + at("road.crg") + " -o " + at("scans") +
                                   " --u-end-m 40 --azimuths 64 --laps 1");
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto mapped = [&](const std::string& options) {
    ran = lidar2mesh(folder, "map " + at("scans") + " --trajectory " + at("scans/trajectory.csv") +
                                 " --no-report -o " + at("out") + " " + options);
    EXPECT_EQ(ran.code, 0) << ran.err;
    return base::parse_json<nlohmann::json>(folder.read("out/summary.json"));
  };
  const std::string base = "--road " + at("road.crg");
  const auto all = mapped(base), near = mapped(base + " --max-range-m 10");
  EXPECT_EQ(near["options"]["max-range-m"], 10);
  std::size_t within = 0;
  const Cloud scan = read_cloud(folder.path("scans/scan_000.ply"));
  for (std::size_t i = 0; i < scan.size(); ++i)
    within += (scan.origin_m + scan.point(i)).norm() <= 10.0;
  EXPECT_LT(within, scan.size());
  EXPECT_EQ(near["points"]["read"], within);
  EXPECT_EQ(all["points"]["read"], scan.size());
  const auto many = mapped(base + " --min-points 8");
  EXPECT_LT(many["grid"]["from_points"], 0.8 * all["grid"]["from_points"].get<double>());
  const auto coarse = mapped("--step-m 0.2 --v-max-m 4"), fine = mapped("--step-m 0.1 --v-max-m 4");
  EXPECT_NEAR(fine["grid"]["nodes"].get<double>() / coarse["grid"]["nodes"].get<double>(), 4.0,
              0.2);
  ran = lidar2mesh(
      folder, "map " + at("scans") + " --frame map " + base + " --max-range-m 10 -o " + at("out"));
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.err, HasSubstr("--max-range-m wants points in the sensor's frame"));
}

TEST(Command, NothingIsGrassUpToTheEdgeThatIsStatedOrAnywhere) {
  const support::TemporaryFolder folder;
  support::write_wavy_road(folder.path("road.crg"));
  const auto at = [&](const char* name) { return "'" + folder.path(name) + "'"; };
  ScanSynthOptions scanned;
  scanned.u_end_m = 40.0, scanned.azimuths = 128, scanned.laps = 1;
  scanned.grass_height_m = 0.05, scanned.grass_from_m = 3.0;
  synth_scans(crg::read(folder.path("road.crg")), folder.path("scans"), scanned);
  const auto on_grass = [&](const std::string& options) {
    const Ran ran = lidar2mesh(
        folder, "map " + at("scans") + " --trajectory " + at("scans/trajectory.csv") + " --road " +
                    at("road.crg") + " --no-report -o " + at("out") + " " + options);
    EXPECT_NE(ran.code, 1) << ran.err;
    return base::parse_json<nlohmann::json>(folder.read("out/summary.json"))["points"]["on_grass"]
        .get<std::size_t>();
  };
  const std::size_t all = on_grass(""), beyond = on_grass("--edge-m 4");
  EXPECT_GT(beyond, 0u);
  EXPECT_LT(beyond, all);
  EXPECT_EQ(on_grass("--no-grass"), 0u);
}

TEST(Command, TheDemoMendsARoad) {
  const support::TemporaryFolder folder;
  const auto at = [&](const char* name) { return "'" + folder.path(name) + "'"; };
  Ran ran = lidar2mesh(
      folder, "synth '" + places::source() + "/tracks/kerbstone-ring/circuit.yaml' -o " +
                  at("scans") +
                  " --u-begin-m 290 --u-end-m 370 --azimuths 128 --grass-m 0.03 --scenery-m 12");
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("base.crg: no kerbs, no bumps"));
  ran = lidar2mesh(folder, "map " + at("scans") + " --trajectory " + at("scans/trajectory.csv") +
                               " --road " + at("scans/base.crg") + " --no-report -o " + at("out"));
  ASSERT_EQ(ran.code, 0) << ran.err << ran.out;
  const crg::Crg truth = crg::read(folder.path("scans/truth.crg")),
                 base = crg::read(folder.path("scans/base.crg")),
                 refined = crg::read(folder.path("out/refined.crg")),
                 source = crg::read(folder.path("out/refined.provenance.crg"));
  const RoadFrame wanted(truth), before(base), after(refined), how(source);
  ASSERT_EQ(wanted.rows(), after.rows());
  ASSERT_EQ(wanted.columns(), after.columns());
  double count = 0.0, base2 = 0.0, refined2 = 0.0, kerb_m = 0.0;
  for (std::size_t i = 0; i < wanted.rows(); ++i)
    for (std::size_t j = 0; j < wanted.columns(); ++j) {
      if (how.node(i, j) != 2.0f || std::abs(wanted.v_m()[j]) > 7.0) continue;
      const double z = wanted.node(i, j) + wanted.z_origin_m(),
                   old = before.node(i, j) + before.z_origin_m() - z;
      count += 1.0, base2 += old * old;
      kerb_m = std::max(kerb_m, -old);
      refined2 += std::pow(after.node(i, j) + after.z_origin_m() - z, 2);
    }
  std::printf("base rms %.1f mm, refined %.2f mm\n", 1e3 * std::sqrt(base2 / count),
              1e3 * std::sqrt(refined2 / count));
  EXPECT_GT(count, 50000.0);
  EXPECT_GT(kerb_m, 0.04);  // kerbs of 50 and 60 mm are missing
  EXPECT_GT(std::sqrt(base2 / count), 0.015);
  EXPECT_LT(std::sqrt(refined2 / count), 0.002);
}

TEST(Command, SaysWhatIsMissing) {
  const support::TemporaryFolder folder;
  folder.file("survey.laz", "LASF");
  const std::string laz = "'" + folder.path("survey.laz") + "'";
  Ran ran = lidar2mesh(folder, "info " + laz);
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.err, HasSubstr("LAS header truncated: 4 bytes seen"));
  folder.file("points.xyz", "0 0 0\n1 0 0\n");
  ran = lidar2mesh(folder, "map '" + folder.path("points.xyz") + "' -o '" + folder.path("o") + "'");
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.err, HasSubstr("--centreline"));
  // A line beside the cloud, which its outermost points still touch.
  std::string cloud, line = "x_m,y_m,z_m,half_width_m\n";
  for (int i = 0; i < 20000; ++i)
    cloud += std::to_string(0.5 * (i % 200)) + "," + std::to_string(0.2 * (i / 200)) + ",0\n";
  for (int i = 0; i < 60; ++i) line += std::to_string(2 * i) + ",-9.7,0,5\n";
  ran = lidar2mesh(folder, "grid '" + folder.file("c.xyz", cloud) + "' --centreline '" +
                               folder.file("line.csv", line) + "' -o '" + folder.path("beside") +
                               "' --no-report");
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.err, HasSubstr("lies beside the cloud"));
  EXPECT_FALSE(std::filesystem::exists(folder.path("beside/refined.crg")));
}

}  // namespace command_test
}  // namespace cloud
