// The same by topics.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#ifdef KERBSTONE_HAS_DDS
#include <dds/dds.h>
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "kerbstone.h"
#include "odd_commands.h"
#include "support/own_domain.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace odd_commands_dds_test {

using Command = kerbstone_msgs_msg_dds__CarCommand_;

/// A participant that commands and hears whether a command was taken or refused.
class Peer {
 public:
  Peer() {
    dds_create_domain(
        places::own_domain(),
        "<General><Interfaces><NetworkInterface address='127.0.0.1'/></Interfaces><AllowMulticast>"
        "false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
        "<Peers><Peer address='127.0.0.1'/></Peers></Discovery>");
    participant_ = dds_create_participant(places::own_domain(), nullptr, nullptr);
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(10));
    dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
    const auto topic = [&](const char* name, const dds_topic_descriptor_t& type) {
      return dds_create_topic(participant_, &type, name, nullptr, nullptr);
    };
    command_ = dds_create_writer(
        participant_, topic("rt/crgsim/command", kerbstone_msgs_msg_dds__CarCommand__desc), qos,
        nullptr);
    step_ = dds_create_reader(
        participant_, topic("rt/crgsim/step", kerbstone_msgs_msg_dds__Step__desc), qos, nullptr);
    remark_ = dds_create_reader(participant_,
                                topic("rt/crgsim/remark", kerbstone_msgs_msg_dds__Remark__desc),
                                qos, nullptr);
    dds_delete_qos(qos);
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  ~Peer() { dds_delete(DDS_CYCLONEDDS_HANDLE); }

  void say(const Command& command) const { dds_write(command_, &command); }

  enum class Answer { none, taken, refused };
  Answer answer(std::uint32_t sequence, double patience_s) const {
    for (int tries = 0; tries < patience_s / 0.001; ++tries) {
      if (has<kerbstone_msgs_msg_dds__Step_>(
              step_, [&](const auto& one) { return one.sequence_ == sequence; }))
        return Answer::taken;
      if (has<kerbstone_msgs_msg_dds__Remark_>(remark_, [&](const auto& one) {
            return one.sequence_ == sequence && std::string(one.kind_) == "refused" &&
                   one.text_[0] != '\0';
          }))
        return Answer::refused;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return Answer::none;
  }

 private:
  template <class Message, class IsIt>
  static bool has(dds_entity_t reader, const IsIt& is_it) {
    bool found = false;
    for (bool some = true; some && !found;) {
      void* sample = nullptr;
      dds_sample_info_t info{};
      some = dds_take(reader, &sample, &info, 1, 1) == 1;
      if (!some) break;
      found = info.valid_data && is_it(*static_cast<const Message*>(sample));
      dds_return_loan(reader, &sample, 1);
    }
    return found;
  }
  dds_entity_t participant_ = 0, command_ = 0, step_ = 0, remark_ = 0;
};

/// What a command points to.
struct Kept {
  std::vector<std::string> names;
  std::vector<char*> pointers;
  std::vector<double> values;
  std::vector<kerbstone_msgs_msg_dds__PlanPoint_> plan;
  std::string save, state;
};

Command odd_command(sim_tests::OddCommands& odd, std::uint32_t sequence, Kept& kept) {
  const auto number = [&] { return odd.below(30) == 0 ? std::nan("") : odd.number(); };
  Command out{};
  out.sequence_ = sequence;
  out.steering_angle_ = number();
  out.throttle_ = number();
  for (double& pressure : out.brake_pressure_) pressure = 1e6 * number();
  out.gear_ = static_cast<int>(odd.below(10)) - 2;
  out.clutch_ = number();
  out.reset_ = odd.below(5) == 0;
  kept = {};
  for (std::size_t k = odd.below(3); k > 0; --k) {
    kept.names.push_back(odd.below(2) == 0 ? "start.speed" : odd.name());
    kept.values.push_back(number());
  }
  for (std::string& name : kept.names) kept.pointers.push_back(name.data());
  const auto count = static_cast<std::uint32_t>(kept.names.size());
  auto& names = out.reset_ ? out.start_names_ : out.names_;
  auto& values = out.reset_ ? out.start_values_ : out.values_;
  names = {count, count, kept.pointers.data(), false};
  values = {count, odd.below(20) == 0 ? 0 : count, kept.values.data(), false};
  kept.plan.resize(odd.below(40) == 0 ? 501 : odd.below(3));
  const auto points = static_cast<std::uint32_t>(kept.plan.size());
  out.plan_ = {points, points, kept.plan.data(), false};
  if (odd.below(20) == 0) kept.save = odd.below(2) == 0 ? std::string(70, 'x') : "here";
  if (odd.below(20) == 0) kept.state = odd.below(2) == 0 ? "nowhere" : "here";
  out.save_ = kept.save.data();
  out.state_ = kept.state.data();
  return out;
}

void answer_each(std::uint32_t count) {
  const support::TemporaryFolder folder;
  int status = -1;
  std::thread serves([&] {
    status = std::system(
        fmt::format(
            "timeout 500 '{}' serve '{}/vehicles/open_wheel/vehicle.yaml' --dds --domain {} "
            "--lockstep --every 5 --stop-s 100000 --command parameter.environment.road_grip "
            "-o '{}' > '{}' 2>&1",
            places::crgsim(), places::source(), places::own_domain(), folder.path("run.csv"),
            folder.path("said"))
            .c_str());
  });
  std::uint32_t refused = 0, taken = 0, sequence = 1;
  {
    const Peer peer;
    Command command{};
    std::string none;
    command.save_ = command.state_ = none.data();
    command.gear_ = 1;
    command.sequence_ = sequence;
    Peer::Answer first = Peer::Answer::none;
    for (int tries = 0; tries < 60 && first == Peer::Answer::none; ++tries) {  // until it is heard
      peer.say(command);
      first = peer.answer(sequence, 0.5);
    }
    EXPECT_EQ(first, Peer::Answer::taken);
    sim_tests::OddCommands odd(11);
    Kept kept;
    for (std::uint32_t k = 0; first != Peer::Answer::none && k < count; ++k) {
      peer.say(odd_command(odd, ++sequence, kept));
      const Peer::Answer answer = peer.answer(sequence, 10.0);
      if (answer == Peer::Answer::none) {
        ADD_FAILURE() << "no answer to the command " << k;
        break;
      }
      ++(answer == Peer::Answer::taken ? taken : refused);
    }
    command.sequence_ = ++sequence;
    EXPECT_TRUE(peer.answer((peer.say(command), sequence), 10.0) == Peer::Answer::taken);
    command.sequence_ = ++sequence;
    command.end_ = true;
    peer.say(command);
    serves.join();
  }
  EXPECT_GT(refused, count / 10);
  EXPECT_GT(taken, count / 10);
  EXPECT_THAT(folder.read("said"), ::testing::HasSubstr("by a command"));
  EXPECT_EQ(status & 0x7f, 0);
}

TEST(OddCommandsByDds, EachIsAnsweredAndTheRunGoesOn) { answer_each(300); }

TEST(SlowOddCommandsByDds, TenThousandAreAnsweredAndTheRunGoesOn) { answer_each(10'000); }

}  // namespace odd_commands_dds_test
#endif
