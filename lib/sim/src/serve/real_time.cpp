#include "real_time.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>

#include <cerrno>
#include <cmath>

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

namespace {

/// The last of those that this process may use: the first has most interrupts.
cpu_set_t last_processor() {
  cpu_set_t allowed, one;
  CPU_ZERO(&allowed);
  CPU_ZERO(&one);
  ::sched_getaffinity(0, sizeof allowed, &allowed);
  for (int k = CPU_SETSIZE - 1; k >= 0 && CPU_COUNT(&one) == 0; --k)
    if (CPU_ISSET(k, &allowed)) CPU_SET(k, &one);
  return one;
}

bool schedule(pthread_t thread, int policy, int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return ::pthread_setschedparam(thread, policy, &parameters) == 0;
}

}  // namespace

RealTime::RealTime() {
  const cpu_set_t processor = last_processor();
  awake_ = std::thread([this, processor] {
    ::sched_setaffinity(0, sizeof processor, &processor);
    if (!schedule(::pthread_self(), SCHED_IDLE, 0)) return;
    while (!ends_.load(std::memory_order_relaxed)) {
    }
  });
  // Before it is scheduled: it takes a while, and other loops of this machine are on time.
  ::mlockall(MCL_CURRENT);
  is_scheduled_ = schedule(::pthread_self(), SCHED_FIFO, 10);
  ends_ = !is_scheduled_;
  if (!is_scheduled_) ::munlockall();
  if (is_scheduled_) ::sched_setaffinity(0, sizeof processor, &processor);
}

RealTime::~RealTime() {
  ends_ = true;
  // Else it would see this when nobody wants the processor.
  schedule(awake_.native_handle(), SCHED_OTHER, 0);
  awake_.join();
}

}  // namespace sim
