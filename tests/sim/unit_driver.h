// A program that drives a unit that is served.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "base/json_text.h"

namespace sim_tests {

/// A program that drives, as a Unix datagram socket.
class Driver {
 public:
  explicit Driver(const std::string& path, const std::string& name = "driver")
      : own_(path + "." + name) {
    for (int tries = 0; tries < 500 && !std::filesystem::exists(path); ++tries)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const sockaddr_un mine = address(own_), theirs = address(path);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&mine), sizeof mine), 0);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&theirs), sizeof theirs), 0);
    const timeval patience{5, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;
  ~Driver() {
    ::close(socket_);
    ::unlink(own_.c_str());
  }
  void say(const std::string& bytes) const { ::send(socket_, bytes.data(), bytes.size(), 0); }
  std::string hear_bytes() const {
    std::string bytes(65536, '\0');
    const ssize_t count = ::recv(socket_, bytes.data(), bytes.size(), 0);
    EXPECT_GT(count, 0) << "no measurement came";
    return bytes.substr(0, static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  }
  nlohmann::json hear() const { return base::parse_json<nlohmann::json>(hear_bytes(), false); }

 private:
  static sockaddr_un address(const std::string& path) {
    sockaddr_un out{};
    out.sun_family = AF_UNIX;
    std::copy_n(path.begin(), std::min(path.size(), sizeof out.sun_path - 1), out.sun_path);
    return out;
  }
  std::string own_;
  int socket_ = ::socket(AF_UNIX, SOCK_DGRAM, 0);
};

}  // namespace sim_tests
