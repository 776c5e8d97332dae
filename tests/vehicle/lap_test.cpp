#include "vehicle/lap.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/figure.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "test_roads.h"
#include "vehicle/driver.h"
#include "vehicle/error.h"
#include "vehicle/start.h"
#include "vehicle/vehicle_file.h"

namespace lap_test {

using namespace vehicle;  // NOLINT: a test of this library

Vehicle racer() { return read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml"); }

TEST(Lap, IsCompletedFlyingAndStandingHotAndCold) {
  const Vehicle v = racer();
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  const crg::Surface surface(stadium());
  LapOptions options;
  options.laps = 2;
  options.record_every = 0;
  const LapResult flying = drive_laps(car, Road(surface), options);
  ASSERT_TRUE(flying.complete) << flying.problem;
  EXPECT_EQ(flying.steps_off_road, 0u);
  EXPECT_GT(flying.least_edge_m, 0.3);
  options.standing = true;
  const LapResult standing = drive_laps(car, Road(surface), options);
  ASSERT_TRUE(standing.complete) << standing.problem;
  EXPECT_GT(standing.lap_s[0], flying.lap_s[0] + 1.0);
  options.tyre_k = 295;
  options.disc_k = 295;
  const LapResult cold = drive_laps(car, Road(surface), options);
  ASSERT_TRUE(cold.complete) << cold.problem;
  EXPECT_EQ(cold.steps_off_road, 0u);
  EXPECT_GT(cold.lap_s[0], standing.lap_s[0] + 0.5);
}

// The plan knows how slippery the road is, and the driver keeps to it.
TEST(Lap, OnASlipperyRoadStaysOnIt) {
  const Vehicle v = racer();
  const crg::Surface surface(stadium());
  LapOptions options;
  options.record_every = 0;
  for (const double grip : {0.4, 0.7, 1.2}) {
    Parameters<double> parameters = v.parameters;
    parameters[Parameter::environment_road_grip] = grip;
    const Car<double> car = make_car(v.files, parameters, v.terms);
    RacingLine line = plan_line(surface);
    plan_speed(line, car, options.speed);
    double planned_s = 0.0;
    for (std::size_t i = 0, n = line.s_m.size(); i < n; ++i)
      planned_s += ((i + 1 < n ? line.s_m[i + 1] : line.length_m) - line.s_m[i]) /
                   (0.5 * (line.speed_mps[i] + line.speed_mps[(i + 1) % n]));
    const LapResult lap = drive_laps(car, Road(surface), options);
    ASSERT_TRUE(lap.complete) << grip << ": " << lap.problem;
    EXPECT_EQ(lap.steps_off_road, 0u) << grip;
    EXPECT_NEAR(lap.lap_s[0], planned_s, 0.05 * planned_s) << grip;
  }
}

// Which limit the car met where it left its line.
TEST(Lap, SaysWhyTheCarLeftItsLine) {
  const Vehicle v = racer();
  LapOptions options;
  options.record_every = 0;
  const auto drive = [&](const crg::Crg& road, double grip) {
    Parameters<double> parameters = v.parameters;
    parameters[Parameter::environment_road_grip] = grip;
    const crg::Surface surface(road);
    return drive_laps(make_car(v.files, parameters, v.terms), Road(surface), options);
  };
  EXPECT_EQ(drive(stadium(), 1.0).limit, "");
  crg::Crg bumps = stadium();
  const std::size_t columns = bumps.grid.columns();
  for (std::size_t i = 0; i < bumps.grid.z_m.size(); ++i)  // rows that go up and down by 15 cm
    if (i / columns > 380 && i / columns < 650 && i / columns % 4 < 2) bumps.grid.z_m[i] = 0.15f;
  EXPECT_THAT(drive(bumps, 0.4).limit, ::testing::HasSubstr("wheels were off the ground"));
  options.speed.grip_usage = 1.2;
  const std::string slid = drive(stadium(), 1.0).limit;
  EXPECT_THAT(slid, ::testing::HasSubstr("tyres slid more"));
  EXPECT_THAT(slid, ::testing::HasSubstr("--grip-usage"));

  // A driver who looks for it finds the first tenth that keeps the car.
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  const crg::Surface surface(stadium());
  const auto [tuned, usage, margin_m] = drive_laps_tuned(car, Road(surface), options);
  EXPECT_EQ(tuned.limit, "");
  EXPECT_LT(usage, 1.15);
  EXPECT_GT(usage, 0.75);
  options.speed.grip_usage = std::stod(fmt::format("{:g}", usage));  // as it is printed
  EXPECT_EQ(drive_laps(car, Road(surface), options).lap_s, tuned.lap_s);
  options.speed.grip_usage = usage + 0.1;
  EXPECT_NE(drive_laps(car, Road(surface), options).limit, "");
  EXPECT_GT(drive_laps_tuned(car, Road(surface), {}).grip_usage, 0.74);
}

// Beside the middle of this road holes of 15 cm throw the car at any speed that a driver chooses.
TEST(Lap, WhereNoShareOfTheGripKeepsTheCarItKeepsAwayFromTheEdges) {
  const Vehicle v = racer();
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  crg::Crg edges = stadium();
  const std::size_t columns = edges.grid.columns();
  for (std::size_t i = 0; i < edges.grid.z_m.size(); ++i)
    if (std::abs(edges.grid.v_m[i % columns]) > 1.6 && i / columns % 4 < 2)
      edges.grid.z_m[i] = -0.15f;
  const crg::Surface surface(edges);
  LapOptions options;
  options.record_every = 0;
  const TunedLaps near = drive_laps_tuned(car, Road(surface), options, Margin::as_given);
  EXPECT_NE(near.result.limit, "");
  EXPECT_EQ(near.margin_m, 2.0);
  const TunedLaps tuned = drive_laps_tuned(car, Road(surface), options);
  EXPECT_EQ(tuned.result.limit, "");
  EXPECT_GT(tuned.margin_m, 2.0);
  EXPECT_LE(tuned.margin_m, largest_margin_m(surface));
}

// A gear lower, the engine may not drag the driven wheels until they slide.
TEST(Lap, TheDriverLetsTheClutchSlipWhereTheEngineDragsTheWheels) {
  const Vehicle v = racer();
  const crg::Surface surface(stadium());
  RacingLine line = plan_line(surface);
  StartOptions begin;
  begin.speed_mps = 20;
  const auto clutch = [&](double grip, double kappa) {
    Parameters<double> parameters = v.parameters;
    parameters[Parameter::environment_road_grip] = grip;
    const Car<double> car = make_car(v.files, parameters, v.terms);
    plan_speed(line, car, {});
    const Simulation<double> sim = start(car, Road(surface), begin);
    Detail<double> detail{};
    detail.wheel[3].kappa = kappa;
    Driver driver;
    return drive(driver, line, car, sim.state, detail).clutch_command;
  };
  EXPECT_EQ(clutch(0.4, -0.03), 0.0);
  EXPECT_NEAR(clutch(0.4, -0.054), 0.5, 1e-9);
  EXPECT_EQ(clutch(0.4, -0.3), 1.0);
  EXPECT_EQ(clutch(1.0, -0.3), 0.0);
}

/// So slow that the driver gives all the throttle that there is.
Simulation<double> far_below_the_plan(const Car<double>& car, const crg::Surface& surface) {
  StartOptions slow;
  slow.speed_mps = 15;
  slow.gear = 2;
  return start(car, Road(surface), slow);
}

TEST(Lap, TheDriverLiftsWhenTheTailSlides) {
  const Vehicle v = racer();
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  const crg::Surface surface(stadium());
  RacingLine line = plan_line(surface);
  plan_speed(line, car, {});
  const Simulation<double> sim = far_below_the_plan(car, surface);
  const auto throttle = [&](double rear, double front) {
    Detail<double> detail{};
    for (std::size_t i = 0; i < 4; ++i) detail.wheel[i].tan_alpha = i < 2 ? front : rear;
    Driver driver;
    for (int k = 0; k < 200; ++k) drive(driver, line, car, sim.state, detail);
    return driver.throttle;
  };
  EXPECT_EQ(throttle(0.1, 0.0), 1.0);
  EXPECT_EQ(throttle(0.1, 0.5), 1.0) << "a front that slides is no tail";
  EXPECT_GT(throttle(-0.15, 0.0), 0.3);
  EXPECT_LT(throttle(-0.15, 0.0), 0.9) << "to either side";
  EXPECT_EQ(throttle(0.3, 0.0), 0.0);
}

// A driver is a person: what he does in a second does not depend on the step of the simulation.
TEST(Lap, TheDriversFootIsAsFastWhateverTheStep) {
  const Vehicle v = racer();
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  const crg::Surface surface(stadium());
  RacingLine line = plan_line(surface);
  plan_speed(line, car, {});
  const Simulation<double> sim = far_below_the_plan(car, surface);
  const Detail<double> detail{};
  for (const double step_s : {0.001, 0.0005, 0.004}) {
    Driver driver;
    driver.options.step_s = step_s;
    for (int k = 0; k < static_cast<int>(std::lround(0.04 / step_s)); ++k)
      drive(driver, line, car, sim.state, detail);
    EXPECT_NEAR(driver.throttle, 0.4, 1e-9) << step_s;  // all of it in a tenth of a second
  }
}

double residual(const LapResult& r) {
  return std::abs(r.energy_j.sum() - r.energy_change_j) / r.energy_j.engine;
}

// What all forces did is what the car's energy changed by, as a share of what went through the
// engine; with every term, and without each (measured: 0.0006 %; 0.02 % on g-track-1). What is left
// is the first-order step's and halves with it.
TEST(Lap, KeepsItsEnergyBalance) {
  const Vehicle v = racer();
  const crg::Surface surface(stadium());
  LapOptions options;
  options.record_every = 0;
  double worst = 0.0;
  const auto drive = [&](const Amplitudes<double>& terms) {
    const Car<double> car = make_car(v.files, v.parameters, terms);
    LapResult r = drive_laps(car, Road(surface), options);
    EXPECT_TRUE(r.complete) << r.problem;
    return r;
  };
  const LapResult whole = drive(v.terms);
  support::figure("whole", residual(whole));
  EXPECT_LT(residual(whole), 1e-3);
  for (std::size_t i = 0; i < kTermCount; ++i) {
    Amplitudes<double> terms = v.terms;
    if (terms.value[i] == 0.0) continue;
    if (i % 8 != 0 && std::getenv("KERBSTONE_HEAVY") == nullptr) continue;  // a lap each
    terms.value[i] = 0.0;
    const double share = residual(drive(terms));
    EXPECT_LT(share, 1e-3) << "without " << term_list()[i].name;
    worst = std::max(worst, share);
  }
  support::figure("worst", worst);
  options.step.integrator = Integrator::kExplicitEuler;
  const double explicit_euler = residual(drive(v.terms));
  support::figure("explicit", explicit_euler);
  EXPECT_LT(explicit_euler, 1e-3);
  options.step = {0.0005, Integrator::kSemiImplicit};
  EXPECT_LT(residual(drive(v.terms)), 0.7 * residual(whole));
}

TEST(Lap, TakesTheSameTimeToTheBit) {
  const Vehicle v = racer();
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  const crg::Surface surface(stadium());
  const LapResult a = drive_laps(car, Road(surface)), b = drive_laps(car, Road(surface));
  ASSERT_TRUE(a.complete) << a.problem;
  EXPECT_EQ(a.lap_s, b.lap_s);
  EXPECT_EQ(a.telemetry.columns, b.telemetry.columns);
  EXPECT_NE(a.telemetry.find("yaw_rate_radps"), nullptr);
  EXPECT_NEAR(a.telemetry.columns[0][1] - a.telemetry.columns[0][0], 0.01, 1e-12);
}

// The place in the telemetry goes on along the road where another part of it lies above or below.
TEST(Lap, KnowsItsPlaceUnderABridge) {
  const Vehicle v = racer();
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  const crg::Surface surface(spiral(8.0));
  LapOptions options;
  options.record_every = 1;
  const LapResult r = drive_laps(car, Road(surface), options);
  ASSERT_TRUE(r.complete) << r.problem;
  const std::vector<double>& u_m = *r.telemetry.find("u_m");
  double most = 0.0;
  for (std::size_t i = 1; i < u_m.size(); ++i) most = std::max(most, std::abs(u_m[i] - u_m[i - 1]));
  EXPECT_LT(most, 0.05);  // 30 m/s inside the bend, a millisecond apart
  EXPECT_GT(u_m.back(), 270.0);
}

// An open road: wheels on it from the begin, no faster than the car can be, once.
TEST(Lap, BeginsAndEndsOnAnOpenRoad) {
  const Vehicle v = racer();
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  const crg::Surface surface(straight(600.0, 0.5, [](double, double) { return 0.0; }));
  LapOptions options;
  options.record_every = 1;
  options.step.stop_off_road = true;
  const LapResult r = drive_laps(car, Road(surface), options);
  ASSERT_TRUE(r.complete) << r.problem;
  EXPECT_EQ(r.steps_off_road, 0u);
  // Where drag takes all that the engine gives, the car begins neither faster nor slower on.
  const double begin_mps = r.telemetry.find("vx_mps")->front();
  EXPECT_LT(begin_mps, 90.0);
  EXPECT_NEAR(r.telemetry.find("vx_mps")->back(), begin_mps, 2.0);
  options.speed.begin_mps = 20.0;
  const LapResult slow = drive_laps(car, Road(surface), options);
  ASSERT_TRUE(slow.complete) << slow.problem;
  EXPECT_NEAR(slow.telemetry.find("vx_mps")->front(), 20.0, 0.01);
  options.laps = 2;
  try {
    drive_laps(car, Road(surface), options);
    ADD_FAILURE() << "two laps of an open road were driven";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("2 laps of an open road"));
  }
}

TEST(Lap, NamesThePlaceWithoutRoad) {
  const Vehicle v = racer();
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  EXPECT_THROW(drive_laps(car, Road()), Error);
  crg::Crg road = stadium();
  const std::size_t columns = road.grid.columns();
  for (std::size_t i = 300 * columns; i < 302 * columns; ++i) road.grid.z_m[i] = std::nanf("");
  const crg::Surface surface(std::move(road));
  try {
    const LapResult r = drive_laps(car, Road(surface));
    EXPECT_THAT(r.problem, ::testing::HasSubstr("no road under"));
  } catch (const Error& error) {  // the line already cannot be planned there
    EXPECT_THAT(std::string(error.what()), ::testing::HasSubstr("u = "));
  }
}

TEST(Lap, RefusesOrSaysWhatTheCommandLineCannotMean) {
  const cli::Folder folder;
  const std::string road = folder / "s.crg", grip = folder / "grip.crg";
  crg::write(straight(400.0, 1.0, [](double, double) { return 0.0; }), road, crg::Format::KRBI);
  const auto run = [&](const std::string& arguments) {
    const std::string line = places::crgdrive() + " " + arguments + " --car " + places::source() +
                             "/vehicles/open_wheel/vehicle.yaml > '" + (folder / "said") + "' 2>&1";
    const int status = std::system(line.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  const auto said = [&] { return cli::read(folder / "said"); };
  const std::string lap =
      "lap --speed-mps 20 --road '" + road + "' -o '" + (folder / "lap.csv") + "'";
  // A row every 8 steps of 1.2 ms is what comes nearest to 100 Hz.
  EXPECT_EQ(run(lap + " --step-s 0.0012"), 0) << said();
  EXPECT_THAT(said(), ::testing::HasSubstr("104.167 Hz"));
  EXPECT_EQ(run(lap + " --rate-hz 2000"), 1);
  EXPECT_THAT(said(), ::testing::HasSubstr("at most 1000"));
  EXPECT_EQ(run(lap + " --laps 2"), 1);
  EXPECT_THAT(said(), ::testing::HasSubstr("open road"));
  // Grip factors that cannot be.
  const auto with_grip = [&](double factor, double at_m) {
    crg::write(straight(400.0, 1.0, [&](double u, double) { return u < at_m ? factor : 1.0; }),
               grip, crg::Format::KRBI);
    return run(lap + " --grip '" + grip + "'");
  };
  EXPECT_EQ(with_grip(-0.2, 10.0), 1);
  EXPECT_THAT(said(), ::testing::HasSubstr("grip factor -0.2"));
  EXPECT_EQ(with_grip(5.0, 10.0), 1);
  EXPECT_THAT(said(), ::testing::HasSubstr("wanted 0 to 3"));
  EXPECT_EQ(with_grip(std::nan(""), 10.0), 0) << said();
  EXPECT_THAT(said(), ::testing::HasSubstr("empty; there it is 1"));
  EXPECT_EQ(with_grip(std::nan(""), 1e9), 1);
  // Less grip is felt in a replay too.
  EXPECT_EQ(with_grip(0.7, 1e9), 0) << said();
  const std::string replay = "replay --log '" + (folder / "lap.csv") + "' --road '" + road + "'";
  EXPECT_EQ(run(replay), 0) << said();
  const std::string dry = said();
  EXPECT_EQ(run(replay + " --grip '" + grip + "'"), 0) << said();
  EXPECT_NE(said(), dry);
  EXPECT_EQ(run("timing --stop-s 0.1 --contact strip"), 1);
  EXPECT_THAT(said(), ::testing::HasSubstr("--road"));
}

TEST(Lap, RunsFromTheCommandLine) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("kerbstone_lap_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const auto path = [&](const char* name) { return (folder / name).string(); };
  crg::write(stadium(), path("s.crg"), crg::Format::KRBI);
  const auto run = [&](const std::string& arguments) {
    const std::string line =
        places::crgdrive() + " " + arguments + " >" + path("out.txt") + " 2>" + path("err.txt");
    const int status = std::system(line.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  const auto text = [&](const char* name) {
    std::ifstream in(path(name));
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
  };
  const std::string car = " --car " + places::source() + "/vehicles/open_wheel/vehicle.yaml ";
  ASSERT_EQ(run("lap" + car + "--road " + path("s.crg") + " -o " + path("lap.csv")), 0)
      << text("err.txt");
  EXPECT_THAT(text("out.txt"), ::testing::HasSubstr("lap 1:"));
  EXPECT_THAT(text("lap.csv"), ::testing::HasSubstr("sha256"));
  EXPECT_GT(recording::read_table(path("lap.csv")).rows(), 1000u);
  ASSERT_EQ(run("replay" + car + "--road " + path("s.crg") + " --log " + path("lap.csv") + " -o " +
                path("replayed")),
            0)
      << text("err.txt");
  EXPECT_THAT(text("out.txt"), ::testing::HasSubstr("lateral_m"));
  EXPECT_THAT(text("replayed/errors.csv"), ::testing::HasSubstr("\nvx_mps,"));
  EXPECT_GT(recording::read_table(path("replayed/replay.csv")).rows(), 1000u);
  ASSERT_EQ(run("report " + path("lap.csv") + " " + path("replayed/replay.csv") + " --road " +
                path("s.crg") + " -o " + path("page.html")),
            0)
      << text("err.txt");
  EXPECT_THAT(text("page.html"), ::testing::HasSubstr("Load rear right"));
  EXPECT_EQ(run("replay" + car + "--road " + path("s.crg") + " --log " + path("none.csv")), 1);
  EXPECT_EQ(run("lap" + car + "--road " + path("none.crg")), 1);
  EXPECT_EQ(run("lap" + car + "--road " + path("s.crg") + " --set chassis.mass=1"), 1);
  EXPECT_THAT(text("err.txt"), ::testing::HasSubstr("chassis.mass_kg"));
  EXPECT_EQ(run("lap" + car), 2);
  ASSERT_EQ(run("timing" + car + "--stop-s 0.5 --json --road " + path("s.crg")), 0)
      << text("err.txt");
  EXPECT_THAT(text("out.txt"), ::testing::HasSubstr("\"median_us\""));
  ASSERT_EQ(run("poles" + car + "--speed-mps 20"), 0) << text("err.txt");
  EXPECT_THAT(text("out.txt"), ::testing::HasSubstr("explicit Euler stable up to"));
  ASSERT_EQ(run("parameters"), 0);
  std::filesystem::remove_all(folder);
}

}  // namespace lap_test
