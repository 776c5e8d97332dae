// From data sheets to cars: what the files say, and what the cars do beside published figures.
#include "vehicle/new_car.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "base/write_file.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "test_roads.h"
#include "vehicle/lap.h"
#include "vehicle/straight_run.h"
#include "vehicle/vehicle_file.h"

namespace new_car_test {

using namespace vehicle;  // NOLINT: a test of this library
using ::testing::HasSubstr;
namespace fs = std::filesystem;

std::string sheet_path(const std::string& name) {
  return places::source() + "/vehicles/sheets/" + name + ".yaml";
}

/// A car of its sheet, through its files.
struct Made {
  cli::Folder folder;
  DataSheet sheet;
  Vehicle vehicle;

  explicit Made(const std::string& name) : sheet(read_data_sheet(sheet_path(name))) {
    for (const auto& [file, text] : make_new_car(sheet).files)
      base::write_file(folder / file, text);
    vehicle = read_vehicle(folder / "vehicle.yaml");
  }
  Car<double> car() const {
    return make_car(vehicle.files, vehicle.parameters, vehicle.terms, vehicle.contact);
  }
};

double planned_s(const crg::Surface& surface, const Car<double>& car, const LapOptions& options) {
  RacingLine line = plan_line(surface, options.line);
  SpeedOptions speed = options.speed;
  speed.tyre_k = options.tyre_k;
  speed.fuel_kg = options.fuel_kg;
  plan_speed(line, car, speed);
  double sum = 0.0;
  for (std::size_t i = 0, n = line.s_m.size(); i < n; ++i)
    sum += ((i + 1 < n ? line.s_m[i + 1] : line.length_m) - line.s_m[i]) /
           (0.5 * (line.speed_mps[i] + line.speed_mps[(i + 1) % n]));
  return sum;
}

/// Drives a lap; nothing where it went as planned, else a sentence.
std::string lap_fault(const crg::Surface& surface, const Car<double>& car, LapOptions options) {
  options.record_every = 0;
  options.fuel_kg = 5.0;
  const auto [lap, grip_usage, margin_m] = drive_laps_tuned(car, Road(surface), options);
  options.speed.grip_usage = grip_usage, options.line.margin_m = margin_m;
  if (!lap.complete) return lap.problem + "; " + lap.limit;
  if (lap.steps_off_road > 0) return fmt::format("{} steps off; {}", lap.steps_off_road, lap.limit);
  const double plan_s = planned_s(surface, car, options);
  if (std::abs(lap.lap_s[0] - plan_s) > 0.05 * plan_s)
    return fmt::format("{:.2f} s, planned {:.2f} s; {}", lap.lap_s[0], plan_s, lap.limit);
  return "";
}

/// What the car does over what is published; NaN where nothing is.
std::array<double, 2> over_published(const Made& made) {
  const StraightRun run = run_straight(made.car());
  EXPECT_EQ(run.problem, "") << made.sheet.name;
  const auto& s = made.sheet;
  const double top = s.top_speed_kmh ? 3.6 * run.top_mps / *s.top_speed_kmh : NAN;
  const double to_100 = s.to_100_kmh_s ? run.to_100_kmh_s / *s.to_100_kmh_s : NAN;
  fmt::print("{}: {:.0f} km/h ({:+.0f} %), {:.2f} s to 100 km/h ({:+.0f} %)\n", s.name,
             3.6 * run.top_mps, 100 * (top - 1), run.to_100_kmh_s, 100 * (to_100 - 1));
  return {top, to_100};
}

TEST(NewCar, MarksWhatIsGuessedWithItsPriorItsRangeAndWhy) {
  const Made made("gr86");
  const std::string text = cli::read(made.folder / "vehicle.yaml");
  const auto index = [](Parameter p) { return static_cast<std::size_t>(p); };
  const Vehicle& v = made.vehicle;
  EXPECT_EQ(v.parameters[Parameter::chassis_mass_kg], 1345.0);
  EXPECT_FALSE(v.assumed[index(Parameter::chassis_mass_kg)]);
  EXPECT_NEAR(v.parameters[Parameter::chassis_cog_behind_front_m], 0.47 * 2.575, 1e-3);
  EXPECT_TRUE(v.assumed[index(Parameter::front_spring_npm)]);
  EXPECT_EQ(v.prior[index(Parameter::chassis_yaw_inertia_kgm2)], 0.15);
  EXPECT_EQ(v.parameters[Parameter::gearbox_ratio_6], 0.767);
  std::size_t guessed = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.find("assumed: true") == std::string::npos) continue;
    ++guessed;
    EXPECT_THAT(line, ::testing::ContainsRegex("}  # -?[0-9.e+-]+ to -?[0-9.e+-]+: .+"));
    EXPECT_THAT(line, HasSubstr("prior: "));
  }
  EXPECT_EQ(guessed, make_new_car(made.sheet).guessed);
  EXPECT_GT(guessed, 40u);
}

// The tyre is the reference's: the same coefficients where it is scaled to it.
TEST(NewCar, ScalesTheReferenceTyre) {
  const Made made("gr86");
  const TyreCoefficients reference =
      read_tyre(places::source() + "/vehicles/open_wheel/front.tir").coefficients;
  const TyreCoefficients& t = made.vehicle.files.tyre[0];
  EXPECT_NEAR(t.unloaded_radius_m, 0.3146, 1e-4);
  EXPECT_EQ(t.pcy1, reference.pcy1);
  EXPECT_EQ(t.rby1, reference.rby1);
  EXPECT_NEAR(t.pdx1 / t.pdy1, reference.pdx1 / reference.pdy1, 1e-6);
  // The grip that is stated or guessed holds at the load of the standing car.
  const Car<double> car = made.car();
  const TyreForces<double> f = tyre_forces(
      t, TyreInput<double>{car.static_load_n[0], 0, 0, 0, 30, 0}, {}, {.moments = false});
  EXPECT_NEAR(f.mu_y, 1.05, 0.002);
  EXPECT_THAT(cli::read(made.folder / "front.tir"),
              HasSubstr("the front tyre of vehicles/open_whe"));
}

TEST(NewCar, KeepsOtherNumbersThanTheSheetsWithinTheirBounds) {
  // Light and heavy, narrow and wide: the file is read again, so nothing lies outside its bounds.
  for (const char* name : {"kart_kz", "bentley_mulsanne", "formula_1", "formula_student"})
    EXPECT_NO_THROW(Made{name}) << name;
}

// Two cars, through their files: published figures, and a lap as planned.
TEST(NewCar, DrivesAsPublishedAndAsPlanned) {
  const crg::Surface surface(stadium());
  for (const char* name : {"porsche_911_1964", "formula_student"}) {
    const Made made(name);
    const auto [top, to_100] = over_published(made);
    EXPECT_NEAR(top, 1.0, 0.1) << name;
    EXPECT_NEAR(to_100, 1.0, 0.1) << name;
    EXPECT_EQ(lap_fault(surface, made.car(), {}), "") << name;
  }
}

// The kart's rear axle is locked, its wheels are 1 m apart: he knows what that takes from the turn.
// Of two cars with the same grip the one that the air presses behind alone is planned slower in
// bends.
TEST(NewCar, BendsArePlannedByTheAxleThatGivesWay) {
  const crg::Surface surface(stadium());
  const Made kart("kart_kz");
  EXPECT_EQ(lap_fault(surface, kart.car(), {}), "");
  const auto slowest_mps = [&](const Made& made, Parameters<double> p, Amplitudes<double> terms) {
    RacingLine line = plan_line(surface);
    plan_speed(line, make_car(made.vehicle.files, p, terms, made.vehicle.contact), {});
    return *std::min_element(line.speed_mps.begin(), line.speed_mps.end());
  };
  Amplitudes<double> open = kart.vehicle.terms;
  open[Term::locked_differential] = 0.0;
  EXPECT_LT(slowest_mps(kart, kart.vehicle.parameters, kart.vehicle.terms),
            0.97 * slowest_mps(kart, kart.vehicle.parameters, open));
  const Made racer("av21");
  Parameters<double> p = racer.vehicle.parameters;
  p[Parameter::rear_lift_area_m2] = 9.0;
  p[Parameter::front_lift_area_m2] = 0.0;
  Parameters<double> balanced = p;
  balanced[Parameter::front_lift_area_m2] = 0.42 * p[Parameter::rear_lift_area_m2];
  balanced[Parameter::rear_lift_area_m2] *= 0.58;
  EXPECT_LT(slowest_mps(racer, p, racer.vehicle.terms),
            0.97 * slowest_mps(racer, balanced, racer.vehicle.terms));
}

std::vector<std::string> all_sheets() {
  std::vector<std::string> out;
  for (const auto& file : fs::directory_iterator(places::source() + "/vehicles/sheets"))
    out.push_back(file.path().stem().string());
  std::sort(out.begin(), out.end());
  return out;
}

TEST(SlowNewCars, TopSpeedAndTimeToHundredAreThePublishedOnes) {
  std::size_t cars = 0, tops = 0, times = 0;
  for (const std::string& name : all_sheets()) {
    const Made made(name);
    // A figure that the drag was found from would test nothing.
    EXPECT_TRUE(made.sheet.drag_area_m2) << name;
    const auto [top, to_100] = over_published(made);
    ++cars;
    tops += std::abs(top - 1.0) < 0.1 ? 1 : 0;
    times += std::abs(to_100 - 1.0) < 0.1 ? 1 : 0;
  }
  EXPECT_EQ(cars, 10u);
  EXPECT_GE(tops, 8u);
  EXPECT_GE(times, 8u);
}

/// The road, built by crgbuild; nothing where its mesh is not installed.
std::optional<crg::Surface> build_road(const std::string& name, const cli::Folder& folder) {
  std::vector<std::string> arguments{
      "build", fmt::format("{}/tracks/{}/track.yaml", places::source(), name)};
  if (name == "kerbstone-ring") {
    const std::string circuit = fmt::format("{}/tracks/{}/circuit.yaml", places::source(), name);
    EXPECT_EQ(cli::crgbuild({"synth", circuit, "-o", folder.path()}).code, 0);
    arguments = {"build", folder / "kerbstone-ring.obj", "--start-at", "0,0"};
  } else if (!cli::exists(fmt::format("{0}/road/{1}/{1}.acc", places::torcs_tracks(), name))) {
    return {};
  }
  arguments.insert(arguments.end(), {"--no-report", "-o", folder.path()});
  const cli::Ran ran = cli::crgbuild(arguments);
  EXPECT_EQ(ran.code, 0) << ran.err;
  return crg::Surface(crg::read(folder / (name + ".crg")));
}

class SlowNewCarsOn : public ::testing::TestWithParam<const char*> {};

// Kerbs and the edges of facets throw the kart, whose travel is short: it takes less of the grip,
// and on g-track-1 the larger margin.
TEST_P(SlowNewCarsOn, DriveALapAsPlanned) {
  const cli::Folder folder;
  const std::optional<crg::Surface> surface = build_road(GetParam(), folder);
  if (!surface) GTEST_SKIP() << "the package torcs-data is not installed";
  for (const std::string& name : all_sheets()) {
    EXPECT_EQ(lap_fault(*surface, Made(name).car(), {}), "") << name;
  }
}

INSTANTIATE_TEST_SUITE_P(, SlowNewCarsOn,
                         ::testing::Values("kerbstone-ring", "aalborg", "e-track-3", "g-track-1"),
                         [](const auto& track) {
                           std::string name = track.param;
                           for (char& c : name)
                             if (c == '-') c = '_';
                           return name;
                         });

}  // namespace new_car_test
