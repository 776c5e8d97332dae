// The socket to a running `crgsim serve`. Private to lib/view.
#pragma once

#include <string>

#include "base/descriptor.h"

namespace view {

/// A UDP port of this machine that nobody uses now.
int free_udp_port();

class LiveLink {
 public:
  /// Throws Error where there is no socket.
  explicit LiveLink(int port);

  /// Sends a command as it is and gives the newest measurement that has come, without waiting;
  /// empty: none yet. What was seen of the road and planned since the last time is in it, a list
  /// "sights", of at most kMostSights datagrams. What nobody hears is lost, as datagrams are.
  std::string tell(const std::string& command);
  static constexpr std::size_t kMostSights = 200;

 private:
  base::Descriptor socket_;
  std::string newest_;
};

}  // namespace view
