// Draws the recordings of the blind trials: make_trials COUNT SEED DIR. Every trial gets a track, a
// stated car that is wrong by a few per cent everywhere, a recording of the truth, and a truth file.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "scenarios.h"
#include "write_trial.h"

namespace trials {
namespace {

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

void add_dead_time(Style& style, const Effect& e) {
  if (e.mechanism == "vehicle.throttle_dead_time") style.dead_throttle = e.amount;
  if (e.mechanism == "vehicle.brake_dead_time") style.dead_brake = e.amount;
  if (e.mechanism == "vehicle.steering_dead_time") style.dead_steer = e.amount;
}

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
  std::vector<double> sizes;
  Style style;
  style.seed = seed * 7919 + static_cast<unsigned long long>(id);
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
      Style one_lap;
      one_lap.seed = style.seed;
      one.effects = {e};
      if (e.mechanism.starts_with("sensor.")) {
        const Drive d = drive(car, track, one_lap, false);
        const int channel = e.channel == "yaw_rate_radps" ? kR : e.channel == "ax_mps2" ? kAx : kAy;
        double sum = 0, count = 0;
        for (std::size_t i = 200; i < d.row.size(); i += 10) {
          const double change = sensed(d, i, channel, {e}, e.channel) - d.row[i][static_cast<std::size_t>(channel)];
          sum += change * change;
          count += 1;
        }
        size = std::sqrt(sum / std::max(1.0, count)) / kNoise[static_cast<std::size_t>(channel)];
      } else {
        add_dead_time(one_lap, e);
        size = drive(one, track, one_lap, true).size;
      }
      if (!(size > 0)) break;
      if (round < 1 || std::abs(size / wanted[k] - 1) > 0.1)
        e.amount = std::copysign(std::min(chosen[k].most, std::abs(e.amount) * wanted[k] / size), e.amount);
      if (round == 1) size = std::min(wanted[k], size * 1e9);
    }
    sizes.push_back(size);
    car.effects.push_back(e);
    add_dead_time(style, e);
  }
  style.laps = laps;
  char name[16];
  std::snprintf(name, sizeof name, "%04d", id);
  Trial trial;
  trial.name = name;
  trial.kind = kinds[kind];
  trial.id = id;
  trial.track = track;
  trial.car = car;
  trial.sizes = sizes;
  trial.nominal = nominal;
  trial.style = style;
  trial.hz = hz;
  trial.alike = alike;
  write_trial(trial, dice, folder);
}

}  // namespace
}  // namespace trials

int main(int argc, char** argv) {
  if (argc == 4 && std::string(argv[1]) == "--scenario") return trials::make_scenario(argv[2], argv[3]) ? 0 : 1;
  if (argc != 4) {
    std::fprintf(stderr, "make_trials COUNT SEED DIR\nmake_trials --scenario NAME DIR\n");
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
