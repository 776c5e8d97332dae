#include "vehicle/manoeuvre.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "vehicle/error.h"
#include "vehicle/vehicle_file.h"

namespace {

using namespace vehicle;  // NOLINT: a test of this library

const Vehicle& racer() {
  static const Vehicle v =
      read_vehicle(std::string(KERBSTONE_SOURCE) + "/vehicles/open_wheel/vehicle.yaml");
  return v;
}

ManoeuvreResult run(ManoeuvreKind kind, Manoeuvre m = {}) {
  m.kind = kind;
  const Car<double> car = make_car(racer().files, racer().parameters, racer().terms);
  ManoeuvreResult r = run_manoeuvre(car, m);
  EXPECT_TRUE(r.complete) << r.problem;
  return r;
}

TEST(Manoeuvre, IsKnownByItsName) {
  EXPECT_EQ(manoeuvre_named("kerb"), ManoeuvreKind::kKerb);
  EXPECT_THROW(manoeuvre_named("drift"), Error);
}

TEST(Manoeuvre, TurnsTheWayItSteers) {
  Manoeuvre right;
  right.steer_rad = -0.02;
  const ManoeuvreResult r = run(ManoeuvreKind::kStepSteer, right);
  EXPECT_LT(r.telemetry.find("yaw_rate_radps")->back(), -0.1);
  EXPECT_NEAR((*r.telemetry.find("yaw_rate_radps"))[900], 0.0, 0.01);
  EXPECT_NEAR(r.end_mps, 30.0, 2.0);
}

TEST(Manoeuvre, SwingsWithSineAndChirp) {
  for (const ManoeuvreKind kind : {ManoeuvreKind::kSine, ManoeuvreKind::kChirp}) {
    const ManoeuvreResult r = run(kind);
    const auto& yaw = *r.telemetry.find("yaw_rate_radps");
    EXPECT_GT(*std::max_element(yaw.begin(), yaw.end()), 0.1);
    EXPECT_LT(*std::min_element(yaw.begin(), yaw.end()), -0.1);
  }
}

TEST(Manoeuvre, CornersHarderOnTheRampThanTheTyresAloneAllow) {
  Manoeuvre slow;
  slow.steer_rad = 0.12;
  slow.duration_s = 15.0;
  const ManoeuvreResult r = run(ManoeuvreKind::kRamp, slow);
  EXPECT_GT(r.peak_ay_mps2, 13.0);
  EXPECT_LT(r.peak_ay_mps2, 25.0);
}

TEST(Manoeuvre, StopsInTheDistanceOfItsGripOrItsBrakes) {
  const ManoeuvreResult r = run(ManoeuvreKind::kBraking);
  EXPECT_GT(r.stop_m, 0.5 * 30.0 * 30.0 / 20.0);
  EXPECT_LT(r.stop_m, 0.5 * 30.0 * 30.0 / 7.0);
  const ManoeuvreResult coast = run(ManoeuvreKind::kCoastDown);
  EXPECT_GT(coast.end_mps, 24.0);
  EXPECT_LT(coast.end_mps, 30.0);
}

TEST(Manoeuvre, FeelsKerbAndBump) {
  const ManoeuvreResult flat = run(ManoeuvreKind::kCoastDown);
  EXPECT_GT(run(ManoeuvreKind::kKerb).peak_fz_n, 1.3 * flat.peak_fz_n);
  EXPECT_GT(run(ManoeuvreKind::kBump).peak_fz_n, 1.3 * flat.peak_fz_n);
}

TEST(Manoeuvre, PullsToTheSideWithGrip) {
  Manoeuvre brief;
  brief.duration_s = 2.0;
  const ManoeuvreResult r = run(ManoeuvreKind::kSplitFriction, brief);
  EXPECT_LT((*r.telemetry.find("yaw_rate_radps"))[1300], -0.02);  // to the right, where the grip is
}

}  // namespace
