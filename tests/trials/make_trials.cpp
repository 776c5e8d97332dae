// Draws the recordings of the blind trials: make_trials COUNT SEED DIR. Every trial gets a track, a
// stated car that is wrong by a few per cent everywhere, a recording of the truth, and a truth file.
#include <crg/file.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <thread>

#include "truth_car.h"

namespace trials {
namespace {

using Json = nlohmann::ordered_json;
constexpr double kPi = std::numbers::pi;

struct Random {
  unsigned long long state;
  double uniform() {
    state += 0x9E3779B97F4A7C15ull;
    unsigned long long z = state;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }
  double in(double low, double high) { return low + (high - low) * uniform(); }
  double normal() { return std::sqrt(-2 * std::log(1 - uniform())) * std::cos(2 * kPi * uniform()); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(uniform() * static_cast<double>(n)); }
};

/// What a log holds, before sensors.
enum { kT, kX, kY, kYaw, kVx, kVy, kR, kAx, kAy, kAz, kSteer, kThrottle, kBrake, kGear, kEngine, kWfl, kWfr, kWrl, kWrr, kFzF, kFzR, kLogged };
const std::array<double, kLogged> kNoise{0, 0.02, 0.02, 0.002, 0.04, 0.03, 0.004, 0.15, 0.15, 0.3, 0.0004, 0.002, 1.5e4, 0, 1.5, 0.15, 0.15, 0.15, 0.15, 60, 60};

struct Speeds {
  std::vector<double> v;
};

/// Speed over the track from what grip, drive and brakes allow, at a pace.
Speeds plan(const Track& t, double pace, double constant) {
  const std::size_t n = t.x.size();
  Speeds out;
  for (std::size_t i = 0; i < n; ++i) out.v.push_back(std::min(62.0, std::sqrt(13.5 * pace * pace / std::max(1e-4, std::abs(t.curvature[i])))));
  for (int round = 0; round < 2; ++round) {
    for (std::size_t k = 0; k < 2 * n; ++k) {
      const std::size_t i = k % n, j = (i + 1) % n;
      out.v[j] = std::min(out.v[j], std::sqrt(out.v[i] * out.v[i] + 2 * 4.5 * pace * t.step_m * std::max(0.1, 1 - out.v[i] / 75)));
    }
    for (std::size_t k = 2 * n; k-- > 0;) {
      const std::size_t i = k % n, j = (i + 1) % n;
      out.v[i] = std::min(out.v[i], std::sqrt(out.v[j] * out.v[j] + 2 * 9.5 * pace * t.step_m));
    }
  }
  if (constant > 0) std::fill(out.v.begin(), out.v.end(), constant);
  return out;
}

struct Drive {
  std::vector<std::array<double, kLogged>> row;  ///< every 5 ms
  double size = 0.0;                             ///< of the effects, see below
  std::array<double, kLogged> channel_size{};
  double lap_s = 0.0;
};

Drive drive(const TruthCar& car, const Track& track, int laps, unsigned long long seed, double constant, bool measure, double dead_throttle,
            double dead_brake, double dead_steer) {
  Random dice{seed};
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
  double shift = 0;
  std::vector<Commands> history;
  std::array<double, kLogged> sum{};
  double count = 0;
  int lap = -1;
  double pace = 0.8, amplitude = 0, phase = 0;
  Speeds speeds;
  Output o;
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
      speeds = plan(track, pace, constant);
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
    Commands used = c;
    if (shift > 0) shift -= 0.001;
    history.push_back(c);
    const auto late = [&](double dead) -> const Commands& {
      const auto back = static_cast<std::size_t>(dead * 1000);
      return history[history.size() > back ? history.size() - 1 - back : 0];
    };
    used.throttle = late(dead_throttle).throttle;
    used.brake_pa = late(dead_brake).brake_pa;
    used.steer = late(dead_steer).steer;
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
  out.lap_s = static_cast<double>(out.row.size()) * 0.005 / laps;
  return out;
}

/// The sensor effects; a delayed or filtered copy is read from the fine rows.
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

std::string tir(const char* side, double load, double mu, double mu_load, double c, double ck, double radius) {
  char text[3000];
  std::snprintf(text, sizeof text,
                "[MDI_HEADER]\nFILE_TYPE = 'tir'\nFILE_VERSION = 3\nFILE_FORMAT = 'ASCII'\n[UNITS]\nLENGTH = 'meter'\nFORCE = 'newton'\nANGLE = 'radians'\nMASS = 'kg'\nTIME = 'second'\n"
                "[MODEL]\nFITTYP = 62\nTYRESIDE = '%s'\nLONGVL = 30\n[DIMENSION]\nUNLOADED_RADIUS = %.5f\n[VERTICAL]\nFNOMIN = %.1f\nVERTICAL_STIFFNESS = 240000\n"
                "VERTICAL_DAMPING = 250\n[LONGITUDINAL_COEFFICIENTS]\nPCX1 = 1.3\nPDX1 = %.4f\nPDX2 = %.4f\nPEX1 = 0.4\nPKX1 = %.3f\nRBX1 = 12\nRBX2 = 10\nRCX1 = 1\n"
                "[LATERAL_COEFFICIENTS]\nPCY1 = 1.3\nPDY1 = %.4f\nPDY2 = %.4f\nPEY1 = 0.4\nPKY1 = %.4f\nPKY2 = 3\nPKY4 = 2\nRBY1 = 12\nRBY2 = 8\nRCY1 = 1\n[ROLLING_COEFFICIENTS]\nQSY1 = 0.0125\n[ALIGNING_COEFFICIENTS]\nQBZ1 = 10\nQCZ1 = 1.1\nQDZ1 = 0.1\n",
                side, radius, load, mu, -mu_load * mu, ck, mu, -mu_load * mu, -c * 1.0 / 0.6);
  return text;
}

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  if (!out) std::fprintf(stderr, "cannot write %s\n", path.c_str()), std::exit(1);
}

struct Choice {
  const char* mechanism;
  const char* channel;
  double unit, most;  ///< first guess and largest amount
};
const std::vector<Choice> kSingle{{"vehicle.turbo_lag", "", 0.4, 0.75}, {"vehicle.throttle_dead_time", "", 0.08, 0.2},
                                  {"vehicle.brake_dead_time", "", 0.06, 0.2}, {"vehicle.steering_dead_time", "", 0.04, 0.12},
                                  {"vehicle.tyre_thermal", "", 0.15, 0.35}, {"vehicle.brake_friction_temperature", "", 0.15, 0.5},
                                  {"environment.wind", "", 4, 12}, {"vehicle.differential", "", 0.5, 1},
                                  {"road.banking", "", 0.03, 0.12}, {"road.grade", "", 0.03, 0.1},
                                  {"road.friction", "", -0.15, 0.4}, {"vehicle.fuel_burn", "", 0.1, 0.3},
                                  {"parameter.mass", "", 0.14, 0.3}, {"parameter.engine_torque", "", 0.15, 0.35},
                                  {"parameter.drag", "", 0.2, 0.5}, {"parameter.brake_gain", "", 0.15, 0.35},
                                  {"sensor.bias", "yaw_rate_radps", 0.004, 0.1}, {"sensor.bias", "ax_mps2", 0.15, 3},
                                  {"sensor.bias", "ay_mps2", 0.15, 3}, {"sensor.gain", "yaw_rate_radps", 0.02, 0.3},
                                  {"sensor.gain", "ay_mps2", 0.02, 0.3}, {"sensor.delay", "yaw_rate_radps", 0.04, 0.3},
                                  {"sensor.delay", "ax_mps2", 0.06, 0.3}};
const std::vector<Choice> kOutside{{"outside.slip_drag", "", 1, 50}, {"outside.torque_steer", "", 1, 20}, {"outside.brake_pull", "", 1, 20},
                                   {"outside.surge", "", 0.3, 5}, {"outside.gust", "", 0.5, 8}};

void make_one(int id, unsigned long long seed, const std::filesystem::path& folder) {
  Random dice{seed * 1000003ull + static_cast<unsigned long long>(id)};
  for (int k = 0; k < 5; ++k) dice.uniform();
  const Track track = [&] {
    Track t = make_track(dice.in(170, 260), dice.in(0.15, 0.28), dice.in(0.08, 0.16), dice.in(0.02, 0.05), dice.in(0, 6));
    for (std::size_t k = 0; k < 3; ++k) t.hill[k] = dice.in(0, 4.0 / static_cast<double>((k + 1) * (k + 1))), t.hill_phase[k] = dice.in(0, 6);
    t.bank_base = dice.in(0, 0.02);
    return t;
  }();
  TruthCar car;
  for (double* p : {&car.mass, &car.inertia, &car.mu_f, &car.mu_r, &car.c_f, &car.c_r, &car.drag, &car.lift_f, &car.lift_r, &car.torque}) *p *= dice.in(0.9, 1.1);
  const TruthCar nominal = car;

  const int kind = id % 8;  // 0, 1 nothing; 2, 3, 4 single; 5 two; 6 outside; 7 a pair that looks alike
  const int laps = 3 + static_cast<int>(dice.below(4));
  const double hz = std::array{25.0, 50.0, 100.0}[dice.below(3)];
  std::vector<Choice> chosen;
  std::vector<double> wanted;
  const std::array<double, 4> kSizes{0.25, 0.5, 1.0, 2.0};
  std::vector<std::string> alike;
  const char* kinds[] = {"none", "none", "single", "single", "single", "two", "outside", "alike"};
  if (kind >= 2 && kind <= 4) chosen.push_back(kSingle[dice.below(kSingle.size())]), wanted.push_back(kSizes[dice.below(4)]);
  if (kind == 5) {
    const std::size_t first = dice.below(kSingle.size());
    std::size_t second = dice.below(kSingle.size());
    while (std::string(kSingle[second].mechanism) == kSingle[first].mechanism) second = dice.below(kSingle.size());
    for (const std::size_t k : {first, second}) chosen.push_back(kSingle[k]), wanted.push_back(kSizes[1 + dice.below(3)]);
  }
  if (kind == 6) chosen.push_back(kOutside[dice.below(kOutside.size())]), wanted.push_back(kSizes[1 + dice.below(3)]);
  if (kind == 7) {
    const bool gyro = dice.uniform() < 0.5, filter = dice.uniform() < 0.5;
    chosen.push_back({filter ? "sensor.low_pass" : "sensor.delay", gyro ? "yaw_rate_radps" : "ax_mps2", 0.03, 0.04});
    wanted.push_back(0.5 + 0.5 * dice.uniform());
    alike = {"sensor.delay", "sensor.low_pass"};
  }
  double dead_throttle = 0, dead_brake = 0, dead_steer = 0;
  std::vector<double> sizes;
  const unsigned long long route = seed * 7919 + static_cast<unsigned long long>(id);
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    Effect e{chosen[k].mechanism, chosen[k].channel, chosen[k].unit};
    if (e.mechanism == "vehicle.turbo_lag") e.extra = dice.in(0.2, 0.6);
    if (e.mechanism == "vehicle.tyre_thermal") e.extra = dice.in(25, 90);
    if (e.mechanism == "environment.wind") e.extra = dice.in(0, 6.28);
    if (e.mechanism.starts_with("road.")) {
      const double length = dice.in(60, 220);
      e.begin_m = dice.in(60, track.length_m - length - 60);
      e.end_m = e.begin_m + length;
      if (dice.uniform() < 0.5) e.amount = -e.amount;
    }
    if (e.mechanism.starts_with("parameter.") && dice.uniform() < 0.5) e.amount = -e.amount;
    double size = 0;
    for (int round = 0; round < 2; ++round) {
      TruthCar one = car;
      one.effects = {e};
      if (e.mechanism.starts_with("sensor.")) {
        const Drive d = drive(car, track, 1, route, 0, false, 0, 0, 0);
        const int channel = e.channel == "yaw_rate_radps" ? kR : e.channel == "ax_mps2" ? kAx : kAy;
        double sum = 0, count = 0;
        for (std::size_t i = 200; i < d.row.size(); i += 10) {
          const double change = sensed(d, i, channel, {e}, e.channel) - d.row[i][static_cast<std::size_t>(channel)];
          sum += change * change;
          count += 1;
        }
        size = std::sqrt(sum / std::max(1.0, count)) / kNoise[static_cast<std::size_t>(channel)];
      } else {
        const auto dead = [&](const char* m) { return e.mechanism == m ? e.amount : 0.0; };
        size = drive(one, track, 1, route, 0, true, dead("vehicle.throttle_dead_time"), dead("vehicle.brake_dead_time"), dead("vehicle.steering_dead_time")).size;
      }
      if (!(size > 0)) break;
      if (round < 1 || std::abs(size / wanted[k] - 1) > 0.1)
        e.amount = std::copysign(std::min(chosen[k].most, std::abs(e.amount) * wanted[k] / size), e.amount);
      if (round == 1) size = std::min(wanted[k], size * 1e9);
    }
    sizes.push_back(size);
    car.effects.push_back(e);
    if (e.mechanism == "vehicle.throttle_dead_time") dead_throttle = e.amount;
    if (e.mechanism == "vehicle.brake_dead_time") dead_brake = e.amount;
    if (e.mechanism == "vehicle.steering_dead_time") dead_steer = e.amount;
  }
  const Drive d = drive(car, track, laps, route, 0, false, dead_throttle, dead_brake, dead_steer);
  if (d.row.size() < 4000) {
    std::fprintf(stderr, "trial %d: no drive\n", id);
    return;
  }

  char name[16];
  std::snprintf(name, sizeof name, "%04d", id);
  const std::filesystem::path here = folder / name;
  std::filesystem::create_directories(here);
  // The road as the simulation knows it.
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = track.step_m;
  line.closed = true;
  for (int j = -20; j <= 20; ++j) grid.v_m.push_back(0.5 * j);
  const std::size_t n = track.x.size();
  for (std::size_t i = 0; i <= n; ++i) {
    line.x_m.push_back(track.x[i % n]);
    line.y_m.push_back(track.y[i % n]);
    const std::size_t before = (i + n - 1) % n;
    line.heading_rad.push_back(std::atan2(track.y[i % n] - track.y[before], track.x[i % n] - track.x[before]));
    const double s = static_cast<double>(i % n) * track.step_m;
    for (const double v : grid.v_m) grid.z_m.push_back(static_cast<float>(track.height(s) + v * track.bank(s)));
  }
  crg::write(crg::make_crg(line, grid), (here / "track.crg").string(), crg::Format::KRBI);

  // The stated car: a few per cent off everywhere.
  const auto off = [&](double share = 0.04) { return dice.in(1 - share, 1 + share); };
  const TruthCar& t = nominal;
  write(here / "front.tir", tir("LEFT", t.load_f, t.mu_f * off(), t.mu_load * off(0.2), t.c_f * off(), t.ck * off(), 0.325));
  write(here / "rear.tir", tir("LEFT", t.load_r, t.mu_r * off(), t.mu_load * off(0.2), t.c_r * off(), t.ck * off(), 0.328));
  std::string engine = "engine_radps:throttle,0,0.25,0.5,0.75,1\n";
  const double tilt = dice.in(-0.03, 0.03), scale = off();
  for (int omega = 100; omega <= 850; omega += 50) {
    engine += std::to_string(omega);
    for (const double thr : {0.0, 0.25, 0.5, 0.75, 1.0}) engine += "," + std::to_string(t.engine_nm(omega, thr) * scale * (1 + tilt * (omega - 500) / 300.0));
    engine += "\n";
  }
  write(here / "engine.csv", engine);
  char yaml[4000];
  std::snprintf(yaml, sizeof yaml,
                "name: stated\ntyres: {front: front.tir, rear: rear.tir, alpha: tan}\nmaps: {engine_torque_nm: engine.csv}\ncontact: single_point\nparameters:\n"
                "  chassis.mass_kg: %.2f\n  chassis.wheelbase_m: %.3f\n  chassis.cog_behind_front_m: %.4f\n  chassis.cog_height_m: %.4f\n  chassis.yaw_inertia_kgm2: %.1f\n"
                "  front.track_m: %.3f\n  rear.track_m: %.3f\n  aero.drag_area_m2: %.4f\n  front.lift_area_m2: %.4f\n  rear.lift_area_m2: %.4f\n"
                "  engine.inertia_kgm2: %.4f\n  engine.limit_radps: 830\n  front.wheel_inertia_kgm2: 0.9\n  rear.wheel_inertia_kgm2: 0.9\n  gearbox.efficiency: 0.95\n"
                "  gearbox.final: 3\n  gearbox.ratio_1: 2.9\n  gearbox.ratio_2: 2.1\n  gearbox.ratio_3: 1.65\n  gearbox.ratio_4: 1.36\n  gearbox.ratio_5: 1.16\n  gearbox.ratio_6: 1.02\n"
                "  front.brake_area_m2: 0.004\n  front.brake_radius_m: 0.125\n  front.brake_friction: %.4f\n  rear.brake_area_m2: 0.003\n  rear.brake_radius_m: 0.115\n  rear.brake_friction: %.4f\n"
                "  front.camber_rad: 0\n  rear.camber_rad: 0\n  front.camber_gain_radpm: 0\n  rear.camber_gain_radpm: 0\n  front.toe_rad: 0\n  rear.toe_rad: 0\n"
                "terms: {aero_ride_height: 0, aero_yaw: 0, turbo_lag: 0, tyre_thermal: 0, tyre_camber: 0, brake_friction_temperature: 0, fuel_burn: 0, limited_slip: 0, locked_differential: 0, "
                "steering_actuator: 0, steering_friction: 0, throttle_actuator: 0, brake_actuator: 0, wind: 0}\n",
                t.mass * off(), t.a + t.b, t.a * off(0.015), t.h * off(), t.inertia * off(), t.track_f, t.track_r, t.drag * off(), t.lift_f * off(), t.lift_r * off(),
                t.engine_inertia * off(), t.brake_f / (4 * 0.004 * 0.125) * off(), t.brake_r / (4 * 0.003 * 0.115) * off());
  write(here / "vehicle.yaml", yaml);

  // The recording. Some logs lack channels; what a trial is about stays in.
  const bool loads = dice.uniform() < 0.3, vertical = dice.uniform() < 0.5, engine_speed = dice.uniform() < 0.6, gear = dice.uniform() < 0.85;
  const auto about = [&](const char* channel) { return std::any_of(car.effects.begin(), car.effects.end(), [&](const Effect& e) { return e.channel == channel; }); };
  const bool ax = about("ax_mps2") || dice.uniform() < 0.85, ay = about("ay_mps2") || dice.uniform() < 0.8;
  const bool commands = dead_steer > 0 || dice.uniform() < 0.4;
  struct Column { std::string name; int channel; };
  std::vector<Column> columns{{"time_s", kT}, {"x_m", kX}, {"y_m", kY}, {"yaw_rad", kYaw}, {"vx_mps", kVx}, {"vy_mps", kVy}, {"yaw_rate_radps", kR}};
  if (ax) columns.push_back({"ax_mps2", kAx});
  if (ay) columns.push_back({"ay_mps2", kAy});
  if (vertical) columns.push_back({"az_mps2", kAz});
  columns.push_back({commands ? "steer_command_rad" : "steer_rad", kSteer});
  columns.push_back({commands ? "throttle_command" : "throttle", kThrottle});
  for (const char* wheel : {"fl", "fr", "rl", "rr"}) columns.push_back({std::string("brake_") + wheel + (commands ? "_command_pa" : "_pa"), kBrake});
  if (gear) columns.push_back({"gear", kGear});
  if (engine_speed || !gear) columns.push_back({"engine_radps", kEngine});
  for (const auto& [wheel, channel] : {std::pair{"fl", kWfl}, {"fr", kWfr}, {"rl", kWrl}, {"rr", kWrr}}) columns.push_back({std::string("wheel_") + wheel + "_radps", channel});
  if (loads) {
    for (const auto& [wheel, channel] : {std::pair{"fl", kFzF}, {"fr", kFzF}, {"rl", kFzR}, {"rr", kFzR}}) columns.push_back({std::string("fz_") + wheel + "_n", channel});
  }
  std::string csv;
  for (std::size_t k = 0; k < columns.size(); ++k) csv += (k ? "," : "") + columns[k].name;
  csv += "\n";
  const auto every = static_cast<std::size_t>(200.0 / hz);
  for (std::size_t i = 0; i < d.row.size(); i += every) {
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const int channel = columns[k].channel;
      double value = sensed(d, i, channel, car.effects, columns[k].name);
      if (channel == kFzF || channel == kFzR) value *= 0.5;
      value += kNoise[static_cast<std::size_t>(channel)] * dice.normal();
      if (channel == kBrake || channel == kThrottle) value = std::max(0.0, value);
      if (columns[k].name.ends_with("_command_rad") || columns[k].name.ends_with("_command") || columns[k].name.ends_with("_command_pa")) value = d.row[i][static_cast<std::size_t>(channel)];
      char text[40];
      std::snprintf(text, sizeof text, "%s%.7g", k ? "," : "", value);
      csv += text;
    }
    csv += "\n";
  }
  write(here / "run.csv", csv);

  Json truth{{"id", id}, {"class", kinds[kind]}, {"laps", laps}, {"hz", hz}, {"length_m", track.length_m}, {"effects", Json::array()}, {"alike", alike}};
  for (std::size_t k = 0; k < car.effects.size(); ++k) {
    const Effect& e = car.effects[k];
    Json item{{"mechanism", e.mechanism}, {"channel", e.channel}, {"amount", e.amount}, {"extra", e.extra}, {"size_sd", sizes[k]}};
    if (e.end_m > 0) item["where"] = {e.begin_m, e.end_m};
    truth["effects"].push_back(item);
  }
  write(folder / "sealed" / (std::string(name) + ".json"), truth.dump(1) + "\n");
}

}  // namespace
}  // namespace trials

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "make_trials COUNT SEED DIR\n");
    return 2;
  }
  const int count = std::atoi(argv[1]);
  const auto seed = static_cast<unsigned long long>(std::atoll(argv[2]));
  const std::filesystem::path folder = argv[3];
  std::filesystem::create_directories(folder / "sealed");
  std::thread other([&] {
    for (int id = 1; id < count; id += 2) trials::make_one(id, seed, folder);
  });
  for (int id = 0; id < count; id += 2) trials::make_one(id, seed, folder);
  other.join();
  return 0;
}
