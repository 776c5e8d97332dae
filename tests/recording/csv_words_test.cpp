#include "csv_words.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"

namespace recording {
namespace csv_words_test {

const Channel& of(const Log& log, const std::string& name) {
  for (const Channel& channel : log.channels)
    if (channel.name == name) return channel;
  throw std::runtime_error("no channel " + name);
}

TEST(CsvWords, SouthAndWestAreNegative) {
  const Log log = parse_log(
      "time_s,Latitude,N/S,Longitude,E/W\n0,47.1,N,8.1,W\n1,47.2,N,8.2,W\n2,0.1,S,0.1,E\n", "x");
  EXPECT_EQ(of(log, "Latitude").values, (std::vector<double>{47.1, 47.2, -0.1}));
  EXPECT_EQ(of(log, "Longitude").values, (std::vector<double>{-8.1, -8.2, 0.1}));
  EXPECT_THAT(log.notes, testing::Contains(testing::HasSubstr("by the letters of 'E/W'")));
  const Log words = parse_log("time_s,Latitude,town\n0,47.1,W\n1,47.2,Ulm\n", "x");
  EXPECT_EQ(of(words, "Latitude").values, (std::vector<double>{47.1, 47.2}));
}

TEST(CsvWords, ARowForEachSampleOfASignal) {
  const Log log = parse_log(
      "timestamp,can_id,signal,value,unit\n10.0,0x1A0,Speed,50,km/h\n10.02,0x1A1,RPM,3000,rpm\n"
      "10.1,0x1A0,Speed,51,km/h\n10.1,0x1A0,Speed,51,km/h\n10.2,0x1A0,Speed,52,km/h\n",
      "can.csv");
  ASSERT_EQ(log.channels.size(), 2u);
  EXPECT_EQ(of(log, "Speed").values, (std::vector<double>{50, 51, 52}));
  EXPECT_EQ(of(log, "Speed").unit, "km/h");
  EXPECT_NEAR(of(log, "Speed").rate_hz, 10.0, 1e-9);
  EXPECT_NEAR(log.clocks.at(of(log, "RPM").clock).at(0), 0.02, 1e-9);
  EXPECT_THAT(log.notes, testing::ElementsAre(testing::HasSubstr("1 of 5 rows are left out")));
  EXPECT_EQ(in_rows(log, "can.csv").channels.at(1).values.size(), 3u);
}

TEST(CsvWords, RowsOfSeveralCarsAreRefused) {
  try {
    (void)parse_log(
        "timestamp,vehicle_id,telemetry_name,telemetry_value\n0,A,speed,1\n1,B,speed,2\n", "cup");
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("cup: rows of 2 cars, by column 'vehicle_id'"));
  }
}

TEST(CsvWords, RowsOfSeveralCarsAreNoDrive) {
  const auto read = [](const std::string& rows) {
    try {
      return fmt::format("{} rows", parse_log(rows, "x.csv").channels[0].values.size());
    } catch (const base::Error& error) {
      return std::string(error.what());
    }
  };
  EXPECT_THAT(read("VehicleID,Time,v\nA,0,1\nA,1,2\nB,2,3\n"),
              testing::HasSubstr("rows of 2 cars, by column 'VehicleID' ('A', 'B' ...)"));
  EXPECT_THAT(read("Time,Driver,v\n0,A,1\n1,A,2\n0,B,3\n"), testing::HasSubstr("of 2 cars"));
  EXPECT_EQ(read("Time,Driver,v\n0,A,1\n1,A,2\n2,B,3\n"), "3 rows") << "they took turns";
  EXPECT_EQ(read("Time,Vehicle Speed,v\n0,1,1\n1,2,2\n"), "2 rows");
}

}  // namespace csv_words_test
}  // namespace recording
