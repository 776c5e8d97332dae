// Which message of ROS 2 tells which numbers of a run, and what a command says to which input; the
// wire itself is behind dds.h. Private to serve_unit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/message.h"
#include "sim/serve_unit.h"
#include "sim/unit_description.h"

namespace sim {

/// Fields of kerbstone_msgs/CarCommand and what they act on, where the devices' file has no
/// command of the field's name; of an array in FMI 3.0 the second.
struct CarField {
  const char *name, *input, *element;
};
constexpr std::array<CarField, 8> kCarFields{{
    {"steering_angle", "input.steering", ""},
    {"throttle", "input.throttle", ""},
    {"brake_pressure.fl", "input.brake.fl", "input.brake[1]"},
    {"brake_pressure.fr", "input.brake.fr", "input.brake[2]"},
    {"brake_pressure.rl", "input.brake.rl", "input.brake[3]"},
    {"brake_pressure.rr", "input.brake.rr", "input.brake[4]"},
    {"gear", "input.gear", ""},
    {"clutch", "input.clutch", ""},
}};

/// kerbstone_msgs/CarCommand.
struct CarCommand {
  std::uint32_t sequence = 0;
  std::array<double, kCarFields.size()> fields{};
  std::vector<std::pair<std::string, double>> others, starts;
  bool ends = false, pauses = false, resets = false;
  std::vector<PlanPoint> plan;  ///< none: not told
  std::string save, state;      ///< empty: nothing is saved; a reset begins at 0 s
};

struct PlannedTopic {
  std::string name, type, frame, child_frame;
  std::vector<std::string> fields;
  /// Of each field: the measurement, or nothing where it is a constant.
  std::vector<std::optional<std::size_t>> measurements;
  std::vector<double> constants;
  /// The measurement that is the age of what is told; nothing: it is told as it is now.
  std::optional<std::size_t> age;
};

struct TopicPlan {
  std::vector<PlannedTopic> topics;
  std::array<std::optional<std::size_t>, kCarFields.size()> commands;  ///< of the run
  std::vector<std::string> command_names;
  std::vector<std::string> scans, edges;  ///< topics of what is seen, called like their sensors
  std::string prefix;                     ///< before the names of all
};

/// Plans the topics of the devices' file, else odom and imu of the numbers that the unit of a car
/// has, and adds the measurements and commands that they need to those of the run. Throws Error,
/// with the unit's path, on types and fields that do not exist.
TopicPlan plan_topics(ServeOptions& options, const UnitDescription& unit, const std::string& path);

/// One message: what its fields hold.
class Told {
 public:
  Told(const PlannedTopic& topic, const MeasurementMessage& message)
      : topic_(topic), message_(message) {}

  bool has(std::string_view field) const;
  double value(std::string_view field) const;  ///< 0 where the topic does not tell it
  /// When what is told was true.
  double time_s() const;

  const PlannedTopic& topic() const { return topic_; }

 private:
  double value_at(std::size_t field) const;
  const PlannedTopic& topic_;
  const MeasurementMessage& message_;
};

/// The command in the order of the run. Nothing, and the reason in `why`, where it holds names that
/// are none of the run, or numbers that are not finite in what the run takes.
std::optional<CommandMessage> command_of(const CarCommand& said, const TopicPlan& plan,
                                         std::string& why);

/// x, y, z, w of the turn by yaw, then pitch, then roll about the turned axes, rad.
std::array<double, 4> quaternion(double roll_rad, double pitch_rad, double yaw_rad);

}  // namespace sim
