// The recipes of real tracks, where the package torcs-data is installed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/places.h"
#include "support/run_crgbuild.h"

namespace cli {
namespace {

struct Track {
  const char* name;
  double designed_length_m;
};

class RealTracks : public ::testing::TestWithParam<Track> {};

TEST_P(RealTracks, RecipeBuildsTheTrackAsDesigned) {
  const Track& track = GetParam();
  if (!exists(fmt::format("{0}/road/{1}/{1}.acc", places::torcs_tracks(), track.name)))
    GTEST_SKIP() << "the package torcs-data is not installed";
  const Folder folder;
  const Ran ran =
      crgbuild({"build", fmt::format("{}/tracks/{}/track.yaml", places::source(), track.name), "-o",
                folder / "out", "--json"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto s = nlohmann::json::parse(ran.out);
  EXPECT_NEAR(s["reference_line"]["length_m"], track.designed_length_m,
              5e-4 * track.designed_length_m);
  EXPECT_EQ(s["reference_line"]["closed"], true);
  EXPECT_TRUE(s["validation"]["passed"]);
  EXPECT_LE(s["validation"]["z_error_m"]["p99"].get<double>(), 0.0015);
  const auto timing = nlohmann::json::parse(read(folder / "out/timing.json"));
  EXPECT_LE(timing["peak_memory_mb"].get<double>(), 500.0);
  // No bound on time here: other tests run at the same moment. docs/performance.md has the figures.
  fmt::print("{}: {:.3f} m, {} nodes, {:.2f} s, {:.0f} MB\n", track.name,
             s["reference_line"]["length_m"].get<double>(), s["grid"]["nodes"].get<std::size_t>(),
             timing["seconds"]["total"].get<double>(), timing["peak_memory_mb"].get<double>());
}

INSTANTIATE_TEST_SUITE_P(, RealTracks,
                         ::testing::Values(Track{"g-track-1", 2057.56}, Track{"e-track-3", 4208.36},
                                           Track{"aalborg", 2587.55}),
                         [](const auto& track) {
                           std::string name = track.param.name;
                           for (char& c : name)
                             if (c == '-') c = '_';
                           return name;
                         });

}  // namespace
}  // namespace cli
