#include "explain/mapping.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "recording/log_table.h"
#include "support/places.h"
#include "support/temporary_folder.h"
#include "vehicle/error.h"

namespace explain {
namespace mapping_test {

/// A car that goes round a circle of 100 m to the left with changing speed, written in the manner
/// of another logger: km/h, degrees, heading from +y clockwise, right turns positive.
recording::Table foreign() {
  recording::Table t;
  for (const char* name : {"Time [ms]", "posx(m)", "posy(m)", "heading(deg)", "speed(km/h)",
                           "yawrate(deg/s)", "tyre noise"})
    t.add(name, {});
  double angle = 0;
  for (int i = 0; i < 3000; ++i) {
    const double s = 0.02 * i, v = 20 + 5 * std::sin(s), rate = v / 100;
    t.columns[0].push_back(1000 * s);
    t.columns[1].push_back(100 * std::cos(angle));
    t.columns[2].push_back(100 * std::sin(angle));
    const double yaw = angle + M_PI / 2;
    t.columns[3].push_back(90 - yaw * 180 / M_PI);
    t.columns[4].push_back(v * 3.6);
    t.columns[5].push_back(-rate * 180 / M_PI);
    t.columns[6].push_back(1);
    angle += rate * 0.02;
  }
  return t;
}

const ColumnMapping& of(const Mapping& m, const std::string& channel) {
  for (const ColumnMapping& c : m.columns)
    if (c.channel == channel) return c;
  throw std::runtime_error("no " + channel);
}

TEST(Mapping, FindsUnitsSignsAndTheZeroOfHeadings) {
  const Mapping m = propose_mapping(foreign(), "log");
  EXPECT_DOUBLE_EQ(of(m, "time_s").scale, 1e-3);
  EXPECT_NEAR(of(m, "vx_mps").scale, 1 / 3.6, 1e-12);
  EXPECT_NEAR(of(m, "yaw_rate_radps").scale, -M_PI / 180, 1e-12);
  EXPECT_NEAR(of(m, "yaw_rad").scale, -M_PI / 180, 1e-12);
  EXPECT_NEAR(of(m, "yaw_rad").offset, M_PI / 2, 1e-9);
  EXPECT_EQ(m.columns.size(), 6u);
}

TEST(Mapping, CountsRepeatsAsMissing) {
  recording::Table t = foreign();
  for (std::size_t i = 1; i < t.rows(); ++i)
    if (i % 4 != 0) t.columns[5][i] = t.columns[5][i - 1];
  EXPECT_TRUE(of(propose_mapping(t, "log"), "yaw_rate_radps").held);
  EXPECT_FALSE(of(propose_mapping(foreign(), "log"), "yaw_rate_radps").held);
}

TEST(Mapping, IsReadBackWithAnyNames) {
  recording::Table log = foreign();
  log.names[3] = "heading(°)";
  log.names[5] = "yawrate \"raw\\\t(deg/s)";
  log.names[4] = "speed(km/h) ü" + std::string(3000, 'x');  // YAML's short keys end at 1024
  const Mapping m = propose_mapping(log, "log");
  const support::TemporaryFolder folder;
  const recording::Mapping again =
      recording::read_mapping(folder.file("mapping.yaml", format_mapping(m)));
  ASSERT_EQ(again.columns.size(), m.columns.size());
  for (std::size_t k = 0; k < m.columns.size(); ++k)
    EXPECT_EQ(again.columns[k].column, m.columns[k].column);
  // As a logger's own Latin-1 went into mappings once.
  const recording::Mapping old = recording::read_mapping(
      folder.file("old.yaml", "version: 1\ncolumns:\n  \"v [\xb0]\": {channel: vx_mps}\n"));
  EXPECT_EQ(old.columns.at(0).column, "v [°]");
}

TEST(Mapping, ProposesForAClockThatRunsBackwardsToo) {
  recording::Table log = foreign();
  for (std::size_t i = 1500; i < log.rows(); ++i)
    log.columns[0][i] -= 29990.0;  // the mean step is 3 us
  EXPECT_EQ(propose_mapping(log, "log").columns.size(), 6u);
  log.columns[0].back() = log.columns[0].front();
  EXPECT_EQ(propose_mapping(log, "log").columns.size(), 6u);
  log.columns[0].back() = log.columns[0].front() - 1.0;
  EXPECT_EQ(propose_mapping(log, "log").columns.size(), 6u);
}

TEST(Mapping, ReadsBackWhatItWrites) {
  Mapping m = propose_mapping(foreign(), "log");
  m.columns[4].delay_s = 0.07;
  m.columns[4].low_pass_s = 0.3;
  m.imu_yaw_rad = 0.01;
  const support::TemporaryFolder folder;
  const recording::Mapping back =
      recording::read_mapping(folder.file("mapping.yaml", format_mapping(m)));
  ASSERT_EQ(back.columns.size(), m.columns.size());
  for (std::size_t k = 0; k < m.columns.size(); ++k) {
    EXPECT_EQ(back.columns[k].column, m.columns[k].column);
    EXPECT_EQ(back.columns[k].channel, m.columns[k].channel);
    EXPECT_NEAR(back.columns[k].scale, m.columns[k].scale, 1e-12);
    EXPECT_EQ(back.columns[k].delay_s, m.columns[k].delay_s);
    EXPECT_EQ(back.columns[k].low_pass_s, m.columns[k].low_pass_s);
  }
  EXPECT_EQ(back.imu_yaw_rad, 0.01);
}

TEST(Mapping, KnowsChannelsOfTopicsByTheirLastParts) {
  const std::vector<std::pair<const char*, const char*>> expected{
      {"log time [s]", "time_s"},
      {"/odom.pose.pose.position.x [m]", "x_m"},
      {"/odom.pose.pose.position.y [m]", "y_m"},
      {"pose.position.z", "z_m"},
      {"twist.linear.y", "vy_mps"},
      {"/odom.pose.pose.orientation.x", ""},
      {"/odom.pose.pose.orientation.yaw [rad]", "yaw_rad"},
      {"/odom.pose.covariance.0", ""},
      {"/odom.twist.twist.linear.x [m/s]", "vx_mps"},
      {"/accel.accel.linear.x [m/s2]", ""},
      {"/imu/data.angular_velocity.z [rad/s]", "yaw_rate_radps"},
      {"/imu/data.linear_acceleration.y [m/s2]", "ay_mps2"},
      {"/imu/data.header.stamp [s]", ""},
      {"/motion.roll_rate_radps", "roll_rate_radps"},
      {"/car.rpm", "engine_radps"}};
  recording::Table log;
  for (std::size_t c = 0; c < expected.size(); ++c) {
    std::vector<double> values;
    for (int i = 0; i < 100; ++i) values.push_back(0.01 * i * (1 + static_cast<double>(c)));
    log.add(expected[c].first, values);
  }
  const Mapping m = propose_mapping(log, "log");
  for (const auto& [column, channel] : expected) {
    std::string found;
    for (const ColumnMapping& map : m.columns)
      if (map.column == column) found = map.channel;
    EXPECT_EQ(found, channel) << column;
  }
}

/// The column that gives a channel; empty: none does.
std::string column_of(const Mapping& m, const std::string& channel) {
  for (const ColumnMapping& c : m.columns)
    if (c.channel == channel) return c.column;
  return "";
}

TEST(Mapping, KnowsWhatIsMeasuredAtWheelsInSeveralLanguages) {
  const std::vector<std::pair<const char*, const char*>> expected{
      {"Brake Temp FL [C]", "brake_disc_fl_k"},
      {"Temp Frein AVD [°C]", "brake_disc_fr_k"},
      {"Bremsscheibentemperatur_HL (K)", "brake_disc_rl_k"},
      {"Temperatura freno TD [°F]", "brake_disc_rr_k"},
      {"LFshockDefl [m]", "suspension_fl_m"},
      {"Federweg VR (mm)", "suspension_fr_m"},
      {"Corsa ammortizzatore PS [mm]", "suspension_rl_m"},
      {"Recorrido suspension trasera derecha [mm]", "suspension_rr_m"},
      {"Brake Temp Front [C]", ""},  // of which wheel?
      {"LFshockVel [m/s]", ""},
      {"LFcoldPressure [kPa]", ""},
      {"Tyre Temp FL Centre [C]", ""},
      {"Bremsdruck VA [bar]", "brake_fl_pa"},
      {"Pression frein AR [bar]", "brake_rl_pa"},
      {"Brake Bias Setting [%]", ""}};
  recording::Table log = foreign();
  for (const auto& [name, channel] : expected) {
    std::vector<double> values(log.rows());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::sin(0.01 * i) + 20.0;
    log.add(name, values);
  }
  const Mapping m = propose_mapping(log, "log");
  for (const auto& [name, channel] : expected) {
    std::string found;
    for (const ColumnMapping& map : m.columns)
      if (map.column == name && found.empty()) found = map.channel;
    EXPECT_EQ(found, channel) << name;
  }
  EXPECT_NEAR(of(m, "brake_disc_fl_k").offset, 273.15, 1e-9);
  EXPECT_NEAR(of(m, "brake_disc_fr_k").offset, 273.15, 1e-9);
  EXPECT_EQ(of(m, "brake_disc_rl_k").offset, 0.0);
  // 212 F is 373.15 K.
  EXPECT_NEAR(212.0 * of(m, "brake_disc_rr_k").scale + of(m, "brake_disc_rr_k").offset, 373.15,
              1e-9);
  EXPECT_NEAR(of(m, "suspension_fr_m").scale, 1e-3, 1e-12);
  // The sensor of an axle gives both of its wheels, and is read back so.
  EXPECT_EQ(column_of(m, "brake_fr_pa"), "Bremsdruck VA [bar]");
  const support::TemporaryFolder folder;
  const recording::Mapping again =
      recording::read_mapping(folder.file("mapping.yaml", format_mapping(m)));
  ASSERT_EQ(again.columns.size(), m.columns.size());
  for (std::size_t k = 0; k < m.columns.size(); ++k) {
    EXPECT_EQ(again.columns[k].channel, m.columns[k].channel);
    EXPECT_EQ(again.columns[k].column, m.columns[k].column);
    EXPECT_NEAR(again.columns[k].scale, m.columns[k].scale, 1e-9 * std::abs(m.columns[k].scale));
  }
}

TEST(Mapping, OnePressureAloneStandsForAllWheels) {
  recording::Table log = foreign();
  log.add("Brake_Pressure_Front [bar]", std::vector<double>(log.rows(), 3.0));
  const Mapping m = propose_mapping(log, "log");
  EXPECT_EQ(column_of(m, "brake_pa"), "Brake_Pressure_Front [bar]");
  EXPECT_EQ(column_of(m, "brake_fl_pa"), "");
  log.add("Brake_Pressure_Rear [bar]", std::vector<double>(log.rows(), 2.0));
  log.add("Brake Pressure [bar]", std::vector<double>(log.rows(), 3.0));
  const Mapping both = propose_mapping(log, "log");
  EXPECT_EQ(column_of(both, "brake_fr_pa"), "Brake_Pressure_Front [bar]");
  EXPECT_EQ(column_of(both, "brake_rr_pa"), "Brake_Pressure_Rear [bar]");
  EXPECT_EQ(column_of(both, "brake_pa"), "");
}

TEST(Mapping, TravelsBumpInFrontWhereTheCarBrakes) {
  recording::Table log = foreign();
  std::vector<double> front, rear, still;
  for (std::size_t i = 0; i < log.rows(); ++i) {
    const double s = 0.02 * static_cast<double>(i), v = 20 + 5 * std::sin(s), a = 5 * std::cos(s);
    front.push_back(0.01 * v * v - a);  // mm, with what downforce presses
    rear.push_back(-0.01 * v * v - a);  // droop positive
    still.push_back(std::sin(17.0 * s));
  }
  log.add("Damper FL [mm]", front);
  log.add("Damper RR [mm]", rear);
  log.add("Damper RL [mm]", still);
  const Mapping m = propose_mapping(log, "log");
  EXPECT_NEAR(of(m, "suspension_fl_m").scale, 1e-3, 1e-12);
  EXPECT_NEAR(of(m, "suspension_rr_m").scale, -1e-3, 1e-12);
  EXPECT_THAT(m.notes, ::testing::Contains(
                           ::testing::AllOf(::testing::HasSubstr("suspension_rl_m"),
                                            ::testing::HasSubstr("the sign is not confirmed"))));
}

/// A log of 60 rows whose columns are the numbers of rows times these, moved by one.
recording::Table counted(const std::vector<std::pair<std::string, double>>& columns) {
  recording::Table log;
  for (const auto& [name, factor] : columns) {
    log.names.push_back(name);
    auto& values = log.columns.emplace_back();
    for (int i = 0; i < 60; ++i) values.push_back(factor * (i + 1));
  }
  return log;
}

TEST(Mapping, EndingsOfNamesAreUnitsAndOrigins) {
  const Mapping m = propose_mapping(counted({{"INS_time_sec", 0.01},
                                             {"speedo_obd", 0.9},
                                             {"yaw_rate_degps", 1},
                                             {"ax_cg_mps2", 0.1},
                                             {"latacc-calc [g]", 0.01},
                                             {"aps", 1},
                                             {"pbrake_f", 1},
                                             {"pbrake_r", 1},
                                             {"nmot", 100}}),
                                    "log");
  EXPECT_THAT(m.missing, ::testing::IsEmpty());
  EXPECT_EQ(of(m, "time_s").column, "INS_time_sec");
  EXPECT_EQ(of(m, "vx_mps").column, "speedo_obd");
  EXPECT_NEAR(of(m, "yaw_rate_radps").scale, M_PI / 180, 1e-12);
  EXPECT_EQ(of(m, "ax_mps2").scale, 1.0);
  EXPECT_EQ(of(m, "ay_mps2").scale, 9.80665);
  EXPECT_EQ(of(m, "throttle").scale, 0.01);
  const Mapping plain = propose_mapping(counted({{"time_s", 0.1}, {"throttle", 1}}), "log");
  EXPECT_EQ(of(plain, "throttle").scale, 0.01) << "others have this name of ours, too";
  EXPECT_EQ(of(m, "brake_fr_pa").column, "pbrake_f");
  EXPECT_EQ(of(m, "brake_rl_pa").column, "pbrake_r");
  EXPECT_EQ(of(m, "engine_radps").column, "nmot");
}

TEST(Mapping, AMomentSince1970AndASpeedBeyondAllCarsSayTheirUnits) {
  recording::Table log = counted({{"rosbagTimestamp", 1e7}, {"speed", 5}});
  for (double& t : log.columns[0]) t += 1.7e18;
  const Mapping m = propose_mapping(log, "log");
  EXPECT_EQ(of(m, "time_s").scale, 1e-9);
  EXPECT_NEAR(of(m, "vx_mps").scale, 1 / 3.6, 1e-12);
}

TEST(Mapping, OfTwoAccelerationsTheLiveOneIsTaken) {
  const Mapping m = propose_mapping(
      counted({{"time", 0.01}, {"speed", 1}, {"latacc", 0}, {"latacc-calc", 0.1}}), "log");
  EXPECT_EQ(of(m, "ay_mps2").column, "latacc-calc");
  EXPECT_THAT(m.notes,
              ::testing::Contains(::testing::HasSubstr("'latacc' is not used: it holds 0 in")));
}

TEST(Mapping, AColumnOrAPathThatStandsStillIsComparedWithNothing) {
  for (const std::vector<std::size_t>& still : {std::vector<std::size_t>{1, 2}, {4}, {1, 2, 4}}) {
    recording::Table t = foreign();
    for (const std::size_t k : still)
      for (double& value : t.columns[k]) value = 0;
    for (const std::string& note : propose_mapping(t, "log").notes)
      EXPECT_THAT(note, ::testing::Not(::testing::ContainsRegex("(^|[ -])(inf|nan)([ ,:]|$)")));
  }
}

TEST(Mapping, ThePathSaysTheUnitThatNoNameSays) {
  for (const double unit : {1.0, 3.6, 1 / 0.44704}) {
    recording::Table log = foreign();
    log.names[4] = "speed";
    for (double& v : log.columns[4]) v *= unit / 3.6;
    EXPECT_NEAR(of(propose_mapping(log, "log"), "vx_mps").scale, 1 / unit, 1e-12);
  }
  recording::Table furlongs = foreign();
  furlongs.names[4] = "speed [fur/h]";
  for (double& v : furlongs.columns[4]) v *= 1.38;
  EXPECT_THROW(of(propose_mapping(furlongs, "log"), "vx_mps"), std::runtime_error);
  recording::Table log = foreign();  // of half the size: up to 2.5 m/s^2, and no g
  for (const std::size_t k : {1u, 2u, 4u})
    for (double& value : log.columns[k]) value *= 0.5;
  std::vector<double> ahead;
  for (std::size_t i = 0; i < log.rows(); ++i)
    ahead.push_back(2.5 * std::cos(0.02 * static_cast<double>(i)));
  log.add("LongAccel", ahead);
  EXPECT_EQ(of(propose_mapping(log, "log"), "ax_mps2").scale, 1.0);
}

TEST(Mapping, AccelerationsThatThePathExchangesAreExchanged) {
  recording::Table log = foreign();
  std::vector<double> ahead, aside;
  for (std::size_t i = 0; i < log.rows(); ++i) {
    const double s = 0.02 * static_cast<double>(i), v = 20 + 5 * std::sin(s);
    ahead.push_back(5 * std::cos(s) / 9.80665);
    aside.push_back(-v * v / 100 / 9.80665);
  }
  log.add("Accel X [g]", aside);
  log.add("Accel Y [g]", ahead);
  const Mapping m = propose_mapping(log, "log");
  EXPECT_EQ(of(m, "ax_mps2").column, "Accel Y [g]");
  EXPECT_EQ(of(m, "ay_mps2").column, "Accel X [g]");
  EXPECT_LT(of(m, "ay_mps2").scale, 0.0);
}

TEST(Mapping, ASpeedThatMayBeKilometresOrMetresIsLeftOut) {
  const Mapping m = propose_mapping(counted({{"time", 0.1}, {"speed", 1.8}}), "log");
  EXPECT_THAT(m.missing, ::testing::ElementsAre(::testing::HasSubstr("the unit of 'speed'")));
  EXPECT_THROW(of(m, "vx_mps"), std::runtime_error);
  recording::Table log = counted({{"time", 0.1}, {"speed", 0}, {"ax [m/s^2]", 0}});
  for (std::size_t i = 0; i < log.rows(); ++i) {  // the acceleration says it
    log.columns[1][i] = 3.6 * (25 + 4 * std::sin(0.1 * static_cast<double>(i)));
    log.columns[2][i] = 4 * std::cos(0.1 * static_cast<double>(i));
  }
  EXPECT_NEAR(of(propose_mapping(log, "log"), "vx_mps").scale, 1 / 3.6, 1e-12);
}

TEST(Mapping, WhatIsNoPlaceNoHeadingAndNoPressureIsLeftOut) {
  const Mapping m = propose_mapping(counted({{"time", 0.1},
                                             {"Latitude", 0.001},
                                             {"Longitude", 0.001},
                                             {"X", 0.01},
                                             {"Y", 0.01},
                                             {"Heading", 1},
                                             {"Brake (calculated)", 1 / 60.0},
                                             {"Brake Temperature Front Left (% est.)", 1},
                                             {"Speed (OBD)(km/h)", 1}}),
                                    "log");
  for (const char* channel : {"x_m", "y_m", "yaw_rad", "brake_pa", "brake_disc_fl_k"})
    EXPECT_EQ(column_of(m, channel), "") << channel;
  EXPECT_EQ(column_of(m, "latitude_rad"), "Latitude");
  const Mapping columbus = propose_mapping(counted({{"TIME", 1},
                                                    {"LATITUDE N/S [deg]", 1e-3},
                                                    {"LONGITUDE E/W [deg]", 1e-3},
                                                    {"HEADING", 1}}),
                                           "log");
  EXPECT_EQ(column_of(columbus, "yaw_rad"), "") << "the receiver's course";
  EXPECT_NEAR(of(m, "vx_mps").scale, 1 / 3.6, 1e-12);
}

TEST(Mapping, ClocksAreOfUnitsThatAreKnown) {
  const auto scale = [](const char* name, double step) {
    return of(propose_mapping(counted({{name, step}, {"v [km/h]", 1}, {"vx", 0.5}}), "log"),
              "time_s")
        .scale;
  };
  EXPECT_EQ(scale("Time [min]", 0.01), 60.0);
  EXPECT_EQ(scale("Timestamp", 50), 1e-3);
  EXPECT_EQ(scale("Timestamp", 1), 1.0);
  EXPECT_EQ(scale("Zeitstempel", 0.1), 1.0);
  EXPECT_THAT(propose_mapping(counted({{"Time [fortnights]", 1}, {"vx", 0.5}}), "log").missing,
              ::testing::ElementsAre(::testing::HasSubstr("no clock")));
  recording::Table words = counted({{"GPS Time", 1}, {"Device Time", 0.1}, {"vx", 0.5}});
  for (double& t : words.columns[0]) t = NAN;
  EXPECT_EQ(of(propose_mapping(words, "log"), "time_s").column, "Device Time");
}

TEST(Mapping, WhatIsMissingIsSaidOfADraft) {
  using ::testing::ElementsAre, ::testing::HasSubstr;
  EXPECT_THAT(propose_mapping(counted({{"a", 1}, {"speed", 1}}), "log").missing,
              ElementsAre(HasSubstr("no clock")));
  EXPECT_THAT(propose_mapping(counted({{"time", 1}, {"rpm", 1}}), "log").missing,
              ElementsAre(HasSubstr("no place and no speed")));
  recording::Table small = counted({{"time", 1}, {"speed", 1}});
  for (auto& column : small.columns) column.resize(6);
  const Mapping m = propose_mapping(small, "log");
  EXPECT_THAT(m.missing, ElementsAre(HasSubstr("6 rows: a log of at least 50")));
  EXPECT_EQ(of(m, "vx_mps").column, "speed");
}

TEST(Mapping, ProposesForRealLogsWhatTheyHold) {
  const std::string folder = places::data() + "/recordings/";
  if (!std::filesystem::exists(folder + "road_america_run1.vbo"))
    GTEST_SKIP() << "no real logs beside the checkout";
  const auto proposed = [&](const char* file) {
    return propose_mapping(recording::read_log_table(folder + file), file);
  };
  const Mapping vbo = proposed("road_america_run1.vbo");
  EXPECT_NEAR(of(vbo, "vx_mps").scale, 1 / 3.6, 1e-12);
  EXPECT_EQ(of(vbo, "latitude_rad").column, "lat [deg]");
  EXPECT_EQ(of(vbo, "throttle_command").column, "Throttle_Pedal [%]");
  EXPECT_THROW(of(vbo, "yaw_rad"), std::runtime_error);    // the receiver's course
  EXPECT_THROW(of(vbo, "steer_rad"), std::runtime_error);  // the steering wheel
  const Mapping chrono = proposed("racechrono_tianma_lap9.csv");
  EXPECT_EQ(of(chrono, "vx_mps").column, "gps speed [m/s]");
  EXPECT_NEAR(of(chrono, "ay_mps2").scale, 9.80665, 1e-9);
  EXPECT_NEAR(chrono.origin_latitude_deg, 31.08, 1e-9);
  const Mapping ibt = proposed("iracing_valid.ibt");
  EXPECT_EQ(of(ibt, "wheel_rl_mps").column, "LRspeed [m/s]");
  EXPECT_EQ(of(ibt, "throttle").scale, 1.0);
  EXPECT_THROW(of(ibt, "brake_pa"), std::runtime_error);  // a share, no pressure
  const Mapping ld = proposed("Sample1.ld");
  EXPECT_NEAR(of(ld, "wheel_fr_mps").scale, 1 / 3.6, 1e-12);
  EXPECT_NEAR(of(ld, "brake_disc_rl_k").offset, 273.15, 1e-9);
  EXPECT_EQ(of(ld, "suspension_rr_m").column, "Susp Pos RR [mm]");
  EXPECT_EQ(of(ld, "brake_fl_pa").column, of(ld, "brake_fr_pa").column);
  EXPECT_EQ(of(ld, "brake_rr_pa").column, "Brake Pres Rear [kPa]");
  EXPECT_EQ(of(vbo, "brake_pa").column, "Brake_Pressure_Front [bar]");
}

}  // namespace mapping_test
}  // namespace explain
