#include "explain/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace explain {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(FindingsPage, TakesTextOfLogsForText) {
  Findings f;
  f.remarks = {{"<script>alert(1)</script>"}};
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

// The page goes by what a remark is about, not by its wording.
TEST(FindingsPage, PutsWhatTheCarWasRefittedToBesideItsErrors) {
  Findings f;
  Finding x;
  x.held_out.emplace_back();
  f.findings = {x};
  f.remarks = {{"mass 700", Remark::About::kRefit},
               {"refitted to the laps that do not judge", Remark::About::kAnalysis}};
  const std::string page = findings_page(f, {}, "t");
  const auto place = [&](const char* text) { return page.find(text); };
  ASSERT_NE(place("mass 700"), std::string::npos);
  EXPECT_EQ(page.find("mass 700", place("mass 700") + 1), std::string::npos) << "once";
  EXPECT_LT(place("refitted to the laps"), place("</section>")) << "under the verdict";
  EXPECT_GT(place("mass 700"), place("</section>")) << "not under the verdict";
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

TEST(FindingsPage, SaysHowSureWithTheFiguresThatEachKindHas) {
  const auto page_of = [](const std::string& kind, double statistic, double threshold,
                          double cv_gain, double stability) {
    Findings f;
    Finding x;
    x.mechanism = "m";
    x.kind = kind;
    x.statistic = statistic;
    x.threshold = threshold;
    x.cv_gain = cv_gain;
    x.stability = stability;
    f.findings = {x};
    return findings_page(f, {}, "t");
  };
  const std::string let_go = page_of("parameter", -7.25, 0, 0, 1);
  EXPECT_THAT(let_go, HasSubstr("How sure: 7.2 standard deviations from what the vehicle file "
                                "states, beyond its prior width.</p>"));
  EXPECT_THAT(let_go, Not(HasSubstr("gain of")));
  EXPECT_THAT(let_go, Not(HasSubstr("half samples")));
  // A parameter that was searched for like a mechanism.
  EXPECT_THAT(page_of("parameter", 9, 4, 120, 0.95),
              HasSubstr("How sure: score 9.0 where 4.0 is needed, gain of 120 on laps left out, "
                        "the same sign in 95 % of half samples.</p>"));
  const std::string waves = page_of("road", 30, 5, 11.5, std::nan(""));
  EXPECT_THAT(
      waves,
      HasSubstr("How sure: score 30.0 where 5.0 is needed, gain of 11.5 on laps left out.</p>"));
  EXPECT_THAT(page_of("vehicle", 12, 0, 80, 0.75),
              HasSubstr("How sure: gain of 80 on laps left out, better in 75 % of them.</p>"));
}

}  // namespace
}  // namespace explain
