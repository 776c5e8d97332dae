#include "vehicle/laws/disc_heat.h"

#include <gtest/gtest.h>

#include <cmath>

namespace disc_heat_test {

using namespace vehicle;  // NOLINT: a test of this library

laws::DiscParameters<double> front() { return laws::disc_parameters(default_parameters(), 0); }

laws::DiscRates<double> rates(const laws::DiscParameters<double>& p,
                              const laws::DiscAmounts<double>& amount, double surface_k,
                              double core_k, double brake_nm, double spin_radps, double speed_mps) {
  return laws::disc_heat<double>(p, amount, surface_k, core_k, brake_nm, spin_radps,
                                 laws::disc_air<double>(p, amount, speed_mps));
}

// 1000 N m at 100 rad/s are 100 kW; 0.9 of it into 900 J/K: 100 K/s. Half the term, half of that.
TEST(DiscHeat, TakesUpItsShareOfTheFriction) {
  EXPECT_NEAR(rates(front(), {.heating = 1}, 300, 300, -1000, 100, 0).surface_kps, 100, 1e-9);
  EXPECT_NEAR(rates(front(), {.heating = 0.5}, 300, 300, -1000, 100, 0).surface_kps, 50, 1e-9);
  EXPECT_EQ(rates(front(), {.heating = 1}, 300, 300, -1000, 100, 0).core_kps, 0.0);
}

// 260 W/K over 100 K leave the surface for the core; with a slope of 1e-3 per kelvin they are 20 %
// more at a mean of 700 K, and never below a twentieth.
TEST(DiscHeat, ConductsToItsCore) {
  laws::DiscParameters<double> p = front();
  const auto at = [&](double surface, double core) {
    return rates(p, {.conduction = 1}, surface, core, 0, 0, 0);
  };
  EXPECT_NEAR(at(750, 650).surface_kps, -26000.0 / 900, 1e-9);
  EXPECT_NEAR(at(750, 650).core_kps, 26000.0 / 1900, 1e-9);
  p.conductance_slope_1pk = 1e-3;
  EXPECT_NEAR(at(750, 650).surface_kps, -1.2 * 26000.0 / 900, 1e-9);
  p.conductance_slope_1pk = -0.01;
  EXPECT_NEAR(at(750, 650).surface_kps, -0.05 * 26000.0 / 900, 1e-9);
}

// Worked by hand: d = 0.28 m, 20 m/s: Re = 350,000, 0.02 Re^0.8 = 544.9; 100 rad/s: the rim runs
// 14 m/s, Re = 245,000, 0.04 Re^0.8 = 819.4. With 20 at rest Nu = 1384; h = 128.5 W/(m2 K); 0.11
// m2, 600 K - 295 K: 4312 W.
TEST(DiscHeat, IsCooledByItsOwnTurningAndTheCarsAir) {
  const auto p = front();
  EXPECT_NEAR(rates(p, {.convection = 1}, 600, 600, 0, 100, 20).surface_kps, -4312.0 / 900, 0.01);
  EXPECT_NEAR(rates(p, {.convection = 1}, 600, 600, 0, -100, 20).surface_kps, -4312.0 / 900, 0.01);
  EXPECT_NEAR(rates(p, {.convection = 1}, 295, 295, 0, 100, 20).surface_kps, 0, 1e-12);
  EXPECT_EQ(rates(p, {.convection = 1}, 600, 600, 0, 100, 20).core_kps, 0.0);
}

// Between the one law and faces and vanes the heat goes from one to the other.
TEST(DiscHeat, MixesItsLawsOfConvection) {
  const auto p = front();
  const auto at = [&](double vanes) {
    return rates(p, {.convection = 1, .vanes = vanes}, 700, 600, 0, 80, 25);
  };
  EXPECT_LT(at(1).core_kps, 0);
  EXPECT_NEAR(at(0.25).core_kps, 0.25 * at(1).core_kps, 1e-12);
  EXPECT_NEAR(at(0.25).surface_kps, 0.75 * at(0).surface_kps + 0.25 * at(1).surface_kps, 1e-9);
}

// Stefan and Boltzmann: 1000 K against 295 K with emissivity 0.55 and 0.11 m2: 3404.5 W.
TEST(DiscHeat, Radiates) {
  const double w = 0.55 * 0.11 * 5.670374e-8 * (1e12 - std::pow(295.0, 4));
  EXPECT_NEAR(w, 3404.5, 0.5);
  EXPECT_NEAR(rates(front(), {.radiation = 1}, 1000, 900, 0, 0, 0).surface_kps, -w / 900, 1e-4);
}

// 6e-4 per kelvin above 300 K: 24 % more at 700 K. A slope at its bound in the cold must not turn
// the heat capacity over.
TEST(DiscHeat, TakesMoreHeatWhenHot) {
  laws::DiscParameters<double> p = front();
  const laws::DiscAmounts<double> amount{.heating = 1, .heat_capacity = 1};
  EXPECT_NEAR(rates(p, amount, 700, 300, -1000, 100, 0).surface_kps, 100 / 1.24, 1e-9);
  p.capacity_slope_1pk = 0.01;
  EXPECT_NEAR(rates(p, amount, 199, 300, -1000, 100, 0).surface_kps, 500, 1e-9);
}

}  // namespace disc_heat_test
