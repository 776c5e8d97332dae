// Tyres from the forces of drives: made-up tables whose tyre is known, and another simulator's car.
#include "identify/drive_tyres.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "base/error.h"
#include "base/random.h"
#include "base/read_file.h"
#include "identify/forces.h"
#include "identify/forces_files.h"
#include "identify/tyre_conditions.h"
#include "identify/tyre_fit.h"
#include "support/places.h"
#include "support/recorded_car.h"
#include "vehicle/tyre_file.h"

namespace {

using identify::DriveTyres, identify::TyreFit;

vehicle::TyreCoefficients tyre_of(const char* name) {
  return vehicle::read_tyre(places::source() + "/vehicles/open_wheel/" + name).coefficients;
}

/// A table as forces_table makes it, of one axle on these tyres; a hundredth of the rows on a kerb.
vehicle::Table made_up(const vehicle::TyreCoefficients& tyre) {
  vehicle::Table out;
  base::Random dice = base::random_of(1, "rows");
  std::map<std::string, std::vector<double>> c;
  for (int k = 0; k < 1000; ++k) {
    c["time_s"].push_back(0.05 * k);
    const double turn = std::sin(0.05 * k), push = std::sin(0.171 * k);
    for (const bool left : {true, false}) {
      const std::string w = left ? "rl" : "rr";
      const bool kerb = k % 250 == 7;
      const double fz = (2800.0 + (left ? -1000.0 : 1000.0) * turn) * (kerb ? 3.0 : 1.0);
      const double camber = (left ? 0.02 : -0.02) + 0.01 * turn + (kerb ? 0.4 : 0.0);
      const double alpha = 0.11 * turn, kappa = 0.06 * push * push * push;
      vehicle::TyreOptions law{.moments = false};
      law.mirrored = left != tyre.left_side;
      const vehicle::TyreInput<double> at{fz, kappa, std::tan(alpha), camber, 40.0, 0.0};
      const auto f = vehicle::tyre_forces(tyre, at, {}, law);
      const double noise = kerb ? 400.0 : 25.0;
      const auto add = [&](const std::string& name, double v) { c[name].push_back(v); };
      add("fx_" + w + "_n", f.fx_n + noise * dice.normal());
      add("fy_" + w + "_n", f.fy_n + noise * dice.normal());
      add("fx_" + w + "_sd_n", noise);
      add("fy_" + w + "_sd_n", noise);
      add("fz_" + w + "_n", fz);
      add("kappa_" + w, kappa);
      add("alpha_" + w + "_rad", alpha);
      add("camber_" + w + "_rad", camber);
      add("wheel_vx_" + w + "_mps", 40.0);
      add("tyre_" + w + "_k", 350.0);
    }
  }
  for (auto& [name, column] : c) out.add(name, column);
  return out;
}

TEST(DriveTyres, BothWheelsTellOfOneTyre) {
  const auto truth = tyre_of("rear.tir"), reference = tyre_of("front.tir");
  DriveTyres rows;
  identify::add_drive_tyres(rows, made_up(truth), 1, reference.left_side, "made up");
  EXPECT_GT(rows.fit.left_out, 5u);
  EXPECT_NEAR(static_cast<double>(rows.held_out.rows()) / static_cast<double>(rows.fit.rows()),
              1.0 / 3.0, 0.02);
  for (const auto& condition : rows.fit.conditions) EXPECT_LT(condition.fz_n, 4000.0);
  identify::TyreFitOptions options;
  options.starts = 2;
  const TyreFit fit = identify::fit_tyre(rows.fit, reference, options);
  const auto mine = identify::held_out(fit.tyre, rows.held_out, options.alpha),
             true_one = identify::held_out(truth, rows.held_out, options.alpha),
             other = identify::held_out(reference, rows.held_out, options.alpha);
  EXPECT_LT(mine.fy_left_n, 1.2 * true_one.fy_left_n);
  EXPECT_LT(mine.fx_left_n, 1.2 * true_one.fx_left_n);
  EXPECT_GT(other.fy_left_n, 3.0 * true_one.fy_left_n);
}

TEST(DriveTyres, OtherTablesAreRefused) {
  DriveTyres rows;
  vehicle::Table log;
  log.add("time_s", {0.0, 1.0});
  log.add("vx_mps", {1.0, 1.0});
  try {
    identify::add_drive_tyres(rows, log, 0, true, "log.csv");
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("log.csv: no column '"));
  }
}

/// The first seconds of a recording.
vehicle::Recording begin_of(const vehicle::Recording& log, double longest_s) {
  const std::vector<double>& time = *log.table.find("time_s");
  const auto rows =
      std::upper_bound(time.begin(), time.end(), time.front() + longest_s) - time.begin();
  vehicle::Table out;
  for (std::size_t c = 0; c < log.table.names.size(); ++c) {
    const std::vector<double>& column = log.table.columns[c];
    out.add(log.table.names[c], {column.begin(), column.begin() + rows});
  }
  return vehicle::make_recording(out, "begin");
}

// Another simulator's car, whose grip and cornering stiffness are off what its owners state.
TEST(DriveTyres, AnotherSimulatorsCar) {
  const std::string folder = places::data() + "/ocd_trials";
  if (!std::filesystem::exists(folder + "/truth.json"))
    GTEST_SKIP() << "no recordings of Open-Car-Dynamics here";
  if (std::getenv("KERBSTONE_HEAVY") == nullptr)
    GTEST_SKIP() << "minutes; KERBSTONE_HEAVY=1 runs it";
  const auto truth = nlohmann::json::parse(base::read_file(folder + "/truth.json", 1u << 24));
  for (const auto& trial : truth.at("trials")) {
    const std::string id = trial.at("id");
    if (id != "t01") continue;
    SCOPED_TRACE(id);
    const auto& factors = trial.at("parameter_factors");
    auto own = factors;  // masses are known; tyres as stated
    own["grip"] = own["cornering_stiffness"] = 1.0;
    support::RecordedCar c = support::recorded_car(folder, own);
    c.terms[vehicle::Term::gyroscopic] = c.terms[vehicle::Term::wheel_reaction] = 0.0;
    const auto car = make_car(c.files, c.parameters, c.terms);
    identify::ForcesOptions options;
    options.fuel_kg = 0.0;
    options.noise_rounds = 2;
    const auto log = begin_of(support::recorded_log(folder + "/" + id + ".csv.xz"), 90.0);
    const auto table =
        identify::forces_table(identify::estimate_forces(car, vehicle::Road(), log, options));
    const vehicle::TyreCoefficients& stated = c.files.tyre[0];
    const vehicle::TyreFactors<double> is{
        .grip_x = factors.at("grip").get<double>(),
        .grip_y = factors.at("grip").get<double>(),
        .stiffness_y = factors.at("cornering_stiffness").get<double>()};
    for (const std::size_t axle : {0u, 1u}) {
      DriveTyres rows;
      identify::add_drive_tyres(rows, table, axle, stated.left_side, id);
      identify::TyreFitOptions fitting;
      fitting.starts = 2;
      const TyreFit fit = identify::fit_tyre(rows.fit, stated, fitting);
      const auto conditions = identify::tyre_conditions(fit, rows.fit);
      const double middle = 0.5 * (conditions.measured.fz_low_n + conditions.measured.fz_high_n);
      const vehicle::TyreInput<double> rolling{middle, 0.0, 0.0, 0.0, 50.0, 0.0};
      const auto stiffness = [&](const vehicle::TyreCoefficients& t,
                                 const vehicle::TyreFactors<double>& f) {
        return vehicle::tyre_forces(t, rolling, f, {.moments = false}).cornering_stiffness_npr;
      };
      fmt::print("{} axle {}: stiffness {:.3f} of the truth, stated {:.3f}\n", id, axle,
                 stiffness(fit.tyre, {}) / stiffness(stated, is),
                 stiffness(stated, {}) / stiffness(stated, is));
      // Measured: 1.000 and 0.951, at loads that the rear hardly sees.
      EXPECT_NEAR(stiffness(fit.tyre, {}) / stiffness(stated, is), 1.0, 0.05);
      const auto mine = identify::held_out(fit.tyre, rows.held_out, fitting.alpha),
                 before = identify::held_out(stated, rows.held_out, fitting.alpha);
      fmt::print("  held out: fy {:.1f} N of {:.0f}, stated {:.1f}; fx {:.1f} of {:.0f}, {:.1f}\n",
                 mine.fy_left_n, mine.fy_n, before.fy_left_n, mine.fx_left_n, mine.fx_n,
                 before.fx_left_n);
      EXPECT_LT(mine.fy_left_n, 0.5 * before.fy_left_n);
      // This driver goes past no peak.
      for (const auto& peak : conditions.peaks) {
        if (peak.kind == identify::SlipKind::kLateral) {
          EXPECT_FALSE(peak.reached);
        }
      }
    }
  }
}

}  // namespace
