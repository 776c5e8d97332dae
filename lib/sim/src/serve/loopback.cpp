#include "loopback.h"

#include <fmt/format.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "base/error.h"

namespace sim {

std::set<int> open_sockets() {
  std::set<int> out;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int descriptor = std::atoi(entry.path().filename().c_str());
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) == 0 &&
        (address.ss_family == AF_INET || address.ss_family == AF_INET6))
      out.insert(descriptor);
  }
  return out;
}

void receive_by_loopback(const std::set<int>& before) {
  for (const int descriptor : open_sockets())
    if (!before.contains(descriptor) &&
        ::setsockopt(descriptor, SOL_SOCKET, SO_BINDTODEVICE, "lo", 3) != 0)
      throw base::Error(fmt::format(
          "DDS: cannot be kept to this machine: {}; CYCLONEDDS_URI says what else is wanted",
          std::strerror(errno)));
}

}  // namespace sim
