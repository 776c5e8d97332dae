// crgbuild report and build, run as the program it is.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/json_text.h"
#include "crg/file.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace cli {
namespace report_test {

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
  const Json report = base::parse_json<Json>(read(out("report.json")));
  EXPECT_EQ(report["verdict"], "usable") << base::dump_json(report["findings"], 1);
  EXPECT_EQ(report["title"], "stadium");
  EXPECT_EQ(report["comparisons"][0]["key"], "mesh");
  EXPECT_EQ(report["comparisons"][1]["key"], "before");
  EXPECT_THAT(report["command_line"].get<std::string>(), HasSubstr("crgbuild build"));
}

TEST_F(Reported, ReportOfAFileAgainstMeshAndItselfIsTheSameVerdict) {
  const Ran report = crgbuild({"report", out("stadium.crg"), "--mesh", *folder / "stadium.obj",
                               "--against", out("stadium.crg"), "-o", *folder / "again", "--json"});
  ASSERT_EQ(report.code, 0) << report.err;
  EXPECT_EQ(base::parse_json<Json>(report.out)["verdict"], "usable");
  const Json json = base::parse_json<Json>(read(*folder / "again/report.json"));
  ASSERT_EQ(json["comparisons"].size(), 2u);
  EXPECT_LT(json["comparisons"][1]["abs_error_m"]["max"].get<double>(), 1e-4);
  EXPECT_EQ(json["inputs"].size(), 3u);
}

TEST_F(Reported, AgainstPointsMeasuredOnIt) {
  std::string wanted = "u_m,v_m\n";
  for (int k = 0; k < 3000; ++k)
    wanted += std::to_string(20.0 + 0.01 * k) + "," + std::to_string(0.07 * (k % 29) - 1.0) + "\n";
  write(*folder / "wanted.csv", wanted);
  ASSERT_EQ(crgbuild({"query", out("stadium.crg"), "--points", *folder / "wanted.csv", "-o",
                      *folder / "measured.csv"})
                .code,
            0);
  const Ran report = crgbuild(
      {"report", out("stadium.crg"), "--cloud", *folder / "measured.csv", "-o", *folder / "cloud"});
  ASSERT_EQ(report.code, 0) << report.err;
  const Json json = base::parse_json<Json>(read(*folder / "cloud/report.json"));
  ASSERT_EQ(json["comparisons"].size(), 1u);
  EXPECT_EQ(json["comparisons"][0]["key"], "cloud");
  EXPECT_GT(json["comparisons"][0]["points"].get<int>(), 200);
  EXPECT_LT(json["comparisons"][0]["abs_error_m"]["p95"].get<double>(), 0.002);
  EXPECT_EQ(json["inputs"].size(), 2u);
  // Somewhere else.
  write(*folder / "elsewhere.xyz", "1000 1000 0\n1001 1000 0\n");
  const Ran wrong = crgbuild({"report", out("stadium.crg"), "--cloud", *folder / "elsewhere.xyz",
                              "-o", *folder / "nothing"});
  EXPECT_EQ(wrong.code, 1);
  EXPECT_THAT(wrong.err, HasSubstr("none of its 2 points"));
}

TEST_F(Reported, TheCommandOfTheReportMakesItAgain) {
  const std::string mesh = *folder / "the stadium's.obj", to = *folder / "once more",
                    report = to + "/report.json";
  write(mesh, Stadium{}.obj());
  const Ran first = crgbuild({"build", mesh, "-o", to, "--reverse", "--line-is-right", "--name",
                              "it's", "--v-max-m", "12"});
  ASSERT_EQ(first.code, 0) << first.err;
  const std::string line = base::parse_json<Json>(read(report))["command_line"].get<std::string>();
  EXPECT_THAT(line, ::testing::StartsWith("crgbuild build "));
  std::filesystem::remove_all(to);
  const support::ToolRun again =
      support::run_tool("/bin/bash", {"-c", places::crgbuild() + line.substr(line.find(' '))});
  ASSERT_EQ(again.code, 0) << line << "\n" << again.err;
  EXPECT_EQ(base::parse_json<Json>(read(report))["command_line"], line);
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
  const Ran report = crgbuild({"report", out("stadium.crg"), "--mesh", *folder / "stadium.obj",
                               "--translation-m", "0,0,0.3", "-o", *folder / "high"});
  EXPECT_EQ(report.code, 3) << report.err;
  EXPECT_THAT(report.err, HasSubstr("not usable"));
  EXPECT_EQ(base::parse_json<Json>(read(*folder / "high/report.json"))["verdict"], "not_usable");
}

/// The stadium with a ring of its road half a metre too high: a ridge that no wheel follows.
std::string stadium_with_ridge() {
  std::istringstream lines(Stadium{}.obj());
  std::string text;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    double x = 0.0, y = 0.0, z = 0.0;
    words >> kind >> x >> y >> z;
    if (kind == "v" && x > 59.0 && x < 61.0 && std::abs(y) < 9.0)
      line = fmt::format("v {:.6f} {:.6f} {:.6f}", x, y, z + 0.5);
    text += line + "\n";
  }
  return text;
}

TEST(BuildVerdict, ARoadThatItsOwnReportCallsNotUsableExitsWithThreeEveryTime) {
  const Folder folder;
  write(folder / "ridge.obj", stadium_with_ridge());
  const std::vector<std::string> command = {"build", folder / "ridge.obj", "-o", folder / "out"};
  const auto with = [&](const char* flag) {
    std::vector<std::string> more = command;
    more.emplace_back(flag);
    return more;
  };
  const auto expect_refused = [&](const Ran& ran, bool reused) {
    EXPECT_EQ(ran.code, 3);
    EXPECT_THAT(ran.err, HasSubstr("ridge.crg: not usable, 1 error: "));
    EXPECT_THAT(ran.err, HasSubstr("at u = "));
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
    EXPECT_EQ(ran.out.find("reused: nothing has changed") != std::string::npos, reused) << ran.out;
  };
  const Ran built = crgbuild(command);
  expect_refused(built, false);
  const Json report = base::parse_json<Json>(read(folder / "out/report.json"));
  EXPECT_EQ(report["verdict"], "not_usable");
  EXPECT_TRUE(base::parse_json<Json>(read(folder / "out/summary.json"))["validation"]["passed"])
      << "only the report may speak against it";
  const std::string last = built.out.substr(built.out.rfind('\n', built.out.size() - 2) + 1);
  EXPECT_THAT(last, HasSubstr("(not usable: 1 error,"));
  const Ran again = crgbuild(command);
  expect_refused(again, true);
  EXPECT_EQ(again.out.substr(again.out.rfind('\n', again.out.size() - 2) + 1), last);
  EXPECT_EQ(crgbuild(with("--json")).code, 3);
  EXPECT_EQ(crgbuild(with("--quiet")).code, 3);
  EXPECT_EQ(crgbuild(with("--no-report")).code, 0) << "nobody has looked";
  // A report that says nothing is made again.
  write(folder / "out/report.json", "{}");
  expect_refused(crgbuild(command), false);
}

TEST(BuildVerdict, ARoadInPlaceOfAMeshIsToldWhatToDoWithIt) {
  const Folder folder;
  crg::ReferenceLine line;
  crg::Grid grid;
  for (int i = 0; i < 3; ++i)
    line.x_m.push_back(i), line.y_m.push_back(0.0), line.heading_rad.push_back(0.0);
  line.u_step_m = grid.u_step_m = 1.0;
  grid.v_m = {-1.0, 1.0};
  grid.z_m.assign(6, 0.0F);
  crg::write(crg::make_crg(line, grid), folder / "road.crg", crg::Format::KRBI);
  for (const char* name : {"road.crg", "ROAD.CRG", "road.obj"}) {
    write(folder / name, read(folder / "road.crg"));
    const Ran ran = crgbuild({"build", folder / name, "-o", folder / "out"});
    EXPECT_EQ(ran.code,
              std::string(name) == "road.obj" ? 1 : 2);  // only its content tells that it is a road
    EXPECT_THAT(ran.err, HasSubstr(fmt::format("crgbuild info {}", folder / name)));
    EXPECT_THAT(ran.err, HasSubstr("crgbuild report"));
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

}  // namespace report_test
}  // namespace cli
