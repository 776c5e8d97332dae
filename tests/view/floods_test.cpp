// Programs that flood the page of kerbstone view: memory stays, and its owner is answered.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>
#include <vector>

#include "base/descriptor.h"
#include "connection.h"
#include "served.h"

namespace server_test {
namespace floods_test {

using Clock = std::chrono::steady_clock;
using ::testing::StartsWith;

double since_s(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// VmRSS or VmHWM of this process, in MB.
double memory_mb(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(key + ":")) return std::stod(line.substr(key.size() + 1)) / 1000.0;
  ADD_FAILURE() << "no " << key;
  return 0.0;
}

class Floods : public Server {
 protected:
  void SetUp() override {
    Server::SetUp();
    if (IsSkipped()) return;
    get("api/list");
    std::ofstream("/proc/self/clear_refs") << "5";  // the peak begins here
    rest_mb_ = memory_mb("VmRSS");
  }
  void TearDown() override {
    if (!IsSkipped()) {
      EXPECT_LT(memory_mb("VmHWM") - rest_mb_, 64.0);
    }
  }

  int connected() const {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port_));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    const timeval patience{10, 0};
    ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    return socket;
  }
  std::string head(const std::string& line, const std::string& headers = "") const {
    return line + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port_) +
           "\r\nX-Kerbstone-Token: " + kToken + "\r\n" + headers;
  }
  /// Sends `begin`, then `more` so many times or until it is refused; what is answered.
  std::string flooded(const std::string& begin, const std::string& more, int times) const {
    const base::Descriptor socket(connected());
    ::send(socket.value, begin.data(), begin.size(), MSG_NOSIGNAL);
    for (int k = 0; k < times; ++k)
      if (::send(socket.value, more.data(), more.size(), MSG_NOSIGNAL) < 0) break;
    std::string out(200, '\0');
    const ssize_t got = ::recv(socket.value, out.data(), out.size(), 0);
    out.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    return out;
  }
  void expect_owner_answered() {
    const auto begin = Clock::now();
    httplib::Client owner("127.0.0.1", port_);
    owner.set_read_timeout(20);
    const auto list = owner.Get("/api/list", {{"X-Kerbstone-Token", kToken}});
    EXPECT_TRUE(list && list->status == 200);
    EXPECT_LT(since_s(begin), 1.0);
  }

  double rest_mb_ = 0.0;
};

TEST_F(Floods, HeadersWithoutEndAreNotKept) {
  std::string thousand;
  for (int k = 0; k < 1000; ++k)
    thousand += "h" + std::to_string(k) + ": " + std::string(50, 'x') + "\r\n";
  EXPECT_THAT(flooded(head("GET /api/list"), thousand, 640), StartsWith("HTTP/1.1 431"));
  expect_owner_answered();
}

TEST_F(Floods, ALineWithoutEndIsNotKept) {
  const std::string megabyte(1'000'000, 'x');
  EXPECT_THAT(flooded("GET /", megabyte, 200), StartsWith("HTTP/1.1 414"));
  EXPECT_THAT(flooded(head("GET /api/list", "h: "), megabyte, 200), StartsWith("HTTP/1.1 431"));
  expect_owner_answered();
}

TEST_F(Floods, ChunksWithoutEndAreNotKept) {
  const std::string put = head("PUT /api/text?id=0/x.yaml", "If-None-Match: *\r\n");
  EXPECT_THAT(flooded(put + "Transfer-Encoding: chunked\r\n\r\n",
                      "f4240\r\n" + std::string(1'000'000, 'x') + "\r\n", 200),
              StartsWith("HTTP/1.1 411"));
  EXPECT_THAT(flooded(put + "Content-Length: 200000000\r\n\r\n", std::string(1'000'000, 'x'), 200),
              StartsWith("HTTP/1.1 413"));
  // Bytes that unpack to a thousand times as many are not unpacked.
  EXPECT_THAT(flooded(put + "Content-Encoding: gzip\r\nContent-Length: 1000\r\n\r\n",
                      std::string(1000, 'x'), 1),
              StartsWith("HTTP/1.1 415"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path("shown/x.yaml")));
  expect_owner_answered();
}

TEST_F(Floods, ManyBodiesAtOnceAreReadFewAtATime) {
  std::vector<std::unique_ptr<base::Descriptor>> sockets;
  sockets.reserve(40);
  const std::string body(3'900'000, 'x');
  for (int k = 0; k < 40; ++k) {
    sockets.push_back(std::make_unique<base::Descriptor>(connected()));
    const std::string begin = head("PUT /api/text?id=0/x.yaml", "Content-Length: 4000000\r\n\r\n");
    ::send(sockets.back()->value, begin.data(), begin.size(), MSG_NOSIGNAL);
    ::send(sockets.back()->value, body.data(), body.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  }
  for (int k = 0; k < 5; ++k) {
    for (const auto& socket : sockets)
      ::send(socket->value, body.data(), body.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    expect_owner_answered();
  }
}

TEST_F(Floods, SixtyThatDripLetNobodyWaitAndAreEnded) {
  std::vector<std::unique_ptr<base::Descriptor>> sockets;
  sockets.reserve(60);
  for (int k = 0; k < 60; ++k) sockets.push_back(std::make_unique<base::Descriptor>(connected()));
  const auto begin = Clock::now();
  while (since_s(begin) < view::Patience().head_s + 0.5) {
    for (const auto& socket : sockets) ::send(socket->value, "G", 1, MSG_NOSIGNAL);
    expect_owner_answered();
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  }
  for (const auto& socket : sockets) {
    std::string out(12, '\0');
    EXPECT_EQ(::recv(socket->value, out.data(), out.size(), 0), 12);
    EXPECT_EQ(out, "HTTP/1.1 408");
  }
}

TEST_F(Floods, OfManyConnectionsTheOldestAreClosed) {
  std::vector<std::unique_ptr<base::Descriptor>> sockets;
  sockets.reserve(400);
  for (int k = 0; k < 400; ++k) {
    sockets.push_back(std::make_unique<base::Descriptor>(connected()));
    if (k % 100 == 99) expect_owner_answered();
  }
  // The last that connected may not have been taken in yet.
  std::size_t open = sockets.size();
  for (const auto begin = Clock::now(); open > view::kMostStrangers && since_s(begin) < 1.0;) {
    open = 0;
    for (const auto& socket : sockets) {
      char byte = 0;
      open += ::recv(socket->value, &byte, 1, MSG_DONTWAIT) < 0 ? 1 : 0;
    }
  }
  EXPECT_LE(open, view::kMostStrangers);
  EXPECT_GE(open, view::kMostStrangers / 2);
}

}  // namespace floods_test
}  // namespace server_test
