// Torque maps of engines, of cars whose truth is known and of another simulator's recordings.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <tuple>

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

namespace engine_fit_test {

using identify::EngineFit, identify::WeighedOptions, identify::MapPlace;
using P = vehicle::Parameter;

/// An engine that is none of the vehicle file's: up to 20 % off, by speed and by throttle; what the
/// fit takes from the file is off by its prior.
struct Driven {
  vehicle::Vehicle stated =
      vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  vehicle::Car<double> as_stated =
      make_car(stated.files, stated.parameters, stated.terms, stated.contact);
  vehicle::CarFiles files = stated.files;
  vehicle::Parameters<double> truth = stated.parameters;
  recording::Recording recording;
};

/// Ten runs on a plane, each in one gear, with another throttle every second and a half.
test_drive::Drive engine_tests(const vehicle::Car<double>& car, std::uint64_t seed) {
  using namespace vehicle;  // NOLINT: names of one library
  const Road road;
  base::Random dice = base::random_of(seed, "throttle");
  test_drive::Drive out;
  for (const std::string& name : recording::telemetry_channels()) out.telemetry.add(name, {});
  std::vector<double> row(recording::telemetry_channels().size());
  for (int run = 0; run < 10; ++run) {
    StartOptions begin;
    begin.gear = 2 + run % 5;
    begin.speed_mps = 250.0 * car.static_radius_m[1] / overall_ratio(car.parameters, begin.gear);
    begin.y_m = 300.0 * run;  // another place
    Simulation<double> sim = start(car, road, begin);
    Detail<double> detail{};
    double open = 0.5;
    for (std::size_t k = 0; k < 25000; ++k) {
      if (k % 1500 == 0) open = std::clamp(dice.uniform(-0.2, 1.3), 0.0, 1.0);
      if (sim.state[kEngine] > 770.0) open = 0.0;
      if (sim.state[kEngine] < 220.0 && open < 0.3) open = 0.6;
      Controls<double> controls{};
      controls.gear_command = begin.gear;
      controls.throttle_command = open;
      const State<double> before = sim.state;
      const double time_s = sim.time_s + 100.0 * run;
      const StepResult result = step(car, sim, controls, road, StepOptions{}, detail);
      if (!result.ok()) throw std::runtime_error(describe(result, time_s, 0.0, 0.0));
      if (k % 20 != 0 || k < 500) continue;
      fill_telemetry(time_s, before, detail, controls, 0.0, 0.0, row);
      for (std::size_t i = 0; i < row.size(); ++i) out.telemetry.columns[i].push_back(row[i]);
    }
  }
  return out;
}

Driven driven(std::uint64_t seed, const crg::Surface* surface) {
  Driven out;
  base::Random dice = base::random_of(seed, "car");
  vehicle::Map2& map = out.files.engine_torque_nm;
  const double level = 1.0 + dice.uniform(-0.1, 0.1), tilt = dice.uniform(-0.1, 0.1),
               bend = dice.uniform(-0.1, 0.1);
  for (std::size_t i = 0; i < map.x.size(); ++i)
    for (std::size_t j = 0; j < map.y.size(); ++j) {
      const double speed = map.x[i] / map.x.back();
      map.z[i * map.y.size() + j] *=
          level + tilt * (2.0 * speed - 1.0) + bend * (1.0 - map.y[j]) * map.y[j] * 4.0;
    }
  for (const P p : {P::chassis_mass_kg, P::aero_drag_area_m2, P::front_wheel_inertia_kgm2,
                    P::rear_wheel_inertia_kgm2, P::engine_inertia_kgm2, P::gearbox_efficiency})
    out.truth[p] *= 1.0 + 0.5 * out.stated.prior[static_cast<std::size_t>(p)] * dice.normal();
  out.truth[P::gearbox_efficiency] = std::min(1.0, out.truth[P::gearbox_efficiency]);
  const auto car = make_car(out.files, out.truth, out.stated.terms, out.stated.contact);
  const test_drive::Drive drive =
      surface == nullptr ? engine_tests(car, seed)
                         : test_drive::drive_car(car, vehicle::Road(*surface), 20, 1, 100.0);
  out.recording = recording::make_recording(test_drive::logged(drive, true, seed, true), "log");
  return out;
}

struct Score {
  int inside = 0, seen = 0, all = 0;
  double square = 0.0, before = 0.0, largest = 0.0;
};

/// Errors over the torque, or over a quarter of the largest where it is less.
void count(const Driven& d, const EngineFit& fit, Score& s) {
  const vehicle::Map2& is = d.files.engine_torque_nm;
  const double most = *std::max_element(is.z.begin(), is.z.end());
  for (std::size_t k = 0; k < fit.places.size(); ++k) {
    const MapPlace& cell = fit.places[k];
    ++s.all;
    if (!cell.unseen.empty()) continue;
    ++s.seen;
    const double scale = std::max(std::abs(is.z[k]), 0.25 * most);
    const double off = (cell.value - is.z[k]) / scale;
    s.inside += std::abs(cell.value - is.z[k]) < cell.within ? 1 : 0;
    s.square += off * off;
    s.before += std::pow((cell.stated - is.z[k]) / scale, 2.0);
    s.largest = std::max(s.largest, std::abs(off));
  }
}

TEST(EngineFit, TheTruthLiesInItsIntervals) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const crg::Surface surface{identify::proving_road()};
  std::map<std::string, Score> scores;
  for (std::uint64_t seed = 1; seed <= (heavy ? 20u : 2u); ++seed)
    for (const crg::Surface* road : {static_cast<const crg::Surface*>(nullptr), &surface}) {
      const Driven d = driven(seed, road);
      WeighedOptions weighed;
      weighed.mass_kg = d.truth[P::chassis_mass_kg] + 30.0;
      weighed.mass_sd_kg = 1.0;
      for (const bool known : {true, false}) {
        const EngineFit fit = identify::fit_engine(
            d.as_stated, d.stated.prior, identify::drive_windows(d.as_stated, road, d.recording),
            d.recording, known ? weighed : WeighedOptions{});
        EXPECT_THAT(fit.fit.doubts, testing::IsEmpty());
        count(d, fit,
              scores[fmt::format("{}, {}", road == nullptr ? "engine tests" : "one lap",
                                 known ? "weighed" : "stated mass")]);
      }
    }
  int inside = 0, seen = 0;
  for (const auto& [name, s] : scores) {
    const double rms = std::sqrt(s.square / s.seen), before = std::sqrt(s.before / s.seen);
    support::figure(name + " percent", 100.0 * rms);
    support::figure(name + " inside", s.inside), support::figure(name + " seen", s.seen);
    EXPECT_LT(rms, 0.035) << name;
    EXPECT_LT(rms, 0.6 * before) << name;
    EXPECT_LT(s.largest, 0.09) << name;
    if (name.starts_with("engine")) {
      EXPECT_GT(2 * s.seen, s.all) << name;
    }
    inside += s.inside;
    seen += s.seen;
  }
  EXPECT_GE(inside, 0.85 * seen);
}

/// The vehicle file has another ratio of the fourth gear than the car.
EngineFit with_ratio(double factor) {
  const Driven d = driven(3, nullptr);
  vehicle::Vehicle other = d.stated;
  other.parameters[P::gearbox_ratio_4] *= factor;
  const auto car = make_car(other.files, other.parameters, other.terms, other.contact);
  WeighedOptions options;
  options.mass_kg = d.truth[P::chassis_mass_kg] + 30.0;
  options.mass_sd_kg = 1.0;
  return identify::fit_engine(car, other.prior, identify::drive_windows(car, nullptr, d.recording),
                              d.recording, options);
}

// A gear that pulls 2 % more than the file says: 1.6 % above the mean of the five gears.
TEST(EngineFit, AGearThatPullsMoreIsSeen) {
  const EngineFit fit = with_ratio(0.98);
  const identify::Found& f = fit.fit.at("torque_gear_4");
  EXPECT_EQ(f.unseen, "");
  EXPECT_NEAR(f.value, 1.0 + 0.8 * (1.0 / 0.98 - 1.0), f.within);
  EXPECT_GT(f.value, 1.006);
  EXPECT_NE(fit.fit.at("torque_gear_1").unseen, "");
}

TEST(EngineFit, AWrongRatioIsLeftOut) {
  const EngineFit fit = with_ratio(0.95);
  EXPECT_NE(fit.fit.at("torque_gear_4").unseen, "");
  EXPECT_THAT(fit.fit.remarks,
              testing::Contains(testing::ContainsRegex("[1-9][0-9]+ with engine")));
  EXPECT_NO_THROW(vehicle::check_map(fit.map(), "engine map"));
}

// Beyond its prior, and with it the torques beyond their intervals.
TEST(EngineFit, AWrongDragAreaOrEngineInertiaIsSaid) {
  const Driven d = driven(3, nullptr);
  for (const auto& [parameter, factor, words] :
       {std::tuple{P::aero_drag_area_m2, 1.6, "drag area"},
        std::tuple{P::engine_inertia_kgm2, 3.0, "engine inertia"}}) {
    vehicle::Vehicle other = d.stated;
    other.parameters[parameter] *= factor;
    const auto car = make_car(other.files, other.parameters, other.terms, other.contact);
    WeighedOptions options;
    options.mass_kg = d.truth[P::chassis_mass_kg] + 30.0;
    options.mass_sd_kg = 1.0;
    const EngineFit fit = identify::fit_engine(
        car, other.prior, identify::drive_windows(car, nullptr, d.recording), d.recording, options);
    EXPECT_THAT(fit.fit.doubts, testing::Contains(testing::HasSubstr(words)));
  }
}

TEST(EngineFit, UnvisitedPlacesAreEmpty) {
  Driven d = driven(1, nullptr);
  recording::Table lazy;
  const auto& open = *d.recording.table.find("throttle");
  for (std::size_t c = 0; c < d.recording.table.names.size(); ++c) {
    std::vector<double> kept;
    for (std::size_t k = 0; k < open.size(); ++k)
      if (open[k] < 0.6) kept.push_back(d.recording.table.columns[c][k]);
    lazy.add(d.recording.table.names[c], std::move(kept));
  }
  const auto recording = recording::make_recording(lazy, "log");
  const EngineFit fit =
      identify::fit_engine(d.as_stated, d.stated.prior,
                           identify::drive_windows(d.as_stated, nullptr, recording), recording);
  std::size_t seen = 0;
  for (const MapPlace& cell : fit.places) {
    if (cell.y > 0.8) {
      EXPECT_NE(cell.unseen, "");
    }
    seen += cell.unseen.empty() ? 1 : 0;
  }
  EXPECT_GT(seen, 10u);
}

// The stated engine is made 12 % too weak at low speeds and 12 % too strong at high ones.
TEST(EngineFit, AnotherSimulatorsCar) {
  const std::string folder = places::data() + "/ocd_trials";
  if (!std::filesystem::exists(folder + "/truth.json"))
    GTEST_SKIP() << "no recordings of Open-Car-Dynamics here";
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const auto truth =
      base::parse_json<nlohmann::json>(base::read_file(folder + "/truth.json", 1u << 24));
  Score all;
  for (const auto& trial : truth.at("trials")) {
    const std::string id = trial.at("id");
    if (heavy ? id > "t10" : id != "t01" && id != "t05") continue;  // t11 on: other cars
    SCOPED_TRACE(id);
    const auto& factors = trial.at("parameter_factors");
    Driven d;
    const support::RecordedCar c = support::stated_car(folder, factors);
    d.files = c.files;
    vehicle::CarFiles wrong = c.files;
    for (std::size_t i = 0; i < wrong.engine_torque_nm.x.size(); ++i)
      for (std::size_t j = 0; j < 2; ++j)
        wrong.engine_torque_nm.z[2 * i + j] *= 0.88 + 0.24 * static_cast<double>(i) / 14.0;
    const auto car = make_car(wrong, c.parameters, c.terms);
    const auto recording = support::recorded_log(folder + "/" + id + ".csv.xz");
    identify::DriveWindowsOptions windows;
    windows.body_axes = false;
    WeighedOptions options;
    options.body_axes = false;
    options.mass_kg = 760.0 * factors.at("mass").get<double>();
    options.mass_sd_kg = 2.0;
    const EngineFit fit = identify::fit_engine(
        car, support::default_priors(), identify::drive_windows(car, nullptr, recording, windows),
        recording, options);
    // The same with a file that does not state the arm: its word is in the intervals.
    vehicle::CarFiles silent = c.files;
    silent.fx_arm = vehicle::FxArm::kUnstated;
    const auto silent_car = make_car(silent, c.parameters, c.terms);
    const EngineFit wider = identify::fit_engine(
        silent_car, support::default_priors(),
        identify::drive_windows(silent_car, nullptr, recording, windows), recording, options);
    const identify::Found& factor = wider.fit.at("torque");
    EXPECT_LT(std::abs(factor.value - 1.0), factor.within);
    EXPECT_LT(factor.within, 0.06);
    EXPECT_THAT(wider.fit.remarks, testing::Contains(testing::HasSubstr("does not state fx_arm")));
    // The truth at the places of the fit, whose throttle axis is finer.
    vehicle::Map2 is{fit.x, fit.y, {}};
    for (const double speed : is.x)
      for (const double open : is.y)
        is.z.push_back(vehicle::evaluate(c.files.engine_torque_nm, speed, open));
    d.files.engine_torque_nm = is;
    Score one;
    count(d, fit, one);
    if (heavy)
      fmt::print("{} {} of {} inside, of {}; rms {:.2f} % (stated {:.2f} %), largest {:.2f} %\n",
                 id, one.inside, one.seen, one.all, 100.0 * std::sqrt(one.square / one.seen),
                 100.0 * std::sqrt(one.before / one.seen), 100.0 * one.largest);
    count(d, fit, all);
  }
  EXPECT_GE(all.inside, 0.8 * all.seen);
  EXPECT_LT(std::sqrt(all.square / all.seen), 0.035);
  EXPECT_LT(std::sqrt(all.square), 0.5 * std::sqrt(all.before));
}

TEST(EngineFit, WhatIsMissingIsSaid) {
  const Driven d = driven(1, nullptr);
  recording::Table bare;
  for (std::size_t c = 0; c < d.recording.table.names.size(); ++c)
    if (d.recording.table.names[c] != "throttle")
      bare.add(d.recording.table.names[c], d.recording.table.columns[c]);
  const auto recording = recording::make_recording(bare, "log");
  const auto windows = identify::drive_windows(d.as_stated, nullptr, recording);
  EXPECT_THROW(identify::fit_engine(d.as_stated, d.stated.prior, windows, recording), base::Error);
}

TEST(EngineFit, AMapOfFarTooManyPlacesIsRefused) {
  Driven d = driven(1, nullptr);
  vehicle::Map2& map = d.stated.files.engine_torque_nm;
  map = {{}, {0.0, 0.25, 0.5, 1.0}, {}};
  for (int k = 0; k < 251; ++k) map.x.push_back(4.0 * k);
  map.z.assign(map.x.size() * map.y.size(), 100.0);
  const auto car = make_car(d.stated.files, d.stated.parameters, d.stated.terms, d.stated.contact);
  const auto windows = identify::drive_windows(car, nullptr, d.recording);
  try {
    identify::fit_engine(car, d.stated.prior, windows, d.recording);
    FAIL() << "no error";
  } catch (const base::Error& error) {
    EXPECT_NE(std::string(error.what()).find("251 by 5 places, at most 1000"), std::string::npos)
        << error.what();
  }
}

}  // namespace engine_fit_test
