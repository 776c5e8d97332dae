#include "blind_effects.h"

#include <algorithm>

#include "blind_car.h"

namespace trials {
namespace {

const std::vector<Choice> kSingle{{"vehicle.turbo_lag", "", 0.4, 0.75},
                                  {"vehicle.throttle_dead_time", "", 0.08, 0.2},
                                  {"vehicle.brake_dead_time", "", 0.06, 0.2},
                                  {"vehicle.steering_dead_time", "", 0.04, 0.12},
                                  {"vehicle.steering_lag", "", 0.05, 0.15},
                                  {"vehicle.tyre_thermal", "", 0.15, 0.35},
                                  {"vehicle.brake_friction_temperature", "", 0.15, 0.5},
                                  {"vehicle.differential", "", 0.5, 1},
                                  {"vehicle.fuel_burn", "", 0.1, 0.3},
                                  {"vehicle.tyre_load_sensitivity", "", 1, 3},
                                  {"vehicle.tyre_camber", "", 1, 2},
                                  {"vehicle.tyre_combined_slip", "", 0.7, 1},
                                  {"vehicle.tyre_relaxation", "", 1.5, 6},
                                  {"vehicle.aero_drag", "", 0.1, 1},
                                  {"vehicle.aero_downforce", "", 0.3, 1},
                                  {"vehicle.aero_ride_height", "", 0.2, 0.6},
                                  {"environment.wind", "", 4, 12},
                                  {"road.banking", "", 0.03, 0.12},
                                  {"road.grade", "", 0.03, 0.1},
                                  {"road.friction", "", -0.15, 0.4},
                                  {"road.vertical_curvature", "", 0.002, 0.01},
                                  {"road.misplaced", "", 8, 60},
                                  {"sensor.bias", "yaw_rate_radps", 0.004, 0.1},
                                  {"sensor.bias", "ax_mps2", 0.15, 3},
                                  {"sensor.bias", "ay_mps2", 0.15, 3},
                                  {"sensor.gain", "yaw_rate_radps", 0.02, 0.3},
                                  {"sensor.gain", "ay_mps2", 0.02, 0.3},
                                  {"sensor.gain", "ax_mps2", 0.02, 0.3},
                                  {"sensor.delay", "yaw_rate_radps", 0.04, 0.3},
                                  {"sensor.delay", "ax_mps2", 0.06, 0.3},
                                  {"sensor.delay", "ay_mps2", 0.06, 0.3},
                                  {"sensor.low_pass", "yaw_rate_radps", 0.06, 0.5},
                                  {"sensor.low_pass", "ax_mps2", 0.1, 0.5},
                                  {"sensor.misalignment", "ax_mps2,ay_mps2", 0.03, 0.2},
                                  {"sensor.lever_arm", "ax_mps2,ay_mps2", 0.5, 2.5}};
const std::vector<Choice> kOutside{
    {"outside.slip_drag", "", 1, 50},    {"outside.torque_steer", "", 1, 20},
    {"outside.brake_pull", "", 1, 20},   {"outside.surge", "", 0.3, 5},
    {"outside.gust", "", 0.5, 8},        {"outside.misfire", "", 0.3, 1},
    {"outside.heading_drift", "", 1, 10}};
const double kAyOfYawRate = std::hypot(kNoise[kAy], 35 * kNoise[kR]);  // r vx at 35 m/s
const std::vector<Pair> kPairs{
    {"sensor.delay", "sensor.low_pass", "yaw_rate_radps", kNoise[kYaw] / kNoise[kR], 1},
    {"sensor.delay", "sensor.low_pass", "ax_mps2", kNoise[kVx] / kNoise[kAx], 1},
    {"sensor.delay", "sensor.low_pass", "ay_mps2", kNoise[kVy] / kAyOfYawRate,
     kAyOfYawRate / kNoise[kAy]}};
const std::array<double, 4> kSizes_sd{0.25, 0.5, 1.0, 2.0};

int channel_of(const std::string& column) {
  return column == "yaw_rate_radps" ? kR
         : column == "ay_mps2"      ? kAy
         : column == "yaw_rad"      ? kYaw
                                    : kAx;
}

/// RMS difference that sensor effects make, in standard deviations of the noise. With `reference_s`
/// that of an observer whose reference is noisy too (see Pair): the difference behind a first-order
/// low pass.
double sensor_size(const std::vector<Row>& rows, const std::vector<Effect>& a,
                   const std::vector<Effect>& b, const std::string& column,
                   double reference_s = 0) {
  double worst = 0;
  const std::size_t stride = 8;
  const double keep =
      reference_s > 0 ? std::exp(-static_cast<double>(stride) * kRow_s / reference_s) : 0;
  for (std::size_t begin = 0; begin < column.size();) {
    const std::size_t end = std::min(column.find(',', begin), column.size());
    const std::string name = column.substr(begin, end - begin);
    const int channel = channel_of(name);
    double sum = 0, count = 0, seen = 0;
    for (std::size_t i = 200; i < rows.size(); i += stride) {
      const double change = sensed(rows, i, channel, a, name) - sensed(rows, i, channel, b, name);
      seen = change + keep * (seen - change);
      sum += seen * seen;
      count += 1;
    }
    worst = std::max(
        worst, std::sqrt(sum / std::max(1.0, count)) / kNoise[static_cast<std::size_t>(channel)]);
    begin = end + 1;
  }
  return worst;
}

bool is_of_sensor(const Effect& e) {
  return e.mechanism.starts_with("sensor.") || e.mechanism == "outside.heading_drift";
}

/// The first guess: where it acts, in which direction, how fast.
Effect draw_effect(const Choice& choice, const Track& track, Variant& nominal, Random& dice) {
  Effect e{choice.mechanism, choice.channel, choice.unit};
  if (e.mechanism == "vehicle.turbo_lag") e.extra = dice.in(0.2, 0.6);
  if (e.mechanism == "vehicle.tyre_thermal") e.extra = dice.in(25, 90);
  if (e.mechanism == "vehicle.tyre_camber") nominal.car.camber = dice.in(0.02, 0.05);
  if (e.mechanism == "environment.wind") e.extra = dice.in(0, 6.28);
  const bool road = e.mechanism.starts_with("road.");
  if (road && e.mechanism != "road.misplaced") {
    const double length = dice.in(60, 220);
    e.begin_m = dice.in(60, track.length_m - length - 60);
    e.end_m = e.begin_m + length;
  }
  const bool either_sign = road || e.mechanism == "sensor.bias" || e.mechanism == "sensor.gain" ||
                           e.mechanism == "sensor.misalignment";
  if (either_sign && dice.uniform() < 0.5) e.amount = -e.amount;
  return e;
}

/// Of an effect that the drive feels.
double driven_size(const Effect& e, const Track& track, const Style& one_lap,
                   const Variant& nominal) {
  Track moved = track;
  if (e.mechanism == "road.misplaced") moved.shift_m = e.amount;
  const Variant one = with(nominal, {e}, moved), none = without(nominal, {e}, track);
  return drive(one, track, one_lap, &none).size;
}

/// Makes an effect of a pair so small that an observer of all samples is at 1.2 standard deviations
/// between the two, and returns at how many he is. The difference of two that begin alike grows
/// with the square of the amount.
double shrink(Effect& e, const Question& question, const std::vector<Row>& rows, double samples) {
  const Pair& pair = question.pair;
  double apart_sd = 0;
  for (int round = 0; round < 4; ++round) {
    Effect other = e;
    other.mechanism = question.second ? pair.one : pair.other;
    apart_sd = sensor_size(rows, {e}, {other}, e.channel, pair.reference_s) / pair.noise *
               std::sqrt(samples);
    if (round < 3)
      e.amount =
          std::min(question.chosen[0].most, e.amount * std::sqrt(1.2 / std::max(1e-3, apart_sd)));
  }
  return apart_sd;
}

/// One in four is a parameter that is off, the others are drawn evenly.
void draw_one(Question& q, std::size_t smallest, Random& dice) {
  if (dice.uniform() < 0.25) {
    q.parameters.push_back(dice.below(kParameters.size()));
    return;
  }
  q.chosen.push_back(kSingle[dice.below(kSingle.size())]);
  q.wanted_sd.push_back(kSizes_sd[smallest + dice.below(kSizes_sd.size() - smallest)]);
}

}  // namespace

Question choose(const std::string& kind, Random& dice) {
  Question q;
  q.kind = kind;
  if (kind == "single") draw_one(q, 0, dice);
  while (kind == "two" && q.chosen.size() + q.parameters.size() < 2) {
    draw_one(q, 1, dice);
    if (q.chosen.size() == 2 && std::string(q.chosen[0].mechanism) == q.chosen[1].mechanism)
      q.chosen.pop_back(), q.wanted_sd.pop_back();
    if (q.parameters.size() == 2 &&
        std::string(kParameters[q.parameters[0]].id) == kParameters[q.parameters[1]].id)
      q.parameters.pop_back();
  }
  if (kind == "outside") {
    q.chosen.push_back(kOutside[dice.below(kOutside.size())]);
    q.wanted_sd.push_back(kSizes_sd[1 + dice.below(3)]);
  }
  if (kind == "alike") {
    q.pair = kPairs[dice.below(kPairs.size())];
    q.second = dice.uniform() < 0.5;
    q.chosen.push_back({q.second ? q.pair.other : q.pair.one, q.pair.channel, 0.012, 0.12});
    q.wanted_sd.push_back(0);
  }
  return q;
}

Sized size_effects(const Question& question, const Track& track, const Style& style, double hz,
                   Variant& nominal, Random& dice) {
  const Style one_lap{.laps = 1, .seed = style.seed};
  Sized out;
  for (std::size_t k = 0; k < question.chosen.size(); ++k) {
    const Choice& choice = question.chosen[k];
    Effect e = draw_effect(choice, track, nominal, dice);
    const bool of_sensor = is_of_sensor(e);
    const Drive plain = of_sensor ? drive(nominal, track, one_lap, nullptr) : Drive{};
    const auto size_of = [&] {
      return of_sensor ? sensor_size(plain.row, {e}, {}, e.channel.empty() ? "yaw_rad" : e.channel)
                       : driven_size(e, track, one_lap, nominal);
    };
    if (question.kind == "alike")
      out.apart_sd = shrink(e, question, plain.row, 40.0 * style.laps * hz);
    double size = size_of();
    const double wanted = question.wanted_sd[k];
    for (int round = 0; round < 3 && wanted > 0 && size > 0 && std::abs(size / wanted - 1) > 0.1;
         ++round) {
      e.amount = std::copysign(
          std::min(choice.most, std::abs(e.amount) * std::clamp(wanted / size, 0.1, 10.0)),
          e.amount);
      size = size_of();
    }
    // A second effect that the drive feels moves the road back: the sealed sets are drawn so.
    if (!of_sensor) out.shift_m = e.mechanism == "road.misplaced" ? e.amount : 0.0;
    out.effects.push_back(e);
    out.sizes_sd.push_back(size);
  }
  return out;
}

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

Variant without(const Variant& v, std::vector<Effect> effects, const Track& track) {
  for (Effect& e : effects) e.amount = 0;
  return with(v, effects, track);
}

bool is_about(const std::vector<Effect>& effects, const std::string& mechanism) {
  return std::any_of(effects.begin(), effects.end(),
                     [&](const Effect& e) { return e.mechanism == mechanism; });
}

}  // namespace trials
