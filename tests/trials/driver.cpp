#include "driver.h"

#include <algorithm>
#include <numbers>

namespace trials {
namespace {

constexpr double kPi = std::numbers::pi;

/// Speed over the track from what grip, drive and brakes allow, at a pace.
std::vector<double> plan(const Track& t, double pace, double drive) {
  const std::size_t n = t.x.size();
  std::vector<double> v;
  for (std::size_t i = 0; i < n; ++i)
    v.push_back(
        std::min(62.0, std::sqrt(13.5 * pace * pace / std::max(1e-4, std::abs(t.curvature[i])))));
  for (int round = 0; round < 2; ++round) {
    for (std::size_t k = 0; k < 2 * n; ++k) {
      const std::size_t i = k % n, j = (i + 1) % n;
      v[j] = std::min(v[j], std::sqrt(v[i] * v[i] + 2 * 4.5 * drive * pace * t.step_m *
                                                        std::max(0.1, 1 - v[i] / 75)));
    }
    for (std::size_t k = 2 * n; k-- > 0;) {
      const std::size_t i = k % n, j = (i + 1) % n;
      v[i] = std::min(v[i], std::sqrt(v[j] * v[j] + 2 * 9.5 * pace * t.step_m));
    }
  }
  return v;
}

/// Towards a point of his line ahead of him.
void steer(Driver& driver, const Style& style, const TruthCar& car, const Track& track,
           const State& x, double s) {
  const double preview = 6 + 0.45 * x[3];
  const Track::Point p = track.at(s + preview);
  const double offset =
      driver.sway_m *
      std::sin(2 * kPi * style.sway_waves * (s + preview) / track.length_m + driver.sway_rad);
  const double tx = p.x - offset * std::sin(p.heading), ty = p.y + offset * std::cos(p.heading);
  const double angle = std::remainder(std::atan2(ty - x[1], tx - x[0]) - x[2], 2 * kPi);
  const double curvature = 2 * std::sin(angle) / preview;
  const double wanted =
      curvature * (car.a + car.b + 0.0012 * x[3] * x[3]) - 0.05 * (x[5] - curvature * x[3]);
  driver.now.steer += std::clamp(std::clamp(wanted, -0.25, 0.25) - driver.now.steer, -0.006, 0.006);
}

/// Towards the planned speed.
void use_pedals(Driver& driver, const Track& track, const State& x, double s) {
  const auto planned = [&](double at) {
    const auto i = static_cast<std::size_t>(std::fmod(at, track.length_m) / track.step_m);
    return driver.speed_mps[std::min(i, driver.speed_mps.size() - 1)];
  };
  const double near = planned(s + 0.15 * x[3]), ahead = planned(s + 0.25 * x[3]),
               far = planned(s + 0.35 * x[3]);
  const double feed = (far * far - near * near) / (2 * 0.2 * x[3]);
  const double error = ahead - x[3];
  driver.integral = std::clamp(driver.integral + 0.0008 * error, -0.4, 0.4);
  const double acceleration = feed + 1.4 * error + 0.6 + 0.0007 * x[3] * x[3];
  double throttle = acceleration > 0 ? acceleration / 9.0 * (0.4 + x[3] / 60) + driver.integral : 0;
  double pressure = acceleration < -0.8 ? -(acceleration + 0.8) * 1.95e5 * 1.6 : 0;
  throttle = std::clamp(throttle, 0.0, 1.0);
  pressure = std::clamp(pressure, 0.0, 3.2e6);
  driver.now.throttle += std::clamp(throttle - driver.now.throttle, -0.06, 0.025);
  driver.now.brake_pa += std::clamp(pressure - driver.now.brake_pa, -2.5e5, 1.2e5);
}

void choose_gear(Driver& driver, const TruthCar& car, const State& x) {
  if (car.electric) {
    driver.now.gear = 1;
    return;
  }
  const double omega = x[3] / car.radius_r * car.final_drive;
  int gear = std::max(1, driver.now.gear);
  if (gear < 6 && omega * car.ratio[static_cast<std::size_t>(gear - 1)] > 790)
    ++gear;
  else if (gear > 1 && omega * car.ratio[static_cast<std::size_t>(gear - 2)] < 640)
    --gear;
  if (gear != driver.now.gear && driver.now.gear > 0) driver.between_gears_s = 0.06;
  driver.now.gear = gear;
}

}  // namespace

void act(Driver& driver, const Style& style, const TruthCar& car, const Track& track,
         const State& state, double s_m, long step) {
  const int lap = static_cast<int>(std::floor(s_m / track.length_m));
  if (lap != driver.lap) {
    driver.lap = lap;
    const double pace = driver.dice.in(style.pace_low, style.pace_high);
    driver.sway_m = driver.dice.in(-style.sway_m, style.sway_m);
    driver.sway_rad = driver.dice.in(0, 6);
    driver.speed_mps = plan(track, lap == 0 ? style.first_pace : pace, style.drive);
  }
  driver.now.steer -= driver.weave_rad;  // he holds his line beside it
  if (step % 5 == 0) {
    steer(driver, style, car, track, state, s_m);
    use_pedals(driver, track, state, s_m);
    choose_gear(driver, car, state);
  }
  if (style.weave_rad > 0) {
    const double t = std::fmod(static_cast<double>(step) * 0.001, 20.0);
    driver.weave_rad =
        style.weave_rad * std::sin(2 * kPi *
                                   (style.weave_from_hz * t +
                                    (style.weave_to_hz - style.weave_from_hz) * t * t / 40.0));
  }
  driver.now.steer += driver.weave_rad;
  if (driver.between_gears_s > 0) driver.between_gears_s -= 0.001;
}

}  // namespace trials
