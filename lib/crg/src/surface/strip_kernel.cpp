// The inner loop of a strip, for any processor, for AVX2 and for AVX-512. All do the same float
// operations in the same order (no fused multiply-add), so they give the same bits.
#if defined(__x86_64__)
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // of its own header: what a mask leaves out
#endif
#include <immintrin.h>
#endif

#include "strip_filler.h"

namespace crg {
namespace {

// Coordinates along one sample row: c0 + b (c1 + b c2), b counted from the row's first sample.
struct RowQuadratic {
  float c0, c1, c2;

  RowQuadratic(const Quadratic& q, double a, double b) {
    c0 = static_cast<float>(q.at(a, b));
    c1 = static_cast<float>(q.c[2] + a * q.c[4] + 2.0 * b * q.c[5]);
    c2 = static_cast<float>(q.c[5]);
  }
  float at(float k) const { return c0 + k * (c1 + k * c2); }
};

inline float sample(const Tile& tile, float row, float column) {
  const int i = static_cast<int>(row), j = static_cast<int>(column);
  const float fu = row - static_cast<float>(i), fv = column - static_cast<float>(j);
  const float* z = tile.dz_m.data() +
                   static_cast<std::ptrdiff_t>(i) * static_cast<std::ptrdiff_t>(kTileSide) + j;
  const float low = z[0] + fv * (z[1] - z[0]);
  const float high = z[kTileSide] + fv * (z[kTileSide + 1] - z[kTileSide]);
  return low + fu * (high - low);
}

void fill_scalar(const Tile& tile, double a0, double b0, std::size_t rows, std::size_t columns,
                 float* out, std::size_t stride) {
  for (std::size_t i = 0; i < rows; ++i, out += stride) {
    const RowQuadratic r(tile.row, a0 + static_cast<double>(i), b0),
        c(tile.column, a0 + static_cast<double>(i), b0);
    for (std::size_t j = 0; j < columns; ++j)
      out[j] = sample(tile, r.at(static_cast<float>(j)), c.at(static_cast<float>(j)));
  }
}

#if defined(__x86_64__)
/// z[at] and z[at + 1] of 8 places: half as many loads as one by one.
__attribute__((target("avx2"), always_inline)) inline void pairs(const float* z, __m256i at,
                                                                 __m256& first, __m256& second) {
  const __m256i order = _mm256_permute4x64_epi64(at, 0b11'01'10'00);
  const auto* const doubles = reinterpret_cast<const double*>(z);  // loaded, never computed with
  const __m256 a = _mm256_castpd_ps(_mm256_i32gather_pd(doubles, _mm256_castsi256_si128(order), 4)),
               b = _mm256_castpd_ps(
                   _mm256_i32gather_pd(doubles, _mm256_extracti128_si256(order, 1), 4));
  first = _mm256_shuffle_ps(a, b, 0b10'00'10'00);
  second = _mm256_shuffle_ps(a, b, 0b11'01'11'01);
}

__attribute__((target("avx2"))) void fill_avx2(const Tile& tile, double a0, double b0,
                                               std::size_t rows, std::size_t columns, float* out,
                                               std::size_t stride) {
  const __m256 lanes = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
  const float* nodes = tile.dz_m.data();
  for (std::size_t i = 0; i < rows; ++i, out += stride) {
    const RowQuadratic r(tile.row, a0 + static_cast<double>(i), b0),
        c(tile.column, a0 + static_cast<double>(i), b0);
    const __m256 r0 = _mm256_set1_ps(r.c0), r1 = _mm256_set1_ps(r.c1), r2 = _mm256_set1_ps(r.c2);
    const __m256 c0 = _mm256_set1_ps(c.c0), c1 = _mm256_set1_ps(c.c1), c2 = _mm256_set1_ps(c.c2);
    for (std::size_t begin = 0; begin < columns; begin += 8) {
      // The last eight begin where they fit: what stands twice is the same.
      const std::size_t j = std::min(begin, columns - 8);
      const __m256 k = _mm256_add_ps(lanes, _mm256_set1_ps(static_cast<float>(j)));
      const __m256 u = _mm256_add_ps(r0, _mm256_mul_ps(k, _mm256_add_ps(r1, _mm256_mul_ps(k, r2))));
      const __m256 v = _mm256_add_ps(c0, _mm256_mul_ps(k, _mm256_add_ps(c1, _mm256_mul_ps(k, c2))));
      const __m256i ui = _mm256_cvttps_epi32(u), vi = _mm256_cvttps_epi32(v);
      const __m256 fu = _mm256_sub_ps(u, _mm256_cvtepi32_ps(ui)),
                   fv = _mm256_sub_ps(v, _mm256_cvtepi32_ps(vi));
      const __m256i at = _mm256_add_epi32(_mm256_slli_epi32(ui, 3), vi);
      __m256 z00, z01, z10, z11;
      pairs(nodes, at, z00, z01);
      pairs(nodes + kTileSide, at, z10, z11);
      const __m256 low = _mm256_add_ps(z00, _mm256_mul_ps(fv, _mm256_sub_ps(z01, z00)));
      const __m256 high = _mm256_add_ps(z10, _mm256_mul_ps(fv, _mm256_sub_ps(z11, z10)));
      _mm256_storeu_ps(out + j, _mm256_add_ps(low, _mm256_mul_ps(fu, _mm256_sub_ps(high, low))));
    }
  }
}

/// c0 and c1 of RowQuadratic for eight rows, of which the first is at a[0].
__attribute__((target("avx512f"), always_inline)) inline void eight_rows(const Quadratic& q,
                                                                         __m512d a, double b,
                                                                         float (*out)[8]) {
  const auto c = [&](std::size_t k) __attribute__((target("avx512f"), always_inline)) {
    return _mm512_set1_pd(q.c[k]);
  };
  const __m512d slope =
      _mm512_add_pd(_mm512_add_pd(c(1), _mm512_mul_pd(a, c(3))), _mm512_set1_pd(b * q.c[4]));
  const __m512d at = _mm512_add_pd(_mm512_add_pd(c(0), _mm512_mul_pd(a, slope)),
                                   _mm512_set1_pd(b * (q.c[2] + b * q.c[5])));
  _mm256_storeu_ps(out[0], _mm512_cvtpd_ps(at));
  _mm256_storeu_ps(out[1],
                   _mm512_cvtpd_ps(_mm512_add_pd(_mm512_add_pd(c(2), _mm512_mul_pd(a, c(4))),
                                                 _mm512_set1_pd(2.0 * b * q.c[5]))));
}

/// The whole tile in four registers: a node is a permutation, not a load.
__attribute__((target("avx512f"))) void fill_avx512(const Tile& tile, double a0, double b0,
                                                    std::size_t rows, std::size_t columns,
                                                    float* out, std::size_t stride) {
  static_assert(kTileSide * kTileSide == 64);
  const float* const z = tile.dz_m.data();
  const __m512 z0 = _mm512_loadu_ps(z), z1 = _mm512_loadu_ps(z + 16), z2 = _mm512_loadu_ps(z + 32),
               z3 = _mm512_loadu_ps(z + 48);
  const auto node = [&](__m512i at, __mmask16 behind)
      __attribute__((target("avx512f"), always_inline)) {
    return _mm512_mask_blend_ps(behind, _mm512_permutex2var_ps(z0, at, z1),
                                _mm512_permutex2var_ps(z2, at, z3));
  };
  const auto pair = [&](__m512i at, __m512 & first, __m512 & second)
      __attribute__((target("avx512f"), always_inline)) {
    const __mmask16 behind = _mm512_test_epi32_mask(at, _mm512_set1_epi32(32));  // both: of one row
    first = node(at, behind);
    second = node(_mm512_add_epi32(at, _mm512_set1_epi32(1)), behind);
  };
  const __m512 r2 = _mm512_set1_ps(static_cast<float>(tile.row.c[5])),
               c2 = _mm512_set1_ps(static_cast<float>(tile.column.c[5]));
  const __m512 lanes = _mm512_setr_ps(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  const __m512d ahead = _mm512_setr_pd(0, 1, 2, 3, 4, 5, 6, 7);
  for (std::size_t begin = 0; begin < rows; begin += 8) {
    const __m512d a = _mm512_add_pd(
        _mm512_set1_pd(a0), _mm512_add_pd(ahead, _mm512_set1_pd(static_cast<double>(begin))));
    float of_row[2][8], of_column[2][8];
    eight_rows(tile.row, a, b0, of_row);
    eight_rows(tile.column, a, b0, of_column);
    const std::size_t here = std::min<std::size_t>(8, rows - begin);
    for (std::size_t j = 0; j < columns; j += 16) {
      const auto used =
          static_cast<__mmask16>(columns - j < 16 ? (1u << (columns - j)) - 1u : 0xffffu);
      const __m512 k = _mm512_add_ps(lanes, _mm512_set1_ps(static_cast<float>(j)));
      const __m512 k_r2 = _mm512_mul_ps(k, r2), k_c2 = _mm512_mul_ps(k, c2);
      for (std::size_t i = 0; i < here; ++i) {
        const auto at_row = [&](const float(&of)[2][8], __m512 bend)
            __attribute__((target("avx512f"), always_inline)) {
          const __m512 slope = _mm512_add_ps(_mm512_set1_ps(of[1][i]), bend);
          return _mm512_add_ps(_mm512_set1_ps(of[0][i]), _mm512_mul_ps(k, slope));
        };
        const __m512 u = at_row(of_row, k_r2), v = at_row(of_column, k_c2);
        const __m512i ui = _mm512_cvttps_epi32(u), vi = _mm512_cvttps_epi32(v);
        const __m512 fu = _mm512_sub_ps(u, _mm512_cvtepi32_ps(ui)),
                     fv = _mm512_sub_ps(v, _mm512_cvtepi32_ps(vi));
        const __m512i at = _mm512_add_epi32(_mm512_slli_epi32(ui, 3), vi);
        __m512 z00, z01, z10, z11;
        pair(at, z00, z01);
        pair(_mm512_add_epi32(at, _mm512_set1_epi32(kTileSide)), z10, z11);
        const __m512 low = _mm512_add_ps(z00, _mm512_mul_ps(fv, _mm512_sub_ps(z01, z00)));
        const __m512 high = _mm512_add_ps(z10, _mm512_mul_ps(fv, _mm512_sub_ps(z11, z10)));
        _mm512_mask_storeu_ps(out + (begin + i) * stride + j, used,
                              _mm512_add_ps(low, _mm512_mul_ps(fu, _mm512_sub_ps(high, low))));
      }
    }
  }
}
#endif

}  // namespace

bool available(StripKernel kernel) {
#if defined(__x86_64__)
  if (kernel == StripKernel::Avx2) return __builtin_cpu_supports("avx2");
  if (kernel == StripKernel::Avx512) return __builtin_cpu_supports("avx512f");
#endif
  return kernel == StripKernel::Best || kernel == StripKernel::Scalar;
}

void fill_from_tile(const Tile& tile, double a, double b, std::size_t rows, std::size_t columns,
                    float* out, std::size_t stride, StripKernel kernel) noexcept {
  const auto wanted = [&](StripKernel which) {
    return (kernel == StripKernel::Best || kernel == which) && available(which);
  };
#if defined(__x86_64__)
  if (wanted(StripKernel::Avx512)) return fill_avx512(tile, a, b, rows, columns, out, stride);
  if (wanted(StripKernel::Avx2) && columns >= 8)
    return fill_avx2(tile, a, b, rows, columns, out, stride);
#endif
  static_cast<void>(wanted);
  fill_scalar(tile, a, b, rows, columns, out, stride);
}

}  // namespace crg
