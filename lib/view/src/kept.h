// What was read of files, kept as long as these stay the same. Private to lib/view.
#pragma once

#include <fmt/format.h>

#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

namespace view {

/// The values of the `most` files that were asked for last; from any thread. A file is read again
/// when its size or its time has changed.
template <class Value, std::size_t most = 4>
class Kept {
 public:
  explicit Kept(std::function<Value(const std::string& path)> read) : read_(std::move(read)) {}

  std::shared_ptr<const Value> of(const std::string& path) {
    const std::lock_guard lock(mutex_);
    std::error_code unknown;
    const std::string mark =
        fmt::format("{} {} {}", path, std::filesystem::file_size(path, unknown),
                    std::filesystem::last_write_time(path, unknown).time_since_epoch().count());
    for (const auto& [known, value] : values_)
      if (known == mark) return value;
    auto value = std::make_shared<const Value>(read_(path));
    values_.emplace_back(mark, value);
    if (values_.size() > most) values_.pop_front();
    return value;
  }

 private:
  std::function<Value(const std::string& path)> read_;
  std::mutex mutex_;
  std::deque<std::pair<std::string, std::shared_ptr<const Value>>> values_;
};

}  // namespace view
