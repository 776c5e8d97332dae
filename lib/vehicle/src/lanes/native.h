// What packs of four and eight are on processors with AVX2 and AVX-512.
#pragma once

#include <immintrin.h>

#include "vehicle/lanes.h"

namespace vehicle {

#if defined(__AVX512F__)
template <>
[[gnu::always_inline]] inline bool any(const Mask<8>& which) {
  const __m512i v = reinterpret_cast<__m512i>(which.v);
  return _mm512_test_epi64_mask(v, v) != 0;
}
[[gnu::always_inline]] inline Pack<8> looked_up(const double* table, const Pack<8>& shifted,
                                                std::uint64_t bits) {
  const Pack<8>::Bits index = shifted.bits() & bits;
  return Pack<8>(_mm512_mask_i64gather_pd(_mm512_setzero_pd(), __mmask8(0xff),
                                          reinterpret_cast<__m512i>(index), table, 8));
}
[[gnu::always_inline]] inline Pack<8> sqrt(const Pack<8>& x) {
  return Pack<8>(_mm512_maskz_sqrt_pd(__mmask8(0xff), x.v));
}
#else
template <>
[[gnu::always_inline]] inline bool any(const Mask<4>& which) {
  const __m256i v = reinterpret_cast<__m256i>(which.v);
  return _mm256_testz_si256(v, v) == 0;
}
[[gnu::always_inline]] inline Pack<4> looked_up(const double* table, const Pack<4>& shifted,
                                                std::uint64_t bits) {
  const Pack<4>::Bits index = shifted.bits() & bits;
  const __m256d every = reinterpret_cast<__m256d>(_mm256_set1_epi64x(-1));
  return Pack<4>(_mm256_mask_i64gather_pd(_mm256_setzero_pd(), table,
                                          reinterpret_cast<__m256i>(index), every, 8));
}
[[gnu::always_inline]] inline Pack<4> sqrt(const Pack<4>& x) {
  return Pack<4>(_mm256_sqrt_pd(x.v));
}
#endif

}  // namespace vehicle
