// The tour of `kerbstone try`, as somebody who has just installed the programs takes it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/sha256.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"

namespace try_test {

using ::testing::HasSubstr;

// Two minutes on two cores at most (docs/evidence.md); twice that where others work beside it.
TEST(SlowTry, GoesThroughEveryStepAndFindsWhatItHid) {
  const support::TemporaryFolder folder;
  for (const char* const seed : {"0", "1", "2"}) {
    const support::ToolRun ran =
        support::run_tool(places::kerbstone(),
                          {"try", "-o", folder.path(seed), "--seed", seed, "--no-open", "--json"});
    ASSERT_EQ(ran.code, 0) << ran.err << folder.read(std::string(seed) + "/steps.txt");
    const auto told = base::parse_json<nlohmann::json>(ran.out);
    EXPECT_EQ(told.at("sealed_sha256"), base::sha256(told.at("answer").get<std::string>()));
    EXPECT_LT(told.at("seconds").get<double>(), 240.0);
    EXPECT_EQ(told.at("verdict"), "explained") << told;
    ASSERT_EQ(told.at("findings").size(), 1u) << told.at("findings");
    const nlohmann::json found = told["findings"][0].at("parameters")[0];
    EXPECT_LE(found.at("ci90")[0].get<double>(), told.at("hidden").get<double>());
    EXPECT_GE(found.at("ci90")[1].get<double>(), told.at("hidden").get<double>());
    for (const char* page : {"road/report.html", "refined/report.html", "found/report.html"})
      EXPECT_TRUE(std::filesystem::exists(folder.path(std::string(seed) + "/" + page))) << page;
  }
}

TEST(Try, SaysWhichProgramFailedAndWhere) {
  const support::TemporaryFolder folder;
  folder.file("out", "a file in the place of a folder");
  const support::ToolRun ran =
      support::run_tool(places::kerbstone(), {"try", "-o", folder.path("out"), "--no-open"});
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.err, HasSubstr("out"));
  EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
}

}  // namespace try_test
