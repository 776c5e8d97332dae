#include "view/folders.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "base/error.h"
#include "support/temporary_folder.h"

namespace folders_test {

namespace fs = std::filesystem;

class Folders : public ::testing::Test {
 protected:
  Folders() {
    fs::create_directories(folder_.path("shown/tracks/a"));
    fs::create_directories(folder_.path("shown/.hidden"));
    fs::create_directories(folder_.path("secret"));
    folder_.file("shown/tracks/a/track.yaml", "mesh: a.obj\n");
    folder_.file("shown/tracks/a/a.obj", "v 0 0 0\n");
    folder_.file("shown/out.crg", "x");
    folder_.file("shown/notes.txt", "not shown");
    folder_.file("shown/.hidden/b.obj", "hidden");
    folder_.file("secret/key.csv", "secret");
    fs::create_symlink(folder_.path("secret/key.csv"), folder_.path("shown/link.csv"));
    fs::create_directory_symlink(folder_.path("secret"), folder_.path("shown/away"));
    fs::create_symlink("out.crg", folder_.path("shown/inside.crg"));
  }
  support::TemporaryFolder folder_;
};

TEST_F(Folders, ListFilesOfKnownKindsBelowThem) {
  const view::Listing listing = view::Folders({folder_.path("shown")}).list();
  std::vector<std::string> ids;
  for (const view::Entry& entry : listing.entries) ids.push_back(entry.id);
  EXPECT_THAT(ids,
              ::testing::IsSupersetOf({"0/out.crg", "0/tracks/a/a.obj", "0/tracks/a/track.yaml"}));
  EXPECT_THAT(ids, ::testing::Not(::testing::Contains(::testing::HasSubstr("hidden"))));
  EXPECT_THAT(ids, ::testing::Not(::testing::Contains("0/notes.txt")));
  EXPECT_THAT(ids, ::testing::Not(::testing::Contains(::testing::HasSubstr("away/"))));
  EXPECT_TRUE(listing.is_whole);
}

TEST_F(Folders, TellCloudsFromMeshesAndTilesFromOtherFiles) {
  fs::create_directories(folder_.path("shown/t"));
  fs::create_directories(folder_.path("shown/car"));
  const std::string ply = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\n";
  folder_.file("shown/cloud.ply", ply + "end_header\n");
  folder_.file("shown/mesh.ply", ply + "element face 0\nend_header\n");
  folder_.file("shown/broken.ply", ply);
  folder_.file("shown/survey.LAZ", "");
  folder_.file("shown/t/tiles.json", "{}");
  folder_.file("shown/t/points.tiles", "");
  folder_.file("shown/car/devices.yaml", "# of the car\nseed: 1\nscans:\n  lidar: {}\n");
  std::map<std::string, std::string> kinds;
  for (const view::Entry& entry : view::Folders({folder_.path("shown")}).list().entries)
    kinds[entry.id] = view::to_string(entry.kind);
  EXPECT_EQ(kinds["0/cloud.ply"], "scan");
  EXPECT_EQ(kinds["0/car/devices.yaml"], "devices");
  EXPECT_EQ(kinds["0/tracks/a/track.yaml"], "recipe");
  EXPECT_EQ(kinds["0/mesh.ply"], "mesh");
  EXPECT_EQ(kinds["0/broken.ply"], "mesh");
  EXPECT_EQ(kinds["0/survey.LAZ"], "scan");
  EXPECT_EQ(kinds["0/t/tiles.json"], "tiles");
  EXPECT_EQ(kinds.count("0/t/points.tiles"), 0u);
}

TEST_F(Folders, TellCarsAndTheirMapsFromRecipesAndDrives) {
  fs::create_directories(folder_.path("shown/car"));
  folder_.file("shown/car/vehicle.yaml",
               "name: one\ntyres:\n  front: front.tir  # as in lap.csv\nengine.map: engine.csv\n");
  folder_.file("shown/car/engine.csv", "engine_radps:throttle,0,1\n");
  folder_.file("shown/car/lap.csv", "time_s,x_m\n");
  folder_.file("shown/car/gine.csv", "time_s,x_m\n");
  folder_.file("shown/engine.csv", "time_s,x_m\n");
  folder_.file("shown/mapping.yaml", "version: 1\ncolumns:\n  time_s: t\n");
  std::map<std::string, std::string> kinds;
  for (const view::Entry& entry : view::Folders({folder_.path("shown")}).list().entries)
    kinds[entry.id] = view::to_string(entry.kind);
  EXPECT_EQ(kinds["0/car/vehicle.yaml"], "car");
  EXPECT_EQ(kinds.count("0/car/engine.csv"), 0u);
  EXPECT_EQ(kinds["0/car/lap.csv"], "table");
  EXPECT_EQ(kinds["0/car/gine.csv"], "table");
  EXPECT_EQ(kinds["0/engine.csv"], "table");
  EXPECT_EQ(kinds.count("0/mapping.yaml"), 0u);
}

TEST_F(Folders, NothingOutsideThemIsReached) {
  const view::Folders folders({folder_.path("shown")});
  EXPECT_EQ(folders.path_of("0/out.crg"), fs::canonical(folder_.path("shown/out.crg")));
  EXPECT_EQ(folders.path_of("0/inside.crg"), fs::canonical(folder_.path("shown/out.crg")));
  for (const char* const id :
       {"", "0", "0/", "1/out.crg", "-1/out.crg", "0x0/out.crg", "+0/out.crg", "/etc/passwd",
        "0//etc/passwd", "0/../secret/key.csv", "0/tracks/../../secret/key.csv", "0/./out.crg",
        "0/link.csv", "0/away/key.csv", "0/tracks", "0/tracks/", "0/missing.crg",
        "99999999999999999999/out.crg"})
    EXPECT_THROW(folders.path_of(id), base::Error) << id;
  EXPECT_THROW(folders.path_of(std::string("0/out.crg\0.yaml", 15)), base::Error);
}

TEST_F(Folders, ANewFileHasToLieInThemToo) {
  const view::Folders folders({folder_.path("shown")});
  EXPECT_EQ(folders.path_of("0/tracks/a/guide.csv", true),
            fs::canonical(folder_.path("shown/tracks/a")).string() + "/guide.csv");
  for (const char* const id : {"0/away/new.csv", "0/../new.csv", "0/missing/new.csv", "0/link.csv"})
    EXPECT_THROW(folders.path_of(id, true), base::Error) << id;
}

TEST_F(Folders, AFolderThatIsNoneIsRefused) {
  EXPECT_THROW(view::Folders({folder_.path("nowhere")}), base::Error);
  EXPECT_THROW(view::Folders({folder_.path("shown/out.crg")}), base::Error);
  EXPECT_THROW(view::Folders(std::vector<std::string>{}), base::Error);
}

}  // namespace folders_test
