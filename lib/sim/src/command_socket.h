// Datagrams from and to whoever drives. Private to serve_unit.
#pragma once

#include <sys/socket.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/descriptor.h"

namespace sim {

class CommandSocket {
 public:
  /// Of this machine alone: a path, or a UDP port of the loopback. Throws Error where it cannot be
  /// bound; a path that stands there is not replaced unless it is a socket that nobody listens to.
  CommandSocket(const std::string& path, std::uint16_t udp_port);

  /// The next datagram, waited for at most so long; nothing where none came.
  std::optional<std::string_view> receive(double wait_s);
  /// To the sender of the last datagram that was kept by answer_here(); lost when it is gone.
  void send(std::string_view bytes);
  void answer_here() { answer_to_ = from_, answer_size_ = from_size_; }

 private:
  base::Descriptor socket_;
  sockaddr_storage from_{}, answer_to_{};
  socklen_t from_size_ = 0, answer_size_ = 0;
  std::string bytes_;
};

/// Removes the path of a socket when it goes.
struct SocketPath {
  std::string path;
  ~SocketPath();
};

}  // namespace sim
