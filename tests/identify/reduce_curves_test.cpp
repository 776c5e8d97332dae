// Curves of wheels and axles, fitted to moments whose forces are known.
#include <gtest/gtest.h>

#include <cmath>

#include "reduce_fit.h"
#include "support/places.h"
#include "vehicle/vehicle_file.h"

namespace reduce_curves_test {

using identify::CarMoment;

/// A wheel that has most side force where it drives a little, as tyre files with RHY1 say (H. B.
/// Pacejka, Tire and Vehicle Dynamics, 2012, 4.3.2).
double side_force(double fz_n, double alpha_rad, double kappa) {
  const double b = 20.0 * std::cos(std::atan(20.0 * alpha_rad));
  const double weight = std::cos(std::atan(b * (kappa - 0.02))) / std::cos(std::atan(b * -0.02));
  return weight * 1.4 * fz_n * std::sin(1.5 * std::atan(12.0 * alpha_rad));
}

std::vector<CarMoment> moments() {
  std::vector<CarMoment> out;
  for (double fz_n = 1500.0; fz_n < 5000.0; fz_n += 1000.0)
    for (int slip = 0; slip <= 10; ++slip)
      for (int drive = -6; drive <= 6; ++drive) {
        const double alpha_rad = 0.02 * slip, kappa = 0.015 * drive;
        CarMoment m;
        m.vx_mps = 30.0;
        m.vy_mps = -30.0 * std::tan(alpha_rad);
        m.an_mps2 = 9.81;
        for (auto& w : m.wheel) {
          w.fz_n = fz_n;
          w.kappa = kappa;
          w.fy_n = side_force(fz_n, alpha_rad, kappa);
          w.fx_n = 1.5 * fz_n * std::sin(1.6 * std::atan(14.0 * kappa)) *
                   std::cos(std::atan(6.0 * alpha_rad));
        }
        out.push_back(m);
      }
  return out;
}

TEST(ReduceCurves, SideForceMayBeLargestWhileDriving) {
  const vehicle::Vehicle v =
      vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  const auto full = make_car(v.files, v.parameters, v.terms, v.contact);
  identify::ReducedCar car = identify::plain_numbers(full, 0.0);
  std::vector<identify::PartError> errors;
  const std::vector<CarMoment> all = moments();
  identify::fit_curves(car, all, all, full, 1, errors);
  ASSERT_EQ(errors.size(), 8u);
  for (const identify::PartError& e : errors) EXPECT_LT(e.rms, 0.005) << e.name;
  for (const identify::WheelCurve* curves : {car.wheel, car.axle})
    for (int a = 0; a < 2; ++a) EXPECT_NEAR(curves[a].shift_kappa, -0.02, 0.002);
  identify::CurveInput in{3000.0, std::tan(0.01)};
  EXPECT_NEAR(identify::curve_forces(car.wheel[1], in).fy_n, side_force(3000.0, 0.01, 0.0), 10.0);
}

}  // namespace reduce_curves_test
