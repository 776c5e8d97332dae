#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "base/read_file.h"
#include "recording/log.h"
#include "support/mcap_file.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace recording {
namespace bag_folder_test {

using support::raw;

const Channel& of(const Log& log, const std::string& name) {
  for (const Channel& channel : log.channels)
    if (channel.name == name) return channel;
  throw std::runtime_error("no channel " + name);
}

void put(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// As `ros2 bag record` writes it (a part of it).
std::string metadata(const std::vector<std::string>& files, const char* storage) {
  std::string out = "rosbag2_bagfile_information:\n  version: 9\n  storage_identifier: ";
  out += storage;
  out += "\n  duration:\n    nanoseconds: 99\n  relative_file_paths:\n";
  for (const std::string& file : files) out += "    - " + file + "\n";
  return out + "  compression_format: \"\"\n  compression_mode: \"\"\n";
}

/// An MCAP file of /speed (and /late in the second part), from that second on.
std::string part(int first, int messages, bool late) {
  std::string data = support::mcap_schema(1, "std_msgs/msg/Float64", "ros2msg", "float64 data") +
                     support::mcap_channel(7, 1, "/speed", "cdr");
  if (late) data += support::mcap_channel(3, 1, "/late", "cdr");
  for (int k = 0; k < messages; ++k) {
    const std::string value = std::string("\0\1\0\0", 4) + raw(10.0 + first + k);
    const auto at = static_cast<std::uint64_t>(first + k) * 1000000000u;
    data += support::mcap_message(7, at, value);
    if (late) data += support::mcap_message(3, at, value);
  }
  return support::mcap_file(data);
}

std::string refusal(const std::string& path) {
  try {
    (void)read_log(path);
  } catch (const base::Error& error) {
    return error.what();
  }
  return "read";
}

TEST(BagFolder, FilesAreOneLogInTheOrderOfTheMetadata) {
  const support::TemporaryFolder folder;
  put(folder.path("drive_0.mcap"), part(100, 3, false));
  put(folder.path("drive_1.mcap"), part(103, 2, true));
  put(folder.path("other.mcap"), part(500, 2, true));  // not named
  put(folder.path("metadata.yaml"), metadata({"drive_0.mcap", "drive_1.mcap"}, "mcap"));
  const Log log = read_log(folder.path(""));
  EXPECT_EQ(log.format, "rosbag2");
  EXPECT_EQ(of(log, "/speed.data").values, (std::vector<double>{110, 111, 112, 113, 114}));
  EXPECT_EQ(log.clocks[of(log, "/speed.data").clock], (std::vector<double>{0, 1, 2, 3, 4}));
  EXPECT_EQ(of(log, "/late.data").values, (std::vector<double>{113, 114}));
  EXPECT_EQ(log.clocks[of(log, "/late.data").clock], (std::vector<double>{3, 4}));
  EXPECT_EQ(log.channels.size(), 2u);
}

TEST(BagFolder, ReadsDatabasesAndFilesThatArePackedAsAWhole) {
  const support::TemporaryFolder folder;
  const std::string db = base::read_file(places::source() + "/tests/corpus/logs/humble.db3");
  put(folder.path("a_0.db3"), db);
  put(folder.path("a_1.db3.zstd"), support::packed(db, "zstd"));
  put(folder.path("metadata.yaml"), metadata({"a_0.db3", "a_1.db3"}, "sqlite3"));
  const Log log = read_log(folder.path(""));
  const Channel& vx = of(log, "/odom.twist.twist.linear.x");  // the same twice, sorted by time
  EXPECT_EQ(vx.values, (std::vector<double>{30, 30, 31, 31, 32, 32, 33, 33, 34, 34, 35, 35}));
  EXPECT_EQ(vx.unit, "m/s");
  EXPECT_THAT(log.notes,
              testing::ElementsAre("a_0.db3: /own: not read: type car_msgs/Own is not described",
                                   "a_1.db3: /own: not read: type car_msgs/Own is not described"));
}

TEST(BagFolder, SaysWhatIsMissingOrLeadsOut) {
  const support::TemporaryFolder folder;
  EXPECT_THAT(refusal(folder.path("")), testing::HasSubstr("a folder without metadata.yaml"));
  put(folder.path("x.mcap"), part(1, 2, false));
  put(folder.path("metadata.yaml"), metadata({"x.mcap", "y.mcap"}, "mcap"));
  EXPECT_THAT(refusal(folder.path("")), testing::HasSubstr("names y.mcap, which is not there"));
  for (const char* name : {"../x.mcap", "/etc/passwd", "a/../../x.mcap", "\"\""}) {
    put(folder.path("metadata.yaml"), metadata({name}, "mcap"));
    EXPECT_THAT(refusal(folder.path("")), testing::HasSubstr("wanted a name within the folder"));
  }
  for (const char* text : {"", "a: [1", "rosbag2_bagfile_information: 3",
                           "rosbag2_bagfile_information: {relative_file_paths: {a: b}}",
                           "rosbag2_bagfile_information: {relative_file_paths: []}"}) {
    put(folder.path("metadata.yaml"), text);
    EXPECT_THAT(refusal(folder.path("")), testing::HasSubstr("metadata.yaml: ")) << text;
  }
  put(folder.path("x.mcap"), "time_s,vx_mps\n0,1\n");
  put(folder.path("metadata.yaml"), metadata({"x.mcap"}, "mcap"));
  EXPECT_THAT(refusal(folder.path("")), testing::HasSubstr("neither an SQLite database nor MCAP"));
}

}  // namespace bag_folder_test
}  // namespace recording
