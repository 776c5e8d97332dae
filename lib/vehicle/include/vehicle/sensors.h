// Sensors: what a logger would have written of a run, from the true telemetry of every step.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/random.h"
#include "recording/table.h"
#include "vehicle/telemetry.h"

namespace vehicle {

/// What one channel's sensor does to the value it samples:
/// quantise(gain * value + bias + noise * gaussian).
struct ChannelSensor {
  std::string channel;  ///< of the telemetry
  double gain = 1.0;
  double bias = 0.0;          ///< in the channel's unit
  double noise = 0.0;         ///< standard deviation, in the channel's unit
  double quantisation = 0.0;  ///< step of the output, 0: none
};

/// A box with a clock of its own. The true values of its channels go, in this order, to the box's
/// place and axes, through the low-pass, through the delay, and are sampled.
struct Device {
  std::string name;
  double rate_hz = 0.0;                  ///< 0: at every row of the telemetry
  double delay_s = 0.0;                  ///< sampled values are those of that much earlier
  double low_pass_hz = 0.0;              ///< corner of a first-order filter; 0: none
  std::array<double, 3> mounting_rad{};  ///< roll, pitch, yaw of the box's axes against the body's
  std::array<double, 3> lever_arm_m{};   ///< from the design centre of mass, body axes
  std::vector<ChannelSensor> channels;
};

struct DeviceFile {
  std::uint64_t seed = 1;  ///< of the noise
  bool hold = false;       ///< between samples: the last value again; otherwise an empty cell
  bool others_ideal =
      true;  ///< channels without a device: ideal; otherwise left out, commands apart
  std::vector<Device> devices;
};

/// Reads a device configuration (docs/sensors.md). Throws Error with file:line on unknown keys and
/// channels, a channel in two devices, values that cannot be.
DeviceFile read_devices(const std::string& path);

/// Sees every step of a run and collects rows of telemetry as the devices measure it. The same run
/// and seed give the same bytes. Place, velocity, acceleration and turning are moved to the box's
/// place and turned to its axes; other channels only filtered, delayed, sampled and falsified.
class SensorRecorder {
 public:
  /// One row every `every` steps of `step_s`. Throws Error when a delay is longer than 10 s.
  SensorRecorder(const DeviceFile& file, std::size_t every, double step_s);

  /// The row that fill_telemetry gives for this step, and the vertical speed it does not have.
  void record(const std::vector<double>& row, double vz_mps);

  const recording::Table& table() const { return table_; }

 private:
  struct Channel {
    std::size_t column;  ///< in the telemetry
    ChannelSensor sensor;
    base::Random random{0};
    double filtered = 0.0, sampled = 0.0;
    std::vector<double> ring;
  };
  struct Box {
    Device device;
    std::vector<Channel> channels;
    std::int64_t samples = 0;
    bool fresh = false;
  };
  void move_and_turn(const Device& device, std::vector<double>& row, double vz_mps) const;

  std::vector<Box> boxes_;
  std::vector<std::size_t> kept_;  ///< columns of the telemetry that are written
  std::vector<int> measured_;      ///< per column of the telemetry: by a device
  std::size_t every_;
  double step_s_;
  bool hold_;
  std::int64_t step_ = 0;
  std::array<double, 3> last_turning_{};
  std::array<double, 3> turning_change_{};
  std::vector<double> moved_, row_;
  recording::Table table_;
};

/// Telemetry of a run, ideal or through devices.
class RunRecorder {
 public:
  /// One row every `every` steps, 0: none. `devices` may be nullptr; `on_row` is called after each
  /// row.
  RunRecorder(const DeviceFile* devices, std::size_t every, double step_s,
              std::function<void(const recording::Table&)> on_row = {});

  /// Whether record() must be called for the step to come; counts steps.
  bool wants_step();
  void record(double time_s, const State<double>& state, const Detail<double>& detail,
              const Controls<double>& controls, double u_m, double v_m);

  const recording::Table& table() const { return sensors_ ? sensors_->table() : table_; }

 private:
  std::size_t every_, steps_ = 0;
  std::optional<SensorRecorder> sensors_;
  std::function<void(const recording::Table&)> on_row_;
  std::vector<double> row_;
  recording::Table table_;
};

}  // namespace vehicle
