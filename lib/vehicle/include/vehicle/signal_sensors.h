// Sensors on signals of any simulation, by their names, read while it runs.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/random.h"
#include "vehicle/road_sensors.h"

namespace vehicle {

/// One number of a simulation as a device tells it. Each sample is that of `delay_s` earlier,
/// `gain` * truth + `offset` + bias + noise, in steps of `quantisation`, held between `smallest`
/// and `largest`. All in the signal's unit after the gain.
struct SignalSensor {
  std::string name;      ///< what the measurement is called
  std::string signal;    ///< of the simulation
  double rate_hz = 0.0;  ///< 0: at every step
  double delay_s = 0.0;
  double jitter_s = 0.0;  ///< a sample comes up to so much later, uniformly; less than 1 / rate_hz
  double gain = 1.0, offset = 0.0;
  double noise = 0.0;          ///< standard deviation of a sample, white
  double noise_density = 0.0;  ///< the same per square root of Hz (angle or velocity random walk of
                               ///< a data sheet, per square root of s): times sqrt(rate_hz)
  double bias_walk = 0.0;      ///< a bias that begins at 0 and walks: standard deviation after 1 s
  double bias_instability = 0.0;  ///< standard deviation of a bias that forgets itself
  double bias_time_s = 100.0;     ///< ... in so long, to 1/e (first-order Gauss-Markov)
  double quantisation = 0.0;      ///< 0: none
  double smallest = -std::numeric_limits<double>::infinity();
  double largest = std::numeric_limits<double>::infinity();
  double lost = 0.0;  ///< share of the samples that never arrive; the one before stays
  /// Of a box elsewhere in the car, or with axes of its own: the signal is one of the file's pose
  /// or motion, and what is sampled is what it is there.
  std::optional<Mounting> mounting = std::nullopt;
};

/// What somebody who drives says, and what the simulation's input becomes of it:
/// `gain` * value + `offset`, held between `smallest` and `largest`; then what an actuator makes of
/// it: a dead time, and lag^2 y'' + 2 damping lag y' + y = command, with a lead (the ARX model of
/// second order, as of the car's own actuators).
struct SignalCommand {
  std::string name;    ///< what the command is called
  std::string signal;  ///< of the simulation
  double gain = 1.0, offset = 0.0;
  double smallest = -std::numeric_limits<double>::infinity();
  double largest = std::numeric_limits<double>::infinity();
  double dead_time_s = 0.0, lag_s = 0.0, damping = 1.0, lead_s = 0.0;

  bool has_actuator() const { return dead_time_s > 0.0 || lag_s > 0.0; }
  double to_signal(double value) const;
  double from_signal(double value) const { return (value - offset) / gain; }
};

/// Two sensors that tell a place on the map, to be told in latitude and longitude.
struct SignalPosition {
  std::string name;
  std::size_t x = 0, y = 0;  ///< of the file's sensors
};

/// A message of ROS 2 and what is told in it.
struct SignalTopic {
  std::string name;  ///< of the topic
  std::string type;  ///< package/Message
  std::string frame = "map", child_frame = "base_link";
  /// Field of the message, and the name of a measurement or a number.
  std::vector<std::pair<std::string, std::string>> fields;
};

struct SignalSensorFile {
  std::uint64_t seed = 1;
  std::vector<SignalSensor> sensors;
  std::vector<SignalCommand> commands;
  std::vector<SignalPosition> positions;
  std::vector<SignalTopic> topics = {};
  RoadSensorFile road = {};
};

/// Reads a YAML file (docs/sensors.md). Throws Error with file:line on unknown keys, a sensor
/// without a signal, and numbers that cannot be.
SignalSensorFile read_signal_sensors(const std::string& path);

class SignalSensors {
 public:
  /// `step_s` is the time from one step() to the next. Throws Error for a sensor that samples
  /// faster than that, and for one with a place in the car whose signal no place changes.
  SignalSensors(const SignalSensorFile& file, double step_s);

  /// What step() wants to know: the signals of the sensors in the order of the file, then what
  /// places in the car need, where a sensor has one.
  static std::vector<std::string> signals(const SignalSensorFile& file);

  /// The true values of signals(), in their order; first those of time 0. Every sensor
  /// has a stream of random numbers of its own, by the seed and its name: another sensor does not
  /// change it. Jitter and losses are by the name up to its last dot: gnss.x and gnss.y are one
  /// device, whose samples come, or are lost, together.
  void step(std::span<const double> told);

  std::size_t size() const { return sensors_.size(); }
  double value(std::size_t sensor) const { return sensors_[sensor].value; }
  /// How long ago value() was true: the delay, and the time since the sample came.
  double age_s(std::size_t sensor) const;

 private:
  struct Running {
    SignalSensor is;
    base::Random random{0}, clock{0};
    std::vector<double> past;  ///< ring of true values
    double noise = 0.0, walked = 0.0, unstable = 0.0;
    double due_s = 0.0, value = 0.0;
    std::uint64_t samples = 0, of_step = 0;
    std::size_t of_car = 0;  ///< with a place in it: which of the file's pose and motion
  };
  void sample(Running& sensor);
  std::vector<double> at_their_places(std::span<const double> truth);

  std::vector<Running> sensors_;
  std::vector<std::size_t> of_car_;       ///< of the file's pose and motion: those that are told
  std::array<double, 3> last_turning_{};  ///< rad/s
  double step_s_;
  std::uint64_t steps_ = 0;
};

}  // namespace vehicle
