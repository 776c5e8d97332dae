// The wire of DDS, by Eclipse Cyclone DDS and the types that idlc makes of idl/: names and types
// are those that ROS 2 has there (design.ros2.org, "Topic and service name mapping to DDS").
#include "sim/dds.h"

#include <dds/dds.h>
#include <dds/version.h>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>

#include "base/error.h"
#include "dds_connection.h"
#include "dds_messages.h"
#include "kerbstone.h"
#include "loopback.h"
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
constexpr int kKeptMessages = 100;  ///< messages that a reader may be behind
constexpr int kScansKept = 10;      ///< the same of scans, which are large
constexpr std::size_t kMostNames = 1000;
constexpr double kLongestReaderWait_s = 10.0;  ///< for a reader, in lockstep

/// Anything of Cyclone DDS, or what it says instead.
dds_entity_t sound(dds_entity_t entity, const std::string& what) {
  if (entity >= 0) return entity;
  throw base::Error(fmt::format("DDS: {}: {}", what, dds_strretcode(-entity)));
}

/// Names and values that belong together.
bool take_pairs(const dds_sequence_string& names, const dds_sequence_double& values,
                std::vector<std::pair<std::string, double>>& out) {
  if (names._length != values._length || names._length > kMostNames) return false;
  for (std::uint32_t k = 0; k < names._length; ++k)
    out.emplace_back(names._buffer[k], values._buffer[k]);
  return true;
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
    for (const std::string& name : plan.scans)
      scans_.push_back({writer(name, &sensor_msgs_msg_dds__PointCloud2__desc, kScansKept)});
    for (const std::string& name : plan.edges)
      edges_.push_back({writer(name, &kerbstone_msgs_msg_dds__Edges__desc)});
    plan_told_ = writer("crgsim/plan", &kerbstone_msgs_msg_dds__Plan__desc);
    remark_ = writer("crgsim/remark", &kerbstone_msgs_msg_dds__Remark__desc);
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
    for (const auto& [kind, text] :
         {std::pair{"clipped", &message.clipped}, {"parked", &message.parked}})
      if (!text->empty()) remark({kind, *text, message.sequence, message.time_s});
    std::vector<std::uint32_t> counts;
    for (const auto* const writers : {&writers_, &scans_, &edges_})
      for (const Writer& one : *writers) counts.push_back(one.messages);
    const auto size = static_cast<std::uint32_t>(counts.size());
    const kerbstone_msgs_msg_dds__Step_ step{stamp_of(message.time_s),
                                             message.sequence,
                                             message.is_safe,
                                             message.was_reset,
                                             {size, size, counts.data(), false}};
    check(dds_write(step_, &step), "crgsim/step");
  }

  void remark(const Remark& one) const { check(write_remark(remark_, one), "crgsim/remark"); }

  void show(const Sight& sight) {
    const auto told = [this](Writer& one, dds_return_t result, const std::string& name) {
      check(result, name);
      ++one.messages;
    };
    if (const auto* const scan = std::get_if<Scan>(&sight)) {
      Writer& one = scans_[scan->sensor];
      told(one, write_scan(one.entity, *scan), scan->name);
    } else if (const auto* const edges = std::get_if<Edges>(&sight)) {
      Writer& one = edges_[edges->sensor];
      told(one, write_edges(one.entity, *edges), edges->name);
    } else {
      check(write_plan(plan_told_, std::get<Plan>(sight)), "crgsim/plan");
    }
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

  std::unique_ptr<dds_qos_t, DeleteQos> reliable(int kept = kKeptMessages) const {
    std::unique_ptr<dds_qos_t, DeleteQos> qos(dds_create_qos());
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE,
                         lockstep_ ? static_cast<dds_duration_t>(1e9 * kLongestReaderWait_s) : 0);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, kept);
    return qos;
  }

  dds_entity_t topic_of(const std::string& name, const dds_topic_descriptor_t* type) const {
    return sound(dds_create_topic(participant_, type, ("rt/" + plan_.prefix + name).c_str(),
                                  nullptr, nullptr),
                 "no topic " + name);
  }

  dds_entity_t writer(const std::string& name, const dds_topic_descriptor_t* type,
                      int kept = kKeptMessages) const {
    const auto qos = reliable(kept);
    // Who joins late and asks for it gets what was sent before.
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, kept, DDS_LENGTH_UNLIMITED,
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
                                    topic, kLongestReaderWait_s));
    sound(result, topic);
  }

  Received read(const kerbstone_msgs_msg_dds__CarCommand_& message) const {
    Received out;
    CarCommand said;
    said.sequence = message.sequence_;
    out.sequence = message.sequence_;
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
    for (const auto& [from, to] :
         {std::pair{message.save_, &said.save}, {message.state_, &said.state}})
      if (from != nullptr) *to = from;
    const auto& plan = message.plan_;
    if (plan._length > kMostPlanPoints) {
      out.why = "a plan of more than 500 points";
      return out;
    }
    for (std::uint32_t k = 0; k < plan._length; ++k)
      said.plan.push_back({plan._buffer[k].x_, plan._buffer[k].y_, plan._buffer[k].speed_});
    if (!take_pairs(message.names_, message.values_, said.others) ||
        !take_pairs(message.start_names_, message.start_values_, said.starts))
      out.why = "names and values that are not as many, or more than 1000";
    else
      out.command = command_of(said, plan_, out.why);
    return out;
  }

  const TopicPlan& plan_;
  bool lockstep_;
  dds_entity_t participant_ = 0, clock_ = 0, step_ = 0, remark_ = 0, command_ = 0, waitset_ = 0,
               plan_told_ = 0;
  std::vector<Writer> writers_, scans_, edges_;
};

}  // namespace

std::string dds_version() { return DDS_VERSION; }

void require_dds(const std::string&) {}

Connection connect_dds(unsigned domain, const TopicPlan& plan, bool lockstep) {
  const auto participant = std::make_shared<Participant>(domain, plan, lockstep);
  return {[participant](double wait_s) { return participant->receive(wait_s); }, [] {},
          [participant](const Remark& remark) { participant->remark(remark); },
          [participant](const MeasurementMessage& message, bool again) {
            participant->send(message, again);
          },
          [participant](const ToldSight& seen) { participant->show(seen.sight); }};
}

}  // namespace sim
