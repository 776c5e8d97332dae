// What the tables of other loggers have that plain ones have not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/error.h"
#include "recording/log.h"
#include "recording/look.h"

namespace recording {
namespace foreign_csv_test {

using testing::ElementsAre;
using testing::HasSubstr;

Log read(const std::string& text) { return parse_log(text, "x.csv"); }

const Channel& of(const Log& log, const std::string& name) {
  for (const Channel& channel : log.channels)
    if (channel.name == name) return channel;
  throw std::runtime_error("no " + name);
}

std::string refusal(const std::string& text) {
  try {
    (void)read(text);
  } catch (const base::Error& error) {
    return error.what();
  }
  return "read";
}

TEST(ForeignCsv, TitlesBetweenThePartsAreNoRows) {
  const Log log = read(
      "A log\n\n[Channels]\n0,7,9\nOffset,Engine RPM (SAE),Vehicle Speed (SAE)\ns,rpm,mph\n\n"
      "[Rows]\n0.0,900,10\n0.1,950,11\n0.2,990,12\n");
  EXPECT_EQ(of(log, "Vehicle Speed (SAE)").unit, "mph");
  EXPECT_THAT(of(log, "Vehicle Speed (SAE)").values, ElementsAre(10, 11, 12));
  EXPECT_NEAR(of(log, "Offset").rate_hz, 10.0, 1e-9);
}

TEST(ForeignCsv, AChannelInAFileOfItsOwnHasItsUnit) {
  const Log log =
      read("Session, 7 a\ntime, value\ns, V\n0.917000, 4.0\n1.917000, 4.0\n2.917000, 3.9\n");
  EXPECT_EQ(of(log, "value").unit, "V");
  EXPECT_THAT(of(log, "value").values, ElementsAre(4.0, 4.0, 3.9));
  EXPECT_EQ(of(log, "time").unit, "s");
}

TEST(ForeignCsv, AClockWithTooFewDigitsGivesWayToAFinerOne) {
  std::string rows = "Timestamp (s),Time (s),Lap time (s),RPM\n", alone = "Timestamp (s),RPM\n";
  for (int k = 0; k < 60; ++k) {
    rows += std::to_string(k / 10) + "." + std::to_string(k / 10) + "," + std::to_string(0.01 * k) +
            "," + std::to_string(0.01 * (k % 50)) + ",900\n";
    alone += std::to_string(0.1 * (k / 10)) + ",900\n";
  }
  EXPECT_NEAR(of(read(rows), "RPM").rate_hz, 100.0, 1e-6);
  std::string lap_first = "Timestamp (s),Time in lap (s),Time (s),RPM\n";
  for (int k = 0; k < 60; ++k)
    lap_first += std::to_string(0.1 * (k / 10)) + "," + std::to_string(0.005 * (k % 50)) + "," +
                 std::to_string(0.01 * k) + ",900\n";
  EXPECT_NEAR(of(read(lap_first), "RPM").rate_hz, 100.0, 1e-6) << "a time in the lap begins anew";
  EXPECT_NEAR(of(read(alone), "RPM").rate_hz, 10.0, 1e-6) << "it stays the clock";
}

TEST(ForeignCsv, MomentsMarkedAsTextAreMoments) {
  const Log log = read(
      "Time,RPM\n'2024-05-01T12:00:00.0Z,0\n'2024-05-01T12:00:00.1Z,900\n"
      "'2024-05-01T12:00:00.2Z,2500\n");
  EXPECT_NEAR(of(log, "RPM").rate_hz, 10.0, 1e-6);
}

TEST(ForeignCsv, TimesMarkedAsTextAreTimes) {
  const Log log = read(
      "LAP,REC TIME,RPM\nL000,'00:00:00.00,0\nL000,'00:00:00.10,900\nL000,'00:00:00.20,2500\n");
  EXPECT_THAT(of(log, "REC TIME").values,
              ElementsAre(0.0, testing::DoubleNear(0.1, 1e-9), testing::DoubleNear(0.2, 1e-9)));
  EXPECT_NEAR(of(log, "RPM").rate_hz, 10.0, 1e-6);
}

TEST(ForeignCsv, NumbersOfChannelsBelowTheUnitsAreNoSamples) {
  const Log log = read(
      "\"Format\",\"MoTeC CSV File\"\n\n\"Time\",\"Ground Speed\",\"Throttle Pos\"\n"
      "\"s\",\"km/h\",\"%\"\n\"\",\"1\",\"2\"\n0.0,50,10\n0.1,51,11\n0.2,52,12\n");
  EXPECT_THAT(of(log, "Ground Speed").values, ElementsAre(50, 51, 52));
  EXPECT_EQ(of(log, "Throttle Pos").unit, "%");
  // A row whose clock is silent stays, where others do too.
  EXPECT_EQ(read("t,a,b\n,1,2\n,3,4\n").channels[1].values.size(), 2u);
}

TEST(ForeignCsv, NamesTwiceWithASeparatorMoreThanTheRows) {
  const Log log = read(
      "\"Format\",\"AIM CSV File\"\n\"Sample "
      "Rate\",\"10\"\n\n\"Time\",\"Distance\",\"RPM\",\"Speed\",\n"
      "\"Time\",\"Dist\",\"RPM\",\"Spd\",\n\"sec\",\"km\",\"rpm\",\"km/"
      "h\",\n\"\",\"\",\"1\",\"2\",\n\n"
      "\"0.0\",\"0\",\"900\",\"50\"\n\"0.1\",\"0\",\"950\",\"51\"\n");
  EXPECT_THAT(of(log, "Speed").values, ElementsAre(50, 51));
  EXPECT_EQ(of(log, "Speed").unit, "km/h");
  EXPECT_EQ(log.channels.size(), 4u);
}

TEST(ForeignCsv, ATableWithoutNamesIsRefusedAsSuch) {
  for (const char* const text : {"0.0,1.5,2\n0.1,1.6,3\n0.2,1.7,4\n", "0.0 1.5 2\n0.1 1.6 3\n"})
    EXPECT_THAT(refusal(text), HasSubstr("x.csv:1: numbers ('0.0', ...) where the names"));
  EXPECT_EQ(of(read("t,2\n0,1\n1,2\n"), "2").values[1], 2.0) << "a cell of a bus";
}

TEST(ForeignCsv, Utf16AndLatin1AreReadAsWindowsWritesThem) {
  std::string low = "\xFF\xFE", high = "\xFE\xFF";
  for (const char c : std::string("t;v;Gier (\xB0/s)\r\n0,0;5;1,5\r\n0,1;6;2,5\r\n")) {
    low += {c, '\0'};
    high += {'\0', c};
  }
  for (const std::string& text : {low, high, low + "7"})
    EXPECT_THAT(of(read(text), "Gier (°/s)").values, ElementsAre(1.5, 2.5));
  // A character of two halves, and half of one.
  const Log log =
      read(std::string("\xFF\xFEt\0,\0\x3D\xD8\x97\xDE,\0\x3D\xD8\n\0"
                       "1\0,\0"
                       "2\0,\0"
                       "3\0\n\0",
                       28));
  EXPECT_EQ(log.channels[1].name, "\xF0\x9F\x9A\x97");
  EXPECT_EQ(log.channels[2].name, "\xEF\xBF\xBD");
}

TEST(ForeignCsv, ZerosThatFillCellsAreBlanks) {
  std::string text = "INDEX,TIME,SPEED,NOTE\n1**,10,5**,***\n2**,11,6**,***\n";
  std::replace(text.begin(), text.end(), '*', '\0');
  EXPECT_THAT(of(read(text), "SPEED").values, ElementsAre(5, 6));
  std::replace(text.begin(), text.end(), 'E', '\0');
  EXPECT_THAT(refusal(text), HasSubstr("binary"));
}

TEST(ForeignCsv, AHeaderThatComesAgainIsNoRow) {
  const Log log =
      read("Device Time,v(km/h),Altitude\n0,1,2\n1,2,2\nDevice Time,v(km/h),Altitude\n2,3,2\n");
  EXPECT_THAT(of(log, "v(km/h)").values, ElementsAre(1, 2, 3));
  EXPECT_EQ(of(log, "v(km/h)").words, 0u);
  EXPECT_THAT(log.notes, testing::Contains(HasSubstr("1 lines that repeat the header")));
}

TEST(ForeignCsv, NamesThatComeAgainAreNumbered) {
  const Log log = read("Time,Cl,RPM,Cl,\n0,1,900,4,\n1,2,910,5,\n");
  EXPECT_THAT(of(log, "Cl").values, ElementsAre(1, 2));
  EXPECT_THAT(of(log, "Cl #2").values, ElementsAre(4, 5));
  EXPECT_EQ(read(",Time,v\n0,0.0,5\n1,0.1,6\n").channels[0].name, "unnamed #1")
      << "a first column that counts the rows";
  EXPECT_EQ(of(read(",Stamp,,TimeUS\n7,a,IMU,100\n8,b,IMU,200\n"), "unnamed #2").words, 2u);
  EXPECT_THAT(refusal("time_s,vx_mps,vx_mps\n0,1,2\n"),
              HasSubstr("x.csv:1: column 'vx_mps' twice"));
  EXPECT_EQ(of(read("t,gear,gear\n0,1,2\n"), "gear #2").values[0], 2.0) << "no table of ours";
  EXPECT_THAT(refusal("Raw,0,0,18\nFix,1,2,3\nRaw,1,1,18\n"), HasSubstr("'0' twice"));
}

TEST(ForeignCsv, CellsBetweenBlanksAreATable) {
  const Log log =
      read("# a remark\n# timestamp tx ty\n100.5 1.0  -2.0\n100.6 1.5 -2.5\n100.7 2 -3\n");
  EXPECT_THAT(of(log, "ty").values, ElementsAre(-2.0, -2.5, -3.0));
  EXPECT_NEAR(of(log, "timestamp").rate_hz, 10.0, 1e-6);
  EXPECT_EQ(of(read("t v\n0 1\n1 2\n"), "v").values.size(), 2u);
  std::string torn = "t v w\n";
  for (int i = 0; i < 9; ++i) torn += std::to_string(i) + " 1 2\n";
  EXPECT_THAT(refusal(torn + "9 1\n10 1 2\n"), HasSubstr("x.csv:11: "));
}

TEST(ForeignCsv, MetadataInTheHeaderAreNameAndUnit) {
  const Log log = read(
      "\"Interval\"|\"ms\"|0|0|1,\"AccelX\"|\"G\"|-3.0|3.0|25,\"Battery\"|\"Volts\"|0.0|20.0|1\n"
      "400,0.1,12.1\n440,0.2,\n480,0.3,\n");
  EXPECT_EQ(of(log, "AccelX").unit, "G");
  EXPECT_NEAR(of(log, "AccelX").rate_hz, 25.0, 1e-9) << "the clock is in ms";
  EXPECT_EQ(of(log, "Battery").unit, "Volts");
}

TEST(ForeignCsv, WholeNumbersOfHaltechAreScaledByTheirTypes) {
  const Log log = read(
      "%DataLog%\r\nDataLogVersion : 1.1\r\n\r\nChannel : RPM\r\nID : 1\r\nType : EngineSpeed\r\n"
      "DisplayMaxMin : 9,0\r\n\r\nChannel : Vehicle Speed\r\nType : Speed\r\nChannel : Air\r\n"
      "Type : Temperature\r\nChannel : Other\r\nType : New\r\nLog : 20250101 10:00:00\r\n"
      "23:59:59.950,900,500,2931,7\r\n00:00:00.000,910,510,,8\r\n00:00:00.050,920,520,2951,9\r\n");
  EXPECT_EQ(log.format, "CSV of Haltech");
  EXPECT_THAT(of(log, "RPM").values, ElementsAre(900, 910, 920));
  EXPECT_EQ(of(log, "Vehicle Speed").unit, "km/h");
  EXPECT_NEAR(of(log, "Vehicle Speed").values[1], 51.0, 1e-12);
  EXPECT_NEAR(of(log, "Air").values[2], 21.95, 1e-9);
  EXPECT_TRUE(std::isnan(of(log, "Air").values[1]));
  EXPECT_EQ(of(log, "Other").unit, "");
  EXPECT_THAT(log.notes, testing::Contains(HasSubstr("'Other': its type 'New'")));
  EXPECT_NEAR(of(log, "RPM").rate_hz, 20.0, 1e-6) << "over midnight";
  EXPECT_THAT(refusal("%DataLog%\nChannel : A\nType : Raw\n10:00:00.000,1\n10:00:00.1,1,2\n"),
              HasSubstr("x.csv:5: 3 cells"));
  EXPECT_THAT(refusal("%DataLog%\nChannel : A\nType : Raw\n"), HasSubstr("1 channels and no row"));
}

TEST(ForeignCsv, SignalsInRowsBringTheirPlaces) {
  const Log log = read(
      "\"SECONDS\";\"PID\";\"VALUE\";\"UNITS\";\"LATITUDE\";\"LONGTITUDE\";\n"
      "\"10.0\";\"Speed\";\"36\";\"km/h\";\"45.1\";\"15.1\";\n"
      "\"10.1\";\"RPM\";\"900\";\"rpm\";\"45.1\";\"15.2\";\n"
      "\"11.0\";\"Speed\";\"37\";\"km/h\";\"45.2\";\"15.2\";\n"
      "\"11.1\";\"RPM\";\"\";\"rpm\";\"45.2\";\"15.2\";\n");
  EXPECT_EQ(of(log, "Speed").unit, "km/h");
  EXPECT_THAT(of(log, "Speed").values, ElementsAre(36, 37));
  EXPECT_THAT(of(log, "RPM").values, ElementsAre(900));
  EXPECT_THAT(of(log, "LATITUDE").values, ElementsAre(45.1, 45.2));
  EXPECT_THAT(moments_of(log, of(log, "LONGTITUDE")),
              ElementsAre(0.0, testing::DoubleNear(0.1, 1e-9)));
}

TEST(ForeignCsv, ClocksAreDurationsAndHaveManyUnits) {
  EXPECT_THAT(of(read(",SessionTime,v\n0,0 days 01:00:00.250000,1\n1,0 days 01:00:00.500000,2\n"
                      "2,1 day 01:00:00,3\n"),
                 "SessionTime")
                  .values,
              ElementsAre(0.0, 0.25, 86399.75));
  for (const char* header : {"Time (msec),v", "TimestampMS,v", "cts,v", "time [ms],v"})
    EXPECT_NEAR(of(read(std::string(header) + "\n0,1\n4,2\n8,3\n"), "v").rate_hz, 250.0, 1e-6)
        << header;
  EXPECT_NEAR(of(read("SECONDS,v\n0,1\n4,2\n8,3\n"), "v").rate_hz, 0.25, 1e-9);
  EXPECT_NEAR(of(read("time,v\n0,1\n12.5,2\n25,3\n"), "v").rate_hz, 80.0, 1e-9) << "ms";
  EXPECT_NEAR(of(read("time,v\n1700000000.5,1\n1700000010.5,2\n"), "v").rate_hz, 0.1, 1e-9);
  EXPECT_NEAR(of(read("v,(UTC)TimeInMs\n1,1700000000000\n2,1700000000500\n"), "v").rate_hz, 2.0,
              1e-9);
}

TEST(ForeignCsv, ATimeThatRunsIsTheClockWhereNoneIsCalledOne) {
  for (const char* header : {"Section Time (s),v", "lapTime,v", "elapsed_s,v"})
    EXPECT_NEAR(of(read(std::string(header) + "\n-0.5,1\n-0.25,2\n0,3\n"), "v").rate_hz, 4.0, 1e-9)
        << header;
  EXPECT_NEAR(of(read("v,auxTime\n1,1000\n2,1400\n3,1800\n"), "v").rate_hz, 2.5, 1e-9);
  for (const char* header : {"Dwell time (deg),v", "LastLapTime,v", "stage,v"})
    EXPECT_EQ(of(read(std::string(header) + "\n1,1\n1,2\n2,3\n"), "v").rate_hz, 0.0) << header;
  EXPECT_NEAR(of(read("lapTime,time,v\n1,0,1\n2,9,2\n3,18,3\n"), "v").rate_hz, 1 / 9e-3, 1e-9);
}

TEST(ForeignCsv, CellsMayHoldUnitsAndHemispheres) {
  const Log log = read(
      "t,HEIGHT,SPEED,LATITUDE N/S,NOTE\n0,3.5 M,36.0 km/h,48.125000S,2 laps\n"
      "1,4.5 M,37.5 km/h,48.250000S,4 km/h\n2,5.5 M,38 mph,0.500000N,\n");
  EXPECT_EQ(of(log, "HEIGHT").unit, "M");
  EXPECT_THAT(of(log, "HEIGHT").values, ElementsAre(3.5, 4.5, 5.5));
  EXPECT_EQ(of(log, "SPEED").unit, "km/h");
  EXPECT_TRUE(std::isnan(of(log, "SPEED").values[2])) << "another unit is no number of the column";
  EXPECT_EQ(of(log, "SPEED").words, 1u);
  EXPECT_THAT(of(log, "LATITUDE N/S").values, ElementsAre(-48.125, -48.25, 0.5));
  EXPECT_EQ(of(log, "NOTE").words, 1u);
}

TEST(ForeignCsv, MillisecondsOfAnotherColumnBelongToTheClock) {
  const Log log =
      read("UTC TIME,MS,v\n10:00:00,0,1\n10:00:00,500,2\n10:00:01,0,3\n10:00:01,500,4\n");
  EXPECT_THAT(of(log, "UTC TIME").values, ElementsAre(0.0, 0.5, 1.0, 1.5));
  EXPECT_NEAR(of(log, "v").rate_hz, 2.0, 1e-9);
  EXPECT_THAT(of(read("UTC TIME,MS,v\n10:00:00,0,1\n10:00:01,5000,2\n"), "UTC TIME").values,
              ElementsAre(0.0, 1.0));
}

TEST(ForeignCsv, RowsOfOneSecondAreSpreadOverIt) {
  std::string text = "timestamp,v\n";
  std::vector<double> wanted;
  const int rows[] = {2, 4, 5, 4, 3};
  for (int s = 0; s < 5; ++s)
    for (int k = 0; k < rows[s]; ++k) {
      text += "2025-01-01T10:00:0" + std::to_string(s) + ".000,1\n";
      wanted.push_back(s == 0 ? 0.5 + 0.25 * k : s + k / (s == 2 ? 5.0 : 4.0));
    }
  const Log log = read(text);
  EXPECT_THAT(of(log, "timestamp").values, testing::Pointwise(testing::DoubleNear(1e-12), wanted));
  EXPECT_THAT(log.notes, testing::Contains(HasSubstr("about 4 rows each")));
  EXPECT_NEAR(of(log, "v").rate_hz, 4.0, 1e-9);
  // Numbers that nothing calls seconds, and a second that some rows have and most have not.
  EXPECT_EQ(
      of(read("time,v\n0,1\n0,1\n0,1\n1,1\n1,1\n1,1\n2,1\n2,1\n2,1\n3,1\n"), "time").values[1],
      0.0);
  EXPECT_EQ(of(read("time (s),v\n0,1\n1,1\n1,1\n2,1\n3,1\n4,1\n"), "time (s)").values[2], 1.0);
}

TEST(ForeignCsv, AClockOfLapsGoesOn) {
  const Log log = read("Lap,Time,v\n1,0.0,1\n1,0.1,1\n1,0.2,1\n2,0.05,1\n2,0.15,1\n");
  EXPECT_THAT(of(log, "Time").values,
              testing::Pointwise(testing::DoubleNear(1e-12), {0.0, 0.1, 0.2, 0.3, 0.4}));
  EXPECT_THAT(log.notes, testing::Contains(HasSubstr("with each lap of 'Lap', 1 times")));
  // Another reason than a lap.
  EXPECT_EQ(of(read("Lap,Time,v\n1,0.0,1\n1,0.1,1\n1,0.0,1\n2,0.1,1\n"), "Time").values[2], 0.0);
}

TEST(ForeignCsv, ThousandsBesideDecimalsAreRefusedAsSuch) {
  EXPECT_THAT(refusal("t;RPM\n0.5;4,120\n"), HasSubstr("without separators of thousands"));
  EXPECT_THAT(refusal("t;v\n0.5;4,1\n"), testing::Not(HasSubstr("thousands")));
}

}  // namespace foreign_csv_test
}  // namespace recording
