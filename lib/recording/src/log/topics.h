// Messages of topics (MCAP, rosbag2) on their way to channels: columns that grow message by
// message.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "recording/log.h"

namespace recording {

/// An array with more elements than this is data of its own (an image, a scan), no row of channels.
constexpr std::size_t kMostElements = 64;
/// Numbers in one message that become channels.
constexpr std::size_t kMostFields = 10000;

/// The numbers of a topic's messages. What was put at a slot belongs to the message begun last;
/// slots without a value there are NaN.
class Topic {
 public:
  /// A message of that moment, as the logger stamped it. False: its time is none (beyond 2^62).
  bool begin_message(std::uint64_t logged_ns);
  /// The slot of a field ("header.stamp.sec"), made where it is new; kNone after kMostFields.
  std::size_t slot(std::string_view path, std::string_view unit = {});
  /// One look-up less where fields come in the same order again.
  std::size_t slot_near(std::size_t guess, std::string_view path);
  void put(std::size_t slot, double value);
  /// Appends what another file says of the topic.
  void append(Topic later);
  /// A message that contradicts its schema or its format.
  void count_damaged() { ++damaged; }

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  struct Column {
    std::string path, unit;
    std::vector<double> values;  ///< as long as to the last message with a value
  };
  std::string name;
  std::string schema_name;  ///< of messages in JSON; tells units
  std::vector<std::int64_t> times_ns;
  std::vector<Column> columns;
  std::size_t damaged = 0;

 private:
  std::unordered_map<std::string, std::size_t> known_;
};

/// What a file of topics holds, and what of it was not read and why, in sentences.
struct FileTopics {
  std::vector<Topic> topics;
  std::vector<std::string> notes;
};
/// Throw base::Error on damage; `name` is for messages.
FileTopics topics_of_mcap(std::string_view bytes, const std::string& name);
FileTopics topics_of_rosbag2(std::string_view bytes, const std::string& name);

/// What a later file says of the same topics, behind what is known of them.
void append_topics(std::vector<Topic>& topics, std::vector<Topic> later);

/// The log of a file; throws base::Error where it has no number.
Log log_of_file(FileTopics file, const std::string& format, const std::string& name);

/// The channels of all topics, named topic.field, each topic with a clock of its own.
/// - Pairs "P.sec" with "P.nanosec", "P.nsec" or "P.nsecs" become "P" [s].
/// - The stamp of a message's header ("header.stamp", "timestamp", "stamp") is the moment of its
///   sample, where it goes on; where it is of another clock (more than 10 s off, by the median) it
///   is moved onto the logger's.
/// - Beside quaternions (x, y, z, w of one name) stand their angles roll, pitch, yaw [rad].
/// Throws base::Error on more than 2 GB. Topics without numbers leave a note.
Log log_of_topics(std::vector<Topic> topics, std::string format, const std::string& name);

}  // namespace recording
