#include "blind.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "stated.h"
#include "write_trial.h"

namespace trials {
namespace {

using Json = nlohmann::ordered_json;

struct Choice {
  const char* mechanism;
  const char* channel;
  double unit, most;  ///< first guess and largest amount
};
const std::vector<Choice> kSingle{
    {"vehicle.turbo_lag", "", 0.4, 0.75}, {"vehicle.throttle_dead_time", "", 0.08, 0.2}, {"vehicle.brake_dead_time", "", 0.06, 0.2},
    {"vehicle.steering_dead_time", "", 0.04, 0.12}, {"vehicle.steering_lag", "", 0.05, 0.15}, {"vehicle.tyre_thermal", "", 0.15, 0.35},
    {"vehicle.brake_friction_temperature", "", 0.15, 0.5}, {"vehicle.differential", "", 0.5, 1}, {"vehicle.fuel_burn", "", 0.1, 0.3},
    {"vehicle.tyre_load_sensitivity", "", 1, 3}, {"vehicle.tyre_camber", "", 1, 2}, {"vehicle.tyre_combined_slip", "", 0.7, 1},
    {"vehicle.tyre_relaxation", "", 1.5, 6}, {"vehicle.aero_drag", "", 0.1, 1}, {"vehicle.aero_downforce", "", 0.3, 1},
    {"vehicle.aero_ride_height", "", 0.2, 0.6}, {"environment.wind", "", 4, 12}, {"road.banking", "", 0.03, 0.12}, {"road.grade", "", 0.03, 0.1},
    {"road.friction", "", -0.15, 0.4}, {"road.vertical_curvature", "", 0.002, 0.01}, {"road.misplaced", "", 8, 60},
    {"sensor.bias", "yaw_rate_radps", 0.004, 0.1}, {"sensor.bias", "ax_mps2", 0.15, 3}, {"sensor.bias", "ay_mps2", 0.15, 3},
    {"sensor.gain", "yaw_rate_radps", 0.02, 0.3}, {"sensor.gain", "ay_mps2", 0.02, 0.3}, {"sensor.gain", "ax_mps2", 0.02, 0.3},
    {"sensor.delay", "yaw_rate_radps", 0.04, 0.3}, {"sensor.delay", "ax_mps2", 0.06, 0.3}, {"sensor.delay", "ay_mps2", 0.06, 0.3},
    {"sensor.low_pass", "yaw_rate_radps", 0.06, 0.5}, {"sensor.low_pass", "ax_mps2", 0.1, 0.5},
    {"sensor.misalignment", "ax_mps2,ay_mps2", 0.03, 0.2}, {"sensor.lever_arm", "ax_mps2,ay_mps2", 0.5, 2.5}};
const std::vector<Choice> kOutside{{"outside.slip_drag", "", 1, 50}, {"outside.torque_steer", "", 1, 20}, {"outside.brake_pull", "", 1, 20},
                                   {"outside.surge", "", 0.3, 5}, {"outside.gust", "", 0.5, 8}, {"outside.misfire", "", 0.3, 1},
                                   {"outside.heading_drift", "", 1, 10}};
/// Terms of the tyre that truth and stated car may both lack.
const std::vector<std::string> kLacking{"vehicle.tyre_load_sensitivity", "vehicle.tyre_camber", "vehicle.tyre_combined_slip"};
/// Pairs that the data cannot tell apart when they are small enough. What a sensor should have said is known
/// from other channels only, whose noise grows with frequency: `reference` is the frequency's reciprocal
/// (rad/s) from which on it is larger than the sensor's own, `noise` what else they add, as a factor.
struct Pair {
  const char *one, *other, *channel;
  double reference_s, noise;
};
const double kAyOfYawRate = std::hypot(kNoise[kAy], 35 * kNoise[kR]);  // r vx at 35 m/s
const std::vector<Pair> kPairs{{"sensor.delay", "sensor.low_pass", "yaw_rate_radps", kNoise[kYaw] / kNoise[kR], 1},
                               {"sensor.delay", "sensor.low_pass", "ax_mps2", kNoise[kVx] / kNoise[kAx], 1},
                               {"sensor.delay", "sensor.low_pass", "ay_mps2", kNoise[kVy] / kAyOfYawRate, kAyOfYawRate / kNoise[kAy]}};
/// Parameters of the stated car, with what they are in the truth car.
struct Parameter {
  const char *id, *name;
  bool commanded;  ///< can be seen only where the log has commands
  void (*scale)(Variant&, double);
};
const std::vector<Parameter> kParameters{
    {"parameter.mass", "chassis.mass_kg", false, [](Variant& v, double f) { v.car.mass *= f; }},
    {"parameter.cog", "chassis.cog_behind_front_m", false, [](Variant& v, double f) { v.car.b -= v.car.a * (f - 1); v.car.a *= f; }},
    {"parameter.yaw_inertia", "chassis.yaw_inertia_kgm2", false, [](Variant& v, double f) { v.car.inertia *= f; }},
    {"parameter.drag", "aero.drag_area_m2", false, [](Variant& v, double f) { v.car.drag *= f; }},
    {"parameter.downforce", "front.lift_area_m2", false, [](Variant& v, double f) { v.car.lift_f *= f; }},
    {"parameter.downforce", "rear.lift_area_m2", false, [](Variant& v, double f) { v.car.lift_r *= f; }},
    {"parameter.engine_torque", "engine.torque", false, [](Variant& v, double f) { v.car.torque *= f; v.car.engine_drag *= f; }},
    {"parameter.brake_gain", "brake.gain", false, [](Variant& v, double f) { v.car.brake_f *= f; v.car.brake_r *= f; }},
    {"parameter.tyre_grip", "front.tyre_grip", false, [](Variant& v, double f) { v.car.mu_f *= f; }},
    {"parameter.tyre_grip", "rear.tyre_grip", false, [](Variant& v, double f) { v.car.mu_r *= f; }},
    {"parameter.tyre_stiffness", "front.tyre_cornering_stiffness", false, [](Variant& v, double f) { v.car.c_f *= f; }},
    {"parameter.tyre_stiffness", "rear.tyre_cornering_stiffness", false, [](Variant& v, double f) { v.car.c_r *= f; }},
    {"parameter.wheel_radius", "front wheel radius, share", false, [](Variant& v, double f) { v.car.radius_f *= f; }},
    {"parameter.wheel_radius", "rear wheel radius, share", false, [](Variant& v, double f) { v.car.radius_r *= f; }},
    {"parameter.steering_ratio", "steering.ratio", true, [](Variant& v, double f) { v.steer_gain /= f; }},
    {"parameter.throttle_gain", "throttle.gain", true, [](Variant& v, double f) { v.throttle_gain *= f; }}};

int channel_of(const std::string& column) { return column == "yaw_rate_radps" ? kR : column == "ay_mps2" ? kAy : column == "yaw_rad" ? kYaw : kAx; }

/// The car with these effects; what acts between driver and car becomes part of the variant.
Variant with(Variant v, const std::vector<Effect>& effects, const Track& moved) {
  v.car.effects = effects;
  for (const Effect& e : effects) {
    if (e.mechanism == "vehicle.throttle_dead_time") v.throttle_dead_s += e.amount;
    if (e.mechanism == "vehicle.brake_dead_time") v.brake_dead_s += e.amount;
    if (e.mechanism == "vehicle.steering_dead_time") v.steer_dead_s += e.amount;
    if (e.mechanism == "vehicle.steering_lag") v.steer_lag_s += e.amount;
    if (e.mechanism == "road.misplaced") v.track = &moved;
  }
  return v;
}
std::vector<Effect> nothing_of(std::vector<Effect> effects) {
  for (Effect& e : effects) e.amount = 0;
  return effects;
}

/// RMS difference that sensor effects make, in standard deviations of the noise. With `reference_s` that of
/// an observer whose reference is noisy too (see Pair): the difference behind a first-order low pass.
double sensor_size(const Drive& d, const std::vector<Effect>& a, const std::vector<Effect>& b, const std::string& column, double reference_s = 0) {
  double worst = 0;
  const std::size_t stride = 8;
  const double keep = reference_s > 0 ? std::exp(-static_cast<double>(stride) * kRow_s / reference_s) : 0;
  for (std::size_t begin = 0; begin < column.size();) {
    const std::size_t end = std::min(column.find(',', begin), column.size());
    const std::string name = column.substr(begin, end - begin);
    const int channel = channel_of(name);
    double sum = 0, count = 0, seen = 0;
    for (std::size_t i = 200; i < d.row.size(); i += stride) {
      const double change = sensed(d.row, i, channel, a, name) - sensed(d.row, i, channel, b, name);
      seen = change + keep * (seen - change);
      sum += seen * seen;
      count += 1;
    }
    worst = std::max(worst, std::sqrt(sum / std::max(1.0, count)) / kNoise[static_cast<std::size_t>(channel)]);
    begin = end + 1;
  }
  return worst;
}

}  // namespace

void draw_blind(int id, unsigned long long seed, const std::filesystem::path& folder) {
  Random dice{seed * 1000003ull + static_cast<unsigned long long>(id)};
  for (int k = 0; k < 5; ++k) dice.uniform();
  const Track track = [&] {
    Track t = make_track(dice.in(160, 300), dice.in(0.12, 0.28), dice.in(0.06, 0.16), dice.in(0.02, 0.05), dice.in(0, 6));
    for (std::size_t k = 0; k < 3; ++k) t.hill[k] = dice.in(0, 4.0 / static_cast<double>((k + 1) * (k + 1))), t.hill_phase[k] = dice.in(0, 6);
    t.bank_base = dice.in(0, 0.02);
    return t;
  }();
  Variant nominal;
  for (double* p : {&nominal.car.mass, &nominal.car.inertia, &nominal.car.mu_f, &nominal.car.mu_r, &nominal.car.c_f, &nominal.car.c_r, &nominal.car.drag,
                    &nominal.car.lift_f, &nominal.car.lift_r, &nominal.car.torque})
    *p *= dice.in(0.9, 1.1);

  const int kind = id % 8;  // 0, 1 nothing; 2, 3, 4 single; 5 two; 6 outside; 7 a pair that looks alike
  const char* kinds[] = {"none", "none", "single", "single", "single", "two", "outside", "alike"};
  const int laps = 2 + static_cast<int>(dice.below(7));
  const double hz = std::array{25.0, 50.0, 100.0}[dice.below(3)];
  const Style style{.laps = laps, .seed = seed * 7919 + static_cast<unsigned long long>(id)};
  const Style one_lap{.laps = 1, .seed = style.seed};
  const std::array<double, 4> kSizes{0.25, 0.5, 1.0, 2.0};
  std::vector<Choice> chosen;
  std::vector<double> wanted;
  std::vector<std::size_t> parameters;  // of the stated car, off by more than a few per cent
  // One in four is a parameter that is off, the others are drawn evenly.
  const auto draw = [&](std::size_t smallest) {
    if (dice.uniform() < 0.25) {
      parameters.push_back(dice.below(kParameters.size()));
      return;
    }
    chosen.push_back(kSingle[dice.below(kSingle.size())]);
    wanted.push_back(kSizes[smallest + dice.below(4 - smallest)]);
  };
  if (kind >= 2 && kind <= 4) draw(0);
  if (kind == 5)
    while (chosen.size() + parameters.size() < 2) {
      const std::size_t before = chosen.size();
      draw(1);
      if (chosen.size() == 2 && before == 1 && std::string(chosen[0].mechanism) == chosen[1].mechanism) chosen.pop_back(), wanted.pop_back();
      if (parameters.size() == 2 && std::string(kParameters[parameters[0]].id) == kParameters[parameters[1]].id) parameters.pop_back();
    }
  if (kind == 6) chosen.push_back(kOutside[dice.below(kOutside.size())]), wanted.push_back(kSizes[1 + dice.below(3)]);
  std::vector<std::string> alike;
  Pair pair{};
  bool second = false;
  if (kind == 7) {
    pair = kPairs[dice.below(kPairs.size())];
    second = dice.uniform() < 0.5;
    chosen.push_back({second ? pair.other : pair.one, pair.channel, 0.012, 0.12});
    wanted.push_back(0);
    alike = {pair.one, pair.other};
  }

  // Effects, sized. What a trial about a term is measured against is the car without it.
  Track moved = track;
  std::vector<Effect> effects;
  std::vector<double> sizes;
  double apart = 0;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    Effect e{chosen[k].mechanism, chosen[k].channel, chosen[k].unit};
    if (e.mechanism == "vehicle.turbo_lag") e.extra = dice.in(0.2, 0.6);
    if (e.mechanism == "vehicle.tyre_thermal") e.extra = dice.in(25, 90);
    if (e.mechanism == "vehicle.tyre_camber") nominal.car.camber = dice.in(0.02, 0.05);
    if (e.mechanism == "environment.wind") e.extra = dice.in(0, 6.28);
    if (e.mechanism.starts_with("road.") && e.mechanism != "road.misplaced") {
      const double length = dice.in(60, 220);
      e.begin_m = dice.in(60, track.length_m - length - 60);
      e.end_m = e.begin_m + length;
    }
    if ((e.mechanism.starts_with("road.") || e.mechanism == "sensor.bias" || e.mechanism == "sensor.gain" || e.mechanism == "sensor.misalignment") && dice.uniform() < 0.5)
      e.amount = -e.amount;
    const bool sensor = e.mechanism.starts_with("sensor.") || e.mechanism == "outside.heading_drift";
    const Drive plain = sensor ? drive(nominal, track, one_lap, nullptr) : Drive{};
    const auto size_of = [&](const Effect& x) {
      if (sensor) return sensor_size(plain, {x}, {}, x.mechanism.starts_with("outside.") ? "yaw_rad" : x.channel);
      moved.shift_m = x.mechanism == "road.misplaced" ? x.amount : 0.0;
      const Variant one = with(nominal, {x}, moved), none = with(nominal, nothing_of({x}), track);
      Variant still = none;
      still.track = &track;
      return drive(one, track, one_lap, &still).size;
    };
    double size = size_of(e);
    if (kind == 7) {
      // So small that an observer of all samples is at 1.2 standard deviations between the two. The
      // difference of two that begin alike grows with the square of the amount.
      Effect other = e;
      other.mechanism = second ? pair.one : pair.other;
      const double samples = 40.0 * laps * hz;
      for (int round = 0; round < 4; ++round) {
        other.amount = e.amount;
        apart = sensor_size(plain, {e}, {other}, e.channel, pair.reference_s) / pair.noise * std::sqrt(samples);
        if (round < 3) e.amount = std::min(chosen[k].most, e.amount * std::sqrt(1.2 / std::max(1e-3, apart)));
      }
      size = size_of(e);
    } else {
      for (int round = 0; round < 3 && size > 0 && std::abs(size / wanted[k] - 1) > 0.1; ++round) {
        e.amount = std::copysign(std::min(chosen[k].most, std::abs(e.amount) * std::clamp(wanted[k] / size, 0.1, 10.0)), e.amount);
        size = size_of(e);
      }
    }
    if (e.mechanism == "road.misplaced") moved.shift_m = e.amount;
    effects.push_back(e);
    sizes.push_back(size);
  }
  // A term that the stated car leaves out need not be missing: here and there the truth lacks it too.
  std::vector<Effect> as_driven = effects;
  std::string lacking;
  if (dice.uniform() < 0.2) {
    lacking = kLacking[dice.below(kLacking.size())];
    const bool about = std::any_of(effects.begin(), effects.end(), [&](const Effect& e) { return e.mechanism == lacking; });
    if (about) lacking.clear();
    else as_driven.push_back({lacking, "", 0.0});
    if (lacking == "vehicle.tyre_camber") nominal.car.camber = dice.in(0.02, 0.05);
  }
  const Variant real = with(nominal, as_driven, moved);
  Variant without = with(nominal, nothing_of(as_driven), track);
  without.track = &track;
  const Drive d = drive(real, track, style, nullptr);
  if (d.row.size() < kShortestDrive) {
    std::fprintf(stderr, "trial %d: no drive\n", id);
    return;
  }

  char name[16];
  std::snprintf(name, sizeof name, "%04d", id);
  const std::filesystem::path here = folder / name;
  std::filesystem::create_directories(here);
  write_road(track, track, TruthCar{}, here / "track.crg");  // as the simulation knows it

  // The stated car: a few per cent off everywhere, further in what the trial is about.
  std::vector<double> deviation;  // truth over stated, less one
  for (const Parameter& p : kParameters) deviation.push_back(p.commanded ? 0.0 : dice.in(-0.04, 0.04)), deviation.back() *= std::string(p.id) == "parameter.cog" ? 0.4 : 1.0;
  for (const std::size_t k : parameters) {
    const bool inside = kind != 5 && kind != 7 && dice.uniform() < 0.3;  // within the prior width: listed, and nothing is missing
    deviation[k] = inside ? dice.in(0.01, 0.045) : dice.in(0.12, 0.25);
    if (dice.uniform() < 0.5) deviation[k] = -deviation[k];
  }
  // An effect that tuning has hidden: the parameter that makes up for most of it is off in that direction.
  std::string compensated;
  const std::vector<std::pair<const char*, std::pair<std::size_t, double>>> kTuned{
      {"vehicle.turbo_lag", {6, 0.05}}, {"vehicle.brake_friction_temperature", {7, 0.05}}, {"vehicle.tyre_thermal", {9, 0.05}},
      {"vehicle.fuel_burn", {0, 0.04}}, {"vehicle.aero_ride_height", {5, 0.05}}};
  for (const auto& [mechanism, how] : kTuned)
    if (kind >= 2 && kind <= 4 && !effects.empty() && effects[0].mechanism == mechanism && dice.uniform() < 0.5)
      deviation[how.first] = how.second, compensated = kParameters[how.first].id;
  Variant stated = nominal, before_tuning = nominal;
  for (std::size_t k = 0; k < kParameters.size(); ++k) kParameters[k].scale(stated, 1 / (1 + deviation[k]));
  std::vector<double> parameter_sizes;
  for (const std::size_t k : parameters) {
    before_tuning = nominal;
    kParameters[k].scale(before_tuning, 1 / (1 + deviation[k]));
    parameter_sizes.push_back(drive(nominal, track, one_lap, &before_tuning).size);
  }
  const auto off = [&](double share = 0.04) { return dice.in(1 - share, 1 + share); };
  const auto shape = [&] {
    std::array<double, 8> out{};
    for (double& o : out) o = off();
    return out;
  };
  const TruthCar& t = nominal.car;
  const TruthCar& c = stated.car;
  StatedCar car;
  // The radii of the truth are rolling radii; the stated tyre rolls a little closer to the road.
  car.front = {t.load_f, c.mu_f, t.mu_load * off(0.2), c.c_f, t.ck * off(), c.radius_f * 1.0075, t.relaxation_f * off(0.2), shape()};
  car.rear = {t.load_r, c.mu_r, t.mu_load * off(0.2), c.c_r, t.ck * off(), c.radius_r * 1.0075, t.relaxation_r * off(0.2), shape()};
  car.engine = c;
  car.torque_tilt = dice.in(-0.03, 0.03);
  car.rear_brake_friction = rear_friction(c.brake_r) * off(0.02);
  car.front_brake_friction = front_friction(c.brake_f) * off(0.02);
  car.engine_inertia_kgm2 = t.engine_inertia * off();
  car.cog_height_m = t.h * off();
  car.mass_kg = c.mass;
  car.wheelbase_m = t.a + t.b;
  car.cog_behind_front_m = c.a;
  car.yaw_inertia_kgm2 = c.inertia;
  car.front_track_m = t.track_f;
  car.rear_track_m = t.track_r;
  car.drag_area_m2 = c.drag;
  car.front_lift_area_m2 = c.lift_f;
  car.rear_lift_area_m2 = c.lift_r;
  car.camber_rad = -t.camber;
  char text[300];
  std::snprintf(text, sizeof text,
                "  steering.ratio: %.4f\n  throttle.gain: %.4f\n"
                "  front.tyre_cornering_stiffness: {value: 1, prior: 0.05}\n  rear.tyre_cornering_stiffness: {value: 1, prior: 0.05}\n",
                1 / stated.steer_gain, stated.throttle_gain);
  car.last_parameters = text;
  // What a trial is about, the stated car leaves out.
  std::string terms;
  for (const std::string term : {"aero_drag", "aero_downforce", "tyre_load_sensitivity", "tyre_combined_slip", "tyre_relaxation"}) {
    const bool left_out = std::any_of(as_driven.begin(), as_driven.end(), [&](const Effect& e) { return e.mechanism == "vehicle." + term; });
    terms += term + (left_out ? ": 0, " : ": 1, ");
  }
  car.terms = terms + kTermsOff;
  write_car(car, here);

  // The recording. Some logs lack channels; what a trial is about stays in.
  const auto about = [&](const char* what) {
    return std::any_of(effects.begin(), effects.end(), [&](const Effect& e) { return e.mechanism == what || e.channel.find(what) != std::string::npos; });
  };
  Logged logged;
  logged.axle_loads = dice.uniform() < 0.3;
  logged.az = dice.uniform() < 0.5 || about("road.vertical_curvature");
  logged.engine = dice.uniform() < 0.6;
  logged.gear = dice.uniform() < 0.85;
  logged.engine |= !logged.gear;
  logged.ax = dice.uniform() < 0.85 || about("ax_mps2");
  logged.ay = dice.uniform() < 0.8 || about("ay_mps2");
  logged.vy = dice.uniform() < 0.92 || !effects.empty() || !parameters.empty();  // side slip is rarely logged in earnest
  logged.commands = dice.uniform() < 0.4 || about("vehicle.steering_dead_time") || about("vehicle.steering_lag") ||
                    kind == 7 || std::any_of(parameters.begin(), parameters.end(), [](std::size_t k) { return kParameters[k].commanded; });
  const std::vector<Column> logged_columns = columns(logged);
  const auto log = [&](const Drive& run, const std::vector<Effect>& errors, Random noise) { return csv(run.row, logged_columns, hz, errors, noise); };
  const Random noise = dice;
  write(here / "run.csv", log(d, effects, noise));
  if (!effects.empty() && kind != 7) {
    const Drive clean = drive(without, track, style, nullptr);
    if (clean.row.size() >= kShortestDrive) write(folder / "sealed" / (std::string(name) + ".csv"), log(clean, {}, noise));
  }

  Json truth{{"id", id}, {"class", kinds[kind]}, {"laps", laps}, {"hz", hz}, {"length_m", track.length_m}, {"effects", Json::array()}, {"alike", alike},
             {"apart_sd", apart}, {"compensated", compensated}, {"lacking", lacking}, {"parameters", Json::array()}};
  for (std::size_t k = 0; k < effects.size(); ++k) truth["effects"].push_back(truth_of(effects[k], sizes[k]));
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const Parameter& p = kParameters[parameters[k]];
    truth["effects"].push_back({{"mechanism", p.id}, {"name", p.name}, {"channel", ""}, {"amount", deviation[parameters[k]]}, {"size_sd", parameter_sizes[k]}});
  }
  for (std::size_t k = 0; k < kParameters.size(); ++k) truth["parameters"].push_back({{"name", kParameters[k].name}, {"deviation", deviation[k]}});
  write(folder / "sealed" / (std::string(name) + ".json"), truth.dump(1) + "\n");
}

}  // namespace trials

