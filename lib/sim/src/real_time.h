// Clock and scheduling of a loop in real time. Private to serve_unit.
#pragma once

namespace sim {

double now_s();  ///< of a clock that nobody sets
void sleep_until(double time_s);

/// What keeps a thread of 1 kHz on time, as far as this user may: scheduled before all others, its
/// memory held, and the processors kept from sleeping (those of a virtual machine that sleep are
/// given away, and come back up to 40 ms late).
class RealTime {
 public:
  RealTime();
  ~RealTime() { close(); }
  RealTime(const RealTime&) = delete;
  RealTime& operator=(const RealTime&) = delete;

  bool is_scheduled() const { return is_scheduled_; }

 private:
  void close();

  int latency_;
  bool is_scheduled_ = false;
};

}  // namespace sim
