#include "real_time.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdint>

namespace sim {

double now_s() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void sleep_until(double time_s) {
  timespec until{};
  until.tv_sec = static_cast<time_t>(std::floor(time_s));
  until.tv_nsec = static_cast<long>(1e9 * (time_s - std::floor(time_s)));
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

RealTime::RealTime() : latency_(::open("/dev/cpu_dma_latency", O_RDWR | O_CLOEXEC)) {
  sched_param priority{};
  priority.sched_priority = 10;
  is_scheduled_ = ::sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
  if (is_scheduled_) ::mlockall(MCL_CURRENT);
  const std::int32_t none = 0;  // microseconds to wake up
  if (latency_ >= 0 && ::write(latency_, &none, sizeof none) != sizeof none) close();
}

void RealTime::close() {
  if (latency_ >= 0) ::close(latency_);
  latency_ = -1;
}

}  // namespace sim
