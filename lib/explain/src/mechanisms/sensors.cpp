// Errors of sensors: whatever a redundant relation sees.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <string>
#include <utility>

#include "listing.h"
#include "mapping_changes.h"

namespace explain::sensors {
namespace {

using Set = std::function<void(Setting&, double)>;

// Of lists of columns, "ax,ay".
bool names_column(const std::string& list, const std::string& column) {
  return ("," + list + ",").find("," + column + ",") != std::string::npos;
}

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
  of_channel(l, c, kSensorBias, {"bias", unit, step, least}, "logged = true + bias",
             [c](Setting& s, double v) { s.sensor[c].bias += v; });
}

void gain(const Listing& l, Channel c, double least) {
  of_channel(l, c, kSensorGain, {"gain error", "1", 0.01, least},
             "logged = (1 + gain error) * true",
             [c](Setting& s, double v) { s.sensor[c].gain += v; });
}

void timing(const Listing& l, Channel c, double least_s) {
  const char* const separating =
      "swing the quantity ever faster, for steering 0.5 to 2 Hz: a delay keeps the amplitude, a "
      "filter does not";
  const auto late = [&](Unknown& u) {
    u.separating = separating;
    u.in_time = true;
  };
  late(of_channel(l, c, kSensorDelay, {"delay", "s", 0.02, least_s, true},
                  "logged(t) = true(t - delay)",
                  [c](Setting& s, double v) { s.sensor[c].delay_s += v; }));
  late(of_channel(l, c, kSensorLowPass, {"time constant", "s", 0.05, least_s, true},
                  "T d(logged)/dt = true - logged",
                  [c](Setting& s, double v) { s.sensor[c].low_pass_s += v; }));
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

void list_motion(const Listing& l) {
  const std::size_t before = l.out.unknowns.size();
  if (has(l, kYawRate)) all_errors(l, kYawRate, "rad/s", 0.005, {.bias = 0.0015});
  if (has(l, kAx)) all_errors(l, kAx, "m/s2", 0.1, {.bias = 0.04});
  if (has(l, kAy) && has(l, kVy)) all_errors(l, kAy, "m/s2", 0.1, {.bias = 0.04});
  if (has(l, kYaw)) bias(l, kYaw, "rad", 0.005, 0.002);
  if (has(l, kVy)) bias(l, kVy, "m/s", 0.05, 0.03);
  if (has(l, kVy) && has(l, kYawRate))
    of_channel(l, kVy, kSensorLeverArm, {"ahead of the centre of mass", "m", 0.3, 0.1},
               "logged = vy + l r", [](Setting& s, double v) { s.vy_ahead += v; })
        .separating = "measure where it is mounted";
  if (has(l, kVy) && has(l, kYaw)) {
    Unknown& antenna =
        of_channel(l, kX, kSensorLeverArm, {"ahead of the centre of mass", "m", 0.5, 0.3},
                   "logged = place + l ahead", [](Setting& s, double v) { s.place_ahead += v; });
    antenna.channel = column(l, kX) + "," + column(l, kY);
    antenna.separating = "measure where the antenna is mounted";
  }
  if (has(l, kAx))
    of_channel(l, kAx, "sensor.derived", {"share", "1", 0.2, 0.6, true},
               "logged = dvx/dt, not what an accelerometer feels",
               [](Setting& s, double v) { s.derived_ax += v; })
        .separating = "log the accelerometer itself, or stand on a slope";
  // Slip has to build up before a wheel follows the car, and the road wheel before the tyre.
  all_errors(l, kVx, "m/s", 0.1, {.bias = 0.08, .time_s = 0.015});
  if (has(l, kWheelFront)) timing(l, kWheelFront, 0.02);
  for (std::size_t k = before; k < l.out.unknowns.size(); ++k) l.out.unknowns[k].of_motion = true;
}

void list_driver(const Listing& l) {
  if (l.lateral && !commanded(l.logs, kSteer))
    all_errors(l, kSteer, "rad", 0.002, {.bias = 0.002, .gain = 0.06, .time_s = 0.05});
  if (l.brake && l.engine && !commanded(l.logs, kBrakeFront))
    candidate(l, kSensorDelay, {"delay", "s", 0.02, 0.01, true},
              {"the brake pressure is logged late", "logged(t) = true(t - delay)", ""},
              [](Setting& s, double v) {
                // All pressures have one clock.
                for (const Channel c : {kBrakeFront, kBrakeRear, kBrakeFrontApart, kBrakeRearApart})
                  s.sensor[c].delay_s += v;
              })
        .channel = column(l, kBrakeFront);
}

void list_mounting(const Listing& l) {
  if (!has(l, kAx))
    for (const char* id : {kSensorBias, "sensor.derived"}) untestable(l, id, "of ax: not logged");
  if (!has(l, kAy) || !has(l, kVy))
    untestable(l, kSensorBias, "of ay: ay or the lateral speed is not logged");
  if (!has(l, kAx) || !has(l, kAy) || !has(l, kVy)) {
    for (const char* id : {"sensor.misalignment", kSensorLeverArm})
      untestable(l, id, "needs ax, ay and the lateral speed");
    return;
  }
  const std::string columns = column(l, kAx) + "," + column(l, kAy);
  candidate(l, "sensor.misalignment", {"angle", "rad", 0.01, 0.005},
            {"the accelerometer is turned about the vertical against the car",
             "ax, ay logged = true ax, ay turned by -angle",
             "park the car on a known slope, twice, turned by 90 degrees"},
            [](Setting& s, double v) { s.imu_yaw += v; })
      .channel = columns;
  candidate(l, kSensorLeverArm, {"ahead of the centre of mass", "m", 0.3, 0.15},
            {"the accelerometer does not sit in the centre of mass",
             "ay logged = ay + l dr/dt, ax logged = ax - l r^2", "measure where it is mounted"},
            [](Setting& s, double v) { s.imu_ahead += v; })
      .channel = columns;
}

/// Only of sensors that feel the road; the others say when and where: shifted all at once they
/// would shift it. How late yaw rate is, heading or path tell. Of accelerations nothing else tells
/// it: a driver does the same at the same place, so that any delay of theirs could be slopes of the
/// road.
UsualError usual_error(const Unknown& u, const Signals& s) {
  const auto of = [&](Channel c) { return s.present[c] && names_column(u.channel, s.column[c]); };
  constexpr double kTime_s = 0.5;
  if (of(kYawRate) && u.in_time) return {kTime_s, kTime_s};
  if (!of(kYawRate) && !of(kAx) && !of(kAy) && !of(kAz)) return {};
  if (u.in_time) return {0.0, kTime_s};
  if (u.id == "sensor.derived") return {0.0, 1.0};
  return {0.5 * u.least, 5 * u.step};
}

/// Channel by channel: the errors that each may have.
void list(const Listing& l) {
  const std::size_t first = l.out.unknowns.size();
  list_motion(l);
  list_driver(l);
  list_mounting(l);
  for (std::size_t k = first; k < l.out.unknowns.size(); ++k)
    l.out.unknowns[k].beside_road = usual_error(l.out.unknowns[k], l.logs.front());
}

/// Calls change(column) for every column that the finding names; one about the mean of two names
/// both.
template <class Change>
void in_columns(MappingChanges& out, const Finding& f, Change change) {
  for (ColumnMapping& m : out.mapping.columns)
    if (names_column(f.channel, m.column)) change(m), out.changed = true;
}

void write_bias(MappingChanges& out, const Finding& f) {
  in_columns(out, f, [&](ColumnMapping& m) { m.offset -= f.parameters[0].value; });
}

void write_gain(MappingChanges& out, const Finding& f) {
  const double value = f.parameters[0].value;
  in_columns(out, f, [&](ColumnMapping& m) { m.scale /= 1 + value, m.offset /= 1 + value; });
}

void write_delay(MappingChanges& out, const Finding& f) {
  in_columns(out, f, [&](ColumnMapping& m) { m.delay_s += f.parameters[0].value; });
}

void write_low_pass(MappingChanges& out, const Finding& f) {
  in_columns(out, f, [&](ColumnMapping& m) {
    m.low_pass_s = std::max(0.0, m.low_pass_s + f.parameters[0].value);
  });
}

/// A column that is the derivative of the speed says nothing that the speed does not.
void write_derived(MappingChanges& out, const Finding& f) {
  constexpr double kMostOfIt = 0.5;
  if (f.parameters[0].low < kMostOfIt) return;
  const auto dropped = std::erase_if(out.mapping.columns, [&](const ColumnMapping& m) {
    return names_column(f.channel, m.column);
  });
  if (dropped == 0) return;
  out.mapping.notes.push_back("column '" + f.channel +
                              "' is not used: it is the derivative of the speed");
  out.changed = true;
}

void write_misalignment(MappingChanges& out, const Finding& f) {
  out.mapping.imu_yaw_rad += f.parameters[0].value;
  out.changed = true;
}

/// Those of the lateral speed and of the place have none in a mapping.
void write_lever_arm(MappingChanges& out, const Finding& f) {
  if (!names_column(f.channel, out.logs.front().column[kAx])) return;
  out.mapping.imu_ahead_m += f.parameters[0].value;
  out.changed = true;
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kSensorBias, .list = list, .write_mapping = write_bias},
          {.id = kSensorGain, .most = 0.5, .write_mapping = write_gain},
          {.id = kSensorDelay, .most = 1.0, .write_mapping = write_delay},
          {.id = kSensorLowPass, .most = 5.0, .write_mapping = write_low_pass},
          {.id = "sensor.misalignment", .most = 0.3, .write_mapping = write_misalignment},
          {.id = kSensorLeverArm, .most = 4.0, .write_mapping = write_lever_arm},
          {.id = "sensor.derived", .most = 1.4, .write_mapping = write_derived}};
}

}  // namespace explain::sensors
