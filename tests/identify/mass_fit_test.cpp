// Mass, its place and lift from wheel loads: cars whose truth is known, driven and logged with
// noise, and another simulator's recordings.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "base/error.h"
#include "base/statistics.h"
#include "base/write_file.h"
#include "identify/drive_fits.h"
#include "identify/proving_road.h"
#include "recorded_drive.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/recorded_car.h"
#include "vehicle/vehicle_file.h"

namespace mass_fit_test {

using identify::DriveFit, identify::DriveWindows, identify::Found;
using recording::Recording;
using P = vehicle::Parameter;

vehicle::Vehicle racer() {
  return vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
}

/// One car that is not quite the stated one, and its drive.
struct Driven {
  vehicle::Vehicle stated = racer();
  vehicle::Parameters<double> truth = stated.parameters;
  vehicle::Car<double> car;
  Recording recording;
};

/// Everything that the fit looks for is off by up to 8 %; what it takes from the vehicle file, by
/// its prior.
Driven driven(std::uint64_t seed, const crg::Surface& surface) {
  Driven out;
  base::Random dice = base::random_of(seed, "car");
  const auto off = [&](P p, double share) { out.truth[p] *= 1.0 + dice.uniform(-share, share); };
  for (const P p :
       {P::chassis_mass_kg, P::chassis_cog_height_m, P::front_lift_area_m2, P::rear_lift_area_m2})
    off(p, 0.08);
  off(P::chassis_cog_behind_front_m, 0.03);
  for (const P p : {P::aero_drag_area_m2, P::aero_drag_height_m, P::front_wheel_inertia_kgm2,
                    P::rear_wheel_inertia_kgm2, P::front_spring_npm, P::rear_spring_npm,
                    P::front_ride_height_m, P::rear_ride_height_m})
    out.truth[p] *= 1.0 + 0.5 * out.stated.prior[static_cast<std::size_t>(p)] * dice.normal();
  out.car = make_car(out.stated.files, out.truth, out.stated.terms, out.stated.contact);
  const test_drive::Drive drive =
      test_drive::drive_car(out.car, vehicle::Road(surface), 20, 1, 100.0);
  recording::Table log = test_drive::logged(drive, true, seed, true);
  log.add("fuel_kg", *drive.telemetry.find("fuel_kg"));
  for (auto& column : log.columns)  // the simulated car settles on its springs at first
    column.erase(column.begin(), column.begin() + 75);
  out.recording = recording::make_recording(log, "log");
  return out;
}

vehicle::Car<double> stated_car(const vehicle::Vehicle& v) {
  return make_car(v.files, v.parameters, v.terms, v.contact);
}

/// What the numbers ought to be: with the fuel that was on board.
std::map<std::string, double> truth_of(const Driven& d, double fuel_kg) {
  const auto& p = d.truth;
  const double dry = p[P::chassis_mass_kg], all = dry + fuel_kg;
  return {
      {"mass_kg", all},
      {"cog_behind_front_m",
       (dry * p[P::chassis_cog_behind_front_m] + fuel_kg * p[P::fuel_tank_behind_front_m]) / all},
      {"cog_height_m",
       (dry * p[P::chassis_cog_height_m] + fuel_kg * p[P::fuel_tank_height_m]) / all},
      {"front_lift_area_m2", p[P::front_lift_area_m2]},
      {"rear_lift_area_m2", p[P::rear_lift_area_m2]}};
}

/// The same drive as others would have it: a wheelbase off by its prior, and loads that lack, or
/// have too much of, the wheels' moments.
Driven by_others(Driven d, std::uint64_t seed) {
  base::Random dice = base::random_of(seed, "others");
  constexpr P kLength = P::chassis_wheelbase_m;
  d.stated.parameters[kLength] *=
      1.0 + 0.5 * d.stated.prior[static_cast<std::size_t>(kLength)] * dice.normal();
  double wheels_kg_m = 0.0;
  for (std::size_t a = 0; a < 2; ++a)
    wheels_kg_m += 2.0 * d.truth.axle(a, P::front_wheel_inertia_kgm2) / d.car.static_radius_m[a];
  const double lacks = 0.8 * dice.normal() * wheels_kg_m / d.truth[kLength];
  recording::Table& table = d.recording.table;
  const std::vector<double> along = *table.find("ax_mps2");
  for (std::size_t c = 0; c < table.names.size(); ++c)
    if (table.names[c].starts_with("fz_"))
      for (std::size_t k = 0; k < along.size(); ++k)
        table.columns[c][k] += (table.names[c][3] == 'f' ? 0.5 : -0.5) * lacks * along[k];
  return d;
}

struct Score {
  int inside = 0, all = 0;
  double square = 0.0, largest = 0.0;  ///< of the error as a share of the truth
  void add(const Found& f, double is) {
    ++all;
    inside += std::abs(f.value - is) < f.within ? 1 : 0;
    square += (f.value / is - 1.0) * (f.value / is - 1.0);
    largest = std::max(largest, std::abs(f.value / is - 1.0));
  }
};

TEST(MassFit, AWrongWheelbaseIsSaidAndWidensWhatGoesWithIt) {
  const crg::Surface surface{identify::proving_road()};
  const Driven d = driven(1, surface);
  vehicle::Vehicle other = d.stated;
  other.parameters[P::chassis_wheelbase_m] *= 1.15;
  const auto car = stated_car(other);
  identify::WeighedOptions options;
  options.fuel_kg = base::median(*d.recording.table.find("fuel_kg"));
  const double height_m = truth_of(d, options.fuel_kg).at("cog_height_m");
  DriveWindows w = identify::drive_windows(car, &surface, d.recording);
  w.wheelbase_m = w.wheelbase_sd_m = NAN;  // as where no steering was recorded
  EXPECT_THAT(identify::fit_mass(car, other.prior, w, options).or_throw().remarks,
              testing::Contains(testing::HasSubstr("in proportion to the wheelbase of 3.45 m")));
  w.wheelbase_m = d.truth[P::chassis_wheelbase_m];
  w.wheelbase_sd_m = 0.02;
  const DriveFit fit = identify::fit_mass(car, other.prior, w, options).or_throw();
  EXPECT_THAT(fit.remarks, testing::Contains(testing::HasSubstr("say a wheelbase of 3.00 m")));
  EXPECT_NE(fit.at("cog_behind_front_m").unseen, "");
  EXPECT_LT(std::abs(fit.at("cog_height_m").value - height_m), fit.at("cog_height_m").within);
}

// 40 drives of 45 s (KERBSTONE_HEAVY), measured: 375 of 400 numbers inside; with the stated
// wheelbase and whole loads root mean square errors of 0.14 % of the mass, 1.8 mm of the place, 1.7
// mm of the height, 0.015 m2 of each lift area.
TEST(MassFit, TheTruthLiesInItsIntervals) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const crg::Surface surface{identify::proving_road()};
  std::map<std::string, Score> scores;
  int inside = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= (heavy ? 40u : 6u); ++seed) {
    const Driven d = driven(seed, surface);
    const auto stated = stated_car(d.stated);
    identify::WeighedOptions options;
    options.fuel_kg = base::median(*d.recording.table.find("fuel_kg"));
    const Driven others = by_others(d, seed);
    const auto other_car = stated_car(others.stated);
    for (const bool with_road : {true, false}) {
      const auto fitted = [&](const vehicle::Car<double>& car, const Recording& recording) {
        const DriveWindows w =
            identify::drive_windows(car, with_road ? &surface : nullptr, recording);
        return identify::fit_mass(car, d.stated.prior, w, options).or_throw();
      };
      const DriveFit fit = fitted(stated, d.recording), other = fitted(other_car, others.recording);
      EXPECT_TRUE(fit.doubts.empty());
      for (const auto& [name, is] : truth_of(d, options.fuel_kg)) {
        EXPECT_EQ(fit.at(name).unseen + other.at(name).unseen, "") << name;
        scores[name].add(fit.at(name), is);
        inside += std::abs(other.at(name).value - is) < other.at(name).within ? 1 : 0, ++all;
      }
    }
  }
  const std::map<std::string, double> most{{"mass_kg", 0.006},
                                           {"cog_behind_front_m", 0.004},
                                           {"cog_height_m", 0.025},
                                           {"front_lift_area_m2", 0.05},
                                           {"rear_lift_area_m2", 0.04}};
  for (const auto& [name, s] : scores) {
    support::figure(name + "_percent", 100.0 * std::sqrt(s.square / s.all));
    support::figure(name + "_inside", s.inside);
    support::figure(name + "_of", s.all);
    EXPECT_LT(s.largest, most.at(name)) << name;
    EXPECT_GE(s.inside, 0.8 * s.all) << name;
  }
  support::figure("inside", inside), support::figure("of", all);
  EXPECT_GE(inside, 0.8 * all);
  if (heavy) {
    EXPECT_LE(inside, 0.97 * all);
  }
}

/// Another simulator's recording and its stated car. There, lever arms are those of the standing
/// car, and wheels act on the body by their forces alone (vehicle_dynamics_equations.cpp of
/// Open-Car-Dynamics): neither sinking nor the wheels' moments.
struct Other {
  support::RecordedCar stated;
  vehicle::Car<double> car;
  DriveWindows windows;
  std::array<double, vehicle::kParameterCount> prior{};
};

Other other(const std::string& folder, const nlohmann::json& trial) {
  Other out{support::stated_car(folder, trial.at("parameter_factors")), {}, {}, {}};
  for (const auto term : {vehicle::Term::gyroscopic, vehicle::Term::wheel_reaction,
                          vehicle::Term::rolling_resistance})
    out.stated.terms[term] = 0.0;
  out.car = make_car(out.stated.files, out.stated.parameters, out.stated.terms);
  out.prior = support::default_priors();
  identify::DriveWindowsOptions options;
  options.body_axes = false;
  const std::string id = trial.at("id");
  out.windows = identify::drive_windows(
      out.car, nullptr, support::recorded_log(folder + "/" + id + ".csv.xz"), options);
  for (auto& w : out.windows.windows) w.sink_m = {};
  return out;
}

// Measured: masses 0.02 to 0.06 % off; places 0.0 to 0.3 mm; heights 0.3 to 0.9 mm; lift areas up
// to 0.007 m2; fuel burnt 0.0154 kg/s where 0.016 is true.
TEST(MassFit, LoadsOfAnotherSimulator) {
  const std::string folder = places::data() + "/ocd_trials";
  const std::vector<nlohmann::json> trials = support::trials_of(folder);
  if (trials.empty()) GTEST_SKIP() << "no recordings of Open-Car-Dynamics here";
  int inside = 0, all = 0;
  for (const auto& trial : trials) {
    const std::string id = trial.at("id");
    if (id != "t01" && id != "t06" && id != "t18" && id != "t19") continue;
    SCOPED_TRACE(id);
    const Other o = other(folder, trial);
    identify::WeighedOptions options;
    options.fuel_kg = 0.0;
    options.body_axes = false;
    const DriveFit fit = identify::fit_mass(o.car, o.prior, o.windows, options).or_throw();
    EXPECT_TRUE(fit.doubts.empty());
    const auto& factors = trial.at("parameter_factors");
    const double rate = id == "t18" ? -0.016 : 0.0, half_s = 0.5 * o.windows.end_s;
    const double mass =
        760.0 * factors.at("mass").get<double>() * (id == "t19" ? 1.1 : 1.0) + rate * half_s;
    const std::map<std::string, std::pair<double, double>> is{
        {"mass_kg", {mass, 0.7}},
        {"mass_rate_kgps", {rate, 0.003}},
        {"cog_behind_front_m", {1.6 * factors.at("cog").get<double>(), 0.002}},
        {"cog_height_m", {0.28, 0.003}},
        {"front_lift_area_m2", {0.95, 0.015}},
        {"rear_lift_area_m2", {1.45, 0.015}}};
    for (const auto& [name, value] : is) {
      const Found& f = fit.at(name);
      if (name == "mass_kg")
        support::figure_of_case("mass_percent", 100.0 * std::abs(f.value / value.first - 1.0));
      if (name == "cog_height_m")
        support::figure_of_case("height_mm", 1e3 * std::abs(f.value - value.first));
      inside += std::abs(f.value - value.first) < f.within ? 1 : 0, ++all;
      EXPECT_EQ(f.unseen, "") << name;
      EXPECT_NEAR(f.value, value.first, value.second) << name;
    }
  }
  support::figure("inside", inside), support::figure("of", all);
}

// The same loads with a car that has all of it: its intervals hold what such loads lack.
TEST(MassFit, LoadsOfASimplerSimulatorAreInTheIntervals) {
  const std::string folder = places::data() + "/ocd_trials";
  const std::vector<nlohmann::json> trials = support::trials_of(folder);
  if (trials.empty()) GTEST_SKIP() << "no recordings of Open-Car-Dynamics here";
  for (const auto& trial : trials) {
    const std::string id = trial.at("id");
    if (id != "t01" && id != "t06" && id != "t19") continue;
    SCOPED_TRACE(id);
    const auto& factors = trial.at("parameter_factors");
    const support::RecordedCar stated = support::stated_car(folder, factors);
    const auto car = make_car(stated.files, stated.parameters, stated.terms);
    identify::WeighedOptions options;
    options.fuel_kg = 0.0;
    const DriveFit fit =
        identify::fit_mass(car, support::default_priors(),
                           identify::drive_windows(
                               car, nullptr, support::recorded_log(folder + "/" + id + ".csv.xz")),
                           options)
            .or_throw();
    const Found &place = fit.at("cog_behind_front_m"), &height = fit.at("cog_height_m");
    EXPECT_LT(std::abs(place.value - 1.6 * factors.at("cog").get<double>()), place.within);
    EXPECT_LT(std::abs(height.value - 0.28), height.within);
    EXPECT_LT(height.within, 0.12 * 0.28);
    EXPECT_THAT(fit.remarks, testing::Contains(testing::HasSubstr("lack the wheels' moments")));
  }
}

class MassFitOneDrive : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    surface_ = new crg::Surface(identify::proving_road());
    driven_ = new Driven(driven(1, *surface_));
  }
  static void TearDownTestSuite() {
    delete driven_;
    delete surface_;
  }
  vehicle::Car<double> car_ = stated_car(driven_->stated);
  DriveWindows windows(const recording::Table& log) const {
    return identify::drive_windows(car_, nullptr, recording::make_recording(log, "log"));
  }
  DriveFit fit(const DriveWindows& w) const {
    return identify::fit_mass(car_, driven_->stated.prior, w).or_throw();
  }
  static inline crg::Surface* surface_ = nullptr;
  static inline Driven* driven_ = nullptr;
};

// Channels that do not belong to each other, or not to the car: nothing of the drive may be used.
TEST_F(MassFitOneDrive, ChannelsThatDoNotBelongTogetherAreSaid) {
  const recording::Table& log = driven_->recording.table;
  EXPECT_EQ(windows(log).doubts, std::vector<std::string>{});
  EXPECT_EQ(fit(windows(log)).doubts, std::vector<std::string>{});
  const auto scaled = [&](const std::string& begin, double by) {
    recording::Table out = log;
    for (std::size_t c = 0; c < out.names.size(); ++c)
      if (out.names[c].starts_with(begin))
        for (double& value : out.columns[c]) value *= by;
    return windows(out);
  };
  const auto doubted = [](const char* what) { return testing::Contains(testing::HasSubstr(what)); };
  EXPECT_THAT(scaled("suspension_", -1.0).doubts, doubted("compressed is positive"));
  EXPECT_THAT(scaled("ax_", 1.0 / 9.80665).doubts, doubted("times the change of vx_mps"));
  EXPECT_THAT(scaled("ax_", -1.0).doubts, doubted("times the change of vx_mps"));
  EXPECT_THAT(scaled("vx_", 1.08).doubts, doubted("rolling radius +"));
  EXPECT_THAT(fit(scaled("fz_", 1.0 / 9.80665)).doubts, doubted("the loads weigh"));
  EXPECT_THAT(fit(scaled("fz_", 1.25)).doubts, doubted("the loads weigh"));
}

TEST_F(MassFitOneDrive, AtOneSpeedWeightAndDownforceLookTheSame) {
  DriveWindows w = identify::drive_windows(car_, surface_, driven_->recording);
  std::erase_if(w.windows, [](const auto& v) { return std::abs(v.vx_mps - 44.0) > 2.4; });
  const auto again = w.windows;  // two laps
  w.windows.insert(w.windows.end(), again.begin(), again.end());
  const DriveFit f = fit(w);
  for (const char* name : {"mass_kg", "front_lift_area_m2", "rear_lift_area_m2"})
    EXPECT_THAT(f.at(name).unseen, testing::HasSubstr("weight and downforce look the same"));
  const std::string sheet = identify::mass_sheet(car_, f, 30.0);
  EXPECT_THAT(sheet, testing::HasSubstr("# chassis.mass_kg not observable: the speed varies by"));
  EXPECT_THAT(sheet, testing::Not(testing::HasSubstr("mass_kg =")));
  EXPECT_THAT(sheet, testing::Not(testing::HasSubstr("lift_area_m2 =")));
}

TEST_F(MassFitOneDrive, WithoutBrakingThereIsNoHeight) {
  DriveWindows w = identify::drive_windows(car_, surface_, driven_->recording);
  std::erase_if(w.windows, [](const auto& v) { return std::abs(v.along_mps2 - 4.0) > 1.2; });
  const DriveFit f = fit(w);
  EXPECT_NE(f.at("cog_height_m").unseen, "");
  EXPECT_THAT(identify::mass_sheet(car_, f, 30.0),
              testing::HasSubstr("# chassis.cog_height_m not observable"));
}

TEST_F(MassFitOneDrive, ATiltedAccelerometerIsNamed) {
  recording::Table log = driven_->recording.table;
  const double tilt = 3.0 / 57.29577951308232;
  const auto column = [&](const char* name) -> std::vector<double>& {
    return log.columns[static_cast<std::size_t>(
        std::find(log.names.begin(), log.names.end(), name) - log.names.begin())];
  };
  for (std::size_t k = 0; k < log.rows(); ++k) {
    double &x = column("ax_mps2")[k], &z = column("az_mps2")[k];
    const double ahead = std::cos(tilt) * x + std::sin(tilt) * z;
    z = std::cos(tilt) * z - std::sin(tilt) * x;
    x = ahead;
  }
  const DriveFit f = fit(windows(log));
  EXPECT_THAT(f.remarks, testing::Contains(testing::HasSubstr("seems to be tilted by")));
  EXPECT_THAT(fit(windows(driven_->recording.table)).remarks,
              testing::Not(testing::Contains(testing::HasSubstr("seems to be tilted by"))));
}

TEST_F(MassFitOneDrive, LoadsThatDoNotBelongToTheAccelerationAreNotUsed) {
  recording::Table turned = driven_->recording.table, late = turned;
  for (std::size_t c = 0; c < turned.names.size(); ++c) {
    if (turned.names[c] == "ax_mps2")
      for (double& v : turned.columns[c]) v = -v;
    if (late.names[c].starts_with("fz_"))
      std::rotate(late.columns[c].begin(), late.columns[c].begin() + 100, late.columns[c].end());
  }
  EXPECT_THAT(fit(windows(turned)).doubts,
              testing::Contains(testing::HasSubstr("sign of ax_mps2")));
  EXPECT_THAT(fit(windows(late)).doubts, testing::Contains(testing::HasSubstr("clock")));
}

TEST_F(MassFitOneDrive, WithoutLoadsNothingIsSaid) {
  recording::Table log;
  for (std::size_t c = 0; c < driven_->recording.table.names.size(); ++c)
    if (!driven_->recording.table.names[c].starts_with("fz_"))
      log.add(driven_->recording.table.names[c], driven_->recording.table.columns[c]);
  try {
    fit(windows(log));
    FAIL();
  } catch (const base::Error& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("no wheel loads"));
  }
}

TEST_F(MassFitOneDrive, TheSheetIsTheCarWithoutItsFuel) {
  const DriveFit f = fit(identify::drive_windows(car_, surface_, driven_->recording));
  vehicle::Vehicle v = racer();
  const std::string path =
      (std::filesystem::temp_directory_path() / fmt::format("mass_sheet_{}.txt", ::getpid()))
          .string();
  base::write_file(path, identify::mass_sheet(car_, f, 30.0));
  vehicle::read_setup(v, path);
  std::filesystem::remove(path);
  EXPECT_NEAR(v.parameters[P::chassis_mass_kg], driven_->truth[P::chassis_mass_kg], 4.0);
  // How well the mass was found goes with it: a prior is two deviations.
  const auto mass = static_cast<std::size_t>(P::chassis_mass_kg);
  EXPECT_NEAR(v.prior[mass], 2.0 * f.at("mass_kg").sd / f.at("mass_kg").value, 1e-4);
  EXPECT_LT(v.prior[mass], 0.5 * racer().prior[mass]);
  EXPECT_NEAR(v.parameters[P::chassis_cog_height_m], driven_->truth[P::chassis_cog_height_m],
              0.006);
  EXPECT_NEAR(v.parameters[P::chassis_cog_behind_front_m],
              driven_->truth[P::chassis_cog_behind_front_m], 0.006);
}

}  // namespace mass_fit_test
