#include "blind_drive.h"

#include <algorithm>
#include <cstdio>
#include <numbers>

namespace trials::blind {
namespace {

constexpr double kPi = std::numbers::pi;

/// Speed over the track from what grip, drive and brakes allow, at a pace.
std::vector<double> plan(const Track& t, double pace) {
  const std::size_t n = t.x.size();
  std::vector<double> out;
  for (std::size_t i = 0; i < n; ++i) out.push_back(std::min(62.0, std::sqrt(13.5 * pace * pace / std::max(1e-4, std::abs(t.curvature[i])))));
  for (int round = 0; round < 2; ++round) {
    for (std::size_t k = 0; k < 2 * n; ++k) {
      const std::size_t i = k % n, j = (i + 1) % n;
      out[j] = std::min(out[j], std::sqrt(out[i] * out[i] + 2 * 4.5 * pace * t.step_m * std::max(0.1, 1 - out[i] / 75)));
    }
    for (std::size_t k = 2 * n; k-- > 0;) {
      const std::size_t i = k % n, j = (i + 1) % n;
      out[i] = std::min(out[i], std::sqrt(out[j] * out[j] + 2 * 9.5 * pace * t.step_m));
    }
  }
  return out;
}

/// What reaches the wheels, the engine and the brakes of a variant: late, through a lag, scaled.
struct Actuators {
  double steer = 0;
  Commands operator()(const Variant& v, const std::vector<Commands>& history, const Commands& now) {
    const auto late = [&](double dead) -> const Commands& {
      const auto back = static_cast<std::size_t>(dead * 1000 + 0.5);
      return history[history.size() > back ? history.size() - 1 - back : 0];
    };
    Commands used = now;
    used.throttle = std::min(1.0, late(v.throttle_dead_s).throttle * v.throttle_gain);
    used.brake_pa = late(v.brake_dead_s).brake_pa;
    const double wanted = late(v.steer_dead_s).steer * v.steer_gain;
    steer = v.steer_lag_s > 0 ? steer + (wanted - steer) * (1 - std::exp(-0.001 / v.steer_lag_s)) : wanted;
    used.steer = steer;
    return used;
  }
};

}  // namespace

Drive drive(const Variant& truth, const Track& track, int laps, unsigned long long seed, const Variant* other) {
  const TruthCar& car = truth.car;
  Random dice{seed};
  Drive out;
  const bool measure = other != nullptr;
  State x{};
  const Track::Point start = track.at(0);
  x[0] = start.x;
  x[1] = start.y;
  x[2] = start.heading;
  x[3] = 25;
  x[6] = 25 / car.radius_f;
  x[7] = x[8] = 25 / car.radius_r;
  Commands c;
  double s = 0, integral = 0;
  double shift = 0;
  std::vector<Commands> history;
  std::array<double, kLogged> sum{};
  double count = 0;
  int lap = -1;
  double pace = 0.8, amplitude = 0, phase = 0;
  std::vector<double> speeds;
  Output o, twin_o;
  Actuators actuators, other_actuators;
  const auto total = static_cast<long>(1000.0 * 400.0 * laps);
  std::vector<std::pair<State, double>> branch;  // states waiting for their other future
  State twin{};
  double twin_s = 0;
  long twin_end = -1;
  for (long step = 0; step < total; ++step) {
    const int now = static_cast<int>(std::floor(s / track.length_m));
    if (now >= laps) break;
    if (now != lap) {
      lap = now;
      pace = dice.in(0.72, 0.93);
      if (lap == 0) pace = 0.7;
      amplitude = dice.in(-1.5, 1.5);
      phase = dice.in(0, 6);
      speeds = plan(track, pace);
    }
    if (step % 5 == 0) {
      const double preview = 6 + 0.45 * x[3];
      const Track::Point p = track.at(s + preview);
      const double offset = amplitude * std::sin(2 * kPi * 3 * (s + preview) / track.length_m + phase);
      const double tx = p.x - offset * std::sin(p.heading), ty = p.y + offset * std::cos(p.heading);
      const double angle = std::remainder(std::atan2(ty - x[1], tx - x[0]) - x[2], 2 * kPi);
      const double curvature = 2 * std::sin(angle) / preview;
      const double wanted = curvature * (car.a + car.b + 0.0012 * x[3] * x[3]) - 0.05 * (x[5] - curvature * x[3]);
      c.steer += std::clamp(std::clamp(wanted, -0.25, 0.25) - c.steer, -0.006, 0.006);
      const auto cell = [&](double at) {
        auto i = static_cast<std::size_t>(std::fmod(at, track.length_m) / track.step_m);
        return speeds[std::min(i, speeds.size() - 1)];
      };
      const double ahead = cell(s + 0.25 * x[3]);
      const double feed = (cell(s + 0.35 * x[3]) * cell(s + 0.35 * x[3]) - cell(s + 0.15 * x[3]) * cell(s + 0.15 * x[3])) / (2 * 0.2 * x[3]);
      const double error = ahead - x[3];
      integral = std::clamp(integral + 0.0008 * error, -0.4, 0.4);
      const double acceleration = feed + 1.4 * error + 0.6 + 0.0007 * x[3] * x[3];
      double throttle = acceleration > 0 ? acceleration / 9.0 * (0.4 + x[3] / 60) + integral : 0;
      double pressure = acceleration < -0.8 ? -(acceleration + 0.8) * 1.95e5 * 1.6 : 0;
      throttle = std::clamp(throttle, 0.0, 1.0);
      pressure = std::clamp(pressure, 0.0, 3.2e6);
      c.throttle += std::clamp(throttle - c.throttle, -0.06, 0.025);
      c.brake_pa += std::clamp(pressure - c.brake_pa, -2.5e5, 1.2e5);
      const double omega = x[3] / car.radius_r * car.final_drive;
      int gear = std::max(1, c.gear);
      if (gear < 6 && omega * car.ratio[static_cast<std::size_t>(gear - 1)] > 790) ++gear;
      else if (gear > 1 && omega * car.ratio[static_cast<std::size_t>(gear - 2)] < 640) --gear;
      if (gear != c.gear && c.gear > 0) shift = 0.06;
      c.gear = gear;
    }
    if (shift > 0) shift -= 0.001;
    history.push_back(c);
    Commands used = actuators(truth, history, c);
    if (shift > 0) used.gear = 0;
    if (measure) {
      Commands plain = other_actuators(*other, history, c);
      plain.gear = used.gear;
      if (step % 900 == 0) twin = x, twin_s = s, twin_end = step + 450;
      if (twin_end > step) advance(other->car, other->track != nullptr ? *other->track : track, twin, plain, twin_s, twin_end == step + 1 ? &twin_o : nullptr);
    }
    const State before = x;
    advance(car, truth.track != nullptr ? *truth.track : track, x, used, s, &o);
    if (measure && twin_end == step + 1) {
      const auto add = [&](int channel, double d) { sum[static_cast<std::size_t>(channel)] += d * d; };
      add(kVx, x[3] - twin[3]);
      add(kVy, x[4] - twin[4]);
      add(kR, x[5] - twin[5]);
      add(kYaw, x[2] - twin[2]);
      add(kX, std::hypot(x[0] - twin[0], x[1] - twin[1]));
      add(kWrl, x[7] - twin[7]);
      add(kWrr, x[8] - twin[8]);
      add(kAz, o.az - twin_o.az);
      count += 1;
    }
    if (step % 5 == 0) {
      std::array<double, kLogged> row{};
      row[kT] = static_cast<double>(step) * 0.001;
      for (int k = 0; k < 6; ++k) row[static_cast<std::size_t>(kX + k)] = before[static_cast<std::size_t>(k)];
      row[kAx] = o.ax, row[kAy] = o.ay, row[kAz] = o.az;
      row[kSteer] = c.steer, row[kThrottle] = c.throttle, row[kBrake] = c.brake_pa;
      row[kGear] = used.gear;
      row[kEngine] = 0.5 * (before[7] + before[8]) * car.ratio[static_cast<std::size_t>(std::max(1, c.gear) - 1)] * car.final_drive;
      row[kWfl] = row[kWfr] = before[6];
      row[kWfl] -= before[5] * car.track_f / 2 / car.radius_f;
      row[kWfr] += before[5] * car.track_f / 2 / car.radius_f;
      row[kWrl] = before[7], row[kWrr] = before[8];
      row[kFzF] = o.fz_front, row[kFzR] = o.fz_rear;
      out.row.push_back(row);
    }
    if (!std::isfinite(x[3]) || std::abs(o.v) > 7) {
      std::fprintf(stderr, "the truth car left the road at s = %.0f m\n", s);
      out.row.clear();
      break;
    }
  }
  for (std::size_t k = 0; k < kLogged; ++k)
    if (count > 0 && kNoise[k] > 0) {
      out.channel_size[k] = std::sqrt(sum[k] / count) / kNoise[k];
      out.size = std::max(out.size, out.channel_size[k]);
      out.distance += sum[k] / (kNoise[k] * kNoise[k]);
    }
  return out;
}

double sensed(const Drive& d, std::size_t k, int channel, const std::vector<Effect>& effects, const std::string& name) {
  const auto at = [&](std::size_t i, int c) { return d.row[i][static_cast<std::size_t>(c)]; };
  double value = at(k, channel);
  for (const Effect& e : effects) {
    // The accelerometer's place and direction concern both of its axes.
    if ((channel == kAx || channel == kAy) && (e.mechanism == "sensor.misalignment" || e.mechanism == "sensor.lever_arm")) {
      double ax = at(k, kAx), ay = at(k, kAy);
      if (e.mechanism == "sensor.lever_arm") {
        const double r = at(k, kR), rate = k > 0 && k + 1 < d.row.size() ? (at(k + 1, kR) - at(k - 1, kR)) / (2 * kRow_s) : 0.0;
        ax -= e.amount * r * r;
        ay += e.amount * rate;
      } else {
        const double turned = std::cos(e.amount) * ax + std::sin(e.amount) * ay;
        ay = std::cos(e.amount) * ay - std::sin(e.amount) * ax;
        ax = turned;
      }
      value = channel == kAx ? ax : ay;
    }
    if (e.mechanism == "outside.heading_drift" && channel == kYaw) value += e.amount * 0.02 * std::sin(2 * kPi * at(k, kT) / 47.0);
    if (e.channel != name) continue;
    if (e.mechanism == "sensor.delay") {
      const double back = std::max(0.0, static_cast<double>(k) - e.amount / kRow_s);
      const auto i = static_cast<std::size_t>(back);
      value = at(i, channel) + (back - static_cast<double>(i)) * (at(std::min(i + 1, d.row.size() - 1), channel) - at(i, channel));
    } else if (e.mechanism == "sensor.low_pass") {
      // Exact for a signal that is straight between rows.
      double state = at(k > 400 ? k - 400 : 0, channel);
      const double h = kRow_s / std::max(1e-6, e.amount), keep = std::exp(-h);
      for (std::size_t j = k > 400 ? k - 399 : 1; j <= k; ++j) {
        const double a = at(j - 1, channel), b = at(j, channel);
        state = b - (b - a) / h + keep * (state - a + (b - a) / h);
      }
      value = state;
    } else if (e.mechanism == "sensor.gain") {
      value *= 1 + e.amount;
    } else if (e.mechanism == "sensor.bias") {
      value += e.amount;
    }
  }
  return value;
}

}  // namespace trials::blind
