// A topic with the way to the numbers of its messages, whatever they are written in.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "serialized_message.h"
#include "topics.h"
#include "transforms.h"

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

  /// Its numbers, as one topic or, of transforms, one for each pair of frames.
  void move_to(std::vector<Topic>& topics) &&;

  const std::string& name() const { return topic_.name; }

 private:
  Topic topic_;
  bool json_ = false, has_transforms_ = false;
  MessageWay way_;
  Transforms transforms_;
};

}  // namespace recording
