#include "live_link.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <deque>
#include <string_view>

#include "base/error.h"
#include "wish.h"

namespace view {
namespace {

sockaddr_in local(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

int made() { return ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0); }

bool is_sight(std::string_view said) {
  return said.starts_with(R"({"scan")") || said.starts_with(R"({"edges")") ||
         said.starts_with(R"({"plan")");
}

[[noreturn]] void fail() { throw base::Error(fmt::format("no socket: {}", std::strerror(errno))); }

}  // namespace

int free_udp_port() {
  const base::Descriptor socket(made());
  sockaddr_in address = local(0);
  socklen_t size = sizeof address;
  if (socket.value < 0 ||
      ::bind(socket.value, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::getsockname(socket.value, reinterpret_cast<sockaddr*>(&address), &size) != 0)
    fail();
  return ntohs(address.sin_port);
}

LiveLink::LiveLink(int port, double forgets_s) : socket_(made()), forgets_s_(forgets_s) {
  // A scan comes as several large datagrams at once; as much as the system allows.
  constexpr int kBytes = 4 << 20;
  ::setsockopt(socket_.value, SOL_SOCKET, SO_RCVBUF, &kBytes, sizeof kBytes);
  const sockaddr_in address = local(port);
  if (socket_.value < 0 ||
      ::connect(socket_.value, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    fail();
}

std::string LiveLink::tell(const std::string& command) {
  ::send(socket_.value, command.data(), command.size(), MSG_NOSIGNAL);
  std::array<char, 65536> buffer;
  std::deque<std::string> sights;
  for (int k = 0; k < 1000; ++k) {  // no more than a unit says in ten seconds
    const ssize_t got = ::recv(socket_.value, buffer.data(), buffer.size(), 0);
    const std::string_view said(buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    if (!said.empty()) heard_ = std::chrono::steady_clock::now();
    if (is_sight(said)) {
      sights.emplace_back(said);
      if (sights.size() > kMostSights) sights.pop_front();
    } else if (!said.empty()) {
      newest_ = said;
    }
    if (got < 0 && errno != EINTR && errno != ECONNREFUSED) break;
  }
  const std::chrono::duration<double> silent = std::chrono::steady_clock::now() - heard_;
  if (silent.count() > forgets_s_) newest_.clear();
  if (sights.empty() || !newest_.ends_with('}')) return newest_;
  return fmt::format(R"({},"sights":[{}]}})", newest_.substr(0, newest_.size() - 1),
                     fmt::join(sights, ","));
}

void LiveLinks::drive(int job, int port) {
  const std::lock_guard lock(mutex_);
  driven_ = std::make_unique<LiveLink>(port);
  job_ = job;
}

std::string LiveLinks::tell(int job, const std::string& command) {
  const std::lock_guard lock(mutex_);
  if (driven_ == nullptr || job != job_)
    throw Refusal(404, "this drive has ended, or another one was started");
  return driven_->tell(command);
}

std::string LiveLinks::watch(int port) {
  constexpr double kForgets_s = 3.0;
  const std::lock_guard lock(mutex_);
  if (port < 1 || port > 65535) throw Refusal(400, "watch: a UDP port, 1 to 65535, wanted");
  if (watched_port_ != port) watched_ = std::make_unique<LiveLink>(port, kForgets_s);
  watched_port_ = port;
  return watched_->tell(R"({"watch": true})");
}

}  // namespace view
