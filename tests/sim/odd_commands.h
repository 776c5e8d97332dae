// Commands that no sound program sends, and sound ones between them; the same for the same seed.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace sim_tests {

class OddCommands {
 public:
  explicit OddCommands(unsigned seed) : random_(seed) {}

  std::size_t below(std::size_t count) { return random_() % count; }
  const std::string& one_of(const std::vector<std::string>& list) {
    return list[below(list.size())];
  }

  /// Mostly what is in reach, else anything that a double may be.
  double number() {
    static const std::vector<double> odd{0.0,  -0.0,  2.5,    9.0,    -5.0,  999.0, 1e9,
                                         -1e9, 1e300, -1e300, 5e-324, 1e-12, 7.0,   3.0};
    return below(3) == 0 ? odd[below(odd.size())]
                         : std::uniform_real_distribution<double>(-1.0, 4.0)(random_);
  }

  std::string name() {
    return one_of({"input.steering", "input.throttle", "input.brake.fl", "input.gear",
                   "parameter.environment.road_grip", "start.speed", "start.u", "start.v",
                   "start.yaw", "nobody", "", "input.gear[3]", "car.x", "vehicle",
                   "input.opponent[1].active", "parameter.chassis.mass_kg", "state"});
  }

  std::string value() {
    if (below(3) != 0) return fmt::format("{}", number());
    return one_of({"NaN", "null", "\"x\"", "[1]", "{\"a\": {\"b\": []}}", "1e999", "-1e999", "true",
                   "18446744073709551616", "\"\\ud800\"", "0.1.2", "+1", "\"here\""});
  }

  std::string table() {
    std::string out;
    for (std::size_t k = below(4); k > 0; --k)
      out += fmt::format("{}\"{}\": {}", out.empty() ? "" : ", ", name(), value());
    return "{" + out + "}";
  }

  /// A datagram in either form.
  std::string datagram(std::uint32_t sequence, std::size_t commands) {
    switch (below(12)) {
      case 0: {
        std::string bytes(below(200), '\0');
        for (char& c : bytes) c = static_cast<char>(below(256));
        return bytes;
      }
      case 1: {
        const std::string sound =
            fmt::format(R"({{"sequence": {}, "set": {}}})", sequence, table());
        return sound.substr(0, below(sound.size()));
      }
      case 2:
        return fmt::format("{{\"sequence\": {}, \"set\": {}", sequence,
                           std::string(below(5000), '['));
      case 3: {
        const std::uint32_t count = below(4) == 0 ? static_cast<std::uint32_t>(random_())
                                                  : static_cast<std::uint32_t>(commands);
        std::string bytes = "KSC1";
        const std::uint32_t flags =
            below(2) == 0 ? 0 : 2 * (static_cast<std::uint32_t>(random_()) & 31);
        for (const std::uint32_t word : {sequence, flags, count})
          bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
        for (std::size_t k = 0; k < commands; ++k) {
          const double said = below(9) == 0 ? std::numeric_limits<double>::quiet_NaN() : number();
          bytes.append(reinterpret_cast<const char*>(&said), sizeof said);
        }
        return bytes;
      }
      case 4:
        return fmt::format(R"({{"sequence": {}, "reset": {}}})", sequence, table());
      case 5:
        return fmt::format(R"({{"sequence": {}, "reset": {{"start.u": {}, "start.speed": {}}}}})",
                           sequence, 60.0 * number(), 10.0 * number());
      case 6:
        return fmt::format(R"({{"sequence": {}, "{}": "{}"}})", sequence,
                           one_of({"save", "plan", "end", "pause", "sequence", "other"}), name());
      case 7:
        return fmt::format(R"({{"sequence": {}, "reset": {{"state": "{}"}}}})", sequence, name());
      case 8:
        return fmt::format(R"({{"sequence": {}, "set": {}}})", value(), table());
      default:
        return fmt::format(R"({{"sequence": {}, "set": {}}})", sequence, table());
    }
  }

 private:
  std::mt19937 random_;
};

}  // namespace sim_tests
