#include "live_link.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <string>
#include <thread>

namespace live_link_test {

TEST(LiveLink, TellsAndHearsTheNewest) {
  const int port = view::free_udp_port();
  const base::Descriptor unit(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  view::LiveLink link(port);
  EXPECT_EQ(link.tell("lost: nobody listens yet"), "");
  EXPECT_EQ(link.tell("lost, too"), "");
  ASSERT_EQ(::bind(unit.value, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);

  EXPECT_EQ(link.tell("first"), "");
  std::array<char, 100> buffer;
  sockaddr_in who{};
  socklen_t size = sizeof who;
  const ssize_t got = ::recvfrom(unit.value, buffer.data(), buffer.size(), 0,
                                 reinterpret_cast<sockaddr*>(&who), &size);
  EXPECT_EQ(std::string(buffer.data(), static_cast<std::size_t>(got)), "first");
  for (const std::string& answer : {std::string("one"), std::string("two"), std::string("three")})
    ::sendto(unit.value, answer.data(), answer.size(), 0, reinterpret_cast<const sockaddr*>(&who),
             size);
  std::string newest;
  for (int k = 0; k < 1000 && newest != "three"; ++k) {
    newest = link.tell("again");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(newest, "three");
  EXPECT_EQ(link.tell("and again"), "three");  // until something newer comes

  // What was seen comes with the measurement, once.
  const std::string scan = R"({"scan":"lidar","points":[]})", plan = R"({"plan":[]})";
  for (const std::string& said : {scan, plan, std::string(R"({"time_s":1})")})
    ::sendto(unit.value, said.data(), said.size(), 0, reinterpret_cast<const sockaddr*>(&who),
             size);
  for (int k = 0; k < 1000 && !newest.starts_with("{"); ++k) newest = link.tell("again");
  EXPECT_EQ(newest, R"({"time_s":1,"sights":[{"scan":"lidar","points":[]},{"plan":[]}]})");
  EXPECT_EQ(link.tell("and again"), R"({"time_s":1})");
}

TEST(LiveLink, ARunThatHasEndedIsForgotten) {
  const int port = view::free_udp_port();
  const base::Descriptor unit(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::bind(unit.value, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  view::LiveLink link(port, 0.5);
  link.tell("watch");
  std::array<char, 100> buffer;
  sockaddr_in who{};
  socklen_t size = sizeof who;
  ::recvfrom(unit.value, buffer.data(), buffer.size(), 0, reinterpret_cast<sockaddr*>(&who), &size);
  ::sendto(unit.value, "one", 3, 0, reinterpret_cast<const sockaddr*>(&who), size);
  std::string newest;
  for (int k = 0; k < 400 && newest.empty(); ++k) {
    newest = link.tell("watch");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(newest, "one");
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  EXPECT_EQ(link.tell("watch"), "");
}

}  // namespace live_link_test
