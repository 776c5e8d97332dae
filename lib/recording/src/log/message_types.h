// Types of ROS messages from the text that describes them (ros2msg and ros1msg in MCAP and
// rosbag2).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace recording {

enum class Kind {
  boolean,
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64,
  text,
  time,
  nested
};
enum class Many { one, fixed, sequence };

struct MessageField {
  std::string name;
  Kind kind = Kind::nested;
  std::string type;  ///< of a nested field: "geometry_msgs/Vector3"
  Many many = Many::one;
  std::size_t count = 1;  ///< of a fixed array
};

/// Fields of every type, by names without "msg/" between package and type.
using MessageTypes = std::unordered_map<std::string, std::vector<MessageField>>;

/// "sensor_msgs/msg/Imu" as "sensor_msgs/Imu".
std::string plain_type(std::string_view type);

/// Reads the text of a type `root` and of those it uses (each after a line of '=' and "MSG: name").
/// Constants and defaults say nothing of the bytes and are left out. Throws base::Error that begins
/// with the type's name on lines that are no fields and on kinds whose bytes are not known (wide
/// strings).
MessageTypes parse_message_types(std::string_view text, const std::string& root);

/// Types of the standard packages, for logs that say a message's type and do not describe it, as
/// rosbag2 did until 2023.
const MessageTypes& standard_types();

/// Unit of a field of a standard type ("sensor_msgs/Imu", "angular_velocity"), which holds for what
/// is nested in it; empty: none is laid down.
std::string_view standard_unit(std::string_view type, std::string_view field);

}  // namespace recording
