#include "base/read_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/descriptor.h"
#include "base/error.h"
#include "base/stand_in.h"

namespace base {
namespace {

Refusal cannot_read(const std::string& path, const char* what) {
  return Refusal(fmt::format("{}: {}: {}", path, what, std::strerror(errno)));
}

std::optional<Refusal> no_file(const std::string& path, const struct stat& status) {
  if (S_ISDIR(status.st_mode)) return Refusal(path + ": is a folder, wanted a file");
  if (!S_ISREG(status.st_mode))
    return Refusal(path + ": is a device, a FIFO or a socket, wanted a regular file");
  return std::nullopt;
}

}  // namespace

std::optional<Refusal> no_regular_file(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return no_file(path, status);
}

void want_regular_file(const std::string& path) {
  if (const auto refused = no_regular_file(path)) throw Error(refused->message);
}

Answer<std::string> try_read_file(const std::string& path, std::size_t largest_bytes) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (file.value < 0) return cannot_read(path, "cannot open");
  struct stat status {};
  if (::fstat(file.value, &status) != 0) return cannot_read(path, "cannot read");
  if (auto refused = no_file(path, status)) return *std::move(refused);
  const auto too_large = [&](std::size_t seen, const char* more) {
    return Refusal(
        fmt::format("{}: {}{} bytes, wanted at most {}, the most such a file can need; look "
                    "whether it is the file that was meant",
                    path, more, seen, largest_bytes));
  };
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > largest_bytes) return too_large(size, "");
  std::string bytes;
  bytes.reserve(size);
  char block[1 << 16];
  for (;;) {
    const ssize_t count = ::read(file.value, block, sizeof block);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return cannot_read(path, "cannot read");
    if (count == 0) break;
    bytes.append(block, static_cast<std::size_t>(count));
    if (bytes.size() > largest_bytes) return too_large(largest_bytes, "more than ");  // grown
  }
  if (auto refused = lfs_pointer(bytes, path)) return *std::move(refused);
  return bytes;
}

std::string read_file(const std::string& path, std::size_t largest_bytes) {
  return try_read_file(path, largest_bytes).or_throw();
}

}  // namespace base
