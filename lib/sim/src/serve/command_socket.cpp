#include "command_socket.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "sim/message.h"

namespace sim {
namespace {

constexpr double kTry_s = 0.0005;

/// A socket that a killed run left behind is taken away; nothing else is.
void free_path(const std::string& path, const sockaddr_un& address) {
  struct stat there {};
  if (::lstat(path.c_str(), &there) != 0 || !S_ISSOCK(there.st_mode)) return;
  const base::Descriptor probe(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (probe.value < 0) return;
  const int connected =
      ::connect(probe.value, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  if (connected != 0 && errno == ECONNREFUSED) ::unlink(path.c_str());
}

}  // namespace

CommandSocket::CommandSocket(const std::string& path, std::uint16_t udp_port)
    : socket_(::socket(path.empty() ? AF_INET : AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)),
      bytes_(kLongestMessage + 1, '\0') {
  const std::string where = path.empty() ? "UDP port " + std::to_string(udp_port) : path;
  const auto refuse = [&] {
    throw base::Error(where + ": no socket can be made there: " + std::strerror(errno));
  };
  if (socket_.value < 0) refuse();
  if (path.empty()) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(udp_port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::bind(socket_.value, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      refuse();
    return;
  }
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path)
    throw base::Error(path + ": longer than the 107 characters that a socket's path may have");
  std::copy(path.begin(), path.end(), address.sun_path);
  free_path(path, address);
  if (::bind(socket_.value, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    refuse();
}

std::optional<std::string_view> CommandSocket::receive(double wait_s) {
  pollfd waiting{socket_.value, POLLIN, 0};
  const int ready = ::poll(&waiting, 1, static_cast<int>(std::ceil(1000.0 * wait_s)));
  if (ready <= 0) return std::nullopt;
  from_size_ = sizeof from_;
  const ssize_t count = ::recvfrom(socket_.value, bytes_.data(), bytes_.size(), MSG_DONTWAIT,
                                   reinterpret_cast<sockaddr*>(&from_), &from_size_);
  if (count < 0) return std::nullopt;
  return std::string_view(bytes_.data(), static_cast<std::size_t>(count));
}

bool CommandSocket::send(std::string_view bytes, double wait_s) {
  // A Unix socket without a path of its own cannot be answered.
  if (answer_size_ <= sizeof(sa_family_t)) return true;
  // poll() knows nothing of the queue of whoever is to be answered.
  for (double waited_s = 0.0;; waited_s += kTry_s) {
    const ssize_t sent =
        ::sendto(socket_.value, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                 reinterpret_cast<const sockaddr*>(&answer_to_), answer_size_);
    if (sent >= 0 || (errno != EAGAIN && errno != ENOBUFS && errno != EINTR)) return true;
    if (waited_s >= wait_s) return false;
    ::usleep(static_cast<useconds_t>(1e6 * kTry_s));
  }
}

void CommandSocket::reply(std::string_view bytes) const {
  if (from_size_ <= sizeof(sa_family_t)) return;
  ::sendto(socket_.value, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
           reinterpret_cast<const sockaddr*>(&from_), from_size_);
}

void CommandSocket::watch_here() {
  if (from_size_ <= sizeof(sa_family_t)) return;
  const auto until = std::chrono::steady_clock::now() +
                     std::chrono::milliseconds(static_cast<int>(1000.0 * kWatch_s));
  for (Watcher& watcher : watchers_)
    if (watcher.size == from_size_ && std::memcmp(&watcher.address, &from_, from_size_) == 0) {
      watcher.until = until;
      return;
    }
  if (watchers_.size() == kMostWatchers) watchers_.erase(watchers_.begin());
  watchers_.push_back({from_, from_size_, until});
}

bool CommandSocket::is_watched() {
  if (watchers_.empty()) return false;
  const auto now = std::chrono::steady_clock::now();
  std::erase_if(watchers_, [&](const Watcher& watcher) { return watcher.until < now; });
  return !watchers_.empty();
}

void CommandSocket::copy(std::string_view bytes) const {
  for (const Watcher& watcher : watchers_)
    ::sendto(socket_.value, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
             reinterpret_cast<const sockaddr*>(&watcher.address), watcher.size);
}

SocketPath::~SocketPath() {
  if (!path.empty()) ::unlink(path.c_str());
}

}  // namespace sim
