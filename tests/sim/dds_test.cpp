// A second participant: a program of its own that knows the messages alone.
#include "sim/dds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#ifdef KERBSTONE_HAS_DDS
#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <thread>

#include "crg/file.h"
#include "dds_connection.h"
#include "kerbstone.h"
#include "ros2.h"
#include "some_unit.h"
#include "support/own_domain.h"
#include "support/places.h"

namespace dds_test {

using sim_tests::description_2, sim_tests::scalar_2, sim_tests::write_unit;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const char* const kDevices = R"(sensors:
  slow.b: {signal: b, rate_hz: 20, delay_s: 0.02}
commands:
  steering_angle: {signal: a, gain: 2}
topics:
  imu: {type: sensor_msgs/Imu, frame: box, fields: {angular_velocity.z: b, linear_acceleration.x: m, linear_acceleration.z: 9.81, angular_velocity.variance: 0.5}}
  fix: {type: sensor_msgs/NavSatFix, frame: antenna, fields: {latitude: 48.5, longitude: slow.b, position.variance: 4}}
  car/odom: {type: nav_msgs/Odometry, fields: {position.x: b, position.y: m, yaw: b, linear.x: 12, position.variance: 0.25, angular.variance: 0.125}}
  twist: {type: geometry_msgs/TwistWithCovarianceStamped, frame: base_link, fields: {linear.x: b, angular.z: m}}
  rest: {type: kerbstone_msgs/Values, fields: {b: b, slow_m: m}}
)";

struct Topic {
  const char *name, *type;
  const dds_topic_descriptor_t* descriptor;
};
// As `ros2 topic list -t` would have them, written as they are on the wire.
const Topic kImu{"rt/imu", "sensor_msgs::msg::dds_::Imu_", &sensor_msgs_msg_dds__Imu__desc},
    kFix{"rt/fix", "sensor_msgs::msg::dds_::NavSatFix_", &sensor_msgs_msg_dds__NavSatFix__desc},
    kOdom{"rt/car/odom", "nav_msgs::msg::dds_::Odometry_", &nav_msgs_msg_dds__Odometry__desc},
    kTwist{"rt/twist", "geometry_msgs::msg::dds_::TwistWithCovarianceStamped_",
           &geometry_msgs_msg_dds__TwistWithCovarianceStamped__desc},
    kRest{"rt/rest", "kerbstone_msgs::msg::dds_::Values_", &kerbstone_msgs_msg_dds__Values__desc},
    kClock{"rt/clock", "rosgraph_msgs::msg::dds_::Clock_", &rosgraph_msgs_msg_dds__Clock__desc},
    kStep{"rt/crgsim/step", "kerbstone_msgs::msg::dds_::Step_",
          &kerbstone_msgs_msg_dds__Step__desc},
    kCommand{"rt/crgsim/command", "kerbstone_msgs::msg::dds_::CarCommand_",
             &kerbstone_msgs_msg_dds__CarCommand__desc};

class Second {
 public:
  Second() {
    dds_create_domain(
        places::own_domain(),
        "<General><Interfaces><NetworkInterface address='127.0.0.1'/></Interfaces><AllowMulticast>"
        "false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
        "<Peers><Peer address='127.0.0.1'/></Peers></Discovery>");
    participant_ = dds_create_participant(places::own_domain(), nullptr, nullptr);
    EXPECT_GT(participant_, 0) << dds_strretcode(-participant_);
    command_ = dds_create_writer(participant_, topic(kCommand), qos().get(), nullptr);
  }
  Second(const Second&) = delete;
  Second& operator=(const Second&) = delete;
  ~Second() { dds_delete(DDS_CYCLONEDDS_HANDLE); }

  dds_entity_t reader(const Topic& of) {
    EXPECT_STREQ(of.descriptor->m_typename, of.type);
    return dds_create_reader(participant_, topic(of), qos().get(), nullptr);
  }

  void say(const kerbstone_msgs_msg_dds__CarCommand_& command) {
    EXPECT_EQ(dds_write(command_, &command), DDS_RETCODE_OK);
  }

  /// The next message, waited for; once more `again` is called every second.
  template <class Message>
  std::shared_ptr<const Message> next(dds_entity_t reader,
                                      const std::function<void()>& again = {}) {
    for (int tries = 0; tries < 500; ++tries) {
      void* sample = nullptr;
      dds_sample_info_t info{};
      if (dds_take(reader, &sample, &info, 1, 1) == 1) {
        std::shared_ptr<const Message> out(static_cast<const Message*>(sample),
                                           [reader](const Message* one) {
                                             void* given = const_cast<Message*>(one);
                                             dds_return_loan(reader, &given, 1);
                                           });
        if (info.valid_data) return out;
        continue;
      }
      if (again && tries % 100 == 99) again();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ADD_FAILURE() << "no message came";
    return std::make_shared<const Message>();
  }

  /// The bytes of the next message, as they were on the wire.
  std::string next_bytes(dds_entity_t reader) {
    for (int tries = 0; tries < 500; ++tries) {
      ddsi_serdata* data = nullptr;
      dds_sample_info_t info{};
      if (dds_takecdr(reader, &data, 1, &info, DDS_ANY_STATE) == 1) {
        std::string bytes(ddsi_serdata_size(data), '\0');
        ddsi_serdata_to_ser(data, 0, bytes.size(), bytes.data());
        ddsi_serdata_unref(data);
        if (info.valid_data) return bytes;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ADD_FAILURE() << "no message came";
    return {};
  }

 private:
  struct DeleteQos {
    void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
  };
  static std::unique_ptr<dds_qos_t, DeleteQos> qos() {
    std::unique_ptr<dds_qos_t, DeleteQos> out(dds_create_qos());
    dds_qset_reliability(out.get(), DDS_RELIABILITY_RELIABLE, DDS_SECS(10));
    dds_qset_durability(out.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_history(out.get(), DDS_HISTORY_KEEP_ALL, 0);
    return out;
  }
  dds_entity_t topic(const Topic& of) const {
    return dds_create_topic(participant_, of.descriptor, of.name, nullptr, nullptr);
  }
  dds_entity_t participant_ = 0, command_ = 0;
};

/// crgsim serve --dds in a process of its own, of a unit whose b and m are its inputs a and n.
class Served {
 public:
  explicit Served(const std::string& more, const std::string& devices = kDevices) {
    // Along x from 0 to 100 m, 8 m wide.
    crg::ReferenceLine middle;
    crg::Grid grid{0.0, 1.0, {-4, 0, 4}, std::vector<float>(303, 0.0f)};
    for (int i = 0; i <= 100; ++i) middle.x_m.push_back(i);
    middle.y_m.assign(101, 0.0);
    middle.heading_rad.assign(101, 0.0);
    crg::write(crg::make_crg(middle, grid), folder_.path("road.crg"), crg::Format::KRBI);
    const std::string unit = write_unit(
        folder_,
        description_2("through",
                      scalar_2("a", 10, "input") + scalar_2("n", 11, "input", "Integer") +
                          scalar_2("b", 20, "output") + scalar_2("m", 21, "output", "Integer")),
        2);
    const std::string line = fmt::format(
        "timeout 60 '{}' serve '{}' --dds --domain {} --step-s 0.01 --devices '{}' --command n {} "
        "--json -o '{}' > '{}' 2> '{}'",
        places::crgsim(), unit, places::own_domain(), folder_.file("devices.yaml", devices),
        more + road_of(devices), folder_.path("run.csv"), folder_.path("json"),
        folder_.path("errors"));
    runs_ = std::thread([this, line] { status_ = std::system(line.c_str()); });
  }
  ~Served() {
    if (runs_.joinable()) runs_.join();
  }
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

  /// What it printed, when it has ended.
  std::string ended() {
    runs_.join();
    EXPECT_EQ(status_, 0) << folder_.read("errors");
    return folder_.read("json");
  }
  std::string table() const { return folder_.read("run.csv"); }
  std::string sights() const { return folder_.read("sights.jsonl"); }

 private:
  std::string road_of(const std::string& devices) const {
    if (devices.find("scans:") == std::string::npos) return "";
    return fmt::format(" --road '{}' --sights '{}'", folder_.path("road.crg"),
                       folder_.path("sights.jsonl"));
  }
  support::TemporaryFolder folder_;
  std::thread runs_;
  int status_ = -1;
};

/// CDR as the standard has it: little endian, numbers aligned to their size after the header.
class Cdr {
 public:
  template <class Number>
  Cdr& put(Number number) {
    while ((bytes_.size() - 4) % sizeof number != 0) bytes_ += '\0';
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof number);
    return *this;
  }
  Cdr& text(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size() + 1));
    bytes_ += text + '\0';
    return *this;
  }
  Cdr& numbers(std::initializer_list<double> all) {
    for (const double one : all) put(one);
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_{'\0', '\1', '\0', '\0'};
};

kerbstone_msgs_msg_dds__CarCommand_ command_of(std::uint32_t sequence, double steering_rad) {
  kerbstone_msgs_msg_dds__CarCommand_ out{};
  out.sequence_ = sequence;
  out.steering_angle_ = steering_rad;
  return out;
}

TEST(Dds, ASecondParticipantHearsWhatTheUnitHas) {
  Served served("--lockstep --every 1 --patience-s 20 --stop-s 5");
  Second second;
  const dds_entity_t imu = second.reader(kImu), fix = second.reader(kFix),
                     odom = second.reader(kOdom), twist = second.reader(kTwist),
                     rest = second.reader(kRest), clock = second.reader(kClock),
                     step = second.reader(kStep);
  char name[] = "n";
  char* names[] = {name};
  double values[] = {3.0};
  auto command = command_of(1, 0.25);
  command.names_ = {1, 1, names, false};
  command.values_ = {1, 1, values, false};
  const auto say = [&] { second.say(command); };
  say();
  const auto answer = second.next<kerbstone_msgs_msg_dds__Step_>(step, say);
  EXPECT_EQ(answer->sequence_, 1u);
  EXPECT_EQ(answer->stamp_.sec_, 0);
  EXPECT_EQ(answer->stamp_.nanosec_, 10'000'000u);
  ASSERT_EQ(answer->messages_._length, 5u);

  const auto turning = second.next<sensor_msgs_msg_dds__Imu_>(imu);
  EXPECT_EQ(turning->angular_velocity_.z_, 0.5) << "the file's gain of 2";
  EXPECT_EQ(turning->linear_acceleration_.x_, 3.0);
  EXPECT_EQ(turning->linear_acceleration_.z_, 9.81);
  EXPECT_EQ(turning->orientation_covariance_[0], -1.0) << "none is told";
  const auto place = second.next<sensor_msgs_msg_dds__NavSatFix_>(fix);
  EXPECT_EQ(place->latitude_, 48.5);
  EXPECT_EQ(place->longitude_, 0.0) << "the sample of before the command";
  EXPECT_STREQ(place->header_.frame_id_, "antenna");
  EXPECT_EQ(place->header_.stamp_.sec_, -1) << "0.02 s before the begin";
  EXPECT_EQ(place->header_.stamp_.nanosec_, 980'000'000u);
  EXPECT_THAT(std::vector(place->position_covariance_, place->position_covariance_ + 9),
              ElementsAre(4, 0, 0, 0, 4, 0, 0, 0, 4));
  EXPECT_EQ(place->position_covariance_type_, 2);
  const auto at = second.next<nav_msgs_msg_dds__Odometry_>(odom);
  EXPECT_EQ(at->pose_.pose_.position_.x_, 0.5);
  EXPECT_EQ(at->pose_.pose_.position_.y_, 3.0);
  EXPECT_DOUBLE_EQ(at->pose_.pose_.orientation_.z_, std::sin(0.25));
  EXPECT_EQ(at->pose_.covariance_[14], 0.25);
  EXPECT_EQ(at->twist_.twist_.linear_.x_, 12.0);
  EXPECT_EQ(at->twist_.covariance_[35], 0.125);
  EXPECT_EQ(at->twist_.covariance_[14], 0.0);
  EXPECT_STREQ(at->header_.frame_id_, "map");
  EXPECT_STREQ(at->child_frame_id_, "base_link");
  const auto goes = second.next<geometry_msgs_msg_dds__TwistWithCovarianceStamped_>(twist);
  EXPECT_EQ(goes->twist_.twist_.linear_.x_, 0.5);
  EXPECT_EQ(goes->twist_.twist_.angular_.z_, 3.0);
  const auto others = second.next<kerbstone_msgs_msg_dds__Values_>(rest);
  ASSERT_EQ(others->names_._length, 2u);
  EXPECT_STREQ(others->names_._buffer[1], "slow_m");
  EXPECT_EQ(others->values_._buffer[0], 0.5);
  EXPECT_EQ(second.next<rosgraph_msgs_msg_dds__Clock_>(clock)->clock_.nanosec_, 10'000'000u);

  // Ten more steps: the sensor of 20 Hz speaks twice, at 0.05 and 0.1 s.
  for (std::uint32_t k = 2; k <= 11; ++k) {
    command = command_of(k, 0.5);
    say();
    const auto told = second.next<kerbstone_msgs_msg_dds__Step_>(step, say);
    EXPECT_EQ(told->sequence_, k);
    EXPECT_EQ(told->messages_._buffer[0], k);
    EXPECT_EQ(told->messages_._buffer[1], 1u + k / 5);
  }
  EXPECT_EQ(second.next<sensor_msgs_msg_dds__NavSatFix_>(fix)->longitude_, 1.0);
  command.end_ = true;
  ++command.sequence_;
  say();
  EXPECT_THAT(served.ended(), HasSubstr("by a command"));
  EXPECT_THAT(served.table(), HasSubstr("time_s,b,m,slow.b,slow.b.age_s,n,steering_angle,safe"));
}

TEST(Dds, BytesAreThoseOfTheStandard) {
  Served served("--lockstep --every 1 --patience-s 20 --stop-s 5");
  Second second;
  const dds_entity_t imu = second.reader(kImu), twist = second.reader(kTwist),
                     fix = second.reader(kFix), step = second.reader(kStep);
  auto command = command_of(1, -1.5);
  const auto say = [&] { second.say(command); };
  say();
  second.next<kerbstone_msgs_msg_dds__Step_>(step, say);
  const auto header = [](std::int32_t s, std::uint32_t ns, const char* frame) {
    return Cdr().put(s).put(ns).text(frame);
  };
  const auto trimmed = [](const std::string& bytes, const Cdr& like) {
    EXPECT_LT(bytes.size() - like.bytes().size(), 4u) << "filled up to words alone";
    return bytes.substr(4, like.bytes().size() - 4);
  };
  Cdr turning = header(0, 10'000'000, "box");
  turning.numbers({0, 0, 0, 1}).numbers({-1, 0, 0, 0, 0, 0, 0, 0, 0});
  turning.numbers({0, 0, -3}).numbers({0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.5});
  turning.numbers({0, 0, 9.81}).numbers({0, 0, 0, 0, 0, 0, 0, 0, 0});
  const std::string told = second.next_bytes(imu);
  EXPECT_EQ(told.substr(0, 2), std::string("\0\1", 2)) << "CDR, little endian";
  EXPECT_EQ(trimmed(told, turning), turning.bytes().substr(4));
  Cdr goes = header(0, 10'000'000, "base_link");
  goes.numbers({-3, 0, 0}).numbers({0, 0, 0});
  for (int k = 0; k < 36; ++k) goes.put(0.0);
  EXPECT_EQ(trimmed(second.next_bytes(twist), goes), goes.bytes().substr(4));
  Cdr place = header(-1, 980'000'000, "antenna");
  place.put(std::int8_t{0}).put(std::uint16_t{1}).numbers({48.5, 0, 0});
  place.numbers({4, 0, 0, 0, 4, 0, 0, 0, 4}).put(std::uint8_t{2});
  EXPECT_EQ(trimmed(second.next_bytes(fix), place), place.bytes().substr(4));
  command.end_ = true;
  ++command.sequence_;
  say();
  served.ended();
}

TEST(Dds, ScansEdgesAndPlansAreMessagesOfTheirOwn) {
  Served served("--lockstep --every 5 --patience-s 20 --stop-s 5",
                R"(scans:
  lidar/points: {at_m: [0, 0, 1], beams_deg: [-30], field_deg: 90, step_deg: 30, rate_hz: 20}
edges:
  camera: {at_m: [0, 0, 1], reach_m: 20, rate_hz: 10}
pose: {x: b, y: m, z: m, roll: m, pitch: m, yaw: m}
commands:
  steering_angle: {signal: a, gain: 100}
topics:
  rest: {type: kerbstone_msgs/Values, fields: {b: b}}
)");
  Second second;
  const dds_entity_t scans =
                         second.reader({"rt/lidar/points", "sensor_msgs::msg::dds_::PointCloud2_",
                                        &sensor_msgs_msg_dds__PointCloud2__desc}),
                     edges = second.reader({"rt/camera", "kerbstone_msgs::msg::dds_::Edges_",
                                            &kerbstone_msgs_msg_dds__Edges__desc}),
                     plans = second.reader({"rt/crgsim/plan", "kerbstone_msgs::msg::dds_::Plan_",
                                            &kerbstone_msgs_msg_dds__Plan__desc}),
                     step = second.reader(kStep);
  auto command = command_of(1, 0.5);  // at x = 50 m
  kerbstone_msgs_msg_dds__PlanPoint_ points[] = {{51.0, 0.0, 10.0}, {52.0, 0.5, 11.0}};
  command.plan_ = {2, 2, points, false};
  const auto say = [&] { second.say(command); };
  say();
  const auto told = second.next<kerbstone_msgs_msg_dds__Step_>(step, say);
  ASSERT_EQ(told->messages_._length, 3u) << "the topic, the scan, the edges";
  EXPECT_EQ(told->messages_._buffer[1], 2u) << "at 0 and at 0.05 s";
  EXPECT_EQ(told->messages_._buffer[2], 1u);

  second.next<sensor_msgs_msg_dds__PointCloud2_>(scans);  // at 0 s, at the begin of the road
  const auto cloud = second.next<sensor_msgs_msg_dds__PointCloud2_>(scans);
  EXPECT_STREQ(cloud->header_.frame_id_, "lidar/points");
  EXPECT_EQ(cloud->header_.stamp_.nanosec_, 50'000'000u);
  ASSERT_EQ(cloud->width_, 3u) << "azimuths of -30, 0 and 30 degrees";
  EXPECT_EQ(cloud->height_, 1u);
  EXPECT_EQ(cloud->point_step_, 16u);
  EXPECT_EQ(cloud->row_step_, 48u);
  EXPECT_FALSE(cloud->is_bigendian_);
  ASSERT_EQ(cloud->fields_._length, 4u);
  EXPECT_STREQ(cloud->fields_._buffer[3].name_, "intensity");
  EXPECT_EQ(cloud->fields_._buffer[3].offset_, 12u);
  EXPECT_EQ(cloud->fields_._buffer[3].datatype_, 7) << "float32";
  ASSERT_EQ(cloud->data_._length, 48u);
  std::array<float, 12> numbers{};
  std::memcpy(numbers.data(), cloud->data_._buffer, 48);
  EXPECT_NEAR(numbers[4], std::sqrt(3.0), 1e-5) << "straight ahead";
  EXPECT_NEAR(numbers[5], 0.0, 1e-6);
  EXPECT_NEAR(numbers[6], -1.0, 1e-5);
  EXPECT_NEAR(numbers[7], 0.5, 1e-5) << "the cosine of 60 degrees";

  const auto ends = second.next<kerbstone_msgs_msg_dds__Edges_>(edges);
  EXPECT_STREQ(ends->header_.frame_id_, "base_link");
  ASSERT_GT(ends->left_._length, 10u);
  EXPECT_NEAR(ends->left_._buffer[0].y_, 4.0, 1e-5);
  EXPECT_NEAR(ends->right_._buffer[0].y_, -4.0, 1e-5);

  const auto plan = second.next<kerbstone_msgs_msg_dds__Plan_>(plans);
  EXPECT_EQ(plan->sequence_, 1u);
  ASSERT_EQ(plan->points_._length, 2u);
  EXPECT_EQ(plan->points_._buffer[1].y_, 0.5);
  EXPECT_EQ(plan->points_._buffer[1].speed_, 11.0);
  std::vector<kerbstone_msgs_msg_dds__PlanPoint_> many(501);
  command.plan_ = {501, 501, many.data(), false};
  ++command.sequence_;
  say();
  command.plan_ = {};
  command.end_ = true;
  ++command.sequence_;
  say();
  EXPECT_THAT(served.ended(), HasSubstr("\"broken_commands\": 1"));
  EXPECT_THAT(served.sights(), HasSubstr(R"({"plan":[[51,0,10],[52,0.5,11]],"sequence":1)"));
}

TEST(Dds, InRealTimeTheSafeInputActsAndBrokenCommandsAreCounted) {
  Served served("--every 5 --stop-s 15 --safe n=7 --safe-after-s 0.3");
  Second second;
  const dds_entity_t step = second.reader(kStep), twist = second.reader(kTwist);
  auto command = command_of(1, 0.5);
  const auto say = [&] { second.say(command); };
  std::uint32_t taken = 0;
  for (int k = 0; k < 250 && taken != 1; ++k) {  // until it is heard
    say();
    taken = second.next<kerbstone_msgs_msg_dds__Step_>(step)->sequence_;
  }
  EXPECT_EQ(taken, 1u);
  command.sequence_ = 2;
  command.steering_angle_ = NAN;
  say();
  bool safe = false;
  for (int k = 0; k < 60 && !safe; ++k)
    safe = second.next<kerbstone_msgs_msg_dds__Step_>(step)->safe_;
  EXPECT_TRUE(safe);
  double told = 0.0;
  for (int k = 0; k < 300 && told != 7.0; ++k)
    told = second.next<geometry_msgs_msg_dds__TwistWithCovarianceStamped_>(twist)
               ->twist_.twist_.angular_.z_;
  EXPECT_EQ(told, 7.0);
  command = command_of(1, 0.0);  // begins anew, and may count from anywhere
  command.end_ = true;
  say();
  const std::string summary = served.ended();
  EXPECT_THAT(summary, HasSubstr("\"broken_commands\": 1"));
  EXPECT_THAT(summary, HasSubstr("by a command"));
}

TEST(Dds, HearsThisMachineAlone) {
  const auto sockets = [] {
    std::map<int, std::string> devices;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
      const int descriptor = std::atoi(entry.path().filename().c_str());
      sockaddr_storage address{};
      socklen_t size = sizeof address, length = IFNAMSIZ;
      if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
          address.ss_family != AF_INET)
        continue;
      char device[IFNAMSIZ] = {};
      ::getsockopt(descriptor, SOL_SOCKET, SO_BINDTODEVICE, device, &length);
      devices[descriptor] = device;
    }
    return devices;
  };
  const auto before = sockets();
  {
    const sim::TopicPlan plan;
    const sim::Connection connection = sim::connect_dds(places::own_domain(), plan, true);
    std::size_t count = 0;
    for (const auto& [descriptor, device] : sockets())
      if (!before.contains(descriptor)) {
        ++count;
        EXPECT_EQ(device, "lo");
      }
    EXPECT_GE(count, 3u);
  }
  EXPECT_EQ(sockets(), before);
}

TEST(Dds, SaysItsVersion) { EXPECT_THAT(sim::dds_version(), HasSubstr("0.")); }

}  // namespace dds_test
#else
TEST(Dds, IsBuilt) { GTEST_SKIP() << "built without Cyclone DDS"; }
#endif
