#include "big_endian.h"

#include <bit>
#include <cmath>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace crg {
namespace {

float float_at(const char* bytes) {
  std::uint32_t word;
  std::memcpy(&word, bytes, sizeof word);
  return std::bit_cast<float>(std::endian::native == std::endian::little ? __builtin_bswap32(word)
                                                                         : word);
}

double double_at(const char* bytes) {
  std::uint64_t word;
  std::memcpy(&word, bytes, sizeof word);
  return std::bit_cast<double>(std::endian::native == std::endian::little ? __builtin_bswap64(word)
                                                                          : word);
}

#if defined(__x86_64__)

// Eight at a time; says how many were taken.
__attribute__((target("avx2"))) std::size_t take_eights(const char* bytes, std::size_t count,
                                                        float most, float* to, bool& bounded) {
  const __m256i reversed = _mm256_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12, 3,
                                            2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12);
  const __m256 no_sign = _mm256_castsi256_ps(_mm256_set1_epi32(0x7FFFFFFF)),
               bound = _mm256_set1_ps(most);
  __m256 beyond = _mm256_setzero_ps();
  std::size_t c = 0;
  for (; c + 8 <= count; c += 8) {
    const __m256i word = _mm256_shuffle_epi8(
        _mm256_loadu_si256(reinterpret_cast<const __m256i*>(bytes + 4 * c)), reversed);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + c), word);
    const __m256 magnitude = _mm256_and_ps(_mm256_castsi256_ps(word), no_sign);
    beyond = _mm256_or_ps(beyond, _mm256_cmp_ps(magnitude, bound, _CMP_GT_OQ));
  }
  bounded = _mm256_movemask_ps(beyond) == 0;
  return c;
}

#endif

}  // namespace

bool take_floats_one_by_one(const char* bytes, std::size_t count, float most, float* to) noexcept {
  bool bounded = true;
  for (std::size_t c = 0; c < count; ++c) {
    to[c] = float_at(bytes + 4 * c);
    bounded &= !(std::abs(to[c]) > most);
  }
  return bounded;
}

bool take_floats(const char* bytes, std::size_t count, float most, float* to) noexcept {
  bool bounded = true;
  std::size_t taken = 0;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) taken = take_eights(bytes, count, most, to, bounded);
#endif
  return take_floats_one_by_one(bytes + 4 * taken, count - taken, most, to + taken) && bounded;
}

bool take_doubles(const char* bytes, std::size_t count, double most, double* to) noexcept {
  bool bounded = true;
  for (std::size_t c = 0; c < count; ++c) {
    to[c] = double_at(bytes + 8 * c);
    bounded &= !(std::abs(to[c]) > most);
  }
  return bounded;
}

}  // namespace crg
