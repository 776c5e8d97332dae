#include "base/growing_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <vector>

#include "base/error.h"
#include "unfinished.h"
#include "write_target.h"

namespace base {
namespace {

/// Under unfinished_guard().
std::vector<GrowingFile*>& growing() {
  static auto& list = *new std::vector<GrowingFile*>;  // the watching thread may outlive main
  return list;
}

/// "out/drive.csv" as "out/drive.partial.csv".
std::string with_word(const std::string& path, const std::string& word) {
  const std::filesystem::path whole(path);
  const std::string extension = whole.extension().string();
  return path.substr(0, path.size() - extension.size()) + word + extension;
}

/// Without what follows the last end of a line.
void cut_to_lines(int file) {
  struct stat status {};
  if (::fstat(file, &status) != 0) return;
  std::int64_t end = status.st_size;
  for (char last = 0; end > 0; --end)
    if (::pread(file, &last, 1, end - 1) != 1 || last == '\n') break;
  if (end < status.st_size && ::ftruncate(file, end) != 0) return;
}

}  // namespace

GrowingFile::GrowingFile(const std::string& path) : path_(path) {
  const Target target = find_target(path);
  final_path_ = target.path;
  if (target.through) {
    descriptor_ = open_through(target, path_);
    return;
  }
  partial_path_ = with_word(final_path_, ".partial");
  const std::lock_guard lock(unfinished_guard());
  growing().push_back(this);
  const int left = ::open(partial_path_.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC);
  if (left < 0) return;
  const bool is_free = ::flock(left, LOCK_EX | LOCK_NB) == 0;
  const std::string killed = with_word(final_path_, ".killed");
  if (is_free) cut_to_lines(left);
  if (is_free && ::rename(partial_path_.c_str(), killed.c_str()) == 0) killed_ = killed;
  ::close(left);
  if (is_free) return;
  std::erase(growing(), this);
  throw Error(fmt::format("{}: another process writes it; name another file", path));
}

GrowingFile::~GrowingFile() {
  const std::lock_guard lock(unfinished_guard());
  take_name();
}

void GrowingFile::open() {
  struct stat old {};
  const bool is_there = ::stat(final_path_.c_str(), &old) == 0;
  descriptor_ = ::open(partial_path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail_to_write(path_, "cannot create a file in this folder");
  ::flock(descriptor_, LOCK_EX | LOCK_NB);
  if (is_there && ::fchmod(descriptor_, old.st_mode & 07777) != 0)
    fail_to_write(path_, "cannot set the permissions");
  if (is_there) ::unlink(final_path_.c_str());
}

void GrowingFile::append(std::string_view lines) {
  const std::lock_guard lock(unfinished_guard());
  if (descriptor_ < 0) open();
  const auto end = size_ + static_cast<std::int64_t>(lines.size());
  while (!lines.empty()) {
    const ssize_t written = ::write(descriptor_, lines.data(), lines.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int reason = errno;
      if (!partial_path_.empty() && ::ftruncate(descriptor_, size_) != 0) errno = reason;
      fail_to_write(path_, "cannot write", reason);
    }
    lines.remove_prefix(static_cast<std::size_t>(written));
  }
  size_ = end;
}

void GrowingFile::take_name() noexcept {
  if (is_finished_) return;
  is_finished_ = true;
  if (descriptor_ >= 0 && !partial_path_.empty())
    ::rename(partial_path_.c_str(), final_path_.c_str());
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  std::erase(growing(), this);
}

void GrowingFile::finish() {
  const std::lock_guard lock(unfinished_guard());
  if (descriptor_ >= 0 && !partial_path_.empty() && ::fsync(descriptor_) != 0)
    fail_to_write(path_, "cannot flush to disk");
  if (!is_finished_ && descriptor_ < 0) ::unlink(final_path_.c_str());
  take_name();
}

void finish_growing() noexcept {
  while (!growing().empty()) growing().back()->take_name();
}

}  // namespace base
