#include "text_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>

#include "vehicle/error.h"
#include "vehicle/write_file.h"

namespace vehicle {
namespace {

[[noreturn]] void fail(const std::string& path, const char* what) {
  throw Error(fmt::format("{}: {}: {}", path, what, std::strerror(errno)));
}

/// Closes on every way out.
struct Descriptor {
  int value = -1;
  explicit Descriptor(int opened) : value(opened) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
};

}  // namespace

std::string read_text(const std::string& path, std::size_t largest_bytes) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.value < 0) fail(path, "cannot open");
  struct stat status {};
  if (::fstat(file.value, &status) != 0) fail(path, "cannot read");
  if (S_ISDIR(status.st_mode)) throw Error(path + ": is a folder, wanted a file");
  std::string text;
  char block[1 << 16];
  for (;;) {
    const ssize_t count = ::read(file.value, block, sizeof block);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(path, "cannot read");
    if (count == 0) return text;
    text.append(block, static_cast<std::size_t>(count));
    if (text.size() > largest_bytes)
      throw Error(fmt::format("{}: larger than {} bytes, the most such a file can need", path,
                              largest_bytes));
  }
}

void write_file(const std::string& path, std::string_view bytes) {
  std::string temporary = path + ".XXXXXX";
  Descriptor file(::mkstemp(temporary.data()));
  if (file.value < 0) fail(path, "cannot create a file in this folder");
  const auto fail_clean = [&](const char* what) {
    const int reason = errno;
    ::unlink(temporary.c_str());
    errno = reason;
    fail(path, what);
  };
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.value, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail_clean("cannot write");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  // mkstemp makes 0600; a result is for everybody whom the umask lets.
  const mode_t mask = ::umask(022);
  ::umask(mask);
  if (::fchmod(file.value, 0666 & ~mask) != 0) fail_clean("cannot set the permissions");
  if (::fsync(file.value) != 0) fail_clean("cannot flush to disk");
  if (::rename(temporary.c_str(), path.c_str()) != 0) fail_clean("cannot rename to the final name");
}

}  // namespace vehicle
