#include "vehicle/signal_sensors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/settings.h"
#include "longest_delay.h"
#include "mounted_motion.h"
#include "read_road_sensors.h"
#include "vehicle/error.h"

namespace vehicle {
namespace {

constexpr double kMostDelaySteps = 1e6;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

std::string device_of(const std::string& sensor) { return sensor.substr(0, sensor.rfind('.')); }

SignalSensor read_sensor(const base::Section& entry, const std::string& name,
                         const std::string& where) {
  entry.allow({"signal", "rate_hz", "delay_s", "jitter_s", "gain", "offset", "noise",
               "noise_density", "bias_walk", "bias_instability", "bias_time_s", "quantisation",
               "smallest", "largest", "lost", "at_m", "turned_deg"});
  SignalSensor out;
  out.name = name;
  out.signal = entry.text("signal");
  out.rate_hz = entry.number("rate_hz", 0.0, 0.0, 1e5);
  out.delay_s = entry.number("delay_s", 0.0, 0.0, kLongestDelay_s);
  out.jitter_s = entry.number("jitter_s", 0.0, 0.0, kLongestDelay_s);
  out.gain = entry.number("gain", 1.0, -1e6, 1e6);
  out.offset = entry.number("offset", 0.0, -1e9, 1e9);
  out.noise = entry.number("noise", 0.0, 0.0, 1e9);
  out.noise_density = entry.number("noise_density", 0.0, 0.0, 1e9);
  out.bias_walk = entry.number("bias_walk", 0.0, 0.0, 1e9);
  out.bias_instability = entry.number("bias_instability", 0.0, 0.0, 1e9);
  out.bias_time_s = entry.number("bias_time_s", 100.0, 1e-3, 1e6);
  out.quantisation = entry.number("quantisation", 0.0, 0.0, 1e9);
  out.smallest = entry.number("smallest", -kInfinite, -1e12, 1e12);
  out.largest = entry.number("largest", kInfinite, -1e12, 1e12);
  out.lost = entry.number("lost", 0.0, 0.0, 1.0);
  if (entry.has("at_m") || entry.has("turned_deg"))
    out.mounting = read_mounting(entry, name, where);
  const auto refuse = [&](const std::string& what) {
    throw Error(fmt::format("{}: {}: {}", where, name.substr(0, 60), what));
  };
  if (!(out.smallest < out.largest)) refuse("smallest has to be below largest");
  if (out.jitter_s > 0.0 && !(out.jitter_s * out.rate_hz < 1.0 && out.rate_hz > 0.0))
    refuse("jitter_s has to be less than the time between two samples, 1 / rate_hz");
  return out;
}

SignalCommand read_command(const base::Section& entry, const std::string& name,
                           const std::string& where) {
  entry.allow({"signal", "gain", "offset", "smallest", "largest", "dead_time_s", "lag_s", "damping",
               "lead_s"});
  SignalCommand out;
  out.name = name;
  out.signal = entry.text("signal");
  out.gain = entry.number("gain", 1.0, -1e12, 1e12);
  out.offset = entry.number("offset", 0.0, -1e12, 1e12);
  out.smallest = entry.number("smallest", -kInfinite, -1e12, 1e12);
  out.largest = entry.number("largest", kInfinite, -1e12, 1e12);
  out.dead_time_s = entry.number("dead_time_s", 0.0, 0.0, 5.0);
  out.lag_s = entry.number("lag_s", 0.0, 0.0, 10.0);
  out.damping = entry.number("damping", 1.0, 0.05, 100.0);
  out.lead_s = entry.number("lead_s", 0.0, -10.0, 10.0);
  if (out.gain == 0.0)
    throw Error(fmt::format("{}: {}: a gain of 0 commands nothing", where, name.substr(0, 60)));
  if (!(out.smallest < out.largest))
    throw Error(fmt::format("{}: {}: smallest has to be below largest", where, name.substr(0, 60)));
  return out;
}

/// Of the car: 0 to 5 its pose, 6 to 8 its speed, 9 to 11 its turning, 12 to 14 its acceleration.
constexpr std::size_t kSpeed = 6, kTurning = 9, kAcceleration = 12, kOfCar = 15;

const std::string& name_of_car(const SignalSensorFile& file, std::size_t k) {
  return k < kSpeed ? file.road.pose[k] : file.road.motion[k - kSpeed];
}

/// Which number of the car the sensor is of. Throws Error where it is none.
std::size_t of_car(const SignalSensorFile& file, const SignalSensor& sensor) {
  std::string names;
  for (std::size_t k = 0; k < kOfCar; ++k) {
    if (name_of_car(file, k) == sensor.signal) return k;
    if (!name_of_car(file, k).empty()) names += (k > 0 ? ", " : "") + name_of_car(file, k);
  }
  throw Error(fmt::format(
      "the sensor {} has a place or axes in the car (at_m, turned_deg), which change nothing of "
      "{}; wanted one of {}, or other names for these by pose",
      sensor.name, sensor.signal, names));
}

/// What places in the car need to know for this number of it.
bool needs(std::size_t wanted, std::size_t k) {
  const bool is_turning = k >= kTurning && k < kAcceleration;
  if (wanted < kSpeed) return k < kSpeed;
  if (wanted < kTurning) return (k >= kSpeed && k < kTurning) || is_turning;
  return is_turning || (wanted >= kAcceleration && k >= kAcceleration);
}

/// Those of the car that its sensors need.
std::vector<std::size_t> needed_of_car(const SignalSensorFile& file) {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < kOfCar; ++k)
    if (!name_of_car(file, k).empty() &&
        std::any_of(file.sensors.begin(), file.sensors.end(), [&](const SignalSensor& sensor) {
          return sensor.mounting && needs(of_car(file, sensor), k);
        }))
      out.push_back(k);
  return out;
}

SignalTopic read_topic(const base::Section& entry, const std::string& name) {
  entry.allow({"type", "frame", "child_frame", "fields"});
  SignalTopic out;
  out.name = name;
  out.type = entry.text("type");
  if (entry.has("frame")) out.frame = entry.text("frame");
  if (entry.has("child_frame")) out.child_frame = entry.text("child_frame");
  entry.section("fields").for_each(
      [&](const std::string& field, const base::Setting& value, const std::string& where) {
        if (value.kind != base::Setting::Kind::kWord)
          throw Error(fmt::format("{}: {} is no name and no number", where, field.substr(0, 60)));
        out.fields.emplace_back(field, value.word);
      });
  return out;
}

}  // namespace

double SignalCommand::to_signal(double value) const {
  return std::clamp(gain * value + offset, smallest, largest);
}

SignalSensorFile read_signal_sensors(const std::string& path) {
  const base::Setting root = base::read_settings(path);
  const base::Section top(root, path, "a file of sensors and commands");
  top.allow({"seed", "sensors", "commands", "positions", "topics", "scans", "edges", "pose"});
  SignalSensorFile out;
  out.seed = static_cast<std::uint64_t>(top.number("seed", 1.0, 0.0, 9e15));
  if (top.has("sensors"))
    top.section("sensors").for_each(
        [&](const std::string& name, const base::Setting& value, const std::string& where) {
          out.sensors.push_back(read_sensor(base::Section(value, path, name), name, where));
        });
  if (top.has("commands"))
    top.section("commands")
        .for_each(
            [&](const std::string& name, const base::Setting& value, const std::string& where) {
              out.commands.push_back(read_command(base::Section(value, path, name), name, where));
            });
  const auto sensor = [&](const std::string& name, const std::string& where) {
    for (std::size_t k = 0; k < out.sensors.size(); ++k)
      if (out.sensors[k].name == name) return k;
    throw Error(fmt::format("{}: there is no sensor '{}' in this file", where, name.substr(0, 60)));
  };
  if (top.has("positions"))
    top.section("positions")
        .for_each(
            [&](const std::string& name, const base::Setting& value, const std::string& where) {
              const base::Section entry(value, path, name);
              entry.allow({"x", "y"});
              out.positions.push_back(
                  {name, sensor(entry.text("x"), where), sensor(entry.text("y"), where)});
            });
  if (top.has("topics"))
    top.section("topics").for_each(
        [&](const std::string& name, const base::Setting& value, const std::string&) {
          out.topics.push_back(read_topic(base::Section(value, path, name), name));
        });
  out.road = read_road_sensors(top);
  if (out.sensors.empty() && out.commands.empty() && out.topics.empty() && out.road.empty())
    throw Error(path + ": no sensor, no command, no topic, no scan and no edges");
  return out;
}

std::vector<std::string> SignalSensors::signals(const SignalSensorFile& file) {
  std::vector<std::string> out;
  for (const SignalSensor& sensor : file.sensors) out.push_back(sensor.signal);
  for (const std::size_t k : needed_of_car(file)) out.push_back(name_of_car(file, k));
  return out;
}

SignalSensors::SignalSensors(const SignalSensorFile& file, double step_s)
    : of_car_(needed_of_car(file)), step_s_(step_s) {
  for (const SignalSensor& sensor : file.sensors) {
    if (sensor.rate_hz * step_s > 1.0 + 1e-9)
      throw Error(
          fmt::format("the sensor {} samples {} times a second, and a step is {} s: at most "
                      "one sample per step",
                      sensor.name, sensor.rate_hz, step_s));
    if (!(sensor.delay_s >= 0.0 && sensor.delay_s <= kLongestDelay_s &&
          sensor.delay_s <= kMostDelaySteps * step_s))
      throw Error(fmt::format("the sensor {} has a delay of {} s, wanted 0 to {} s", sensor.name,
                              sensor.delay_s, std::min(kLongestDelay_s, kMostDelaySteps * step_s)));
    Running running;
    running.is = sensor;
    if (sensor.mounting) running.of_car = of_car(file, sensor);
    running.random = base::random_of(file.seed, sensor.name);
    running.clock = base::random_of(file.seed, "clock of " + device_of(sensor.name));
    running.past.resize(static_cast<std::size_t>(std::llround(sensor.delay_s / step_s)) + 1);
    const double rate_hz = sensor.rate_hz > 0.0 ? sensor.rate_hz : 1.0 / step_s;
    running.noise = std::hypot(sensor.noise, sensor.noise_density * std::sqrt(rate_hz));
    running.unstable = sensor.bias_instability * running.random.normal();
    sensors_.push_back(std::move(running));
  }
}

std::vector<double> SignalSensors::at_their_places(std::span<const double> truth) {
  std::vector<double> out(truth.begin(),
                          truth.begin() + static_cast<std::ptrdiff_t>(sensors_.size()));
  if (of_car_.empty()) return out;
  std::array<double, kOfCar> told{};
  for (std::size_t k = 0; k < of_car_.size(); ++k) told[of_car_[k]] = truth[sensors_.size() + k];
  const auto three = [&](std::size_t at) {
    return Vec3<double>{told[at], told[at + 1], told[at + 2]};
  };
  const PointMotion car{
      three(0), {told[3], told[4], told[5]}, three(kSpeed), three(kTurning), three(kAcceleration)};
  std::array<double, 3> change{};
  for (std::size_t k = 0; k < change.size(); ++k) {
    if (steps_ > 0) change[k] = (told[kTurning + k] - last_turning_[k]) / step_s_;
    last_turning_[k] = told[kTurning + k];
  }
  for (std::size_t k = 0; k < sensors_.size(); ++k) {
    if (!sensors_[k].is.mounting) continue;
    const Mounting& at = *sensors_[k].is.mounting;
    const PointMotion box = mounted(car, change, at.at_m, at.turned_rad);
    const std::array<Vec3<double>, 5> all{box.place_m,
                                          {box.angle_rad[0], box.angle_rad[1], box.angle_rad[2]},
                                          box.speed_mps,
                                          box.turning_radps,
                                          box.acceleration_mps2};
    const Vec3<double>& of = all[sensors_[k].of_car / 3];
    out[k] = std::array{of.x, of.y, of.z}[sensors_[k].of_car % 3];
  }
  return out;
}

void SignalSensors::step(std::span<const double> told) {
  const std::vector<double> truth = at_their_places(told);
  for (std::size_t k = 0; k < sensors_.size(); ++k) {
    Running& sensor = sensors_[k];
    // Before the run everything was as at its begin.
    if (steps_ == 0) std::fill(sensor.past.begin(), sensor.past.end(), truth[k]);
    sensor.past[steps_ % sensor.past.size()] = truth[k];
    // Half a step, so that the rounding of times decides nothing.
    if (static_cast<double>(steps_) * step_s_ >= sensor.due_s - 0.5 * step_s_) sample(sensor);
  }
  ++steps_;
}

void SignalSensors::sample(Running& sensor) {
  const SignalSensor& is = sensor.is;
  const double between_s = is.rate_hz > 0.0 ? 1.0 / is.rate_hz : step_s_;
  // Drawn in any case, so that no parameter changes the stream of another one.
  const double white = sensor.random.normal(), walk = sensor.random.normal(),
               unstable = sensor.random.normal();
  const double late = sensor.clock.uniform(), arrives = sensor.clock.uniform();
  if (sensor.samples > 0) {
    sensor.walked += is.bias_walk * std::sqrt(between_s) * walk;
    const double kept = std::exp(-between_s / is.bias_time_s);
    sensor.unstable =
        kept * sensor.unstable + is.bias_instability * std::sqrt(1.0 - kept * kept) * unstable;
  }
  ++sensor.samples;
  sensor.due_s = static_cast<double>(sensor.samples) * between_s + is.jitter_s * late;
  if (arrives < is.lost && sensor.samples > 1) return;
  const double truth = sensor.past[(steps_ + 1) % sensor.past.size()];  // the oldest one
  double value =
      is.gain * truth + is.offset + sensor.walked + sensor.unstable + sensor.noise * white;
  if (is.quantisation > 0.0) value = is.quantisation * std::round(value / is.quantisation);
  sensor.value = std::clamp(value, is.smallest, is.largest);
  sensor.of_step = steps_;
}

double SignalSensors::age_s(std::size_t sensor) const {
  const Running& is = sensors_[sensor];
  return is.is.delay_s + step_s_ * static_cast<double>(steps_ > 0 ? steps_ - 1 - is.of_step : 0);
}

}  // namespace vehicle
