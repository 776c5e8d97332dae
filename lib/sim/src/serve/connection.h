// Whoever drives, however it is heard. Private to serve_unit.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "sim/message.h"
#include "sim/sights.h"

namespace sim {

struct Received {
  std::optional<CommandMessage> command;
  std::string why;                             ///< there is no command
  std::optional<std::uint32_t> sequence = {};  ///< that it has all the same
  bool watches = false;                        ///< no command either: a wish to hear copies
};

struct Connection {
  /// The next message, waited for at most so long; nothing where none came.
  std::function<std::optional<Received>(double wait_s)> receive;
  /// From now on measurements go to the sender of the last message.
  std::function<void()> answer_here;
  /// To the sender of the last message, of which nothing was taken.
  std::function<void(const Remark& remark)> refuse;
  /// `again`: the same as the last one.
  std::function<void(const MeasurementMessage& message, bool again)> send;
  /// What was seen, or is planned, before the measurement that belongs to it.
  std::function<void(const ToldSight& seen)> show;
};

}  // namespace sim
