// Loops over 16 lanes in one or two instructions where the processor has AVX-512; the same results without.
#pragma once

namespace road {

#if defined(__x86_64__)
template <typename Loops>
[[gnu::target("avx512f,avx512vl,prefer-vector-width=512")]] inline void run_avx512(const Loops& loops) {
  loops();
}
#endif

/// Runs `loops`. Multiplications and additions are not fused either way (-ffp-contract=off), so the bits agree.
template <typename Loops>
[[gnu::always_inline]] inline void wide(const Loops& loops) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")) return run_avx512(loops);
#endif
  loops();
}

}  // namespace road
