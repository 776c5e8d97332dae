#include "explain/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/json_text.h"
#include "support/page_claims.h"

namespace explain {
namespace page_test {

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

TEST(FindingsPage, SaysWhatToDoNextUnderTheVerdict) {
  Findings f;
  Finding& x = f.findings.emplace_back();
  x.mechanism = "sensor.gain", x.channel = "ay";
  x.rivals = {{"road.banking", "", "survey the cross slope", 1.0, false},
              {"vehicle.mass", "", "weigh it", 1.0, true}};
  const std::string page =
      findings_page(f, {}, "t", {{"look again", "crgexplain run --log '<a>'"}});
  EXPECT_THAT(page, HasSubstr("look again: <code>crgexplain run --log &#39;&lt;a&gt;&#39;</code>"));
  EXPECT_THAT(page, HasSubstr("tell sensor.gain in ay from road.banking: survey the cross slope"));
  EXPECT_THAT(page.substr(0, page.find("What is")), Not(HasSubstr("weigh it")));
  EXPECT_LT(page.find("What to do next"), page.find("sensor.gain in ay</h2>"));
  EXPECT_THAT(findings_page({}, {}, "t"), Not(HasSubstr("What to do next")));
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

TEST(FindingsPage, SaysHowFarWasDrivenAndWhatWasHeld) {
  Findings f;
  f.laps = 3;
  f.rounds = 1.03;
  Finding x;
  x.mechanism = "sensor.delay", x.kind = "sensor";
  x.parameters = {{"rise_s", "s", 0.13, 0.13, 0.13}};
  f.findings = {x};
  const std::string page = findings_page(f, {Signals{}}, "t");
  EXPECT_THAT(page, HasSubstr("Driven 1.03 times round, in 3 laps. False alarms"));
  EXPECT_THAT(page, HasSubstr("held, not fitted"));
  EXPECT_THAT(page, HasSubstr("How sure: by what the columns say of each other"));
}

/// Something in every list, with signs that markup has too, and numbers that JSON does not have.
Findings full() {
  Findings f;
  f.verdict = Verdict::kTie;
  f.laps = 7;
  f.null_replicates = 2000;
  f.null_false_alarm = 0.0134;
  f.threshold = 4.937;
  f.recorded_lap_s = {91.234, 89.871, 90.5};
  f.simulated_lap_before_s = 88.046;
  f.simulated_lap_after_s = 89.114;
  Finding x;
  x.mechanism = "sensor.gain";
  x.channel = "gyro <z> & co";
  x.kind = "sensor";
  x.physics = "the scale of a sensor is off";
  x.equation = "m = k x";
  x.parameters = {{"gain", "1", 1.02345678, 1.01, 1.0312}, {"second", "1/s", -3.4e-7, NAN, 2e10}};
  for (int k = 0; k < 11; ++k) x.where.push_back({100.0 * k + 0.4, 100.0 * k + 37.7, {}});
  x.rivals = {{"sensor.bias", "gyro <z> & co", "turn the other way", 3.0, false},
              {"vehicle.mass", "", "", 1.0, true}};
  x.statistic = -12.34, x.threshold = 4.9, x.cv_gain = 123.4, x.stability = 0.95;
  x.held_out = {
      {"vx_mps", "m/s", 0.6, 0.123456, 0.0987654, 0.05, 0.3219, 1.1, false},
      {"yaw_rate_radps", "rad/s", 0.0, 0.5, 0.25, -0.02, 0.7, 0.6, true, 0.654, -0.1, 0.8}};
  x.not_used = "<worse> than before";
  Finding let_go = x;
  let_go.mechanism = "parameter.mass", let_go.channel = "", let_go.kind = "parameter";
  let_go.threshold = 0, let_go.where.clear(), let_go.rivals.clear(), let_go.parameters.pop_back();
  f.findings = {x, let_go};
  f.unexplained = {{"forward force", "speed", "m/s2", {{10, 25.6, {}}}, 0.123, 0.01, -0.3217},
                   {"yaw", "u", "1", {}, 0.5, 0.01, 1e-7}};
  f.mismatches = {{"ay", "turning left", "m/s2", {{3.2, 50, {1}}}, -1.23456, 3.3e-5, 0.447}};
  f.parameters = {{"mass", "mass", "kg", 700, 712.3456, 700.1, 724.9, true, false},
                  {"grip", "grip", "1", 1, 1.1, 1.0, 1.2, false, true},
                  {"drag", "drag", "1", 1, 1.1, 1.0, 1.2, false, false}};
  f.evidence = {{"vehicle.fuel_burn", "", "mass lost", 0.0156, 16.7, -2, "kg/s", "", 0.02},
                {"road.banking", "", "slope", -0.0123, -6.2, 4.44, "1", ", u 0 to 40 m", 0.001},
                {"environment.wind", "", "speed", 0.3, 1.1, 0.04, "m/s", "", 0.1}};
  f.untestable = {{"vehicle.differential", "no wheel speeds & \"no\" loads"}};
  return f;
}

TEST(FindingsPage, SaysWhatFindingsJsonSays) {
  Findings f = full();
  const auto says_it = [&] {
    support::expect_page_says(base::parse_json<nlohmann::json>(findings_json(f)),
                              findings_page(f, {}, "t"));
  };
  says_it();
  f.verdict = Verdict::kExplained, f.findings.erase(f.findings.begin());
  says_it();
  f.verdict = Verdict::kNone, f.findings.clear(), f.unexplained.clear();
  says_it();
  f.verdict = Verdict::kNone, f.evidence.clear(), f.mismatches.clear(), f.parameters.clear();
  f.recorded_lap_s.clear(), f.simulated_lap_after_s = 0;
  says_it();
}

}  // namespace page_test
}  // namespace explain
