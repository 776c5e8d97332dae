// Point records that hold more than their file explains, or less than it promises.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "cloud/error.h"
#include "cloud/read_cloud.h"
#include "support/cloud_files.h"
#include "support/laz_file.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace cloud {
namespace odd_records_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

void expect_seed(const std::string& bytes, const std::string& name) {
  SCOPED_TRACE(name);
  const support::CloudSeed seed;
  const support::TemporaryFolder folder;
  CloudReadReport report;
  const Cloud cloud = read_cloud(folder.file(name, bytes), {}, &report);
  EXPECT_THAT(report.remarks, IsEmpty());
  ASSERT_EQ(cloud.size(), seed.count);
  ASSERT_EQ(cloud.time_s.size(), seed.count);
  for (std::size_t i = 0; i < seed.count; ++i) {
    EXPECT_NEAR(cloud.origin_m.x() + cloud.x_m[i], seed.x(i), 1e-6);
    EXPECT_NEAR(cloud.origin_m.y() + cloud.y_m[i], seed.y(i), 1e-6);
    EXPECT_NEAR(cloud.origin_m.z() + cloud.z_m[i], seed.z(i), 1e-6);
    EXPECT_DOUBLE_EQ(cloud.time_s[i], seed.time(i));
    EXPECT_EQ(cloud.intensity[i], static_cast<float>(i));
  }
}

std::string refusal(const std::string& bytes, const std::string& name) {
  const support::TemporaryFolder folder;
  try {
    read_cloud(folder.file(name, bytes));
  } catch (const cloud::Error& error) {
    return error.what();
  }
  return "accepted";
}

/// Point format 6 with so many more bytes a point; nothing in the file says what they are.
std::string with_extra_bytes(std::size_t extra) {
  const std::string plain = support::as_las({}, 4, 6);
  std::string las = plain.substr(0, 375);
  const auto length = static_cast<std::uint16_t>(30 + extra);
  std::memcpy(las.data() + 105, &length, sizeof length);
  for (std::size_t at = 375; at < plain.size(); at += 30)
    las += plain.substr(at, 30) + std::string(extra, '\xA5');
  return las;
}

TEST(OddRecords, ExtraBytesThatNobodyExplainsArePassedOver) {
  for (const std::size_t extra : {1, 4, 300}) {
    expect_seed(with_extra_bytes(extra), "a.las");
    expect_seed(support::as_laz(with_extra_bytes(extra)), "a.laz");
  }
}

TEST(OddRecords, ExtraBytesExplainedAsMoreThanThereAre) {
  std::string doubles(384, '\0');  // two records of 192, of eight bytes each; four bytes are there
  doubles[2] = doubles[192 + 2] = 10;
  std::string las = support::with_record(with_extra_bytes(4), 4, doubles);
  const std::string user = "LASF_Projection", spec("LASF_Spec\0\0\0\0\0\0", 15);
  las.replace(las.find(user), user.size(), spec);
  expect_seed(las, "a.las");
  expect_seed(support::as_laz(las), "a.laz");
}

TEST(OddRecords, PcdWithFieldsOfManySizes) {
  const support::CloudSeed seed;
  std::string bytes = fmt::format(
      "# .PCD v0.7\nVERSION 0.7\nFIELDS ring x intensity y range z flags time\nSIZE 1 8 4 8 2 8 1 "
      "8\nTYPE U F F F I F U F\nCOUNT 1 1 1 1 1 1 3 1\nWIDTH {0}\nHEIGHT 1\nPOINTS {0}\nDATA "
      "binary\n",
      seed.count);
  const std::size_t header = bytes.size();
  for (std::size_t i = 0; i < seed.count; ++i) {
    const auto put = [&](auto value) {
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    put(std::uint8_t{9}), put(seed.x(i)), put(static_cast<float>(i)), put(seed.y(i));
    put(std::int16_t{-7}), put(seed.z(i)), bytes += "abc", put(seed.time(i));
  }
  expect_seed(bytes, "a.pcd");
  const std::size_t length = (bytes.size() - header) / seed.count;
  EXPECT_THAT(refusal(bytes.substr(0, bytes.size() - 1), "a.pcd"),
              HasSubstr(fmt::format("truncated: 20 points of {} bytes promised, {} bytes left",
                                    length, 20 * length - 1)));
}

TEST(OddRecords, FewerPointsThanPromisedAreRefused) {
  const std::string las = with_extra_bytes(4);
  for (const std::size_t missing : {1, 34, 3 * 34 + 1})
    EXPECT_THAT(refusal(las.substr(0, las.size() - missing), "a.las"),
                HasSubstr(fmt::format("a.las: truncated: the header promises 20 points, {} fit",
                                      20 - (missing + 33) / 34)));
  const std::string laz = support::as_laz(las);
  EXPECT_THAT(refusal(laz.substr(0, laz.size() - 40), "a.laz"), HasSubstr("a.laz: byte "));
}

// 100 m x 10 m with 1 % of crossfall, 16,000 points.
TEST(RealClouds, StreetsOfOddRecords) {
  for (const char* name : {"street_pf6_34bytes_no_vlr.las", "street_extrabytes_too_long.las",
                           "street_returns_zero.las", "street_mixed_sizes_utm.pcd"}) {
    const std::string path = places::data() + "/constructed/" + name;
    if (!std::ifstream(path)) GTEST_SKIP() << "no ../shared/data";
    SCOPED_TRACE(name);
    std::size_t points = 0;
    read_chunks(path, {}, [&](Cloud&& chunk) {
      points += chunk.size();
      for (std::size_t i = 0; i < chunk.size(); ++i) {
        const Eigen::Vector3d p = chunk.origin_m + chunk.point(i);
        EXPECT_GE(p.x(), 500000.0 - 1e-3);
        EXPECT_LE(p.x(), 500100.0);
        EXPECT_NEAR(p.z(), 100.0 + 0.01 * (p.y() - 4e6), 1e-3);
      }
    });
    EXPECT_EQ(points, 16000u);
  }
}

TEST(OddRecords, TextRowsLongerThanTheirHeaderAreRefused) {
  for (const char* text :
       {"x;y;z\n10,1;20,5;0,11\n", "x,y,z\n10,1,20,5,0,11\n", "x,y,z,,time\n1,2,3,5,7\n"})
    EXPECT_THAT(refusal(text, "a.csv"), HasSubstr("a.csv:2: more numbers than the")) << text;
  EXPECT_EQ(refusal("x,y,z\n1,2,3\n4,5,6,\n", "a.csv"), "accepted");
  EXPECT_EQ(refusal("x y z\n1 2 3 128\n4 5 6 7\n", "a.xyz"), "accepted") << "no comma, no doubt";
}

}  // namespace odd_records_test
}  // namespace cloud
