// Recordings of the stated car itself, on roads of other kinds than those of the trials: nothing is
// missing, and that is said.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "base/random.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"
#include "vehicle/table.h"

namespace {

using nlohmann::json;
using std::numbers::pi;

struct Pose {
  double x_m, y_m, heading_rad, z_m = 0.0;
};
/// Of the middle at s; the length.
struct Circuit {
  const char* name;
  Pose (*at)(double s_m);
  double length_m;
};

constexpr double kStraight_m = 350.0, kTight_m = 30.0;

/// Two straights and two hairpins.
Pose tight_oval(double s_m) {
  const double half = kStraight_m + pi * kTight_m;
  const bool back = s_m >= half;
  const double s = back ? s_m - half : s_m;
  const double turn = std::max(0.0, s - kStraight_m) / kTight_m;
  const double x = std::min(s, kStraight_m) + kTight_m * std::sin(turn) - 0.5 * kStraight_m,
               y = kTight_m * (1 - std::cos(turn)) - kTight_m;
  return back ? Pose{-x, -y, turn + pi} : Pose{x, y, turn};
}

constexpr double kCentre_m = 140.0, kBend_m = 70.0;
const double kCrossing_rad = std::asin(kBend_m / kCentre_m),
             kTangent_m = std::sqrt(kCentre_m * kCentre_m - kBend_m * kBend_m),
             kArc_rad = pi + 2 * kCrossing_rad,
             kEight_m = 2 * (2 * kTangent_m + kBend_m * kArc_rad);

/// A figure of eight: it comes back to its crossing 6 m higher.
Pose eight(double s_m) {
  const double z = 3 * (1 - std::cos(2 * pi * s_m / kEight_m)), half = 0.5 * kEight_m;
  const bool second = s_m >= half;
  const double s = second ? s_m - half : s_m, bend = kBend_m * kArc_rad;
  Pose p{};
  if (s < kTangent_m) {
    p = {s * std::cos(-kCrossing_rad), s * std::sin(-kCrossing_rad), -kCrossing_rad};
  } else if (s < kTangent_m + bend) {
    const double heading = -kCrossing_rad + (s - kTangent_m) / kBend_m;
    p = {kCentre_m + kBend_m * std::sin(heading), -kBend_m * std::cos(heading), heading};
  } else {
    const double left = 2 * kTangent_m + bend - s, heading = pi + kCrossing_rad;
    p = {-left * std::cos(heading), -left * std::sin(heading), heading};
  }
  // The other half is the same about the crossing, to the right.
  return second ? Pose{-p.x_m, p.y_m, pi - p.heading_rad, z} : Pose{p.x_m, p.y_m, p.heading_rad, z};
}

/// Surveyed edges, 6 m to either side.
void write_edges(const support::TemporaryFolder& folder, const Circuit& c) {
  constexpr double kBegin_m = 60.0;  // on a straight
  for (const double side : {6.0, -6.0}) {
    std::string text = "x_m,y_m,z_m\n";
    const int points = static_cast<int>(c.length_m / 2);
    for (int k = 0; k < points; ++k) {
      const Pose p = c.at(std::fmod(kBegin_m + k * c.length_m / points, c.length_m));
      text += fmt::format("{:.4f},{:.4f},{:.4f}\n", p.x_m - side * std::sin(p.heading_rad),
                          p.y_m + side * std::cos(p.heading_rad), p.z_m);
    }
    folder.file(side > 0 ? "left.csv" : "right.csv", text);
  }
}

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
  const vehicle::Table all = vehicle::read_table(telemetry);
  base::Random dice{seed};
  vehicle::Table out;
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

class OwnCar : public ::testing::TestWithParam<Circuit> {};

TEST_P(OwnCar, HasNothingMissing) {
  const support::TemporaryFolder folder;
  write_edges(folder, GetParam());
  const auto run = [](const std::string& program, const std::vector<std::string>& words) {
    const support::ToolRun ran = support::run_tool(program, words);
    EXPECT_EQ(ran.code, 0) << ran.err;
  };
  const std::string car = places::source() + "/vehicles/open_wheel/vehicle.yaml";
  run(places::crgbuild(), {"from-edges", folder.path("left.csv"), folder.path("right.csv"),
                           "--name", "road", "-o", folder.path("road")});
  run(places::crgdrive(), {"lap", "--vehicle", car, "--track", folder.path("road/road.crg"),
                           "--laps", "4", "--rate-hz", "50", "-o", folder.path("lap.csv"), "-q"});
  for (const bool commands : {false, true}) {
    const std::string log = folder.file(commands ? "commands.csv" : "measured.csv",
                                        logged(folder.path("lap.csv"), commands, 7));
    run(places::crgexplain(),
        {"run", "--skip-simulation", "--track", folder.path("road/road.crg"), "--vehicle", car,
         "--recordings", log, "--fuel-kg", "30", "-o", folder.path("out")});
    const json found = json::parse(folder.read("out/findings.json"));
    EXPECT_EQ(found.at("verdict"), "none")
        << found.at("findings").dump(1) << found.at("unexplained").dump(1);
  }
}

INSTANTIATE_TEST_SUITE_P(Circuits, OwnCar,
                         ::testing::Values(Circuit{"TightOval", tight_oval,
                                                   2 * (kStraight_m + pi * kTight_m)},
                                           Circuit{"CrossesItself", eight, kEight_m}),
                         [](const auto& circuit) { return circuit.param.name; });

}  // namespace
