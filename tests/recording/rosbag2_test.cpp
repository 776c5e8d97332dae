#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cmath>

#include "base/error.h"
#include "base/read_file.h"
#include "recording/log.h"
#include "support/mcap_file.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace recording {
namespace rosbag2_test {

std::string corpus(const std::string& file) {
  return places::source() + "/tests/corpus/logs/" + file;
}

const Channel& of(const Log& log, const std::string& name) {
  for (const Channel& channel : log.channels)
    if (channel.name == name) return channel;
  throw std::runtime_error("no channel " + name);
}

/// A database made by these statements.
std::string database(const std::string& sql) {
  const support::TemporaryFolder folder;
  const std::string path = folder.path("made.db3");
  sqlite3* db = nullptr;
  EXPECT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
      << sqlite3_errmsg(db);
  sqlite3_close(db);
  return base::read_file(path);
}

const std::string kTables =
    "PRAGMA page_size=512;"
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, "
    "offered_qos_profiles TEXT);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data "
    "BLOB);";

std::string refusal(const std::string& bytes) {
  try {
    (void)parse_log(bytes, "x.db3");
  } catch (const base::Error& error) {
    return error.what();
  }
  return "read";
}

// Messages by @foxglove/rosmsg2-serialization 3.1.0, tables as rosbag2 writes them: before 2023
// (no description of types), and since, in a database that was written ahead, every message packed.
TEST(Rosbag2, ReadsStandardTypesWithoutDescriptions) {
  const Log log = read_log(corpus("humble.db3"));
  EXPECT_EQ(log.format, "rosbag2");
  const Channel& vx = of(log, "/odom.twist.twist.linear.x");
  EXPECT_EQ(vx.values, (std::vector<double>{30, 31, 32, 33, 34, 35}));
  EXPECT_EQ(vx.unit, "m/s");
  EXPECT_NEAR(vx.rate_hz, 50, 1e-6);
  EXPECT_EQ(of(log, "/odom.pose.pose.position.y").values[5], -10);
  EXPECT_NEAR(of(log, "/odom.pose.pose.orientation.yaw").values[0], std::acos(-1.0), 1e-12);
  EXPECT_EQ(of(log, "/fix.status.status").values[0], -1);
  EXPECT_NEAR(of(log, "/fix.latitude").values[1], 48.10003, 1e-12);
  EXPECT_EQ(of(log, "/fix.position_covariance_type").values[1], 2);
  EXPECT_NEAR(of(log, "/joints.position.0").values[1], 0.3, 1e-12);
  EXPECT_EQ(of(log, "/joints.effort.0").values[1], 7);
  EXPECT_THAT(log.notes,
              testing::ElementsAre("/own: not read: type car_msgs/Own is not described"));
}

TEST(Rosbag2, ReadsPackedMessagesByTheirDescriptions) {
  const Log log = read_log(corpus("jazzy_zstd.db3"));
  EXPECT_EQ(of(log, "/own.wheel_speed.3").values, (std::vector<double>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(of(log, "/own.braking").values, (std::vector<double>{0, 1, 0, 1, 0, 1}));
  EXPECT_EQ(of(log, "/odom.twist.twist.angular.z").values[2], -0.25);
  EXPECT_TRUE(log.notes.empty());
}

TEST(Rosbag2, ReadsAFileThatIsPackedAsAWhole) {
  const std::string packed = support::packed(base::read_file(corpus("humble.db3")), "zstd");
  const Log log = parse_log(packed, "log");
  EXPECT_EQ(log.format, "rosbag2");
  EXPECT_EQ(of(log, "/odom.twist.twist.linear.x").values.size(), 6u);
  EXPECT_THAT(refusal(packed.substr(0, packed.size() / 2)),
              testing::HasSubstr("x.db3: packed by zstd, and cut off"));
  EXPECT_THROW((void)parse_log(support::packed(packed, "zstd"), "log"), base::Error);  // twice
}

TEST(Rosbag2, RefusesWhatIsNoBag) {
  EXPECT_THAT(refusal(database("CREATE TABLE a(b);")), testing::HasSubstr("no such table"));
  EXPECT_THAT(refusal(database(kTables)), testing::HasSubstr("without a number"));
  EXPECT_THAT(refusal(database(kTables).substr(0, 700)),
              testing::HasSubstr("no rosbag2 file, or it is damaged"));
  EXPECT_THAT(
      refusal(database(kTables + "INSERT INTO topics VALUES(1, '/a', 'p/msg/A', 'protobuf', '');")),
      testing::HasSubstr("messages are 'protobuf'"));
}

TEST(Rosbag2, RunsNothingThatADatabaseAsksFor) {
  // A view in the place of a table, over a recursion that never ends.
  EXPECT_THAT(
      refusal(database(
          "CREATE TABLE messages(topic_id, timestamp, data);"
          "CREATE VIEW topics AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n) "
          "SELECT id, 'a' AS name, 'b' AS type, 'cdr' AS serialization_format FROM n;")),
      testing::HasSubstr("SQLite"));
}

TEST(Rosbag2, TakesMessagesAsTheyAre) {
  // Times below zero, values that are no blobs, topics that are not there.
  const Log log = parse_log(
      database(kTables + "INSERT INTO topics VALUES(1, '/a', 'std_msgs/msg/UInt8', 'cdr', '');"
                         "INSERT INTO messages VALUES(1, 1, 10, x'0001000005');"
                         "INSERT INTO messages VALUES(2, 1, -10, x'0001000006');"
                         "INSERT INTO messages VALUES(3, 1, 20, 'words'), (4, 1, 30, NULL), (5, 9, "
                         "30, x'00'), (6, 1, 40, 7.5);"),
      "log");
  EXPECT_EQ(of(log, "/a.data").values.front(), 5);
  EXPECT_THAT(log.notes, testing::ElementsAre("/a: 3 of 4 messages contradict their schema"));
}

}  // namespace rosbag2_test
}  // namespace recording
