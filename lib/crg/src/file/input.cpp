#include "input.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "crg/error.h"

namespace crg {

Input::Input(const std::string& path) : name_(path) {
  file_ = ::open(path.c_str(),
                 O_RDONLY | O_NONBLOCK | O_CLOEXEC);  // a FIFO is refused, not waited for
  if (file_ < 0) throw Error(path + ": cannot open: " + std::strerror(errno));
  struct stat status = {};
  if (::fstat(file_, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(file_);
    throw Error(path + ": not a regular file");
  }
  size_ = static_cast<std::size_t>(status.st_size);
}

Input::~Input() {
  if (file_ >= 0) ::close(file_);
}

std::size_t Input::read(char* to, std::size_t count) {
  if (file_ < 0) {
    const std::size_t taken = std::min(count, memory_.size() - position_);
    std::memcpy(to, memory_.data() + position_, taken);
    position_ += taken;
    return taken;
  }
  std::size_t taken = 0;
  while (taken < count) {
    const ssize_t got = ::read(file_, to + taken, count - taken);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw Error(name_ + ": cannot read: " + std::strerror(errno));
    if (got == 0) break;
    taken += static_cast<std::size_t>(got);
  }
  return taken;
}

}  // namespace crg
