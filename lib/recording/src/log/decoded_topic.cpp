#include "decoded_topic.h"

#include <fmt/format.h>

#include <utility>

#include "base/error.h"
#include "json_message.h"

namespace recording {

DecodedTopic::DecodedTopic(std::string name, const Description& d) {
  topic_.name = std::move(name);
  json_ = d.message_encoding == "json";
  if (json_) {
    topic_.schema_name = d.schema_name;
    return;
  }
  if (d.message_encoding != "cdr" && d.message_encoding != "ros1")
    throw base::Error(fmt::format("messages are '{}', wanted json, cdr or ros1",
                                  d.message_encoding.substr(0, 40)));
  const bool described = d.schema_encoding == "ros2msg" || d.schema_encoding == "ros1msg";
  if (!described && !d.schema_encoding.empty())
    throw base::Error(fmt::format("messages are described in '{}', wanted ros2msg or ros1msg",
                                  d.schema_encoding.substr(0, 40)));
  const MessageTypes types =
      described ? parse_message_types(d.schema, d.schema_name) : MessageTypes{};
  way_.encoding = d.message_encoding == "cdr" ? Encoding::cdr : Encoding::ros1;
  has_transforms_ = is_transforms(types, d.schema_name, way_.encoding);
  if (!has_transforms_) way_ = lay_way(types, d.schema_name, way_.encoding, topic_);
}

void DecodedTopic::read(std::uint64_t logged_ns, std::string_view message) {
  if (!topic_.begin_message(logged_ns)) return;
  const bool good = json_             ? read_json(message, topic_)
                    : has_transforms_ ? transforms_.read(logged_ns, message, way_.encoding)
                                      : read_serialized(message, way_, topic_);
  if (!good) topic_.count_damaged();
}

void DecodedTopic::move_to(std::vector<Topic>& topics) && {
  if (has_transforms_)
    for (Topic& topic : std::move(transforms_).topics(topic_.name))
      topics.push_back(std::move(topic));
  topics.push_back(std::move(topic_));
}

}  // namespace recording
