// A road for whoever has a log and none: `crgexplain road`.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "crg/file.h"
#include "recording/table.h"
#include "road/driven_lap.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"

namespace flat_road_test {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Words = std::vector<std::string>;

json road_of(const std::string& log, const std::string& out, const Words& more = {}) {
  Words words{"road", log, "-o", out, "--json"};
  words.insert(words.end(), more.begin(), more.end());
  const support::ToolRun ran = support::run_tool(places::crgexplain(), words);
  EXPECT_EQ(ran.code, 0) << ran.err;
  return ran.code == 0 ? base::parse_json<json>(ran.out) : json();
}

double length_of(const std::string& path) {
  const crg::ReferenceLine line = crg::integrate_reference_line(crg::read(path));
  EXPECT_TRUE(line.closed);
  return line.u_step_m * static_cast<double>(line.size() - 1);
}

TEST(FlatRoad, OfSpeedAndYawRateAloneComesWithTheLogPlaced) {
  const support::TemporaryFolder folder;
  const road::DrivenLap drive = road::drive_round(2.5);
  recording::Table log;
  std::vector<double> since_1970 = drive.time_s;
  for (double& t : since_1970) t += 1.7e9;
  log.add("time_s", since_1970);
  log.add("vx_mps", drive.vx_mps);
  std::vector<double> leaning = drive.yaw_rate_radps;
  for (double& rate : leaning) rate *= 0.94;  // about the upright axis of a car on a banking
  log.add("yaw_rate_radps", leaning);
  std::vector<double> yaw_rad(1, 1.1);
  for (std::size_t i = 1; i < since_1970.size(); ++i)
    yaw_rad.push_back(yaw_rad.back() +
                      drive.yaw_rate_radps[i] * (drive.time_s[i] - drive.time_s[i - 1]));
  log.add("yaw_rad", yaw_rad);
  const std::string path = folder.file("log.csv", recording::format_table(log, 17));
  const json said = road_of(path, folder.path("flat.crg"));
  EXPECT_EQ(said.at("places"), "reckoned");
  EXPECT_LT(said.at("turn_rad").get<double>(), 0.05);
  EXPECT_NEAR(length_of(folder.path("flat.crg")), drive.lap_m, 0.01 * drive.lap_m);
  const recording::Table placed = recording::read_table(folder.path("flat_log.csv"));
  ASSERT_NE(placed.find("x_m"), nullptr);
  const std::size_t at = placed.rows() / 2;
  const auto moved_m = [&](const char* name) {
    return placed.find(name)->at(at + 1) - placed.find(name)->at(at);
  };
  EXPECT_NEAR(std::remainder(std::atan2(moved_m("y_m"), moved_m("x_m")) - yaw_rad[at],
                             2 * std::numbers::pi),
              0.0, 0.05);
  EXPECT_EQ(*placed.find("vx_mps"), drive.vx_mps);
  EXPECT_EQ(*placed.find("time_s"), since_1970);
  const support::ToolRun driven =
      support::run_tool(places::crgdrive(), {"lap", "--road", folder.path("flat.crg"), "--car",
                                             places::source() + "/vehicles/open_wheel/vehicle.yaml",
                                             "-o", folder.path("lap.csv")});
  EXPECT_EQ(driven.code, 0) << driven.err;
  // Two files do not go to one output.
  const support::ToolRun dash = support::run_tool(places::crgexplain(), {"road", path, "-o", "-"});
  EXPECT_EQ(dash.code, 1);
  EXPECT_THAT(dash.err, HasSubstr("name a file"));
}

TEST(FlatRoad, OfLatitudesIsThatOfTheMappingThatMapProposes) {
  const support::TemporaryFolder folder;
  const road::DrivenLap drive = road::drive_round(2.2);
  std::string log = "time [s],lat [deg],long [deg],velocity [km/h]\n";
  constexpr double kMetresOfDegree = 111'132.0;  // near 45 degrees; of longitude less
  for (std::size_t i = 0; i < drive.time_s.size(); ++i)
    log += fmt::format(
        "{:.3f},{:.9f},{:.9f},{:.4f}\n", drive.time_s[i], 45.0 + drive.y_m[i] / kMetresOfDegree,
        9.0 + drive.x_m[i] / (kMetresOfDegree * std::cos(45 * std::numbers::pi / 180)),
        3.6 * drive.vx_mps[i]);
  const std::string path = folder.file("log.csv", log);
  const json said = road_of(path, folder.path("flat.crg"));
  EXPECT_EQ(said.at("places"), "logged");
  EXPECT_NEAR(length_of(folder.path("flat.crg")), drive.lap_m, 0.01 * drive.lap_m);
  ASSERT_EQ(
      support::run_tool(places::crgexplain(), {"map", path, "-o", folder.path("m.yaml")}).code, 0);
  road_of(path, folder.path("again.crg"), {"--mapping", folder.path("m.yaml")});
  EXPECT_NEAR(length_of(folder.path("again.crg")), length_of(folder.path("flat.crg")), 0.01);
}

TEST(FlatRoad, SaysWhatALogLacks) {
  const support::TemporaryFolder folder;
  const std::string path = folder.file(
      "log.csv", "time_s,vx_mps\n" + [] {
        std::string rows;
        for (int i = 0; i < 100; ++i) rows += fmt::format("{},20\n", 0.05 * i);
        return rows;
      }());
  const auto refused = [&](const Words& words) {
    const support::ToolRun ran = support::run_tool(places::crgexplain(), words);
    EXPECT_EQ(ran.code, 1);
    return ran.err;
  };
  EXPECT_THAT(refused({"road", path, "-o", folder.path("flat.crg")}),
              AllOf(HasSubstr("no yaw_rate_radps"), HasSubstr("x_m and y_m")));
  EXPECT_THAT(refused({"road", path, "-o", path}), HasSubstr("would overwrite it"));
  const std::string empty = folder.file("empty.csv", "time_s,x(m),y(m)\n");
  EXPECT_THAT(refused({"road", empty, "-o", folder.path("flat.crg")}),
              HasSubstr("0 rows: a log of at least 50 is wanted; give a log"));
  std::string ring = "time_s,x_m,y_m\n";
  for (int i = 0; i < 400; ++i)
    ring += fmt::format("{},{},{}\n", 0.1 * i, 60 * std::cos(0.02 * i), 60 * std::sin(0.02 * i));
  const std::string slow = folder.file("ring.csv", ring);
  const support::ToolRun ran =
      support::run_tool(places::crgexplain(), Words{"road", slow, "-o", folder.path("ring.crg")});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, AllOf(HasSubstr("wants time_s and vx_mps too"),
                             testing::Not(HasSubstr("crgexplain run --road"))));
}

/// A recording of others, unpacked; empty: not here.
std::string recording_of_others(const std::string& name, const support::TemporaryFolder& folder) {
  const std::string path = places::data() + "/" + name;
  if (std::filesystem::exists(path)) return path;
  if (!std::filesystem::exists(path + ".xz")) return "";
  const std::string unpacked = folder.path(std::filesystem::path(name).filename());
  return std::system(fmt::format("xz -dc '{}.xz' > '{}'", path, unpacked).c_str()) == 0 ? unpacked
                                                                                        : "";
}

// Lengths that others state for these circuits; a car that cuts its bends drives less.
TEST(SlowFlatRoad, IsAsLongAsTheCircuitsOfRecordingsOfOthers) {
  struct Log {
    const char* file;
    double length_m;
    const char* places;
  };
  const support::TemporaryFolder folder;
  for (const Log& log : {Log{"recordings/putnam_run4_2.csv", 2865, "logged"},
                         {"recordings/Sample1.ld", 2280, "reckoned"},
                         {"recordings/road_america_run1.vbo", 6515, "logged"},
                         {"recordings/road_america_run4.vbo", 6515, "logged"},
                         {"recordings/racechrono_tianma_lap9.csv", 2063, "logged"},
                         {"car/gr86_R1_barber_mvp.csv", 3830, "logged"},
                         {"car/revs_ferrari250lm_pbir_100hz.csv", 3100, "reckoned"},
                         {"lvms/lvms_whole.csv", 2414, "logged"},
                         {"lvms/lvms_cut.csv", 2414, "logged"}}) {
    SCOPED_TRACE(log.file);
    const std::string path = recording_of_others(log.file, folder);
    if (path.empty()) GTEST_SKIP() << "no " << log.file << " beside the checkout";
    const json said = road_of(path, folder.path("flat.crg"));
    EXPECT_EQ(said.at("places"), log.places);
    const double length_m = length_of(folder.path("flat.crg"));
    fmt::print("{}: {:.0f} m of {:.0f}\n", log.file, length_m, log.length_m);
    EXPECT_GT(length_m, 0.95 * log.length_m);
    EXPECT_LT(length_m, 1.02 * log.length_m);
  }
}

// A real drive whose places are known, and reckoned without them.
TEST(SlowFlatRoad, ReckonsTheLapsOfARealCar) {
  const support::TemporaryFolder folder;
  const std::string path = recording_of_others("recordings/putnam_run4_2.csv", folder);
  if (path.empty()) GTEST_SKIP() << "no recording beside the checkout";
  recording::Table log = recording::read_table(path);
  const std::vector<double> x = *log.find("x(m)"), y = *log.find("y(m)");
  for (std::string& name : log.names)
    if (name == "x(m)" || name == "y(m)" || name == "phi(rad)")
      name = "hidden " + name.substr(0, 1);
  road_of(folder.file("blind.csv", recording::format_table(log, 17)), folder.path("flat.crg"));
  const recording::Table placed = recording::read_table(folder.path("flat_log.csv"));
  const std::vector<double>&u = *placed.find("x_m"), &v = *placed.find("y_m");
  ASSERT_EQ(u.size(), x.size());
  using Complex = std::complex<double>;
  Complex mean_p = 0, mean_q = 0, turn = 0;
  double n = 0, square = 0;
  const auto each = [&](const auto& at) {
    for (std::size_t i = 0; i < u.size(); ++i)
      if (std::isfinite(u[i])) at(Complex(u[i], v[i]), Complex(x[i], y[i]));
  };
  each([&](Complex p, Complex q) { mean_p += p, mean_q += q, n += 1; });
  each([&](Complex p, Complex q) { turn += std::conj(p - mean_p / n) * (q - mean_q / n); });
  turn /= std::abs(turn);
  each([&](Complex p, Complex q) {
    square += std::norm((p - mean_p / n) * turn - (q - mean_q / n));
  });
  fmt::print("{:.0f} of {} rows, {:.1f} m rms\n", n, u.size(), std::sqrt(square / n));
  EXPECT_GT(n, 0.5 * static_cast<double>(u.size()));
  EXPECT_LT(std::sqrt(square / n), 15.0);
}

}  // namespace flat_road_test
