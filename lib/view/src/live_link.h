// The socket to a running `crgsim serve`. Private to lib/view.
#pragma once

#include <chrono>
#include <limits>
#include <string>

#include "base/descriptor.h"

namespace view {

/// A UDP port of this machine that nobody uses now.
int free_udp_port();

class LiveLink {
 public:
  /// Throws Error where there is no socket. What was heard is forgotten when nothing has come for
  /// `forgets_s`: the run has ended, and another one may begin at its port.
  explicit LiveLink(int port, double forgets_s = std::numeric_limits<double>::infinity());

  /// Sends a command as it is and gives the newest measurement that has come, without waiting;
  /// empty: none yet, or forgotten. What was seen of the road and planned since the last time is in
  /// it, a list "sights", of at most kMostSights datagrams. What nobody hears is lost, as datagrams
  /// are.
  std::string tell(const std::string& command);
  static constexpr std::size_t kMostSights = 200;

 private:
  base::Descriptor socket_;
  double forgets_s_;
  std::chrono::steady_clock::time_point heard_;
  std::string newest_;
};

}  // namespace view
