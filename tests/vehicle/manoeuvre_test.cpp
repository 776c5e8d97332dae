#include "vehicle/manoeuvre.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "base/json_text.h"
#include "support/places.h"
#include "test_car.h"
#include "vehicle/driver.h"
#include "vehicle/error.h"
#include "vehicle/vehicle_file.h"

namespace manoeuvre_test {

using namespace vehicle;  // NOLINT: a test of this library

const Vehicle& racer() {
  static const Vehicle v = read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
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

// A car has the gears whose ratios are not zero, also near its limiter.
TEST(Manoeuvre, ChoosesAGearThatTheCarHas) {
  const CarFiles files = test_car_files();
  Parameters<double> p = default_parameters();
  for (const Parameter ratio :
       {Parameter::gearbox_ratio_2, Parameter::gearbox_ratio_3, Parameter::gearbox_ratio_4,
        Parameter::gearbox_ratio_5, Parameter::gearbox_ratio_6})
    p[ratio] = 0.0;
  const Car<double> car = make_car(files, p, default_amplitudes());
  for (double vx_mps = 0.0; vx_mps < 60.0; vx_mps += 0.5)
    for (int gear = 1; gear <= 6; ++gear)
      EXPECT_EQ(choose_gear(car, vx_mps, gear), 1) << vx_mps << " m/s from " << gear;
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

// Somebody listens on a port: every row arrives as JSON, no faster than the clock allows.
TEST(Manoeuvre, CanBeWatchedLive) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  ASSERT_GE(socket, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::bind(socket, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  socklen_t length = sizeof address;
  ASSERT_EQ(::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length), 0);
  const std::string car = " --car " + places::source() + "/vehicles/open_wheel/vehicle.yaml";
  const auto begin = std::chrono::steady_clock::now();
  const int code = std::system((places::crgdrive() + " manoeuvre step-steer" + car +
                                " --stop-s 2 --rate-hz 20 --speed-up 4 --udp 127.0.0.1:" +
                                std::to_string(ntohs(address.sin_port)) + " >/dev/null")
                                   .c_str());
  EXPECT_EQ(code, 0);
  EXPECT_GT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(480));
  std::size_t rows = 0;
  double last_s = -1.0;
  char bytes[65536];
  for (;;) {
    const ssize_t size = ::recv(socket, bytes, sizeof bytes, MSG_DONTWAIT);
    if (size < 0) break;
    const auto row = base::parse_json<nlohmann::json>({bytes, static_cast<std::size_t>(size)});
    EXPECT_GT(row["time_s"].get<double>(), last_s);
    last_s = row["time_s"].get<double>();
    EXPECT_TRUE(row.contains("yaw_rate_radps"));
    ++rows;
  }
  ::close(socket);
  EXPECT_EQ(rows, 40u);
  EXPECT_NE(std::system(
                (places::crgdrive() + " manoeuvre braking" + car + " --udp nowhere >/dev/null 2>&1")
                    .c_str()),
            0);
}

}  // namespace manoeuvre_test
