// cpp-httplib behind bounds: it has none on lines, headers, packed or chunked bodies and slow
// senders. Private to lib/view.
#pragma once

#include <httplib.h>

#include <functional>
#include <semaphore>

#include "connection.h"

namespace view {

/// Each connection has a thread, and gives cpp-httplib only what Connection lets through.
class BoundedServer : public httplib::Server {
 public:
  /// `knows`: whether a request shows the token.
  explicit BoundedServer(std::function<bool(const httplib::Request&)> knows);
  /// As listen_after_bind(); one connection that is slow to come lets no other wait.
  bool listen_within_bounds();

 private:
  bool process_and_close_socket(socket_t socket) override;
  void answer(Connection& connection, int socket);

  std::function<bool(const httplib::Request&)> knows_;
  Crowd crowd_;
  static constexpr std::size_t kLargeBody = 65536;
  std::counting_semaphore<4> large_bodies_{4};  ///< in memory at once
};

}  // namespace view
