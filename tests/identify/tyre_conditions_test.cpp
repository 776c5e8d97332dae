#include <gtest/gtest.h>

#include <cmath>

#include "identify/tyre_fit.h"
#include "support/places.h"
#include "vehicle/tyre_file.h"

namespace tyre_conditions_test {

using identify::SlipKind;

vehicle::TyreCoefficients racer() {
  return vehicle::read_tyre(places::source() + "/vehicles/open_wheel/front.tir").coefficients;
}

/// Side slip up to `most_rad` at the nominal load, exact forces.
identify::TyreSamples swept(double most_rad, const vehicle::TyreCoefficients& tyre = racer()) {
  identify::TyreSamples out;
  for (int i = -50; i <= 50; ++i) {
    out.conditions.push_back({tyre.nominal_load_n, 0.0, std::tan(most_rad * i / 50.0), 0.0,
                              tyre.nominal_speed_mps, 0.0});
    const auto force = vehicle::tyre_forces(tyre, out.conditions.back());
    out.fx_n.push_back(NAN);
    out.fy_n.push_back(force.fy_n);
  }
  return out;
}

identify::TyreConditions conditions_of(const identify::TyreSamples& samples,
                                       const vehicle::TyreCoefficients& reference = racer()) {
  identify::TyreFitOptions options;
  options.starts = 2;
  return identify::tyre_conditions(identify::fit_tyre(samples, reference, options), samples);
}

TEST(TyreConditions, APeakThatWasNotReachedIsSaidToBe) {
  const auto far = conditions_of(swept(0.25)), near = conditions_of(swept(0.04));
  ASSERT_EQ(far.peaks.size(), 1u);
  EXPECT_TRUE(far.peaks[0].reached);
  EXPECT_NEAR(far.peaks[0].peak_n, 1.7 * 3500.0, 0.01 * 1.7 * 3500.0);
  ASSERT_EQ(near.peaks.size(), 1u);
  EXPECT_FALSE(near.peaks[0].reached);
  EXPECT_NEAR(near.peaks[0].measured_slip, 0.04, 0.001);
  EXPECT_GT(near.peaks[0].sd_n, 5.0 * far.peaks[0].sd_n);
}

TEST(TyreConditions, ACurveThatOnlyRisesHasNoPeak) {
  vehicle::TyreCoefficients rising = racer();
  rising.pcy1 = 1.0;
  rising.pey1 = rising.pey2 = rising.pey3 = 0.0;
  const auto found = conditions_of(swept(0.65, rising), rising);  // to a slip of 0.76
  ASSERT_EQ(found.peaks.size(), 1u);
  EXPECT_GT(found.peaks[0].measured_slip, 0.7);
  EXPECT_EQ(found.peaks[0].peak_slip, identify::kMostSlip);
  EXPECT_FALSE(found.peaks[0].reached);
}

TEST(TyreConditions, EveryRowIsInOneCellAndTheNextIsWhereNoneWas) {
  const auto samples = swept(0.04);
  const auto found = conditions_of(samples);
  std::size_t rows = 0;
  for (const auto& cell : found.cells) {
    rows += cell.rows;
    if (cell.rows > 0) {
      EXPECT_EQ(cell.kind, SlipKind::kLateral);
      EXPECT_EQ(cell.load, 2u);
      EXPECT_EQ(cell.camber, 2u);
    }
  }
  EXPECT_EQ(rows, samples.rows());
  // Side forces are exact, longitudinal ones were not measured.
  for (const auto& cell : found.cells) {
    EXPECT_TRUE(std::isnan(cell.fx_left_n));
    EXPECT_EQ(std::isnan(cell.fy_left_n), cell.rows == 0);
    if (cell.rows > 0) {
      EXPECT_LT(cell.fy_left_n, 5.0);
    }
  }
  EXPECT_EQ(found.next.kind, SlipKind::kLateral);
  EXPECT_GT(std::abs(found.next.condition.tan_alpha), 0.06);
}

}  // namespace tyre_conditions_test
