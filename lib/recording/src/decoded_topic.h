// A topic with the way to the numbers of its messages, whatever they are written in.
#pragma once

#include <string>
#include <string_view>
#include <unordered_map>

#include "serialized_message.h"
#include "topics.h"

namespace recording {

/// How a file describes the messages of a topic.
struct Description {
  std::string message_encoding;  ///< "json", "cdr", "ros1"
  std::string schema_encoding;   ///< "jsonschema", "ros2msg", "ros1msg", "": none
  std::string schema_name;       ///< "sensor_msgs/msg/Imu"
  std::string_view schema;       ///< the text itself
};

class DecodedTopic {
 public:
  /// Throws base::Error, without the topic's name, on encodings and types that are not known.
  DecodedTopic(std::string name, const Description& description);
  /// One message, as the logger stamped it.
  void read(std::uint64_t logged_ns, std::string_view message);

  Topic topic;

 private:
  bool json_ = false;
  MessageWay way_;
};

}  // namespace recording
