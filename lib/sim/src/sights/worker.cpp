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
          is_busy_ = true;
          lock.unlock();
          work();
          lock.lock();
          is_busy_ = false;
          if (waiting_.empty()) done_.notify_all();
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

void Worker::finish() {
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return waiting_.empty() && !is_busy_; });
}

}  // namespace sim
