#include "vehicle/magic_formula.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>

#include "recording/table.h"
#include "support/places.h"
#include "tyre_files.h"

namespace magic_formula_test {

using vehicle::AlphaConvention;
using vehicle::tyre_forces;
using vehicle::TyreCoefficients;
using vehicle::TyreFactors;
using vehicle::TyreForces;
using vehicle::TyreInput;
using Point = TyreInput<double>;

TyreCoefficients test_tyre() {
  return vehicle::parse_tyre(test_tyre_text(), "test tyre").coefficients;
}

std::array<double, 5> outputs(const TyreForces<double>& f) {
  return {f.fx_n, f.fy_n, f.mx_nm, f.my_nm, f.mz_nm};
}

/// Calls f for a grid of loads, slips and inclinations over the usual range.
void over_the_range(const std::function<void(const TyreInput<double>&)>& f) {
  for (const double fz : {300.0, 2000.0, 3000.0, 7000.0})
    for (const double kappa : {-0.9, -0.1, -0.02, 0.0, 0.03, 0.2, 0.8})
      for (const double alpha : {-0.4, -0.08, -0.01, 0.0, 0.02, 0.1, 0.5})
        for (const double gamma : {-0.07, 0.0, 0.03})
          f({fz, kappa, std::tan(alpha), gamma, 30.0, 160000.0});
}

// Two independent programs agree on Fx to 3e-7 N; fy_a is tan(alpha) throughout, fy_b has alpha in
// the pure side force. Bounds: printing precision of the table, and 0.2 N for fy_b, whose program
// treats the inclination differently.
TEST(MagicFormula, AgreesWithTwoIndependentPrograms) {
  const std::string folder = places::data() + "/tyre/";
  if (!std::filesystem::exists(folder + "mf61_reference.csv"))
    GTEST_SKIP() << "no mf61_reference.csv in " << folder;
  const recording::Table table = recording::read_table(folder + "mf61_reference.csv");
  const auto at = [&](const char* name, std::size_t row) { return (*table.find(name))[row]; };
  ASSERT_EQ(table.rows(), 729u);
  for (const char* file : {"sample_mf61.tir", "sample_mf62.tir"}) {
    const TyreCoefficients tyre = vehicle::read_tyre(folder + file).coefficients;
    for (std::size_t i = 0; i < table.rows(); ++i) {
      const TyreInput<double> in{at("fz_n", i),      at("kappa", i),  std::tan(at("alpha_rad", i)),
                                 at("gamma_rad", i), at("vx_mps", i), 0.0};
      const auto tangent = tyre_forces(tyre, in);
      const auto angle = tyre_forces(tyre, in, {}, {.alpha = AlphaConvention::kAngle});
      EXPECT_NEAR(tangent.fx_n, at("fx_n", i), 1e-5);
      EXPECT_NEAR(angle.fx_n, at("fx_n", i), 1e-5);
      EXPECT_NEAR(tangent.fy_n, at("fy_a_n", i), 1e-5);
      EXPECT_NEAR(angle.fy_n, at("fy_b_n", i), 0.2);
    }
  }
}

TEST(MagicFormula, IsMirroredOnTheOtherSideOfTheCar) {
  const TyreCoefficients tyre = test_tyre();
  over_the_range([&](const TyreInput<double>& in) {
    TyreInput<double> other = in;
    other.tan_alpha = -in.tan_alpha;
    other.gamma_rad = -in.gamma_rad;
    const auto a = tyre_forces(tyre, in);
    const auto b = tyre_forces(tyre, other, {}, {.mirrored = true});
    EXPECT_EQ(a.fx_n, b.fx_n);
    EXPECT_EQ(a.fy_n, -b.fy_n);
    EXPECT_EQ(a.mx_nm, -b.mx_nm);
    EXPECT_EQ(a.my_nm, b.my_nm);
    EXPECT_EQ(a.mz_nm, -b.mz_nm);
  });
}

TEST(MagicFormula, HasNoForceWithoutLoadAndFadesTowardsIt) {
  const TyreCoefficients tyre = test_tyre();
  for (const double fz : {0.0, -100.0}) {
    const auto none = outputs(tyre_forces(tyre, Point{fz, 0.1, 0.1, 0.05, 30.0, 0.0}));
    for (const double value : none) EXPECT_EQ(value, 0.0);
  }
  for (const double fz : {1.0, 1e-3, 1e-6}) {
    const auto light = tyre_forces(tyre, Point{fz, 0.1, 0.1, 0.05, 30.0, 0.0});
    EXPECT_LT(std::hypot(light.fx_n, light.fy_n), 4.0 * fz);
    EXPECT_LT(std::abs(light.mx_nm) + std::abs(light.mz_nm), 2.0 * fz);
  }
}

TEST(MagicFormula, KeepsTheCombinedForceInsideTheEllipseOfThePurePeaks) {
  std::vector<TyreCoefficients> tyres{test_tyre()};
  const std::string sample = places::data() + "/tyre/sample_mf61.tir";
  if (std::filesystem::exists(sample)) tyres.push_back(vehicle::read_tyre(sample).coefficients);
  for (const TyreCoefficients& tyre : tyres) {
    double worst = 0.0;
    for (const double load : {0.2, 0.6, 1.0, 1.8}) {
      for (const double gamma : {-0.05, 0.0, 0.05}) {
        const double fz = load * tyre.nominal_load_n;
        double peak_x = 0.0, peak_y = 0.0;
        for (double s = -1.0; s <= 1.0; s += 0.002) {
          peak_x =
              std::max(peak_x, std::abs(tyre_forces(tyre, Point{fz, s, 0, gamma, 20, 0}).fx_n));
          peak_y =
              std::max(peak_y, std::abs(tyre_forces(tyre, Point{fz, 0, s, gamma, 20, 0}).fy_n));
        }
        for (double kappa = -1.0; kappa <= 1.0; kappa += 0.02)
          for (double a = -0.9; a <= 0.9; a += 0.02) {
            const auto f = tyre_forces(tyre, Point{fz, kappa, std::tan(a), gamma, 20, 0});
            worst = std::max(worst, std::hypot(f.fx_n / peak_x, f.fy_n / peak_y));
          }
      }
    }
    EXPECT_LE(worst, 1.1);
    RecordProperty("worst", std::to_string(worst));
  }
}

TEST(MagicFormula, HasTheStiffnessItReports) {
  const TyreCoefficients tyre = test_tyre();
  TyreFactors<double> pure;
  pure.combined_slip = 0.0;
  const auto base = tyre_forces(tyre, Point{3000, 0, 0, 0, 20, 0}, pure);
  const double h = 1e-6;
  const double shift_x = -tyre.phx1, shift_y = -tyre.phy1;
  const auto fx = [&](double k) {
    return tyre_forces(tyre, Point{3000, k, 0, 0, 20, 0}, pure).fx_n;
  };
  const auto fy = [&](double a) {
    return tyre_forces(tyre, Point{3000, 0, a, 0, 20, 0}, pure).fy_n;
  };
  EXPECT_NEAR((fx(shift_x + h) - fx(shift_x - h)) / (2 * h) / base.slip_stiffness_n, 1.0, 1e-5);
  EXPECT_NEAR((fy(shift_y + h) - fy(shift_y - h)) / (2 * h) / base.cornering_stiffness_npr, 1.0,
              1e-5);
}

TEST(MagicFormula, ScalesWithItsFactors) {
  const TyreCoefficients tyre = test_tyre();
  TyreFactors<double> grip;
  grip.grip_x = 0.5;
  grip.grip_y = 0.7;
  const auto full = tyre_forces(tyre, Point{3000, 0.0, 0.0, 0, 20, 0});
  const auto less = tyre_forces(tyre, Point{3000, 0.0, 0.0, 0, 20, 0}, grip);
  EXPECT_DOUBLE_EQ(less.mu_x, 0.5 * full.mu_x);
  EXPECT_DOUBLE_EQ(less.mu_y, 0.7 * full.mu_y);
  EXPECT_DOUBLE_EQ(less.slip_stiffness_n, full.slip_stiffness_n);

  TyreFactors<double> off;
  off.load_sensitivity = 0.0;
  off.camber = 0.0;
  const auto one = tyre_forces(tyre, Point{1500, 0.05, 0.04, 0.03, 20, 0}, off);
  const auto two = tyre_forces(tyre, Point{3000, 0.05, 0.04, -0.02, 20, 0}, off);
  EXPECT_NEAR(two.fx_n / one.fx_n, 2.0, 1e-9);
  EXPECT_NEAR(two.fy_n / one.fy_n, 2.0, 1e-6);

  off.combined_slip = 0.0;
  const auto apart = tyre_forces(tyre, Point{3000, 0.05, 0.04, 0, 20, 0}, off);
  EXPECT_EQ(apart.fx_n, tyre_forces(tyre, Point{3000, 0.05, 0.0, 0, 20, 0}, off).fx_n);
  EXPECT_EQ(apart.fy_n, tyre_forces(tyre, Point{3000, 0.0, 0.04, 0, 20, 0}, off).fy_n);
}

TEST(MagicFormula, GrowsInProportionBeyondTheHighestLoadOfTheFile) {
  const TyreCoefficients tyre = test_tyre();
  const auto edge = tyre_forces(tyre, Point{9000, 0.05, 0.05, 0, 20, 0});
  const auto beyond = tyre_forces(tyre, Point{18000, 0.05, 0.05, 0, 20, 0});
  EXPECT_DOUBLE_EQ(beyond.fx_n, 2 * edge.fx_n);
  EXPECT_DOUBLE_EQ(beyond.fy_n, 2 * edge.fy_n);
}

// Derivatives by Jet against central differences, away from the kinks at zero slip. The bound is
// the error of the differences themselves: step 1e-6, curvature of the formula.
TEST(MagicFormula, DifferentiatesLikeCentralDifferences) {
  using Jet = ceres::Jet<double, 6>;
  const TyreCoefficients tyre = test_tyre();
  over_the_range([&](const TyreInput<double>& in) {
    if (in.kappa == 0.0 || in.tan_alpha == 0.0 || in.gamma_rad == 0.0) return;
    const std::array<double, 6> x{in.fz_n,      in.kappa,  in.tan_alpha,
                                  in.gamma_rad, in.vx_mps, in.pressure_pa};
    const std::array<double, 6> step{1.0, 1e-5, 1e-5, 1e-5, 1e-3, 10.0};
    const auto at = [&](const std::array<double, 6>& p) {
      return outputs(tyre_forces(tyre, TyreInput<double>{p[0], p[1], p[2], p[3], p[4], p[5]}));
    };
    const auto jet = tyre_forces(tyre, TyreInput<Jet>{Jet(x[0], 0), Jet(x[1], 1), Jet(x[2], 2),
                                                      Jet(x[3], 3), Jet(x[4], 4), Jet(x[5], 5)});
    const std::array<Jet, 5> d{jet.fx_n, jet.fy_n, jet.mx_nm, jet.my_nm, jet.mz_nm};
    const auto value = at(x);
    for (std::size_t k = 0; k < 5; ++k)
      EXPECT_NEAR(d[k].a, value[k], 1e-11 * (std::abs(value[k]) + in.fz_n));
    for (std::size_t j = 0; j < 6; ++j) {
      // Richardson: two central differences, the h^2 error cancelled.
      const auto central = [&](double h) {
        auto up = x, down = x;
        up[j] += h;
        down[j] -= h;
        const auto a = at(up), b = at(down);
        std::array<double, 5> out{};
        for (std::size_t k = 0; k < 5; ++k) out[k] = (a[k] - b[k]) / (2 * h);
        return out;
      };
      const auto coarse = central(2 * step[j]), fine = central(step[j]);
      for (std::size_t k = 0; k < 5; ++k) {
        const double expected = (4 * fine[k] - coarse[k]) / 3;
        const double scale = std::abs(expected) + in.fz_n / std::max(std::abs(x[j]), 0.01);
        EXPECT_NEAR(d[k].v[static_cast<int>(j)], expected, 1e-6 * scale)
            << "output " << k << " input " << j;
      }
    }
  });
}

TEST(MagicFormula, LoadsTheTyreByItsDeflection) {
  const TyreCoefficients tyre = test_tyre();
  EXPECT_EQ(vehicle::tyre_load(tyre, -0.01, 0.0, 0.0), 0.0);
  // By definition of the linear coefficient the stiffness is VERTICAL_STIFFNESS where the load is
  // FNOMIN, at the nominal pressure, standing still.
  double low = 0.0, high = 0.1;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (vehicle::tyre_load(tyre, middle, 0.0, 0.0) < tyre.nominal_load_n ? low : high) = middle;
  }
  const double h = 1e-7;
  const double stiffness =
      (vehicle::tyre_load(tyre, low + h, 0.0, 0.0) - vehicle::tyre_load(tyre, low - h, 0.0, 0.0)) /
      (2 * h);
  EXPECT_NEAR(stiffness / tyre.vertical_stiffness_npm, 1.0, 1e-6);
  EXPECT_GT(vehicle::tyre_load(tyre, low, 100.0, 0.0), tyre.nominal_load_n);
  EXPECT_GT(vehicle::tyre_load(tyre, low, 0.0, 200000.0), tyre.nominal_load_n);
}

TEST(MagicFormula, RelaxesOverStiffnessOfContactAndCarcass) {
  const TyreCoefficients tyre = test_tyre();
  const auto f = tyre_forces(tyre, Point{3000, 0, 0, 0, 20, 0});
  const auto length =
      vehicle::relaxation_lengths(tyre, 3000.0, f.slip_stiffness_n, f.cornering_stiffness_npr);
  EXPECT_DOUBLE_EQ(length.longitudinal_m, f.slip_stiffness_n / 300000);
  EXPECT_DOUBLE_EQ(length.lateral_m, -f.cornering_stiffness_npr / 150000);
  EXPECT_EQ(vehicle::relaxation_lengths(tyre, 0.0, 0.0, 0.0).longitudinal_m, 0.06);
  // A higher pressure stiffens the carcass, scale factors act on the length.
  TyreCoefficients other = tyre;
  other.pcfx3 = 0.5;
  other.pcfy3 = 0.25;
  other.lsgkp = 2.0;
  const auto hard = vehicle::relaxation_lengths(other, 3000.0, f.slip_stiffness_n,
                                                f.cornering_stiffness_npr, 0.0, 225000.0);
  EXPECT_DOUBLE_EQ(hard.longitudinal_m, 2.0 * length.longitudinal_m / 1.25);
  EXPECT_DOUBLE_EQ(hard.lateral_m, length.lateral_m / 1.125);
}

// 5.2: PTX1 to PTX3 and PTY1, PTY2. Numbers by hand for 3600 N at a nominal load of 3000 N:
// dfz = 0.2; 3600 (2 + 0.5 * 0.2) exp(-0.2) 0.3 / 3000 and 1.5 sin(2 atan(3600 / 6000)) 0.3.
TEST(MagicFormula, RelaxesByThePolynomialsOfOlderFiles) {
  TyreCoefficients tyre = test_tyre();
  tyre.version = 52;
  tyre.longitudinal_stiffness_npm = tyre.lateral_stiffness_npm = 0.0;
  tyre.ptx1 = 2.0;
  tyre.ptx2 = 0.5;
  tyre.ptx3 = 1.0;
  tyre.pty1 = 1.5;
  tyre.pty2 = 2.0;
  tyre.pky3 = 2.0;
  tyre.lsgkp = 0.5;
  tyre.lsgal = 0.8;
  const auto upright = vehicle::relaxation_lengths(tyre, 3600.0, 1.0, 1.0);
  EXPECT_NEAR(upright.longitudinal_m, 0.5 * 0.756 * 0.8187307531, 1e-9);
  EXPECT_NEAR(upright.lateral_m, 0.8 * 0.45 * 0.8823529412, 1e-9);
  for (const double gamma : {0.05, -0.05})
    EXPECT_NEAR(vehicle::relaxation_lengths(tyre, 3600.0, 1.0, 1.0, gamma).lateral_m,
                0.9 * upright.lateral_m, 1e-12);
}

// Less friction shrinks the vertical shift of a 5.2 tyre in proportion; one of 6.x keeps more of it
// (digressive, A_mu = 10): 0.5 becomes 10 * 0.5 / (1 + 9 * 0.5).
TEST(MagicFormula, ShiftsWithFrictionAsTheVersionSays) {
  TyreCoefficients tyre = test_tyre();
  tyre.phy1 = tyre.phy2 = tyre.pvy2 = 0.0;
  tyre.pvy1 = 0.02;
  const auto shift = [&](int version, double lmuy) {
    TyreCoefficients one = tyre;
    one.version = version;
    one.lmuy = lmuy;
    return tyre_forces(one, Point{3000, 0, 0, 0, 20, 0}).fy_n;
  };
  EXPECT_NEAR(shift(52, 1.0), 60.0, 1e-9);
  EXPECT_NEAR(shift(52, 0.5), 30.0, 1e-9);
  EXPECT_NEAR(shift(61, 0.5), 60.0 * 5.0 / 5.5, 1e-9);
}

// Overturning couple, term by term at 3000 N = nominal load, 0.3 m: each number by hand.
TEST(MagicFormula, OverturnsAsTheSourceSays) {
  TyreCoefficients tyre = test_tyre();
  for (double TyreCoefficients::*member :
       {&TyreCoefficients::qsx1, &TyreCoefficients::qsx2, &TyreCoefficients::qsx3,
        &TyreCoefficients::qsx4, &TyreCoefficients::qsx5, &TyreCoefficients::qsx6,
        &TyreCoefficients::qsx7, &TyreCoefficients::qsx8, &TyreCoefficients::qsx9,
        &TyreCoefficients::qsx10, &TyreCoefficients::qsx11})
    tyre.*member = 0.0;
  const double gamma = 0.1;
  const auto mx = [&](const TyreCoefficients& t) {
    return tyre_forces(t, Point{3000, 0, 0, std::asin(gamma), 20, 0}).mx_nm;
  };
  const double fy_n = tyre_forces(tyre, Point{3000, 0, 0, std::asin(gamma), 20, 0}).fy_n;
  EXPECT_EQ(mx(tyre), 0.0);
  TyreCoefficients one = tyre;
  one.qsx4 = 0.5;
  one.qsx5 = 2.0;
  one.qsx6 = 2.0;
  one.qsx7 = 3.0;
  // The arc of the square: cos(2 atan 4) = (1 - 16) / (1 + 16).
  EXPECT_NEAR(mx(one), 900.0 * 0.5 * (-15.0 / 17.0) * std::sin(0.3), 1e-9);
  one = tyre;
  one.qsx12 = 2.0;
  EXPECT_NEAR(mx(one), -900.0 * 2.0 * 0.01, 1e-9);
  one = tyre;
  one.qsx13 = 0.1;
  one.qsx14 = 0.5;
  EXPECT_NEAR(mx(one), 0.3 * fy_n * 0.15, 1e-9);
}

// LFZO scales the load at which coefficients hold, not the arms of the moments: half the trail's
// reference load would double the trail.
TEST(MagicFormula, ReferencesMomentsToTheNominalLoadItself) {
  TyreCoefficients tyre = test_tyre();
  for (double TyreCoefficients::*member :
       {&TyreCoefficients::qdz2, &TyreCoefficients::qbz2, &TyreCoefficients::qbz3,
        &TyreCoefficients::qez2, &TyreCoefficients::qez3, &TyreCoefficients::qhz2,
        &TyreCoefficients::qdz7})
    tyre.*member = 0.0;
  tyre.ssz1 = tyre.ssz2 = tyre.qdz6 = 0.0;
  const auto trail = [](const TyreCoefficients& t) {
    const auto f = tyre_forces(t, Point{3000, 0, 0.03, 0, 20, 0});
    return -f.mz_nm / f.fy_n;
  };
  TyreCoefficients half = tyre;
  half.lfzo = 0.5;
  EXPECT_NEAR(trail(half) / trail(tyre), 1.0, 1e-9);
}

TEST(MagicFormula, RollsOnItsFreeRadiusWhereTheFileSaysSo) {
  const TyreCoefficients silent = test_tyre();
  EXPECT_DOUBLE_EQ(vehicle::rolling_radius(silent, 3000.0, 0.3, 0.015), 0.295);
  const TyreCoefficients zero =
      vehicle::parse_tyre(test_tyre_text() + "BREFF = 0\nDREFF = 0\nFREFF = 0\n", "t").coefficients;
  EXPECT_DOUBLE_EQ(vehicle::rolling_radius(zero, 3000.0, 0.3, 0.015), 0.3);
}

}  // namespace magic_formula_test
