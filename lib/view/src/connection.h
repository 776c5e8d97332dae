// One connection of HTTP, what comes over it within bounds. Private to lib/view.
#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace view {

constexpr std::size_t kMostLine = 8192, kMostHead = 32768,
                      kMostHeaders = 64;      ///< bytes, bytes, lines
constexpr std::size_t kMostBody = 4'000'000;  ///< bytes
constexpr double kTakenBytesPerSecond =
    1e5;  ///< as fast an answer has to be taken, after Patience::taken_s
/// Connections that showed no token yet, and those that did; of more the oldest are closed.
constexpr std::size_t kMostStrangers = 128, kMostKnown = 64;

struct Patience {
  double stranger_s = 5.0;  ///< for the first byte of a request, before a token was shown
  double idle_s = 60.0;     ///< the same, afterwards
  double head_s = 5.0;      ///< from that byte to the last of the head
  double request_s = 30.0;  ///< from that byte to the last of the body
  double taken_s = 10.0;    ///< for an answer to be taken, besides its size by kTakenBytesPerSecond
};

/// Who is connected. From any thread.
class Crowd {
 public:
  /// False once closed. One stranger too many: the one that came first is cut off.
  bool enter(int socket);
  /// It has shown the token, or has done so again.
  void know(int socket);
  /// To be called before the socket is closed.
  void leave(int socket);
  /// Cuts off all, those too who come later.
  void close();

 private:
  struct Place {
    std::size_t turn = 0;
    bool is_known = false, is_cut = false;
  };
  void cut_oldest(bool is_known, std::size_t most);

  std::mutex mutex_;
  std::map<int, Place> places_;
  std::size_t turn_ = 0;
  bool is_closed_ = false;
};

/// A request that is not read any further.
struct Unreadable {
  int status = 0;
  std::string why;
};

/// Reads and writes a socket, which it closes at its end.
class Connection {
 public:
  explicit Connection(int socket, const Patience& patience = {})
      : socket_(socket), patience_(patience) {}
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() { ::close(socket_); }

  /// Waits for the head of the next request. False: none comes.
  /// Throws Unreadable beyond the bounds above.
  bool next_request(bool is_known);
  /// Of the request that next_request() found, head and body: as much as is there; 0: no more,
  /// negative: it ended before its end, or took too long.
  ssize_t read(char* to, std::size_t size);
  /// Bytes of the request that read() has not given yet.
  std::size_t left() const { return left_; }
  /// When the last of them has to be there.
  std::chrono::steady_clock::time_point until() const { return until_; }
  /// All of it, or false: closed by the other end, or taken too slowly.
  bool write(const char* bytes, std::size_t size) const;
  /// Nothing is written any more; what still comes is dropped, for at most a second, so that the
  /// other end gets what was written.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  bool receive(Clock::time_point until);
  std::size_t scanned_head(std::size_t& line, std::size_t& lines) const;

  int socket_;
  Patience patience_;
  std::string pending_;  ///< came, not read yet from at_ on
  std::size_t at_ = 0;
  std::size_t left_ = 0;  ///< bytes of the request that read() may still give
  Clock::time_point until_{};
};

}  // namespace view
