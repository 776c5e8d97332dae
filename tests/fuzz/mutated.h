// Damages bytes as the files of careless or hostile senders are damaged, for the fuzzing replays.
#pragma once

#include <algorithm>
#include <iterator>
#include <random>
#include <string>

namespace fuzz {

/// A few damages: bytes changed, parts cut out, repeated (also thousands of times) or moved,
/// numbers made absurd. Two of three begin within the first `head` bytes, where a format has its
/// header; 0: anywhere.
inline std::string mutated(std::string bytes, std::mt19937_64& generator, std::size_t head = 0) {
  constexpr const char* kNumbers[] = {"0",
                                      "-1",
                                      "1e30",
                                      "nan",
                                      "inf",
                                      "4294967296",
                                      "99999999999999999999",
                                      "1e-400",
                                      "-0.0",
                                      "7.25",
                                      "2147483648",
                                      "18446744073709551615"};
  const auto below = [&](std::size_t limit) {
    return limit == 0 ? 0 : static_cast<std::size_t>(generator() % limit);
  };
  const std::size_t damages = 1 + below(4);
  for (std::size_t k = 0; k < damages && !bytes.empty(); ++k) {
    const std::size_t at =
        below(head == 0 || generator() % 3 == 0 ? bytes.size() : std::min(bytes.size(), head));
    const std::size_t length = 1 + below(std::min<std::size_t>(bytes.size() - at, 64));
    switch (below(9)) {
      case 0:
        bytes[at] = static_cast<char>(generator());
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 2:
        bytes.erase(at, length);
        break;
      case 3:
        bytes.insert(at, bytes.substr(at, length));
        break;
      case 4:
        bytes.resize(at);
        break;
      case 5:
        bytes.insert(below(bytes.size()), bytes.substr(at, length));
        break;
      case 6: {  // nesting, and many of a kind
        const std::string part = bytes.substr(at, 1 + below(12));
        std::string many;
        for (std::size_t left = std::size_t{1} << below(13); left > 0; --left) many += part;
        if (bytes.size() < (1u << 20)) bytes.insert(at, many);
        break;
      }
      case 7:
        for (std::size_t i = at; i < bytes.size() && i < at + 8; ++i)
          bytes[i] = static_cast<char>(generator() % 2 == 0 ? 0xff : 0);
        break;
      default: {
        const std::size_t digit = bytes.find_first_of("0123456789", at);
        if (digit == std::string::npos) break;
        const std::size_t end = bytes.find_first_not_of("0123456789.eE+-", digit);
        bytes.replace(digit, (end == std::string::npos ? bytes.size() : end) - digit,
                      kNumbers[below(std::size(kNumbers))]);
      }
    }
  }
  return bytes;
}

}  // namespace fuzz
