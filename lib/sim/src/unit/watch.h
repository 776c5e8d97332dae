// Whether a unit is at work, for the process that looks after it. Private to lib/sim.
#pragma once

#include <atomic>
#include <cstdint>

namespace sim {

/// In memory that both processes have.
struct Watch {
  enum Kind : std::uint32_t { kOutside = 0, kStep = 1, kStart = 2, kKinds = 3 };
  std::atomic<std::uint32_t> now{kOutside};  ///< the kind of call; above it a count of calls
};

/// While it lives, a call of the unit is under way; within another call it does nothing.
class InUnit {
 public:
  InUnit(Watch* watch, Watch::Kind kind) : watch_(watch) {
    if (watch_ == nullptr) return;
    const std::uint32_t before = watch_->now.load(std::memory_order_relaxed);
    if ((before & Watch::kKinds) == Watch::kOutside)
      watch_->now.store((before + Watch::kKinds + 1) | kind, std::memory_order_relaxed);
    else
      watch_ = nullptr;
  }
  InUnit(const InUnit&) = delete;
  InUnit& operator=(const InUnit&) = delete;
  ~InUnit() {
    if (watch_ == nullptr) return;
    const std::uint32_t now = watch_->now.load(std::memory_order_relaxed);
    watch_->now.store(now & ~std::uint32_t{Watch::kKinds}, std::memory_order_relaxed);
  }

 private:
  Watch* watch_;
};

}  // namespace sim
