// Datagrams from and to whoever drives. Private to serve_unit.
#pragma once

#include <sys/socket.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/descriptor.h"

namespace sim {

class CommandSocket {
 public:
  static constexpr double kWatch_s = 5.0;
  static constexpr std::size_t kMostWatchers = 8;

  /// Of this machine alone: a path, or a UDP port of the loopback. Throws Error where it cannot be
  /// bound; a path that stands there is not replaced unless it is a socket that nobody listens to.
  CommandSocket(const std::string& path, std::uint16_t udp_port);

  /// The next datagram, waited for at most so long; nothing where none came.
  std::optional<std::string_view> receive(double wait_s);
  /// To the sender of the last datagram that was kept by answer_here(); lost when it is gone. Where
  /// it has not taken others yet it is waited for at most so long: false, then it is lost too.
  bool send(std::string_view bytes, double wait_s);
  /// To the sender of the last datagram; lost where that takes nothing now.
  void reply(std::string_view bytes) const;
  /// The sender of the last datagram gets copies for the next kWatch_s; of more than kMostWatchers
  /// the one that said so first is forgotten.
  void watch_here();
  bool is_watched();
  void copy(std::string_view bytes) const;
  int descriptor() const { return socket_.value; }
  void answer_here() { answer_to_ = from_, answer_size_ = from_size_; }

 private:
  base::Descriptor socket_;
  sockaddr_storage from_{}, answer_to_{};
  socklen_t from_size_ = 0, answer_size_ = 0;
  struct Watcher {
    sockaddr_storage address{};
    socklen_t size = 0;
    std::chrono::steady_clock::time_point until;
  };
  std::vector<Watcher> watchers_;
  std::string bytes_;
};

/// Removes the path of a socket when it goes.
struct SocketPath {
  std::string path;
  ~SocketPath();
};

}  // namespace sim
