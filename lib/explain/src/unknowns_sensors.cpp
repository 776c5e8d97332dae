// Errors of sensors: whatever a redundant relation sees.
#include <fmt/format.h>

#include <functional>
#include <string>
#include <utility>

#include "late_actuator.h"
#include "unknowns_listing.h"

namespace explain {
namespace {

using Set = std::function<void(Setting&, double)>;

Unknown& of_channel(const Listing& l, Channel c, const char* id, const Amount& amount,
                    const char* equation, Set set) {
  Unknown& u = candidate(
      l, id, amount,
      {fmt::format("the column {} carries an error of its own; other channels with the same "
                   "physics do not show it",
                   column(l, c)),
       equation, "drive the same laps with a second, independent sensor of this quantity"},
      std::move(set));
  u.channel = column(l, c);
  return u;
}

void bias(const Listing& l, Channel c, const char* unit, double step, double least) {
  of_channel(l, c, "sensor.bias", {"bias", unit, step, least}, "logged = true + bias",
             [c](Setting& s, double v) { s.sensor[c].bias += v; });
}

void gain(const Listing& l, Channel c, double least) {
  of_channel(l, c, "sensor.gain", {"gain error", "1", 0.01, least},
             "logged = (1 + gain error) * true",
             [c](Setting& s, double v) { s.sensor[c].gain += v; });
}

void timing(const Listing& l, Channel c, double least_s) {
  const char* const separating =
      "swing the quantity ever faster, for steering 0.5 to 2 Hz: a delay keeps the amplitude, a "
      "filter does not";
  of_channel(l, c, "sensor.delay", {"delay", "s", 0.02, least_s, true},
             "logged(t) = true(t - delay)", [c](Setting& s, double v) { s.sensor[c].delay_s += v; })
      .separating = separating;
  of_channel(l, c, "sensor.low_pass", {"time constant", "s", 0.05, least_s, true},
             "T d(logged)/dt = true - logged",
             [c](Setting& s, double v) { s.sensor[c].low_pass_s += v; })
      .separating = separating;
}

// Smaller amounts are not worth a finding.
struct Least {
  double bias, gain = 0.007, time_s = 0.0015;
};

void all_errors(const Listing& l, Channel c, const char* unit, double bias_step,
                const Least& least) {
  bias(l, c, unit, bias_step, least.bias);
  gain(l, c, least.gain);
  timing(l, c, least.time_s);
}

void motion(const Listing& l) {
  if (has(l, kYawRate)) all_errors(l, kYawRate, "rad/s", 0.005, {.bias = 0.0015});
  if (has(l, kAx)) all_errors(l, kAx, "m/s2", 0.1, {.bias = 0.04});
  if (has(l, kAy) && has(l, kVy)) all_errors(l, kAy, "m/s2", 0.1, {.bias = 0.04});
  if (has(l, kYaw)) bias(l, kYaw, "rad", 0.005, 0.002);
  if (has(l, kVy)) bias(l, kVy, "m/s", 0.05, 0.03);
  if (has(l, kVy) && has(l, kYawRate))
    of_channel(l, kVy, "sensor.lever_arm", {"ahead of the centre of mass", "m", 0.3, 0.1},
               "logged = vy + l r", [](Setting& s, double v) { s.vy_ahead += v; })
        .separating = "measure where it is mounted";
  if (has(l, kAx))
    of_channel(l, kAx, "sensor.derived", {"share", "1", 0.2, 0.6, true},
               "logged = dvx/dt, not what an accelerometer feels",
               [](Setting& s, double v) { s.derived_ax += v; })
        .separating = "log the accelerometer itself, or stand on a slope";
  // Slip has to build up before a wheel follows the car, and the road wheel before the tyre.
  all_errors(l, kVx, "m/s", 0.1, {.bias = 0.08, .time_s = 0.015});
  if (has(l, kWheelFront)) timing(l, kWheelFront, 0.02);
}

void driver(const Listing& l) {
  if (l.lateral && !commanded(l.logs, kSteer))
    all_errors(l, kSteer, "rad", 0.002, {.bias = 0.002, .gain = 0.06, .time_s = 0.05});
  if (l.brake && l.engine && !commanded(l.logs, kBrakeFront))
    candidate(l, "sensor.delay", {"delay", "s", 0.02, 0.01, true},
              {"the brake pressure is logged late", "logged(t) = true(t - delay)", ""},
              [](Setting& s, double v) {
                // Both circuits have one clock.
                s.sensor[kBrakeFront].delay_s += v;
                s.sensor[kBrakeRear].delay_s += v;
              })
        .channel = column(l, kBrakeFront);
}

void accelerometer_mounting(const Listing& l) {
  if (!has(l, kAx)) untestable(l, {"sensor.bias", "sensor.derived"}, "of ax: not logged");
  if (!has(l, kAy) || !has(l, kVy))
    untestable(l, {"sensor.bias"}, "of ay: ay or the lateral speed is not logged");
  if (!has(l, kAx) || !has(l, kAy) || !has(l, kVy)) {
    untestable(l, {"sensor.misalignment", "sensor.lever_arm"},
               "needs ax, ay and the lateral speed");
    return;
  }
  const std::string columns = column(l, kAx) + "," + column(l, kAy);
  candidate(l, "sensor.misalignment", {"angle", "rad", 0.01, 0.005},
            {"the accelerometer is turned about the vertical against the car",
             "ax, ay logged = true ax, ay turned by -angle",
             "park the car on a known slope, twice, turned by 90 degrees"},
            [](Setting& s, double v) { s.imu_yaw += v; })
      .channel = columns;
  candidate(l, "sensor.lever_arm", {"ahead of the centre of mass", "m", 0.3, 0.15},
            {"the accelerometer does not sit in the centre of mass",
             "ay logged = ay + l dr/dt, ax logged = ax - l r^2", "measure where it is mounted"},
            [](Setting& s, double v) { s.imu_ahead += v; })
      .channel = columns;
}

}  // namespace

void list_sensors(const Listing& l) {
  motion(l);
  driver(l);
  accelerometer_mounting(l);
}

}  // namespace explain
