#include "read_ahead.h"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace cloud {
namespace {

/// Nobody wants more.
struct Stopped {};

/// Room for one chunk between the thread that reads and the one that takes.
class Desk {
 public:
  void put(Cloud&& chunk) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !chunk_ || stopped_; });
    if (stopped_) throw Stopped();
    chunk_ = std::move(chunk);
    changed_.notify_all();
  }
  /// Empty once there are no more.
  std::optional<Cloud> take() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return chunk_ || ended_; });
    changed_.notify_all();
    return std::exchange(chunk_, std::nullopt);
  }
  void end() { set(ended_); }
  void stop() { set(stopped_); }

 private:
  void set(bool& what) {
    const std::lock_guard lock(mutex_);
    what = true;
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Cloud> chunk_;
  bool ended_ = false, stopped_ = false;
};

}  // namespace

CloudSource read_ahead(CloudSource source, unsigned threads) {
  if (threads == 0) threads = std::thread::hardware_concurrency();
  if (threads < 2) return source;
  return [source = std::move(source)](const ChunkSink& sink) {
    Desk desk;
    std::exception_ptr error;
    std::thread reader([&] {
      try {
        source([&](Cloud&& chunk) { desk.put(std::move(chunk)); });
      } catch (const Stopped&) {
      } catch (...) {
        error = std::current_exception();
      }
      desk.end();
    });
    try {
      while (std::optional<Cloud> chunk = desk.take()) sink(std::move(*chunk));
    } catch (...) {
      desk.stop();
      reader.join();
      throw;
    }
    reader.join();
    if (error) std::rethrow_exception(error);
  };
}

}  // namespace cloud
