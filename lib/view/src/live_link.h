// The socket to a running `crgsim serve`. Private to lib/view.
#pragma once

#include <chrono>
#include <limits>
#include <memory>
#include <mutex>
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

/// The drive of a job and the run that is watched, one of each; from any thread.
class LiveLinks {
 public:
  void drive(int job, int port);
  /// As LiveLink::tell(). Throws Refusal where this job is not the drive that was begun last.
  std::string tell(int job, const std::string& command);
  /// What somebody else drives at a UDP port of this machine. Throws Refusal: no port.
  std::string watch(int port);

 private:
  std::mutex mutex_;
  std::unique_ptr<LiveLink> driven_, watched_;
  int job_ = 0, watched_port_ = 0;
};

}  // namespace view
