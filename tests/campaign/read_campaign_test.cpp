#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "campaign/results.h"
#include "campaign/results_folder.h"
#include "support/places.h"
#include "support/run_tool.h"

namespace read_campaign_test {

using campaign::State;
using ::testing::HasSubstr;

campaign::Campaign results(const cli::Folder& folder) {
  campaign_test::write_results(folder, "crgbuild: b.obj:\\n no road, \\\"none\\\" <b>&");
  return campaign::read_campaign(folder.path());
}

TEST(ReadCampaign, StatesMessagesAndFacts) {
  const cli::Folder folder;
  const campaign::Campaign read = results(folder);
  ASSERT_EQ(read.jobs.size(), 4u);
  EXPECT_EQ(read.jobs[0].state, State::done);
  EXPECT_EQ(read.jobs[1].state, State::failed);
  EXPECT_EQ(read.jobs[2].state, State::blocked);
  EXPECT_EQ(read.jobs[3].state, State::not_run);
  EXPECT_EQ(read.jobs[0].page, "road/a/report.html");
  EXPECT_EQ(read.jobs[1].page, "") << "no such file";
  EXPECT_EQ(read.jobs[1].message, "crgbuild: b.obj:  no road, \"none\" <b>&");
  ASSERT_EQ(read.jobs[0].facts.size(), 3u);
  EXPECT_EQ(read.jobs[0].facts[0].value, 1234.25);
  EXPECT_EQ(read.jobs[0].facts[1].name, "error, 99 %");
  EXPECT_EQ(read.jobs[0].facts[1].unit, "m");
  EXPECT_EQ(read.jobs[0].facts[2].value, 3.0) << "kerbs";
}

TEST(ReadCampaign, WhatAnExplanationNamesFirst) {
  const cli::Folder folder;
  cli::write(folder / "plan.json",
             R"({"name": "e", "jobs": [{"kind": "explain", "subject": "a", "id": "explain/a"}]})");
  std::filesystem::create_directories(folder / "state/explain");
  cli::write(folder / "state/explain/a.json", R"({"exit_code": 0, "message": "", "outputs": [],
    "said": {"verdict": "explained", "findings": [{"mechanism": "road.banking"}]}})");
  const campaign::Campaign read = campaign::read_campaign(folder.path());
  ASSERT_EQ(read.jobs.size(), 1u);
  const auto& facts = read.jobs[0].facts;
  const auto first = std::find_if(facts.begin(), facts.end(), [](const campaign::Fact& fact) {
    return fact.name == "first finding";
  });
  ASSERT_NE(first, facts.end());
  EXPECT_EQ(first->text, "road.banking");
}

TEST(ReadCampaign, AFleetsVerdictAndWhoseItIs) {
  const cli::Folder folder;
  results(folder);
  cli::write(folder / "plan.json",
             R"({"name": "f", "jobs": [{"kind": "fleet", "subject": "a", "id": "fleet/a"}]})");
  std::filesystem::create_directories(folder / "state/fleet");
  cli::write(folder / "state/fleet/a.json", R"({"exit_code": 0, "message": "", "outputs": [],
    "said": {"verdict": "divided", "drives": 3, "undivided": [], "cars": [{}, {}],
             "findings": [{"mechanism": "vehicle.turbo_lag", "owner": "one"}]}})");
  const campaign::Campaign read = campaign::read_campaign(folder.path());
  ASSERT_EQ(read.jobs.size(), 1u);
  std::vector<std::string> words;
  for (const campaign::Fact& fact : read.jobs[0].facts)
    words.push_back(fact.name + "=" +
                    (fact.text.empty() ? std::to_string(int(fact.value)) : fact.text));
  EXPECT_EQ(words, (std::vector<std::string>{"verdict=divided", "first finding=vehicle.turbo_lag",
                                             "of=one", "findings=1", "not divided=0", "cars=2",
                                             "drives=3"}));
}

TEST(ReadCampaign, AnOutputThatIsGoneOrCutIsNotDone) {
  const cli::Folder folder;
  results(folder);
  cli::write(folder / "road/a/a.crg", "cr");
  const campaign::Job cut = campaign::read_campaign(folder.path()).jobs[0];
  EXPECT_EQ(cut.state, State::output_gone);
  EXPECT_THAT(cut.message, HasSubstr("road/a/a.crg"));
}

TEST(ReadCampaign, AStateThatCannotBeReadFailsItsJobAlone) {
  const cli::Folder folder;
  results(folder);
  for (const char* bad : {"", "{", "[1]", R"({"exit_code": 0, "message": 3})",
                          R"({"exit_code": 0, "outputs": [{"path": "../x", "bytes": 1}]})"}) {
    cli::write(folder / "state/road/a.json", bad);
    const campaign::Campaign read = campaign::read_campaign(folder.path());
    EXPECT_EQ(read.jobs[0].state, State::failed) << bad;
    EXPECT_THAT(read.jobs[0].message, HasSubstr("state/road/a.json")) << bad;
    EXPECT_EQ(read.jobs[1].state, State::failed);
    EXPECT_EQ(read.jobs[3].state, State::not_run);
  }
}

TEST(ReadCampaign, RefusesWhatIsNoPlan) {
  const cli::Folder folder;
  const auto refusal = [&](const char* plan) -> std::string {
    cli::write(folder / "plan.json", plan);
    try {
      campaign::read_campaign(folder.path());
    } catch (const base::Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal("nothing"), HasSubstr("no JSON object"));
  EXPECT_THAT(refusal("{}"), HasSubstr("no list 'jobs'"));
  EXPECT_THAT(refusal(R"({"jobs": [1]})"), HasSubstr("not an object"));
  EXPECT_THAT(refusal(R"({"jobs": [{"kind": "..", "subject": "x/../../y"}]})"),
              HasSubstr("inside the campaign's folder wanted"));
  EXPECT_THAT(refusal(R"({"jobs": [{"kind": "a", "subject": "b", "page": "/etc/passwd"}]})"),
              HasSubstr("'/etc/passwd' seen"));
  EXPECT_THAT(
      refusal(R"({"jobs": [{"kind": "a", "subject": "b"}, {"kind": "a", "subject": "b"}]})"),
      HasSubstr("twice"));
}

TEST(ReadCampaign, CollectSaysWhatIsNotDoneAndWritesThreeFiles) {
  const cli::Folder folder;
  results(folder);
  const support::ToolRun ran = support::run_tool(places::kerbstone(), {"collect", folder.path()});
  EXPECT_EQ(ran.code, 3);
  EXPECT_THAT(ran.out, HasSubstr("1 of 4 jobs done"));
  EXPECT_THAT(ran.out, HasSubstr("road/b: failed: crgbuild: b.obj:  no road"));
  for (const char* name : {"index.html", "campaign.csv", "campaign.sqlite"})
    EXPECT_TRUE(cli::exists(folder / name)) << name;
  EXPECT_EQ(support::run_tool(places::kerbstone(), {"collect", folder / "none"}).code, 1);
}

}  // namespace read_campaign_test
