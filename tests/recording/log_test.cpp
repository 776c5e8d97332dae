#include "recording/log.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <set>

#include "base/error.h"
#include "base/read_file.h"
#include "fuzz/mutated.h"
#include "recording/log_table.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace recording {
namespace log_test {

std::string corpus(const std::string& file) {
  return places::source() + "/tests/corpus/logs/" + file;
}

const Channel& of(const Log& log, const std::string& name) {
  for (const Channel& channel : log.channels)
    if (channel.name == name) return channel;
  throw std::runtime_error("no channel " + name);
}

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Log, ReadsMotecWithItsUnitsRatesAndScales) {
  const Log log = read_log(corpus("log.ld"));
  EXPECT_EQ(log.format, "MoTeC .ld");
  EXPECT_EQ(of(log, "Ground Speed").unit, "km/h");
  EXPECT_EQ(of(log, "Ground Speed").rate_hz, 10);
  EXPECT_NEAR(of(log, "Ground Speed").values[3], 103, 1e-9);
  EXPECT_NEAR(of(log, "Engine RPM").values[2], 6012, 1e-9);
  EXPECT_NEAR(of(log, "G Force Lat").values[23], 0.23, 1e-7);
}

TEST(Log, SlowChannelsHaveAsManyValuesAsSamples) {
  const Log rows = in_rows(read_log(corpus("log.ld")), "log");
  ASSERT_EQ(of(rows, "log time").values.size(), 24u);
  const std::vector<double>& rpm = of(rows, "Engine RPM").values;  // 4 Hz in rows of 20 Hz
  EXPECT_EQ(std::count_if(rpm.begin(), rpm.end(), [](double v) { return std::isfinite(v); }), 5);
  EXPECT_NEAR(rpm[10], 6012, 1e-9);
  EXPECT_TRUE(std::isnan(rpm[11]));
}

TEST(Log, SamplesBetweenRowsAreBroughtToTheNearerOne) {
  Log log{"test", {{"a", "m", 10, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}, 0}, {"b", "m", 6, {}, 0}}, false};
  for (int k = 0; k < 6; ++k) log.channels[1].values.push_back(k / 6.0);  // its own time
  const Log rows = in_rows(log, "log");
  int values = 0;
  for (std::size_t i = 0; i < 10; ++i)
    if (const double b = of(rows, "b").values[i]; std::isfinite(b)) {
      EXPECT_NEAR(b, 0.1 * static_cast<double>(i), 1e-12);
      ++values;
    }
  EXPECT_EQ(values, 6);
}

TEST(Log, ReadsRacelogicOverMidnight) {
  const Log log = read_log(corpus("log.vbo"));
  EXPECT_NEAR(of(log, "time").values[0], 86399.9, 1e-6);
  EXPECT_NEAR(of(log, "time").values[3], 86400.02, 1e-6);
  EXPECT_NEAR(of(log, "lat").values[3], 2627.79 / 60, 1e-9);
  EXPECT_NEAR(of(log, "long").values[3], -5279.39 / 60, 1e-9);
  EXPECT_EQ(of(log, "velocity").unit, "km/h");
  EXPECT_EQ(of(log, "Oil").unit, "°C") << "in UTF-8, whatever the file has";
  EXPECT_EQ(of(log, "Tsample").unit, "s");
  EXPECT_NEAR(of(log, "Gear").rate_hz, 25, 1e-6);
}

/// A log of one row under `titles`, with `units` as they stand in the file.
Log vbo_with(const std::string& titles, const std::string& units, const std::string& names) {
  std::string text = "File created\r\n\r\n[header]\r\n" + titles;
  text += "\r\n[channel units]\r\n" + units + "\r\n[column names]\r\n" + names;
  text += "\r\n\r\n[data]\r\n";
  const auto columns = 1 + std::count(names.begin(), names.end(), ' ');
  for (int row = 0; row < 2; ++row) {
    text += row == 0 ? "120000.0" : "120000.1";
    for (std::ptrdiff_t c = 1; c < columns; ++c) text += " 1";
    text += "\r\n";
  }
  return parse_log(text, "x.vbo");
}

std::string units_of(const Log& log) {
  std::string out;
  for (const Channel& channel : log.channels) out += channel.name + "[" + channel.unit + "] ";
  return out;
}

TEST(Log, BlankUnitsOfRacelogicBelongToChannels) {
  // As a receiver with an inertial unit writes it: standard channels among the listed ones.
  const std::string names =
      "time velocity Longacc AD1 GPS_Sats Status Velocity_Quality _lat Temp YawRate X_Accel";
  EXPECT_EQ(units_of(vbo_with("", "volts\r\n\r\nC\r\ndeg/s\r\ng\r\n", names)),
            "time[s] velocity[km/h] Longacc[] AD1[volts] GPS_Sats[1] Status[] Velocity_Quality[] "
            "_lat[] Temp[C] YawRate[deg/s] X_Accel[g] ");
  // The last one has no unit: its blank line, and the one before the next section.
  EXPECT_EQ(units_of(vbo_with("", "V\r\n\r\n", "time a b")), "time[s] a[V] b[] ");
  EXPECT_EQ(units_of(vbo_with("", "V\r\n(null)\r\n", "time a b")), "time[s] a[V] b[] ");
  // Older receivers list no unit for the sample period.
  EXPECT_EQ(units_of(vbo_with("", "V\r\nC\r\n", "time Tsample a b")),
            "time[s] Tsample[] a[V] b[C] ");
}

TEST(Log, UnitsOfRacelogicThatFitNoChannelsAreNotUsed) {
  const Log log = vbo_with("", "V\r\nC\r\n", "time a b c d");
  EXPECT_EQ(units_of(log), "time[s] a[] b[] c[] d[] ");
  ASSERT_EQ(log.notes.size(), 1u);
  EXPECT_THAT(log.notes[0], testing::HasSubstr("line 5 lists 2 units"));
}

TEST(Log, TitlesOfRacelogicSayUnits) {
  EXPECT_EQ(units_of(vbo_with("time\r\nvelocity knots\r\nlong accel g\r\nlean angle\r\n", "",
                              "time velocity longacc lean")),
            "time[s] velocity[knots] longacc[g] lean[] ");
  EXPECT_EQ(units_of(vbo_with("time\r\nvelocity kmh\r\nyaw rate deg/s\r\nSlip Angle\r\n",
                              "Degrees\r\n\r\n\r\n", "time velocity yaw-calc slip")),
            "time[s] velocity[km/h] yaw-calc[deg/s] slip[Degrees] ");
  EXPECT_EQ(units_of(vbo_with("time\r\n", "", "time longacc")), "time[s] longacc[] ")
      << "titles of other columns say nothing";
  EXPECT_EQ(
      units_of(vbo_with("time\r\nvelocity mi/h\r\nheight ft\r\n", "", "time velocity height")),
      "time[s] velocity[] height[ft] ");
}

TEST(Log, UnitsOfRacelogicThatFitInTwoWaysAreNotKnown) {
  // Two units for three channels: either the period or the one whose title names a unit has none.
  const Log log = vbo_with("time\r\nTsample\r\nroll deg\r\nspring\r\n", "V\r\nC\r\n",
                           "time Tsample roll spring");
  EXPECT_EQ(units_of(log), "time[s] Tsample[] roll[] spring[C] ");
  ASSERT_EQ(log.notes.size(), 1u);
  EXPECT_THAT(log.notes[0], testing::HasSubstr("the units of Tsample, roll are not known"));
}

TEST(Log, ReadsIracing) {
  const Log log = read_log(corpus("log.ibt"));
  EXPECT_EQ(log.channels.size(), 6u);
  EXPECT_NEAR(of(log, "SessionTime").values[5], 100 + 5 / 60.0, 1e-12);
  EXPECT_EQ(of(log, "Gear").values[0], 3);
  EXPECT_EQ(of(log, "Torque_ST.1").values[2], 2.5);
  EXPECT_EQ(of(log, "Speed").unit, "m/s");
  EXPECT_EQ(of(log, "Speed").rate_hz, 60);
}

TEST(Log, ReadsExportsOfLoggers) {
  const Log chrono = read_log(corpus("racechrono.csv"));
  EXPECT_EQ(of(chrono, "calc speed").values[0], 33.4);
  EXPECT_EQ(of(chrono, "gps speed").unit, "m/s");
  EXPECT_NEAR(of(chrono, "gps speed").rate_hz, 50, 0.01);
  const Log aim = read_log(corpus("aim.csv"));
  EXPECT_EQ(of(aim, "GPS Speed").unit, "km/h");
  EXPECT_EQ(of(aim, "GPS Speed").values, (std::vector<double>{100, 101, 102, 103, 104}));
  const Log motec = read_log(corpus("motec.csv"));
  EXPECT_EQ(of(motec, "Steered Angle").unit, "deg");
  EXPECT_EQ(of(motec, "Ground Speed").values.size(), 5u);
  const Log comma = read_log(corpus("komma.csv"));
  EXPECT_NEAR(of(comma, "Zeit").values[3], 0.15, 1e-12);
  EXPECT_EQ(of(comma, "Lenkwinkel").unit, "°");
  EXPECT_EQ(of(comma, "Lenkwinkel").values[0], -1.5);
}

TEST(Log, APreambleThatASpreadsheetHasPaddedIsNoHeader) {
  const Log log = parse_log(
      "Format,AiM CSV File,,\nVehicle,,,\nDuration,535.9,,\nBeacon Markers,62.7,117.7,171\n"
      "Segment Times,01:02.8,00:54.9,\n,,,\nTime,GPS Speed,GPS LatAcc,GPS Gyro\ns,km/h,g,deg/s\n"
      ",,,\n0,49,0.1,1\n0.05,50,0.2,2\n0.1,51,0.3,3\n",
      "aim.csv");
  EXPECT_EQ(of(log, "GPS LatAcc").values, (std::vector<double>{0.1, 0.2, 0.3}));
  EXPECT_EQ(of(log, "GPS Gyro").unit, "deg/s");
  EXPECT_NEAR(of(log, "GPS Speed").rate_hz, 20, 1e-9);
  EXPECT_THAT(log.notes,
              testing::ElementsAre(testing::HasSubstr("states 535.9 s, its rows end after 0.1 s")));
}

TEST(Log, APreambleOfPairsIsNoTable) {
  const Log log = parse_log(
      "Format,RaceBox CSV\nTrack,Ring\nDate UTC,2024-05-01T12:00:00Z\n\n"
      "Record,Time,Speed,GForceX\n1,2024-05-01T12:00:00.000Z,50.5,0.1\n"
      "2,2024-05-01T12:00:00.040Z,51,0.2\n3,2024-05-01T12:00:00.080Z,52,0.3\n",
      "box.csv");
  EXPECT_EQ(of(log, "Speed").values, (std::vector<double>{50.5, 51, 52}));
  EXPECT_NEAR(of(log, "Time").values[2], 0.08, 1e-12);
  EXPECT_NEAR(of(log, "Speed").rate_hz, 25, 1e-9);
}

TEST(Log, MarksBetweenTheRowsAreLeftOut) {
  const Log log = parse_log(
      "\"MS3 Format\"\nTime\tRPM\tVSS\ns\trpm\tmph\n0\t1000\t10\n0.1\t1010\t11\n"
      "MARK 001 - manual\n0.2\t1020\t12\n",
      "x.msl");
  EXPECT_EQ(of(log, "RPM").values, (std::vector<double>{1000, 1010, 1020}));
  EXPECT_THAT(log.notes, testing::ElementsAre(testing::HasSubstr("1 lines of marks")));
}

TEST(Log, BeaconsInThePreambleCountLaps) {
  const auto with = [](const std::string& beacons) {
    return parse_log("Format,AiM CSV File,,\nBeacon Markers," + beacons +
                         "\n,,,\nTime,GPS Speed,GPS LatAcc,GPS Gyro\ns,km/h,g,deg/s\n"
                         "0,49,0.1,1\n0.05,50,0.2,2\n0.1,51,0.3,3\n0.15,52,0.3,3\n",
                     "aim.csv");
  };
  const Log log = with("0.05,0.12,171");
  EXPECT_EQ(of(log, "beacon lap").values, (std::vector<double>{1, 2, 2, 3}));
  EXPECT_NEAR(of(log, "beacon lap").rate_hz, 20, 1e-9);
  EXPECT_THAT(log.notes, testing::ElementsAre(testing::AllOf(
                             testing::HasSubstr("laps end at 0.050, 0.120 s"),
                             testing::HasSubstr("1 behind the last sample left out"))));
  EXPECT_EQ(of(with("\"0.05 0.12\","), "beacon lap").values, (std::vector<double>{1, 2, 2, 3}));
  EXPECT_EQ(with("62.7,117.7").channels.size(), 4u);  // none of them is in the log
}

TEST(Log, BeaconsOfTheLdxBesideAnLdCountLaps) {
  const support::TemporaryFolder folder;
  const std::string path = folder.path("drive.ld");
  std::filesystem::copy_file(corpus("log.ld"), path);
  const Log without = read_log(path);
  const auto& longest = *std::max_element(
      without.channels.begin(), without.channels.end(),
      [](const auto& a, const auto& b) { return a.values.size() < b.values.size(); });
  const double step_us = 1e6 / longest.rate_hz;
  folder.file("drive.ldx",
              fmt::format("<LDXFile><MarkerGroup Name=\"Beacons\"><Marker Version=\"100\" "
                          "ClassName=\"BCN\" Name=\"Manual.1\" Flags=\"77\" Time=\"{}\"/>"
                          "<Marker ClassName=\"OTHER\" Time=\"0\"/>"
                          "<Marker Time=\"9e+12\" ClassName=\"BCN\"/></MarkerGroup></LDXFile>",
                          1.5 * step_us));
  const Log log = read_log(path);
  ASSERT_EQ(log.channels.size(), without.channels.size() + 1);
  const auto& lap = of(log, "beacon lap");
  ASSERT_EQ(lap.values.size(), longest.values.size());
  EXPECT_EQ(lap.rate_hz, longest.rate_hz);
  EXPECT_EQ(lap.values[1], 1.0);
  EXPECT_EQ(lap.values[2], 2.0);
  EXPECT_EQ(lap.values.back(), 2.0);
  EXPECT_THAT(log.notes.back(), testing::HasSubstr("drive.ldx"));
  folder.file("drive.ldx", "<Marker ClassName=\"BCN\" Time=\"1:02.8\"/>");
  const Log broken = read_log(path);
  EXPECT_EQ(broken.channels.size(), without.channels.size());
  EXPECT_THAT(broken.notes.back(), testing::HasSubstr("'1:02.8', where microseconds"));
  std::filesystem::remove(folder.path("drive.ldx"));
  std::string many;
  for (int k = 1; k <= 40; ++k)
    many += fmt::format("<Marker ClassName=\"BCN\" Time=\"{}\"/>", 0.01 * k * step_us);
  folder.file("drive.LDX", many);
  EXPECT_THAT(read_log(path).notes.back(), testing::HasSubstr(" and 10 more s, by "));
  folder.file("drive.LDX", "<Marker ClassName=\"BCN\" Time=\"");  // without an end
  EXPECT_EQ(read_log(path).channels.size(), without.channels.size());
}

TEST(Log, LongitudesAreCalledLngToo) {
  const Log log = parse_log(
      "[column names]\ntime lat lng\n[data]\n120000.0 +2743.9 -784.3\n120000.1 +2743.9 -784.4\n",
      "box.vbo");
  EXPECT_NEAR(of(log, "lat").values[0], 2743.9 / 60, 1e-12);
  EXPECT_NEAR(of(log, "lng").values[1], 784.4 / 60, 1e-12);
}

TEST(Log, FormatsThatAreNotReadAreNamedWithTheWayOut) {
  const auto refusal = [](const std::string& begin) {
    try {
      parse_log(begin + std::string(200, '\0'), "x");
    } catch (const base::Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal("MDF     4.10    "),
              testing::HasSubstr("x: ASAM MDF, which is not read; export"));
  EXPECT_THAT(refusal("<hCNF"), testing::HasSubstr("AiM .xrk"));
  EXPECT_THAT(refusal("PK\x03\x04"), testing::HasSubstr("spreadsheet"));
  EXPECT_THAT(refusal("PAR1"), testing::HasSubstr("Parquet"));
  EXPECT_THAT(refusal("MATLAB 7.3 MAT-file"), testing::HasSubstr("MATLAB .mat"));
  EXPECT_THAT(refusal("ULog\x01\x12"), testing::HasSubstr("PX4 .ulg"));
  EXPECT_THAT(refusal("ARROW1"), testing::HasSubstr("Arrow or Feather"));
  EXPECT_THAT(refusal(std::string("\x0e\x10\x5c\x08\x6c\x07\0\0.FIT", 12)),
              testing::HasSubstr("Garmin .fit"));
  const auto text_refusal = [](const std::string& text) {
    try {
      parse_log(text, "x");
    } catch (const base::Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(text_refusal("<?xml version=\"1.0\"?>\n<gpx><trk>\n<trkpt lat=\"1\"/>\n"),
              testing::HasSubstr("GPX, KML and TCX"));
  EXPECT_THAT(text_refusal("\xEF\xBB\xBF<?xml version=\"1.0\"?>\n<kml>\n"),
              testing::HasSubstr("gpsbabel"));
  EXPECT_THAT(text_refusal("$GPRMC,100000.00,A,4506.0,N,00912.0,E,38.9,084.4,301126,,*00\n"),
              testing::HasSubstr("NMEA 0183"));
  EXPECT_THAT(text_refusal("[{\"t\":0,\"v\":1},\n{\"t\":1,\"v\":2}]\n"),
              testing::HasSubstr("x: JSON, which is not read"));
  EXPECT_THAT(text_refusal("[\n  {\n    \"t\": 0\n  }\n]\n"), testing::HasSubstr("JSON"));
  EXPECT_THAT(text_refusal("{\r\n \"t\": [0, 1]\r\n}\r\n"), testing::HasSubstr("JSON"));
  EXPECT_THAT(text_refusal("$PVENDOR,1\r\n$GNVTG,84.4,T,,M,38.9,N,72.0,K,A*00\r\n"),
              testing::HasSubstr("NMEA 0183"));
  EXPECT_THAT(text_refusal("03/15/2010,14:08:45.876,$GPGLL,4506.0,N,00912.0,E,100000.00,A*17\n"),
              testing::HasSubstr("NMEA 0183"));
  EXPECT_THAT(text_refusal("(1700000000.250000) can1 123#00FF\n(1700000000.260000) can1 124#0\n"),
              testing::HasSubstr("frames of a CAN bus"));
  EXPECT_THAT(text_refusal("FMT, 128, 89, FMT, B, Type\nGPS, 1, 2\n"),
              testing::HasSubstr("ArduPilot .log"));
  EXPECT_THAT(text_refusal("# notes\n# Raw,ElapsedRealtimeMillis,A\nRaw,0,0\nFix,0,1\n"),
              testing::HasSubstr("rows of fixes"));
  EXPECT_THAT(text_refusal("Monday,VCDS Version: 1\n,TIME,A\nMarker,STAMP,rpm\n,0,1\n"),
              testing::HasSubstr("groups have a clock each"));
  EXPECT_THAT(text_refusal("; GMOS Trace 3.0.1\n#V=4.0.0=\n<trace #pt=1>\n43.1,-85.4,17,1\n"),
              testing::HasSubstr("SpeedAngle"));
  EXPECT_THAT(text_refusal("Type,Local Number,Message,Field 1\nData,0,record,speed\n"),
              testing::HasSubstr("gpsbabel"));
  EXPECT_THAT(text_refusal("one two\nthree four five\n"), testing::HasSubstr("no log"));
  // Tables may begin like that.
  EXPECT_EQ(parse_log("LOGGED,PAR2\n1,2\n", "x").channels.front().name, "LOGGED");
  EXPECT_EQ(parse_log("PAR1,PAR2\n1,2\n", "x").channels.front().name, "PAR1");
}

TEST(Log, OfMotecOnlyTheChannelIsLeftOutWhoseSamplesAreUnknown) {
  std::string bytes = base::read_file(corpus("log.ld"));
  const std::size_t whole = parse_log(bytes, "log.ld").channels.size();
  std::uint32_t first = 0;
  std::memcpy(&first, bytes.data() + 8, sizeof first);
  bytes[first + 20] = 1;  // bytes of a sample
  const Log log = parse_log(bytes, "log.ld");
  EXPECT_EQ(log.channels.size(), whole - 1);
  EXPECT_THAT(log.notes, testing::ElementsAre(testing::HasSubstr("with 1 bytes are not read")));
}

TEST(Log, AnImageOfTheSimulatorsLiveMemoryIsNoRecording) {
  std::string bytes = base::read_file(corpus("log.ibt"));
  bytes[32] = 3;  // buffers
  try {
    parse_log(bytes, "live.ibt");
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(),
                testing::HasSubstr("live.ibt: an image of the simulator's live memory"));
  }
}

TEST(Log, AHeaderMayBeginWithAHash) {
  const Log log = read_log(corpus("hash.csv"));
  EXPECT_EQ(of(log, "vx_mps").values.size(), 5u);
  EXPECT_EQ(of(log, "time_s").values[1], 0.05);
}

TEST(Log, RefusesInOneLine) {
  const auto refusal = [](std::string bytes) {
    try {
      (void)parse_log(bytes, "x.ld");
    } catch (const base::Error& error) {
      return std::string(error.what());
    }
    return std::string("read");
  };
  const std::string ld = bytes_of(corpus("log.ld"));
  EXPECT_THAT(refusal(ld.substr(0, ld.size() - 10)), testing::HasSubstr("was cut off"));
  std::string circle = ld;
  circle[64 + 2 * 124 + 4] = 64;  // the last channel's next is the first
  EXPECT_THAT(refusal(circle), testing::HasSubstr("circle"));
  EXPECT_THAT(refusal(std::string(500, '\0')), testing::HasSubstr("binary"));
  const std::string ibt = bytes_of(corpus("log.ibt"));
  EXPECT_THAT(refusal(ibt.substr(0, 144 * 6 + 20)), testing::HasSubstr("no whole record"));
  std::string many = ibt;
  many[144 + 8] = 2;  // the first variable is an array that others lie in
  EXPECT_THAT(refusal(many), testing::HasSubstr("bytes, but a record has 25; the file is damaged"));
}

// A record of 100,000 bytes, each a variable of its own, all of one name.
TEST(Log, VeryManyNamesTakeNoLongerThanTheirBytes) {
  const std::string ibt = bytes_of(corpus("log.ibt"));
  constexpr std::int32_t kMany = 100'000;
  std::string bytes = ibt.substr(0, 144);
  const auto put = [&](std::size_t at, std::int32_t value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
  };
  put(24, kMany);  // variables, in a record of as many bytes, behind their headers
  put(36, kMany);
  put(52, 144 + 144 * kMany);
  for (std::int32_t k = 0; k < kMany; ++k) {
    const std::size_t at = bytes.size();
    bytes.append(144, '\0');
    put(at, 1);
    put(at + 4, k);
    put(at + 8, 1);
    bytes[at + 16] = 'a';
  }
  bytes.append(12 * kMany, '\1');
  const auto begin = std::chrono::steady_clock::now();
  const Table table = parse_log_table(bytes, "x.ibt");
  EXPECT_EQ(table.names.size(), static_cast<std::size_t>(kMany));
  EXPECT_EQ(std::set<std::string>(table.names.begin(), table.names.end()).size(),
            table.names.size());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

std::string refusal_of(const std::string& text) {
  try {
    (void)parse_log(text, "x.csv");
  } catch (const base::Error& error) {
    return error.what();
  }
  return "read";
}

Channel second(const std::string& text) { return parse_log(text, "x.csv").channels.at(1); }

TEST(Log, DecimalsAreWrittenAllAlike) {
  using testing::HasSubstr;
  EXPECT_THAT(refusal_of("t;v;w\n0.1;1,5;2.5\n0.2;1,6;2.5\n"),
              HasSubstr("x.csv:2: column 'v' holds '1,5', but other decimals of this table have "
                        "'.'; write all alike"))
      << "not a column of words";
  std::string late = "t;v\n";
  for (int i = 0; i < 400; ++i) late += std::to_string(i) + ";7\n";
  EXPECT_EQ(second(late + "400;7,5\n").values.back(), 7.5) << "decimals far below the header";
  EXPECT_THAT(refusal_of(late + "400;7,5\n401;7.5\n"), HasSubstr("x.csv:403: column 'v'"));
}

TEST(Log, NumbersWithCommasThatAreNoneAreRefused) {
  using testing::HasSubstr;
  for (const char* cell : {"1,234.5", "-1,234,567", "1.234,5", "1,234,567.25"})
    EXPECT_THAT(refusal_of(std::string("t;v\n0;") + cell + "\n"),
                HasSubstr(std::string("x.csv:2: column 'v' holds '") + cell))
        << cell;
  EXPECT_THAT(refusal_of("t,v\n0,\"1,234\"\n"), HasSubstr("x.csv:2: column 'v' holds '1,234'"));
  EXPECT_EQ(second("t,v\n0,\"1,25\"\n").values.front(), 1.25) << "no thousands";
  EXPECT_THAT(refusal_of("t,v\n0.5,\"1,25\"\n"), HasSubstr("write all alike"));
  for (const char* word : {"1,2,3", "a,5", ",", "192.168.0.1", "1,234 m"})
    EXPECT_EQ(second(std::string("t;v\n0;") + word + "\n").words, 1u) << word;
}

TEST(Log, OfACutOffLineLessThanTheHeaderNamesIsLeftOut) {
  EXPECT_EQ(second("t,v\n0,1\n1").values.size(), 1u);
  EXPECT_THAT(refusal_of("t,v\n0,1\n1,2,3"), testing::HasSubstr("x.csv:3: 3 cells"));
}

TEST(Log, SeparatorsBehindTheNamesArePassedOver) {
  for (const char* text : {"t,v,,\n0,1\n1,2\n", "t,v,\n0,1,\n1,2,\n"})
    EXPECT_EQ(parse_log(text, "x.csv").channels.size(), 2u) << text;
  EXPECT_THAT(refusal_of("t,v,\n0,1,2\n"), testing::HasSubstr("x.csv:2: 3 cells"));
  EXPECT_THAT(refusal_of("time_s,,v\n0,1,2\n"), testing::HasSubstr("x.csv:1: a column without"));
}

TEST(Log, MutantsAreReadOrRefused) {
  const char* const wanted = std::getenv("KERBSTONE_MUTANTS");
  const int mutants = wanted != nullptr ? std::atoi(wanted) : 300;
  for (const auto& file : std::filesystem::directory_iterator(corpus(""))) {
    const std::string bytes = bytes_of(file.path().string());
    std::mt19937_64 generator(1);
    for (int k = 0; k < mutants; ++k) {
      try {
        (void)in_rows(parse_log(fuzz::mutated(bytes, generator, 600), "log"), "log");
      } catch (const base::Error& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("log"));
      }
    }
  }
}

TEST(Log, ReadsRealLogsAsTheyAre) {
  const std::filesystem::path folder = places::data() + "/recordings";
  if (!std::filesystem::exists(folder / "Sample1.ld"))
    GTEST_SKIP() << "no real logs beside the checkout";
  struct Real {
    const char* file;
    std::size_t channels;
    double rate_hz;
  };
  for (const Real& real :
       {Real{"Sample1.ld", 78, 100}, Real{"iracing_valid.ibt", 281, 60},
        Real{"road_america_run1.vbo", 33, 25}, Real{"road_america_run4.vbo", 33, 25},
        Real{"racechrono_tianma_lap9.csv", 26, 0}}) {
    const Log log = read_log((folder / real.file).string());
    EXPECT_EQ(log.channels.size(), real.channels) << real.file;
    double fastest = 0;
    for (const Channel& channel : log.channels) {
      EXPECT_GT(channel.rate_hz, 0) << real.file << ' ' << channel.name;
      fastest = std::max(fastest, channel.rate_hz);
    }
    if (real.rate_hz > 0) {
      EXPECT_NEAR(fastest, real.rate_hz, 0.01) << real.file;
    }
  }
  EXPECT_THROW((void)read_log((folder / "iracing_invalid.ibt").string()), base::Error);
  if (const std::string modena = places::data() + "/logs2/vbox-modena.vbo";
      std::filesystem::exists(modena)) {
    const Log log = read_log(modena);
    EXPECT_EQ(of(log, "longacc").unit, "g");
    EXPECT_EQ(of(log, "longacc-calc").unit, "g");
    EXPECT_EQ(of(log, "velocity").unit, "km/h");
  }
  EXPECT_EQ(of(read_log((folder / "road_america_run4.vbo").string()), "Brake_Pressure_Front").unit,
            "bar");
}

}  // namespace log_test
}  // namespace recording
