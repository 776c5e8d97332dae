// The wire of DDS, by Eclipse Cyclone DDS and the types that idlc makes of idl/: names and types
// are those that ROS 2 has there (design.ros2.org, "Topic and service name mapping to DDS").
#include "sim/dds.h"

#include <dds/dds.h>
#include <dds/version.h>
#include <fmt/format.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <set>

#include "base/error.h"
#include "dds_connection.h"
#include "kerbstone.h"
#include "ros2.h"

namespace sim {
namespace {

// Peers are asked one by one where the loopback has no multicast.
constexpr const char* kLoopback =
    "<CycloneDDS><Domain id=\"any\"><General><Interfaces><NetworkInterface address=\"127.0.0.1\" "
    "multicast=\"true\"/></Interfaces><AllowMulticast>spdp</AllowMulticast></General><Discovery>"
    "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>30"
    "</MaxAutoParticipantIndex><Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery></Domain>"
    "</CycloneDDS>";
constexpr int kKept = 100;  ///< messages that a reader may be behind
constexpr std::size_t kMostNames = 1000;
constexpr double kLongestWait_s = 10.0;  ///< for a reader, in lockstep

/// Anything of Cyclone DDS, or what it says instead.
dds_entity_t sound(dds_entity_t entity, const std::string& what) {
  if (entity >= 0) return entity;
  throw base::Error(fmt::format("DDS: {}: {}", what, dds_strretcode(-entity)));
}

builtin_interfaces_msg_dds__Time_ stamp_of(double time_s) {
  const std::int64_t all = std::llround(1e9 * time_s);
  const std::int64_t seconds = all >= 0 ? all / 1'000'000'000 : (all + 1) / 1'000'000'000 - 1;
  return {static_cast<std::int32_t>(seconds),
          static_cast<std::uint32_t>(all - seconds * 1'000'000'000)};
}

// Written, not kept: Cyclone DDS copies it.
char* text_of(const std::string& text) { return const_cast<char*>(text.c_str()); }

void fill(std_msgs_msg_dds__Header_& header, const Told& told) {
  header.stamp_ = stamp_of(told.time_s());
  header.frame_id_ = text_of(told.topic().frame);
}

geometry_msgs_msg_dds__Vector3_ vector_of(const Told& told, const std::string& of) {
  return {told.value(of + ".x"), told.value(of + ".y"), told.value(of + ".z")};
}

geometry_msgs_msg_dds__Quaternion_ orientation_of(const Told& told) {
  const auto q = quaternion(told.value("roll"), told.value("pitch"), told.value("yaw"));
  return {q[0], q[1], q[2], q[3]};
}

/// `variance` on three places of a square matrix's diagonal.
template <std::size_t count>
void spread(double variance, double (&matrix)[count], std::size_t first = 0) {
  constexpr std::size_t rows = count == 9 ? 3 : 6;
  for (std::size_t k = first; k < first + 3; ++k) matrix[k * (rows + 1)] = variance;
}

void fill(geometry_msgs_msg_dds__TwistWithCovariance_& twist, const Told& told) {
  twist.twist_ = {vector_of(told, "linear"), vector_of(told, "angular")};
  spread(told.value("linear.variance"), twist.covariance_);
  spread(told.value("angular.variance"), twist.covariance_, 3);
}

void fill(geometry_msgs_msg_dds__TwistWithCovarianceStamped_& message, const Told& told) {
  fill(message.header_, told);
  fill(message.twist_, told);
}

void fill(sensor_msgs_msg_dds__Imu_& message, const Told& told) {
  fill(message.header_, told);
  message.orientation_ = orientation_of(told);
  spread(told.value("orientation.variance"), message.orientation_covariance_);
  // The message's word for: not measured.
  if (!told.has("yaw") && !told.has("pitch") && !told.has("roll"))
    message.orientation_covariance_[0] = -1.0;
  message.angular_velocity_ = vector_of(told, "angular_velocity");
  spread(told.value("angular_velocity.variance"), message.angular_velocity_covariance_);
  message.linear_acceleration_ = vector_of(told, "linear_acceleration");
  spread(told.value("linear_acceleration.variance"), message.linear_acceleration_covariance_);
}

void fill(sensor_msgs_msg_dds__NavSatFix_& message, const Told& told) {
  fill(message.header_, told);
  message.status_ = {0, 1};  // a fix, by GPS
  message.latitude_ = told.value("latitude");
  message.longitude_ = told.value("longitude");
  message.altitude_ = told.value("altitude");
  spread(told.value("position.variance"), message.position_covariance_);
  message.position_covariance_type_ = told.has("position.variance") ? 2 : 0;  // diagonal known
}

void fill(nav_msgs_msg_dds__Odometry_& message, const Told& told) {
  fill(message.header_, told);
  message.child_frame_id_ = text_of(told.topic().child_frame);
  const auto at = vector_of(told, "position");
  message.pose_.pose_ = {{at.x_, at.y_, at.z_}, orientation_of(told)};
  spread(told.value("position.variance"), message.pose_.covariance_);
  spread(told.value("orientation.variance"), message.pose_.covariance_, 3);
  fill(message.twist_, told);
}

template <class Message>
dds_return_t write_as(dds_entity_t writer, const Told& told) {
  Message message{};
  fill(message, told);
  return dds_write(writer, &message);
}

template <>
dds_return_t write_as<kerbstone_msgs_msg_dds__Values_>(dds_entity_t writer, const Told& told) {
  std::vector<char*> names;
  std::vector<double> values;
  for (const std::string& field : told.topic().fields) {
    names.push_back(text_of(field));
    values.push_back(told.value(field));
  }
  const auto count = static_cast<std::uint32_t>(values.size());
  kerbstone_msgs_msg_dds__Values_ message{};
  fill(message.header_, told);
  message.names_ = {count, count, names.data(), false};
  message.values_ = {count, count, values.data(), false};
  return dds_write(writer, &message);
}

struct WireType {
  std::string_view name;
  const dds_topic_descriptor_t* descriptor;
  dds_return_t (*write)(dds_entity_t, const Told&);
};
constexpr std::array kWireTypes{
    WireType{"sensor_msgs/Imu", &sensor_msgs_msg_dds__Imu__desc,
             write_as<sensor_msgs_msg_dds__Imu_>},
    WireType{"sensor_msgs/NavSatFix", &sensor_msgs_msg_dds__NavSatFix__desc,
             write_as<sensor_msgs_msg_dds__NavSatFix_>},
    WireType{"nav_msgs/Odometry", &nav_msgs_msg_dds__Odometry__desc,
             write_as<nav_msgs_msg_dds__Odometry_>},
    WireType{"geometry_msgs/TwistWithCovarianceStamped",
             &geometry_msgs_msg_dds__TwistWithCovarianceStamped__desc,
             write_as<geometry_msgs_msg_dds__TwistWithCovarianceStamped_>},
    WireType{"kerbstone_msgs/Values", &kerbstone_msgs_msg_dds__Values__desc,
             write_as<kerbstone_msgs_msg_dds__Values_>}};

const WireType& wire_type(const std::string& name) {
  for (const WireType& type : kWireTypes)
    if (type.name == name) return type;
  throw base::Error("DDS: no message " + name);
}

/// Names and values that belong together.
bool take_pairs(const dds_sequence_string& names, const dds_sequence_double& values,
                std::vector<std::pair<std::string, double>>& out) {
  if (names._length != values._length || names._length > kMostNames) return false;
  for (std::uint32_t k = 0; k < names._length; ++k)
    out.emplace_back(names._buffer[k], values._buffer[k]);
  return true;
}

/// Sockets of the internet that this process has.
std::set<int> open_sockets() {
  std::set<int> out;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int descriptor = std::atoi(entry.path().filename().c_str());
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) == 0 &&
        (address.ss_family == AF_INET || address.ss_family == AF_INET6))
      out.insert(descriptor);
  }
  return out;
}

/// Cyclone DDS sends by the interface that it was given, and receives by all. Sockets that are not
/// in `before` receive by the loopback alone.
void receive_by_loopback(const std::set<int>& before) {
  for (const int descriptor : open_sockets())
    if (!before.contains(descriptor) &&
        ::setsockopt(descriptor, SOL_SOCKET, SO_BINDTODEVICE, "lo", 3) != 0)
      throw base::Error(fmt::format(
          "DDS: cannot be kept to this machine: {}; CYCLONEDDS_URI says what else is wanted",
          std::strerror(errno)));
}

class Participant {
 public:
  Participant(unsigned domain, const TopicPlan& plan, bool lockstep)
      : plan_(plan), lockstep_(lockstep) {
    const bool is_alone = std::getenv("CYCLONEDDS_URI") == nullptr;
    const std::set<int> before = open_sockets();
    if (is_alone) sound(dds_create_domain(domain, kLoopback), fmt::format("domain {}", domain));
    participant_ = sound(dds_create_participant(domain, nullptr, nullptr), "no participant");
    if (is_alone) receive_by_loopback(before);
    for (const PlannedTopic& topic : plan.topics)
      writers_.push_back({writer(topic.name, wire_type(topic.type).descriptor)});
    clock_ = writer("clock", &rosgraph_msgs_msg_dds__Clock__desc);
    step_ = writer("crgsim/step", &kerbstone_msgs_msg_dds__Step__desc);
    const auto qos = reliable();
    command_ = sound(
        dds_create_reader(participant_,
                          topic_of("crgsim/command", &kerbstone_msgs_msg_dds__CarCommand__desc),
                          qos.get(), nullptr),
        "no reader of crgsim/command");
    waitset_ = sound(dds_create_waitset(participant_), "no set to wait on");
    sound(dds_set_status_mask(command_, DDS_DATA_AVAILABLE_STATUS), "no status");
    sound(dds_waitset_attach(waitset_, command_, 0), "nothing to wait on");
  }
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;
  ~Participant() { dds_delete(DDS_CYCLONEDDS_HANDLE); }

  std::optional<Received> receive(double wait_s) {
    for (const double patience_s : {0.0, wait_s}) {
      if (patience_s > 0.0)
        dds_waitset_wait(waitset_, nullptr, 0, static_cast<dds_duration_t>(1e9 * patience_s));
      // Whoever leaves says so as well: no data.
      for (bool some = true; some;) {
        void* sample = nullptr;
        dds_sample_info_t info{};
        some = dds_take(command_, &sample, &info, 1, 1) > 0;
        if (!some) continue;
        std::optional<Received> received;
        if (info.valid_data)
          received = read(*static_cast<const kerbstone_msgs_msg_dds__CarCommand_*>(sample));
        dds_return_loan(command_, &sample, 1);
        if (received) return received;
      }
    }
    return std::nullopt;
  }

  void send(const MeasurementMessage& message, bool again) {
    if (!again) {
      for (std::size_t k = 0; k < writers_.size(); ++k) tell(writers_[k], plan_.topics[k], message);
      const rosgraph_msgs_msg_dds__Clock_ clock{stamp_of(message.time_s)};
      check(dds_write(clock_, &clock), "clock");
    }
    std::vector<std::uint32_t> counts;
    for (const Writer& one : writers_) counts.push_back(one.messages);
    const auto size = static_cast<std::uint32_t>(counts.size());
    const kerbstone_msgs_msg_dds__Step_ step{stamp_of(message.time_s),
                                             message.sequence,
                                             message.is_safe,
                                             message.was_reset,
                                             {size, size, counts.data(), false}};
    check(dds_write(step_, &step), "crgsim/step");
  }

 private:
  struct Writer {
    dds_entity_t entity = 0;
    std::uint32_t messages = 0;
    std::optional<double> told_s = {};  ///< when what was told last was true
  };
  struct DeleteQos {
    void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
  };

  std::unique_ptr<dds_qos_t, DeleteQos> reliable() const {
    std::unique_ptr<dds_qos_t, DeleteQos> qos(dds_create_qos());
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE,
                         lockstep_ ? static_cast<dds_duration_t>(1e9 * kLongestWait_s) : 0);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, kKept);
    return qos;
  }

  dds_entity_t topic_of(const std::string& name, const dds_topic_descriptor_t* type) const {
    return sound(dds_create_topic(participant_, type, ("rt/" + name).c_str(), nullptr, nullptr),
                 "no topic " + name);
  }

  dds_entity_t writer(const std::string& name, const dds_topic_descriptor_t* type) const {
    const auto qos = reliable();
    // Who joins late and asks for it gets what was sent before.
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, kKept, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
    return sound(dds_create_writer(participant_, topic_of(name, type), qos.get(), nullptr),
                 "no writer of " + name);
  }

  void tell(Writer& one, const PlannedTopic& topic, const MeasurementMessage& message) const {
    const Told told(topic, message);
    // Sensors that are slower than the measurements have told this before.
    if (topic.age && one.told_s && std::abs(*one.told_s - told.time_s()) < 1e-9 &&
        !message.was_reset)
      return;
    one.told_s = told.time_s();
    check(wire_type(topic.type).write(one.entity, told), topic.name);
    ++one.messages;
  }

  void check(dds_return_t result, const std::string& topic) const {
    if (result == DDS_RETCODE_TIMEOUT && !lockstep_) return;
    if (result == DDS_RETCODE_TIMEOUT)
      throw base::Error(fmt::format("DDS: a reader of {} did not take its messages for {:g} s",
                                    topic, kLongestWait_s));
    sound(result, topic);
  }

  Received read(const kerbstone_msgs_msg_dds__CarCommand_& message) const {
    Received out;
    CarCommand said;
    said.sequence = message.sequence_;
    const double* const brake = message.brake_pressure_;
    said.fields = {message.steering_angle_,
                   message.throttle_,
                   brake[0],
                   brake[1],
                   brake[2],
                   brake[3],
                   static_cast<double>(message.gear_),
                   message.clutch_};
    said.ends = message.end_;
    said.pauses = message.pause_;
    said.resets = message.reset_;
    if (!take_pairs(message.names_, message.values_, said.others) ||
        !take_pairs(message.start_names_, message.start_values_, said.starts))
      out.why = "names and values that are not as many, or more than 1000";
    else
      out.command = command_of(said, plan_, out.why);
    return out;
  }

  const TopicPlan& plan_;
  bool lockstep_;
  dds_entity_t participant_ = 0, clock_ = 0, step_ = 0, command_ = 0, waitset_ = 0;
  std::vector<Writer> writers_;
};

}  // namespace

std::string dds_version() { return DDS_VERSION; }

void require_dds(const std::string&) {}

Connection connect_dds(unsigned domain, const TopicPlan& plan, bool lockstep) {
  const auto participant = std::make_shared<Participant>(domain, plan, lockstep);
  return {[participant](double wait_s) { return participant->receive(wait_s); }, [] {},
          [participant](const MeasurementMessage& message, bool again) {
            participant->send(message, again);
          }};
}

}  // namespace sim
