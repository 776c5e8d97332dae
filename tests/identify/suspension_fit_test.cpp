// Springs and anti-roll bars from loads and travels, of cars whose truth is known.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "base/error.h"
#include "base/statistics.h"
#include "identify/drive_fits.h"
#include "identify/proving_road.h"
#include "recorded_drive.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/recorded_car.h"
#include "vehicle/vehicle_file.h"

namespace suspension_fit_test {

using identify::DriveFit, identify::Found;
using P = vehicle::Parameter;

struct Driven {
  vehicle::Vehicle stated =
      vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  vehicle::Parameters<double> truth = stated.parameters;
  vehicle::Car<double> car, as_stated;
  recording::Recording recording;
};

Driven driven(std::uint64_t seed, const crg::Surface& surface) {
  Driven out;
  base::Random dice = base::random_of(seed, "car");
  for (const P p :
       {P::front_spring_npm, P::rear_spring_npm, P::front_anti_roll_npm, P::rear_anti_roll_npm})
    out.truth[p] *= 1.0 + dice.uniform(-0.15, 0.15);
  for (const P p : {P::front_roll_centre_m, P::rear_roll_centre_m})
    out.truth[p] += 0.01 * dice.normal();
  for (const P p : {P::front_camber_gain_radpm, P::rear_camber_gain_radpm})
    out.truth[p] *= 1.0 + 0.5 * out.stated.prior[static_cast<std::size_t>(p)] * dice.normal();
  out.car = make_car(out.stated.files, out.truth, out.stated.terms, out.stated.contact);
  out.as_stated =
      make_car(out.stated.files, out.stated.parameters, out.stated.terms, out.stated.contact);
  const test_drive::Drive drive =
      test_drive::drive_car(out.car, vehicle::Road(surface), 20, 1, 100.0);
  recording::Table log = test_drive::logged(drive, true, seed, true);
  for (auto& column : log.columns) column.erase(column.begin(), column.begin() + 75);
  out.recording = recording::make_recording(log, "log");
  return out;
}

// 40 drives (KERBSTONE_HEAVY), measured: 79 of 80 spring rates inside, root mean square errors 1.9
// and 1.7 %. The links of this car carry so much of the side force that its bars are not seen.
TEST(SuspensionFit, TheTruthLiesInItsIntervals) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const crg::Surface surface{identify::proving_road()};
  struct Score {
    int inside = 0, seen = 0, all = 0;
    double square = 0.0, largest = 0.0;  ///< the former of shares, the latter in N/m
  };
  std::map<std::string, Score> scores;
  for (std::uint64_t seed = 1; seed <= (heavy ? 40u : 5u); ++seed) {
    const Driven d = driven(seed, surface);
    const DriveFit fit = identify::fit_suspension(
        d.as_stated, d.stated.prior, identify::drive_windows(d.as_stated, &surface, d.recording),
        750.0);
    EXPECT_TRUE(fit.doubts.empty());
    for (const std::string axle : {"front", "rear"})
      for (const std::string what : {"_spring_npm", "_anti_roll_npm"}) {
        const Found& f = fit.at(axle + what);
        const double is = d.truth[*vehicle::find_parameter(axle + "." + what.substr(1))];
        Score& s = scores[axle + what];
        ++s.all;
        if (!f.unseen.empty()) continue;
        ++s.seen;
        s.inside += std::abs(f.value - is) < f.within ? 1 : 0;
        s.square += std::pow(f.value / is - 1.0, 2.0);
        s.largest = std::max(s.largest, std::abs(f.value - is));
      }
  }
  int inside = 0, seen = 0;
  for (const auto& [name, s] : scores) {
    support::figure(name + "_percent", 100.0 * std::sqrt(s.square / std::max(1, s.seen)));
    support::figure(name + "_inside", s.inside), support::figure(name + "_of", s.all);
    if (name.ends_with("spring_npm")) {
      EXPECT_EQ(s.seen, s.all) << name;
      EXPECT_LT(s.largest, 7000.0) << name;
    } else {
      EXPECT_EQ(s.seen, 0) << name;
    }
    inside += s.inside;
    seen += s.seen;
  }
  EXPECT_GE(inside, 0.8 * seen);
}

// Measured: front springs 0.2 to 0.4 %, rear ones 0.9 to 1.2 % off; bars 200 to 800 N/m.
TEST(SuspensionFit, AnotherSimulatorsCar) {
  const std::string folder = places::data() + "/ocd_trials";
  const std::vector<nlohmann::json> trials = support::trials_of(folder);
  if (trials.empty()) GTEST_SKIP() << "no recordings of Open-Car-Dynamics here";
  for (const auto& trial : trials) {
    const std::string id = trial.at("id");
    if (id != "t01" && id != "t19") continue;  // the two with travels
    SCOPED_TRACE(id);
    const support::RecordedCar c = support::stated_car(folder, trial.at("parameter_factors"));
    const auto car = make_car(c.files, c.parameters, c.terms);
    const auto prior = support::default_priors();
    identify::DriveWindowsOptions windows;
    windows.body_axes = false;
    const DriveFit fit = identify::fit_suspension(
        car, prior,
        identify::drive_windows(car, nullptr, support::recorded_log(folder + "/" + id + ".csv.xz"),
                                windows),
        760.0 * trial.at("parameter_factors").at("mass").get<double>());
    EXPECT_TRUE(fit.doubts.empty());
    const std::map<std::string, std::pair<double, double>> is{
        {"front_spring_npm", {160000.0, 1600.0}},
        {"rear_spring_npm", {140000.0, 2500.0}},
        {"front_anti_roll_npm", {55000.0, 1500.0}},
        {"rear_anti_roll_npm", {5000.0, 1500.0}}};
    for (const auto& [name, value] : is) {
      const Found& f = fit.at(name);
      EXPECT_EQ(f.unseen, "") << name;
      EXPECT_NEAR(f.value, value.first, value.second) << name;
      EXPECT_LT(std::abs(f.value - value.first), f.within) << name;
    }
  }
}

TEST(SuspensionFit, WhatTheDriveDoesNotShow) {
  const crg::Surface surface{identify::proving_road()};
  const Driven d = driven(1, surface);
  const auto w = identify::drive_windows(d.as_stated, &surface, d.recording);
  const auto fit = [&](const identify::DriveWindows& windows) {
    return identify::fit_suspension(d.as_stated, d.stated.prior, windows, 750.0);
  };
  auto turned = w;
  for (auto& one : turned.windows)
    for (double& z : one.travel_m) z = -z;
  EXPECT_THAT(fit(turned).doubts, testing::Contains(testing::HasSubstr("sign of the travels")));
  auto stiff = w;  // travels that hardly move
  for (auto& one : stiff.windows)
    for (double& z : one.travel_m) z = 0.002 + 0.05 * z;
  const DriveFit none = fit(stiff);
  EXPECT_THAT(none.at("front_spring_npm").unseen, testing::HasSubstr("wanted 2"));
  EXPECT_THAT(none.at("rear_anti_roll_npm").unseen, testing::HasSubstr("wanted 2"));
  EXPECT_THAT(identify::suspension_sheet(none),
              testing::HasSubstr("# front.spring_npm not observable"));
  auto unlogged = w;
  unlogged.travels = false;
  try {
    fit(unlogged);
    FAIL();
  } catch (const base::Error& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("travels"));
  }
}

}  // namespace suspension_fit_test
