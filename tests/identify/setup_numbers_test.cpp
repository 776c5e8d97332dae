// Every number of a setup sheet from another simulator's recordings, by vehicle files that do not
// state the arm of longitudinal forces and are off as their priors say.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/random.h"
#include "base/statistics.h"
#include "identify/drive_fits.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/recorded_car.h"

namespace setup_numbers_test {

using identify::DriveFit, identify::Found;

struct Numbers {
  int inside = 0, all = 0;
  std::vector<double> share;  ///< half-width over the truth

  void count(const std::string& id, const DriveFit& fit, const std::string& name, double is) {
    const Found& f = fit.at(name);
    fmt::print("{} {} {:.4f} within {:.4f}, is {:.4f} {}\n", id, name, f.value, f.within, is,
               f.unseen);
    if (!f.unseen.empty() || !fit.doubts.empty()) return;
    inside += std::abs(f.value - is) < f.within ? 1 : 0, ++all;
    share.push_back(f.within / std::abs(is));
  }
};

/// Whether an effect of the trial acts on a number that is asked for.
bool acts(const nlohmann::json& trial, const std::string& on) {
  for (const auto& effect : trial.at("effects"))
    if (effect.at("mechanism").get<std::string>().find(on) != std::string::npos) return true;
  return false;
}

/// The stated car, off by its priors in what the fits take from it, and its log with an offset.
struct Stated {
  support::RecordedCar its;
  vehicle::Car<double> car;
  recording::Recording log;

  Stated(const std::string& folder, const nlohmann::json& trial, std::uint64_t seed)
      : its(support::stated_car(folder, trial.at("parameter_factors"))) {
    const std::string id = trial.at("id");
    base::Random dice = base::random_of(seed, id);
    its.files.fx_arm = vehicle::FxArm::kUnstated;
    const auto prior = support::default_priors();
    using P = vehicle::Parameter;
    for (const P p : {P::chassis_wheelbase_m, P::aero_drag_height_m, P::front_wheel_inertia_kgm2,
                      P::rear_wheel_inertia_kgm2, P::front_spring_npm, P::rear_spring_npm,
                      P::engine_inertia_kgm2, P::aero_drag_area_m2})
      its.parameters[p] *= 1.0 + 0.5 * prior[static_cast<std::size_t>(p)] * dice.normal();
    const double rolls = 1.0 + 0.15 * dice.normal();
    for (auto& tyre : its.files.tyre) tyre.qsy1 *= rolls, tyre.qsy2 *= rolls;
    car = make_car(its.files, its.parameters, its.terms);
    log = support::recorded_log(folder + "/" + id + ".csv.xz");
    const double offset = 0.05 * dice.normal();
    for (std::size_t c = 0; c < log.table.names.size(); ++c)
      if (log.table.names[c] == "ax_mps2")
        for (double& v : log.table.columns[c]) v += offset;
  }
};

// Measured: 92 to 94 % in six draws; 96 % where the stated drag was exact, since intervals of
// engine and brakes hold its prior.
TEST(SlowSetupNumbers, AreInTheirIntervalsWhereTheArmIsUnknown) {
  const std::string folder = places::data() + "/ocd_trials";
  const std::vector<nlohmann::json> trials = support::trials_of(folder);
  if (trials.empty()) GTEST_SKIP() << "no recordings of Open-Car-Dynamics here";
  Numbers numbers;
  for (std::uint64_t k = 0; k < 3 * trials.size(); ++k) {
    const auto& trial = trials[k / 3];
    const std::string id = trial.at("id");
    const auto& factors = trial.at("parameter_factors");
    const auto factor = [&](const char* name) { return factors.at(name).get<double>(); };
    const Stated stated(folder, trial, k + 1000);
    const vehicle::Car<double>& car = stated.car;
    const recording::Recording& log = stated.log;
    const auto prior = support::default_priors();
    identify::DriveWindowsOptions cut;
    cut.body_axes = false;
    const identify::DriveWindows drive = identify::drive_windows(car, nullptr, log, cut);
    identify::AeroFitOptions options;
    options.body_axes = false;
    options.fuel_kg = 0.0;
    if (drive.loads) {
      const DriveFit mass = identify::fit_mass(car, prior, drive, options).or_throw();
      const double kg = 760.0 * factor("mass") * (id == "t19" ? 1.1 : 1.0) -
                        (id == "t18" ? 0.016 * 0.5 * drive.end_s : 0.0);
      numbers.count(id, mass, "mass_kg", kg);
      numbers.count(id, mass, "cog_behind_front_m", 1.6 * factor("cog"));
      numbers.count(id, mass, "cog_height_m", 0.28);
      numbers.count(id, mass, "front_lift_area_m2", 0.95);
      numbers.count(id, mass, "rear_lift_area_m2", 1.45);
      options.mass_kg = mass.at("mass_kg").value;
      options.mass_sd_kg = mass.at("mass_kg").sd;
    } else {
      options.mass_sd_kg = 3.8;  // as a scale says it
      options.mass_kg =
          760.0 * factor("mass") + options.mass_sd_kg * base::random_of(k, "scale").normal();
    }
    if (!acts(trial, "turbo"))
      numbers.count(id, identify::fit_engine(car, prior, drive, log, options).fit, "torque", 1.0);
    if (!acts(trial, "brake_friction"))
      numbers.count(id, identify::fit_brakes(car, prior, drive, options), "torque", 1.0);
    numbers.count(id, identify::fit_aero(car, prior, drive, options), "drag_area_m2",
                  0.9 * factor("drag"));
  }
  const double half = base::median(numbers.share);
  fmt::print("{} of {} inside, median half-width {:.3f}\n", numbers.inside, numbers.all, half);
  support::figure("inside", numbers.inside), support::figure("of", numbers.all);
  support::figure("half_width_percent", 100.0 * half);
  EXPECT_GE(numbers.inside, 0.85 * numbers.all);
  EXPECT_LE(numbers.inside, 0.95 * numbers.all);
  EXPECT_LE(half, 0.06);
}

}  // namespace setup_numbers_test
