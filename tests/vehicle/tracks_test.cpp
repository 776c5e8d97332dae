// Whole laps of real tracks and of the demo circuit with its kerbs: built here, then driven.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "support/figure.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "vehicle/lap.h"
#include "vehicle/vehicle_file.h"

namespace tracks_test {

using namespace vehicle;  // NOLINT: a test of this library

class Tracks : public ::testing::TestWithParam<const char*> {
 protected:
  /// The road, built by crgbuild; empty where its mesh is not installed.
  static std::optional<crg::Surface> build(const std::string& name, const cli::Folder& folder) {
    std::vector<std::string> arguments;
    if (name == "kerbstone-ring") {
      const std::string circuit = fmt::format("{}/tracks/{}/circuit.yaml", places::source(), name);
      EXPECT_EQ(cli::crgbuild({"synth", circuit, "-o", folder.path()}).code, 0);
      arguments = {"build", folder / "kerbstone-ring.obj", "--start-at", "0,0"};
    } else {
      if (!cli::exists(fmt::format("{0}/road/{1}/{1}.acc", places::torcs_tracks(), name)))
        return {};
      arguments = {"build", fmt::format("{}/tracks/{}/track.yaml", places::source(), name)};
    }
    arguments.insert(arguments.end(), {"-o", folder.path()});
    const cli::Ran ran = cli::crgbuild(arguments);
    EXPECT_EQ(ran.code, 0) << ran.err;
    return crg::Surface(crg::read(folder / (name + ".crg")));
  }
};

TEST_P(Tracks, AreDrivenHotColdAndByExplicitEuler) {
  const cli::Folder folder;
  const std::optional<crg::Surface> surface = build(GetParam(), folder);
  if (!surface) GTEST_SKIP() << "the package torcs-data is not installed";
  const Vehicle v = read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  const auto drive = [&](const char* what, const LapOptions& options) {
    const Car<double> car = make_car(v.files, v.parameters, v.terms);
    const LapResult r = drive_laps(car, Road(*surface), options);
    EXPECT_TRUE(r.complete) << what << ": " << r.problem;
    // All four wheels on the road's v range, at all times.
    EXPECT_GT(r.least_edge_m, 0.0) << what;
    EXPECT_EQ(r.steps_off_road, 0u) << what;
    EXPECT_LT(r.step_swing, 0.01) << what;
    EXPECT_LT(std::abs(r.energy_j.sum() - r.energy_change_j), 1e-3 * r.energy_j.engine) << what;
    fmt::print("{} {}: {:.3f} s, top {:.1f} m/s, edge {:.2f} m, swing {:.4f} %\n", GetParam(), what,
               r.lap_s.empty() ? 0.0 : r.lap_s[0], r.top_mps, r.least_edge_m, 100 * r.step_swing);
    return r;
  };
  LapOptions options;
  options.record_every = 0;
  const LapResult hot = drive("hot", options);
  support::figure("lap_s", hot.lap_s.at(0));
  if (std::string(GetParam()) == "aalborg") {
    EXPECT_EQ(drive("hot again", options).lap_s, hot.lap_s);
  }
  options.standing = true;
  options.tyre_k = options.disc_k = 295;
  const LapResult cold = drive("cold, standing", options);
  EXPECT_GT(cold.lap_s.at(0), hot.lap_s.at(0) + 1.0);
  // Explicit Euler from standstill to top speed, the car as it is shipped.
  options.tyre_k = 360;
  options.disc_k = 500;
  options.step.integrator = Integrator::kExplicitEuler;
  const LapResult euler = drive("explicit Euler, standing", options);
  EXPECT_GT(euler.top_mps, 50);
}

double planned_s(const crg::Surface& surface, const Car<double>& car) {
  RacingLine line = plan_line(surface);
  plan_speed(line, car, {});
  double sum = 0.0;
  for (std::size_t i = 0, n = line.s_m.size(); i < n; ++i)
    sum += ((i + 1 < n ? line.s_m[i + 1] : line.length_m) - line.s_m[i]) /
           (0.5 * (line.speed_mps[i] + line.speed_mps[(i + 1) % n]));
  return sum;
}

// On ice and rain the car stays on the road, too, as fast as planned.
TEST(SlowTracks, AreDrivenWithLittleGrip) {
  const Vehicle v = read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  for (const std::string name : {"g-track-1", "wheel-1"}) {
    const std::string mesh = fmt::format("{0}/road/{1}/{1}.acc", places::torcs_tracks(), name);
    if (!cli::exists(mesh)) GTEST_SKIP() << "the package torcs-data is not installed";
    const cli::Folder folder;
    const cli::Ran ran = cli::crgbuild({"build", mesh, "-o", folder.path()});
    ASSERT_EQ(ran.code, 0) << ran.err;
    const crg::Surface surface(crg::read(folder / (name + ".crg")));
    for (const double grip : {0.4, 0.5, 0.7}) {
      Parameters<double> parameters = v.parameters;
      parameters[Parameter::environment_road_grip] = grip;
      const Car<double> car = make_car(v.files, parameters, v.terms);
      LapOptions options;
      options.record_every = 0;
      const LapResult lap = drive_laps(car, Road(surface), options);
      ASSERT_TRUE(lap.complete) << name << " " << grip << ": " << lap.problem << lap.limit;
      EXPECT_EQ(lap.steps_off_road, 0u) << name << " " << grip << ": " << lap.limit;
      const double plan_s = planned_s(surface, car);
      EXPECT_NEAR(lap.lap_s.at(0), plan_s, 0.05 * plan_s) << name << " " << grip;
      fmt::print("{} grip {}: {:.2f} s, planned {:.2f} s, at most {:.2f} m off the line\n", name,
                 grip, lap.lap_s.at(0), plan_s, lap.furthest_off_line_m);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, Tracks, ::testing::Values("aalborg"));
INSTANTIATE_TEST_SUITE_P(Slow, Tracks,
                         ::testing::Values("g-track-1", "e-track-3", "kerbstone-ring"),
                         [](const auto& track) {
                           std::string name = track.param;
                           for (char& c : name)
                             if (c == '-') c = '_';
                           return name;
                         });

}  // namespace tracks_test
