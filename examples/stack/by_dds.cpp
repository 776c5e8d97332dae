// The stack over topics of ROS 2, by Cyclone DDS and what idlc makes of lib/sim/idl
// (docs/crgsim.md). In ROS 2 it would be a node: the topics are those of devices.yaml.
#include <dds/dds.h>

#include <array>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "connection.h"
#include "kerbstone.h"
#include "ros2.h"

namespace stack {
namespace {

// This machine alone, as crgsim.
constexpr const char* kLoopback =
    "<CycloneDDS><Domain id=\"any\"><General><Interfaces><NetworkInterface address=\"127.0.0.1\" "
    "multicast=\"true\"/></Interfaces><AllowMulticast>spdp</AllowMulticast></General><Discovery>"
    "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>30"
    "</MaxAutoParticipantIndex><Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery></Domain>"
    "</CycloneDDS>";

dds_entity_t sound(dds_entity_t entity) {
  if (entity < 0) throw std::runtime_error(std::string("DDS: ") + dds_strretcode(-entity));
  return entity;
}

double seconds(const builtin_interfaces_msg_dds__Time_& time) {
  return time.sec_ + 1e-9 * time.nanosec_;
}

class Connection {
 public:
  Connection(int domain, const std::string& prefix) : prefix_("rt/" + prefix) {
    const auto id = static_cast<dds_domainid_t>(domain);
    sound(dds_create_domain(id, kLoopback));
    participant_ = sound(dds_create_participant(id, nullptr, nullptr));
    waitset_ = sound(dds_create_waitset(participant_));
    gnss_ = reader("gnss/odom", &nav_msgs_msg_dds__Odometry__desc);
    imu_ = reader("imu/data", &sensor_msgs_msg_dds__Imu__desc);
    wheels_ = reader("wheels/twist", &geometry_msgs_msg_dds__TwistWithCovarianceStamped__desc);
    step_ = reader("crgsim/step", &kerbstone_msgs_msg_dds__Step__desc);
    command_ = sound(dds_create_writer(
        participant_, topic("crgsim/command", &kerbstone_msgs_msg_dds__CarCommand__desc),
        qos().get(), nullptr));
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() { dds_delete(DDS_CYCLONEDDS_HANDLE); }

  Measured exchange(const Command& command, const Plan& plan, bool ends) {
    kerbstone_msgs_msg_dds__CarCommand_ message{};
    message.sequence_ = ++sequence_;
    message.steering_angle_ = command[0];
    message.throttle_ = command[1];
    for (std::size_t k = 0; k < 4; ++k) message.brake_pressure_[k] = command[2 + k];
    message.gear_ = static_cast<std::int32_t>(command[6]);
    message.end_ = ends;
    std::vector<kerbstone_msgs_msg_dds__PlanPoint_> points;
    for (const auto& [x_m, y_m, speed_mps] : plan) points.push_back({x_m, y_m, speed_mps});
    const auto count = static_cast<std::uint32_t>(points.size());
    message.plan_ = {count, count, points.data(), false};
    for (int tries = 0; tries < 50; ++tries) {  // said again, it is not acted on again
      sound(dds_write(command_, &message));
      if (ends) return {};
      while (!is_answered())
        if (sound(dds_waitset_wait(waitset_, nullptr, 0, DDS_SECS(1))) == 0) break;
      if (answered_ == sequence_) return now_;
    }
    throw std::runtime_error("no measurement comes");
  }

 private:
  struct DeleteQos {
    void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
  };
  /// Reliable, and of all that was sent before this program was found.
  static std::unique_ptr<dds_qos_t, DeleteQos> qos() {
    std::unique_ptr<dds_qos_t, DeleteQos> out(dds_create_qos());
    dds_qset_reliability(out.get(), DDS_RELIABILITY_RELIABLE, DDS_SECS(10));
    dds_qset_durability(out.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_history(out.get(), DDS_HISTORY_KEEP_ALL, 0);
    return out;
  }
  dds_entity_t topic(const char* name, const dds_topic_descriptor_t* type) const {
    return sound(dds_create_topic(participant_, type, (prefix_ + name).c_str(), nullptr, nullptr));
  }
  dds_entity_t reader(const char* name, const dds_topic_descriptor_t* type) const {
    const dds_entity_t out =
        sound(dds_create_reader(participant_, topic(name, type), qos().get(), nullptr));
    sound(dds_set_status_mask(out, DDS_DATA_AVAILABLE_STATUS));
    sound(dds_waitset_attach(waitset_, out, 0));
    return out;
  }

  /// Calls take(message) for all that came.
  template <class Message, class Take>
  static void take_all(dds_entity_t reader, const Take& take) {
    for (;;) {
      void* sample = nullptr;
      dds_sample_info_t info{};
      if (sound(dds_take(reader, &sample, &info, 1, 1)) == 0) return;
      if (info.valid_data) take(*static_cast<const Message*>(sample));
      dds_return_loan(reader, &sample, 1);
    }
  }

  /// Whether the last command's step is there, and all messages that were sent before it.
  bool is_answered() {
    take_all<nav_msgs_msg_dds__Odometry_>(gnss_, [&](const auto& message) {
      ++came_[0];
      now_.gnss_x_m = message.pose_.pose_.position_.x_;
      now_.gnss_y_m = message.pose_.pose_.position_.y_;
      gnss_s_ = seconds(message.header_.stamp_);
    });
    take_all<sensor_msgs_msg_dds__Imu_>(imu_, [&](const auto& message) {
      ++came_[1];
      now_.yaw_rate_radps = message.angular_velocity_.z_;
    });
    take_all<geometry_msgs_msg_dds__TwistWithCovarianceStamped_>(wheels_, [&](const auto& message) {
      ++came_[2];
      now_.vx_mps = message.twist_.twist_.linear_.x_;
    });
    take_all<kerbstone_msgs_msg_dds__Step_>(step_, [&](const auto& message) {
      answered_ = message.sequence_;
      now_.time_s = seconds(message.stamp_);
      for (std::size_t k = 0; k < sent_.size() && k < message.messages_._length; ++k)
        sent_[k] = message.messages_._buffer[k];
    });
    now_.gnss_age_s = now_.time_s - gnss_s_;
    return answered_ == sequence_ && came_ == sent_;
  }

  std::string prefix_;
  dds_entity_t participant_ = 0, waitset_ = 0, gnss_ = 0, imu_ = 0, wheels_ = 0, step_ = 0,
               command_ = 0;
  std::uint32_t sequence_ = 0, answered_ = 0;
  std::array<std::uint32_t, 3> came_{}, sent_{};  ///< in the order of devices.yaml
  Measured now_;
  double gnss_s_ = 0.0;
};

}  // namespace

Exchange exchange_by_dds(int domain, const std::string& prefix) {
  const auto connection = std::make_shared<Connection>(domain, prefix);
  return [connection](const Command& command, const Plan& plan, bool ends) {
    return connection->exchange(command, plan, ends);
  };
}

}  // namespace stack
