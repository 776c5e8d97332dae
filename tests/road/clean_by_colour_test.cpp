// Roads that only the colours of pictures tell.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "make/make_track.h"
#include "make/plausible.h"
#include "mesh/error.h"
#include "mesh/ray_surface.h"
#include "mesh/read_mesh.h"
#include "road/centreline.h"
#include "road/clean.h"
#include "support/coloured_ring.h"
#include "support/mesh_files.h"
#include "support/ring_strips.h"

namespace clean_by_colour_test {

using support::ColouredStrip;
using support::kAsphalt;
using support::kEarth;
using support::kGrass;
using support::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A road of 10 m between a verge of 4 m and one of 7 m.
const std::vector<ColouredStrip> kRoad{{-5, 5, kAsphalt}, {5, 9, kGrass}, {-12, -5, kGrass}};

struct Found {
  road::CleanReport report;
  road::Centreline line;
  std::vector<std::string> doubts;
  double width_m = 0.0;
};

Found find(const std::string& path, road::CleanOptions options = {}) {
  Found found;
  const road::Mesh mesh = road::read_mesh(path, road::read_to_clean({}, options));
  const road::RoadMesh surface = road::clean(mesh, options, &found.report);
  found.line = road::trace_centreline(surface);
  found.doubts = road::doubts_about(found.line, road::RaySurface(surface.mesh), surface.mesh, mesh,
                                    found.report);
  std::vector<double> half_m = found.line.half_width_m;
  std::nth_element(half_m.begin(), half_m.begin() + static_cast<std::ptrdiff_t>(half_m.size() / 2),
                   half_m.end());
  found.width_m = 2.0 * half_m[half_m.size() / 2];
  return found;
}

void expect_road(const Found& found, const std::string& what) {
  EXPECT_EQ(road::told_by(found.report), "colour") << what;
  EXPECT_THAT(found.doubts, IsEmpty()) << what;
  EXPECT_TRUE(found.line.closed) << what;
  EXPECT_NEAR(found.line.length_m, support::kRingLength_m, 0.5) << what;
  EXPECT_NEAR(found.width_m, 10.0, 0.1) << what;
  EXPECT_THAT(found.report.remarks, testing::Contains(HasSubstr("road told by colour"))) << what;
}

TEST(CleanByColour, TellsTheRoadOfAnObj) {
  for (const char* ending : {"png", "jpg"}) {
    const TemporaryFolder folder;
    expect_road(find(support::coloured_obj(folder, kRoad, ending)), ending);
  }
}

TEST(CleanByColour, WithoutPicturesIsDoubtedAsBefore) {
  const TemporaryFolder folder;
  const std::string path = support::coloured_obj(folder, kRoad);
  for (const char* name : {"p0.png", "p1.png", "p2.png"})
    std::filesystem::remove(folder.path(name));
  const Found found = find(path);
  EXPECT_FALSE(found.report.by_colour);
  EXPECT_THAT(found.doubts, ElementsAre(HasSubstr("may be the road and this one its verge")));
}

// A ring of one colour along one side is as much a road as the grey one.
TEST(CleanByColour, GroundOfOneColourAsWideAsARoadLeavesItToShapeWithItsDoubt) {
  const TemporaryFolder folder;
  const Found found =
      find(support::coloured_obj(folder, {{-5, 5, kAsphalt}, {5, 9, kEarth}, {-12, -5, kGrass}}));
  EXPECT_EQ(road::told_by(found.report), "shape");
  EXPECT_THAT(found.doubts, ElementsAre(HasSubstr("may be the road and this one its verge")));
  EXPECT_NEAR(found.width_m, 10.0, 0.1);
}

TEST(CleanByColour, TellsTheRoadOfAGlbWithPicturesInIt) {
  const TemporaryFolder folder;
  road::Mesh mesh = support::coloured_ring(kRoad);
  for (road::MeshObject& object : mesh.objects) object.name = object.material = "";
  const auto with = [&](auto picture) {
    return support::as_glb(
        mesh, {picture(kAsphalt, 12, 32), picture(kGrass, 12, 32), picture(kGrass, 12, 32)});
  };
  expect_road(find(folder.file("png.glb", with(support::png_of))), "PNG");
  expect_road(find(folder.file("jpeg.glb", with(support::jpeg_of))), "JPEG");
}

TEST(CleanByColour, TellsTheRoadOfAnAc) {
  const TemporaryFolder folder;
  support::coloured_obj(folder, kRoad);
  expect_road(find(folder.file("ring.ac", support::as_acc(support::coloured_ring(kRoad)))), "AC3D");
}

TEST(CleanByColour, TellsTheRoadWhoseEveryPieceHasAPictureOfItsOwn) {
  const TemporaryFolder folder;
  std::vector<ColouredStrip> pieces;
  for (const ColouredStrip& strip : kRoad)
    for (int k = 0; k < 60; ++k)
      pieces.push_back({strip.right_m, strip.left_m, strip.rgb, k / 60.0, (k + 1) / 60.0});
  const std::string path = support::coloured_obj(folder, pieces);
  expect_road(find(path), "pieces");
  // Along a guide too the colours keep the pieces together, and end the road.
  road::CleanOptions options;
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < 40; ++k)
    points.push_back(
        support::on_ring(support::kRingLength_m * k / 40.0, k % 2 == 0 ? 1.5 : -1.5, 0.0));
  options.guide = road::guide_along(points);
  const Found guided = find(path, options);
  EXPECT_THAT(guided.doubts, IsEmpty());
  EXPECT_NEAR(guided.width_m, 10.0, 0.1);
  EXPECT_NEAR(guided.line.length_m, support::kRingLength_m, 0.5);
}

TEST(CleanByColour, ContradictoryPicturesMakeNoRoad) {
  // The verges are grey and the road is green: shape's own answer, with its doubt.
  {
    const TemporaryFolder folder;
    const Found found = find(support::coloured_obj(
        folder, {{-5, 5, kGrass}, {5, 9, kAsphalt}, {-12, -5, kAsphalt}, {-60, -12, kEarth}}));
    EXPECT_FALSE(found.report.by_colour);
    EXPECT_FALSE(found.doubts.empty());
  }
  // One grey strip of 4 m beside the road: two answers.
  const TemporaryFolder folder;
  const std::string path =
      support::coloured_obj(folder, {{-5, 5, kGrass}, {5, 9, kAsphalt}, {9, 40, kGrass}});
  try {
    find(path);
    FAIL() << "colour and shape tell different roads";
  } catch (const road::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("colour and shape tell different ones"));
  }
}

TEST(CleanByColour, NamesAndUseNamesComeFirst) {
  const TemporaryFolder folder;
  const std::string path = support::coloured_obj(folder, kRoad);
  road::CleanOptions options;
  options.use_names = road::UseNames::no;
  EXPECT_FALSE(find(path, options).report.by_colour);
  // A name that tells the road: no picture is read.
  std::string text = folder.read("ring.obj");
  text.replace(text.find("o Plane.000"), 11, "o Main_Road");
  road::MeshReadReport report;
  const road::Mesh mesh =
      road::read_mesh(folder.file("named.obj", text), road::read_to_clean({}, {}), &report);
  EXPECT_EQ(report.files.size(), 1u) << "the list of materials";
  for (const road::MeshObject& object : mesh.objects) EXPECT_FALSE(object.colour);
}

TEST(CleanByColour, BrokenPicturesAreOneRemark) {
  const TemporaryFolder folder;
  const std::string path = support::coloured_obj(folder, kRoad);
  folder.file("p0.png", folder.read("p0.png").substr(0, 200));
  folder.file("p1.png", "DDS |");
  std::filesystem::remove(folder.path("p2.png"));
  road::MeshReadReport report;
  const road::Mesh mesh = road::read_mesh(path, road::read_to_clean({}, {}), &report);
  for (const road::MeshObject& object : mesh.objects) EXPECT_FALSE(object.colour);
  EXPECT_THAT(report.remarks,
              ElementsAre(HasSubstr("3 of 3 pictures tell none; the first: 'p0.png': a damaged")));
}

TEST(CleanByColour, PicturesOutsideTheFolderAreNotRead) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path("mesh"));
  support::coloured_obj(folder, kRoad);
  std::string materials = folder.read("ring.mtl");
  for (std::size_t at = 0; (at = materials.find(" p", at)) != std::string::npos; at += 5)
    materials.replace(at, 2, " ../p");
  folder.file("mesh/ring.mtl", materials);
  const std::string path = folder.file("mesh/ring.obj", folder.read("ring.obj"));
  road::MeshReadReport report;
  road::MeshReadOptions options = road::read_to_clean({}, {});
  const road::Mesh kept_out = road::read_mesh(path, options, &report);
  EXPECT_FALSE(kept_out.objects[0].colour);
  EXPECT_THAT(report.remarks, ElementsAre(HasSubstr("--allow-outside")));
  options.allow_outside = true;
  EXPECT_TRUE(road::read_mesh(path, options).objects[0].colour);
}

TEST(CleanByColour, APictureThatChangesIsBuiltAgain) {
  const TemporaryFolder folder;
  road::Recipe recipe = road::recipe_for_mesh(support::coloured_obj(folder, kRoad));
  const auto is_reused = [&] {
    return road::make_track(recipe, folder.path("out"), {}, nullptr, road::Reuse::everything)
        .reused;
  };
  EXPECT_FALSE(is_reused());
  EXPECT_TRUE(is_reused());
  folder.file("p1.png", support::png_of({70, 110, 50}));
  EXPECT_FALSE(is_reused());
  EXPECT_TRUE(is_reused());
}

}  // namespace clean_by_colour_test
