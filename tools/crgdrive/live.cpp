#include "live.h"

#include <fmt/format.h>
#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmath>
#include <iterator>
#include <memory>
#include <thread>

#include "vehicle/error.h"

namespace crgdrive {

Live::Live(const LiveOptions& options) : speed_up_(options.speed_up) {
  if (options.udp.empty()) return;
  const std::size_t colon = options.udp.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == options.udp.size())
    throw vehicle::Error(
        fmt::format("--udp '{}': wanted host:port, e.g. localhost:9870", options.udp));
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int code = ::getaddrinfo(options.udp.substr(0, colon).c_str(),
                                 options.udp.substr(colon + 1).c_str(), &hints, &found);
  if (code != 0)
    throw vehicle::Error(fmt::format("--udp '{}': {}", options.udp, ::gai_strerror(code)));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> addresses(found, &::freeaddrinfo);
  for (const addrinfo* at = found; at != nullptr && socket_ < 0; at = at->ai_next) {
    socket_ = ::socket(at->ai_family, at->ai_socktype | SOCK_CLOEXEC, at->ai_protocol);
    if (socket_ >= 0 && ::connect(socket_, at->ai_addr, at->ai_addrlen) != 0) {
      ::close(socket_);
      socket_ = -1;
    }
  }
  if (socket_ < 0)
    throw vehicle::Error(fmt::format("--udp '{}': cannot be reached from here", options.udp));
}

Live::~Live() {
  if (socket_ >= 0) ::close(socket_);
}

void Live::row(const recording::Table& telemetry) {
  const double time_s = telemetry.columns.front().back();
  if (!begun_) {
    begun_ = true;
    begin_s_ = time_s;
    begin_ = std::chrono::steady_clock::now();
  }
  if (speed_up_ > 0.0)
    std::this_thread::sleep_until(
        begin_ + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                     std::chrono::duration<double>((time_s - begin_s_) / speed_up_)));
  if (socket_ < 0) return;
  fmt::memory_buffer json;
  char before = '{';
  for (std::size_t i = 0; i < telemetry.names.size(); ++i) {
    const double value = telemetry.columns[i].back();
    if (!std::isfinite(value)) continue;
    fmt::format_to(std::back_inserter(json), "{}\"{}\":{:.9g}", before, telemetry.names[i], value);
    before = ',';
  }
  json.push_back('}');
  (void)::send(socket_, json.data(), json.size(), MSG_NOSIGNAL);  // nobody may listen
}

}  // namespace crgdrive
