// The inner loop of a strip, for any processor and for AVX2. Both do the same float operations in
// the same order (no fused multiply-add), so they give the same bits.
#if defined(__x86_64__)
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

void fill_scalar(const Tile& tile, const Quadratic& row, const Quadratic& column, double a0,
                 double b0, std::size_t rows, std::size_t columns, float* out, std::size_t stride) {
  for (std::size_t i = 0; i < rows; ++i, out += stride) {
    const RowQuadratic r(row, a0 + static_cast<double>(i), b0),
        c(column, a0 + static_cast<double>(i), b0);
    for (std::size_t j = 0; j < columns; ++j)
      out[j] = sample(tile, r.at(static_cast<float>(j)), c.at(static_cast<float>(j)));
  }
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void fill_avx2(const Tile& tile, const Quadratic& row,
                                               const Quadratic& column, double a0, double b0,
                                               std::size_t rows, std::size_t columns, float* out,
                                               std::size_t stride) {
  const __m256 lanes = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
  const float* nodes = tile.dz_m.data();
  for (std::size_t i = 0; i < rows; ++i, out += stride) {
    const RowQuadratic r(row, a0 + static_cast<double>(i), b0),
        c(column, a0 + static_cast<double>(i), b0);
    const __m256 r0 = _mm256_set1_ps(r.c0), r1 = _mm256_set1_ps(r.c1), r2 = _mm256_set1_ps(r.c2);
    const __m256 c0 = _mm256_set1_ps(c.c0), c1 = _mm256_set1_ps(c.c1), c2 = _mm256_set1_ps(c.c2);
    std::size_t j = 0;
    for (; j + 8 <= columns; j += 8) {
      const __m256 k = _mm256_add_ps(lanes, _mm256_set1_ps(static_cast<float>(j)));
      const __m256 u = _mm256_add_ps(r0, _mm256_mul_ps(k, _mm256_add_ps(r1, _mm256_mul_ps(k, r2))));
      const __m256 v = _mm256_add_ps(c0, _mm256_mul_ps(k, _mm256_add_ps(c1, _mm256_mul_ps(k, c2))));
      const __m256i ui = _mm256_cvttps_epi32(u), vi = _mm256_cvttps_epi32(v);
      const __m256 fu = _mm256_sub_ps(u, _mm256_cvtepi32_ps(ui)),
                   fv = _mm256_sub_ps(v, _mm256_cvtepi32_ps(vi));
      const __m256i at = _mm256_add_epi32(_mm256_slli_epi32(ui, 3), vi);
      const __m256 z00 = _mm256_i32gather_ps(nodes, at, 4),
                   z01 = _mm256_i32gather_ps(nodes + 1, at, 4);
      const __m256 z10 = _mm256_i32gather_ps(nodes + kTileSide, at, 4),
                   z11 = _mm256_i32gather_ps(nodes + kTileSide + 1, at, 4);
      const __m256 low = _mm256_add_ps(z00, _mm256_mul_ps(fv, _mm256_sub_ps(z01, z00)));
      const __m256 high = _mm256_add_ps(z10, _mm256_mul_ps(fv, _mm256_sub_ps(z11, z10)));
      _mm256_storeu_ps(out + j, _mm256_add_ps(low, _mm256_mul_ps(fu, _mm256_sub_ps(high, low))));
    }
    for (; j < columns; ++j)
      out[j] = sample(tile, r.at(static_cast<float>(j)), c.at(static_cast<float>(j)));
  }
}
#endif

}  // namespace

bool available(StripKernel kernel) {
#if defined(__x86_64__)
  return kernel != StripKernel::Avx2 || __builtin_cpu_supports("avx2");
#else
  return kernel != StripKernel::Avx2;
#endif
}

void fill_from_tile(const Tile& tile, const Quadratic& row, const Quadratic& column, double a0,
                    double b0, std::size_t rows, std::size_t columns, float* out,
                    std::size_t stride, StripKernel kernel) noexcept {
#if defined(__x86_64__)
  if (kernel != StripKernel::Scalar && __builtin_cpu_supports("avx2")) {
    fill_avx2(tile, row, column, a0, b0, rows, columns, out, stride);
    return;
  }
#endif
  static_cast<void>(kernel);
  fill_scalar(tile, row, column, a0, b0, rows, columns, out, stride);
}

}  // namespace crg
