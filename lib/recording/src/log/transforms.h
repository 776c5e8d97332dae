// Transforms between frames (tf2_msgs/TFMessage): every message is a list, and every pair of frames
// in it a series of its own.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "message_types.h"
#include "serialized_message.h"
#include "topics.h"

namespace recording {

/// Whether messages of a type are such lists, laid out as the standard packages have them; `types`
/// as the file describes them, empty where it does not.
bool is_transforms(const MessageTypes& types, const std::string& root, Encoding encoding);

class Transforms {
 public:
  /// Pairs of frames in one topic; what comes after is left out, and counted as damaged.
  static constexpr std::size_t kMostPairs = 2000;

  /// The transforms of one message, as the logger stamped it, into the topics of their frames;
  /// false when the bytes are not what the type says (what came before stays).
  bool read(std::uint64_t logged_ns, std::string_view bytes, Encoding encoding);
  /// One topic "name.parent.child" for each pair, with header.stamp, translation and rotation.
  std::vector<Topic> topics(const std::string& name) &&;

 private:
  struct Pair {
    Topic topic;
    std::size_t slots[9] = {};
  };
  std::map<std::pair<std::string, std::string>, Pair, std::less<>> pairs_;  ///< parent, child
};

}  // namespace recording
