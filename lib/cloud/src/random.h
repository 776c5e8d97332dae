// Random numbers that are the same on every machine: SplitMix64 (Steele, Lea, Flood 2014) and the
// polar method (Marsaglia 1964).
#pragma once

#include <cmath>
#include <cstdint>

namespace cloud {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  /// [0, 1), 53 random bits.
  double uniform() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
  }

  /// Mean 0, standard deviation 1.
  double normal() {
    for (;;) {
      const double a = 2.0 * uniform() - 1.0, b = 2.0 * uniform() - 1.0, s = a * a + b * b;
      if (s > 0.0 && s < 1.0) return a * std::sqrt(-2.0 * std::log(s) / s);
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace cloud
