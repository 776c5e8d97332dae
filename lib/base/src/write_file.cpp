#include "base/write_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <vector>

#include "base/error.h"
#include "unfinished.h"
#include "write_target.h"

namespace base {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".part";
constexpr std::size_t kMostName = 200;  // of 255 bytes that a name may have; the rest is ours

/// The beginning of the temporary names of this file.
std::string stem_of(const std::string& path) {
  const std::string name = path.substr(path.rfind('/') + 1);
  return "." + name.substr(0, kMostName) + ".";
}

/// PID-COUNT.
bool is_number_pair(std::string_view text) {
  const std::size_t dash = text.find('-');
  const auto digits = [](std::string_view part) {
    return !part.empty() &&
           std::all_of(part.begin(), part.end(), [](char c) { return c >= '0' && c <= '9'; });
  };
  return dash != std::string_view::npos && digits(text.substr(0, dash)) &&
         digits(text.substr(dash + 1));
}

/// Temporary files of this name whose writer was killed: nobody holds their lock.
void remove_leftovers(const std::string& folder, const std::string& stem) {
  std::error_code problem;
  for (fs::directory_iterator entry(folder, problem), end; !problem && entry != end;
       entry.increment(problem)) {
    const std::string name = entry->path().filename().string();
    if (name.size() < stem.size() + kEnding.size() || !name.starts_with(stem) ||
        !name.ends_with(kEnding) ||
        !is_number_pair(
            std::string_view(name).substr(stem.size(), name.size() - stem.size() - kEnding.size())))
      continue;
    const int file = ::open(entry->path().c_str(), O_RDWR | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC);
    if (file < 0) continue;
    struct stat status {};
    if (::fstat(file, &status) == 0 && S_ISREG(status.st_mode) &&
        ::flock(file, LOCK_EX | LOCK_NB) == 0)
      ::unlink(entry->path().c_str());
    ::close(file);
  }
}

/// A new file, locked; its name goes to `path`. -1 and errno when it cannot be made.
int create_temporary(const std::string& folder, const std::string& stem, std::string& path) {
  static std::atomic<unsigned> count{0};
  for (;;) {
    path =
        fmt::format("{}{}{}-{}{}", folder == "." ? "" : folder, stem, ::getpid(), count++, kEnding);
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0 && errno == EEXIST) continue;
    if (file < 0) return -1;
    struct stat status {};
    // Between open and flock another process may take it for a leftover and remove it: then another
    // one.
    if ((::flock(file, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) &&
        ::fstat(file, &status) == 0 && status.st_nlink > 0)
      return file;
    ::close(file);
  }
}

struct Unfinished {
  std::string path;
  bool only_if_empty = false;
};

std::vector<Unfinished>& unfinished() {
  static auto& list =
      *new std::vector<Unfinished>;  // never destroyed: the watching thread may outlive main
  return list;
}

}  // namespace

std::recursive_mutex& unfinished_guard() {
  static auto& guard = *new std::recursive_mutex;
  return guard;
}

void add_unfinished(const std::string& path) {
  unfinished().push_back({fs::absolute(path).string()});
}

void add_made_folder(const std::string& path) {
  unfinished().push_back({fs::absolute(path).string(), true});
}

void drop_unfinished(const std::string& path) {
  const std::string full = fs::absolute(path).string();
  std::erase_if(unfinished(), [&](const Unfinished& one) { return one.path == full; });
}

void abandon_writes() noexcept {
  unfinished_guard().lock();
  finish_growing();
  // The newest first, so that a folder's lock goes after all that it guards: whoever takes the lock
  // next makes things of the same names.
  for (auto one = unfinished().rbegin(); one != unfinished().rend(); ++one) {
    std::error_code ignored;
    one->only_if_empty ? fs::remove(one->path, ignored) : fs::remove_all(one->path, ignored);
  }
}

FileWriter::FileWriter(const std::string& path) : path_(path) {
  const Target target = find_target(path);
  final_path_ = target.path;
  if (target.through) {
    descriptor_ = open_through(target, path_);
    return;
  }
  const std::string folder = folder_of(final_path_), stem = stem_of(final_path_);
  remove_leftovers(folder, stem);
  const std::lock_guard lock(unfinished_guard());
  descriptor_ = create_temporary(folder, stem, temporary_path_);
  if (descriptor_ < 0) fail_to_write(path_, "cannot create a file in this folder");
  add_unfinished(temporary_path_);
}

FileWriter::~FileWriter() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (temporary_path_.empty()) return;
  const std::lock_guard lock(unfinished_guard());
  ::unlink(temporary_path_.c_str());
  drop_unfinished(temporary_path_);
}

void FileWriter::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail_to_write(path_, "cannot write");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void FileWriter::commit() {
  if (temporary_path_.empty()) {
    const int file = descriptor_;
    descriptor_ = -1;
    if (::close(file) != 0) fail_to_write(path_, "cannot write");
    return;
  }
  struct stat old {};
  if (::stat(final_path_.c_str(), &old) == 0 && ::fchmod(descriptor_, old.st_mode & 07777) != 0)
    fail_to_write(path_, "cannot set the permissions");
  if (::fsync(descriptor_) != 0) fail_to_write(path_, "cannot flush to disk");
  {
    const std::lock_guard lock(unfinished_guard());
    if (::rename(temporary_path_.c_str(), final_path_.c_str()) != 0)
      fail_to_write(path_, "cannot rename to the final name");
    drop_unfinished(temporary_path_);
    temporary_path_.clear();
  }
  // The rename itself lasts through a power cut only once the folder is flushed; a file system
  // that cannot flush a folder is no reason to fail.
  const int folder = ::open(folder_of(final_path_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {
    ::fsync(folder);
    ::close(folder);
  }
}

void write_file(const std::string& path, std::string_view bytes) {
  FileWriter file(path);
  file.append(bytes);
  file.commit();
}

void check_writable(const std::string& path) {
  const Target target = find_target(path);
  if (target.descriptor >= 0) {
    if (::fcntl(target.descriptor, F_GETFL) < 0) fail_to_write(path, "cannot write");
    return;
  }
  if (target.through && ::access(target.path.c_str(), W_OK) != 0)
    fail_to_write(path, "cannot write");
  if (!target.through && ::access(folder_of(target.path).c_str(), W_OK | X_OK) != 0)
    fail_to_write(path, "cannot create a file in this folder");
}

void check_writable_folder(const std::string& path) {
  fs::path there = fs::absolute(path).lexically_normal();
  std::error_code problem;
  while (!fs::exists(there, problem) && !problem && there.has_parent_path() &&
         there != there.parent_path())
    there = there.parent_path();
  if (problem) fail_to_write(path, "cannot make this folder", problem.value());
  if (!fs::is_directory(there, problem))
    fail_to_write(path, "cannot make this folder", problem ? problem.value() : ENOTDIR);
  if (::access(there.c_str(), W_OK | X_OK) != 0)
    fail_to_write(path, "cannot write into this folder");
}

}  // namespace base
