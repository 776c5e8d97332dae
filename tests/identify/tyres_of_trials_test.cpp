// Tyres from drives of the blind trials' two cars, whose tyres are a brush and a table: what the
// fitted Magic Formula says at the true slips and loads, against what those tyres truly did.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "base/statistics.h"
#include "crg/file.h"
#include "identify/drive_tyres.h"
#include "identify/forces.h"
#include "identify/tyre_fit.h"
#include "trial_drive.h"
#include "vehicle/vehicle_file.h"

namespace tyres_of_trials_test {

using test_drive::Trial;

/// How a tyre does on the last quarter of a drive, which no fit saw.
struct Judged {
  double left = 0.0;       ///< side force missed, root mean square, over the largest true one
  double stiffness = 0.0;  ///< fitted over true force of small slips, by least squares
  double peak = 0.0;       ///< the same of the twentieth of the rows with the largest forces
};

/// Of one tyre, at what truly was: load, slips, side force.
Judged judge(const Trial& trial, const vehicle::TyreCoefficients& tyre, std::size_t axle,
             const std::vector<double>& time_s) {
  struct Row {
    double slip, is, by_tyre;
  };
  std::vector<Row> rows;
  std::vector<double> slips, forces;
  const double from_s = time_s.front() + 0.75 * (time_s.back() - time_s.front());
  for (const double t : time_s) {
    if (t < from_s) continue;
    for (std::size_t i = 2 * axle; i < 2 * axle + 2; ++i) {
      const double side = (i % 2 == 0) == tyre.left_side ? 1.0 : -1.0;
      const vehicle::TyreInput<double> in{
          trial.of(t, i, 2), trial.of(t, i, 3), side * trial.of(t, i, 4), 0.0, 40.0, 0.0};
      const double by_tyre = side * vehicle::tyre_forces(tyre, in, {}, {.moments = false}).fy_n;
      rows.push_back({trial.of(t, i, 4), trial.of(t, i, 1), by_tyre});
      slips.push_back(std::abs(rows.back().slip));
      forces.push_back(std::abs(rows.back().is));
    }
  }
  const double small = 0.5 * base::quantile(slips, 0.9), large = base::quantile(forces, 0.95);
  double square = 0.0, most = 0.0, slope = 0.0, slope_is = 0.0, top = 0.0, top_is = 0.0;
  for (const Row& r : rows) {
    square += std::pow(r.by_tyre - r.is, 2);
    most = std::max(most, std::abs(r.is));
    if (std::abs(r.slip) < small) slope += r.slip * r.by_tyre, slope_is += r.slip * r.is;
    if (std::abs(r.is) >= large) top += std::abs(r.by_tyre), top_is += std::abs(r.is);
  }
  return {std::sqrt(square / static_cast<double>(rows.size())) / most, slope / slope_is,
          top / top_is};
}

TEST(SlowTyresOfTrials, AreThoseOfTheCars) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  for (const bool third : {false, true}) {
    if (!heavy && !third) continue;
    Trial trial(third, 1, 7);
    const vehicle::Vehicle stated = vehicle::read_vehicle(trial.folder.path("vehicle.yaml"));
    const auto car = make_car(stated.files, stated.parameters, stated.terms, stated.contact);
    const crg::Surface surface(crg::read(trial.folder.path("track.crg")));
    identify::ForcesOptions options;
    options.fuel_kg = 0.0;
    options.prior = stated.prior;
    options.rolling_sd = 1.0;
    options.noise_rounds = 3;
    const auto table = identify::forces_table(identify::estimate_forces(
        car, vehicle::Road(surface), trial.log(50.0, true, heavy ? 1e4 : 16.0), options));
    for (const std::size_t axle : {0u, 1u}) {
      const vehicle::TyreCoefficients& reference = stated.files.tyre[axle];
      identify::DriveTyres rows;
      identify::add_drive_tyres(rows, table, axle, reference.left_side, "drive");
      identify::TyreFitOptions fitting;
      fitting.starts = 1;
      fitting.most_rows = heavy ? 3000 : 800;
      const auto found_tyre = identify::fit_drive_tyres(rows, reference, fitting);
      ASSERT_TRUE(found_tyre);
      const identify::TyreFit& fit = found_tyre->fit;
      for (const std::string& kept : found_tyre->kept) fmt::print("{}\n", kept);
      const auto& time_s = *table.find("time_s");
      const Judged found = judge(trial, fit.tyre, axle, time_s),
                   was = judge(trial, reference, axle, time_s);
      fmt::print(
          "{} car, axle {}: side force kept back missed by {:.2f} % of the largest (stated tyre "
          "{:.2f}), at small slips {:.3f} of the truth ({:.3f}), largest forces {:.3f} ({:.3f})\n",
          third ? "third" : "second", axle, 100.0 * found.left, 100.0 * was.left, found.stiffness,
          was.stiffness, found.peak, was.peak);
      EXPECT_NEAR(found.stiffness, 1.0, 0.05);
      EXPECT_NEAR(found.peak, 1.0, 0.05);
      EXPECT_LT(found.left, 0.03);
    }
  }
}

}  // namespace tyres_of_trials_test
