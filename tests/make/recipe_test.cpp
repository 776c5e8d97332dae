#include "make/recipe.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "mesh/error.h"

namespace road {
namespace recipe_test {

using ::testing::HasSubstr;

class RecipeFile {
 public:
  explicit RecipeFile(const std::string& text) {
    static int count = 0;
    folder_ = std::filesystem::temp_directory_path() /
              ("recipe_test_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(folder_);
    std::ofstream(path(), std::ios::binary) << text;
  }
  ~RecipeFile() { std::filesystem::remove_all(folder_); }
  std::string path() const { return (folder_ / "track.yaml").string(); }
  std::filesystem::path folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

std::string error_of(const std::string& text) {
  const RecipeFile file(text);
  try {
    read_recipe(file.path());
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Recipe, DefaultsAndPathsBesideTheRecipe) {
  const RecipeFile file("mesh: meshes/circuit.obj\n");
  const Recipe recipe = read_recipe(file.path());
  EXPECT_EQ(recipe.mesh_path, (file.folder() / "meshes/circuit.obj").string());
  EXPECT_EQ(recipe.name, "circuit");
  EXPECT_EQ(recipe.recipe_path, file.path());
  EXPECT_FALSE(recipe.reference_line.u_step_m) << "automatic";
  EXPECT_FALSE(recipe.sample.v_step_m);
  EXPECT_DOUBLE_EQ(recipe.sample.v_max_m, 15.0);
  EXPECT_DOUBLE_EQ(recipe.smooth.window_u_m, 0.0);
  EXPECT_EQ(recipe.format, crg::Format::KRBI);
}

TEST(Recipe, EveryKeyIsRead) {
  const RecipeFile file(R"(# a comment
mesh: /abs/track.ac
name: my track
up: y
unit: cm
scale: 2.5
use_names: false
weld_tolerance_m: 0.02
reverse: true
start_near_m: [12.5, -3e2]
start_object: START
u_step_m: 0.25
v_step_m: 0.05
v_max_m: 20
smooth_window_m: 1.5
yaw_deg: 90
translation_m: [500000, 4649776.25, 12]
format: LDFI
threads: 3
validate_points: 500
max_z_error_p99_m: 0.01
name_rules:
  - {object: '^ASPH', class: road}
  - {texture: 'rumble', class: kerb}
)");
  const Recipe recipe = read_recipe(file.path());
  EXPECT_EQ(recipe.mesh_path, "/abs/track.ac");
  EXPECT_EQ(recipe.name, "my track");
  EXPECT_EQ(recipe.read.up, UpAxis::y);
  EXPECT_EQ(recipe.read.unit, Unit::cm);
  EXPECT_EQ(recipe.read.scale, 2.5);
  EXPECT_EQ(recipe.clean.use_names, road::UseNames::no);
  EXPECT_DOUBLE_EQ(recipe.clean.weld_tolerance_m, 0.02);
  EXPECT_TRUE(recipe.centreline.reverse);
  EXPECT_EQ(recipe.centreline.start_near_m, Eigen::Vector2d(12.5, -300.0));
  EXPECT_EQ(recipe.start_object, "START");
  EXPECT_DOUBLE_EQ(recipe.reference_line.u_step_m.value(), 0.25);
  EXPECT_DOUBLE_EQ(recipe.sample.v_step_m.value(), 0.05);
  EXPECT_DOUBLE_EQ(recipe.sample.v_max_m, 20.0);
  EXPECT_DOUBLE_EQ(recipe.smooth.window_u_m, 1.5);
  ASSERT_TRUE(recipe.T_global_mesh);
  EXPECT_DOUBLE_EQ(recipe.T_global_mesh->yaw_rad, std::numbers::pi / 2);
  EXPECT_EQ(recipe.T_global_mesh->translation_m, Eigen::Vector3d(500000, 4649776.25, 12));
  EXPECT_EQ(recipe.format, crg::Format::LDFI);
  EXPECT_EQ(recipe.sample.threads, 3u);
  EXPECT_EQ(recipe.smooth.threads, 3u);
  EXPECT_EQ(recipe.validate.points, 500u);
  EXPECT_DOUBLE_EQ(recipe.limits.max_z_error_p99_m, 0.01);
  ASSERT_EQ(recipe.clean.name_rules.size(), default_name_rules().size() + 2);
  EXPECT_EQ(recipe.clean.name_rules[0].pattern, "^ASPH");
  EXPECT_EQ(recipe.clean.name_rules[1].field, NameRule::Field::texture);
  EXPECT_EQ(recipe.clean.name_rules[1].surface_class, SurfaceClass::kerb);
}

TEST(Recipe, WhatAKeyShowsItReadsBack) {
  Recipe from;
  from.mesh_path = "m.obj";
  from.name = "n";
  from.clean.near_m = Eigen::Vector2d(-1, 2.5);
  from.centreline.start_near_m = Eigen::Vector2d(0.1, 1e7 / 3);
  from.start_object = "START";
  from.guide_path = "rough.gpx";
  from.guide_mapping_path = "mapping.yaml";
  from.clean.route_m = {{0, -1.5}, {100, 2}};
  from.clean.guide_width_m = 7.5;
  from.control_points_path = "points.csv";
  from.trajectory_path = "lap.csv";
  from.friction.picture_path = "wet.png";
  from.friction.zones_path = "zones.csv";
  from.kerb.zones_path = "kerbs.csv";
  from.published = {4304.0, 2.9, 12.0, "the organiser", "A. N., CC0"};
  from.utm_zone = UtmZone{55, false};
  from.T_global_mesh.emplace();
  from.T_global_mesh->translation_m = {1.0 / 3, 2, 3};
  Recipe to;
  for (const RecipeKey& key : recipe_keys()) {
    ASSERT_FALSE(key.show(from).empty()) << key.name;
    key.set(to, key.show(from));
    EXPECT_EQ(key.show(to), key.show(from)) << key.name;
  }
}

TEST(Recipe, ABlockSaysWhatIsPublished) {
  const RecipeFile file(
      "mesh: a.obj\nreference:\n  length_m: 4304\n  source: a page\n  mesh: A. N., CC0\n");
  const Recipe recipe = read_recipe(file.path());
  EXPECT_EQ(recipe.published.length_m, 4304.0);
  EXPECT_EQ(recipe.published.source, "a page");
  EXPECT_EQ(recipe.published.mesh, "A. N., CC0");
  EXPECT_FALSE(recipe.published.climb_m);
  EXPECT_THAT(error_of("mesh: a.obj\nreference:\n  lenght_m: 4304\n"),
              HasSubstr(":3: unknown key 'reference_lenght_m'; the nearest known one is "
                        "'reference_length_m'"));
}

TEST(Recipe, ErrorsNameFileLineSeenAndWanted) {
  EXPECT_THAT(
      error_of("mesh: a.obj\n\nu_stepm: 1\n"),
      HasSubstr("track.yaml:3: unknown key 'u_stepm'; the nearest known one is 'u_step_m'"));
  EXPECT_THAT(
      error_of("mesh: a.obj\nu_step_m: 50\n"),
      HasSubstr(
          "track.yaml:2: u_step_m: '50' seen, automatic or a number from 0.001 to 10 wanted"));
  EXPECT_THAT(error_of("mesh: a.obj\nformat: XYZ\n"),
              HasSubstr("track.yaml:2: format: 'XYZ' seen, KRBI, KDBI, LRFI or LDFI wanted"));
  EXPECT_THAT(error_of("mesh: a.obj\nmesh: b.obj\n"), HasSubstr(":2: mesh: given twice"));
  EXPECT_THAT(error_of("u_step_m: 0.1\n"), HasSubstr("the key mesh is missing"));
  EXPECT_THAT(error_of(""), HasSubstr("empty"));
  EXPECT_THAT(error_of("- 1\n- 2\n"), HasSubstr("no recipe"));
  EXPECT_THAT(error_of("mesh: [unclosed\n"), HasSubstr("no valid YAML"));
  EXPECT_THAT(error_of("mesh: a.obj\nname: ../../etc\n"), HasSubstr(":2: name: '../../etc' seen"));
  EXPECT_THAT(error_of("mesh: a.obj\nname_rules:\n  - {object: '(', class: road}\n"),
              HasSubstr(":3: name_rules: '(' seen, a regular expression wanted"));
  for (const char* pattern : {"(a)\\1", "a(?=b)", "a(?!b)"}) {
    EXPECT_THAT(
        error_of(std::string("mesh: a.obj\nname_rules:\n  - {object: '") + pattern +
                 "', class: road}\n"),
        HasSubstr(std::string(":3: name_rules: '") + pattern +
                  "' seen, a regular expression wanted, without look-ahead and back references"));
  }
  EXPECT_THAT(error_of("mesh: a.obj\nname_rules:\n  - {object: x, class: asphalt}\n"),
              HasSubstr("road, kerb, runoff, barrier or scenery wanted"));
  EXPECT_THAT(error_of("mesh: a.obj\ncontrol_points: p.csv\nyaw_deg: 3\n"), HasSubstr("give one"));
}

TEST(Recipe, HostileValuesAreRefusedNotTaken) {
  for (const char* value :
       {".nan", "nan", "inf", "-.inf", "1e999", "-1", "0", "0x10", "1,5", "''", "~", "[1, 2]",
        "{a: 1}", "99999999999999999999999999", "0.1m", "[[1]]"}) {
    EXPECT_THAT(error_of(std::string("mesh: a.obj\nu_step_m: ") + value + "\n"),
                HasSubstr("track.yaml:2: u_step_m: "))
        << value;
    EXPECT_THAT(error_of(std::string("mesh: a.obj\ntranslation_m: ") + value + "\n"),
                HasSubstr("track.yaml:2: translation_m: "))
        << value;
  }
  EXPECT_THAT(error_of("mesh: a.obj\nthreads: 1.5\n"), HasSubstr("a whole number"));
  EXPECT_THAT(error_of(std::string("mesh: a.obj\0x", 13)), HasSubstr("binary data"));
  EXPECT_THAT(error_of(std::string(2 << 20, 'a')), HasSubstr("a recipe of a few lines"));
  EXPECT_NE(error_of(std::string(100000, '[')), "no error");
  EXPECT_NE(error_of("a: &x [*x]\n"), "no error");
  EXPECT_THROW(read_recipe("/"), Error);
  EXPECT_THROW(read_recipe("/does/not/exist.yaml"), Error);
}

TEST(Recipe, MutatedRecipesNeverCrash) {
  const std::string good =
      "mesh: a.obj\nname: n\nu_step_m: 0.1\nstart_near_m: [1, 2]\nname_rules:\n  - {object: 'x+', "
      "class: road}\ntranslation_m: [1, 2, 3]\nformat: KRBI\nfriction_grass: 0.4\nutm_zone: 32N\n";
  const RecipeFile file(good);
  int read = 0;
  std::mt19937 random(1);
  const std::string alphabet = "[]{}:,-&*!|>'\"%@`#?\n\t 019.e\\()+$ax\x80\xff";
  // 10,000 with KERBSTONE_MUTATIONS=10000 (docs/dev/fuzzing.md).
  const char* wanted = std::getenv("KERBSTONE_MUTATIONS");
  const int rounds = wanted == nullptr ? 1000 : std::atoi(wanted);
  for (int round = 0; round < rounds; ++round) {
    std::string text = good;
    for (unsigned change = random() % 8; change-- > 0;) {
      const std::size_t at = random() % text.size();
      if (random() % 3 == 0)
        text.erase(at, random() % 5);
      else
        text.insert(at, 1, alphabet[random() % alphabet.size()]);
      if (text.empty()) text = "a";
    }
    std::ofstream(file.path(), std::ios::binary | std::ios::trunc) << text;
    try {
      read_recipe(file.path());
      ++read;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr(file.path()));
    }
  }
  EXPECT_GT(read, rounds / 20);  // most mutants are refused, some are not
  EXPECT_LT(read, rounds - rounds / 20);
}

TEST(Recipe, ForAMeshTakesItsStem) {
  const Recipe recipe = recipe_for_mesh("/some/where/g-track-1.ac");
  EXPECT_EQ(recipe.name, "g-track-1");
  EXPECT_EQ(recipe.mesh_path, "/some/where/g-track-1.ac");
}

}  // namespace recipe_test
}  // namespace road
