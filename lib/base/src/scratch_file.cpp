#include "base/scratch_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <mutex>

#include "base/error.h"
#include "unfinished.h"

namespace base {

ScratchFile::ScratchFile(const std::string& path) : path_(path) {
  const std::lock_guard guard(unfinished_guard());  // nobody interrupts while it has a name
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor_ < 0)
    throw Error(fmt::format("{}: cannot be made: {}; a folder that can be written is wanted", path,
                            std::strerror(errno)));
  ::unlink(path.c_str());
}

ScratchFile::~ScratchFile() { ::close(descriptor_); }

void ScratchFile::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written =
        ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(size_));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0)
      throw Error(fmt::format(
          "{}: cannot write: {} ({} bytes were written before); free some space on this disk",
          path_, std::strerror(errno), size_));
    bytes.remove_prefix(static_cast<std::size_t>(written));
    size_ += static_cast<std::uint64_t>(written);
  }
}

void ScratchFile::read(std::uint64_t begin, char* to, std::size_t count) const {
  while (count > 0) {
    const ssize_t got = ::pread(descriptor_, to, count, static_cast<off_t>(begin));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      throw Error(fmt::format("{}: cannot be read again at byte {} of {}: {}", path_, begin, size_,
                              got == 0 ? "it ends" : std::strerror(errno)));
    to += got, count -= static_cast<std::size_t>(got);
    begin += static_cast<std::uint64_t>(got);
  }
}

}  // namespace base
