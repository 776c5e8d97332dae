#include "recording/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "base/error.h"
#include "base/write_file.h"
#include "recording/log_table.h"
#include "support/places.h"

namespace recording_test {

using namespace recording;  // NOLINT: a test of this library
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string error_of(const auto& f) {
  try {
    f();
  } catch (const base::Error& error) {
    return error.what();
  }
  return "";
}

class RecordingFile : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    const std::string path = (std::filesystem::temp_directory_path() /
                              ("kerbstone_recording_" + std::to_string(::getpid()) + "_" + name))
                                 .string();
    base::write_file(path, text);
    return path;
  }
};

TEST_F(RecordingFile, MapsForeignColumnsUnitsSignsAndDelays) {
  std::string log = "\"t(ms)\";v kmh;head deg;note\n";
  for (int i = 0; i < 20; ++i)
    log += std::to_string(10 * i) + ";" + std::to_string(36 + i) + ";" + std::to_string(-i) +
           ";word\n";
  log += "200;5";  // cut off
  const Mapping mapping = read_mapping(write(
      "m.yaml",
      "version: 1\ncolumns:\n"
      "  t(ms): {channel: time_s, scale: 0.001}\n"
      "  v kmh: {channel: vx_mps, scale: 0.2777777777777778}\n"
      "  head deg: {channel: yaw_rad, scale: -0.017453292519943295, offset: 1, delay_s: 0.02}\n"));
  const Recording r = read_recording(write("log.csv", log), mapping);
  EXPECT_EQ(r.table.rows(), 20u);
  EXPECT_NEAR(r.table.columns[0][3], 0.03, 1e-12);
  EXPECT_NEAR((*r.table.find("vx_mps"))[4], 40 / 3.6, 1e-12);
  // Stamped 20 ms late: what is written two rows later.
  EXPECT_NEAR((*r.table.find("yaw_rad"))[4], 1 + 6 * std::numbers::pi / 180, 1e-12);
  EXPECT_TRUE(std::isnan((*r.table.find("yaw_rad"))[19]));
  EXPECT_NEAR(r.step_s, 0.01, 1e-12);
  EXPECT_EQ(r.stretches.size(), 1u);
}

TEST(Recording, FindsRepeatsLateRowsResetsGapsAndHeldSamples) {
  Table log;
  std::vector<double> t, v, held, pedal;
  const auto add = [&](double time) {
    const auto i = static_cast<double>(t.size());
    t.push_back(time);
    v.push_back(10 + 0.1 * i);
    held.push_back(std::floor(i / 2));  // every second sample is the one before
    pedal.push_back(1);
  };
  for (int i = 0; i < 20; ++i) add(5 + 0.1 * i);  // to 6.9
  add(6.9);                                       // once more
  add(6.85);                                      // late
  add(7.0);
  add(8.5);  // a gap of 1.5 s
  add(8.6);
  for (int i = 0; i < 10; ++i) add(0.1 * i);  // the clock begins anew
  add(std::nan(""));
  log.add("time_s", t);
  log.add("vx_mps", v);
  log.add("yaw_rate_radps", held);
  log.add("throttle_command", pedal);
  const Recording r = make_recording(log, "log");
  EXPECT_EQ(r.rows_read, 36u);
  EXPECT_EQ(r.rows_repeated, 1u);
  EXPECT_EQ(r.rows_backwards, 1u);
  EXPECT_EQ(r.clock_resets, 1u);
  EXPECT_EQ(r.rows_without_time, 1u);
  EXPECT_EQ(r.table.rows(), 33u);
  EXPECT_DOUBLE_EQ(r.first_trouble_s, 6.9);
  ASSERT_EQ(r.stretches.size(), 3u);
  EXPECT_EQ(r.stretches[0].end, 21u);
  EXPECT_EQ(r.stretches[1].end, 23u);
  EXPECT_NEAR(r.longest_gap_s, 1.5, 1e-9);
  for (std::size_t i = 1; i < r.table.rows(); ++i)
    EXPECT_GT(r.table.columns[0][i], r.table.columns[0][i - 1]);
  ASSERT_EQ(r.held.size(), 1u);
  EXPECT_EQ(r.held[0].first, "yaw_rate_radps");
  EXPECT_NEAR(r.held[0].second, 0.5, 0.05);
  EXPECT_THAT(r.constant, ElementsAre("throttle_command"));
}

// A sensor ahead of the centre of mass and turned, on a car that turns ever faster on the spot:
// what the sensor feels is worked out by hand.
TEST(Recording, TakesNoClockThatASecondDoesNotMove) {
  Table log;
  std::vector<double> t;
  for (int i = 0; i < 12; ++i) t.push_back(0.1 * i);
  for (const double far : {1e300, 1e200, 9e15, -1e308}) t.push_back(far);
  for (int i = 12; i < 24; ++i) t.push_back(0.1 * i);
  log.add("time_s", t);
  const Recording r = make_recording(log, "log");
  EXPECT_EQ(r.rows_without_time, 4u);
  ASSERT_EQ(r.table.rows(), 24u);
  for (std::size_t i = 1; i < 24; ++i) EXPECT_GT(r.table.columns[0][i], r.table.columns[0][i - 1]);
}

TEST(Recording, MovesTheAccelerometerAndTakesOutItsFilter) {
  constexpr double kAhead = 1.5, kYaw = 0.1, kRate2 = 0.4;
  Table log;
  std::vector<double> t, rate, ax, ay, slow;
  for (int i = 0; i < 50; ++i) {
    const double time = 0.01 * i;
    t.push_back(time);
    rate.push_back(kRate2 * time);
    const double forward = -kAhead * kRate2 * kRate2 * time * time, left = kAhead * kRate2;
    ax.push_back(std::cos(kYaw) * forward + std::sin(kYaw) * left);
    ay.push_back(-std::sin(kYaw) * forward + std::cos(kYaw) * left);
    slow.push_back(3 * (time - 0.05));  // a ramp 3 t after a filter of 50 ms, settled
  }
  log.add("time_s", t);
  log.add("yaw_rate_radps", rate);
  log.add("ax_mps2", ax);
  log.add("ay_mps2", ay);
  log.add("vx_mps", slow);
  Mapping mapping;
  for (const std::string& name : log.names) mapping.columns.push_back({name, name});
  mapping.columns[4].low_pass_s = 0.05;
  mapping.imu_yaw_rad = kYaw;
  mapping.imu_ahead_m = kAhead;
  const Recording r = make_recording(log, "log", mapping);
  for (std::size_t i = 1; i + 1 < t.size(); ++i) {
    EXPECT_NEAR((*r.table.find("ax_mps2"))[i], 0, 1e-12);
    EXPECT_NEAR((*r.table.find("ay_mps2"))[i], 0, 1e-12);
    EXPECT_NEAR((*r.table.find("vx_mps"))[i], 3 * t[i], 1e-12);
  }
}

TEST(Recording, FillsGapsAlongStraightLines) {
  const double nan = std::nan("");
  EXPECT_THAT(fill_gaps({0, 1, 3, 4, 5}, {nan, 2, nan, 8, nan}), ElementsAre(2, 2, 6, 8, 8));
  EXPECT_TRUE(std::isnan(fill_gaps({0, 1}, {nan, nan})[0]));
}

TEST_F(RecordingFile, RefusesWithPlaceAndReason) {
  const std::string log = write("l.csv", "t,v\n1,2\n");
  EXPECT_THAT(error_of([&] { read_recording(log); }), HasSubstr("no channel time_s"));
  EXPECT_THAT(error_of([&] { read_recording(write("d.csv", "time_s,time_s\n1,2\n")); }),
              HasSubstr(":1"));
  EXPECT_THAT(error_of([&] { read_recording(write("c.csv", "t,v\n1,2\n3\n4,5\n")); }),
              HasSubstr(":3: 1 cells"));
  const auto refusal = [&](const std::string& yaml) {
    return error_of([&] { read_recording(log, read_mapping(write("bad.yaml", yaml))); });
  };
  EXPECT_THAT(refusal("columns:\n  t: {channel: time}\n"),
              HasSubstr("bad.yaml:2: there is no channel 'time'"));
  EXPECT_THAT(refusal("columns:\n  t: {channel: time_s, factor: 2}\n"), HasSubstr("'factor'"));
  EXPECT_THAT(refusal("columns:\n  t: {channel: time_s, scale: 0}\n"), HasSubstr("scale"));
  EXPECT_THAT(refusal("columns:\n  t: {channel: time_s}\n  v: {channel: time_s}\n"),
              HasSubstr(":3: channel time_s twice"));
  EXPECT_THAT(refusal("columns:\n  q: {channel: time_s}\n"), HasSubstr("no column 'q'"));
  EXPECT_THAT(refusal("columns:\n  t: {channel: time_s}\n"),
              HasSubstr("1 rows with ascending time"));
  EXPECT_THAT(refusal("- 1\n"), HasSubstr("a mapping is not"));
}

TEST_F(RecordingFile, EndsInAnErrorOrARecordingWhateverTheBytes) {
  std::string good = "time_s,vx_mps,yaw_rate_radps\n";
  for (int i = 0; i < 30; ++i)
    good += std::to_string(0.1 * i) + "," + std::to_string(20 + i) + "," + std::to_string(i) + "\n";
  const std::string map =
      "columns:\n  time_s: {channel: time_s}\n  vx_mps: {channel: vx_mps, held: true}\n";
  std::mt19937 random(7);
  int read = 0;
  for (int k = 0; k < 400; ++k) {
    std::string log = good, yaml = map;
    for (unsigned n = random() % 4 + 1; n > 0; --n) {
      std::string& text = k % 2 == 0 ? log : yaml;
      const std::size_t at = random() % text.size();
      if (random() % 3 == 0)
        text.erase(at, random() % 40);
      else
        text[at] = static_cast<char>(random() % 256);
      if (text.empty()) text = "x";
    }
    try {
      const Mapping mapping = k % 2 == 0 ? Mapping{} : read_mapping(write("fuzz.yaml", yaml));
      const Recording r = make_recording(parse_log_table(log, "log"), "log", mapping);
      for (std::size_t i = 1; i < r.table.rows(); ++i)
        ASSERT_GT((*r.table.find("time_s"))[i], (*r.table.find("time_s"))[i - 1]);
      ++read;
    } catch (const base::Error&) {  // said why
    }
  }
  EXPECT_GT(read, 10);
}

TEST(Recording, ReadsTheLogOfARealRaceCar) {
  const std::string log = places::data() + "/recordings/putnam_run4_2.csv";
  if (!std::filesystem::exists(log)) GTEST_SKIP() << "no " << log;
  const Recording r =
      read_recording(log, read_mapping(places::source() + "/vehicles/av21/putnam_mapping.yaml"));
  EXPECT_NEAR(r.step_s, 0.04, 0.001);
  EXPECT_NEAR(r.table.columns[0].back() - r.table.columns[0].front(), 476, 2);
  double top = 0;
  for (const double v : *r.table.find("vx_mps"))
    if (v > top) top = v;
  EXPECT_NEAR(top, 32.39, 0.01);
  const std::vector<double>& yaw = *r.table.find("yaw_rad");
  for (std::size_t i = 1; i < yaw.size(); ++i) ASSERT_LT(std::abs(yaw[i] - yaw[i - 1]), 1.0);
}

}  // namespace recording_test
