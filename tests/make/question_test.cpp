// Where a mesh leaves two readings, each answer that is printed leads to its road.
#include "make/question.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/json_text.h"
#include "make/make_track.h"
#include "mesh/export_mesh.h"
#include "support/ring_strips.h"
#include "support/temporary_folder.h"

namespace question_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kLength_m = support::kRingLength_m;

struct Built {
  std::vector<road::Candidate> answers;
  std::string asked;       ///< empty: a road
  nlohmann::json summary;  ///< of the road
};

class Question : public ::testing::Test {
 protected:
  Built build(const road::Mesh& mesh, const std::function<void(road::Recipe&)>& told = {}) {
    road::export_mesh(mesh, folder_.path("ring.obj"), {road::UpAxis::z, road::Unit::m});
    road::Recipe recipe = road::recipe_for_mesh(folder_.path("ring.obj"));
    recipe.reference_line.u_step_m = recipe.sample.v_step_m = 0.5;
    if (told) told(recipe);
    Built built;
    try {
      const auto result = road::make_track(recipe, folder_.path("out"));
      built.summary = base::parse_json<nlohmann::json>(result.summary_json);
    } catch (const road::Question& question) {
      built.asked = question.what();
      built.answers = question.candidates();
    }
    return built;
  }
  support::TemporaryFolder folder_;
};

/// 12 m wide, its sides lower than its middle by this; all one object.
road::Mesh ring(double crown_m) {
  road::Mesh mesh;
  support::add_ring_strip(mesh, "road", -6.0, 0.0, 5.0 - crown_m, 5.0);
  support::add_ring_strip(mesh, "road", 0.0, 6.0, 5.0, 5.0 - crown_m);
  for (Eigen::Vector3d& v : mesh.vertices_m) v.z() += 2.0 * v.x() / support::kRing_m;
  return mesh;
}

/// By the signs of y and z; the faces go with their corners.
road::Mesh reflected(road::Mesh mesh, double y, double z) {
  for (Eigen::Vector3d& v : mesh.vertices_m) v.y() *= y, v.z() *= z;
  return mesh;
}

TEST_F(Question, ACrownTellsWhichWayIsUp) {
  const Built built = build(reflected(ring(0.12), -1.0, -1.0));
  EXPECT_THAT(built.asked, IsEmpty());
  EXPECT_EQ(built.summary["read"]["up"], "-z");
  EXPECT_THAT(built.summary["read"]["up_why"].get<std::string>(), HasSubstr("crowned"));
  EXPECT_TRUE(built.summary["validation"]["passed"].get<bool>());
}

TEST_F(Question, ACrownAgainstTheFacesTellsThatThePlanMayBeMirrored) {
  const road::Mesh mesh = reflected(ring(0.12), -1.0, 1.0);
  const Built built = build(mesh);
  ASSERT_EQ(built.answers.size(), 3u) << built.asked;
  EXPECT_EQ(built.answers[0].flags, "--up z --mirror");
  EXPECT_EQ(built.answers[1].flags, "--up z");
  EXPECT_EQ(built.answers[2].flags, "--up -z");
  const Built taken = build(mesh, [](road::Recipe& recipe) {
    recipe.read.up = road::UpAxis::z;
    recipe.read.mirror = true;
  });
  EXPECT_TRUE(taken.summary["validation"]["passed"].get<bool>());
  EXPECT_NEAR(taken.summary["reference_line"]["length_m"].get<double>(), kLength_m, 0.5);
}

TEST_F(Question, ATroughMayHaveItsHeightsNegated) {
  const road::Mesh mesh = reflected(ring(0.12), 1.0, -1.0);
  const std::string failures = build(mesh).summary["validation"]["failures"].dump();
  EXPECT_THAT(failures, HasSubstr("give --up -z --mirror"));
  const Built taken = build(mesh, [](road::Recipe& recipe) {
    recipe.read.up = road::UpAxis::minus_z;
    recipe.read.mirror = true;
  });
  EXPECT_TRUE(taken.summary["validation"]["passed"].get<bool>());
  const Built trough = build(mesh, [](road::Recipe& recipe) { recipe.read.up = road::UpAxis::z; });
  EXPECT_TRUE(trough.summary["validation"]["passed"].get<bool>());
}

/// Two straights of 200 m, 6 degrees steep, and bends of 140 m, 30 degrees steep, above an apron
/// that is level: most of the lap is bend.
road::Mesh oval() {
  constexpr double kStraight_m = 200.0, kRadius_m = 140.0, kBend_m = M_PI * kRadius_m;
  constexpr int kRows = 1280;
  road::Mesh mesh;
  mesh.objects.resize(2);
  mesh.objects[0].name = "road", mesh.objects[1].name = "apron grass";
  for (int i = 0; i < kRows; ++i) {
    const double s = (2.0 * (kStraight_m + kBend_m)) * i / kRows;
    const double half = std::fmod(s, kStraight_m + kBend_m), in_bend = half - kStraight_m;
    const double angle = std::max(0.0, in_bend) / kRadius_m;
    const double turned = s < kStraight_m + kBend_m ? 0.0 : M_PI;
    // 60 m from one slope to the other, half of it in the bend.
    const double into = std::min(in_bend + 30.0, kBend_m - in_bend + 30.0) / 60.0;
    const double before = (30.0 - half) / 60.0;  // the end of the bend before
    const double share = std::clamp(std::max(into, before), 0.0, 1.0);
    const double slope = std::tan((6.0 + 24.0 * share) * M_PI / 180.0);
    for (const auto& [left_m, z_m] :
         {std::pair{-7.0, 14.0 * slope}, {0.0, 7.0 * slope}, {7.0, 0.0}, {12.0, 0.0}}) {
      const double out_m = kRadius_m - left_m;
      const Eigen::Vector2d at = in_bend < 0.0
                                     ? Eigen::Vector2d(half - 0.5 * kStraight_m, -out_m)
                                     : Eigen::Vector2d(0.5 * kStraight_m + out_m * std::sin(angle),
                                                       -out_m * std::cos(angle));
      const Eigen::Vector2d turned_at = Eigen::Rotation2Dd(turned) * at;
      mesh.vertices_m.emplace_back(turned_at.x(), turned_at.y(), z_m);
    }
  }
  for (std::uint32_t i = 0; i < kRows; ++i)
    for (std::uint32_t column = 0; column < 3; ++column) {
      const std::uint32_t a = 4 * i + column, b = 4 * ((i + 1) % kRows) + column;
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({b, b + 1, a + 1});
      mesh.object_of_triangle.insert(mesh.object_of_triangle.end(), 2, column == 2 ? 1 : 0);
    }
  return mesh;
}

// The slope of most of its places was taken for that of all of them: its bends were then the
// straights.
TEST_F(Question, AnOvalThatIsMostlyBendIsTheRightWayUp) {
  const Built built = build(oval());
  EXPECT_THAT(built.asked, IsEmpty());
  EXPECT_TRUE(built.summary["validation"]["passed"].get<bool>())
      << built.summary["validation"]["failures"].dump();
  const std::string failures = build(reflected(oval(), 1.0, -1.0)).summary["validation"].dump();
  EXPECT_THAT(failures, HasSubstr("give --up -z --mirror"));
}

TEST_F(Question, ALevelRoadIsAskedForAllThreeWays) {
  for (const double y : {-1.0, 1.0}) {
    const Built built = build(reflected(ring(0.0), y, -y));
    if (y > 0.0) {
      EXPECT_THAT(built.asked, IsEmpty()) << "faces look up";
      continue;
    }
    ASSERT_EQ(built.answers.size(), 3u) << built.asked;
    EXPECT_EQ(built.answers[0].flags, "--up -z");
    EXPECT_THAT(built.asked, HasSubstr("--up z --mirror"));
  }
}

/// A road of 8 m, and beside it on the left ground in columns of these widths that falls by 5 % and
/// is `uneven_m`; one object without a name.
road::Mesh beside(std::initializer_list<double> widths_m, double uneven_m) {
  road::Mesh mesh;
  const auto add = [&](double right_m, double left_m, double z_right_m, double z_left_m) {
    support::add_ring_strip(mesh, "", right_m, left_m, z_right_m, z_left_m);
  };
  add(-4.0, 0.0, -0.08, 0.0);
  add(0.0, 4.0, 0.0, -0.08);
  double at_m = 4.0, z_m = -0.08;
  for (const double width_m : widths_m) {
    add(at_m, at_m + width_m, z_m, z_m - 0.05 * width_m);
    at_m += width_m, z_m -= 0.05 * width_m;
  }
  for (Eigen::Vector3d& v : mesh.vertices_m) {
    const double left_m = support::kRing_m - v.head<2>().norm();
    if (left_m > 4.5) v.z() += uneven_m * std::sin(7e3 * std::atan2(v.y(), v.x()) + left_m);
  }
  mesh.objects.resize(1);
  std::fill(mesh.object_of_triangle.begin(), mesh.object_of_triangle.end(), 0);
  return mesh;
}

TEST_F(Question, OfStripsSideBySideEachIsAnAnswer) {
  const road::Mesh mesh = beside({10.0}, 0.05);
  const Built built = build(mesh);
  ASSERT_EQ(built.answers.size(), 3u) << built.asked;
  EXPECT_THAT(built.asked, HasSubstr("question.png"));
  EXPECT_NEAR(built.answers[0].width_m, 8.0, 0.1) << "the even strip comes first";
  EXPECT_THAT(built.answers.back().flags, HasSubstr(" --guide-width-m 18.0"));
  const road::Candidate& answer = built.answers[0];
  double x_m = 0.0, y_m = 0.0;
  ASSERT_EQ(std::sscanf(answer.flags.c_str(), "--near-m %lf,%lf", &x_m, &y_m), 2);
  const Built taken =
      build(mesh, [&](road::Recipe& recipe) { recipe.clean.near_m = Eigen::Vector2d(x_m, y_m); });
  ASSERT_THAT(taken.asked, IsEmpty());
  EXPECT_TRUE(taken.summary["validation"]["passed"].get<bool>());
  EXPECT_NEAR(taken.summary["reference_line"]["length_m"].get<double>(), kLength_m, 0.5);
  EXPECT_NEAR(taken.summary["centreline"]["width_median_m"].get<double>(), 8.0, 0.1);
}

TEST_F(Question, TwoHalvesAreRatherOneRoad) {
  road::Mesh mesh = ring(-0.12);
  for (road::MeshObject& object : mesh.objects) object = {};
  const Built built = build(mesh, [](road::Recipe& recipe) { recipe.read.up = road::UpAxis::z; });
  ASSERT_EQ(built.answers.size(), 3u) << built.asked;
  EXPECT_NEAR(built.answers[0].width_m, 12.0, 0.1);
}

TEST_F(Question, AllColumnsInOnePlaneAreTheFirstAnswer) {
  road::Mesh mesh;
  for (const auto& [right_m, left_m] : {std::pair(-5.0, -3.0), {-3.0, 3.0}, {3.0, 5.0}})
    support::add_ring_strip(mesh, "", right_m, left_m, 0.0, 0.0);
  mesh.objects.resize(1);
  std::fill(mesh.object_of_triangle.begin(), mesh.object_of_triangle.end(), 0);
  const Built built = build(mesh);
  ASSERT_EQ(built.answers.size(), 2u) << built.asked;
  EXPECT_NEAR(built.answers[0].width_m, 10.0, 0.1);
  EXPECT_THAT(built.answers[0].flags, HasSubstr(" --guide-width-m 10.0"));
  EXPECT_NEAR(built.answers[1].width_m, 6.0, 0.1);
}

TEST_F(Question, TheUnitComesBeforeTheStrips) {
  road::Mesh mesh = beside({10.0}, 0.05);
  for (Eigen::Vector3d& v : mesh.vertices_m) v /= 0.3048;
  const Built built = build(mesh);
  EXPECT_THAT(built.asked, IsEmpty()) << "an answer of these would be in the wrong unit";
  EXPECT_THAT(built.summary["validation"]["failures"].dump(), HasSubstr("--unit"));
}

TEST_F(Question, AWidthThatIsRoundInFeetAloneIsDoubted) {
  const auto wide = [&](double metres, double per_unit) {
    road::Mesh mesh;
    support::add_ring_strip(mesh, "road", -0.5 * metres, 0.5 * metres, 0.0, 0.0);
    for (Eigen::Vector3d& v : mesh.vertices_m) v /= per_unit;
    return build(mesh).summary;
  };
  EXPECT_THAT(wide(4.0, 0.3048)["validation"]["failures"].dump(),
              HasSubstr("with --unit ft there is a closed road of 628 m, 4.0 m wide"));
  EXPECT_THAT(wide(6.37, 0.3048)["validation"]["failures"].dump(),
              HasSubstr("with --unit ft there is a closed road of 628 m, 6.4 m wide"))
      << "wide, and round in neither";
  EXPECT_THAT(wide(4.13, 0.3048)["read"]["unit_why"].get<std::string>(),
              HasSubstr("4.1 m wide and 628 m long (--unit ft)"));
  const nlohmann::json summary = wide(18.0, 1.0);
  EXPECT_TRUE(summary["validation"]["passed"].get<bool>());
  EXPECT_THAT(summary["read"]["remarks"].dump(), HasSubstr("--unit ft"));
}

TEST_F(Question, TheUnitsOfAMeshThatIsNoRoadsSizeAreTried) {
  road::Mesh mesh = ring(0.12);
  for (Eigen::Vector3d& v : mesh.vertices_m) v /= 1609.344;
  const Built built = build(mesh);
  ASSERT_EQ(built.answers.size(), 2u) << built.asked;
  EXPECT_EQ(built.answers[0].flags, "--unit mile");
  EXPECT_NEAR(built.answers[0].width_m, 12.0, 0.1);
  EXPECT_EQ(built.answers[1].flags, "--unit km");
}

TEST_F(Question, UnitAndWayUpAreAskedForAtOnce) {
  road::Mesh mesh = reflected(ring(0.12), -1.0, 1.0);
  for (Eigen::Vector3d& v : mesh.vertices_m) v /= 1609.344;
  const Built built = build(mesh);
  ASSERT_GE(built.answers.size(), 3u) << built.asked;
  EXPECT_EQ(built.answers[0].flags, "--unit mile --up z --mirror");
  EXPECT_NEAR(built.answers[0].width_m, 12.0, 0.1);
}

TEST_F(Question, CentimetresOfNoKnownWayUpAreAskedForAtOnce) {
  road::Mesh mesh = reflected(ring(0.12), -1.0, 1.0);
  for (Eigen::Vector3d& v : mesh.vertices_m) v /= 0.01;
  const Built built = build(mesh);  // 20 km across: nothing refuses that as metres
  ASSERT_GE(built.answers.size(), 3u) << built.asked;
  EXPECT_EQ(built.answers[0].flags, "--unit cm --up z --mirror");
  EXPECT_NEAR(built.answers[0].width_m, 12.0, 0.1);
}

TEST_F(Question, AShortPieceBeyondAGapAtAnEndIsNotLost) {
  const auto z_up = [](road::Recipe& recipe) { recipe.read.up = road::UpAxis::z; };
  const auto with_gap = [&](double gap_m) {  // nameless, 40 m beyond it
    road::Mesh mesh;
    support::add_ring_strip(mesh, "", -5.0, 5.0, 0.0, 0.0, 0.0, 360.0);
    support::add_ring_strip(mesh, "", -5.0, 5.0, 0.0, 0.0, 360.0 + gap_m, 400.0 + gap_m);
    mesh.objects.resize(1);
    std::fill(mesh.object_of_triangle.begin(), mesh.object_of_triangle.end(), 0);
    return build(mesh, z_up).summary;
  };
  EXPECT_NEAR(with_gap(5.0)["reference_line"]["length_m"].get<double>(), 405.0, 2.0);
  EXPECT_THAT(with_gap(20.0)["validation"]["failures"].dump(), HasSubstr("--bridge-gap-m 27"));
}

TEST_F(Question, AnAnswerBridgesTheGapsOnItsWay) {
  road::Mesh mesh;
  support::add_ring_strip(mesh, "road", -5.0, 5.0, 0.0, 0.0, 0.0, 550.0);
  support::add_ring_strip(mesh, "road", -5.0, 5.0, 0.0, 0.0, 555.0, kLength_m - 5.0);
  const Built built = build(reflected(mesh, -1.0, 1.0));
  ASSERT_EQ(built.answers.size(), 3u) << built.asked;
  for (const road::Candidate& answer : built.answers) {
    EXPECT_THAT(answer.flags, HasSubstr(" --bridge-gap-m "));
    EXPECT_TRUE(answer.closed) << "the short piece is a part of the road";
  }
}

TEST_F(Question, TheOnlyStripOfAnOpenRoadIsAnAnswerUnlessItIsShort) {
  road::Mesh mesh;
  support::add_ring_strip(mesh, "", -4.0, 4.0, 0.0, 0.0, 0.0, 400.0);
  support::add_ring_strip(mesh, "", -95.0, -4.0, -30.0, -2.0, 0.0, 400.0);
  mesh.objects.resize(1);
  std::fill(mesh.object_of_triangle.begin(), mesh.object_of_triangle.end(), 0);
  const Built built = build(mesh);
  ASSERT_GE(built.answers.size(), 1u) << built.asked;
  EXPECT_THAT(built.answers[0].flags, HasSubstr("--near-m"));
  EXPECT_NEAR(built.answers[0].width_m, 8.0, 0.1);
  for (Eigen::Vector3d& v : mesh.vertices_m) v /= 20.0;
  for (const road::Candidate& answer : build(mesh).answers)
    EXPECT_THAT(answer.flags, Not(HasSubstr("--near-m"))) << "20 m of a plate";
}

}  // namespace question_test
