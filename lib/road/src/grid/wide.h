// Loops over 16 lanes in one or two instructions where the processor has AVX-512; the same results
// without.
#pragma once

#include <cstdint>

namespace road {

/// Lanes that are computed at once; without AVX-512 the compiler takes several narrower
/// instructions.
using Floats16 [[gnu::vector_size(64), gnu::may_alias]] = float;
using Floats8 [[gnu::vector_size(32), gnu::may_alias]] = float;
using Doubles8 [[gnu::vector_size(64), gnu::may_alias]] = double;
using Ints16 [[gnu::vector_size(64), gnu::may_alias]] = std::int32_t;

#if defined(__x86_64__)
template <typename Loops>
#if defined(__clang__)  // knows no such preference
[[gnu::target("avx512f,avx512vl")]]
#else
[[gnu::target("avx512f,avx512vl,prefer-vector-width=512")]]
#endif
inline void
run_avx512(const Loops& loops) {
  loops();
}
#endif

/// Runs `loops`. Multiplications and additions are not fused either way (-ffp-contract=off), so the
/// bits agree.
template <typename Loops>
[[gnu::always_inline]] inline void wide(const Loops& loops) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl"))
    return run_avx512(loops);
#endif
  loops();
}

/// 16 values that lie one after the other, at a multiple of 64 bytes.
template <typename Lanes, typename T>
[[gnu::always_inline]] inline auto& lanes(T* values) {
  return *reinterpret_cast<Lanes*>(values);
}

/// Whether any bit of any lane is set.
[[gnu::always_inline]] inline bool any(const Ints16& lanes) {
  using Longs2 [[gnu::vector_size(16)]] = std::int64_t;
  using Ints4 [[gnu::vector_size(16)]] = std::int32_t;
  const Ints4 a = __builtin_shufflevector(lanes, lanes, 0, 1, 2, 3),
              b = __builtin_shufflevector(lanes, lanes, 4, 5, 6, 7);
  const Ints4 c = __builtin_shufflevector(lanes, lanes, 8, 9, 10, 11),
              d = __builtin_shufflevector(lanes, lanes, 12, 13, 14, 15);
  const auto all = reinterpret_cast<Longs2>((a | b) | (c | d));
  return (all[0] | all[1]) != 0;
}

}  // namespace road
