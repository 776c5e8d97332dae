#include "iso_time.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "recording/log.h"

namespace recording {
namespace iso_time_test {

using testing::AllOf;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(IsoTime, ReadsDatesWithTimes) {
  const auto noon = iso_time("2024-05-01T12:00:00Z");
  ASSERT_TRUE(noon);
  EXPECT_EQ(noon->whole_s, 1714564800);
  EXPECT_TRUE(noon->zoned);
  for (const char* same : {"2024-05-01 12:00:00", "2024-05-01T12:00", "2024-05-01T14:00:00+02:00",
                           "2024-05-01T14:00+02", "2024-05-01t06:30:00.000-0530"}) {
    const auto time = iso_time(same);
    ASSERT_TRUE(time) << same;
    EXPECT_EQ(time->whole_s, noon->whole_s) << same;
    EXPECT_EQ(time->part_s, 0.0) << same;
  }
  EXPECT_FALSE(iso_time("2024-05-01 12:00:00")->zoned);
  EXPECT_NEAR(iso_time("2024-05-01T12:00:00.123456789Z")->part_s, 0.123456789, 1e-12);
  EXPECT_NEAR(iso_time("2024-05-01T12:00:00,25")->part_s, 0.25, 1e-12);
  EXPECT_EQ(iso_time("2024-03-01T00:00:00")->whole_s - iso_time("2024-02-28T23:59:60")->whole_s,
            86400);
}

TEST(IsoTime, OtherWordsAreNone) {
  for (const char* other :
       {"", "2024-05-01", "12:00:00", "2024-05-01T", "2023-02-29T12:00:00", "2024-13-01T12:00:00",
        "2024-05-01T24:00:00", "2024-05-01T12:60:00", "2024-05-01T12:00:00.", "2024-05-01T12:00:0",
        "2024-05-01T12:00:00+", "2024-05-01T12:00:00+2", "2024-05-01T12:00:00+02:",
        "2024-05-01T12:00:00 UTC", "20240501T120000", "01/05/2024 12:00:00", "1714564800"})
    EXPECT_FALSE(iso_time(other)) << other;
}

std::vector<double> times_of(const std::string& text) {
  const Log log = parse_log(text, "x.csv");
  EXPECT_EQ(log.channels.front().words, 0u);
  return log.channels.front().values;
}

TEST(IsoTime, LogsCountSecondsFromTheFirstRow) {
  EXPECT_THAT(times_of("Timestamp,v\n2025-09-05T23:59:59.900Z,1\n2025-09-06T00:00:00.150Z,2\n"),
              ElementsAre(0.0, DoubleNear(0.25, 1e-9)));
  EXPECT_THAT(times_of("t_s;v\n2025-09-05 12:00:00,5;1,5\n;2\n2025-09-05 12:00:02;3,5\n"),
              ElementsAre(0.0, testing::IsNan(), DoubleNear(1.5, 1e-9)));
  EXPECT_THAT(times_of("time,v\n2025-10-26T02:59:59+02:00,1\n2025-10-26T02:00:00+01:00,2\n"),
              ElementsAre(0.0, 1.0));
  const Log log = parse_log("t_s,v\n2025-09-05T12:00:00.0Z,1\n2025-09-05T12:00:00.1Z,2\n", "x.csv");
  EXPECT_EQ(log.channels[0].unit, "s");
  EXPECT_NEAR(log.channels[1].rate_hz, 10, 1e-6);
  const std::string canonical = "time_s,v\n2025-09-05T12:00:00.0Z,1\n";
  EXPECT_EQ(parse_log(canonical, "x.csv").channels[0].unit, "") << "its name says it";
}

TEST(IsoTime, ReadsTimesOfDay) {
  const auto time = time_of_day("9:30:05.125");
  ASSERT_TRUE(time);
  EXPECT_EQ(time->whole_s, 34205);
  EXPECT_EQ(time->part_s, 0.125);
  EXPECT_FALSE(time->dated);
  EXPECT_EQ(time_of_day("12:00:00,07")->part_s, 0.07);
  for (const char* other : {"", "12:00", "24:00:00", "12:60:00", "12:00:61", "12:00:00.", "1:2:3",
                            "012:00:00", "12:00:00Z", ":00:00", "2024-05-01T12:00:00"})
    EXPECT_FALSE(time_of_day(other)) << other;
}

TEST(IsoTime, OfTheClockTimesOfDayCountFromTheFirstRow) {
  EXPECT_THAT(times_of("time,v\n12:00:00.1,1\n12:00:00.2,2\n12:01:00.1,2\n"),
              ElementsAre(0.0, DoubleNear(0.1, 1e-12), DoubleNear(60.0, 1e-12)));
  EXPECT_THAT(times_of("time;v\n23:59:59,5;1,5\n0:00:00,5;2\n\n23:59:59,75;2\n0:00:01,5;2\n"),
              ElementsAre(0.0, 1.0, 0.25, 2.0))
      << "over midnight, and a row that is late";
  const Log log = parse_log("time,lap\n0,0:01:20\n1,0:01:21\n", "x.csv");
  EXPECT_EQ(log.channels[1].words, 2u) << "of another column, how long something took";
}

TEST(IsoTime, ClocksInOtherForms) {
  const auto seconds = [](const std::string& first, const std::string& second) {
    const Log log = parse_log("Time,v\n" + first + ",1\n" + second + ",2\n", "x.csv");
    EXPECT_EQ(log.channels[0].unit, "s");
    return log.channels[0].values.at(1);
  };
  EXPECT_NEAR(seconds("0:59.950", "1:00.05"), 0.1, 1e-9);
  EXPECT_NEAR(seconds("59:59.5", "1:00:00.5"), 1.0, 1e-9);
  EXPECT_NEAR(seconds("12:59:59.5 PM", "1:00:00.25 pm"), 0.75, 1e-9);
  EXPECT_NEAR(seconds("5/1/2024 11:59:59.5 AM", "5/1/2024 12:00:00 PM"), 0.5, 1e-9);
  EXPECT_NEAR(seconds("01-May-2024 23:59:59.9", "02-May-2024 00:00:00.1"), 0.2, 1e-9);
  EXPECT_EQ(parse_log("Time,v\n12:05,1\n12:06,2\n", "x.csv").channels[0].words, 2u)
      << "hours and minutes, or minutes and seconds";
  EXPECT_EQ(parse_log("Time,v\n13:00:00 PM,1\n", "x.csv").channels[0].words, 1u);
}

TEST(IsoTime, OfOtherColumnsOddCellsAreWords) {
  const Log log = parse_log("time,fix\n0,0\n1,0\n2,2024-05-01T12:00:00Z\n3,\n", "x.csv");
  EXPECT_EQ(log.channels[1].words, 1u);
  EXPECT_THAT(log.channels[1].values, ElementsAre(0.0, 0.0, testing::IsNan(), testing::IsNan()));
}

TEST(IsoTime, WhatDoesNotFitTheRowsAboveIsRefused) {
  const auto refusal = [](const std::string& text) {
    try {
      (void)parse_log(text, "x.csv");
    } catch (const base::Error& error) {
      return std::string(error.what());
    }
    return std::string("read");
  };
  EXPECT_THAT(refusal("time,v\n2025-09-05T12:00:00,1\n0.1,2\n"),
              AllOf(HasSubstr("x.csv:3: column 'time' holds '0.1'"), HasSubstr("write all alike")));
  EXPECT_THAT(refusal("time,v\n0.1,2\n2025-09-05T12:00:00,1\n"), HasSubstr("x.csv:3:"));
  EXPECT_THAT(refusal("time,v\n2025-09-05T12:00:00,1\n12:00:01,1\n"), HasSubstr("x.csv:3:"));
  EXPECT_THAT(refusal("time,v\n01.05.2024 12:00:00,1\n03.05.2024 12:00:01,1\n"),
              HasSubstr("x.csv:3: column 'time' holds '03.05.2024 12:00:01', another date"));
  EXPECT_THAT(refusal("time,v\n2025-09-05T12:00:00Z,1\n2025-09-05T12:00:00,1\n"),
              HasSubstr("x.csv:3:"));
}

}  // namespace iso_time_test
}  // namespace recording
