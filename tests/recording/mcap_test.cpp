#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "base/read_file.h"
#include "recording/log.h"
#include "support/mcap_file.h"
#include "support/places.h"

namespace recording {
namespace mcap_test {

using namespace support;

std::string corpus(const std::string& file) {
  return base::read_file(places::source() + "/tests/corpus/logs/" + file);
}

const Channel& of(const Log& log, const std::string& name) {
  for (const Channel& channel : log.channels)
    if (channel.name == name) return channel;
  throw std::runtime_error("no channel " + name);
}

bool has(const Log& log, const std::string& name) {
  return std::any_of(log.channels.begin(), log.channels.end(),
                     [&](const Channel& channel) { return channel.name == name; });
}

std::string refusal(const std::string& bytes) {
  try {
    (void)parse_log(bytes, "x.mcap");
  } catch (const base::Error& error) {
    return error.what();
  }
  return "read";
}

/// Ten messages {"v": k} at 100 Hz on /car, with what `wrap` makes of the records.
std::string json_file(const std::string& packer) {
  std::string records = mcap_schema(1, "car", "jsonschema", R"({"type":"object"})") +
                        mcap_channel(1, 1, "/car", "json");
  for (int k = 0; k < 10; ++k)
    records += mcap_message(1, 1'000'000'000ull + 10'000'000ull * static_cast<unsigned>(k),
                            R"({"v": )" + std::to_string(k) + "}");
  return mcap_file(packer == "top" ? records : mcap_chunk(records, packer));
}

// The file was written by @mcap/core 2.2.2 and @foxglove/rosmsg2-serialization 3.1.0: 20 messages
// of an IMU at 100 Hz, stamped 3 ms before they were logged, 5 of a type with everything in it, 10
// in JSON, 20 in Protocol Buffers.
TEST(Mcap, ReadsWhatAnotherWriterWrote) {
  const Log log = parse_log(corpus("foxglove.mcap"), "log");
  EXPECT_EQ(log.format, "MCAP");
  const Channel& ax = of(log, "/imu/data.linear_acceleration.x");
  EXPECT_EQ(ax.unit, "m/s2");
  EXPECT_NEAR(ax.rate_hz, 100, 1e-6);
  ASSERT_EQ(ax.values.size(), 20u);
  EXPECT_EQ(ax.values[7], 7.0);
  EXPECT_EQ(of(log, "/imu/data.angular_velocity.z").unit, "rad/s");
  EXPECT_EQ(of(log, "/imu/data.angular_velocity.y").values[19], -0.2);
  EXPECT_EQ(of(log, "/imu/data.orientation_covariance.8").values[3], 0.5);
  EXPECT_NEAR(of(log, "/imu/data.orientation.yaw").values[12], 0.6, 1e-12);
  EXPECT_NEAR(of(log, "/imu/data.header.stamp").values[1], 1700000000.01, 1e-6);

  EXPECT_EQ(of(log, "/odd.on").values, (std::vector<double>{1, 0, 1, 0, 1}));
  EXPECT_EQ(of(log, "/odd.a").values[4], -16);
  EXPECT_EQ(of(log, "/odd.b.2").values[3], 12);
  EXPECT_EQ(of(log, "/odd.inner.0.value").values[2], 8.5);
  EXPECT_EQ(of(log, "/odd.inner.1.small").values[2], 2);
  EXPECT_EQ(of(log, "/odd.big").values[0], -9007199254740991.0);
  EXPECT_EQ(of(log, "/odd.row.1").values[4], 16);
  EXPECT_EQ(of(log, "/odd.last").values, std::vector<double>(5, 200.0));
  EXPECT_EQ(of(log, "/odd.few.1").values[4], 16);
  EXPECT_EQ(of(log, "/odd.d").values[1], 4.5);
  EXPECT_EQ(of(log, "/odd.end").values, (std::vector<double>{0, 0.5, 1, 1.5, 2}));
  EXPECT_FALSE(has(log, "/odd.many.0.value"));

  EXPECT_NEAR(of(log, "/car.vx_mps").values[9], 21.8, 1e-12);
  EXPECT_EQ(of(log, "/car.wheel.fl.1").values[9], 19);
  EXPECT_EQ(of(log, "/car.on").values[0], 1);
  EXPECT_NEAR(of(log, "/car.vx_mps").rate_hz, 50, 1e-6);
  EXPECT_FALSE(has(log, "/car.gear"));
  EXPECT_EQ(of(log, "/car.timestamp").values[1], 7 + 1e-9);
  EXPECT_THAT(log.notes, testing::Contains(testing::HasSubstr("/car: stamps at another pace")));
  EXPECT_THAT(log.notes,
              testing::Contains(testing::HasSubstr("/proto: not read: messages are 'protobuf'")));
}

TEST(Mcap, TopicsMeetInRowsOfTheFastestByTheirStamps) {
  const Log rows = in_rows(parse_log(corpus("foxglove.mcap"), "log"), "log");
  const std::vector<double>& time = of(rows, "log time").values;
  ASSERT_EQ(time.size(), 20u);
  EXPECT_NEAR(time[19], 0.19, 1e-9);  // stamps, not 3 ms later
  const std::vector<double>& end = of(rows, "/odd.end").values;
  for (std::size_t i = 0; i < 20; ++i)
    if (i % 4 == 0)
      EXPECT_NEAR(end[i], 0.125 * static_cast<double>(i), 1e-9);
    else
      EXPECT_TRUE(std::isnan(end[i]));
}

TEST(Mcap, EveryPackingHoldsTheSame) {
  for (const char* packer : {"top", "", "zstd", "lz4"}) {
    const Log log = parse_log(json_file(packer), "log");
    EXPECT_EQ(of(log, "/car.v").values, (std::vector<double>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}))
        << packer;
    EXPECT_NEAR(of(log, "/car.v").rate_hz, 100, 1e-6) << packer;
    EXPECT_TRUE(log.notes.empty()) << packer;
  }
}

TEST(Mcap, ChecksTheCrcOfChunksAndData) {
  const std::string records = mcap_channel(1, 0, "/a", "json") + mcap_message(1, 5, R"({"v": 1})");
  EXPECT_EQ(refusal(mcap_file(mcap_chunk(records))), "read");
  EXPECT_EQ(refusal(mcap_file(mcap_chunk(records, "zstd", 0))), "read");  // none stated
  EXPECT_THAT(refusal(mcap_file(mcap_chunk(records, "lz4", 12345))),
              testing::HasSubstr("a chunk: CRC"));
  std::string damaged = mcap_file(records);
  damaged[damaged.find("\"v\"") + 1] = 'w';
  EXPECT_THAT(refusal(damaged), testing::HasSubstr("the data: CRC"));
}

TEST(Mcap, AFileThatWasCutOffIsReadUpToThere) {
  const std::string file = json_file("top");
  const std::size_t seventh = file.find(R"({"v": 6})");
  const Log log = parse_log(file.substr(0, seventh + 3), "log");
  EXPECT_EQ(of(log, "/car.v").values.size(), 6u);
  EXPECT_THAT(log.notes, testing::Contains(testing::HasSubstr("cut off")));
}

TEST(Mcap, StampsOfAnotherClockAreMovedOntoTheLoggers) {
  std::string records =
      mcap_channel(1, 0, "/sensor", "json") + mcap_channel(2, 0, "/clock", "json");
  for (int k = 0; k < 20; ++k) {
    const auto logged = 1'700'000'000'000'000'000ull + 20'000'000ull * static_cast<unsigned>(k);
    const int late_ms = k % 2 == 0 ? 0 : 5;  // the line to the logger, not the sensor
    records += mcap_message(1, logged + 1'000'000ull * static_cast<unsigned>(late_ms),
                            R"({"header": {"stamp": {"sec": 12, "nanosec": )" +
                                std::to_string(20'000'000 * k) + R"(}}, "v": 1})");
    records += mcap_message(2, logged, R"({"v": 2})");
  }
  const Log log = parse_log(mcap_file(records), "log");
  const Channel& v = of(log, "/sensor.v");
  const std::vector<double>& clock = log.clocks[v.clock];
  for (std::size_t i = 1; i < clock.size(); ++i) EXPECT_NEAR(clock[i] - clock[i - 1], 0.02, 1e-12);
  EXPECT_NEAR(clock[0], log.clocks[of(log, "/clock.v").clock][0], 0.0051);
  EXPECT_THAT(log.notes, testing::Contains(testing::HasSubstr("a clock of its own")));
}

TEST(Mcap, ChannelsOfOneTopicAreOne) {
  const std::string records = mcap_channel(1, 0, "/a", "json") + mcap_channel(7, 0, "/a", "json") +
                              mcap_message(7, 20, R"({"v": 2})") +
                              mcap_message(1, 10, R"({"v": 1})") +
                              mcap_message(1, 30, R"({"w": 3})");
  const Log log = parse_log(mcap_file(records), "log");
  ASSERT_EQ(log.channels.size(), 2u);
  EXPECT_EQ(of(log, "/a.v").values[0], 1);
  EXPECT_EQ(of(log, "/a.v").values[1], 2);
  EXPECT_TRUE(std::isnan(of(log, "/a.v").values[2]));
  EXPECT_EQ(of(log, "/a.w").values[2], 3);
}

TEST(Mcap, RefusesInOneLine) {
  const std::string channel = mcap_channel(1, 0, "/a", "json"),
                    message = mcap_message(1, 5, R"({"v": 1})");
  EXPECT_THAT(refusal(mcap_file("")), testing::HasSubstr("MCAP without a number"));
  EXPECT_THAT(refusal(mcap_file(message + channel)),
              testing::HasSubstr("is not described before it"));
  EXPECT_THAT(refusal(mcap_file(record(4, "12"))), testing::HasSubstr("shorter than its fields"));
  EXPECT_THAT(refusal(mcap_file(mcap_chunk(channel + message.substr(0, 12)))),
              testing::HasSubstr("ends beyond its chunk"));
  EXPECT_THAT(refusal(mcap_file(record(6, raw(0ull) + raw(0ull) + raw(1ull << 40) + raw(0u) +
                                              counted("zstd") + raw(0ull)))),
              testing::HasSubstr("more than such a file can hold"));
  EXPECT_THAT(refusal(mcap_file(record(6, raw(0ull) + raw(0ull) + raw(3ull) + raw(0u) +
                                              counted("snappy") + raw(3ull) + "abc"))),
              testing::HasSubstr("packed by 'snappy'"));
  EXPECT_THAT(refusal(mcap_file(record(6, raw(0ull) + raw(0ull) + raw(9ull) + raw(0u) +
                                              counted("zstd") + raw(3ull) + "abc"))),
              testing::HasSubstr("packed by zstd, and"));
  EXPECT_THAT(refusal(mcap_file(mcap_schema(1, "p/A", "ros2msg", "B b\n====\nMSG: p/B\nA a") +
                                mcap_channel(2, 1, "/a", "cdr") + mcap_message(2, 1, "x"))),
              testing::HasSubstr("nested more than"));
}

}  // namespace mcap_test
}  // namespace recording
