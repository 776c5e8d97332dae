#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "identify/tyre_fit.h"
#include "support/places.h"
#include "vehicle/tyre_file.h"

namespace tyre_scan_test {

using vehicle::TyreCoefficients;

TyreCoefficients racer() {
  return vehicle::read_tyre(places::source() + "/vehicles/open_wheel/front.tir").coefficients;
}

const identify::TyreRange kRange{1000.0, 6000.0, -0.05, 0.05};

std::string first(const TyreCoefficients& tyre) {
  const auto faults = identify::scan_tyre(tyre, kRange);
  return faults.empty() ? "" : faults.front().what;
}

TEST(TyreScan, ATyreHasNoFault) {
  EXPECT_EQ(first(racer()), "");
  TyreCoefficients other_sign = racer();
  other_sign.pky1 *= -1.0;
  EXPECT_EQ(first(other_sign), "");
}

TEST(TyreScan, WhatNoTyreDoesIsFound) {
  TyreCoefficients tyre = racer();
  tyre.pdy2 = -2.5;  // friction gone at 1.7 nominal loads
  EXPECT_EQ(first(tyre), "friction is not above zero");
  EXPECT_GT(identify::scan_tyre(tyre, kRange).front().fz_n, 4000.0);
  tyre = racer();
  tyre.pky4 = 5.0;  // sin of more than pi
  EXPECT_EQ(first(tyre), "cornering stiffness turns its sign");
  tyre = racer();
  tyre.pkx2 = -80.0;
  EXPECT_EQ(first(tyre), "slip stiffness is not above zero");
  tyre = racer();
  tyre.pcx1 = 2.6;
  EXPECT_THAT(first(tyre),
              ::testing::HasSubstr("longitudinal force turns its sign behind its peak"));
}

}  // namespace tyre_scan_test
