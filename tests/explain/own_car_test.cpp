// Recordings of the stated car itself, on a tighter road than those of the trials: nothing is
// missing, and that is said.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "base/json_text.h"
#include "base/random.h"
#include "crg/file.h"
#include "crg/surface.h"
#include "explain/signals.h"
#include "recording/table.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"
#include "vehicle/error.h"
#include "vehicle/test_roads.h"

namespace own_car_test {

using nlohmann::json;

/// The telemetry's columns as loggers have them, with white noise.
std::string logged(const std::string& telemetry, bool commands, std::uint64_t seed) {
  const std::map<std::string, double> noise{{"time_s", 0},
                                            {"x_m", 0.03},
                                            {"y_m", 0.03},
                                            {"yaw_rad", 0.003},
                                            {"vx_mps", 0.04},
                                            {"vy_mps", 0.06},
                                            {"yaw_rate_radps", 5e-3},
                                            {"ax_mps2", 0.25},
                                            {"ay_mps2", 0.25},
                                            {"steer_rad", 6e-4},
                                            {"throttle", 0.004},
                                            {"brake_fl_pa", 3e4},
                                            {"brake_fr_pa", 3e4},
                                            {"brake_rl_pa", 3e4},
                                            {"brake_rr_pa", 3e4},
                                            {"wheel_fl_radps", 0.25},
                                            {"wheel_fr_radps", 0.25},
                                            {"wheel_rl_radps", 0.25},
                                            {"wheel_rr_radps", 0.25},
                                            {"engine_radps", 2},
                                            {"gear", 0}};
  const recording::Table all = recording::read_table(telemetry);
  base::Random dice{seed};
  recording::Table out;
  for (const auto& [channel, its_noise] : noise) {
    std::string name = channel;
    double sd = its_noise;
    if (commands && name == "steer_rad") name = "steer_command_rad", sd = 0;
    if (commands && name == "throttle") name = "throttle_command", sd = 0;
    std::vector<double> values = *all.find(name);
    for (double& x : values) x += sd * dice.normal();
    out.add(name, values);
  }
  std::string text = fmt::format("{}\n", fmt::join(out.names, ","));
  for (std::size_t k = 0; k < out.rows(); ++k)
    for (std::size_t c = 0; c < out.columns.size(); ++c)
      text += fmt::format("{:.9g}{}", out.columns[c][k], c + 1 < out.columns.size() ? "," : "\n");
  return text;
}

// A driver who shifts down in hairpins and brakes wheel by wheel.
TEST(SlowOwnCar, HasNothingMissing) {
  const support::TemporaryFolder folder;
  const std::string track = folder.path("road.crg");
  const crg::Crg road = stadium(350, 30);
  crg::write(road, track, road.format);
  const auto run = [](const std::string& program, const std::vector<std::string>& words) {
    const support::ToolRun ran = support::run_tool(program, words);
    EXPECT_EQ(ran.code, 0) << ran.err;
  };
  const std::string car = places::source() + "/vehicles/open_wheel/vehicle.yaml";
  run(places::crgdrive(), {"lap", "--car", car, "--road", track, "--laps", "3", "--rate-hz", "50",
                           "-o", folder.path("lap.csv"), "-q"});
  for (const bool commands : {false, true}) {
    const std::string log = folder.file(commands ? "commands.csv" : "measured.csv",
                                        logged(folder.path("lap.csv"), commands, 7));
    std::vector<std::string> words{"run", "--road", track, "--car", car, "--log", log};
    words.insert(words.end(), {"--fuel-kg", "30", "--skip-simulation", "-o", folder.path("out")});
    if (commands) words.insert(words.end(), {"--hold-out", "2"});
    run(places::crgexplain(), words);
    const json found = base::parse_json<json>(folder.read("out/findings.json"));
    EXPECT_EQ(found.at("verdict"), "none")
        << base::dump_json(found.at("findings"), 1) << base::dump_json(found.at("unexplained"), 1);
  }
}

/// What is said of a log of a car on that road.
std::string said(const recording::Table& log, const crg::Surface& road) {
  std::string out;
  try {
    const explain::Signals s =
        explain::make_signals(log, explain::identity_mapping(log), road, "log.csv");
    for (const std::string& remark : s.remarks) out += remark + "\n";
    if (s.broken) out += "broken";
  } catch (const vehicle::Error& error) {
    out = error.what();
  }
  return out;
}

// A driver who swings the steering, a road that leans and climbs, and tyres that hardly slip: all
// of them hide what is wrong with columns.
TEST(SlowOwnCar, BrokenColumnsAreNamedAsWhatTheyAre) {
  const support::TemporaryFolder folder;
  const std::string ring = places::source() + "/tracks/kerbstone-ring/circuit.yaml";
  ASSERT_EQ(support::run_tool(places::crgbuild(), {"synth", ring, "-o", folder.path("ring")}).code,
            0);
  const std::string track = folder.path("ring/kerbstone-ring_truth.crg"),
                    car = places::source() + "/vehicles/open_wheel/vehicle.yaml";
  ASSERT_EQ(
      support::run_tool(places::crgdrive(), {"lap", "--car", car, "--road", track, "--rate-hz",
                                             "50", "-o", folder.path("lap.csv"), "-q"})
          .code,
      0);
  recording::Table good =
      recording::read_table(folder.file("log.csv", logged(folder.path("lap.csv"), false, 7)));
  const recording::Table lap = recording::read_table(folder.path("lap.csv"));
  for (const char* load : {"fz_fl_n", "fz_fr_n", "fz_rl_n", "fz_rr_n"})
    good.add(load, *lap.find(load));
  const crg::Surface road(crg::read(track));
  const auto column = [](recording::Table& t, const std::string& name) -> std::vector<double>& {
    return t.columns.at(static_cast<std::size_t>(std::find(t.names.begin(), t.names.end(), name) -
                                                 t.names.begin()));
  };
  EXPECT_EQ(said(good, road).find("broken"), std::string::npos) << said(good, road);

  recording::Table bus = good;
  for (const std::string& name : good.names)
    for (const char* of_the_bus : {"vx_", "wheel", "steer", "throttle", "brake", "engine", "fz_"})
      if (name.starts_with(of_the_bus))
        std::rotate(column(bus, name).begin(), column(bus, name).end() - 10,
                    column(bus, name).end());
  EXPECT_THAT(said(bus, road), ::testing::ContainsRegex("come 0.(19|20)"));

  recording::Table clock = good;
  for (double& t : column(clock, "time_s")) t *= 0.98;
  EXPECT_THAT(said(clock, road), ::testing::HasSubstr("the clock runs slow by 2."));

  recording::Table driven = good;
  for (std::size_t i = 0; i < driven.rows(); ++i)
    column(driven, "vx_mps")[i] =
        0.16 * (column(driven, "wheel_rl_radps")[i] + column(driven, "wheel_rr_radps")[i]);
  EXPECT_THAT(said(driven, road), ::testing::HasSubstr("speed of the driven wheels"));

  recording::Table loads = good;
  for (const char* side : {"l_n", "r_n"})
    std::swap(column(loads, std::string("fz_f") + side), column(loads, std::string("fz_r") + side));
  EXPECT_THAT(said(loads, road), ::testing::HasSubstr("front and rear are exchanged"));

  recording::Table across = good;
  for (double& vy : column(across, "vy_mps")) vy *= 3.6;
  EXPECT_THAT(said(across, road),  // at most 3.6
              ::testing::ContainsRegex("'vy_mps' is (2.[5-9]|3.[0-5]).* or more"));
}

/// The 300 m in which a car turns most steadily at speed: where they begin, and the way of the
/// turn.
struct Turn {
  double begin_m = 0.0, sign = 1.0;
};
Turn steadiest_turn(const recording::Table& lap) {
  constexpr double kCell_m = 20.0;
  constexpr int kCells = 15;
  std::map<int, std::array<double, 3>> cells;  // count, sums of ay and of speed
  for (std::size_t i = 0; i < lap.rows(); ++i) {
    auto& cell = cells[static_cast<int>((*lap.find("u_m"))[i] / kCell_m)];
    cell[0] += 1, cell[1] += (*lap.find("ay_mps2"))[i], cell[2] += (*lap.find("vx_mps"))[i];
  }
  Turn out;
  double most = 0.0;
  for (int begin = 5; begin + kCells + 5 < static_cast<int>(cells.size()); ++begin) {
    std::array<double, 3> sum{};
    for (int k = begin; k < begin + kCells; ++k)
      for (std::size_t of = 0; of < 3; ++of) sum[of] += cells[k][of];
    const double ay = sum[1] / sum[0];
    if (sum[2] / sum[0] > 35.0 && std::abs(ay) > most)
      most = std::abs(ay), out = {begin * kCell_m, ay > 0 ? 1.0 : -1.0};
  }
  return out;
}

/// The same road, but it leans by 0.03 more into the turn.
void lean(crg::Crg& road, const Turn& turn) {
  const std::size_t columns = road.grid.v_m.size();
  for (std::size_t i = 0; i < road.grid.z_m.size(); ++i) {
    const double u = static_cast<double>(i / columns) * road.grid.u_step_m - turn.begin_m;
    const double in = std::clamp(std::min(u, 300.0 - u) / 30.0, 0.0, 1.0);
    road.grid.z_m[i] -= static_cast<float>(0.03 * turn.sign * in * in * (3.0 - 2.0 * in) *
                                           road.grid.v_m[i % columns]);
  }
}

// The whole way round, on circuits that others drew: where the road file is wrong is found by the
// recording, scanned, refined, and then nothing is missing. Minutes each.
class SlowLoop : public ::testing::TestWithParam<const char*> {};
TEST_P(SlowLoop, EndsWhereThePlaceThatWasNamedIsScanned) {
  const std::string name = std::string("f1_") + GetParam();
  const std::string mesh = places::data() + "/f1/" + name + ".glb";
  if (!std::filesystem::exists(mesh)) GTEST_SKIP() << "skipped: " << mesh << " is not there";
  const support::TemporaryFolder folder;
  const std::string car = places::source() + "/vehicles/open_wheel/vehicle.yaml";
  const auto run = [](const std::string& program, const std::vector<std::string>& words) {
    const support::ToolRun ran = support::run_tool(program, words);
    ASSERT_EQ(ran.code, 0) << ran.err;
  };
  const std::string truth = folder.path("true/" + name + ".crg"), base = folder.path("base.crg");
  run(places::crgbuild(), {"build", mesh, "-o", folder.path("true"), "--no-report"});
  run(places::crgdrive(), {"lap", "--car", car, "--road", truth, "--laps", "3", "--rate-hz", "50",
                           "-o", folder.path("lap.csv"), "-q"});
  const std::string log = folder.file("log.csv", logged(folder.path("lap.csv"), false, 7));
  const Turn turn = steadiest_turn(recording::read_table(folder.path("lap.csv")));
  crg::Crg road = crg::read(truth);
  lean(road, turn);
  crg::write(road, base, road.format);

  const auto explained = [&](const std::string& on, const std::string& out) {
    run(places::crgexplain(), {"run", "--road", on, "--car", car, "--log", log, "--fuel-kg", "30",
                               "--hold-out", "2", "--skip-simulation", "-o", folder.path(out)});
    return base::parse_json<json>(folder.read(out + "/findings.json"));
  };
  const json before = explained(base, "before");
  ASSERT_FALSE(before.at("findings").empty());
  const json& found = before.at("findings").at(0);
  EXPECT_EQ(found.at("mechanism"), "road.banking") << base::dump_json(before.at("findings"), 1);
  EXPECT_EQ(before.at("findings").size(), 1u) << base::dump_json(before.at("findings"), 1);
  const double begin = found.at("where").at(0).at("u_begin_m"),
               end = found.at("where").at(0).at("u_end_m");
  const double wanted_begin = turn.begin_m + 15.0, wanted_end = turn.begin_m + 285.0;
  EXPECT_GT(std::min(end, wanted_end) - std::max(begin, wanted_begin),
            0.6 * (std::max(end, wanted_end) - std::min(begin, wanted_begin)));
  for (const json& held : found.at("held_out"))
    if (held.at("channel") == "ay") {
      EXPECT_LT(held.at("rmse_after"), held.at("rmse_before"));
    }

  run(places::lidar2mesh(),
      {"synth", truth, "-o", folder.path("scans"), "--u-begin-m", fmt::format("{:.0f}", begin - 60),
       "--u-end-m", fmt::format("{:.0f}", end + 60), "--cars", "0", "-q"});
  run(places::lidar2mesh(),
      {"map", folder.path("scans"), "--trajectory", folder.path("scans/trajectory.csv"), "--road",
       base, "-o", folder.path("refined"), "-q"});
  const json after = explained(folder.path("refined/refined.crg"), "after");
  EXPECT_EQ(after.at("verdict"), "none") << base::dump_json(after.at("findings"), 1);
}
INSTANTIATE_TEST_SUITE_P(, SlowLoop, ::testing::Values("suzuka", "silverstone_07"));

}  // namespace own_car_test
