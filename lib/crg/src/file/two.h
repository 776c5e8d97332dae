// Two doubles side by side: one operation on both halves of a register, the bits those of two
// single ones.
#pragma once

#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace crg {

using Two = double __attribute__((vector_size(16)));

inline Two two_at(const double* numbers) noexcept {
  Two two;
  std::memcpy(&two, numbers, sizeof two);
  return two;
}

inline Two two_at(const float* numbers) noexcept {
#if defined(__SSE2__)
  double bits;
  std::memcpy(&bits, numbers, sizeof bits);
  return _mm_cvtps_pd(_mm_castpd_ps(_mm_set_sd(bits)));
#else
  return Two{static_cast<double>(numbers[0]), static_cast<double>(numbers[1])};
#endif
}

inline Two firsts(Two a, Two b) noexcept { return __builtin_shufflevector(a, b, 0, 2); }
inline Two seconds(Two a, Two b) noexcept { return __builtin_shufflevector(a, b, 1, 3); }
inline Two both(double a) noexcept { return Two{a, a}; }

/// Bit 0: the first is negative (-0 too), bit 1: the second.
inline unsigned signs(Two a) noexcept {
#if defined(__SSE2__)
  return static_cast<unsigned>(_mm_movemask_pd(a));
#else
  std::uint64_t bits[2];
  std::memcpy(bits, &a, sizeof a);
  return static_cast<unsigned>((bits[0] >> 63U) | (bits[1] >> 63U) << 1U);
#endif
}

/// Downwards to a whole number where the number is not negative and has 63 bits; something
/// that is negative or too large elsewhere.
inline std::int64_t whole(double a) noexcept {
#if defined(__SSE2__)
  return _mm_cvttsd_si64(_mm_set_sd(a));
#else
  return a >= 0.0 && a < 9e18 ? static_cast<std::int64_t>(a) : -1;
#endif
}

}  // namespace crg
