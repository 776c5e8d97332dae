// Numbers out of serialised ROS messages, walked by the description of their type.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "message_types.h"
#include "topics.h"

namespace recording {

enum class Encoding {
  cdr,   ///< ROS 2: four bytes that say byte order and alignment, then aligned values
  ros1,  ///< little-endian, nothing aligned
};

/// One step through a message's bytes.
struct Step {
  Kind kind = Kind::uint8;
  Many many = Many::one;
  std::size_t count = 1;              ///< of a fixed array
  std::size_t way = 0;                ///< of nested steps: which of MessageWay::ways
  std::size_t slot = Topic::kNone;    ///< of its (first) number, where it becomes a channel
  std::string path;                   ///< of a sequence of numbers that become channels
  std::vector<std::size_t> elements;  ///< slots of a sequence, as many as have been seen
};

/// The way through messages of one type: the first one with channels, then one for every type that
/// repeats inside, without.
struct MessageWay {
  Encoding encoding = Encoding::cdr;
  std::vector<std::vector<Step>> ways;
};

/// Lays the way through messages of type `root` and makes the slots of its numbers in `topic`:
/// nested types and arrays of up to kMostElements become "a.b.0", sequences of numbers as they
/// come; what is longer or repeats in sequences of types is walked over. Types that are missing
/// from `types` are taken from the standard packages. Throws base::Error on types that are nowhere,
/// contain themselves or have more than kMostFields numbers.
MessageWay lay_way(const MessageTypes& types, const std::string& root, Encoding encoding,
                   Topic& topic);

/// Puts the numbers of one message into the topic's newest row; false when the bytes are not what
/// the type says (what came before stays).
bool read_serialized(std::string_view bytes, MessageWay& way, Topic& topic);

}  // namespace recording
