// Random numbers that are the same on every machine; the distributions of <random> are not.
#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>

namespace base {

/// SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators, 2014). Whoever
/// has the state has all that follows.
struct Random {
  std::uint64_t state;

  explicit Random(std::uint64_t seed) : state(seed) {}

  /// 64 random bits.
  std::uint64_t next() {
    state += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }

  /// [0, 1), 53 random bits.
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// [0, count), count above 0; small numbers come more often by a part in 2^64 / count.
  std::uint64_t below(std::uint64_t count) { return next() % count; }

  /// Mean 0, standard deviation 1, by the polar method (Marsaglia 1964).
  double normal() {
    for (;;) {
      const double a = 2.0 * uniform() - 1.0, b = 2.0 * uniform() - 1.0, s = a * a + b * b;
      if (s > 0.0 && s < 1.0) return a * std::sqrt(-2.0 * std::log(s) / s);
    }
  }
};

/// Numbers of their own for each name: what one of them takes leaves the others as they are.
inline Random random_of(std::uint64_t seed, std::string_view name) {
  Random random(seed);
  for (const char c : name) {
    random.state ^= static_cast<unsigned char>(c);
    random.next();
  }
  return random;
}

}  // namespace base
