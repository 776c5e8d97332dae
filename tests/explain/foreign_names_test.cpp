// What drafts know of the names and the axes of other loggers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "explain/mapping.h"

namespace explain {
namespace foreign_names_test {

using testing::HasSubstr;

/// A car on a road that winds, at a changing speed.
struct Moment {
  double t_s, x_m, y_m, v_mps, ax_mps2, ay_mps2, yaw_rate_radps;
};
std::vector<Moment> drive(double rate_hz, double duration_s) {
  std::vector<Moment> out;
  double x = 0, y = 0, yaw = 0.3;
  constexpr int kFine = 20;
  const double dt = 1.0 / rate_hz / kFine;
  for (int i = 0; i < static_cast<int>(rate_hz * duration_s) * kFine; ++i) {
    const double t = i * dt, v = 20 + 8 * std::sin(t / 4), rate = v * 0.02 * std::sin(t / 3);
    if (i % kFine == 0) out.push_back({t, x, y, v, 2 * std::cos(t / 4), v * rate, rate});
    x += v * std::cos(yaw) * dt;
    y += v * std::sin(yaw) * dt;
    yaw += rate * dt;
  }
  return out;
}

using Column = std::pair<std::string, std::function<double(const Moment&)>>;
recording::Table table_of(const std::vector<Moment>& moments, const std::vector<Column>& columns) {
  recording::Table out;
  for (const auto& [name, value] : columns) {
    std::vector<double> values(moments.size());
    std::transform(moments.begin(), moments.end(), values.begin(), value);
    out.add(name, values);
  }
  return out;
}

const ColumnMapping* of(const Mapping& m, const std::string& channel) {
  for (const ColumnMapping& c : m.columns)
    if (c.channel == channel) return &c;
  return nullptr;
}
std::string column_of(const Mapping& m, const std::string& channel) {
  const ColumnMapping* const c = of(m, channel);
  return c == nullptr ? "" : c->column;
}
double scale_of(const Mapping& m, const std::string& channel) {
  const ColumnMapping* const c = of(m, channel);
  return c == nullptr ? std::nan("") : c->scale;
}
double t(const Moment& m) { return m.t_s; }
double v(const Moment& m) { return m.v_mps; }
double one(const Moment&) { return 1.0; }

constexpr double kDegrees = 180 / M_PI;

TEST(ForeignNames, WordsThatAreUnitsSayThem) {
  // As gently as in town: the size of the numbers would say rad/s and m/s2.
  const Mapping m = propose_mapping(
      table_of(drive(20, 30),
               {{"Time", t},
                {"Speed (m/s)", v},
                {"RPM", [](const Moment& at) { return 800 + 40 * at.v_mps; }},
                {"GForceX", [](const Moment& at) { return 0.05 * at.ax_mps2 / 9.80665; }},
                {"GForceY", [](const Moment& at) { return 0.05 * at.ay_mps2 / 9.80665; }},
                {"GyroZ", [](const Moment& at) { return 0.05 * at.yaw_rate_radps * kDegrees; }}}),
      "log");
  EXPECT_NEAR(scale_of(m, "engine_radps"), M_PI / 30, 1e-9);
  EXPECT_NEAR(scale_of(m, "ax_mps2"), 9.80665, 1e-9);
  EXPECT_NEAR(scale_of(m, "ay_mps2"), 9.80665, 1e-9);
  EXPECT_NEAR(scale_of(m, "yaw_rate_radps"), M_PI / 180, 1e-9) << "by ay_mps2 over vx_mps";
}

TEST(ForeignNames, UnitsOfOtherLoggersAreKnown) {
  const Mapping m = propose_mapping(table_of(drive(20, 10), {{"Time (msec)", t},
                                                             {"GPS Speed (Meters/second)", v},
                                                             {"Yaw [Deg/Sec]", v},
                                                             {"Accel. Pedal Position (%)", v},
                                                             {"Throttle Opening Angle (%)", v}}),
                                    "log");
  EXPECT_NEAR(scale_of(m, "time_s"), 1e-3, 1e-12);
  EXPECT_NEAR(scale_of(m, "vx_mps"), 1.0, 1e-12);
  EXPECT_TRUE(std::none_of(m.notes.begin(), m.notes.end(), [](const std::string& note) {
    return note.find("vx_mps") != std::string::npos && note.find("guessed") != std::string::npos;
  }));
  EXPECT_EQ(column_of(m, "yaw_rate_radps"), "Yaw [Deg/Sec]");
  EXPECT_EQ(column_of(m, "throttle_command"), "Accel. Pedal Position (%)");
  EXPECT_EQ(column_of(m, "throttle"), "Throttle Opening Angle (%)");
}

TEST(ForeignNames, LaptimersOfCarMakersAreKnown) {
  const Mapping m = propose_mapping(
      table_of(drive(20, 30),
               {{"Seconds", t},
                {"Latitude / Y Position (Degrees)",
                 [](const Moment& at) { return 48 + at.y_m / 111e3; }},
                {"Longitude / X Position (Degrees)",
                 [](const Moment& at) { return 11 + at.x_m / 74e3; }},
                {"Speed (MPH)", [](const Moment& at) { return at.v_mps / 0.44704; }},
                {"Lateral Gs", [](const Moment& at) { return at.ay_mps2 / 9.80665; }},
                {"Acceleration Gs", [](const Moment& at) { return at.ax_mps2 / 9.80665; }}}),
      "log");
  EXPECT_NEAR(scale_of(m, "latitude_rad"), M_PI / 180, 1e-9);
  EXPECT_EQ(column_of(m, "longitude_rad"), "Longitude / X Position (Degrees)");
  EXPECT_NEAR(scale_of(m, "vx_mps"), 0.44704, 1e-9);
  EXPECT_NEAR(std::abs(scale_of(m, "ay_mps2")), 9.80665, 1e-9);
  EXPECT_NEAR(scale_of(m, "ax_mps2"), 9.80665, 1e-9);
}

TEST(ForeignNames, ClocksOfOtherLoggersAreKnown) {
  for (const auto& [name, scale] :
       std::vector<std::pair<std::string, double>>{{"timestamps", 1.0},
                                                   {"SECONDS", 1.0},
                                                   {"Offset [s]", 1.0},
                                                   {"Interval [ms]", 1e-3},
                                                   {"cts", 1e-3},
                                                   {"TimestampMS", 1e-3},
                                                   {"Timestamp (from 1970)", 1.0}})
    EXPECT_NEAR(scale_of(propose_mapping(table_of(drive(20, 10), {{name, t}, {"KPH", v}}), "log"),
                         "time_s"),
                scale, 1e-12)
        << name;
  for (const char* name : {"Offset", "Interval", "Offset [V]"})
    EXPECT_EQ(
        of(propose_mapping(table_of(drive(20, 10), {{name, t}, {"KPH", v}}), "log"), "time_s"),
        nullptr)
        << name;
}

TEST(ForeignNames, NamesOfFieldsGroupsAndBrackets) {
  const Mapping m = propose_mapping(table_of(drive(20, 10), {{"%time", t},
                                                             {"field.twist.twist.linear.x", v},
                                                             {"field.angular_velocity.z", v},
                                                             {"field.linear_acceleration.x", one},
                                                             {"engine/rpm", v},
                                                             {"sensors/tps1", v},
                                                             {"dbw/rpm", v}}),
                                    "log");
  EXPECT_EQ(column_of(m, "vx_mps"), "field.twist.twist.linear.x");
  EXPECT_EQ(column_of(m, "yaw_rate_radps"), "field.angular_velocity.z");
  EXPECT_NEAR(scale_of(m, "yaw_rate_radps"), 1.0, 1e-12) << "rad/s, though up to 28";
  EXPECT_EQ(column_of(m, "engine_radps"), "engine/rpm");
  EXPECT_EQ(column_of(m, "throttle"), "sensors/tps1");
  const Mapping gps = propose_mapping(
      table_of(drive(10, 20),
               {{"cts", [](const Moment& at) { return 1e3 * at.t_s; }},
                {"GPS (Lat.) [deg]", [](const Moment& at) { return 48 + at.y_m / 111195; }},
                {"GPS (Long.) [deg]", [](const Moment& at) { return 10 + at.x_m / 74405; }},
                {"GPS (2D speed) [m/s]", v}}),
      "log");
  EXPECT_TRUE(gps.missing.empty());
  EXPECT_EQ(column_of(gps, "latitude_rad"), "GPS (Lat.) [deg]");
  EXPECT_EQ(column_of(gps, "vx_mps"), "GPS (2D speed) [m/s]");
}

TEST(ForeignNames, MessagesVariablesAndElements) {
  const Mapping m = propose_mapping(table_of(drive(20, 10), {{"m_sessionTime", t},
                                                             {"velocity[0]", one},
                                                             {"Brakes::CarSpeed[km/h]", v},
                                                             {"m_engineRPM", v},
                                                             {"fuel", v}}),
                                    "log");
  EXPECT_EQ(column_of(m, "time_s"), "m_sessionTime");
  EXPECT_EQ(column_of(m, "vx_mps"), "Brakes::CarSpeed[km/h]") << "not the first of three axes";
  EXPECT_EQ(column_of(m, "engine_radps"), "m_engineRPM");
  EXPECT_EQ(of(m, "fuel_kg"), nullptr) << "litres, kg or a share";
}

TEST(ForeignNames, WholeNumbersOfReceiversAreDegreesAndMetres) {
  const Mapping m = propose_mapping(
      table_of(drive(10, 20),
               {{"timestamp", t},
                {"lat", [](const Moment& at) { return std::floor(1e7 * (48 + at.y_m / 111195)); }},
                {"lon", [](const Moment& at) { return std::floor(1e7 * (10 + at.x_m / 74405)); }},
                {"alt", [](const Moment&) { return 488000.0; }},
                {"vel_m_s", v}}),
      "log");
  EXPECT_TRUE(m.missing.empty());
  EXPECT_NEAR(scale_of(m, "latitude_rad"), 1e-7 * M_PI / 180, 1e-20);
  EXPECT_NEAR(scale_of(m, "z_m"), 1e-3, 1e-12);
  EXPECT_EQ(column_of(m, "vx_mps"), "vel_m_s");
}

TEST(ForeignNames, AColumnWithoutANumberGivesNothing) {
  const double none = std::nan("");
  const Mapping m =
      propose_mapping(table_of(drive(20, 10), {{"time", t},
                                               {"Latitude", [&](const Moment&) { return none; }},
                                               {"Longitude", [&](const Moment&) { return none; }},
                                               {"Speed (km/h)", v}}),
                      "log");
  EXPECT_TRUE(m.missing.empty());
  EXPECT_EQ(of(m, "latitude_rad"), nullptr);
}

TEST(ForeignNames, SharesAreOfOneOfAHundredOrOfABytesLargest) {
  for (const auto& [most, scale] :
       std::vector<std::pair<double, double>>{{1.0, 1.0}, {100.0, 0.01}, {255.0, 1.0 / 255}}) {
    const double full = most;
    const Mapping m = propose_mapping(
        table_of(drive(20, 10),
                 {{"time", t},
                  {"Speed (km/h)", v},
                  {"Throttle", [full](const Moment& at) { return at.t_s < 5 ? full : 0.0; }}}),
        "log");
    EXPECT_NEAR(scale_of(m, "throttle"), scale, 1e-12) << most;
  }
}

TEST(ForeignNames, WheelsWithoutAUnitGoAsFastAsTheCar) {
  const auto mapped = [](double factor) {
    return propose_mapping(
        table_of(drive(20, 10),
                 {{"time", t},
                  {"Speed (km/h)", [](const Moment& at) { return 3.6 * at.v_mps; }},
                  {"WheelSpeedFL", [factor](const Moment& at) { return factor * at.v_mps; }}}),
        "log");
  };
  EXPECT_NEAR(scale_of(mapped(0.95), "wheel_fl_mps"), 1.0, 1e-12);
  EXPECT_NEAR(scale_of(mapped(3.6), "wheel_fl_mps"), 1 / 3.6, 1e-12);
  EXPECT_NEAR(scale_of(mapped(1 / 0.33), "wheel_fl_radps"), 1.0, 1e-12);
  EXPECT_EQ(of(mapped(1 / 0.33), "wheel_fl_mps"), nullptr);
  EXPECT_EQ(of(mapped(1.5), "wheel_fl_mps"), nullptr);
}

TEST(ForeignNames, AxesOfATelephonesSensorsAreNoPlace) {
  const Mapping m = propose_mapping(
      table_of(drive(20, 10), {{"time", t}, {"seconds_elapsed", t}, {"z", v}, {"y", v}, {"x", v}}),
      "log");
  EXPECT_EQ(of(m, "x_m"), nullptr);
  EXPECT_FALSE(m.missing.empty());
}

TEST(ForeignNames, WhereYIsUpwardsThePathSaysSo) {
  const std::vector<Column> columns{
      {"time", t},
      {"VelocityX", [](const Moment&) { return 0.1; }},
      {"AngularVelocityY", [](const Moment& at) { return -at.yaw_rate_radps; }},
      {"PositionX", [](const Moment& at) { return at.x_m; }},
      {"PositionY", [](const Moment& at) { return 100 + std::sin(at.t_s / 5); }},
      {"PositionZ", [](const Moment& at) { return at.y_m; }},
      {"Speed", v}};
  const Mapping m = propose_mapping(table_of(drive(20, 60), columns), "log");
  EXPECT_EQ(column_of(m, "y_m"), "PositionZ");
  EXPECT_EQ(column_of(m, "z_m"), "PositionY");
  EXPECT_EQ(column_of(m, "vx_mps"), "Speed");
  EXPECT_EQ(of(m, "pitch_rate_radps"), nullptr) << "of axes that nothing tells apart";
  std::vector<Column> level = columns;
  std::swap(level[4].first, level[5].first);
  EXPECT_EQ(column_of(propose_mapping(table_of(drive(20, 60), level), "log"), "y_m"), "PositionY");
}

TEST(ForeignNames, LengthsWithoutAUnitAreSettledBySpeed) {
  const auto columns = [](const char* x, const char* y) {
    return std::vector<Column>{{"time", t},
                               {x, [](const Moment& at) { return 10 * at.x_m; }},
                               {y, [](const Moment& at) { return 10 * at.y_m; }},
                               {"Speed", [](const Moment& at) { return 3.6 * at.v_mps; }}};
  };
  const Mapping m = propose_mapping(table_of(drive(20, 60), columns("X", "Y")), "log");
  EXPECT_NEAR(scale_of(m, "x_m"), 0.1, 1e-12);
  EXPECT_NEAR(scale_of(m, "y_m"), 0.1, 1e-12);
  EXPECT_NEAR(scale_of(m, "vx_mps"), 1 / 3.6, 1e-9);
  const Mapping named = propose_mapping(table_of(drive(20, 60), columns("X (m)", "Y (m)")), "log");
  EXPECT_NEAR(scale_of(named, "x_m"), 1.0, 1e-12) << "the log says metres";
}

TEST(ForeignNames, ColumnsOfOneKindHaveOneUnit) {
  // A place near Greenwich, and a car that turns harder than it brakes.
  const Mapping on_globe = propose_mapping(
      table_of(drive(20, 20), {{"time", t},
                               {"Lat", [](const Moment& at) { return 52.0 + at.y_m / 111e3; }},
                               {"Lon", [](const Moment& at) { return 0.9 + at.x_m / 68e3; }}}),
      "log");
  EXPECT_NEAR(scale_of(on_globe, "longitude_rad"), 1 / kDegrees, 1e-12);
  const Mapping axes = propose_mapping(
      table_of(drive(20, 20), {{"time", t},
                               {"Speed (m/s)", v},
                               {"LongAccel", [](const Moment& at) { return at.ax_mps2; }},
                               {"LatAccel", [](const Moment& at) { return at.ay_mps2; }}}),
      "log");
  EXPECT_EQ(scale_of(axes, "ax_mps2"), 1.0);
  // What the path says of the speed ahead goes for the speed aside.
  const Mapping speeds = propose_mapping(
      table_of(drive(20, 60), {{"time", t},
                               {"x (m)", [](const Moment& at) { return at.x_m; }},
                               {"y (m)", [](const Moment& at) { return at.y_m; }},
                               {"speedX", [](const Moment& at) { return 3.6 * at.v_mps; }},
                               {"speedY", [](const Moment& at) { return at.yaw_rate_radps; }}}),
      "log");
  EXPECT_NEAR(scale_of(speeds, "vx_mps"), 1 / 3.6, 1e-9);
  EXPECT_NEAR(scale_of(speeds, "vy_mps"), 1 / 3.6, 1e-9);
}

TEST(ForeignNames, VelocitiesAlongTheAxesOfThePlaneAreNoneOfTheCar) {
  std::vector<Moment> round = drive(20, 60);  // a circle of 40 m
  for (Moment& m : round) {
    m.v_mps = 10 + std::sin(m.t_s / 3), m.yaw_rate_radps = 0.25;
    const double turned = (10 * m.t_s - 3 * std::cos(m.t_s / 3)) / 40;
    m.x_m = 40 * std::cos(turned), m.y_m = 40 * std::sin(turned);
    m.ax_mps2 = -m.v_mps * std::sin(turned), m.ay_mps2 = m.v_mps * std::cos(turned);
  }
  const auto draft = [&](const std::function<double(const Moment&)>& vx,
                         const std::function<double(const Moment&)>& vy) {
    return propose_mapping(table_of(round, {{"time", t},
                                            {"x", [](const Moment& m) { return m.x_m; }},
                                            {"y", [](const Moment& m) { return m.y_m; }},
                                            {"vx", vx},
                                            {"vy", vy}}),
                           "log");
  };
  const Mapping plane =
      draft([](const Moment& m) { return m.ax_mps2; }, [](const Moment& m) { return m.ay_mps2; });
  EXPECT_EQ(of(plane, "vx_mps"), nullptr);
  EXPECT_EQ(of(plane, "vy_mps"), nullptr);
  EXPECT_THAT(plane.notes, testing::Contains(HasSubstr("'vx' is not used: the path says")));
  EXPECT_EQ(column_of(draft(v, [](const Moment&) { return 0.2; }), "vx_mps"), "vx");
}

TEST(ForeignNames, AShareOfTheLockIsNoAngle) {
  for (const auto& [full_lock, used] :
       std::vector<std::pair<double, bool>>{{1.0, true}, {0.37, false}}) {
    const Mapping m = propose_mapping(
        table_of(drive(20, 60), {{"time", t},
                                 {"x (m)", [](const Moment& at) { return at.x_m; }},
                                 {"y (m)", [](const Moment& at) { return at.y_m; }},
                                 {"steer",
                                  [lock = full_lock](const Moment& at) {
                                    return -2.7 * at.yaw_rate_radps / at.v_mps / lock;
                                  }}}),
        "log");
    EXPECT_EQ(of(m, "steer_rad") != nullptr, used) << full_lock;
    if (!used)
      EXPECT_THAT(m.notes, testing::Contains(HasSubstr("map it to steer_rad with scale -0.4")));
  }
}

TEST(ForeignNames, AUnitThatIsNotKnownIsNotGuessed) {
  const auto brake = [](const Moment& at) { return 100 * at.v_mps; };
  const Mapping m = propose_mapping(
      table_of(drive(20, 20), {{"time", t}, {"KPH", v}, {"Brake pressure [psi_x10]", brake}}),
      "log");
  EXPECT_EQ(of(m, "brake_pa"), nullptr);
  EXPECT_THAT(m.notes, testing::Contains(HasSubstr("'psi_x10' is no unit of brake_pa")));
  for (const auto& [name, scale] : std::vector<std::pair<std::string, double>>{
           {"SpeedMPH", 0.44704}, {"speedKmh", 1 / 3.6}, {"speedmps", 1.0}})
    EXPECT_NEAR(scale_of(propose_mapping(table_of(drive(20, 20), {{"time", t}, {name, v}}), "log"),
                         "vx_mps"),
                scale, 1e-12)
        << name;
  const Mapping shares = propose_mapping(
      table_of(drive(20, 20), {{"time", t},
                               {"KPH", v},
                               {"Brake", [](const Moment& m) { return 3 * m.v_mps; }},
                               {"Throttle", [](const Moment& m) { return 30 * m.v_mps; }}}),
      "log");
  EXPECT_EQ(of(shares, "brake_pa"), nullptr) << "per cent or bar";
  EXPECT_EQ(of(shares, "throttle"), nullptr) << "of a converter of 10 bits";
  // Whole numbers of a bus: m/s or km/h, nothing says.
  const Mapping bus = propose_mapping(
      table_of(drive(20, 20),
               {{"time", t}, {"speed", [](const Moment& at) { return std::round(at.v_mps); }}}),
      "log");
  EXPECT_THAT(bus.missing, testing::ElementsAre(HasSubstr("the unit of 'speed' is not known")));
  const Mapping section =
      propose_mapping(table_of(drive(20, 20), {{"Section Time [s]", t}, {"KPH", v}}), "log");
  EXPECT_EQ(column_of(section, "time_s"), "Section Time [s]");
  EXPECT_THAT(section.missing, testing::IsEmpty());
}

TEST(ForeignNames, APlaceThatHoldsIsComparedWhereItIsNew) {
  std::vector<Moment> held = drive(20, 90);
  for (std::size_t i = 0; i < held.size(); ++i) {
    held[i].x_m = held[i - i % 20].x_m;
    held[i].y_m = held[i - i % 20].y_m;
  }
  const Mapping m = propose_mapping(
      table_of(held, {{"Time", t},
                      {"Latitude", [](const Moment& at) { return 48 + at.y_m / 111195; }},
                      {"Longitude", [](const Moment& at) { return 10 + at.x_m / 74405; }},
                      {"Speed (km/h)", [](const Moment& at) { return 3.6 * at.v_mps; }},
                      {"Accel X", [](const Moment& at) { return -at.ay_mps2 / 9.80665; }},
                      {"Accel Y", [](const Moment& at) { return at.ax_mps2 / 9.80665; }}}),
      "log");
  EXPECT_EQ(column_of(m, "ax_mps2"), "Accel Y");
  EXPECT_NEAR(scale_of(m, "ay_mps2"), -9.80665, 1e-9);
}

}  // namespace foreign_names_test
}  // namespace explain
