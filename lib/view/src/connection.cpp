#include "connection.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <string_view>

#include "base/text_lines.h"

namespace view {
namespace {

using Clock = std::chrono::steady_clock;

Clock::time_point in_s(double seconds) {
  return Clock::now() +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// False: not within the time.
bool is_ready(int socket, short what, Clock::time_point until) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    if (left <= 0) return false;
    pollfd end{socket, what, 0};
    const int ready = ::poll(&end, 1, static_cast<int>(std::min<long>(left, 60'000)));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
}

bool is_header(std::string_view line, std::string_view name) {
  return line.size() > name.size() && line[name.size()] == ':' &&
         std::equal(name.begin(), name.end(), line.begin(), [](char a, char b) {
           return a == static_cast<char>(std::tolower(static_cast<unsigned char>(b)));
         });
}

std::string_view value_of(std::string_view line) {
  line.remove_prefix(line.find(':') + 1);
  const std::size_t begin = line.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return line.substr(begin, line.find_last_not_of(" \t") + 1 - begin);
}

/// Length of the body that a whole head states.
std::size_t body_length(std::string_view head) {
  std::optional<std::size_t> length;
  for (std::size_t end = head.find("\r\n"); end != std::string_view::npos;
       end = head.find("\r\n")) {
    const std::string_view line = head.substr(0, end);
    head.remove_prefix(end + 2);
    if (is_header(line, "transfer-encoding"))
      throw Unreadable{411, "Transfer-Encoding seen, a body with Content-Length wanted"};
    if (is_header(line, "content-encoding"))
      throw Unreadable{415, "Content-Encoding seen, a body that is not packed wanted"};
    if (!is_header(line, "content-length")) continue;
    const auto stated = base::to_number<std::size_t>(std::string(value_of(line)));
    if (length || !stated) throw Unreadable{400, "Content-Length: one whole number wanted"};
    length = stated;
  }
  if (length.value_or(0) > kMostBody)
    throw Unreadable{413,
                     fmt::format("a body of {} bytes seen, at most {} wanted", *length, kMostBody)};
  return length.value_or(0);
}

}  // namespace

bool Crowd::enter(int socket) {
  const std::lock_guard lock(mutex_);
  if (is_closed_) return false;
  places_[socket] = {++turn_};
  cut_oldest(false, kMostStrangers);
  return true;
}

void Crowd::know(int socket) {
  const std::lock_guard lock(mutex_);
  const auto found = places_.find(socket);
  if (found == places_.end()) return;
  found->second.turn = ++turn_;
  found->second.is_known = true;
  cut_oldest(true, kMostKnown);
}

void Crowd::leave(int socket) {
  const std::lock_guard lock(mutex_);
  places_.erase(socket);
}

void Crowd::close() {
  const std::lock_guard lock(mutex_);
  is_closed_ = true;
  for (const auto& [socket, place] : places_) ::shutdown(socket, SHUT_RDWR);
}

void Crowd::cut_oldest(bool is_known, std::size_t most) {
  std::size_t count = 0;
  auto oldest = places_.end();
  for (auto place = places_.begin(); place != places_.end(); ++place) {
    if (place->second.is_known != is_known || place->second.is_cut) continue;
    ++count;
    if (oldest == places_.end() || place->second.turn < oldest->second.turn) oldest = place;
  }
  if (count <= most) return;
  oldest->second.is_cut = true;
  ::shutdown(oldest->first, SHUT_RDWR);
}

bool Connection::receive(Clock::time_point until) {
  std::array<char, 16384> bytes;
  for (;;) {
    const ssize_t got = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (got > 0) {
      pending_.append(bytes.data(), static_cast<std::size_t>(got));
      return true;
    }
    if (got == 0 || (errno != EAGAIN && errno != EINTR)) return false;
    if (!is_ready(socket_, POLLIN, until)) return false;
  }
}

/// Bytes of the head where all of it is there, else 0. `line`, `lines`: where to go on, and lines
/// so far.
std::size_t Connection::scanned_head(std::size_t& line, std::size_t& lines) const {
  for (;;) {
    const std::size_t end = pending_.find('\n', line);
    const std::size_t length = (end == std::string::npos ? pending_.size() : end) - line;
    if (length > kMostLine)
      throw Unreadable{lines == 0 ? 414 : 431,
                       fmt::format("a line of more than {} bytes seen", kMostLine)};
    if ((end == std::string::npos ? pending_.size() : end) > kMostHead)
      throw Unreadable{431, fmt::format("headers of more than {} bytes seen", kMostHead)};
    if (end == std::string::npos) return 0;
    if (length == 0 || pending_[end - 1] != '\r')
      throw Unreadable{400, "a line that ends with LF alone seen, CR LF wanted"};
    line = end + 1;
    if (length == 1) return line;
    if (++lines > kMostHeaders + 1)
      throw Unreadable{431, fmt::format("more than {} headers seen", kMostHeaders)};
  }
}

bool Connection::next_request(bool is_known) {
  pending_.erase(0, at_);
  at_ = left_ = 0;
  if (pending_.empty() && !receive(in_s(is_known ? patience_.idle_s : patience_.stranger_s)))
    return false;
  const Clock::time_point until = in_s(patience_.head_s);
  until_ = in_s(patience_.request_s);
  std::size_t line = 0, lines = 0, head = 0;
  while ((head = scanned_head(line, lines)) == 0) {
    if (receive(until)) continue;
    if (Clock::now() < until) return false;  // closed
    throw Unreadable{408, fmt::format("headers did not come within {} s", patience_.head_s)};
  }
  left_ = head + body_length(std::string_view(pending_).substr(0, head));
  return true;
}

ssize_t Connection::read(char* to, std::size_t size) {
  if (left_ == 0 || size == 0) return 0;
  if (at_ == pending_.size()) {
    pending_.clear();
    at_ = 0;
    if (!receive(until_)) return -1;
  }
  const std::size_t count = std::min({size, left_, pending_.size() - at_});
  pending_.copy(to, count, at_);
  at_ += count;
  left_ -= count;
  return static_cast<ssize_t>(count);
}

bool Connection::write(const char* bytes, std::size_t size) const {
  const Clock::time_point until =
      in_s(patience_.taken_s + static_cast<double>(size) / kTakenBytesPerSecond);
  while (size > 0) {
    const ssize_t sent = ::send(socket_, bytes, size, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent >= 0) {
      bytes += sent;
      size -= static_cast<std::size_t>(sent);
    } else if (errno == EAGAIN) {
      if (!is_ready(socket_, POLLOUT, until)) return false;
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

void Connection::finish() {
  ::shutdown(socket_, SHUT_WR);
  for (const auto until = in_s(1.0); Clock::now() < until && receive(until);) pending_.clear();
}

}  // namespace view
