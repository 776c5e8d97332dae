#include "road/reckon.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <complex>

#include "driven_lap.h"
#include "mesh/error.h"

namespace road {
namespace reckon_test {

using ::testing::HasSubstr;

/// Largest distance once the places are turned and shifted onto the true ones.
double farthest_m(const ReckonedPlaces& places, const DrivenLap& drive) {
  std::complex<double> mean_p = 0, mean_q = 0, turn = 0;
  double n = 0;
  const auto each = [&](const auto& at) {
    for (std::size_t i = 0; i < drive.x_m.size(); ++i)
      if (std::isfinite(places.x_m[i]))
        at(std::complex<double>(places.x_m[i], places.y_m[i]),
           std::complex<double>(drive.x_m[i], drive.y_m[i]));
  };
  each([&](auto p, auto q) { mean_p += p, mean_q += q, n += 1; });
  mean_p /= n, mean_q /= n;
  each([&](auto p, auto q) { turn += std::conj(p - mean_p) * (q - mean_q); });
  double out = 0;
  each([&](auto p, auto q) {
    out = std::max(out, std::abs((p - mean_p) * turn / std::abs(turn) - (q - mean_q)));
  });
  return out;
}

TEST(Reckon, ClosesLapsThatABiasLeavesOpen) {
  DrivenLap drive = drive_round(3.4);
  constexpr double kBias_radps = 0.002;
  for (double& r : drive.yaw_rate_radps) r += kBias_radps;
  const ReckonedPlaces places =
      reckon_places("log", drive.time_s, drive.vx_mps, drive.yaw_rate_radps);
  EXPECT_GE(places.laps, 2u);
  EXPECT_NEAR(places.lap_m, drive.lap_m, 2.0);
  EXPECT_NEAR(places.turn_rad, kBias_radps * drive.lap_s, 0.01);
  EXPECT_GT(std::count_if(places.x_m.begin(), places.x_m.end(),
                          [](double x) { return std::isfinite(x); }),
            static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(drive.x_m.size())));
  EXPECT_LT(farthest_m(places, drive), 2.0);
}

TEST(Reckon, ACarThatSlipsGoesBesideItsNose) {
  DrivenLap drive = drive_round(2.4);
  // The nose points up to 5 degrees off the way that the car goes.
  std::vector<double> vy_mps;
  for (std::size_t i = 0; i < drive.time_s.size(); ++i) {
    const double slow = 0.7, t = drive.time_s[i], slip = 0.09 * std::sin(slow * t);
    vy_mps.push_back(drive.vx_mps[i] * std::sin(slip));
    drive.vx_mps[i] *= std::cos(slip);
    drive.yaw_rate_radps[i] -= 0.09 * slow * std::cos(slow * t);
  }
  const auto places = [&](const std::vector<double>& left) {
    return reckon_places("log", drive.time_s, drive.vx_mps, drive.yaw_rate_radps, left);
  };
  EXPECT_LT(farthest_m(places(vy_mps), drive), 1.0);
  EXPECT_GT(farthest_m(places({}), drive), 2.0);
}

TEST(Reckon, LeavesAWayOpenThatIsDrivenOnce) {
  const DrivenLap drive = drive_round(0.6);
  const ReckonedPlaces places =
      reckon_places("log", drive.time_s, drive.vx_mps, drive.yaw_rate_radps);
  EXPECT_EQ(places.laps, 0u);
  EXPECT_LT(farthest_m(places, drive), 0.5);
}

TEST(Reckon, RefusesWhatIsNoDrive) {
  const auto message = [](const std::vector<double>& v, const std::vector<double>& r) {
    std::vector<double> t;
    for (std::size_t i = 0; i < v.size(); ++i) t.push_back(0.05 * static_cast<double>(i));
    try {
      reckon_places("some.csv", t, v, r);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::vector<double> still(200, 0.0), few(20, 10.0);
  EXPECT_THAT(message(few, few), HasSubstr("some.csv: 20 rows"));
  EXPECT_THAT(message(still, still), HasSubstr("wanted a drive"));
}

}  // namespace reckon_test
}  // namespace road
