#include "explain/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace explain {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(FindingsPage, TakesTextOfLogsForText) {
  Findings f;
  f.remarks = {"<script>alert(1)</script>"};
  f.untestable = {{"a", "<img src=x onerror=alert(1)>"}};
  Finding x;
  x.mechanism = "sensor.bias";
  x.channel = "<b onmouseover='alert(1)'>";
  f.findings = {x};
  f.evidence = {{"sensor.bias", "</td><script>", "", 1, 2, 3, "m/s"}};
  const std::string page = findings_page(f, {}, "<script>");
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, Not(HasSubstr("<img")));
  EXPECT_THAT(page, Not(HasSubstr("<b onmouseover")));
  EXPECT_THAT(page, HasSubstr("&lt;script&gt;alert(1)"));
}

TEST(FindingsPage, ShortensLongListsAndSaysWhoJudged) {
  Findings f;
  Finding x;
  x.mechanism = "vehicle.turbo_lag";
  for (int k = 0; k < 20; ++k) x.where.push_back({100.0 * k, 100.0 * k + 20, {}});
  HeldOut relation, whole;
  relation.channel = whole.channel = "vx_mps";
  whole.whole_car = true;
  x.held_out = {relation, whole};
  f.findings = {x};
  const std::string page = findings_page(f, {}, "t");
  EXPECT_THAT(page, HasSubstr("700 to 720 m and 12 more"));
  EXPECT_THAT(page, Not(HasSubstr("800 to 820")));
  EXPECT_THAT(page, HasSubstr("<td>one relation<td>vx_mps"));
  EXPECT_THAT(page, HasSubstr("<td>whole simulated car<td>vx_mps"));
}

}  // namespace
}  // namespace explain
