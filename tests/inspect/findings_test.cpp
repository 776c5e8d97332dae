#include "inspect/findings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

#include "crg/file.h"
#include "support/oval_road.h"

namespace findings_test {

using test_support::Oval;
using test_support::oval_road;
using test_support::OvalOptions;
using test_support::plant;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<road::Finding> defects(const Oval& oval) {
  // Through the file, as a report sees it.
  const crg::Surface surface(crg::make_crg(oval.line, oval.grid));
  const road::HeightMap map = road::height_map(surface);
  road::FindingOptions options;
  options.closed = oval.line.closed;
  return road::find_defects(map, road::find_kerb_strips(map), options);
}

/// Made once: most tests plant into a copy of it.
const Oval& clean_oval() {
  static const Oval oval = oval_road();
  return oval;
}

/// The only finding is of this kind and within 5 m of [begin, end].
void expect_only(const std::vector<road::Finding>& found, const std::string& kind, double u_begin_m,
                 double u_end_m, double value, double tolerance) {
  ASSERT_EQ(found.size(), 1u) << [&] {
    std::string all;
    for (const auto& f : found) all += f.kind + ": " + f.text + "\n";
    return all;
  }();
  EXPECT_EQ(found[0].kind, kind);
  EXPECT_NEAR(found[0].u_begin_m, u_begin_m, 5.0);
  EXPECT_NEAR(found[0].u_end_m, u_end_m, 5.0);
  EXPECT_NEAR(found[0].value, value, tolerance) << found[0].text;
}

TEST(Findings, CleanRoadsOfEveryOrdinaryClassHaveNone) {
  for (const char iso_class : {'\0', 'B', 'C', 'D'}) {
    for (const double kerb_height_m : {0.025, 0.2}) {
      // Waves of class D are as high as kerbs: high kerbs on such a road are not told from bumps.
      if (iso_class == 'D' && kerb_height_m > 0.1) continue;
      OvalOptions options;
      options.iso_class = iso_class;
      options.kerb_height_m = kerb_height_m;
      for (const auto& f : defects(oval_road(options)))
        ADD_FAILURE() << iso_class << " " << kerb_height_m << " " << f.kind << ": " << f.text;
    }
  }
}

TEST(Findings, CleanRoadOnACoarseGridHasNone) {
  OvalOptions options;
  options.u_step_m = 0.5;
  options.v_step_m = 0.25;
  for (const auto& f : defects(oval_road(options))) ADD_FAILURE() << f.kind << ": " << f.text;
}

TEST(Findings, TileStep) {
  Oval oval = oval_road();
  // Up at 200.03 m and down again so slowly that only the step shows.
  plant(oval, [](double u, double) {
    return u < 200.03 || u > 800.0 ? 0.0 : 0.02 * (1.0 - (u - 200.03) / 599.97);
  });
  expect_only(defects(oval), "tile_step", 200.0, 200.0, 0.02, 0.002);
}

TEST(Findings, HoleOfOneNode) {
  Oval oval = clean_oval();
  plant(oval, [](double u, double v) {
    return std::abs(u - 431.2) < 0.05 && std::abs(v + 2.3) < 0.03 ? kNan : 0.0;
  });
  const auto found = defects(oval);
  expect_only(found, "hole", 431.2, 431.2, 0.1, 0.01);
  EXPECT_NEAR(found[0].v_begin_m, -2.3, 0.06);
  EXPECT_EQ(found[0].severity, road::Severity::remark);
}

TEST(Findings, DeepHole) {
  Oval oval = clean_oval();
  plant(oval,
        [](double u, double v) { return std::hypot(u - 700.0, v - 1.0) < 0.5 ? -0.05 : 0.0; });
  expect_only(defects(oval), "pothole", 700.0, 700.0, 0.05, 0.015);
}

TEST(Findings, LargeHoleIsAnError) {
  Oval oval = clean_oval();
  plant(oval, [](double u, double v) { return std::hypot(u - 700.0, v - 1.0) < 1.0 ? kNan : 0.0; });
  const auto found = defects(oval);
  expect_only(found, "hole", 699.0, 701.0, 2.0, 0.21);
  EXPECT_EQ(found[0].severity, road::Severity::error);
}

TEST(Findings, StripesAcrossAndAlong) {
  Oval across = clean_oval();
  plant(across, [](double u, double) { return u > 333.0 && u < 333.35 ? kNan : 0.0; });
  expect_only(defects(across), "nan_stripe", 333.0, 333.3, 0.35, 0.1);
  Oval partly = clean_oval();
  plant(partly,
        [](double u, double v) { return u > 333.0 && u < 333.35 && v > -3.0 ? kNan : 0.0; });
  expect_only(defects(partly), "nan_stripe", 333.0, 333.3, 0.35, 0.1);
  Oval along = clean_oval();
  plant(along, [](double u, double v) {
    return u > 100.0 && u < 160.0 && std::abs(v - 1.25) < 0.1 ? kNan : 0.0;
  });
  expect_only(defects(along), "nan_stripe", 100.0, 160.0, 60.0, 0.3);
}

TEST(Findings, AGapAslantIsBridgedOverAllOfItsLength) {
  Oval oval = clean_oval();
  const double widest_m = oval.grid.v_m.back();
  plant(oval, [&](double u, double v) {
    return std::abs(u - 150.0 - 2.0 * v / widest_m) < 2.3 ? kNan : 0.0;
  });
  const auto found = defects(oval);
  ASSERT_FALSE(found.empty());
  EXPECT_NE(found[0].text.find("--bridge-gap-m 6 closes it"), std::string::npos) << found[0].text;
}

TEST(Findings, FoldInATightBend) {
  OvalOptions options;
  options.radius_m = 8.0;  // the grid reaches 9 m to the inside
  options.kerb_height_m = 0.0;
  const auto found = defects(oval_road(options));
  ASSERT_EQ(found.size(), 2u);
  for (const auto& f : found) {
    EXPECT_EQ(f.kind, "fold");
    EXPECT_NEAR(f.value, 1.0, 0.05);
    EXPECT_EQ(f.severity, road::Severity::error);
  }
  EXPECT_NEAR(found[0].u_begin_m, 300.0, 1.0);
  EXPECT_NEAR(found[0].u_end_m, 300.0 + 8.0 * M_PI, 1.0);
}

TEST(Findings, SeamInHeight) {
  Oval oval = clean_oval();
  const double end = oval.grid.u_of(oval.grid.rows() - 1);
  plant(oval, [&](double u, double) { return 0.03 * std::max(0.0, (u - end + 200.0) / 200.0); });
  expect_only(defects(oval), "wrong_seam", end, end, -0.03, 0.002);
}

TEST(Findings, SeamInThePlan) {
  Oval gap = clean_oval();
  gap.line.x_m.resize(gap.line.x_m.size() - 100);
  gap.line.y_m.resize(gap.line.x_m.size());
  gap.line.heading_rad.resize(gap.line.x_m.size());
  gap.grid.z_m.resize(gap.line.x_m.size() * gap.grid.columns());
  const double end = gap.grid.u_of(gap.grid.rows() - 1);
  crg::Crg file = crg::make_crg(gap.line, gap.grid);
  const crg::Surface surface(file);
  const road::HeightMap map = road::height_map(surface);
  road::FindingOptions options;
  options.closed = true;
  expect_only(road::find_defects(map, road::find_kerb_strips(map), options), "wrong_seam", end, end,
              10.0, 0.1);
}

TEST(Findings, ARoadThatIsClosedButDoesNotSaySo) {
  Oval oval = clean_oval();
  oval.line.closed = false;
  const double end = oval.grid.u_of(oval.grid.rows() - 1);
  expect_only(defects(oval), "wrong_seam", end, end, 0.0, 0.01);
}

TEST(Findings, AnOpenRoadMayEndAslant) {
  Oval oval = clean_oval();
  oval.line.closed = false;
  const std::size_t rows = oval.grid.rows() / 2;
  for (auto* values : {&oval.line.x_m, &oval.line.y_m, &oval.line.heading_rad})
    values->resize(rows);
  oval.grid.z_m.resize(rows * oval.grid.columns());
  plant(oval, [](double u, double v) { return u < 0.25 && v > -5.0 && v < -1.0 ? kNan : 0.0; });
  EXPECT_EQ(road::verdict_of(defects(oval)), road::Verdict::usable_with_remarks);
}

TEST(Findings, BumpsOfManyShapes) {
  for (const double length_m : {0.4, 1.0, 2.0, 4.0}) {
    for (const double width_m : {1.0, 100.0}) {
      Oval oval = clean_oval();
      plant(oval, [&](double u, double v) {
        const double s = 2.0 * std::abs(u - 150.0) / length_m,
                     t = 2.0 * std::abs(v + 1.0) / width_m;
        return s > 1.0 || t > 1.0
                   ? 0.0
                   : 0.1 * 0.5 * (1.0 + std::cos(M_PI * s)) * 0.5 * (1.0 + std::cos(M_PI * t));
      });
      expect_only(defects(oval), "bump", 150.0, 150.0, 0.1, 0.02);
    }
  }
}

TEST(Findings, ABumpOnAClassDRoadIsStillFound) {
  OvalOptions options;
  options.iso_class = 'D';
  Oval oval = oval_road(options);
  plant(oval, [&](double u, double) {
    return std::abs(u - 150.0) > 1.0 ? 0.0 : 0.1 * 0.5 * (1.0 + std::cos(M_PI * (u - 150.0)));
  });
  expect_only(defects(oval), "bump", 150.0, 150.0, 0.1, 0.04);
}

TEST(Findings, WavesAreOneFinding) {
  Oval oval = clean_oval();
  // A zigzag of 10 m, as coarse meshes have it, over eight waves.
  plant(oval, [](double u, double) {
    if (u < 100.0 || u > 180.0) return 0.0;
    const double phase = std::fmod(u - 100.0, 10.0) / 10.0;
    return phase < 0.25 ? 0.4 * phase : phase < 0.75 ? 0.2 - 0.4 * phase : 0.4 * phase - 0.4;
  });
  const auto found = defects(oval);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].u_begin_m, 100.0, 5.0);
  EXPECT_NEAR(found[0].u_end_m, 180.0, 5.0);
  double height_mm = 0.0, wave_m = 0.0;
  ASSERT_EQ(std::sscanf(found[0].text.c_str(), "Waves of up to %lf mm, %lf m from crest to crest",
                        &height_mm, &wave_m),
            2)
      << found[0].text;
  EXPECT_NEAR(wave_m, 10.0, 0.2);
}

TEST(Findings, OneJumpIsAnErrorFourAreTheTrack) {
  for (const int jumps : {1, 3, 4}) {
    Oval oval = clean_oval();
    plant(oval, [&](double u, double) {  // flat tops of 12 m with ramps of 3 m, 60 m apart
      const double from_m =
          u < 100.0 || u > 100.0 + 60.0 * jumps ? 60.0 : std::fmod(u - 100.0, 60.0);
      return 0.8 * std::clamp((9.0 - std::abs(from_m - 9.0)) / 3.0, 0.0, 1.0);
    });
    const auto found = defects(oval);
    ASSERT_FALSE(found.empty());
    EXPECT_NEAR(found[0].u_begin_m, 100.0, 5.0);
    EXPECT_EQ(road::verdict_of(found),
              jumps < 4 ? road::Verdict::not_usable : road::Verdict::usable_with_remarks);
  }
}

TEST(Findings, TwoJumpsNearEachOtherAreAnError) {
  for (const double apart_m : {7.0, 9.0, 12.0}) {
    Oval oval = clean_oval();
    plant(oval, [&](double u, double) {  // flat tops of 3 m with ramps of 1.5 m
      const double off_m = std::min(std::abs(u - 100.0), std::abs(u - 100.0 - apart_m));
      return 0.8 * std::clamp((3.0 - off_m) / 1.5, 0.0, 1.0);
    });
    EXPECT_EQ(road::verdict_of(defects(oval)), road::Verdict::not_usable) << apart_m;
  }
}

TEST(Findings, VerdictFollowsTheWorst) {
  road::Finding remark, error;
  error.severity = road::Severity::error;
  EXPECT_EQ(road::verdict_of({}), road::Verdict::usable);
  EXPECT_EQ(road::verdict_of({remark}), road::Verdict::usable_with_remarks);
  EXPECT_EQ(road::verdict_of({remark, error, remark}), road::Verdict::not_usable);
}

TEST(Findings, ManyPlacesAreCutWithAWord) {
  Oval oval = clean_oval();
  plant(oval, [](double u, double v) {
    return std::fmod(u + 0.03, 2.0) < 0.06 && std::abs(v) < 0.03 ? kNan : 0.0;
  });
  const auto found = defects(oval);
  ASSERT_EQ(found.size(), 201u);
  bool said = false;
  for (const auto& f : found) said = said || f.text.find("more places") != std::string::npos;
  EXPECT_TRUE(said);
}

TEST(KerbStrips, AreFoundWithPlaceHeightAndWidth) {
  for (const char iso_class : {'\0', 'B', 'C'}) {
    OvalOptions options;
    options.iso_class = iso_class;
    const Oval oval = oval_road(options);
    const crg::Surface surface(crg::make_crg(oval.line, oval.grid));
    const road::KerbStrips kerbs = road::find_kerb_strips(road::height_map(surface));
    ASSERT_EQ(kerbs.strips.size(), 4u) << iso_class << [&] {
      std::string all;
      for (const auto& k : kerbs.strips)
        all += "\n" + std::to_string(k.u_begin_m) + " " + std::to_string(k.u_end_m) + " " +
               std::to_string(k.v_begin_m) + " " + std::to_string(k.v_end_m) + " " +
               std::to_string(k.height_m);
      return all;
    }();
    for (const road::KerbStrip& kerb : kerbs.strips) {
      const double bend = kerb.u_begin_m < 500.0 ? 300.0 : 600.0 + 60.0 * M_PI;
      // Roughness of class C has 10 mm waves of a few metres: ends and heights blur by as much.
      EXPECT_NEAR(kerb.u_begin_m, bend + 20.0, iso_class == 'C' ? 3.0 : 2.0);
      EXPECT_NEAR(kerb.u_end_m, bend + 60.0, iso_class == 'C' ? 3.0 : 2.0);
      EXPECT_NEAR(std::abs(kerb.v_begin_m), 6.0, 0.21);
      EXPECT_NEAR(std::abs(kerb.v_end_m), 7.0, 0.21);
      EXPECT_NEAR(kerb.height_m, 0.06, iso_class == 'C' ? 0.02 : 0.01);
      EXPECT_EQ(kerb.left, kerb.v_begin_m > 0.0);
    }
  }
}

}  // namespace findings_test
