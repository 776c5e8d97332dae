#include "log.h"

#include <algorithm>
#include <cstdio>
#include <numbers>

#include "truth_car_electric.h"

namespace trials {
namespace {

double at(const std::vector<Row>& rows, std::size_t k, int channel) {
  return rows[k][static_cast<std::size_t>(channel)];
}

double delayed(const std::vector<Row>& rows, std::size_t k, int channel, double delay_s) {
  const double back = std::max(0.0, static_cast<double>(k) - delay_s / kRow_s);
  const auto i = static_cast<std::size_t>(back);
  return at(rows, i, channel) +
         (back - static_cast<double>(i)) *
             (at(rows, std::min(i + 1, rows.size() - 1), channel) - at(rows, i, channel));
}

/// First order, exact for a signal that is straight between rows.
double low_passed(const std::vector<Row>& rows, std::size_t k, int channel, double lag_s) {
  double state = at(rows, k > 400 ? k - 400 : 0, channel);
  const double h = kRow_s / std::max(1e-6, lag_s), keep = std::exp(-h);
  for (std::size_t j = k > 400 ? k - 399 : 1; j <= k; ++j) {
    const double a = at(rows, j - 1, channel), b = at(rows, j, channel);
    state = b - (b - a) / h + keep * (state - a + (b - a) / h);
  }
  return state;
}

/// Of an accelerometer that sits ahead of the centre of gravity.
double from_ahead(const std::vector<Row>& rows, std::size_t k, int channel, double ahead_m) {
  const double r = at(rows, k, kR),
               rate = k > 0 && k + 1 < rows.size()
                          ? (at(rows, k + 1, kR) - at(rows, k - 1, kR)) / (2 * kRow_s)
                          : 0.0;
  return channel == kAx ? at(rows, k, kAx) - ahead_m * r * r : at(rows, k, kAy) + ahead_m * rate;
}

/// Of an accelerometer that is turned.
double turned(const std::vector<Row>& rows, std::size_t k, int channel, double angle_rad) {
  const double ax = at(rows, k, kAx), ay = at(rows, k, kAy);
  return channel == kAx ? std::cos(angle_rad) * ax + std::sin(angle_rad) * ay
                        : std::cos(angle_rad) * ay - std::sin(angle_rad) * ax;
}

}  // namespace

Row row_of(const TruthCar& car, double time_s, const State& x, const Output& o,
           const Commands& driver, int gear) {
  Row row{};
  row[kT] = time_s;
  for (int k = 0; k < 6; ++k)
    row[static_cast<std::size_t>(kX + k)] = x[static_cast<std::size_t>(k)];
  row[kAx] = o.ax, row[kAy] = o.ay, row[kAz] = o.az;
  row[kSteer] = driver.steer, row[kThrottle] = driver.throttle, row[kBrake] = driver.brake_pa;
  row[kGear] = gear;
  row[kEngine] = 0.5 * (x[7] + x[8]) *
                 car.ratio[static_cast<std::size_t>(std::max(1, driver.gear) - 1)] *
                 car.final_drive;
  row[kWfl] = x[6] - x[5] * car.track_f / 2 / car.radius_f;
  row[kWfr] = x[6] + x[5] * car.track_f / 2 / car.radius_f;
  row[kWrl] = x[7], row[kWrr] = x[8];
  if (car.electric) {
    row[kWfl] = x[kWheelFl], row[kWfr] = x[kWheelFr];
    row[kSteerReached] = x[kSteered], row[kThrottleReached] = x[kOpened];
    row[kBrakeReached] = x[kPressed];
  }
  row[kFzF] = o.fz_front, row[kFzR] = o.fz_rear;
  row[kS] = o.s, row[kV] = o.v;
  for (std::size_t i = 0; i < 4; ++i) {
    const Tyre& t = o.tyre[i];
    std::size_t at = kTyre + i * kTyreNumbers;
    for (const double number : {t.fx, t.fy, t.fz, t.kappa, t.tan_alpha}) row[at++] = number;
  }
  return row;
}

double sensed(const std::vector<Row>& rows, std::size_t k, int channel,
              const std::vector<Effect>& effects, const std::string& name) {
  double value = at(rows, k, channel);
  for (const Effect& e : effects) {
    // The accelerometer's place and direction concern both of its axes.
    const bool accelerometer = channel == kAx || channel == kAy;
    if (accelerometer && e.mechanism == "sensor.lever_arm")
      value = from_ahead(rows, k, channel, e.amount);
    if (accelerometer && e.mechanism == "sensor.misalignment")
      value = turned(rows, k, channel, e.amount);
    if (e.mechanism == "outside.heading_drift" && channel == kYaw)
      value += e.amount * 0.02 * std::sin(2 * std::numbers::pi * at(rows, k, kT) / 47.0);
    if (e.channel != name) continue;
    if (e.mechanism == "sensor.delay")
      value = delayed(rows, k, channel, e.amount);
    else if (e.mechanism == "sensor.low_pass")
      value = low_passed(rows, k, channel, e.amount);
    else if (e.mechanism == "sensor.gain")
      value *= 1 + e.amount;
    else if (e.mechanism == "sensor.bias")
      value += e.amount;
  }
  return value;
}

std::vector<Column> columns(const Logged& logged) {
  std::vector<Column> out{
      {"time_s", kT}, {"x_m", kX}, {"y_m", kY}, {"yaw_rad", kYaw}, {"vx_mps", kVx}};
  const auto per_wheel = [&](const std::string& before, const std::string& after,
                             const std::array<int, 4>& channel) {
    std::size_t wheel = 0;
    for (const char* name : {"fl", "fr", "rl", "rr"})
      out.push_back({before + name + after, channel[wheel++]});
  };
  if (logged.vy) out.push_back({"vy_mps", kVy});
  out.push_back({"yaw_rate_radps", kR});
  if (logged.ax) out.push_back({"ax_mps2", kAx});
  if (logged.ay) out.push_back({"ay_mps2", kAy});
  if (logged.az) out.push_back({"az_mps2", kAz});
  if (logged.commands || !logged.reached) {
    out.push_back({logged.commands ? "steer_command_rad" : "steer_rad", kSteer});
    out.push_back({logged.commands ? "throttle_command" : "throttle", kThrottle});
    per_wheel("brake_", logged.commands ? "_command_pa" : "_pa", {kBrake, kBrake, kBrake, kBrake});
  }
  if (logged.reached) {
    out.push_back({"steer_rad", kSteerReached});
    out.push_back({"throttle", kThrottleReached});
    per_wheel("brake_", "_pa", {kBrakeReached, kBrakeReached, kBrakeReached, kBrakeReached});
  }
  if (logged.gear) out.push_back({"gear", kGear});
  if (logged.engine) out.push_back({"engine_radps", kEngine});
  per_wheel("wheel_", "_radps", {kWfl, kWfr, kWrl, kWrr});
  if (logged.axle_loads) per_wheel("fz_", "_n", {kFzF, kFzF, kFzR, kFzR});
  if (logged.body) {
    out.push_back({"roll_rate_radps", kRollRate});
    out.push_back({"pitch_rate_radps", kPitchRate});
    int wheel = 0;
    for (const std::string name : {"fl", "fr", "rl", "rr"}) {
      out.push_back({"suspension_" + name + "_m", kTravel + wheel});
      out.push_back({"fz_" + name + "_n", kLoad + wheel++});
    }
  }
  if (logged.discs) per_wheel("brake_disc_", "_k", {kDisc, kDisc + 1, kDisc + 2, kDisc + 3});
  return out;
}

namespace {

/// A cell: through the sensor, with noise.
std::string cell(const std::vector<Row>& rows, std::size_t i, const Column& column,
                 const std::vector<Effect>& effects, Random& dice) {
  const int channel = column.channel;
  double value = sensed(rows, i, channel, effects, column.name);
  if (channel == kFzF || channel == kFzR) value *= 0.5;
  value += kNoise[static_cast<std::size_t>(channel)] * dice.normal();
  if (channel == kBrake || channel == kThrottle || channel == kBrakeReached ||
      channel == kThrottleReached)
    value = std::max(0.0, value);
  if (column.name.find("_command") != std::string::npos) value = at(rows, i, channel);
  char text[40];
  std::snprintf(text, sizeof text, "%.7g", value);
  return text;
}

std::string header(const std::vector<Column>& columns) {
  std::string out;
  for (std::size_t k = 0; k < columns.size(); ++k) out += (k ? "," : "") + columns[k].name;
  return out + "\n";
}

}  // namespace

std::string csv_by_channel(const std::vector<Row>& rows, const std::vector<Column>& columns,
                           double hz, const std::vector<Effect>& effects, Random& dice) {
  std::vector<double> period_s, next_s;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    period_s.push_back(1 / (hz * dice.in(0.6, 1.5)));
    next_s.push_back(period_s.back() * dice.uniform());
  }
  std::string out = header(columns);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double now_s = at(rows, i, kT);
    std::string line;
    bool any = false;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (k > 0) line += ",";
      const bool is_clock = columns[k].channel == kT;
      if (!is_clock && now_s < next_s[k]) continue;
      line += cell(rows, i, columns[k], effects, dice);
      if (is_clock) continue;
      any = true;
      next_s[k] += period_s[k];
    }
    if (any) out += line + "\n";
  }
  return out;
}

std::string csv(const std::vector<Row>& rows, const std::vector<Column>& columns, double hz,
                const std::vector<Effect>& effects, Random& dice) {
  std::string out = header(columns);
  const auto every = static_cast<std::size_t>(1 / kRow_s / hz);
  for (std::size_t i = 0; i < rows.size(); i += every) {
    for (std::size_t k = 0; k < columns.size(); ++k)
      out += (k ? "," : "") + cell(rows, i, columns[k], effects, dice);
    out += "\n";
  }
  return out;
}

}  // namespace trials
