#include "bounded_server.h"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/socket.h>

#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>

namespace view {
namespace {

/// What cpp-httplib reads and writes.
class RequestStream : public httplib::Stream {
 public:
  explicit RequestStream(Connection& connection) : connection_(connection) {}
  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  ssize_t read(char* to, std::size_t size) override { return connection_.read(to, size); }
  ssize_t write(const char* bytes, std::size_t size) override {
    return connection_.write(bytes, size) ? static_cast<ssize_t>(size) : -1;
  }
  void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  socket_t socket() const override { return INVALID_SOCKET; }

 private:
  Connection& connection_;
};

/// A thread for each connection; those of connections that were cut off are about to end.
class Threads : public httplib::TaskQueue {
 public:
  explicit Threads(Crowd& crowd) : crowd_(crowd) {}

  void enqueue(std::function<void()> work) override {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return running_ < kMost; });
      ++running_;
    }
    const auto run = [this, work = std::move(work)] {
      work();
      const std::lock_guard lock(mutex_);
      --running_;
      changed_.notify_all();
    };
    try {
      std::thread(run).detach();
    } catch (const std::system_error&) {  // the system has no more
      run();
    }
  }

  void shutdown() override {
    crowd_.close();
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return running_ == 0; });
  }

 private:
  static constexpr std::size_t kMost = 2 * (kMostStrangers + kMostKnown);
  Crowd& crowd_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t running_ = 0;
};

}  // namespace

BoundedServer::BoundedServer(std::function<bool(const httplib::Request&)> knows)
    : knows_(std::move(knows)) {
  // What is as large as a body goes back to the system at once, whichever thread had it.
  ::mallopt(M_MMAP_THRESHOLD, static_cast<int>(kLargeBody));
  set_payload_max_length(kMostBody);
  set_tcp_nodelay(true);
  new_task_queue = [this] { return new Threads(crowd_); };
}

bool BoundedServer::listen_within_bounds() {
  ::listen(svr_sock_, 1024);  // cpp-httplib: 5, and who comes beyond waits for a second
  return listen_after_bind();
}

void BoundedServer::answer(Connection& connection, int socket) {
  bool is_known = false;
  try {
    while (connection.next_request(is_known)) {
      bool has_ended = false;
      RequestStream stream(connection);
      bool has_slot = false;
      const bool is_well =
          process_request(stream, false, has_ended, [&](httplib::Request& request) {
            request.ranges.clear();  // files go as a whole, or by api/part
            is_known = knows_(request);
            if (is_known) crowd_.know(socket);
            if (is_known && connection.left() > kLargeBody)
              has_slot = large_bodies_.try_acquire_until(connection.until());
            if (has_slot) request.body.reserve(connection.left());
          });
      if (has_slot) large_bodies_.release();
      if (!is_well || has_ended || connection.left() > 0) return;
    }
  } catch (const Unreadable& problem) {
    const std::string text = fmt::format(R"({{"error":"{}"}})", problem.why);
    const std::string answer = fmt::format(
        "HTTP/1.1 {} Refused\r\nConnection: close\r\nContent-Type: application/json\r\n"
        "Content-Length: {}\r\n\r\n{}",
        problem.status, text.size(), text);
    connection.write(answer.data(), answer.size());
  } catch (const std::exception&) {  // no memory: this connection ends, others go on
  }
}

bool BoundedServer::process_and_close_socket(socket_t socket) {
  Connection connection(socket);
  if (!crowd_.enter(socket)) return false;
  answer(connection, socket);
  connection.finish();
  crowd_.leave(socket);
  return true;
}

}  // namespace view
