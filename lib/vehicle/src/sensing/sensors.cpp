#include "vehicle/sensors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/settings.h"
#include "longest_delay.h"
#include "mounted_motion.h"
#include "recording/channels.h"
#include "vehicle/error.h"

namespace vehicle {
namespace {

std::size_t column_of(const char* name) {
  const auto& names = recording::telemetry_channels();
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

/// A normal deviate by Box and Muller; the standard library's differs between its makers.
double gaussian(base::Random& random) {
  const double u = (static_cast<double>(random.next() >> 11) + 1.0) / 9007199254740993.0;
  const double v = static_cast<double>(random.next() >> 11) / 9007199254740992.0;
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}

}  // namespace

DeviceFile read_devices(const std::string& path) {
  const base::Setting root = base::read_settings(path);
  const base::Section top(root, path, "a device configuration");
  top.allow({"seed", "between_samples", "others", "devices"});
  DeviceFile out;
  out.seed = static_cast<std::uint64_t>(top.number("seed", 1.0, 0.0, 9e15));
  const auto word = [&](const char* key, const char* first, const char* second) {
    const std::string text = top.has(key) ? top.text(key) : first;
    if (text != first && text != second)
      throw Error(fmt::format("{}: {} = '{}', wanted {} or {}", path, key, text.substr(0, 40),
                              first, second));
    return text == second;
  };
  out.hold = word("between_samples", "empty", "hold");
  out.others_ideal = !word("others", "ideal", "absent");
  std::vector<std::string> taken;
  top.section("devices").for_each([&](const std::string& name, const base::Setting& value,
                                      const std::string& where) {
    const base::Section entry(value, path, name);
    entry.allow({"rate_hz", "delay_s", "low_pass_hz", "mounting_rad", "lever_arm_m", "channels"});
    Device device;
    device.name = name;
    device.rate_hz = entry.number("rate_hz", 0.0, 0.0, 1e5);
    device.delay_s = entry.number("delay_s", 0.0, 0.0, kLongestDelay_s);
    device.low_pass_hz = entry.number("low_pass_hz", 0.0, 0.0, 1e5);
    const auto three = [&](const char* key, std::array<double, 3>& to) {
      const std::vector<double> numbers = entry.numbers(key, 3);
      if (!numbers.empty()) std::copy(numbers.begin(), numbers.end(), to.begin());
    };
    three("mounting_rad", device.mounting_rad);
    three("lever_arm_m", device.lever_arm_m);
    entry.section("channels")
        .for_each([&](const std::string& channel, const base::Setting& of, const std::string& at) {
          const auto& known = recording::telemetry_channels();
          if (channel == "time_s" || std::find(known.begin(), known.end(), channel) == known.end())
            throw Error(
                fmt::format("{}: there is no channel '{}' to measure", at, channel.substr(0, 60)));
          if (std::find(taken.begin(), taken.end(), channel) != taken.end())
            throw Error(fmt::format("{}: {} is measured twice", at, channel));
          taken.push_back(channel);
          ChannelSensor sensor;
          sensor.channel = channel;
          if (of.kind != base::Setting::Kind::kNothing) {
            const base::Section numbers(of, path, channel);
            numbers.allow({"gain", "bias", "noise", "quantisation"});
            sensor.gain = numbers.number("gain", 1.0, -1e6, 1e6);
            sensor.bias = numbers.number("bias", 0.0, -1e9, 1e9);
            sensor.noise = numbers.number("noise", 0.0, 0.0, 1e9);
            sensor.quantisation = numbers.number("quantisation", 0.0, 0.0, 1e9);
          }
          device.channels.push_back(std::move(sensor));
        });
    if (device.channels.empty())
      throw Error(fmt::format("{}: the device {} measures nothing", where, name.substr(0, 60)));
    out.devices.push_back(std::move(device));
  });
  return out;
}

SensorRecorder::SensorRecorder(const DeviceFile& file, std::size_t every, double step_s)
    : every_(std::max<std::size_t>(1, every)), step_s_(step_s), hold_(file.hold) {
  const auto& names = recording::telemetry_channels();
  measured_.assign(names.size(), 0);
  for (const Device& device : file.devices) {
    if (!(device.delay_s >= 0.0 && device.delay_s <= kLongestDelay_s))
      throw Error(fmt::format("device {}: delay of {} s, wanted 0 to {} s", device.name,
                              device.delay_s, kLongestDelay_s));
    Box box;
    box.device = device;
    for (const ChannelSensor& sensor : device.channels) {
      Channel channel;
      channel.column = column_of(sensor.channel.c_str());
      channel.sensor = sensor;
      channel.random = base::random_of(file.seed, sensor.channel);
      channel.ring.assign(static_cast<std::size_t>(device.delay_s / step_s) + 2, 0.0);
      measured_[channel.column] = 1;
      box.channels.push_back(std::move(channel));
    }
    boxes_.push_back(std::move(box));
  }
  for (std::size_t c = 0; c < names.size(); ++c) {
    const bool always = c == 0 || names[c].find("command") != std::string::npos;
    if (measured_[c] == 0 && !file.others_ideal && !always) continue;
    kept_.push_back(c);
    table_.add(names[c], {});
  }
}

void SensorRecorder::move_and_turn(const Device& device, std::vector<double>& row,
                                   double vz_mps) const {
  static const std::size_t kPlace = column_of("x_m"), kAngle = column_of("roll_rad"),
                           kSpeed = column_of("vx_mps"), kTurning = column_of("roll_rate_radps"),
                           kForce = column_of("ax_mps2");
  const auto three = [&](std::size_t at) {
    return Vec3<double>{row[at], row[at + 1], row[at + 2]};
  };
  const PointMotion car{three(kPlace),
                        {row[kAngle], row[kAngle + 1], row[kAngle + 2]},
                        {row[kSpeed], row[kSpeed + 1], vz_mps},
                        three(kTurning),
                        three(kForce)};
  const PointMotion box = mounted(car, turning_change_, device.lever_arm_m, device.mounting_rad);
  const auto put = [&](std::size_t at, const Vec3<double>& v) {
    row[at] = v.x;
    row[at + 1] = v.y;
    row[at + 2] = v.z;
  };
  put(kPlace, box.place_m);
  row[kSpeed] = box.speed_mps.x;
  row[kSpeed + 1] = box.speed_mps.y;
  put(kForce, box.acceleration_mps2);
  put(kTurning, box.turning_radps);
  put(kAngle, {box.angle_rad[0], box.angle_rad[1], box.angle_rad[2]});
}

void SensorRecorder::record(const std::vector<double>& row, double vz_mps) {
  static const std::size_t kTurning = column_of("roll_rate_radps");
  const std::array<double, 3> turning{row[kTurning], row[kTurning + 1], row[kTurning + 2]};
  for (std::size_t k = 0; k < 3; ++k)
    turning_change_[k] = step_ == 0 ? 0.0 : (turning[k] - last_turning_[k]) / step_s_;
  last_turning_ = turning;
  const bool due_row = step_ % static_cast<std::int64_t>(every_) == 0;
  row_ = row;
  for (Box& box : boxes_) {
    moved_ = row;
    move_and_turn(box.device, moved_, vz_mps);
    const double now_s = static_cast<double>(step_) * step_s_;
    const bool due = box.device.rate_hz > 0.0
                         ? now_s * box.device.rate_hz >= static_cast<double>(box.samples) - 1e-6
                         : due_row;
    const double keep = box.device.low_pass_hz > 0.0
                            ? std::exp(-2.0 * std::numbers::pi * box.device.low_pass_hz * step_s_)
                            : 0.0;
    for (Channel& channel : box.channels) {
      const double value = moved_[channel.column];
      channel.filtered = step_ == 0 ? value : value + keep * (channel.filtered - value);
      const auto size = static_cast<std::int64_t>(channel.ring.size());
      if (step_ == 0) std::fill(channel.ring.begin(), channel.ring.end(), value);
      channel.ring[static_cast<std::size_t>(step_ % size)] = channel.filtered;
      if (!due) continue;
      const double back = box.device.delay_s / step_s_;
      const auto whole = static_cast<std::int64_t>(back);
      const auto at = [&](std::int64_t steps) {
        return channel.ring[static_cast<std::size_t>(((step_ - steps) % size + size) % size)];
      };
      double out = at(whole);
      if (back > static_cast<double>(whole))
        out += (back - static_cast<double>(whole)) * (at(whole + 1) - out);
      const ChannelSensor& s = channel.sensor;
      out = s.gain * out + s.bias;
      if (s.noise > 0.0) out += s.noise * gaussian(channel.random);
      if (s.quantisation > 0.0) out = s.quantisation * std::round(out / s.quantisation);
      channel.sampled = out;
    }
    if (due) {
      ++box.samples;
      box.fresh = true;
    }
    if (!due_row) continue;
    for (const Channel& channel : box.channels)
      row_[channel.column] =
          box.fresh || hold_ ? channel.sampled : std::numeric_limits<double>::quiet_NaN();
    box.fresh = false;
  }
  if (due_row)
    for (std::size_t k = 0; k < kept_.size(); ++k) table_.columns[k].push_back(row_[kept_[k]]);
  ++step_;
}

RunRecorder::RunRecorder(const DeviceFile* devices, std::size_t every, double step_s,
                         std::function<void(const recording::Table&)> on_row)
    : every_(every), on_row_(std::move(on_row)), row_(recording::telemetry_channels().size()) {
  if (devices != nullptr && every > 0) sensors_.emplace(*devices, every, step_s);
  for (const std::string& name : recording::telemetry_channels()) table_.add(name, {});
}

bool RunRecorder::wants_step() {
  if (every_ == 0) return false;
  return steps_++ % every_ == 0 || sensors_.has_value();
}

void RunRecorder::record(double time_s, const State<double>& state, const Detail<double>& detail,
                         const Controls<double>& controls, double u_m, double v_m) {
  fill_telemetry(time_s, state, detail, controls, u_m, v_m, row_);
  const std::size_t rows = table().rows();
  if (sensors_)
    sensors_->record(row_, state[kVz]);
  else
    for (std::size_t i = 0; i < row_.size(); ++i) table_.columns[i].push_back(row_[i]);
  if (on_row_ && table().rows() > rows) on_row_(table());
}

}  // namespace vehicle
