// What was read of files, kept as long as these stay the same. Private to lib/view.
#pragma once

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

namespace view {

/// Differs once a file was replaced or written, whatever became of its size and time: nobody sets
/// back the time of the last change of a file (ctime).
inline std::string mark_of(const std::string& path) {
  struct stat seen {};
  if (::stat(path.c_str(), &seen) != 0) return {};
  return fmt::format("{} {} {} {}.{} {}.{}", seen.st_dev, seen.st_ino, seen.st_size,
                     seen.st_mtim.tv_sec, seen.st_mtim.tv_nsec, seen.st_ctim.tv_sec,
                     seen.st_ctim.tv_nsec);
}

/// The values of the `most` files that were asked for last; from any thread. A file is read again
/// when mark_of() differs.
template <class Value, std::size_t most = 4>
class Kept {
 public:
  explicit Kept(std::function<Value(const std::string& path)> read) : read_(std::move(read)) {}

  std::shared_ptr<const Value> of(const std::string& path) {
    const std::lock_guard lock(mutex_);
    const std::string mark = mark_of(path);
    const auto there = std::find_if(files_.begin(), files_.end(),
                                    [&](const File& file) { return file.path == path; });
    if (there != files_.end() && there->mark == mark) {
      std::rotate(there, there + 1, files_.end());
      return files_.back().value;
    }
    if (there != files_.end()) files_.erase(there);
    files_.push_back({path, mark, std::make_shared<const Value>(read_(path))});
    if (files_.size() > most) files_.pop_front();
    return files_.back().value;
  }

 private:
  struct File {
    std::string path, mark;
    std::shared_ptr<const Value> value;
  };
  std::function<Value(const std::string& path)> read_;
  std::mutex mutex_;
  std::deque<File> files_;  ///< the one that was asked for last at the end
};

}  // namespace view
