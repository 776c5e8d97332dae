#include "socket_connection.h"

#include <memory>
#include <variant>

#include "base/error.h"
#include "sim/message.h"

namespace sim {
namespace {

constexpr double kLongestSendWait_s = 10.0;
constexpr std::string_view kWatch = R"({"watch": true})";

struct Form {
  bool received_is_binary = false, answered_is_binary = false;
};

}  // namespace

Connection connection_by(CommandSocket& socket, const ServeOptions& options) {
  const auto form = std::make_shared<Form>();
  const bool waits = options.lockstep && !options.devices.road.empty();
  const auto send = [&socket, waits](const std::string& bytes) {
    if (!socket.send(bytes, waits ? kLongestSendWait_s : 0.0) && waits)
      throw base::Error("the program that drives did not take its messages for 10 s");
  };
  Connection out;
  out.receive = [&socket, &options, form](double wait_s) -> std::optional<Received> {
    const std::optional<std::string_view> bytes = socket.receive(wait_s);
    if (!bytes) return std::nullopt;
    Received received;
    if (bytes == kWatch) {
      socket.watch_here();
      received.watches = true;
      return received;
    }
    received.command = read_command(*bytes, options.commands, received.why);
    received.sequence = received.command ? received.command->sequence : sequence_of(*bytes);
    form->received_is_binary = is_binary(*bytes);
    return received;
  };
  out.answer_here = [&socket, form] {
    form->answered_is_binary = form->received_is_binary;
    socket.answer_here();
  };
  out.refuse = [&socket, form](const Remark& remark) {
    socket.reply(write_remark(remark, form->received_is_binary));
  };
  out.send = [&socket, &options, form, send](const MeasurementMessage& message, bool) {
    send(write_measurement(message, options.measurements, form->answered_is_binary));
    if (socket.is_watched()) socket.copy(write_measurement(message, options.measurements, false));
  };
  out.show = [&socket, form, send](const ToldSight& seen) {
    // Whoever drives knows its plan.
    const bool is_sent = !std::holds_alternative<Plan>(seen.sight);
    if (is_sent && form->answered_is_binary)
      for (const std::string& bytes : write_sight(seen.sight, true, kLongestMessage)) send(bytes);
    if (is_sent && !form->answered_is_binary)
      for (const std::string& bytes : seen.json) send(bytes);
    if (socket.is_watched())
      for (const std::string& bytes : seen.json) socket.copy(bytes);
  };
  return out;
}

}  // namespace sim
