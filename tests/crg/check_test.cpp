#include "crg/check.h"

#include <gtest/gtest.h>

#include <cmath>

#include "roads.h"

namespace crg {
namespace check_test {

Crg good_road() {
  const ReferenceLine line = test::circuit(801, 20.0, 0.1, 2);
  return make_crg(line,
                  test::grid_of(line, -3.0, 3.0, 7, [](double, double v) { return 0.01 * v; }));
}

// The findings of one rule; "" for all.
std::vector<Finding> findings(const Crg& crg, const std::string& rule) {
  std::vector<Finding> result;
  for (const Finding& finding : check(crg).findings) {
    if (rule.empty() || finding.rule == rule) result.push_back(finding);
  }
  return result;
}

void expect_only(const Crg& crg, const std::string& rule, Severity severity) {
  const std::vector<Finding> all = findings(crg, "");
  EXPECT_FALSE(findings(crg, rule).empty()) << "nothing found by " << rule;
  for (const Finding& finding : all) {
    EXPECT_EQ(finding.rule, rule) << finding.message;
    EXPECT_EQ(finding.severity, severity) << finding.message;
  }
}

TEST(Check, FindsNothingInAGoodRoad) {
  for (const Finding& finding : findings(good_road(), ""))
    ADD_FAILURE() << finding.rule << ": " << finding.message;
}

TEST(Check, HeaderAgainstData) {
  for (const auto& [key, value] : {std::pair{"REFERENCE_LINE_END_U", 7.0},
                                   {"REFERENCE_LINE_END_X", 1.0},
                                   {"REFERENCE_LINE_END_PHI", 0.7},
                                   {"LONG_SECTION_V_RIGHT", -2.5}}) {
    Crg crg = good_road();
    set_value(crg.options, "REFLINE_CONTINUATION", 0.0);
    set_value(crg.road, key, value);
    EXPECT_FALSE(findings(crg, "header").empty()) << key;
  }
}

TEST(Check, IncrementsTooSmall) {
  Crg crg = good_road();
  crg.grid.v_m[3] = crg.grid.v_m[2] + 1e-4;
  expect_only(crg, "increment.v", Severity::Error);
  const ReferenceLine fine = test::line_along(5, 1e-4, [](double) { return 0.0; });
  crg = make_crg(fine, test::grid_of(fine, -1.0, 1.0, 2, [](double, double) { return 0.0; }));
  expect_only(crg, "increment.u", Severity::Error);
}

// A bend of 2 m radius under 3 m of road: rows meet at v = 2 and 3.
Crg tight_bend() {
  const ReferenceLine line = test::line_along(100, 0.1, [](double) { return 0.5; });
  return make_crg(line, test::grid_of(line, -3.0, 3.0, 7, [](double, double) { return 0.0; }));
}

TEST(Check, CutsThatMeetWhereThereAreHeightsAreAnError) {
  Crg crg = tight_bend();
  expect_only(crg, "curvature.local", Severity::Error);
  EXPECT_GT(findings(crg, "curvature.local")[0].count, 90U);
  set_value(crg.options, "WARN_CURV_GLOBAL", 0.0);
  expect_only(crg, "curvature.local", Severity::Warning);
  set_value(crg.options, "WARN_CURV_LOCAL", 1.0);
  expect_only(crg, "curvature.local", Severity::Error);
}

TEST(Check, CutsThatMeetWhereNoNodeHasAHeightAreNone) {
  Crg crg = tight_bend();
  for (std::size_t i = 0; i < crg.grid.rows(); ++i)
    crg.grid.at(i, 6) = crg.grid.at(i, 5) = NAN;  // v = 2, 3
  const Crg empty = crg;
  std::vector<Finding> global = findings(crg, "curvature.global");
  ASSERT_EQ(global.size(), 1U);
  EXPECT_EQ(global[0].severity, Severity::Note);
  EXPECT_GT(global[0].count, 90U);
  EXPECT_TRUE(check(crg).passed());
  set_value(crg.options, "WARN_CURV_GLOBAL", 0.0);
  EXPECT_TRUE(findings(crg, "curvature.global").empty());
  // One node with a height that folds is enough.
  crg = empty;
  crg.grid.at(40, 5) = 0.0F;
  const std::vector<Finding> local = findings(crg, "curvature.local");
  ASSERT_EQ(local.size(), 1U);
  EXPECT_EQ(local[0].severity, Severity::Error);
  EXPECT_EQ(local[0].row, 39U);
  EXPECT_EQ(local[0].count, 2U);
  // Nodes that are filled when the file is evaluated are no empty ones.
  crg = empty;
  set_value(crg.modifiers, "GRID_NAN_MODE", 2.0);
  EXPECT_EQ(findings(crg, "curvature.local").size(), 1U);
  crg = empty;
  crg.has_modifier_section = false;
  EXPECT_FALSE(check(crg).passed());
}

TEST(Check, NanRules) {
  Crg crg = good_road();
  for (std::size_t j = 0; j < 7; ++j) crg.grid.at(10, j) = NAN;
  expect_only(crg, "nan.row", Severity::Warning);
  EXPECT_EQ(findings(crg, "nan.row")[0].row, 10U);
  crg = good_road();
  crg.grid.at(20, 3) = crg.grid.at(30, 3) = NAN;
  expect_only(crg, "nan.inside", Severity::Warning);
  EXPECT_EQ(findings(crg, "nan.inside")[0].count, 2U);
  crg = good_road();
  crg.grid.at(20, 0) = NAN;
  expect_only(crg, "nan.edge", Severity::Note);
}

TEST(Check, Closure) {
  Crg crg = good_road();
  crg.grid.at(800, 2) += 0.05F;
  expect_only(crg, "closure.height", Severity::Warning);
  const ReferenceLine open = test::line_along(100, 1.0, [](double) { return 0.01; });
  crg = make_crg(open, test::grid_of(open, -1.0, 1.0, 2, [](double, double) { return 0.0; }));
  set_value(crg.options, "REFLINE_CONTINUATION", 1.0);
  expect_only(crg, "closure", Severity::Error);
}

TEST(Check, OptionsAndModifiers) {
  Crg crg = good_road();
  set_value(crg.options, "BORDER_MODE_U", 7.0);
  EXPECT_EQ(findings(crg, "options").size(), 1U);
  crg = good_road();
  set_value(crg.modifiers, "SCALE_LENGTH", -1.0);
  expect_only(crg, "modifiers", Severity::Error);
  crg = good_road();
  set_value(crg.modifiers, "REFPOINT_X", 0.0);
  set_value(crg.modifiers, "REFLINE_OFFSET_X", 0.0);
  expect_only(crg, "modifiers.placement", Severity::Warning);
  crg = good_road();
  set_value(crg.modifiers, "SCALE_EVERYTHING", 2.0);
  expect_only(crg, "modifiers.unknown", Severity::Note);
  crg = good_road();
  crg.has_modifier_section = false;
  expect_only(crg, "modifiers.missing", Severity::Warning);
}

TEST(Check, ProjectionAndWgs84) {
  Crg crg = good_road();
  crg.projection = {{.key = "PROJ_NM", .text = "MERCATOR"}};
  expect_only(crg, "projection", Severity::Warning);
  const ReferenceLine line = test::line_along(1001, 1.0, [](double) { return 0.0; });
  crg = make_crg(line, test::grid_of(line, -1.0, 1.0, 2, [](double, double) { return 0.0; }));
  // One kilometre along the equator is 0.0089832 degrees of longitude.
  set_value(crg.road, "REFERENCE_LINE_START_LON", 10.0);
  set_value(crg.road, "REFERENCE_LINE_START_LAT", 0.0);
  set_value(crg.road, "REFERENCE_LINE_END_LON", 10.0089832);
  set_value(crg.road, "REFERENCE_LINE_END_LAT", 0.0);
  EXPECT_TRUE(findings(crg, "").empty());
  set_value(crg.road, "REFERENCE_LINE_END_LON", 10.0098);
  expect_only(crg, "wgs", Severity::Warning);
  set_value(crg.road, "REFERENCE_LINE_END_LON", 200.0);
  expect_only(crg, "wgs", Severity::Error);
}

TEST(Check, TurnsAndUnevenSteps) {
  const ReferenceLine line =
      test::line_along(50, 1.0, [](double u) { return u == 20.0 ? 1.0 : 0.0; });
  const Crg crg =
      make_crg(line, test::grid_of(line, -0.1, 0.1, 2, [](double, double) { return 0.0; }));
  expect_only(crg, "line.turn", Severity::Warning);
  Crg pulled = make_crg(test::line_along(50, 1.0, [](double) { return 0.0; }), crg.grid);
  set_value(pulled.road, "REFERENCE_LINE_END_X", 40.0);
  EXPECT_FALSE(findings(pulled, "line.step").empty());
}

TEST(Check, NotesOfTheReaderAppear) {
  Crg crg = good_road();
  crg.notes = {"line 7: something"};
  expect_only(crg, "read", Severity::Note);
}

}  // namespace check_test
}  // namespace crg
