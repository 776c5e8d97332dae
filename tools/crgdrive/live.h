// A run to watch: at a pace, and over the network.
#pragma once

#include <chrono>
#include <string>

#include "commands.h"
#include "recording/table.h"

namespace crgdrive {

/// Sends rows of telemetry while a run goes on and keeps the run to the clock.
class Live {
 public:
  /// Throws vehicle::Error when `udp` is no host:port or cannot be found.
  explicit Live(const LiveOptions& options);
  Live(const Live&) = delete;
  Live& operator=(const Live&) = delete;
  ~Live();

  bool wanted() const { return speed_up_ > 0.0 || socket_ >= 0; }

  /// The last row of the table: waits until its time has come, then sends it as one datagram of
  /// JSON, {"time_s": ..., "vx_mps": ...}, empty cells left out. That nobody listens is no error.
  void row(const recording::Table& telemetry);

 private:
  double speed_up_;
  int socket_ = -1;
  bool begun_ = false;
  double begin_s_ = 0.0;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace crgdrive
