#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "recording/log.h"
#include "support/mcap_file.h"

namespace recording {
namespace transforms_test {

using support::raw;

const Channel& of(const Log& log, const std::string& name) {
  for (const Channel& channel : log.channels)
    if (channel.name == name) return channel;
  throw std::runtime_error("no channel " + name);
}

constexpr const char* kRos2 =
    "geometry_msgs/TransformStamped[] transforms\n"
    "================\nMSG: geometry_msgs/TransformStamped\n"
    "# a comment\nstd_msgs/Header header\nstring child_frame_id\nTransform transform\n"
    "================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    "================\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
    "================\nMSG: geometry_msgs/Transform\nVector3 translation\nQuaternion rotation\n"
    "================\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    "================\nMSG: geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\n"
    "float64 w 1\n";
constexpr const char* kRos1 =
    "geometry_msgs/TransformStamped[] transforms\n"
    "================\nMSG: geometry_msgs/TransformStamped\n"
    "Header header\nstring child_frame_id\nTransform transform\n"
    "================\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
    "================\nMSG: geometry_msgs/Transform\nVector3 translation\nQuaternion rotation\n"
    "================\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    "================\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\n"
    "float64 w\n";

/// The bytes of a message, written value by value; CDR counts from behind its four bytes.
struct Message {
  bool cdr;
  std::string body = {};

  template <typename T>
  void put(T value) {
    while (cdr && body.size() % sizeof(T) != 0) body += '\0';
    body += raw(value);
  }
  void put_text(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size() + (cdr ? 1 : 0)));
    body += text;
    if (cdr) body += '\0';
  }
  void put_transform(std::uint32_t sec, const std::string& parent, const std::string& child,
                     double x, double yaw) {
    if (!cdr) put(std::uint32_t{17});
    put(sec);
    put(std::uint32_t{500000000});
    put_text(parent);
    put_text(child);
    for (const double number : {x, -x, 0.25, 0.0, 0.0, std::sin(yaw / 2), std::cos(yaw / 2)})
      put(number);
  }
  std::string bytes() const { return (cdr ? std::string("\0\1\0\0", 4) : "") + body; }
};

std::string file_of(const char* type, const char* schema, bool cdr,
                    const std::vector<std::string>& messages) {
  std::string data;
  if (schema != nullptr)
    data += support::mcap_schema(1, type, cdr ? "ros2msg" : "ros1msg", schema);
  else
    data += support::mcap_schema(1, type, "", "");
  data += support::mcap_channel(1, 1, "/tf", cdr ? "cdr" : "ros1");
  std::uint64_t at = 8000000000;
  for (const std::string& message : messages)
    data += support::mcap_message(1, at += 1000000000, message);
  return support::mcap_file(data);
}

std::vector<std::string> drive(bool cdr) {
  std::vector<std::string> out;
  for (std::uint32_t k = 0; k < 3; ++k) {
    Message message{cdr};
    message.put(std::uint32_t{k == 1 ? 1u : 2u});  // the second pair is not in the second message
    message.put_transform(8 + k, "map", "base_link", 10.0 * k, 0.1 * k);
    if (k != 1) message.put_transform(8 + k, "base_link", "wheel", 1.5, -0.3);
    out.push_back(message.bytes());
  }
  return out;
}

TEST(Transforms, EveryPairOfFramesIsASeriesOfItsOwn) {
  for (const bool cdr : {true, false}) {
    const char* type = cdr ? "tf2_msgs/msg/TFMessage" : "tf2_msgs/TFMessage";
    const Log log = parse_log(file_of(type, cdr ? kRos2 : kRos1, cdr, drive(cdr)), "log");
    const Channel& x = of(log, "/tf.map.base_link.translation.x");
    EXPECT_EQ(x.values, (std::vector<double>{0, 10, 20}));
    EXPECT_EQ(x.unit, "m");
    EXPECT_EQ(log.clocks[x.clock], (std::vector<double>{0, 1, 2}));  // by their own stamps
    EXPECT_NEAR(of(log, "/tf.map.base_link.rotation.yaw").values[2], 0.2, 1e-12);
    const Channel& wheel = of(log, "/tf.base_link.wheel.translation.y");
    EXPECT_EQ(wheel.values, (std::vector<double>{-1.5, -1.5}));
    EXPECT_EQ(log.clocks[wheel.clock], (std::vector<double>{0, 2}));
    EXPECT_NEAR(of(log, "/tf.base_link.wheel.rotation.yaw").values[1], -0.3, 1e-12);
    EXPECT_TRUE(log.notes.empty());
  }
}

TEST(Transforms, AreKnownWithoutADescription) {
  const Log log = parse_log(file_of("tf2_msgs/msg/TFMessage", nullptr, true, drive(true)), "log");
  EXPECT_EQ(of(log, "/tf.map.base_link.translation.x").values[1], 10);
}

TEST(Transforms, OfAnotherLayoutAreNotGuessedAt) {
  std::string other = kRos2;
  other.replace(other.find("float64 x\n"), 10, "float32 x\n");
  const std::string file = file_of("tf2_msgs/msg/TFMessage", other.c_str(), true, drive(true));
  EXPECT_THROW((void)parse_log(file, "log"), std::exception);  // no number that can be read
}

TEST(Transforms, MessagesThatAreCutOffAreCounted) {
  std::vector<std::string> messages = drive(true);
  messages[2].resize(messages[2].size() - 5);  // within the second transform
  Message many{true};
  many.put(std::uint32_t{0xFFFFFFFF});
  messages.push_back(many.bytes());
  const Log log = parse_log(file_of("tf2_msgs/msg/TFMessage", kRos2, true, messages), "log");
  EXPECT_EQ(of(log, "/tf.map.base_link.translation.x").values.size(), 3u);
  EXPECT_EQ(of(log, "/tf.base_link.wheel.translation.x").values.size(), 1u);
  EXPECT_THAT(log.notes, testing::ElementsAre("/tf: 2 of 4 messages contradict their schema"));
}

}  // namespace transforms_test
}  // namespace recording
