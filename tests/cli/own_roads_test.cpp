// What the tool makes passes the tool's own check: roads of build, synth and from-edges, from every
// track at hand. The recipes and circuits of tracks/ in an ordinary run; all of torcs-data with
// KERBSTONE_ALL_TRACKS=1 (docs/evidence.md).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "support/places.h"
#include "support/run_crgbuild.h"

namespace cli {
namespace own_roads_test {

namespace fs = std::filesystem;

/// Below tracks/ ("tracks/aalborg"), of torcs-data ("torcs/road/alpine-1"), or made here
/// ("stadium/open").
/// What is made in a moment, or all others.
std::vector<std::string> roads(bool gate) {
  std::vector<std::string> names{"stadium/closed", "stadium/open", "stadium/nameless",
                                 "edges/straight", "edges/bend"};
  std::error_code absent;
  for (const auto& entry : fs::directory_iterator(fs::path(places::source()) / "tracks", absent))
    names.push_back("tracks/" + entry.path().filename().string());
  if (std::getenv("KERBSTONE_ALL_TRACKS") != nullptr) {
    for (const char* kind : {"road", "oval"}) {
      for (const auto& entry :
           fs::directory_iterator(fs::path(places::torcs_tracks()) / kind, absent))
        names.push_back(fmt::format("torcs/{}/{}", kind, entry.path().filename().string()));
    }
  }
  std::erase_if(names, [&](const std::string& name) {
    return gate !=
           (name.starts_with("stadium/") || name.starts_with("edges/") || name == "tracks/aalborg");
  });
  std::sort(names.begin(), names.end());
  return names;
}

std::string name_of(const ::testing::TestParamInfo<std::string>& road) {
  std::string name = road.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '-' || c == '/'; }, '_');
  return name;
}

/// The two sides of a road 8 m wide with a half circle of the given radius in it (0: straight).
void write_edges(const Folder& folder, double radius_m) {
  for (const double side : {4.0, -4.0}) {
    std::string csv = "x_m,y_m,z_m\n";
    for (int i = 0; i <= 60; ++i) csv += fmt::format("{},{},{}\n", i - 60.0, side, 0.01 * i);
    if (radius_m > 0.0) {
      for (int i = 1; i <= 60; ++i) {
        const double turn = M_PI * i / 60.0;
        csv += fmt::format("{},{},{}\n", (radius_m - side) * std::sin(turn),
                           radius_m - (radius_m - side) * std::cos(turn), 0.6 + 0.01 * i);
      }
      for (int i = 1; i <= 60; ++i)
        csv += fmt::format("{},{},{}\n", -1.0 * i, 2.0 * radius_m - side, 1.2 + 0.01 * i);
    }
    write(folder / (side > 0.0 ? "left.csv" : "right.csv"), csv);
  }
}

class OwnRoads : public ::testing::TestWithParam<std::string> {};

TEST_P(OwnRoads, PassTheirOwnCheck) {
  const std::string kind = GetParam().substr(0, GetParam().find('/')),
                    name = GetParam().substr(kind.size() + 1);
  const Folder folder;
  const auto build = [&](const std::string& input) {
    const Ran ran = crgbuild({"build", input, "-o", folder / "out", "--no-report"});
    ASSERT_EQ(ran.code, 0) << ran.err;
  };
  if (kind == "stadium") {
    Stadium stadium;
    stadium.closed = name != "open";
    stadium.names = name != "nameless";
    write(folder / "stadium.obj", stadium.obj());
    build(folder / "stadium.obj");
  } else if (kind == "edges") {
    write_edges(folder, name == "bend" ? 5.0 : 0.0);
    const Ran ran =
        crgbuild({"from-edges", folder / "left.csv", folder / "right.csv", "-o", folder / "out"});
    ASSERT_EQ(ran.code, 0) << ran.err;
  } else if (kind == "torcs") {
    const fs::path track = fs::path(places::torcs_tracks()) / name;
    const std::string stem = (track / track.filename()).string();
    build(exists(stem + ".acc") ? stem + ".acc" : stem + ".ac");
  } else {
    const std::string track = fmt::format("{}/tracks/{}", places::source(), name);
    if (exists(track + "/circuit.yaml")) {
      // The recipe of a circuit says where `synth` has put the mesh: out/demo of the folder above
      // tracks/.
      fs::create_directories(folder / "tracks");
      fs::copy(track, fs::path(folder / "tracks/" + name));
      const Ran ran = crgbuild(
          {"synth", folder / "tracks/" + name + "/circuit.yaml", "-o", folder / "out/demo"});
      ASSERT_EQ(ran.code, 0) << ran.err;
      build(folder / "tracks/" + name + "/track.yaml");
    } else {
      if (!exists(fmt::format("{0}/road/{1}/{1}.acc", places::torcs_tracks(), name)))
        GTEST_SKIP() << "the package torcs-data is not installed";
      build(track + "/track.yaml");
    }
  }
  std::size_t checked = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "out")) {
    if (entry.path().extension() != ".crg") continue;
    ++checked;
    const Ran ran = crgbuild({"check", entry.path().string()});
    EXPECT_EQ(ran.code, 0) << ran.out << ran.err;
  }
  EXPECT_GE(checked, exists(folder / "out/demo") ? 2U : 1U);
}

INSTANTIATE_TEST_SUITE_P(, OwnRoads, ::testing::ValuesIn(roads(true)), name_of);
INSTANTIATE_TEST_SUITE_P(Slow, OwnRoads, ::testing::ValuesIn(roads(false)), name_of);

}  // namespace own_roads_test
}  // namespace cli
