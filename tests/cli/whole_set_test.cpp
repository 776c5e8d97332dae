// The files of one build belong together: after two builds at once, after a change of anything that
// was read. KERBSTONE_HEAVY=1 for 50 pairs (docs/evidence.md). After a kill:
// tests/command/whole_sets_test.cpp.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/json_text.h"
#include "support/mesh_files.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace cli {
namespace whole_set_test {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::HasSubstr;

bool heavy() { return std::getenv("KERBSTONE_HEAVY") != nullptr; }

using Files = std::map<std::string, std::string>;

/// Every file of a folder, hidden ones too, but for what differs from run to run.
Files files_in(const std::string& folder) {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    files[fs::relative(entry.path(), folder).string()] =
        entry.is_regular_file() ? read(entry.path()) : "no file";
  EXPECT_EQ(files.erase("timing.json"), 1u);
  return files;
}

std::string names_of(const Files& files) {
  std::string names;
  for (const auto& [name, bytes] : files) names += name + " ";
  return names;
}

/// Equal byte for byte; which file is not.
void expect_same(const Files& seen, const Files& wanted, const std::string& what) {
  EXPECT_EQ(names_of(seen), names_of(wanted)) << what;
  for (const auto& [name, bytes] : wanted) {
    const auto found = seen.find(name);
    EXPECT_TRUE(found == seen.end() || found->second == bytes)
        << what << ": " << name << " differs";
  }
}

/// Two builds of one name into one folder that share no byte of road or report.
class Two : public ::testing::Test {
 protected:
  Two() {
    road::Mesh mesh = support::small_road();
    write(folder_ / "a.obj", support::as_obj(mesh));
    for (auto& v : mesh.vertices_m) v.z() *= 1.5;
    write(folder_ / "b.obj", support::as_obj(mesh));
    for (const char* mesh_name : {"a", "b"}) {
      const auto start = std::chrono::steady_clock::now();
      const Ran ran = crgbuild(command(mesh_name));
      seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      EXPECT_EQ(ran.code, 0) << ran.err;
      undisturbed_[mesh_name] = files_in(out());
      fs::remove_all(out());
    }
  }
  /// Only the first has a map of friction, which the second must not inherit.
  std::vector<std::string> command(const std::string& mesh) const {
    std::vector<std::string> words{"build",      folder_ / (mesh + ".obj"),
                                   "-o",         out(),
                                   "--name",     "road",
                                   "--up",       "z",
                                   "--unit",     "m",
                                   "--u-step-m", "0.5",
                                   "--v-step-m", "0.5"};
    if (mesh == "a") words.insert(words.end(), {"--friction"});
    return words;
  }
  std::string out() const { return folder_ / "out"; }

  Folder folder_;
  std::map<std::string, Files> undisturbed_;
  double seconds_ = 0.0;  ///< of one build
};

TEST_F(Two, BuildsAtOnceIntoOneFolderLeaveOneSetOrAreRefused) {
  const int pairs = heavy() ? 50 : 2;
  int refused = 0;
  for (int pair = 0; pair < pairs; ++pair) {
    Ran a, b;
    {
      const std::jthread other([&] { a = crgbuild(command("a")); });
      if (pair % 2 == 1)
        std::this_thread::sleep_for(std::chrono::duration<double>(seconds_ * pair / pairs));
      b = crgbuild(command("b"));
    }
    for (const Ran* ran : {&a, &b}) {
      if (ran->code == 0) continue;
      ++refused;
      EXPECT_EQ(ran->code, 1) << ran->err;
      EXPECT_THAT(ran->err, HasSubstr("is writing into this folder"));
      EXPECT_EQ(std::count(ran->err.begin(), ran->err.end(), '\n'), 1) << ran->err;
      EXPECT_EQ(ran->out, "");
    }
    ASSERT_TRUE(a.code == 0 || b.code == 0) << a.err << b.err;
    const Files seen = files_in(out());
    const bool is_a = seen.at("road.crg") == undisturbed_["a"].at("road.crg");
    EXPECT_EQ((is_a ? a : b).code, 0);
    expect_same(seen, undisturbed_[is_a ? "a" : "b"], fmt::format("pair {}", pair));
    if (HasFailure()) return;
  }
  std::printf("%d pairs: %d builds refused, one whole set each time\n", pairs, refused);
}

TEST_F(Two, NothingMadeByHandIsTakenForTheResult) {
  const auto reused = [&] {
    const Ran ran = crgbuild(command("a"));
    EXPECT_EQ(ran.code, 0) << ran.err;
    return ran.out.find("reused: nothing has changed") != std::string::npos;
  };
  EXPECT_FALSE(reused());
  EXPECT_TRUE(reused());
  for (const auto& [name, bytes] : undisturbed_["a"]) {
    if (!heavy() && name != "road.crg" && name != "report.html" && name != "manifest.json")
      continue;  // a build each
    write(folder_ / ("out/" + name), bytes + " ");
    EXPECT_FALSE(reused()) << name << " was edited";
    expect_same(files_in(out()), undisturbed_["a"], name);
  }
  for (const char* name : {"report.html", "road.classes.pgw", "manifest.json"}) {
    if (!heavy() && name != std::string("road.classes.pgw")) continue;
    fs::remove(folder_ / (std::string("out/") + name));
    EXPECT_FALSE(reused()) << name << " was removed";
    expect_same(files_in(out()), undisturbed_["a"], name);
  }
  EXPECT_TRUE(reused());
}

TEST(WholeSet, WhateverTheMeshRefersToIsBuiltAgainWhenItChanges) {
  const Folder folder;
  road::Mesh mesh = support::small_road();
  const auto flat = support::as_gltf(mesh, "road.bin");
  for (auto& v : mesh.vertices_m) v.z() *= 3.0;
  const auto steep = support::as_gltf(mesh, "road.bin");
  ASSERT_TRUE(flat.gltf == steep.gltf && flat.bin.size() == steep.bin.size());
  write(folder / "road.gltf", flat.gltf);
  write(folder / "road.bin", flat.bin);
  const std::vector<std::string> command{
      "build",      folder / "road.gltf", "-o",  folder / "out", "--u-step-m",
      "0.5",        "--v-step-m",         "0.5", "--unit",       "m",
      "--no-report"};
  const auto highest_m = [&](bool expect_reused) {
    const Ran ran = crgbuild(command);
    EXPECT_EQ(ran.code, 0) << ran.err;
    EXPECT_EQ(ran.out.find("reused") != std::string::npos, expect_reused) << ran.out;
    return base::parse_json<Json>(read(folder / "out/summary.json"))["grid"]["z_max_m"]
        .get<double>();
  };
  const double before_m = highest_m(false);
  EXPECT_EQ(highest_m(true), before_m);
  write(folder / "road.bin", steep.bin);
  EXPECT_NEAR(highest_m(false), 3.0 * before_m, 0.01);
  highest_m(true);
}

TEST(WholeSet, AMaterialFileThatAppearsCountsAsAChange) {
  const Folder folder;
  write(folder / "road.obj", "mtllib road.mtl\n" + support::as_obj(support::small_road()));
  const std::vector<std::string> command{"build",      folder / "road.obj",
                                         "-o",         folder / "out",
                                         "--u-step-m", "0.5",
                                         "--v-step-m", "0.5",
                                         "--up",       "z",
                                         "--unit",     "m",
                                         "--no-report"};
  const auto reused = [&] {
    const Ran ran = crgbuild(command);
    EXPECT_EQ(ran.code, 0) << ran.err;
    return ran.out.find("reused") != std::string::npos;
  };
  EXPECT_FALSE(reused());
  EXPECT_TRUE(reused());
  write(folder / "road.mtl", "newmtl asphalt\nKd 0.3 0.3 0.3\nnewmtl concrete\n");
  EXPECT_FALSE(reused());
  EXPECT_TRUE(reused());
  fs::remove(folder / "road.mtl");
  EXPECT_FALSE(reused());
}

TEST(WholeSet, AFolderThatCannotBeWrittenIsRefusedBeforeTheWork) {
  const Folder folder;
  write(folder / "file", "x");
  // The mesh is missing too: what is wrong with -o is said first where it is looked at first.
  write(folder / "road.obj", support::as_obj(support::small_road()));
  for (const std::string& out :
       {folder / "file", folder / "file/below", std::string("/proc/kerbstone")}) {
    const Ran ran = crgbuild({"build", folder / "road.obj", "-o", out});
    EXPECT_EQ(ran.code, 1) << out;
    EXPECT_THAT(ran.err, HasSubstr(out));
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
  }
  EXPECT_EQ(read(folder / "file"), "x");
}

TEST_F(Two, NoReaderTakesFilesOfTwoRuns) {
  ASSERT_EQ(crgbuild(command("a")).code, 0);
  write(folder_ / "points.csv", "u_m,v_m\n1,0\n");
  const std::string road = out() + "/road.crg";
  const std::string car = places::source() + "/vehicles/open_wheel/vehicle.yaml";
  const std::vector<std::pair<std::string, std::vector<std::string>>> readers{
      {places::crgbuild(), {"info", road}},
      {places::crgbuild(),
       {"query", road, "--points", folder_ / "points.csv", "-o", folder_ / "z.csv"}},
      {places::crgbuild(), {"report", road, "-o", folder_ / "report"}},
      {places::crgbuild(), {"crop", road, "--u-end-m", "5", "-o", folder_ / "crop.crg"}},
      {places::crgdrive(), {"timing", "--car", car, "--road", road, "--stop-s", "0.01"}},
      {places::crgdrive(), {"fmu", car, "--road", road, "-o", folder_ / "car.fmu"}},
      {places::lidar2mesh(),
       {"grid", folder_ / "a.obj", "--road", road, "-o", folder_ / "refined"}}};
  const auto expect_refused = [&](const std::string& why) {
    for (const auto& [program, words] : readers) {
      const support::ToolRun ran = support::run_tool(program, words);
      EXPECT_EQ(ran.code, 1) << words[0];
      EXPECT_THAT(ran.err, HasSubstr(why)) << words[0];
      EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
    }
  };
  EXPECT_EQ(crgbuild(readers[0].second).code, 0);
  EXPECT_EQ(crgbuild(readers[1].second).code, 0);
  // An older road under a newer manifest.
  write(road, undisturbed_["b"].at("road.crg"));
  expect_refused("road.crg: SHA-256 ");
  write(road, undisturbed_["a"].at("road.crg"));
  // As a run that is killed while it moves its files in leaves it.
  std::string manifest = read(out() + "/manifest.json");
  const std::string whole = "\"complete\": true";
  ASSERT_NE(manifest.find(whole), std::string::npos);
  write(out() + "/manifest.json",
        manifest.replace(manifest.find(whole), whole.size(), "\"complete\": false"));
  expect_refused("manifest.json: 'complete' is false: 'crgbuild build' was killed");
  EXPECT_EQ(crgbuild(command("a")).code, 0);
  EXPECT_EQ(crgbuild(readers[0].second).code, 0);
}

}  // namespace whole_set_test
}  // namespace cli
