#include "drive.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <ostream>
#include <stdexcept>
#include <thread>
#include <vector>

namespace gamepad {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr auto kEvery = std::chrono::milliseconds(20);
constexpr int kShownEvery = 5, kUnheard = 50;  // commands

// 0.3 rad of the road wheels at rest, half of it at 18 m/s, a twentieth at 80 m/s.
constexpr double kMostSteering_rad = 0.3, kHalf_mps = 18.0;
constexpr double kFrontBrake_pa = 4e6, kRearBrake_pa = 2.4e6;
constexpr int kReverse = -1;

double beyond_rest(double way) {
  const double left = std::clamp((std::abs(way) - kRest) / (1.0 - kRest), 0.0, 1.0);
  return std::copysign(left, way);
}

struct Told {
  bool is_there = false, is_safe = false;
  double time_s = 0.0, speed_mps = 0.0;
};

class Connection {
 public:
  explicit Connection(const std::string& path)
      : own_(path + ".gamepad." + std::to_string(::getpid())) {
    const sockaddr_un mine = address(own_), theirs = address(path);
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM, 0);
    if (::bind(socket_, reinterpret_cast<const sockaddr*>(&mine), sizeof mine) == 0 &&
        ::connect(socket_, reinterpret_cast<const sockaddr*>(&theirs), sizeof theirs) == 0)
      return;
    const std::string why = std::strerror(errno);
    close();
    throw std::runtime_error(path + ": " + why + "; wanted the --socket of a crgsim serve");
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() { close(); }

  /// False when the run has ended. A datagram that finds no room is lost: another comes soon.
  bool say(json message) {
    message["sequence"] = ++sequence_;
    const std::string bytes = message.dump();
    return ::send(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL) >= 0 ||
           errno == EAGAIN || errno == ENOBUFS;
  }

  /// The newest measurement, if one came.
  void hear(Told& told) {
    ssize_t count = 0;
    while ((count = ::recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT)) > 0) {
      const json message = json::parse(buffer_.data(), buffer_.data() + count, nullptr, false);
      if (!message.is_object() || !message.contains("values")) continue;  // what sensors saw
      told = {true, message.value("safe", false), message.value("time_s", 0.0),
              message["values"].value("car.vx", 0.0)};
    }
  }

 private:
  static sockaddr_un address(const std::string& path) {
    sockaddr_un out{};
    out.sun_family = AF_UNIX;
    if (path.size() >= sizeof out.sun_path)
      throw std::runtime_error(path + ": longer than the name of a socket may be");
    std::copy(path.begin(), path.end(), out.sun_path);
    return out;
  }
  void close() {
    ::close(socket_);
    ::unlink(own_.c_str());
  }

  std::string own_;
  int socket_ = -1;
  std::array<char, 65536> buffer_{};
  std::uint32_t sequence_ = 0;
};

json message_of(const Command& command) {
  return {{"set",
           {{"input.steering", command.steering_rad},
            {"input.throttle", command.throttle},
            {"input.brake.fl", command.front_brake_pa},
            {"input.brake.fr", command.front_brake_pa},
            {"input.brake.rl", command.rear_brake_pa},
            {"input.brake.rr", command.rear_brake_pa},
            {"input.gear", command.gear}}}};
}

std::string shown(const Told& told, const Command& command) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                "\r%7.1f s %5.0f km/h  gear %2d  steering %+.3f rad  throttle %3.0f %%  brake "
                "%4.1f MPa  %s",
                told.time_s, 3.6 * told.speed_mps, command.gear, command.steering_rad,
                100.0 * command.throttle, 1e-6 * command.front_brake_pa,
                told.is_safe ? "SAFE INPUT" : "          ");
  return text.data();
}

}  // namespace

Command command_of(const Said& said, int gear, double speed_mps) {
  const double share = speed_mps / kHalf_mps;
  Command out;
  out.steering_rad = -beyond_rest(said.stick) * kMostSteering_rad / (1.0 + share * share);
  out.throttle = beyond_rest(said.throttle);
  out.front_brake_pa = beyond_rest(said.brake) * kFrontBrake_pa;
  out.rear_brake_pa = beyond_rest(said.brake) * kRearBrake_pa;
  out.gear = gear;
  return out;
}

void drive(const std::string& path, const Gears& gears, const Look& look, std::ostream& lines,
           bool is_shown) {
  Connection connection(path);
  const auto line = [&](const char* text) {
    lines << (is_shown ? "\r\033[K" : "") << text << std::endl;
  };
  Told told;
  Command command;
  int gear = gears.first, ticks = 0, said_unheard = 0;
  std::optional<bool> had_pad;
  for (auto next = Clock::now();; next += kEvery) {
    std::this_thread::sleep_until(next);
    const std::optional<Said> said = look();
    if (had_pad != said.has_value())
      line(said      ? "the pad drives"
           : had_pad ? "the pad is gone: nothing is said, so that the safe input of crgsim acts; "
                       "plug one in to drive on"
                     : "there is no pad; plug one in");
    had_pad = said.has_value();
    if (said) {
      gear = said->again ? gears.first : std::clamp(gear + said->shifts, kReverse, gears.count);
      command = command_of(*said, gear, told.speed_mps);
      json message = message_of(command);
      if (said->again) message["reset"] = json::object();
      if (said->ends) message["end"] = true;
      const bool is_taken = connection.say(std::move(message));
      if (said->ends) return line("ended");
      if (!is_taken) return line("the run has ended");
      if (++said_unheard == kUnheard && !told.is_there)
        line("no measurement comes; docs/crgsim.md says what crgsim serve has to be told");
    } else if (::access(path.c_str(), F_OK) != 0) {
      return line("the run has ended");
    }
    connection.hear(told);
    if (is_shown && ++ticks % kShownEvery == 0) lines << shown(told, command) << std::flush;
  }
}

}  // namespace gamepad
