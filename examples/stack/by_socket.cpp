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
  Measured exchange(const Command& values, bool ends) {
    const std::string bytes = binary_ ? as_binary(values, ends) : as_json(values, ends);
    for (int tries = 0; tries < 50;
         ++tries) {  // datagrams may be lost: said again, it is not acted on again
      ::send(socket_, bytes.data(), bytes.size(), 0);
      if (ends) return {};
      pollfd waiting{socket_, POLLIN, 0};
      if (::poll(&waiting, 1, 1000) <= 0) continue;
      std::array<char, 4096> answer{};
      const ssize_t count = ::recv(socket_, answer.data(), answer.size(), 0);
      if (count > 0)
        return binary_ ? from_binary({answer.data(), static_cast<std::size_t>(count)})
                       : from_json({answer.data(), static_cast<std::size_t>(count)});
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

  std::string as_json(const Command& values, bool ends) {
    nlohmann::json set;
    for (std::size_t i = 0; i < values.size(); ++i) set[kCommands[i]] = values[i];
    return nlohmann::json{{"sequence", ++sequence_}, {"set", set}, {"end", ends}}.dump();
  }
  std::string as_binary(const Command& values, bool ends) {
    std::string bytes = "KSC1";
    for (const std::uint32_t number :
         {++sequence_, std::uint32_t{ends}, static_cast<std::uint32_t>(values.size())})
      bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
    bytes.append(reinterpret_cast<const char*>(values.data()), sizeof values);
    return bytes;
  }
  static Measured from_json(const std::string& bytes) {
    const nlohmann::json message = nlohmann::json::parse(bytes);
    const auto value = [&](std::size_t i) {
      return message.at("values").at(kMeasured[i]).get<double>();
    };
    return {message.at("time_s"), value(0), value(1), value(2), value(3), value(4)};
  }
  static Measured from_binary(const std::string& bytes) {
    std::array<double, 1 + kMeasured.size()> values{};
    if (bytes.size() != 16 + sizeof values || !bytes.starts_with("KSM1"))
      throw std::runtime_error("no measurement of this run");
    std::memcpy(values.data(), bytes.data() + 16, sizeof values);
    return {values[0], values[1], values[2], values[3], values[4], values[5]};
  }

  bool binary_;
  std::string own_;
  int socket_;
  std::uint32_t sequence_ = 0;
};

}  // namespace

Exchange exchange_by_socket(const std::string& path, bool binary) {
  const auto connection = std::make_shared<Connection>(path, binary);
  return [connection](const Command& command, bool ends) {
    return connection->exchange(command, ends);
  };
}

}  // namespace stack
