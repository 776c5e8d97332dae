// The drag area from coast-downs and from open throttle, against cars whose truth is known, and
// another simulator's recordings.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "base/error.h"
#include "base/json_text.h"
#include "base/read_file.h"
#include "identify/drive_fits.h"
#include "identify/proving_road.h"
#include "recorded_drive.h"
#include "recording/channels.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/recorded_car.h"
#include "vehicle/vehicle_file.h"

namespace aero_fit_test {

using identify::AeroFitOptions, identify::DriveFit, identify::DriveWindows, identify::Found;
using P = vehicle::Parameter;

/// From 72 m/s in neutral to `until_mps`, on a plane.
test_drive::Drive coast_down(const vehicle::Car<double>& car, double until_mps) {
  using namespace vehicle;  // NOLINT: names of one library
  const Road road;
  StartOptions begin;
  begin.speed_mps = 72.0;
  begin.gear = 0;
  Simulation<double> sim = start(car, road, begin);
  Detail<double> detail{};
  test_drive::Drive out;
  for (const std::string& name : recording::telemetry_channels()) out.telemetry.add(name, {});
  std::vector<double> row(recording::telemetry_channels().size());
  for (std::size_t k = 0; sim.state[kVx] > until_mps && k < 200000; ++k) {
    Controls<double> controls{};
    controls.gear_command = 0;
    const State<double> before = sim.state;
    const double time_s = sim.time_s;
    const StepResult result = step(car, sim, controls, road, StepOptions{}, detail);
    if (!result.ok()) throw std::runtime_error(describe(result, time_s, 0.0, 0.0));
    if (k % 20 != 0 || k < 1500) continue;
    fill_telemetry(time_s, before, detail, controls, 0.0, 0.0, row);
    for (std::size_t i = 0; i < row.size(); ++i) out.telemetry.columns[i].push_back(row[i]);
  }
  return out;
}

struct Stated {
  vehicle::Vehicle vehicle =
      vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  vehicle::Car<double> car =
      make_car(vehicle.files, vehicle.parameters, vehicle.terms, vehicle.contact);

  DriveFit fit(const recording::Table& log, const crg::Surface* road,
               const AeroFitOptions& options = {}) const {
    return identify::fit_aero(
        car, vehicle.prior,
        identify::drive_windows(car, road, recording::make_recording(log, "log")), options);
  }
};

/// A car whose drag is unknown, and what the fit takes from the file off by its prior.
vehicle::Parameters<double> unlike(const vehicle::Vehicle& v, std::uint64_t seed) {
  base::Random dice = base::random_of(seed, "car");
  auto truth = v.parameters;
  truth[P::aero_drag_area_m2] *= 1.0 + dice.uniform(-0.1, 0.1);
  truth[P::engine_torque] *= 1.0 + dice.uniform(-0.05, 0.05);
  for (const P p : {P::chassis_mass_kg, P::front_wheel_inertia_kgm2, P::rear_wheel_inertia_kgm2,
                    P::engine_inertia_kgm2, P::front_ride_height_m, P::rear_ride_height_m})
    truth[p] *= 1.0 + 0.5 * v.prior[static_cast<std::size_t>(p)] * dice.normal();
  return truth;
}

/// A log without the channels that begin so.
recording::Table without(const recording::Table& log, const std::vector<std::string>& beginnings) {
  recording::Table out;
  for (std::size_t c = 0; c < log.names.size(); ++c)
    if (std::none_of(beginnings.begin(), beginnings.end(),
                     [&](const std::string& b) { return log.names[c].starts_with(b); }))
      out.add(log.names[c], log.columns[c]);
  return out;
}

// 40 cars (KERBSTONE_HEAVY), measured: 131 of 138 inside; root mean square errors 2.3 % with the
// stated mass, 0.7 % with a known one, 1.3 % without loads, 1.4 % at open throttle (18 of 40 drives
// of 45 s have enough of it).
TEST(AeroFit, TheTruthLiesInItsIntervals) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const crg::Surface surface{identify::proving_road()};
  const Stated stated;
  struct Score {
    int inside = 0, seen = 0, all = 0;
    double square = 0.0, largest = 0.0;
  };
  std::map<std::string, Score> scores;
  for (std::uint64_t seed = 1; seed <= (heavy ? 40u : 5u); ++seed) {
    const auto truth = unlike(stated.vehicle, seed);
    const auto car =
        make_car(stated.vehicle.files, truth, stated.vehicle.terms, stated.vehicle.contact);
    const double is = truth[P::aero_drag_area_m2];
    const auto look = [&](const std::string& name, const DriveFit& fit) {
      const Found& f = fit.at("drag_area_m2");
      Score& s = scores[name];
      ++s.all;
      if (!f.unseen.empty()) return;
      ++s.seen;
      s.inside += std::abs(f.value - is) < f.within ? 1 : 0;
      s.square += std::pow(f.value / is - 1.0, 2.0);
      s.largest = std::max(s.largest, std::abs(f.value / is - 1.0));
    };
    AeroFitOptions weighed;
    weighed.mass_kg = truth[P::chassis_mass_kg] + 30.0;
    weighed.mass_sd_kg = 1.0;
    const auto coast = test_drive::logged(coast_down(car, 15.0), true, seed, true);
    const auto bare = without(coast, {"fz_", "suspension_"});
    look("coast-down, stated mass", stated.fit(coast, nullptr));
    look("coast-down, weighed", stated.fit(coast, nullptr, weighed));
    look("coast-down, weighed, no loads", stated.fit(bare, nullptr, weighed));
    const auto lap = test_drive::logged(
        test_drive::drive_car(car, vehicle::Road(surface), 20, 1, 100.0), true, seed, true);
    look("open throttle, weighed", stated.fit(lap, &surface, weighed));
  }
  int inside = 0, seen = 0;
  for (const auto& [name, s] : scores) {
    support::figure(name + " percent", 100.0 * std::sqrt(s.square / std::max(1, s.seen)));
    support::figure(name + " inside", s.inside), support::figure(name + " seen", s.seen);
    EXPECT_TRUE(s.seen == s.all || name.starts_with("open")) << name;
    EXPECT_LT(s.largest, name.find("stated") != std::string::npos ? 0.09 : 0.06) << name;
    inside += s.inside;
    seen += s.seen;
  }
  EXPECT_GE(inside, 0.8 * seen);
  if (heavy) {
    EXPECT_LE(inside, 0.98 * seen);
  }
}

TEST(AeroFit, AStretchWithoutEngineCanBeStated) {
  const Stated stated;
  const auto log = without(test_drive::logged(coast_down(stated.car, 25.0), true, 3), {"gear"});
  AeroFitOptions options;
  const DriveFit none = stated.fit(log, nullptr, options);
  EXPECT_THAT(none.at("drag_area_m2").unseen, testing::HasSubstr("no coast-down"));
  EXPECT_THAT(identify::aero_sheet(none),
              testing::StartsWith("# aero.drag_area_m2 not observable: no coast-down"));
  options.engine_off_s = {{3.0, 40.0}};
  const DriveFit fit = stated.fit(log, nullptr, options);
  EXPECT_EQ(fit.at("drag_area_m2").unseen, "");
  EXPECT_NEAR(fit.at("drag_area_m2").value, 0.95, 0.03);
  EXPECT_THAT(identify::aero_sheet(fit), testing::StartsWith("aero.drag_area_m2 = 0.9"));
}

TEST(AeroFit, ASlowCoastDownSaysNothing) {
  const Stated stated;
  auto drive = coast_down(stated.car, 12.0);
  const auto& v = *drive.telemetry.find("vx_mps");
  const auto slow = std::find_if(v.begin(), v.end(), [](double x) { return x < 18.0; }) - v.begin();
  for (auto& column : drive.telemetry.columns) column.erase(column.begin(), column.begin() + slow);
  const DriveFit fit = stated.fit(test_drive::logged(drive, true, 3), nullptr);
  EXPECT_THAT(fit.at("drag_area_m2").unseen, testing::HasSubstr("wanted"));
}

// Measured: all 19 within 1.2 % of the truth and inside their intervals. t08 has no wheel speeds.
TEST(AeroFit, AnotherSimulatorsCarAtOpenThrottle) {
  const std::string folder = places::data() + "/ocd_trials";
  if (!std::filesystem::exists(folder + "/truth.json"))
    GTEST_SKIP() << "no recordings of Open-Car-Dynamics here";
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const auto truth =
      base::parse_json<nlohmann::json>(base::read_file(folder + "/truth.json", 1u << 24));
  int inside = 0, all = 0;
  for (const auto& trial : truth.at("trials")) {
    const std::string id = trial.at("id");
    const auto& factors = trial.at("parameter_factors");
    if (!heavy && id != "t01" && id != "t05" && id != "t08" && id != "t20") continue;
    const support::RecordedCar c = support::stated_car(folder, factors);
    const auto car = make_car(c.files, c.parameters, c.terms);
    const auto prior = support::default_priors();
    identify::DriveWindowsOptions windows;
    windows.body_axes = false;
    AeroFitOptions options;
    options.body_axes = false;
    options.mass_kg = 760.0 * factors.at("mass").get<double>() * (id == "t19" ? 1.1 : 1.0);
    options.mass_sd_kg = 2.0;
    const auto drive = identify::drive_windows(
        car, nullptr, support::recorded_log(folder + "/" + id + ".csv.xz"), windows);
    const DriveFit fit = identify::fit_aero(car, prior, drive, options);
    const Found& f = fit.at("drag_area_m2");
    const double is = 0.9 * factors.at("drag").get<double>();
    if (heavy)
      fmt::print("{} {:.4f} within {:.4f}, is {:.4f} {}\n", id, f.value, f.within, is, f.unseen);
    if (id == "t08") {
      EXPECT_THAT(f.unseen, testing::HasSubstr("no speeds of the driven wheels"));
      continue;
    }
    EXPECT_EQ(f.unseen, "") << id;
    EXPECT_NEAR(f.value, is, 0.02) << id;
    inside += std::abs(f.value - is) < f.within ? 1 : 0;
    ++all;
    support::RecordedCar silent = c;
    silent.files.fx_arm = vehicle::FxArm::kUnstated;
    const auto silent_car = make_car(silent.files, silent.parameters, silent.terms);
    const DriveFit wider = identify::fit_aero(silent_car, prior, drive, options);
    const auto of_file = [](const Found& is) { return is.sd * is.sd - is.sd_drive * is.sd_drive; };
    EXPECT_GT(of_file(wider.at("drag_area_m2")), 1.2 * of_file(f)) << id;
    EXPECT_LT(std::abs(wider.at("drag_area_m2").value - is), wider.at("drag_area_m2").within) << id;
    EXPECT_THAT(wider.remarks, testing::Contains(testing::HasSubstr("does not state fx_arm")));
  }
  EXPECT_GE(inside, 0.8 * all);
}

}  // namespace aero_fit_test
