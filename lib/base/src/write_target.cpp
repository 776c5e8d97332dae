#include "write_target.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <charconv>
#include <cstring>
#include <filesystem>

#include "base/error.h"

namespace base {
namespace {

namespace fs = std::filesystem;

constexpr int kMostLinks = 40;  // the kernel's limit

/// N where `path` is /proc/<this process>/fd/N.
int own_descriptor(const std::string& path) {
  const std::string folder = fmt::format("/proc/{}/fd/", ::getpid());
  if (!path.starts_with(folder)) return -1;
  int number = -1;
  const char* end = path.data() + path.size();
  const auto [at, problem] = std::from_chars(path.data() + folder.size(), end, number);
  return problem == std::errc() && at == end ? number : -1;
}

}  // namespace

void fail_to_write(const std::string& path, const char* what, int reason) {
  throw Error(fmt::format("{}: {}: {}; choose a folder that exists, is writable and has free space",
                          path, what, std::strerror(reason)));
}

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : path.substr(0, slash + 1);
}

Target find_target(const std::string& path) {
  if (path == "-") return {STDOUT_FILENO, path, true};
  fs::path at = path;
  for (int links = 0; links < kMostLinks; ++links) {
    std::error_code problem;
    const fs::path folder =
        fs::canonical(at.parent_path().empty() ? "." : at.parent_path(), problem);
    if (problem) fail_to_write(path, "cannot create a file in this folder", problem.value());
    const std::string full = (folder / at.filename()).string();
    // What descriptor N is cannot always be opened again by name, and has its place in the file.
    if (const int own = own_descriptor(full); own >= 0) return {own, path, true};
    struct stat status {};
    if (::lstat(full.c_str(), &status) != 0) {
      if (errno == ENOENT && !at.filename().empty()) return {-1, links == 0 ? path : full, false};
      fail_to_write(path, "cannot create this file");
    }
    if (S_ISLNK(status.st_mode)) {
      const fs::path next = fs::read_symlink(full, problem);
      if (problem) fail_to_write(path, "cannot follow this link", problem.value());
      at = next.is_absolute() ? next : folder / next;
      continue;
    }
    if (S_ISDIR(status.st_mode))
      throw Error(fmt::format("{}: is a folder; give the name of a file", path));
    if (S_ISBLK(status.st_mode) || S_ISSOCK(status.st_mode))
      throw Error(fmt::format("{}: is a {}; give the name of a file", path,
                              S_ISBLK(status.st_mode) ? "block device" : "socket"));
    return {-1, links == 0 ? path : full, !S_ISREG(status.st_mode)};
  }
  fail_to_write(path, "cannot follow this link", ELOOP);
}

int open_through(const Target& target, const std::string& path) {
  const int descriptor = target.descriptor >= 0 ? ::fcntl(target.descriptor, F_DUPFD_CLOEXEC, 0)
                                                : ::open(target.path.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) fail_to_write(path, "cannot open");
  return descriptor;
}

}  // namespace base
