#include "road/roughness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstdlib>
#include <numbers>
#include <random>
#include <vector>

namespace roughness_test {

constexpr double kStep = 0.1;
constexpr double kTurn = 2.0 * std::numbers::pi;

double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

/// A sum of 1500 waves whose density is psd_n0 (n / 0.1)^-w between n_min and n_max: wave k carries
/// the variance of its own narrow band, so the density is known without any estimate.
std::vector<double> random_road(double psd_n0, double w, double n_min, double n_max,
                                double length_m, unsigned seed) {
  std::mt19937_64 random(seed);
  std::vector<double> z(static_cast<std::size_t>(length_m / kStep) + 1, 0.0);
  constexpr int kWaves = 1500;
  const double ratio = std::pow(n_max / n_min, 1.0 / kWaves);
  for (int k = 0; k < kWaves; ++k) {
    const double low = n_min * std::pow(ratio, k), high = low * ratio;
    const double n = low + (high - low) * uniform(random);
    const double amplitude = std::sqrt(2.0 * psd_n0 * std::pow(n / 0.1, -w) * (high - low));
    // A rotating phasor instead of a sine per sample: 30,000 samples x 1500 waves.
    // By hand: std::complex looks for infinities at each product.
    const double phase = kTurn * uniform(random), turn = kTurn * n * kStep;
    const double c = std::cos(turn), s = std::sin(turn);
    double x = amplitude * std::cos(phase), y = amplitude * std::sin(phase);
    for (double& value : z) {
      value += x;
      const double next = x * c - y * s;
      y = x * s + y * c;
      x = next;
    }
  }
  return z;
}

double class_mean(char c) { return 16e-6 * std::pow(4.0, c - 'A'); }

TEST(Psd, VarianceOfASineIsFoundAtItsFrequency) {
  std::vector<double> z;
  for (int i = 0; i < 20000; ++i) z.push_back(0.01 * std::sin(kTurn * 0.25 * i * kStep));
  const std::vector<std::vector<double>> sections{z};
  const road::DisplacementPsd psd = road::displacement_psd(sections, kStep);
  ASSERT_GT(psd.segments, 5u);
  const double dn = psd.n_cpm[1] - psd.n_cpm[0];
  double variance = 0.0, peak = 0.0, n_peak = 0.0;
  for (std::size_t i = 0; i < psd.n_cpm.size(); ++i) {
    variance += psd.psd_m3[i] * dn;
    if (psd.psd_m3[i] > peak) peak = psd.psd_m3[i], n_peak = psd.n_cpm[i];
  }
  EXPECT_NEAR(variance, 0.5 * 0.01 * 0.01, 0.001 * 0.5 * 0.01 * 0.01);
  EXPECT_NEAR(n_peak, 0.25, dn);
}

TEST(Psd, ShortSectionsHaveNone) {
  const std::vector<std::vector<double>> sections{std::vector<double>(200, 0.0)};
  EXPECT_EQ(road::displacement_psd(sections, kStep).segments, 0u);
  EXPECT_FALSE(road::fit_iso8608(road::displacement_psd(sections, kStep)));
}

TEST(Iso8608, KnownRoadsComeBackWithClassAndExponent) {
  const unsigned seeds = std::getenv("KERBSTONE_HEAVY") != nullptr ? 2 : 1;
  double worst = 0.0;
  for (const char c : {'A', 'B', 'C', 'D', 'E'}) {
    for (unsigned seed = 1; seed <= seeds; ++seed) {
      const std::vector<std::vector<double>> sections{
          random_road(class_mean(c), 2.0, 0.005, 4.0, 3000.0, seed),
          random_road(class_mean(c), 2.0, 0.005, 4.0, 3000.0, seed + 50)};
      const auto fit = road::fit_iso8608(road::displacement_psd(sections, kStep));
      ASSERT_TRUE(fit);
      EXPECT_EQ(fit->iso_class, c);
      EXPECT_NEAR(fit->exponent, 2.0, 0.1) << c << seed;
      EXPECT_FALSE(fit->band_cut);
      worst = std::max(worst, std::abs(fit->exponent - 2.0));
    }
  }
  RecordProperty("worst_exponent_error", std::to_string(worst));
}

TEST(Iso8608, AnotherExponentIsSeen) {
  const std::vector<std::vector<double>> sections{
      random_road(class_mean('C'), 2.5, 0.005, 4.0, 3000.0, 7)};
  const auto fit = road::fit_iso8608(road::displacement_psd(sections, kStep));
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->exponent, 2.5, 0.1);
}

TEST(Iso8608, ASpectrumThatEndsEarlyIsFittedUpToItsEnd) {
  for (const char c : {'B', 'C', 'D'}) {
    const std::vector<std::vector<double>> sections{
        random_road(class_mean(c), 2.0, 0.01, 0.5, 3000.0, 11)};
    const auto fit = road::fit_iso8608(road::displacement_psd(sections, kStep));
    ASSERT_TRUE(fit);
    EXPECT_TRUE(fit->band_cut);
    EXPECT_LT(fit->n_max_cpm, 0.5);
    EXPECT_GT(fit->n_max_cpm, 0.3);
    EXPECT_EQ(fit->iso_class, c);
    EXPECT_NEAR(fit->exponent, 2.0, 0.1) << c;
  }
}

TEST(QuarterCar, StepMatchesTheReferenceTable) {
  // World Bank Technical Paper 46, table of coefficients for dx = 250 mm.
  const double st[4][4] = {{0.9966071, 0.01091514, -0.002083274, 0.0003190145},
                           {-0.5563044, 0.9438768, -0.8324718, 0.05064701},
                           {0.02153176, 0.002126763, 0.7508714, 0.008221888},
                           {3.335013, 0.3376467, -39.12762, 0.4347564}};
  const double pr[4] = {0.005476107, 1.388776, 0.2275968, 35.79262};
  const road::QuarterCarStep step = road::quarter_car_step(0.25);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j)
      EXPECT_NEAR(step.transition[i][j], st[i][j], 2e-6 * std::max(1.0, std::abs(st[i][j])));
    EXPECT_NEAR(step.input[i], pr[i], 2e-6 * std::max(1.0, std::abs(pr[i])));
  }
}

TEST(Iri, FlatAndRampAreZero) {
  std::vector<double> flat(3001, 4.2), ramp;
  for (int i = 0; i <= 3000; ++i) ramp.push_back(0.07 * i * kStep);
  for (const auto& section : {flat, ramp}) {
    const auto segments = road::iri(section, kStep);
    ASSERT_EQ(segments.size(), 3u);
    for (const auto& segment : segments) EXPECT_NEAR(segment.iri_m_per_km, 0.0, 1e-9);
  }
  const auto segments = road::iri(ramp, kStep);
  EXPECT_DOUBLE_EQ(segments[1].begin_m, 100.0);
  EXPECT_DOUBLE_EQ(segments[2].end_m, 300.0);
}

/// Steady state of the quarter car over a sine, by complex amplitudes: mean |stroke slope| is 2/pi
/// times its amplitude; the moving base of 0.3 m (three steps of 0.1 m) takes off its share.
double iri_of_sine(double amplitude_m, double wavelength_m) {
  using C = std::complex<double>;
  const double w = kTurn * (80.0 / 3.6) / wavelength_m;
  const C s(0.0, w);
  const double k1 = 653.0, k2 = 63.3, c = 6.0, mu = 0.15;
  // zs (s^2 + c s + k2) = zu (c s + k2);  mu s^2 zu = (c s + k2)(zs - zu) + k1 (zp - zu)
  const C link = c * s + k2;
  const C zs_over_zu = link / (s * s + link);
  const C zu = k1 / (mu * s * s + k1 + link * (1.0 - zs_over_zu));
  const double stroke = std::abs(zu * (zs_over_zu - 1.0));
  const double base = std::numbers::pi * 0.3 / wavelength_m;
  return 1000.0 * (2.0 / std::numbers::pi) * stroke * amplitude_m * kTurn / wavelength_m *
         std::sin(base) / base;
}

TEST(Iri, SinesMatchTheSteadyStateWithinOnePercent) {
  for (const double wavelength_m : {2.0, 5.0, 10.0, 15.3, 25.0}) {
    std::vector<double> z;
    for (int i = 0; i <= 20000; ++i)
      z.push_back(0.005 * std::sin(kTurn * i * kStep / wavelength_m));
    const auto segments = road::iri(z, kStep);
    const double wanted = iri_of_sine(0.005, wavelength_m);
    // The first segments still hold the start; each other one is a whole number of waves only by
    // chance.
    double sum = 0.0;
    for (std::size_t k = 5; k < segments.size(); ++k) sum += segments[k].iri_m_per_km;
    EXPECT_NEAR(sum / static_cast<double>(segments.size() - 5) / wanted, 1.0, 0.01) << wavelength_m;
  }
}

TEST(Iri, AStepInSlopeMatchesAnIndependentIntegration) {
  // Ramp that begins after 50 m: fourth-order Runge-Kutta with 0.1 ms steps over the same base.
  std::vector<double> z;
  for (int i = 0; i <= 1000; ++i) z.push_back(std::max(0.0, (i - 500) * kStep * 0.02));
  const double v = 80.0 / 3.6, k1 = 653.0, k2 = 63.3, c = 6.0, mu = 0.15;
  std::array<double, 4> x{0, 0, 0, 0};
  const auto rate = [&](const std::array<double, 4>& y, double slope) {
    const double spring = k2 * (y[2] - y[0]) + c * (y[3] - y[1]);
    return std::array<double, 4>{y[1], spring, y[3], (-spring + k1 * (slope - y[2])) / mu};
  };
  const double t_step = kStep / v;
  double sum = 0.0;
  int steps = 0;
  for (int i = 0; i + 3 <= 1000; ++i, ++steps) {
    const double slope = (z[i + 3] - z[i]) / 0.3;
    const int parts = 45;
    const double h = t_step / parts;
    for (int p = 0; p < parts; ++p) {
      const auto add = [&](const std::array<double, 4>& k, double f) {
        std::array<double, 4> y = x;
        for (int j = 0; j < 4; ++j) y[j] += f * k[j];
        return y;
      };
      const auto a = rate(x, slope), b = rate(add(a, h / 2), slope), d = rate(add(b, h / 2), slope),
                 e = rate(add(d, h), slope);
      for (int j = 0; j < 4; ++j) x[j] += h / 6 * (a[j] + 2 * b[j] + 2 * d[j] + e[j]);
    }
    sum += std::abs(x[0] - x[2]);
  }
  const auto segments = road::iri(z, kStep);
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_NEAR(segments[0].iri_m_per_km / (1000.0 * sum / steps), 1.0, 1e-6);
}

TEST(Iri, MissingHeightsLeaveTheSegmentEmpty) {
  std::vector<double> z(3001, 0.0);
  for (int i = 1200; i < 1500; ++i) z[static_cast<std::size_t>(i)] = std::nan("");
  const auto segments = road::iri(z, kStep);
  EXPECT_EQ(segments[0].iri_m_per_km, 0.0);
  EXPECT_TRUE(std::isnan(segments[1].iri_m_per_km));
  EXPECT_EQ(segments[2].iri_m_per_km, 0.0);
}

TEST(Facets, ChordsOfAHillAreFoundWithTheirLength) {
  std::vector<double> z;
  const auto hill = [](double u) { return 5.0 * std::sin(kTurn * u / 400.0); };
  for (int i = 0; i <= 20000; ++i) {
    const double u = i * kStep, low = std::floor(u / 10.0) * 10.0, t = (u - low) / 10.0;
    z.push_back(static_cast<float>((1.0 - t) * hill(low) + t * hill(low + 10.0)));
  }
  const auto spacing = road::facet_spacing(z, kStep);
  ASSERT_TRUE(spacing);
  EXPECT_NEAR(spacing->median_m, 10.0, 0.11);
}

// A wheel crosses the corners of triangles where two edges lie 0.3 m apart.
TEST(Facets, EdgesSideBySideAreNotTheFacets) {
  std::vector<double> z;
  for (int i = 0; i <= 20000; ++i) {
    const double u = i * kStep, k = std::floor(u / 5.0), t = u - 5.0 * k;
    const double slope = 0.01 * std::sin(7.0 * k * k);
    z.push_back(static_cast<float>(t < 0.3 ? -0.5 * slope * t : slope * (t - 0.45)));
  }
  const auto spacing = road::facet_spacing(z, kStep);
  ASSERT_TRUE(spacing);
  EXPECT_NEAR(spacing->median_m, 4.7, 0.21);
}

TEST(Facets, ARoughRoadHasNone) {
  EXPECT_FALSE(road::facet_spacing(random_road(class_mean('C'), 2.0, 0.01, 4.0, 1000.0, 3), kStep));
  std::vector<double> flat(5000, 1.0);
  EXPECT_FALSE(road::facet_spacing(flat, kStep));
}

}  // namespace roughness_test
