// Aligning moments of other people's tyres, measured on a made-up bench, are found again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "base/error.h"
#include "base/random.h"
#include "identify/tyre_fit.h"
#include "recording/table.h"
#include "support/figure.h"
#include "support/places.h"
#include "vehicle/tyre_file.h"

namespace aligning_fit_test {

using identify::TyreFit, identify::TyreSamples;
using vehicle::TyreCoefficients;
constexpr double kDegree = std::numbers::pi / 180.0;

TyreCoefficients racer() {
  return vehicle::read_tyre(places::source() + "/vehicles/open_wheel/front.tir").coefficients;
}

/// A shorter trail that goes on longer, and a moment at rest.
TyreCoefficients other_racer() {
  TyreCoefficients tyre = racer();
  tyre.qdz1 *= 0.75;
  tyre.qbz1 *= 0.8;
  tyre.qdz6 += 0.004;
  tyre.qhz1 += 0.003;
  tyre.ssz1 += 0.03;
  return tyre;
}

/// What a bench measures, with noise of a share of the nominal load (times the radius) in all
/// three.
TyreSamples bench(const TyreCoefficients& tyre, double noise, std::uint64_t seed = 3,
                  double offset_deg = 0.0, bool combined = true) {
  TyreSamples out;
  base::Random random(seed);
  const auto add = [&](double load, double camber_deg, double kappa, double alpha_deg) {
    const vehicle::TyreInput<double> at{load * tyre.nominal_load_n,
                                        kappa,
                                        std::tan((alpha_deg + offset_deg) * kDegree),
                                        camber_deg * kDegree,
                                        tyre.nominal_speed_mps,
                                        0.0};
    const auto f = vehicle::tyre_forces(tyre, at);
    const double sd_n = noise * tyre.nominal_load_n;
    out.conditions.push_back(at);
    out.fx_n.push_back(f.fx_n + sd_n * random.normal());
    out.fy_n.push_back(f.fy_n + sd_n * random.normal());
    out.mz_nm.push_back(f.mz_nm + 0.1 * sd_n * tyre.unloaded_radius_m * random.normal());
  };
  for (const double load : {0.4, 0.7, 1.0, 1.4})
    for (const double camber_deg : {-3.0, 0.0, 3.0}) {
      for (int i = -24; i <= 24; ++i) add(load, camber_deg, 0.0, 0.5 * i);
      if (!combined) continue;
      for (int i = -12; i <= 12; ++i) add(load, camber_deg, 0.015 * i, 0.0);
      for (const double alpha_deg : {-6.0, -3.0, 3.0, 6.0})
        for (int i = -4; i <= 4; ++i) add(load, camber_deg, 0.05 * i, alpha_deg);
    }
  return out;
}

/// Root mean square of fitted less true moment over the largest true one, at other slip angles.
double missed(const TyreCoefficients& fitted, const TyreCoefficients& truth) {
  double sum2 = 0.0, most = 0.0;
  const TyreSamples at = bench(truth, 0.0, 1, 0.2);
  for (std::size_t i = 0; i < at.rows(); ++i) {
    sum2 += std::pow(vehicle::tyre_forces(fitted, at.conditions[i]).mz_nm - at.mz_nm[i], 2);
    most = std::max(most, std::abs(at.mz_nm[i]));
  }
  return std::sqrt(sum2 / static_cast<double>(at.rows())) / most;
}

identify::TyreFitOptions few_starts() {
  identify::TyreFitOptions options;
  options.starts = 3;
  return options;
}

TEST(SlowAligningFit, AnotherTrailIsFoundThroughNoise) {
  const TyreCoefficients truth = other_racer();
  const TyreFit fit = identify::fit_tyre(bench(truth, 0.005), racer(), few_starts());
  support::figure("mz_percent", 100.0 * missed(fit.tyre, truth));
  EXPECT_GT(missed(racer(), truth), 0.05);
  EXPECT_LT(missed(fit.tyre, truth), 0.005);
  ASSERT_EQ(fit.stages.back().kind, identify::SlipKind::kAligning);
  EXPECT_EQ(fit.stages.back().why_not, "");
  EXPECT_GE(fit.stages.back().agreeing, 2);
}

TEST(SlowAligningFit, APublishedTyreIsFoundFromAnotherOne) {
  const std::string path = places::data() + "/tyre/sample_mf61.tir";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no published tyre";
  const TyreCoefficients truth = vehicle::read_tyre(path).coefficients;
  const TyreFit fit = identify::fit_tyre(bench(truth, 0.002), racer(), few_starts());
  support::figure("mz_percent", 100.0 * missed(fit.tyre, truth));
  EXPECT_LT(missed(fit.tyre, truth), 0.01);
}

// The forces are as fitted, so that they add to what the moment is off by.
TEST(AligningFit, TheTruthLiesInNineOfTenIntervals) {
  const TyreCoefficients truth = other_racer();
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const int benches = heavy ? 40 : 4;
  int inside = 0, all = 0;
  identify::TyreFitOptions options;
  options.starts = 1;
  const TyreSamples at = bench(truth, 0.0, 1, 0.2, heavy);
  for (int b = 0; b < benches; ++b) {
    const TyreFit fit = identify::fit_tyre(
        bench(truth, 0.01, 100u + static_cast<unsigned>(b), 0.0, heavy), racer(), options);
    for (std::size_t i = 0; i < at.rows(); ++i) {
      const auto band = identify::force_band(fit, at.conditions[i]);
      ++all;
      if (std::abs(band.mz_nm - at.mz_nm[i]) <= 1.645 * band.mz_sd_nm) ++inside;
    }
  }
  const double share = static_cast<double>(inside) / all;
  support::figure("inside_percent", 100.0 * share);
  EXPECT_GT(share, 0.80);
  EXPECT_LT(share, 0.98);
}

TEST(AligningFit, WithoutMomentsNothingIsFitted) {
  TyreSamples without = bench(other_racer(), 0.005, 3, 0.0, false);
  without.mz_nm.clear();
  const TyreFit fit = identify::fit_tyre(without, racer(), few_starts());
  EXPECT_EQ(fit.mz.rows, 0u);
  EXPECT_EQ(fit.stages.size(), 3u);
  EXPECT_EQ(fit.tyre.qdz1, racer().qdz1);
}

TEST(AligningFit, TheArmOfTheLongitudinalForceWantsCombinedSlip) {
  const TyreFit fit =
      identify::fit_tyre(bench(other_racer(), 0.005, 3, 0.0, false), racer(), few_starts());
  EXPECT_GT(fit.mz.rows, 0u);
  for (const auto& c : fit.coefficients) EXPECT_NE(c.kind, identify::SlipKind::kAligningArm);
}

TEST(AligningFit, TooFewMomentsAreSaid) {
  TyreSamples few = bench(other_racer(), 0.005, 3, 0.0, false);
  for (std::size_t i = 20; i < few.rows(); ++i) few.mz_nm[i] = NAN;
  const TyreFit fit = identify::fit_tyre(few, racer(), few_starts());
  EXPECT_THAT(fit.stages.back().why_not, ::testing::HasSubstr("20 rows with a moment, wanted"));
  EXPECT_EQ(fit.tyre.qdz1, racer().qdz1);
}

TEST(AligningFit, OtherAxesAreRefused) {
  TyreSamples turned = bench(racer(), 0.005);
  for (double& mz_nm : turned.mz_nm) mz_nm = -mz_nm;
  try {
    identify::fit_tyre(turned, racer(), few_starts());
    FAIL() << "moments of the other sign";
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("mz_nm runs against the reference's"));
  }
}

TEST(AligningFit, RowsWithAndWithoutMomentsGoTogether) {
  recording::Table with, without;
  for (const std::string name : {"fz_n", "kappa", "alpha_rad", "gamma_rad", "vx_mps", "fy_n"}) {
    const double load_n = name == "fz_n" ? 3000.0 : 0.0;
    with.add(name, {load_n, 0.0});
    without.add(name, {load_n, 0.0});
  }
  with.add("mz_nm", {12.0, 13.0});
  TyreSamples samples;
  identify::add_tyre_samples(samples, without, "without");
  identify::add_tyre_samples(samples, with, "with");
  identify::add_tyre_samples(samples, without, "without");
  ASSERT_EQ(samples.rows(), 3u);  // the second row of each has no load
  ASSERT_EQ(samples.mz_nm.size(), 3u);
  EXPECT_TRUE(std::isnan(samples.mz_nm[0]));
  EXPECT_EQ(samples.mz_nm[1], 12.0);
  EXPECT_TRUE(std::isnan(samples.mz_nm[2]));
}

}  // namespace aligning_fit_test
