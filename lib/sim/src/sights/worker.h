// One thread that does work in order, beside a loop that must not wait. Private to lib/sim.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace sim {

class Worker {
 public:
  Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker();  ///< ends what is being done, and forgets what waits

  /// Done later, after what was given before. `work` must not throw.
  void give(std::function<void()> work);
  void finish();  ///< waits until all that was given is done

 private:
  std::mutex mutex_;
  std::condition_variable given_, done_;
  std::deque<std::function<void()>> waiting_;
  bool ends_ = false, is_busy_ = false;
  std::thread thread_;
};

}  // namespace sim
