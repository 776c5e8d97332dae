// Recordings of the stated car itself, on a tighter road than those of the trials: nothing is
// missing, and that is said.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "base/json_text.h"
#include "base/random.h"
#include "crg/file.h"
#include "recording/table.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"
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

}  // namespace own_car_test
