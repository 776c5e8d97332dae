// One name for all programs, and one name for each thing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "support/run_tool.h"
#include "support/temporary_folder.h"

namespace verbs_test {

using support::run_tool;
using ::testing::HasSubstr;
using ::testing::Not;
using Words = std::vector<std::string>;

std::string tool(const std::string& name) {
  for (const support::Tool& each : support::all_tools())
    if (each.name == name) return each.path;
  return "no tool " + name;
}

TEST(Verbs, AreCommandsOfTheProgramsThatOwnThem) {
  const std::vector<std::pair<Words, Words>> kOwned = {
      {{"objects"}, {"crgbuild", "objects"}},
      {{"build"}, {"crgbuild", "build"}},
      {{"build", "from-edges"}, {"crgbuild", "from-edges"}},
      {{"check"}, {"crgbuild", "check"}},
      {{"check", "validate"}, {"crgbuild", "validate"}},
      {{"report"}, {"crgbuild", "report"}},
      {{"edit", "crop"}, {"crgbuild", "crop"}},
      {{"export"}, {"crgbuild", "export"}},
      {{"scan", "info"}, {"lidar2mesh", "info"}},
      {{"refine"}, {"lidar2mesh", "map"}},
      {{"drive"}, {"crgdrive", "lap"}},
      {{"drive", "replay"}, {"crgdrive", "replay"}},
      {{"car", "parameters"}, {"crgdrive", "parameters"}},
      {{"car", "new"}, {"crgdrive", "new"}},
      {{"race"}, {"crgsim", "race"}},
      {{"explain"}, {"crgexplain", "run"}},
      {{"explain", "map"}, {"crgexplain", "map"}},
      {{"explain", "road"}, {"crgexplain", "road"}},
      {{"fit", "tyre"}, {"crgidentify", "tyre"}},
      {{"unit", "info"}, {"crgsim", "info"}},
      {{"unit"}, {"crgsim"}},
  };
  for (const auto& [verb, owner] : kOwned) {
    SCOPED_TRACE(verb.front());
    Words asked = verb, wanted(owner.begin() + 1, owner.end());
    asked.emplace_back("--help");
    wanted.emplace_back("--help");
    const std::string help = run_tool(tool(owner.front()), wanted).out;
    EXPECT_THAT(help, HasSubstr("Usage: " + owner.front()));
    EXPECT_EQ(run_tool(tool("kerbstone"), asked).out, help);
    asked = verb;
    asked.insert(asked.begin(), "help");
    EXPECT_EQ(run_tool(tool("kerbstone"), asked).out, help);
  }
}

TEST(Verbs, StandInTheHelpAndAreSuggested) {
  const std::string help = run_tool(tool("kerbstone"), {"help"}).out;
  for (const char* verb : {"objects", "build", "check", "report", "edit", "export", "scan",
                           "refine", "drive", "race", "car", "explain", "fit", "unit", "view"})
    EXPECT_THAT(help, HasSubstr("\n  " + std::string(verb) + " "));
  const auto wrong = run_tool(tool("kerbstone"), {"biuld"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("did you mean 'build'?"));
}

TEST(Verbs, GiveTheExitCodeAndTheMessageOfTheirOwner) {
  const auto ran = run_tool(tool("kerbstone"), {"check", "no.crg"});
  const auto owner = run_tool(tool("crgbuild"), {"check", "no.crg"});
  EXPECT_NE(owner.code, 0);
  EXPECT_EQ(ran.code, owner.code);
  EXPECT_EQ(ran.err, owner.err);
  EXPECT_EQ(run_tool(tool("kerbstone"), {"-q", "--json", "check", "no.crg"}).err, owner.err);
}

TEST(OldNames, StillWorkAndTheNewOneIsSaid) {
  const support::TemporaryFolder folder;
  const Words words = {"run",        "--track",     "no.crg",          "--vehicle=no.yaml",
                       "--friction", "no_grip.crg", "--recordings",    "a.csv",
                       "b.csv",      "-o",          folder.path("out")};
  const auto ran = run_tool(tool("crgexplain"), words);
  for (const char* said : {"--track is called --road now", "--vehicle is called --car now",
                           "--friction is called --grip now", "--recordings is called --log now"})
    EXPECT_THAT(ran.err, HasSubstr(said));
  EXPECT_THAT(ran.err, HasSubstr("no.yaml: cannot open"));  // taken as the car
  Words quiet = words;
  quiet.emplace_back("--quiet");
  EXPECT_THAT(run_tool(tool("crgexplain"), quiet).err, Not(HasSubstr("is called")));
  EXPECT_EQ(run_tool(tool("crgbuild"), {"info", "--track", "no.crg"}).code,
            2);  // it never had that flag
}

}  // namespace verbs_test
