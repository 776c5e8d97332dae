// crgbuild report and build, run as the program it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "support/run_crgbuild.h"

namespace cli {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

/// A built stadium with its report, made once for all tests that only read it.
class Reported : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = new Folder;
    write(*folder / "stadium.obj", Stadium{}.obj());
    ran = crgbuild({"build", *folder / "stadium.obj", "-o", *folder / "out"});
  }
  static void TearDownTestSuite() {
    delete folder;
    folder = nullptr;
  }
  static std::string out(const std::string& name) { return *folder / ("out/" + name); }

  static inline Folder* folder = nullptr;
  static inline Ran ran;
};

TEST_F(Reported, BuildWritesItBesideTheRoad) {
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("report   "));
  const Json report = Json::parse(read(out("report.json")));
  EXPECT_EQ(report["verdict"], "usable") << report["findings"].dump(1);
  EXPECT_EQ(report["title"], "stadium");
  EXPECT_EQ(report["comparisons"][0]["key"], "mesh");
  EXPECT_EQ(report["comparisons"][1]["key"], "before");
  EXPECT_THAT(report["command_line"].get<std::string>(), HasSubstr("crgbuild build"));
}

TEST_F(Reported, ReportOfAFileAgainstMeshAndItselfIsTheSameVerdict) {
  const Ran report = crgbuild({"report", out("stadium.crg"), "--mesh", *folder / "stadium.obj", "--against",
                               out("stadium.crg"), "-o", *folder / "again", "--json"});
  ASSERT_EQ(report.code, 0) << report.err;
  EXPECT_EQ(Json::parse(report.out)["verdict"], "usable");
  const Json json = Json::parse(read(*folder / "again/report.json"));
  ASSERT_EQ(json["comparisons"].size(), 2u);
  EXPECT_LT(json["comparisons"][1]["abs_error_m"]["max"].get<double>(), 1e-4);
  EXPECT_EQ(json["inputs"].size(), 3u);
}

TEST_F(Reported, AgainstPointsMeasuredOnIt) {
  std::string wanted = "u_m,v_m\n";
  for (int k = 0; k < 3000; ++k) wanted += std::to_string(20.0 + 0.01 * k) + "," + std::to_string(0.07 * (k % 29) - 1.0) + "\n";
  write(*folder / "wanted.csv", wanted);
  ASSERT_EQ(crgbuild({"query", out("stadium.crg"), "--points", *folder / "wanted.csv", "-o", *folder / "measured.csv"}).code, 0);
  const Ran report = crgbuild({"report", out("stadium.crg"), "--cloud", *folder / "measured.csv", "-o", *folder / "cloud"});
  ASSERT_EQ(report.code, 0) << report.err;
  const Json json = Json::parse(read(*folder / "cloud/report.json"));
  ASSERT_EQ(json["comparisons"].size(), 1u);
  EXPECT_EQ(json["comparisons"][0]["key"], "cloud");
  EXPECT_GT(json["comparisons"][0]["points"].get<int>(), 200);
  EXPECT_LT(json["comparisons"][0]["abs_error_m"]["p95"].get<double>(), 0.002);
  EXPECT_EQ(json["inputs"].size(), 2u);
  // Somewhere else.
  write(*folder / "elsewhere.xyz", "1000 1000 0\n1001 1000 0\n");
  const Ran wrong = crgbuild({"report", out("stadium.crg"), "--cloud", *folder / "elsewhere.xyz", "-o", *folder / "nothing"});
  EXPECT_EQ(wrong.code, 1);
  EXPECT_THAT(wrong.err, HasSubstr("none of its 2 points"));
}

TEST_F(Reported, WrongInputEndsInOneLineAndWritesNothing) {
  const Ran missing = crgbuild({"report", *folder / "none.crg", "-o", *folder / "nothing"});
  EXPECT_EQ(missing.code, 1);
  EXPECT_THAT(missing.err, HasSubstr("none.crg"));
  EXPECT_EQ(std::count(missing.err.begin(), missing.err.end(), '\n'), 1);
  const Ran wrong = crgbuild({"report", *folder / "stadium.obj", "-o", *folder / "nothing"});
  EXPECT_EQ(wrong.code, 1);
  EXPECT_EQ(std::count(wrong.err.begin(), wrong.err.end(), '\n'), 1);
  EXPECT_EQ(crgbuild({"report", out("stadium.crg")}).code, 2);
  EXPECT_FALSE(std::filesystem::exists(*folder / "nothing"));
}

TEST_F(Reported, ARoadThatIsNotUsableExitsWithThreeAndIsReported) {
  // The mesh 30 cm higher than the road: nothing agrees.
  const Ran report = crgbuild({"report", out("stadium.crg"), "--mesh", *folder / "stadium.obj", "--translation-m", "0,0,0.3",
                               "-o", *folder / "high"});
  EXPECT_EQ(report.code, 3) << report.err;
  EXPECT_THAT(report.err, HasSubstr("not usable"));
  EXPECT_EQ(Json::parse(read(*folder / "high/report.json"))["verdict"], "not_usable");
}

}  // namespace
}  // namespace cli
