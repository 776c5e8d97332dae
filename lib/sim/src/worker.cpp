#include "worker.h"

#include <utility>

namespace sim {

Worker::Worker()
    : thread_([this] {
        std::unique_lock lock(mutex_);
        for (;;) {
          given_.wait(lock, [this] { return ends_ || !waiting_.empty(); });
          if (ends_) return;
          const std::function<void()> work = std::move(waiting_.front());
          waiting_.pop_front();
          lock.unlock();
          work();
          lock.lock();
        }
      }) {}

Worker::~Worker() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  given_.notify_one();
  thread_.join();
}

void Worker::give(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(work));
  }
  given_.notify_one();
}

}  // namespace sim
