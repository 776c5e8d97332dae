// Clock and scheduling of a loop in real time. Private to serve_unit.
#pragma once

#include <atomic>
#include <thread>

namespace sim {

double now_s();  ///< of a clock that nobody sets
void sleep_until(double time_s);

/// What keeps this thread on time, as far as this user may: scheduled before all others, on one
/// processor, its memory held, and that processor kept from sleeping by a thread that runs only
/// where nobody else wants to. A processor of a virtual machine that sleeps is given away, and
/// comes back up to 40 ms late; more of them awake than needed use up what the machine is allowed,
/// and it is stopped for a while.
class RealTime {
 public:
  RealTime();
  ~RealTime();
  RealTime(const RealTime&) = delete;
  RealTime& operator=(const RealTime&) = delete;

  bool is_scheduled() const { return is_scheduled_; }

 private:
  std::atomic<bool> ends_ = false;
  bool is_scheduled_ = false;
  std::thread awake_;
};

}  // namespace sim
