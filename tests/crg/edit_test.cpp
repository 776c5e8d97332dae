#include "crg/edit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "crg/check.h"
#include "crg/error.h"
#include "crg/surface.h"
#include "roads.h"

namespace crg {
namespace edit_test {

// A smooth height in map coordinates, so that the same place can be compared whatever its (u, v).
Crg hilly(std::size_t rows = 301, double u_step = 0.2) {
  ReferenceLine line = test::line_along(
      rows, u_step, [](double u) { return 0.02 * std::sin(0.1 * u); }, 30.0, -20.0, 0.5);
  for (std::size_t i = 0; i < rows; ++i) {
    line.z_m.push_back(3.0 + 0.001 * static_cast<double>(i));
    line.banking.push_back(0.0001 * static_cast<double>(i));
  }
  Crg crg = make_crg(
      line,
      test::grid_of(line, -3.0, 2.0, 26,
                    [](double u, double v) { return 0.1 * std::sin(0.5 * u) * std::cos(v); }),
      {"hills"});
  set_value(crg.options, "BORDER_SMOOTH_UBEG", 0.0);
  return crg;
}

double worst_height_difference(const Crg& a, const Crg& b, double inset) {
  const Surface one(a), other(b);
  Cursor c1, c2;
  const Grid& grid = b.grid;
  double worst = 0.0;
  for (double u = grid.u_begin_m + inset; u < grid.u_of(grid.rows() - 1) - inset; u += 0.137) {
    for (double v = grid.v_m.front() + inset; v < grid.v_m.back() - inset; v += 0.093) {
      const Point2 p = other.xy_of_uv(u, v);
      worst = std::max(worst,
                       std::abs(one.z_at_xy(p.x_m, p.y_m, c1) - other.z_at_xy(p.x_m, p.y_m, c2)));
    }
  }
  return worst;
}

void expect_no_errors(const Crg& crg) {
  for (const Finding& finding : check(crg).findings)
    EXPECT_EQ(finding.severity, Severity::Note) << finding.rule << ": " << finding.message;
}

TEST(Edit, CropKeepsPlaceAndHeight) {
  const Crg road = hilly();
  const Crg part = crop(road, {.u_begin_m = 10.05, .u_end_m = 40.0, .v_left_m = 1.0});
  EXPECT_NEAR(part.grid.u_begin_m, 10.0, 1e-12);
  EXPECT_NEAR(part.grid.u_of(part.grid.rows() - 1), 40.0, 1e-9);
  EXPECT_EQ(part.grid.v_m.front(), -3.0);
  EXPECT_NEAR(part.grid.v_m.back(), 1.0, 1e-12);
  EXPECT_EQ(part.comment, road.comment);
  // Rounded headings aim anew from the first row on; inside the first cells mitres differ.
  EXPECT_LT(worst_height_difference(road, part, 0.3), 1e-6);
  expect_no_errors(part);
  EXPECT_THROW(crop(road, {.u_begin_m = 70.0}), Error);
}

TEST(Edit, ResampleKeepsTheSurface) {
  const Crg road = hilly();
  const Crg fine = resample(road, {.u_step_m = 0.1, .v_step_m = 0.1});
  EXPECT_NEAR(fine.grid.u_step_m, 0.1, 1e-4);
  EXPECT_EQ(fine.grid.columns(), 51U);
  EXPECT_EQ(fine.grid.rows(), 601U);
  const ReferenceLine a = integrate_reference_line(road), b = integrate_reference_line(fine);
  EXPECT_LT(std::hypot(a.x_m.back() - b.x_m.back(), a.y_m.back() - b.y_m.back()), 1e-5);
  // New nodes fall between old ones; measured 1.3e-3 on waves of 0.1 m.
  EXPECT_LT(worst_height_difference(road, fine, 0.3), 3e-3);
  expect_no_errors(fine);
  const Crg coarse = resample(fine, {.u_step_m = 0.2, .v_step_m = 0.2});
  EXPECT_LT(worst_height_difference(road, coarse, 0.3), 5e-3);
  const Crg same = resample(road, {});
  EXPECT_LT(worst_height_difference(road, same, 0.3), 1e-6);
}

TEST(Edit, ResampledCircuitStaysClosed) {
  const ReferenceLine line = test::circuit(801, 20.0, 0.1, 2);
  const Crg road =
      make_crg(line, test::grid_of(line, -3.0, 3.0, 7, [](double, double v) { return 0.01 * v; }));
  const Crg coarse = resample(road, {.u_step_m = 0.4});
  EXPECT_TRUE(integrate_reference_line(coarse).closed);
  EXPECT_LT(worst_height_difference(road, coarse, 0.1), 2e-3);
}

TEST(Edit, ReverseIsTheSameSurfaceDrivenBackwards) {
  const Crg road = hilly();
  const Crg back = reverse(road);
  EXPECT_EQ(back.grid.v_m.front(), -2.0);
  EXPECT_LT(worst_height_difference(road, back, 0.3), 1e-6);
  const Surface a(road), b(back);
  const Sample there = a.at_uv(20.0, 1.0), here = b.at_uv(40.0, -1.0);
  EXPECT_NEAR(here.x_m, there.x_m, 1e-6);
  EXPECT_NEAR(here.y_m, there.y_m, 1e-6);
  EXPECT_NEAR(here.curvature_1pm, -there.curvature_1pm, 1e-4);
  expect_no_errors(back);
  const Crg again = reverse(back);
  EXPECT_LT(worst_height_difference(road, again, 0.3), 1e-6);
  EXPECT_EQ(again.grid.z_m, road.grid.z_m);
}

TEST(Edit, AppendJoinsWhatCropTookApart) {
  const Crg road = hilly();
  const Crg first = crop(road, {.u_end_m = 30.0}), second = crop(road, {.u_begin_m = 30.0});
  const Crg joined = append(first, second);
  EXPECT_EQ(joined.grid.z_m, road.grid.z_m);
  EXPECT_LT(worst_height_difference(road, joined, 0.3), 1e-6);
  expect_no_errors(joined);
  // Cut between two rows, both share one all the same.
  EXPECT_EQ(append(crop(road, {.u_end_m = 29.93}), crop(road, {.u_begin_m = 29.93})).grid.z_m,
            road.grid.z_m);
  Crg far = second;
  set_value(far.modifiers, "REFLINE_OFFSET_X", 40.0);
  set_value(far.modifiers, "REFLINE_OFFSET_PHI", 0.7);
  set_value(far.modifiers, "REFLINE_OFFSET_Z", 4.0);
  EXPECT_THROW(append(first, far), Error);
  const Crg moved = append(first, far, {.move = true});
  EXPECT_EQ(moved.grid.rows(), road.grid.rows());
  EXPECT_LT(worst_height_difference(road, moved, 0.3), 1e-5);
  EXPECT_THROW(append(first, hilly(50, 0.25)), Error);
}

// Built roads end 1 mm before their start.
TEST(Edit, AppendClosesARingAgainWhereverItWasCut) {
  const ReferenceLine line = test::circuit(2001, 100.0, 0.1, 3);
  const double around_m = line.u_step_m * 2000.0;
  const Crg ring =
      make_crg(line, test::grid_of(line, -3.0, 3.0, 13, [&](double u, double v) {
                 return std::sin(u * 2.0 * std::numbers::pi / around_m) * (1.0 + 0.1 * v);
               }));
  const Crg a = crop(ring, {.u_end_m = 200.0}), b = crop(ring, {.u_begin_m = 200.0});
  EXPECT_FALSE(Surface(a).reference_line().closed);
  const Crg again = append(a, b), turned = append(b, a);
  EXPECT_EQ(again.grid.z_m, ring.grid.z_m);
  EXPECT_EQ(turned.grid.rows(), ring.grid.rows());
  for (const Crg* road : {&again, &turned}) {
    EXPECT_TRUE(Surface(*road).reference_line().closed);
    expect_no_errors(*road);
  }
  EXPECT_LT(worst_height_difference(ring, turned, 0.3), 2e-3);
  Crg raised = b;
  for (std::size_t i = 0; i < raised.grid.rows(); ++i)
    for (std::size_t j = 0; j < raised.grid.columns(); ++j)
      raised.grid.z_m[i * raised.grid.columns() + j] += 1e-4f * static_cast<float>(i);
  EXPECT_FALSE(Surface(append(a, raised)).reference_line().closed) << "a step where it would close";
}

TEST(Edit, AppendNamesTheColumnsThatAgree) {
  const Crg road = hilly();
  const Crg first = crop(road, {.u_end_m = 30.0});
  Crg second = crop(road, {.u_begin_m = 30.0});
  for (std::size_t i = 0; i < second.grid.rows(); ++i)
    second.grid.z_m[i * second.grid.columns()] += 0.1f;
  try {
    append(first, second);
    ADD_FAILURE() << "a step at the edge";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("crop both to v = -2.8 to 2 m"));
  }
  EXPECT_EQ(append(crop(first, {.v_right_m = -2.8}), crop(second, {.v_right_m = -2.8})).grid.rows(),
            road.grid.rows());
}

TEST(Edit, AppendMakesNoCliff) {
  const Crg road = hilly();
  const Crg first = crop(road, {.u_end_m = 30.0}), second = crop(road, {.u_begin_m = 30.0});
  Crg low = second;
  set_value(low.modifiers, "REFLINE_OFFSET_Z", -0.99);
  try {
    append(first, low);
    ADD_FAILURE() << "a cliff of 0.99 m";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("it starts 0.99"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("m below the end of "));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("let the second road be moved (--move)"));
  }
  EXPECT_LT(worst_height_difference(road, append(first, low, {.move = true}), 0.3), 1e-5);
  // A height of the grid's own, which the line knows nothing of.
  Crg raised = second;
  for (float& z : raised.grid.z_m) z += 4.01f;
  EXPECT_THROW(append(first, raised), Error);
  EXPECT_LT(worst_height_difference(road, append(first, raised, {.move = true}), 0.3), 1e-5);
  // Cross sections that differ meet nowhere.
  EXPECT_THROW(append(first, hilly(50), {.move = true}), Error);
}

TEST(Edit, ModifiersAreWorkedIn) {
  Crg road = hilly();
  set_value(road.modifiers, "REFLINE_OFFSET_Z", 7.0);
  const Crg back = reverse(road);
  EXPECT_TRUE(back.modifiers.empty());
  EXPECT_TRUE(back.has_modifier_section);
  EXPECT_NEAR(Surface(back).z_at_uv(30.0, 0.0), Surface(hilly()).z_at_uv(30.0, 0.0) + 7.0, 1e-5);
}

}  // namespace edit_test
}  // namespace crg
