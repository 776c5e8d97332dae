#include "drive.h"

#include <algorithm>
#include <cstdio>

namespace trials {
namespace {

struct Speeds {
  std::vector<double> v;
};

/// Speed over the track from what grip, drive and brakes allow, at a pace.
Speeds plan(const Track& t, double pace, double drive) {
  const std::size_t n = t.x.size();
  Speeds out;
  for (std::size_t i = 0; i < n; ++i) out.v.push_back(std::min(62.0, std::sqrt(13.5 * pace * pace / std::max(1e-4, std::abs(t.curvature[i])))));
  for (int round = 0; round < 2; ++round) {
    for (std::size_t k = 0; k < 2 * n; ++k) {
      const std::size_t i = k % n, j = (i + 1) % n;
      out.v[j] = std::min(out.v[j], std::sqrt(out.v[i] * out.v[i] + 2 * 4.5 * drive * pace * t.step_m * std::max(0.1, 1 - out.v[i] / 75)));
    }
    for (std::size_t k = 2 * n; k-- > 0;) {
      const std::size_t i = k % n, j = (i + 1) % n;
      out.v[i] = std::min(out.v[i], std::sqrt(out.v[j] * out.v[j] + 2 * 9.5 * pace * t.step_m));
    }
  }
  return out;
}

}  // namespace

Drive drive(const TruthCar& car, const Track& track, const Style& style, bool measure) {
  Random dice{style.seed};
  Drive out;
  TruthCar without = car;
  without.effects.clear();
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
  double shift = 0, weave = 0;
  std::vector<Commands> history;
  std::array<double, kLogged> sum{};
  double count = 0;
  int lap = -1;
  double pace = 0.8, amplitude = 0, phase = 0;
  Speeds speeds;
  Output o;
  const auto total = static_cast<long>(1000.0 * 400.0 * style.laps);
  std::vector<std::pair<State, double>> branch;  // states waiting for their other future
  State twin{};
  double twin_s = 0;
  long twin_end = -1;
  for (long step = 0; step < total; ++step) {
    const int now = static_cast<int>(std::floor(s / track.length_m));
    if (now >= style.laps) break;
    if (now != lap) {
      lap = now;
      pace = dice.in(style.pace_low, style.pace_high);
      if (lap == 0) pace = style.first_pace;
      amplitude = dice.in(-style.sway_m, style.sway_m);
      phase = dice.in(0, 6);
      speeds = plan(track, pace, style.drive);
    }
    c.steer -= weave;  // the driver holds his line beside it
    if (step % 5 == 0) {
      const double preview = 6 + 0.45 * x[3];
      const Track::Point p = track.at(s + preview);
      const double offset = amplitude * std::sin(2 * kPi * style.sway_waves * (s + preview) / track.length_m + phase);
      const double tx = p.x - offset * std::sin(p.heading), ty = p.y + offset * std::cos(p.heading);
      const double angle = std::remainder(std::atan2(ty - x[1], tx - x[0]) - x[2], 2 * kPi);
      const double curvature = 2 * std::sin(angle) / preview;
      const double wanted = curvature * (car.a + car.b + 0.0012 * x[3] * x[3]) - 0.05 * (x[5] - curvature * x[3]);
      c.steer += std::clamp(std::clamp(wanted, -0.25, 0.25) - c.steer, -0.006, 0.006);
      const auto cell = [&](double at) {
        auto i = static_cast<std::size_t>(std::fmod(at, track.length_m) / track.step_m);
        return speeds.v[std::min(i, speeds.v.size() - 1)];
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
    if (style.weave_rad > 0) {
      const double t = std::fmod(static_cast<double>(step) * 0.001, 20.0);
      weave = style.weave_rad * std::sin(2 * kPi * (style.weave_from_hz * t + (style.weave_to_hz - style.weave_from_hz) * t * t / 40.0));
    }
    c.steer += weave;
    Commands used = c;
    if (shift > 0) shift -= 0.001;
    history.push_back(c);
    const auto late = [&](double dead) -> const Commands& {
      const auto back = static_cast<std::size_t>(dead * 1000);
      return history[history.size() > back ? history.size() - 1 - back : 0];
    };
    used.throttle = late(style.dead_throttle).throttle;
    used.brake_pa = late(style.dead_brake).brake_pa;
    used.steer = late(style.dead_steer).steer;
    if (shift > 0) used.gear = 0;
    const Commands plain = [&] {
      Commands k = c;
      k.gear = used.gear;
      return k;
    }();
    if (measure) {
      if (step % 900 == 0) twin = x, twin_s = s, twin_end = step + 450;
      if (twin_end > step) {
        double ts = twin_s;
        advance(without, track, twin, plain, ts, nullptr);
        twin_s = ts;
      }
    }
    const State before = x;
    advance(car, track, x, used, s, &o);
    if (measure && twin_end == step + 1) {
      const auto add = [&](int channel, double d) { sum[static_cast<std::size_t>(channel)] += d * d; };
      add(kVx, x[3] - twin[3]);
      add(kVy, x[4] - twin[4]);
      add(kR, x[5] - twin[5]);
      add(kYaw, x[2] - twin[2]);
      add(kX, std::hypot(x[0] - twin[0], x[1] - twin[1]));
      add(kWrl, x[7] - twin[7]);
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
      row[kS] = o.s, row[kV] = o.v;
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
    }
  out.lap_s = static_cast<double>(out.row.size()) * 0.005 / style.laps;
  return out;
}

double sensed(const Drive& d, std::size_t k, int channel, const std::vector<Effect>& effects, const std::string& name) {
  double value = d.row[k][static_cast<std::size_t>(channel)];
  for (const Effect& e : effects) {
    if (e.channel != name) continue;
    if (e.mechanism == "sensor.delay") {
      const auto back = static_cast<std::size_t>(e.amount / 0.005 + 0.5);
      value = d.row[k > back ? k - back : 0][static_cast<std::size_t>(channel)];
    } else if (e.mechanism == "sensor.low_pass") {
      double sum = 0, weight = 0;
      for (std::size_t j = 0; j < 100 && j <= k; ++j) {
        const double w = std::exp(-static_cast<double>(j) * 0.005 / e.amount);
        sum += w * d.row[k - j][static_cast<std::size_t>(channel)];
        weight += w;
      }
      value = sum / weight;
    } else if (e.mechanism == "sensor.gain") value *= 1 + e.amount;
    else if (e.mechanism == "sensor.bias") value += e.amount;
  }
  return value;
}

}  // namespace trials
