// The stack over a Unix datagram socket, in both forms of the messages (docs/crgsim.md).
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "connection.h"

namespace stack {
namespace {

// What crgsim serve was told by --command and --measure, in this order.
constexpr std::array kCommands{"input.steering", "input.throttle", "input.brake.fl",
                               "input.brake.fr", "input.brake.rl", "input.brake.rr",
                               "input.gear"};
constexpr std::array kMeasured{"gnss.x", "gnss.y", "gnss.x.age_s", "imu.yaw_rate", "wheels.vx"};

class Connection {
 public:
  Connection(const std::string& path, bool binary)
      : binary_(binary), own_(path + ".stack"), socket_(::socket(AF_UNIX, SOCK_DGRAM, 0)) {
    ::unlink(own_.c_str());
    const sockaddr_un mine = address(own_), theirs = address(path);
    if (::bind(socket_, reinterpret_cast<const sockaddr*>(&mine), sizeof mine) != 0 ||
        ::connect(socket_, reinterpret_cast<const sockaddr*>(&theirs), sizeof theirs) != 0)
      throw std::runtime_error(path + ": " + std::strerror(errno));
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() {
    ::close(socket_);
    ::unlink(own_.c_str());
  }

  /// One command, and the measurement that answers it.
  Measured exchange(const Command& values, const Plan& plan, bool ends) {
    const std::string bytes = binary_ ? as_binary(values, plan, ends) : as_json(values, plan, ends);
    for (int tries = 0; tries < 50;
         ++tries) {  // datagrams may be lost: said again, it is not acted on again
      ::send(socket_, bytes.data(), bytes.size(), 0);
      if (ends) return {};
      pollfd waiting{socket_, POLLIN, 0};
      while (::poll(&waiting, 1, 1000) > 0) {
        const ssize_t count = ::recv(socket_, answer_.data(), answer_.size(), 0);
        if (count <= 0) break;
        const std::string answer(answer_.data(), static_cast<std::size_t>(count));
        // What sensors see of the road comes before; this stack has no use for it.
        if (answer.starts_with("KSS1") || answer.starts_with("KSE1") ||
            answer.starts_with("{\"scan\"") || answer.starts_with("{\"edges\""))
          continue;
        // What answers a command that was said again may come twice.
        if (const auto measured = binary_ ? from_binary(answer) : from_json(answer))
          return *measured;
      }
    }
    throw std::runtime_error("no measurement comes");
  }

 private:
  static sockaddr_un address(const std::string& path) {
    sockaddr_un out{};
    out.sun_family = AF_UNIX;
    if (path.size() >= sizeof out.sun_path) throw std::runtime_error(path + ": too long");
    std::copy(path.begin(), path.end(), out.sun_path);
    return out;
  }

  std::string as_json(const Command& values, const Plan& plan, bool ends) {
    nlohmann::json set;
    for (std::size_t i = 0; i < values.size(); ++i) set[kCommands[i]] = values[i];
    nlohmann::json command{{"sequence", ++sequence_}, {"set", set}, {"end", ends}};
    if (!plan.empty()) command["plan"] = plan;
    return command.dump();
  }
  std::string as_binary(const Command& values, const Plan& plan, bool ends) {
    std::string bytes = "KSC1";
    for (const std::uint32_t number : {++sequence_, (ends ? 1u : 0u) | (plan.empty() ? 0u : 8u),
                                       static_cast<std::uint32_t>(values.size())})
      bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
    bytes.append(reinterpret_cast<const char*>(values.data()), sizeof values);
    if (plan.empty()) return bytes;
    const auto count = static_cast<std::uint32_t>(plan.size());
    bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
    bytes.append(reinterpret_cast<const char*>(plan.data()), count * sizeof plan[0]);
    return bytes;
  }
  /// Nothing: the answer to another command.
  std::optional<Measured> from_json(const std::string& bytes) const {
    const nlohmann::json message = nlohmann::json::parse(bytes);
    if (message.at("sequence") != sequence_) return std::nullopt;
    const auto value = [&](std::size_t i) {
      return message.at("values").at(kMeasured[i]).get<double>();
    };
    return Measured{message.at("time_s"), value(0), value(1), value(2), value(3), value(4)};
  }
  std::optional<Measured> from_binary(const std::string& bytes) const {
    std::array<double, 1 + kMeasured.size()> values{};
    if (bytes.size() != 16 + sizeof values || !bytes.starts_with("KSM1"))
      throw std::runtime_error("no measurement of this run");
    std::uint32_t sequence = 0;
    std::memcpy(&sequence, bytes.data() + 4, sizeof sequence);
    if (sequence != sequence_) return std::nullopt;
    std::memcpy(values.data(), bytes.data() + 16, sizeof values);
    return Measured{values[0], values[1], values[2], values[3], values[4], values[5]};
  }

  bool binary_;
  std::string own_;
  int socket_;
  std::vector<char> answer_ = std::vector<char>(65536);
  std::uint32_t sequence_ = 0;
};

}  // namespace

Exchange exchange_by_socket(const std::string& path, bool binary) {
  const auto connection = std::make_shared<Connection>(path, binary);
  return [connection](const Command& command, const Plan& plan, bool ends) {
    return connection->exchange(command, plan, ends);
  };
}

}  // namespace stack
