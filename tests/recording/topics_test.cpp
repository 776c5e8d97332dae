#include "topics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace recording {
namespace topics_test {

const Channel& of(const Log& log, const std::string& name) {
  for (const Channel& channel : log.channels)
    if (channel.name == name) return channel;
  throw std::runtime_error("no channel " + name);
}

Topic topic_of(const std::string& name, int messages, std::uint64_t begin_ns,
               std::uint64_t step_ns) {
  Topic topic;
  topic.name = name;
  for (int k = 0; k < messages; ++k) {
    topic.begin_message(begin_ns + step_ns * static_cast<unsigned>(k));
    topic.put(topic.slot("v"), k);
  }
  return topic;
}

TEST(Topics, EveryTopicHasItsClockFromTheFirstMomentOfAll) {
  const Log log = log_of_topics({topic_of("/a", 5, 3'000'000'000, 100'000'000),
                                 topic_of("/b", 2, 2'500'000'000, 1'000'000'000)},
                                "t", "log");
  EXPECT_NEAR(log.clocks[of(log, "/a.v").clock][0], 0.5, 1e-12);
  EXPECT_EQ(log.clocks[of(log, "/b.v").clock], (std::vector<double>{0, 1}));
  EXPECT_NEAR(of(log, "/a.v").rate_hz, 10, 1e-9);
  EXPECT_FALSE(log.in_rows);
}

TEST(Topics, ValuesStayWithTheirMessage) {
  Topic topic = topic_of("/a", 3, 0, 10);
  topic.begin_message(30);
  topic.put(topic.slot("late"), 7);
  topic.begin_message(40);
  const Log log = log_of_topics({topic}, "t", "log");
  EXPECT_EQ(of(log, "/a.late").values[3], 7);
  EXPECT_TRUE(std::isnan(of(log, "/a.late").values[2]));
  EXPECT_TRUE(std::isnan(of(log, "/a.late").values[4]));
  EXPECT_TRUE(std::isnan(of(log, "/a.v").values[4]));
}

TEST(Topics, MessagesThatCameLateAreSortedIn) {
  Topic topic;
  topic.name = "/a";
  for (const int k : {0, 2, 1, 3}) {
    topic.begin_message(static_cast<std::uint64_t>(k) * 1000);
    topic.put(topic.slot("v"), k);
  }
  EXPECT_EQ(of(log_of_topics({topic}, "t", "log"), "/a.v").values,
            (std::vector<double>{0, 1, 2, 3}));
}

TEST(Topics, AnglesStandBesideQuaternions) {
  Topic topic;
  topic.name = "/pose";
  topic.begin_message(1);
  // Turned by roll, then pitch, then yaw: the product of the three half-angle quaternions.
  const double r = 0.1, p = -0.2, y = 2.5;
  const double cr = std::cos(r / 2), sr = std::sin(r / 2), cp = std::cos(p / 2),
               sp = std::sin(p / 2), cy = std::cos(y / 2), sy = std::sin(y / 2);
  topic.put(topic.slot("q.x"), sr * cp * cy - cr * sp * sy);
  topic.put(topic.slot("q.y"), cr * sp * cy + sr * cp * sy);
  topic.put(topic.slot("q.z"), cr * cp * sy - sr * sp * cy);
  topic.put(topic.slot("q.w"), cr * cp * cy + sr * sp * sy);
  topic.put(topic.slot("box.x"), 5);
  topic.put(topic.slot("box.y"), 5);
  topic.put(topic.slot("box.z"), 5);
  topic.put(topic.slot("box.w"), 5);
  const Log log = log_of_topics({topic}, "t", "log");
  EXPECT_NEAR(of(log, "/pose.q.roll").values[0], r, 1e-12);
  EXPECT_NEAR(of(log, "/pose.q.pitch").values[0], p, 1e-12);
  EXPECT_NEAR(of(log, "/pose.q.yaw").values[0], y, 1e-12);
  EXPECT_EQ(log.channels.size(), 11u);  // no angles of a box
}

TEST(Topics, LongArraysAndTimesBeyondAllClocksAreLeftOut) {
  Topic topic;
  topic.name = "/scan";
  EXPECT_FALSE(topic.begin_message(0xffffffffffffffffull));
  topic.begin_message(1);
  for (int k = 0; k <= 64; ++k) topic.put(topic.slot("ranges." + std::to_string(k)), k);
  topic.put(topic.slot("ranges.mean"), 32);
  const Log log = log_of_topics({topic}, "t", "log");
  ASSERT_EQ(log.channels.size(), 1u);
  EXPECT_EQ(log.channels[0].name, "/scan.ranges.mean");
}

TEST(Topics, ThereIsAnEndToFields) {
  Topic topic;
  topic.begin_message(1);
  for (std::size_t k = 0; k < kMostFields + 10; ++k)
    topic.put(topic.slot("f" + std::to_string(k)), 1);
  EXPECT_EQ(topic.columns.size(), kMostFields);
}

}  // namespace topics_test
}  // namespace recording
