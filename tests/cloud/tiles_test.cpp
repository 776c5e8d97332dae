#include "cloud/tiles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <unordered_map>

#include "base/json_text.h"
#include "cloud/error.h"
#include "cloud/read_cloud.h"
#include "cloud/write_surface.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace cloud {
namespace tiles_test {

using ::testing::HasSubstr;

/// A wavy road of 300 x 12 m at a map's coordinates; the time of a point is its number.
Cloud road(std::size_t count, std::uint32_t seed = 1) {
  std::mt19937 generator(seed);
  const auto uniform = [&] { return static_cast<double>(generator()) / 4294967296.0; };
  Cloud cloud;
  cloud.origin_m = Eigen::Vector3d(485000.0, 5429000.0, 300.0);
  for (std::size_t k = 0; k < count; ++k) {
    const double x = 300.0 * uniform(), y = 12.0 * uniform();
    cloud.x_m.push_back(x), cloud.y_m.push_back(y);
    cloud.z_m.push_back(0.03 * x + 0.1 * std::sin(y) + 0.005 * uniform());
    cloud.time_s.push_back(static_cast<double>(k));
    cloud.intensity.push_back(static_cast<float>(k % 100));
    cloud.classification.push_back(static_cast<std::uint8_t>(k % 5));
  }
  return cloud;
}

void add(Cloud& cloud, double x, double y, double z) {
  cloud.time_s.push_back(static_cast<double>(cloud.size()));
  cloud.x_m.push_back(x), cloud.y_m.push_back(y), cloud.z_m.push_back(z);
  cloud.intensity.push_back(1.0f), cloud.classification.push_back(1);
}

/// In pieces of some points, of two passes.
PassSource pieces(const Cloud& cloud, std::size_t size = 7001) {
  return [&cloud, size](const PassSink& sink) {
    for (std::size_t begin = 0; begin < cloud.size(); begin += size) {
      const std::size_t end = std::min(cloud.size(), begin + size);
      Cloud chunk;
      chunk.origin_m = cloud.origin_m;
      const auto take = [&](auto& to, const auto& from) {
        if (from.empty()) return;
        to.assign(from.begin() + static_cast<std::ptrdiff_t>(begin),
                  from.begin() + static_cast<std::ptrdiff_t>(end));
      };
      take(chunk.x_m, cloud.x_m), take(chunk.y_m, cloud.y_m), take(chunk.z_m, cloud.z_m);
      take(chunk.time_s, cloud.time_s), take(chunk.intensity, cloud.intensity);
      take(chunk.classification, cloud.classification), take(chunk.sigma_m, cloud.sigma_m);
      sink(std::move(chunk), begin >= cloud.size() / 2 ? 1 : 0);
    }
  };
}

struct Read {
  Eigen::Vector3d place;
  double time_s = 0.0, error_bound_m = 0.0;
  float intensity = 0.0f, sigma_m = 0.0f;
  int pass = 0, classification = 0, level = 0;
};

/// What docs/formats_data.md says, by its own words; checks bounds and where tiles begin on the
/// way.
std::vector<Read> read_back(const TileSet& set, const std::string& bytes) {
  std::vector<Read> out;
  std::size_t at = 0;
  if (bytes.size() != set.bytes) {
    ADD_FAILURE() << bytes.size() << " bytes, " << set.bytes << " wanted";
    return out;
  }
  const auto get = [&](auto value) {
    std::memcpy(&value, bytes.data() + at, sizeof value);
    at += sizeof value;
    return value;
  };
  for (const Tile& tile : set.tiles) {
    EXPECT_EQ(tile.begin, at);
    EXPECT_GT(tile.points, 0u);
    EXPECT_LE(tile.points, 65536u);
    std::vector<Read> points(tile.points);
    if (set.has_time)
      for (Read& p : points) p.time_s = get(0.0);
    for (Read& p : points) {
      Eigen::Vector3d local;
      for (int k = 0; k < 3; ++k) local[k] = static_cast<double>(get(0.0f));
      p.place = tile.origin_m + local, p.level = tile.level;
      p.error_bound_m = std::ldexp(local.cwiseAbs().maxCoeff(), -24) + 1e-8;
      for (int k = 0; k < 3; ++k) {
        EXPECT_GE(p.place[k], tile.min_m[k] - p.error_bound_m);
        EXPECT_LE(p.place[k], tile.max_m[k] + p.error_bound_m);
      }
    }
    if (set.has_intensity)
      for (Read& p : points) p.intensity = get(0.0f);
    if (set.has_sigma)
      for (Read& p : points) p.sigma_m = get(0.0f);
    for (Read& p : points) p.pass = get(std::uint16_t{0});
    if (set.has_class)
      for (Read& p : points) p.classification = get(std::uint8_t{0});
    at = (at + 7) / 8 * 8;
    out.insert(out.end(), points.begin(), points.end());
  }
  EXPECT_EQ(at, bytes.size());
  return out;
}

class Tiles : public ::testing::Test {
 protected:
  TileSet tile(const Cloud& cloud, const TileOptions& options = {}) {
    return write_tiles(pieces(cloud), folder_.path("points"), folder_.path("scratch"), options);
  }
  /// Each point of the cloud once, where it was, within float32.
  void expect_same(const Cloud& cloud, const std::vector<Read>& points) {
    ASSERT_EQ(points.size(), cloud.size());
    std::vector<char> seen(cloud.size(), 0);
    for (const Read& p : points) {
      const auto k = static_cast<std::size_t>(p.time_s);
      ASSERT_LT(k, cloud.size());
      EXPECT_FALSE(seen[k]) << "twice: " << k;
      seen[k] = 1;
      const Eigen::Vector3d was = cloud.origin_m + cloud.point(k);
      ASSERT_LE((p.place - was).cwiseAbs().maxCoeff(), p.error_bound_m) << k;
      ASSERT_EQ(p.intensity, cloud.intensity[k]);
      ASSERT_EQ(p.classification, cloud.classification[k]);
    }
  }
  support::TemporaryFolder folder_;
};

TEST_F(Tiles, HoldEachPointOnceWhereItWas) {
  const Cloud cloud = road(300'000);
  const TileSet set = tile(cloud, {.points_per_run = 40'000});
  EXPECT_EQ(set.points, cloud.size());
  const std::vector<Read> points = read_back(set, folder_.read("points"));
  expect_same(cloud, points);
  // On a road of 300 m the worst that float32 does is below 0.01 mm.
  double worst = 0.0;
  std::size_t of_second = 0;
  for (const Read& p : points) worst = std::max(worst, p.error_bound_m), of_second += p.pass == 1;
  EXPECT_LT(worst, 2e-5);
  EXPECT_EQ(set.points_of_pass.at(1), of_second);
  EXPECT_EQ(set.points_of_class.at(3), 60'000u);
  EXPECT_EQ(set.time_end_s, 299'999.0);
  EXPECT_GE(set.min_m.x(), 485000.0);
  EXPECT_LE(set.max_m.x(), 485300.0);
  EXPECT_NEAR(set.most_m[0].low, 485003.0, 0.5);  // 1 % of 300 m
  EXPECT_NEAR(set.most_m[0].high, 485297.0, 0.5);
  EXPECT_EQ(set.most_intensity.high, 99.0);
  EXPECT_LT(set.tiles.size(), 60u);
  EXPECT_FALSE(std::filesystem::exists(folder_.path("scratch")));
}

/// Whatever is in the cloud is seen at every level: a point of it or of a coarser one lies in the
/// same cell of the level's spacing.
TEST_F(Tiles, EachLevelCoversTheCloudWithItsSpacing) {
  const Cloud cloud = road(400'000);
  const TileSet set = tile(cloud);
  const std::vector<Read> points = read_back(set, folder_.read("points"));
  const int levels = std::max_element(set.tiles.begin(), set.tiles.end(),
                                      [](auto& a, auto& b) { return a.level < b.level; })
                         ->level +
                     1;
  ASSERT_GE(levels, 3);
  std::vector<std::size_t> count(static_cast<std::size_t>(levels));
  for (const Read& p : points) ++count[static_cast<std::size_t>(p.level)];
  for (int level = 0; level + 1 < levels; ++level) {
    const double spacing = std::ldexp(set.spacing_m, -level);
    using Key = std::array<long, 3>;
    std::map<Key, std::vector<Eigen::Vector3d>> near;
    const auto key_of = [&](const Eigen::Vector3d& p) {
      return Key{std::lround(p.x() / spacing), std::lround(p.y() / spacing),
                 std::lround(p.z() / spacing)};
    };
    for (const Read& p : points)
      if (p.level <= level) near[key_of(p.place)].push_back(p.place);
    std::size_t uncovered = 0;
    for (std::size_t k = 0; k < points.size(); k += 97) {
      const Key key = key_of(points[k].place);
      bool covered = false;
      for (long x = -1; x <= 1; ++x)
        for (long y = -1; y <= 1; ++y)
          for (long z = -1; z <= 1; ++z) {
            const auto found = near.find({key[0] + x, key[1] + y, key[2] + z});
            if (found == near.end()) continue;
            for (const Eigen::Vector3d& p : found->second)
              covered |= (p - points[k].place).cwiseAbs().maxCoeff() <= spacing;
          }
      uncovered += covered ? 0 : 1;
    }
    EXPECT_EQ(uncovered, 0u) << "level " << level << ", spacing " << spacing;
  }
  // A view from afar needs few of them.
  EXPECT_LT(count[0], points.size() / 10);
}

TEST_F(Tiles, AreTheSameBytesForAnyNumberOfThreadsAndAnySizeOfRuns) {
  const Cloud cloud = road(100'000);
  tile(cloud, {.points_per_run = 30'000, .threads = 1});
  const std::string one = folder_.read("points");
  tile(cloud, {.points_per_run = 30'000, .threads = 2});
  EXPECT_EQ(folder_.read("points"), one);
  tile(cloud, {.points_per_run = 1'000'000, .threads = 2});
  EXPECT_EQ(folder_.read("points"), one);
  tile(cloud, {.points_per_run = 7, .threads = 1});
  EXPECT_EQ(folder_.read("points"), one);
}

TEST_F(Tiles, StrayPointsFarAwayCostNoPrecisionAndKeepTilesSmall) {
  Cloud cloud = road(120'000);
  add(cloud, 9e7, -9e7, 0.0);
  add(cloud, -9e7, 9e7, 9e7);
  const TileSet set = tile(cloud);
  const std::vector<Read> points = read_back(set, folder_.read("points"));
  expect_same(cloud, points);
  std::size_t coarse = 0, wide = 0;
  for (const Read& p : points) coarse += p.error_bound_m > 1e-4;
  EXPECT_LE(coarse, 2u);
  for (const Tile& t : set.tiles)
    if ((t.max_m - t.min_m).maxCoeff() > 1000.0) wide += t.points;
  EXPECT_LT(wide, cloud.size() / 20);
  EXPECT_LT(set.most_m[0].high, 486000.0);
}

TEST_F(Tiles, FewPointsAreOneTile) {
  for (const std::size_t count : {1u, 2u, 17u, 20'000u}) {
    const Cloud cloud = road(count);
    const TileSet set = tile(cloud);
    EXPECT_EQ(set.tiles.size(), 1u) << count;
    EXPECT_LT(set.spacing_m, 20.0);
    expect_same(cloud, read_back(set, folder_.read("points")));
  }
}

TEST_F(Tiles, ManyPointsAtOnePlaceAreSeveralTiles) {
  Cloud cloud;
  for (int k = 0; k < 200'000; ++k) add(cloud, 1.0, 2.0, 3.0);
  const TileSet set = tile(cloud);
  expect_same(cloud, read_back(set, folder_.read("points")));
}

TEST_F(Tiles, WithoutTimeIntensityAndClassHaveNoneOfThem) {
  Cloud cloud = road(1000);
  cloud.time_s.clear(), cloud.intensity.clear(), cloud.classification.clear();
  const TileSet set = tile(cloud);
  EXPECT_FALSE(set.has_time || set.has_intensity || set.has_class);
  EXPECT_EQ(read_back(set, folder_.read("points")).size(), 1000u);
  EXPECT_EQ(set.bytes, 14'000u);
}

TEST_F(Tiles, KeepTheStandardDeviationOfEachPoint) {
  Cloud cloud = road(30'000);
  for (std::size_t k = 0; k < cloud.size(); ++k)
    cloud.sigma_m.push_back(0.001f * static_cast<float>(k % 101));
  const TileSet set = tile(cloud);
  ASSERT_TRUE(set.has_sigma);
  const std::vector<Read> points = read_back(set, folder_.read("points"));
  expect_same(cloud, points);
  for (const Read& p : points)
    ASSERT_EQ(p.sigma_m, cloud.sigma_m[static_cast<std::size_t>(p.time_s)]);
  EXPECT_NEAR(set.most_sigma_m.high, 0.099, 1e-6);
}

TEST_F(Tiles, OfNothingOrOfNonsenseAreRefusedAndNothingIsLeft) {
  EXPECT_THROW(tile(Cloud{}), Error);
  for (const double wrong : {1e8, -1e300, std::nan(""), HUGE_VAL}) {
    Cloud cloud = road(100);
    add(cloud, wrong, 0.0, 0.0);
    EXPECT_THROW(tile(cloud), Error) << wrong;
  }
  EXPECT_THROW(write_tiles(pieces(road(10)), folder_.path("points"), folder_.path("none/scratch")),
               Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path("")));
}

/// As the command is called.
class TilesCommand : public ::testing::Test {
 protected:
  int run(const std::string& arguments, const std::string& before = "") {
    const std::string command = before + " \"" + places::lidar2mesh() + "\" " + arguments + " > '" +
                                folder_.path("out.txt") + "' 2> '" + folder_.path("err.txt") + "'";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string at(const char* name) const { return "'" + folder_.path(name) + "'"; }
  nlohmann::json index(const char* of) {
    return base::parse_json<nlohmann::json>(folder_.read(std::string(of) + "/tiles.json"));
  }
  support::TemporaryFolder folder_;
};

TEST_F(TilesCommand, WritesAnIndexThatSaysWhatLiesWhere) {
  const Cloud cloud = road(150'000);
  write_cloud(cloud, folder_.path("a.ply"), true);
  ASSERT_EQ(run("tiles " + at("a.ply") + " -o " + at("one") + " --threads 1"), 0)
      << folder_.read("err.txt");
  EXPECT_THAT(folder_.read("out.txt"), HasSubstr("points: 150000, tiles: "));
  ASSERT_EQ(run("tiles " + at("a.ply") + " -o " + at("two") + " --threads 2 --json"), 0);
  const auto said = base::parse_json<nlohmann::json>(folder_.read("out.txt"));
  EXPECT_EQ(said["points"], 150'000);
  EXPECT_FALSE(said.contains("tiles"));
  for (const char* name : {"tiles.json", "points.tiles", "manifest.json"})
    EXPECT_EQ(folder_.read(std::string("one/") + name), folder_.read(std::string("two/") + name));
  const auto json = index("one");
  EXPECT_EQ(json["schema"], 1);
  EXPECT_EQ(json["inputs"][0]["role"], "cloud");
  EXPECT_EQ(json["inputs"][0]["sha256"].get<std::string>().size(), 64u);
  EXPECT_EQ(json["bytes"], std::filesystem::file_size(folder_.path("one/points.tiles")));
  std::uint64_t in_tiles = 0, in_levels = 0, begin = 0;
  for (const auto& tile : json["tiles"]) {
    ASSERT_EQ(tile.size(), json["tile_columns"].size());
    EXPECT_EQ(tile[1], begin);
    in_tiles += tile[2].get<std::uint64_t>();
    begin += (tile[2].get<std::uint64_t>() * (8 + 12 + 4 + 2 + 1) + 7) / 8 * 8;
  }
  for (const auto& level : json["levels"]) in_levels += level["points"].get<std::uint64_t>();
  EXPECT_EQ(in_tiles, 150'000u);
  EXPECT_EQ(in_levels, 150'000u);
  EXPECT_EQ(begin, json["bytes"]);
  // Again into the same folder, of another cloud.
  write_cloud(road(500), folder_.path("b.ply"));
  ASSERT_EQ(run("tiles " + at("b.ply") + " -o " + at("one")), 0);
  EXPECT_EQ(index("one")["points"], 500);
}

// As lidar2mesh writes what it has refined.
TEST_F(TilesCommand, OfARefinedRoadHaveItsStandardDeviations) {
  NodeSurface surface;
  surface.origin_m = {500000.0, 5400000.0, 300.0};
  for (int k = 0; k < 400; ++k) {
    surface.place_m.emplace_back(0.5 * (k % 20), 0.5 * (k / 20), 0.01 * k);
    surface.normal.emplace_back(0.0f, 0.0f, 1.0f);
    surface.stddev_m.push_back(0.002f + 1e-5f * static_cast<float>(k));
  }
  surface.triangles.push_back({0, 1, 20});
  for (const char* name : {"refined.ply", "refined.pcd"}) {
    write_surface(surface, folder_.path(name), false);
    ASSERT_EQ(run("tiles " + at(name) + " -o " + at("tiles")), 0) << folder_.read("err.txt");
    const auto json = index("tiles");
    ASSERT_EQ(json["points"], 400) << name;
    EXPECT_NEAR(json["sigma_m"][0].get<double>(), 0.00204, 2e-5) << name;
    EXPECT_NEAR(json["sigma_m"][1].get<double>(), 0.00595, 2e-5) << name;
    // Read, filtered and written again they are still there.
    ASSERT_EQ(read_cloud(folder_.path(name)).sigma_m, surface.stddev_m) << name;
    write_cloud(read_cloud(folder_.path(name)), folder_.path("again.pcd"), true);
    EXPECT_EQ(read_cloud(folder_.path("again.pcd")).sigma_m, surface.stddev_m) << name;
  }
}

// Files of other people's programs: as many points as their headers state, none lost and none
// twice.
TEST_F(TilesCommand, OfOtherPeoplesCloudsHoldEveryPoint) {
  const std::string others = places::data() + "/lidar/";
  if (!std::filesystem::exists(others)) GTEST_SKIP() << "skipped: " << others << " is not there";
  for (const auto& [name, points] : std::map<std::string, std::uint64_t>{
           {"autzen_trim.las", 110000}, {"street_source.ply", 69792}, {"samp11-utm.pcd", 38010}}) {
    ASSERT_EQ(run("tiles '" + others + name + "' -o " + at("tiles")), 0) << folder_.read("err.txt");
    const nlohmann::json made = index("tiles");
    EXPECT_EQ(made["points"], points) << name;
    std::uint64_t in_tiles = 0;
    for (const auto& tile : made["tiles"]) in_tiles += tile[2].get<std::uint64_t>();
    EXPECT_EQ(in_tiles, points) << name;
  }
}

TEST_F(TilesCommand, PlacesScansByTheirTrajectory) {
  std::string scan = "time,x,y,z\n";
  for (int k = 0; k < 1000; ++k) scan += std::to_string(0.001 * k) + ",0,1,-2\n";
  folder_.file("scan.csv", scan + "99,0,1,-2\n");
  // Turned to the left by 90 degrees, 10 m/s along y.
  folder_.file("poses.csv",
               "time_s,x_m,y_m,z_m,qx,qy,qz,qw\n0,100,0,5,0,0,0.70710678,0.70710678\n"
               "0.5,100,5,5,0,0,0.70710678,0.70710678\n1,100,10,5,0,0,0.70710678,0.70710678\n"
               "98,0,0,0,0,0,0,1\n98.5,0,0,0,0,0,0,1\n");
  ASSERT_EQ(run("tiles " + at("scan.csv") + " --trajectory " + at("poses.csv") + " -o " + at("t")),
            0)
      << folder_.read("err.txt");
  const auto json = index("t");
  EXPECT_EQ(json["points"], 1000);
  EXPECT_THAT(base::dump_json(json["remarks"]),
              HasSubstr("1 points outside the trajectory's time"));
  ASSERT_EQ(json["passes"].size(), 2u);  // a gap of 97 s
  EXPECT_EQ(json["passes"][0]["points"], 1000);
  EXPECT_EQ(json["passes"][1]["time_s"][0], 98.0);
  EXPECT_NEAR(json["min_m"][0], 99.0, 1e-6);
  EXPECT_NEAR(json["max_m"][1], 9.99, 1e-6);
  EXPECT_NEAR(json["max_m"][2], 3.0, 1e-6);
  EXPECT_EQ(run("tiles " + at("scan.csv") + " --trajectory " + at("scan.csv") + " -o " + at("u")),
            1);
}

TEST_F(TilesCommand, LeavesNothingHalfWrittenWhenTheDiskIsFull) {
  write_cloud(road(30'000), folder_.path("a.ply"));
  ASSERT_EQ(run("tiles " + at("a.ply") + " -o " + at("t")), 0);
  const std::string before = folder_.read("t/points.tiles");
  write_cloud(road(60'000, 2), folder_.path("a.ply"));
  EXPECT_EQ(run("tiles " + at("a.ply") + " -o " + at("t"), "ulimit -f 500;"), 1);
  EXPECT_EQ(run("tiles " + at("a.ply") + " -o " + at("new"), "ulimit -f 500;"), 1);
  EXPECT_THAT(folder_.read("err.txt"), HasSubstr("sorted: cannot write"));
  EXPECT_EQ(folder_.read("t/points.tiles"), before);
  EXPECT_FALSE(std::filesystem::exists(folder_.path("t/.kerbstone.new")));
  EXPECT_FALSE(std::filesystem::exists(folder_.path("new")));
}

TEST_F(TilesCommand, SaysWhatItCannotUse) {
  folder_.file("none.xyz", "\n");
  folder_.file("big.las", "LASF" + std::string(300, '\xff'));
  for (const char* name : {"none.xyz", "big.las", "missing.las"}) {
    EXPECT_EQ(run("tiles " + at(name) + " -o " + at("t")), 1) << name;
    const std::string said = folder_.read("err.txt");
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_FALSE(std::filesystem::exists(folder_.path("t"))) << name;
  }
}

}  // namespace tiles_test
}  // namespace cloud
