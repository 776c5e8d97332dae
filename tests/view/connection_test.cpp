#include "connection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <thread>
#include <vector>

namespace connection_test {

/// One end for the test, the other for what is tested.
struct Pair {
  std::array<int, 2> ends{};
  Pair() { EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0); }
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;
  ~Pair() { ::close(ends[0]); }
  void send(const std::string& bytes) const {
    EXPECT_EQ(::send(ends[0], bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  bool is_cut() const {
    pollfd end{ends[0], POLLIN, 0};
    char byte = 0;
    return ::poll(&end, 1, 0) == 1 && ::recv(ends[0], &byte, 1, MSG_DONTWAIT) == 0;
  }
};

constexpr view::Patience kShort{
    .stranger_s = 0.2, .idle_s = 0.2, .head_s = 0.2, .request_s = 0.4, .taken_s = 0.2};

std::string all_of(view::Connection& connection) {
  std::string out;
  std::array<char, 7> bytes;
  ssize_t got = 0;
  while ((got = connection.read(bytes.data(), bytes.size())) > 0)
    out.append(bytes.data(), static_cast<std::size_t>(got));
  return got < 0 ? out + " cut" : out;
}

/// Status with which a head is not read; 0: it is.
int status_of(const std::string& head) {
  const Pair pair;
  view::Connection connection(pair.ends[1], kShort);
  pair.send(head);
  try {
    return connection.next_request(false) ? 0 : -1;
  } catch (const view::Unreadable& problem) {
    return problem.status;
  }
}

TEST(Connection, GivesOneRequestAfterTheOtherAndNoByteMore) {
  const Pair pair;
  view::Connection connection(pair.ends[1], kShort);
  const std::string first = "PUT / HTTP/1.1\r\ncontent-LENGTH:  3 \r\n\r\nabc",
                    second = "GET /\r\n\r\n";
  pair.send(first + second);
  ASSERT_TRUE(connection.next_request(false));
  EXPECT_EQ(connection.left(), first.size());
  EXPECT_EQ(all_of(connection), first);
  ASSERT_TRUE(connection.next_request(true));
  EXPECT_EQ(all_of(connection), second);
  EXPECT_FALSE(connection.next_request(true)) << "nothing comes";
}

TEST(Connection, ReadsNoMoreThanItsBounds) {
  const std::string get = "GET / HTTP/1.1\r\n";
  const auto headers = [](std::size_t count, std::size_t length) {
    std::string out;
    for (std::size_t k = 0; k < count; ++k) out += "h: " + std::string(length, 'x') + "\r\n";
    return out;
  };
  EXPECT_EQ(status_of(get + headers(view::kMostHeaders, 10) + "\r\n"), 0);
  EXPECT_EQ(status_of(get + headers(view::kMostHeaders + 1, 10) + "\r\n"), 431);
  EXPECT_EQ(status_of(get + headers(3, 8000) + "\r\n"), 0);
  EXPECT_EQ(status_of(get + headers(5, 8000) + "\r\n"), 431);
  EXPECT_EQ(status_of(get + headers(1, view::kMostLine)), 431);
  EXPECT_EQ(status_of("GET /" + std::string(view::kMostLine, 'x')), 414);
  EXPECT_EQ(status_of(get + "Content-Length: 4000000\r\n\r\n"), 0);
  EXPECT_EQ(status_of(get + "Content-Length: 4000001\r\n\r\n"), 413);
  for (const char* const length :
       {"-1", "99999999999999999999", "0x10", "1, 1", "", "3\r\nContent-Length: 3"})
    EXPECT_EQ(status_of(get + "Content-Length: " + length + "\r\n\r\n"), 400) << length;
  EXPECT_EQ(status_of(get + "Transfer-Encoding: chunked\r\n\r\n"), 411);
  EXPECT_EQ(status_of(get + "Content-Encoding: gzip\r\n\r\n"), 415);
  EXPECT_EQ(status_of("GET / HTTP/1.1\nHost: x\r\n\r\n"), 400);
}

TEST(Connection, WaitsForNoOneLongerThanItsPatience) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  EXPECT_EQ(status_of(""), -1);
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nHost: x\r\n"), 408);
  {  // a body that drips: each byte in time, all of it not
    const Pair pair;
    view::Connection connection(pair.ends[1], kShort);
    pair.send("PUT / HTTP/1.1\r\nContent-Length: 1000\r\n\r\n");
    std::jthread drips([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        ::send(pair.ends[0], "x", 1, MSG_NOSIGNAL);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
    });
    ASSERT_TRUE(connection.next_request(false));
    EXPECT_THAT(all_of(connection), ::testing::EndsWith(" cut"));
  }
  {  // an answer that nobody takes
    const Pair pair;
    const view::Connection connection(pair.ends[1], kShort);
    const std::string answer(300'000, 'x');  // more than a socket holds: 0.2 s, and 3 s by its size
    EXPECT_FALSE(connection.write(answer.data(), answer.size()));
  }
  EXPECT_LT(std::chrono::duration<double>(Clock::now() - begin).count(), 8.0);
}

TEST(Crowd, OfStrangersTheFirstOfTheKnownTheIdlestIsCutOff) {
  view::Crowd crowd;
  std::vector<Pair> pairs(view::kMostStrangers + view::kMostKnown + 2);
  const auto at = [&](std::size_t k) { return pairs[k].ends[1]; };
  for (std::size_t k = 0; k < view::kMostKnown; ++k) {
    EXPECT_TRUE(crowd.enter(at(k)));
    crowd.know(at(k));
  }
  crowd.know(at(0));
  const std::size_t first = view::kMostKnown, last = pairs.size() - 1;
  for (std::size_t k = first; k < last; ++k) EXPECT_TRUE(crowd.enter(at(k)));
  EXPECT_TRUE(pairs[first].is_cut()) << "one stranger too many";
  EXPECT_FALSE(pairs[first + 1].is_cut());
  EXPECT_FALSE(pairs[0].is_cut());
  crowd.know(at(last - 1));
  EXPECT_TRUE(pairs[1].is_cut()) << "one known too many";
  EXPECT_FALSE(pairs[0].is_cut()) << "asked again since";
  crowd.leave(at(first + 1));
  crowd.close();
  EXPECT_FALSE(pairs[first + 1].is_cut()) << "had left";
  EXPECT_TRUE(pairs[last - 1].is_cut());
  EXPECT_FALSE(crowd.enter(at(last)));
  for (const Pair& pair : pairs) ::close(pair.ends[1]);
}

}  // namespace connection_test
