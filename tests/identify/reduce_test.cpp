// Reduced cars against the full ones, and as files.
#include "identify/reduce.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <sstream>

#include "base/error.h"
#include "identify/proving_road.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "vehicle/vehicle_file.h"

namespace reduce_test {

using identify::LapError, identify::PartError, identify::PlanarState, identify::ReduceBounds,
    identify::Reduction;
using ::testing::HasSubstr;
using ::testing::Not;

struct Loaded {
  vehicle::Vehicle vehicle;
  vehicle::Car<double> car;
  explicit Loaded(const std::string& name, const std::vector<std::string>& settings = {})
      : vehicle(vehicle::read_vehicle(places::source() + "/vehicles/" + name + "/vehicle.yaml")) {
    for (const std::string& s : settings) vehicle::apply_setting(vehicle, s, "test");
    car = make_car(vehicle.files, vehicle.parameters, vehicle.terms, vehicle.contact);
  }
};

bool heavy() { return std::getenv("KERBSTONE_HEAVY") != nullptr; }

PlanarState cornering(double vx_mps, double drive_nm, double brake_n) {
  PlanarState in;
  in.vx_mps = vx_mps;
  in.vy_mps = -0.4;
  in.yaw_rate_radps = 12.0 / vx_mps;
  in.steer_rad = 0.06;
  in.an_mps2 = 10.5;
  in.ax_mps2 = -brake_n / 400.0;
  in.fx_n[0] = -brake_n;
  in.fx_n[1] = drive_nm / 0.33 - brake_n;
  in.drive_nm = drive_nm;
  in.grip[0] = 0.97;
  in.stiffness[1] = 0.95;
  return in;
}

/// The header, compiled by the C compiler, says the same as the formulas.
void compare_in_c(const Reduction& r, const std::string& header) {
  const cli::Folder folder;
  cli::write(folder / "control.h", header);
  const std::vector<PlanarState> states{cornering(30.0, 0.0, 0.0), cornering(45.0, 900.0, 0.0),
                                        cornering(25.0, 0.0, 1500.0)};
  std::string program =
      "#include <stdio.h>\n#include \"control.h\"\nstatic void say(control_state s) {\n"
      "  const control_forces a = control_single_track(&control_car_values, &s);\n"
      "  const control_forces b = control_double_track(&control_car_values, &s);\n"
      "  control_lags one = control_no_lags(), two = control_no_lags();\n  double late[2];\n"
      "  control_single_track_lagged(&control_car_values, &s, &one, 0.0);\n"
      "  control_double_track_lagged(&control_car_values, &s, &two, 0.0);\n"
      "  s.steer_rad += 0.01;\n"
      "  late[0] = control_single_track_lagged(&control_car_values, &s, &one, 0.004).ay_mps2;\n"
      "  late[1] = control_double_track_lagged(&control_car_values, &s, &two, 0.004).ay_mps2;\n"
      "  printf(\"%.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g\\n\", a.ay_mps2, a.yaw_moment_nm, "
      "b.ay_mps2, b.yaw_moment_nm, b.fz_n[1], b.differential_nm, late[0], late[1]);\n}\n"
      "int main(void) {\n";
  for (const PlanarState& s : states)
    program += fmt::format(
        "  {{ const control_state s = {{{}, {}, {}, {}, {}, {}, {{{}, {}}}, {}, {{{}, {}}}, {{{}, "
        "{}}}}}; say(s); }}\n",
        s.vx_mps, s.vy_mps, s.yaw_rate_radps, s.steer_rad, s.ax_mps2, s.an_mps2, s.fx_n[0],
        s.fx_n[1], s.drive_nm, s.grip[0], s.grip[1], s.stiffness[0], s.stiffness[1]);
  const auto& e = r.ellipses.front();
  program += fmt::format(
      "  printf(\"%.9g %.9g\\n\", control_border_radius({0}, {1}, {2}, {3}), "
      "control_border_radius({0}, {1}, {4}, 0.0));\n  return 0;\n}}\n",
      e.vx_mps, e.an_mps2, e.ax_mps2, e.ay_mps2, e.brake_mps2);
  cli::write(folder / "main.c", program);
  const std::string command = fmt::format(
      "cd '{}' && cc -std=c99 -Wall -Wextra -Werror -O1 main.c -o main -lm > log 2>&1 && ./main > "
      "said",
      folder.path());
  ASSERT_EQ(std::system(command.c_str()), 0) << cli::read(folder / "log");
  std::istringstream said(cli::read(folder / "said"));
  for (const PlanarState& s : states) {
    const auto a = identify::single_track(r.car, s), b = identify::double_track(r.car, s);
    identify::SlipLags one{}, two{};
    identify::single_track(r.car, s, &one);
    identify::double_track(r.car, s, &two);
    PlanarState turned = s;
    turned.steer_rad += 0.01;
    double value[8];
    for (double& v : value) said >> v;
    // The header has nine digits of each number.
    EXPECT_NEAR(value[0], a.ay_mps2, 1e-6);
    EXPECT_NEAR(value[1], a.yaw_moment_nm, 1e-3);
    EXPECT_NEAR(value[2], b.ay_mps2, 1e-6);
    EXPECT_NEAR(value[3], b.yaw_moment_nm, 1e-3);
    EXPECT_NEAR(value[4], b.fz_n[1], 1e-3);
    EXPECT_NEAR(value[5], b.differential_nm, 1e-3);
    EXPECT_NEAR(value[6], identify::single_track(r.car, turned, &one, 0.004).ay_mps2, 1e-6);
    EXPECT_NEAR(value[7], identify::double_track(r.car, turned, &two, 0.004).ay_mps2, 1e-6);
  }
  double at_turn = 0.0, at_brake = 0.0;
  said >> at_turn >> at_brake;
  EXPECT_NEAR(at_turn, 1.0, 1e-6);
  EXPECT_NEAR(at_brake, 1.0, 1e-6);
}

const PartError& part(const Reduction& r, const std::string& name) {
  for (const PartError& e : r.parts)
    if (e.name == name) return e;
  ADD_FAILURE() << name;
  return r.parts.front();
}

TEST(Reduce, TheRacerIsWithinTheBounds) {
  const Loaded racer("open_wheel");
  identify::ReduceOptions options;
  options.speeds = 3;
  options.slips = 10;
  options.gravities = {0.7, 1.3};
  options.threads = 2;
  const Reduction r = identify::reduce_car(racer.car, options);
  const crg::Surface road(identify::proving_road());
  const LapError lap = identify::compare_on_lap(racer.car, r, vehicle::Road(road));
  // Measured with these options, 2026-11-24: see docs/evidence.md for those of the command.
  EXPECT_LT(lap.single.ay_rms, 0.015);
  EXPECT_LT(lap.two.ay_rms, 0.015);
  EXPECT_LT(r.limit_double.rms, 0.01);
  EXPECT_LT(r.limit_double.most, 0.015);
  EXPECT_LT(r.limit_single.rms, 0.02);
  EXPECT_EQ(r.limit_double.rows, 6u);
  EXPECT_LT(part(r, "front wheel, side force").rms, 0.004);
  EXPECT_LT(part(r, "rear axle load").rms, 0.005);
  EXPECT_LT(part(r, "torque that the differential moves").rms, 0.06);
  EXPECT_GT(lap.load_rms_without_vertical, 1.5 * lap.two.load_rms);
  EXPECT_GT(lap.load_rms_without_bank, 1.2 * lap.two.load_rms);
  EXPECT_GT(lap.rows, 4000u);

  const ReduceBounds bounds{0.02, 0.02};
  const std::string yaml = identify::control_yaml(r, lap, bounds, "a test"),
                    header = identify::control_header(r, lap, bounds, "a test */ int x;");
  EXPECT_THAT(yaml, Not(HasSubstr("refused")));
  EXPECT_THAT(yaml, Not(HasSubstr("nan")));
  compare_in_c(r, header);

  // What misses its bound is left out, and said.
  const ReduceBounds strict{0.02, 1e-6};
  EXPECT_THAT(identify::why_refused(r, lap, strict, true), HasSubstr("steady-state limit is 0."));
  EXPECT_THAT(identify::why_refused(r, lap, strict, true),
              ::testing::ContainsRegex("% at [0-9]+ m/s, pressed by [0-9.]+ m/s2"));
  const std::string without = identify::control_yaml(r, lap, strict, "a test");
  EXPECT_THAT(without, HasSubstr("refused: \"double-track: its steady-state limit"));
  EXPECT_THAT(without, Not(HasSubstr("front_wheel:")));
  EXPECT_THAT(identify::control_header(r, lap, strict, "a test"),
              Not(HasSubstr("control_double_track")));
  LapError broken = lap;
  broken.two.ay_rms = std::nan("");
  EXPECT_NE(identify::why_refused(r, broken, bounds, true), "");
}

TEST(Reduce, AnyNumberOfThreadsGivesTheSame) {
  const Loaded racer("open_wheel");
  identify::ReduceOptions options;
  options.speeds = 2;
  options.slips = 5;
  options.gravities = {1.0};
  options.most_mps = 40.0;
  options.threads = 1;
  const Reduction one = identify::reduce_car(racer.car, options);
  options.threads = 3;
  const Reduction three = identify::reduce_car(racer.car, options);
  const LapError none;
  const ReduceBounds open{1.0, 1.0};
  EXPECT_EQ(identify::control_yaml(one, none, open, ""),
            identify::control_yaml(three, none, open, ""));
  EXPECT_EQ(identify::border_csv(one), identify::border_csv(three));
}

TEST(Reduce, SpeedsThatTheCarDoesNotReachAreRefused) {
  const Loaded weak("open_wheel", {"engine.torque=0.1", "aero.drag_area_m2=15"});
  identify::ReduceOptions options;
  options.least_mps = 30.0;
  EXPECT_THROW(identify::reduce_car(weak.car, options), base::Error);
}

TEST(Reduce, ACarThatCannotBrakeIsRefused) {
  const Loaded rolls("open_wheel", {"front.brake_area_m2=0"});
  EXPECT_THROW(identify::reduce_car(rolls.car), base::Error);
}

TEST(Reduce, BothCarsAndALockedDifferential) {
  if (!heavy()) GTEST_SKIP() << "minutes; KERBSTONE_HEAVY=1 runs it";
  struct Case {
    const char* car;
    std::vector<std::string> settings;
    double limit;
  };
  for (const Case& c : {Case{"open_wheel", {}, 0.01}, Case{"av21", {}, 0.01},
                        Case{"open_wheel", {"locked_differential=1", "limited_slip=0"}, 0.01}}) {
    const Loaded racer(c.car, c.settings);
    const Reduction r = identify::reduce_car(racer.car);
    const crg::Surface road(identify::proving_road());
    const LapError lap = identify::compare_on_lap(racer.car, r, vehicle::Road(road));
    for (const auto& model : {lap.single, lap.two})
      support::figure_of_case("ay_percent", 100.0 * model.ay_rms),
          support::figure_of_case("ay_95_percent", 100.0 * model.ay_95);
    for (const auto& limit : {r.limit_single, r.limit_double})
      support::figure_of_case("limit_percent", 100.0 * limit.rms);
    EXPECT_LT(lap.two.ay_rms, 0.02) << c.car;
    EXPECT_LT(r.limit_double.rms, c.limit) << c.car;
    EXPECT_LT(r.limit_double.most, 0.02) << c.car;
  }
}

}  // namespace reduce_test
