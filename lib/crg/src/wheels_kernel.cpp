#include "wheels_kernel.h"

#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace crg {

#if defined(__x86_64__)

#define KERBSTONE_AVX2 __attribute__((target("avx2")))
// Parts of one loop's body: a call would pass vectors through memory.
#define KERBSTONE_AVX2_INLINE __attribute__((target("avx2"), always_inline)) inline

namespace {

// Four structs of four numbers <-> four numbers of each kind.
struct Four {
  __m256d a, b, c, d;
};

KERBSTONE_AVX2 inline Four transposed(const Four& m) {
  const __m256d ab_even = _mm256_unpacklo_pd(m.a, m.b), ab_odd = _mm256_unpackhi_pd(m.a, m.b);
  const __m256d cd_even = _mm256_unpacklo_pd(m.c, m.d), cd_odd = _mm256_unpackhi_pd(m.c, m.d);
  return {
      _mm256_permute2f128_pd(ab_even, cd_even, 0x20), _mm256_permute2f128_pd(ab_odd, cd_odd, 0x20),
      _mm256_permute2f128_pd(ab_even, cd_even, 0x31), _mm256_permute2f128_pd(ab_odd, cd_odd, 0x31)};
}

KERBSTONE_AVX2 inline Four loaded(const double* a, const double* b, const double* c,
                                  const double* d) {
  return transposed(
      {_mm256_loadu_pd(a), _mm256_loadu_pd(b), _mm256_loadu_pd(c), _mm256_loadu_pd(d)});
}

// a + t (b - a)
KERBSTONE_AVX2 inline __m256d between(__m256d a, __m256d b, __m256d t) {
  return _mm256_add_pd(a, _mm256_mul_pd(t, _mm256_sub_pd(b, a)));
}

// Two neighbouring nodes under each of four wheels, as the right ones and the left ones.
struct Pairs {
  __m256d right, left;
};

KERBSTONE_AVX2 inline Pairs pairs(const float* const node[4], std::size_t offset) {
  const auto two = [&](int first, int second) KERBSTONE_AVX2 {
    double low, high;  // two floats each, not aligned as a double is
    std::memcpy(&low, node[first] + offset, sizeof low);
    std::memcpy(&high, node[second] + offset, sizeof high);
    return _mm_castpd_ps(_mm_set_pd(high, low));
  };
  const __m128 first = two(0, 1), last = two(2, 3);
  return {_mm256_cvtps_pd(_mm_shuffle_ps(first, last, 0x88)),
          _mm256_cvtps_pd(_mm_shuffle_ps(first, last, 0xDD))};
}

// The segment that each wheel is expected on.
struct Rows {
  __m256d steps;  // from the last one
  __m256i segment;
  alignas(32) std::size_t of[4];
};

// False: one of them is outside the line.
KERBSTONE_AVX2_INLINE bool expected_rows(const Four& cursor, std::size_t segments, Rows& rows) {
  const __m256d large = _mm256_set1_pd(kLarge);
  const __m256d sum =
      _mm256_add_pd(_mm256_add_pd(_mm256_sub_pd(cursor.b, _mm256_set1_pd(kHalf)), cursor.c), large);
  rows.steps = _mm256_sub_pd(sum, large);
  rows.segment =
      _mm256_add_epi64(_mm256_castpd_si256(cursor.a),
                       _mm256_sub_epi64(_mm256_castpd_si256(sum), _mm256_castpd_si256(large)));
  const __m256i in_range = _mm256_and_si256(
      _mm256_cmpgt_epi64(_mm256_set1_epi64x(static_cast<long long>(segments)), rows.segment),
      _mm256_cmpgt_epi64(rows.segment, _mm256_set1_epi64x(-1)));
  if (_mm256_movemask_pd(_mm256_castsi256_pd(in_range)) != 15) return false;
  _mm256_store_si256(reinterpret_cast<__m256i*>(rows.of), rows.segment);
  return true;
}

// Where each wheel is on its segment.
struct Places {
  __m256d fraction, v_m;
};

// False: one of them is not certain to be on the expected segment.
KERBSTONE_AVX2_INLINE bool places_on(const SegmentRecord* records, const Rows& rows,
                                     const Point2* points, Places& places) {
  const auto record = [&](int k) { return reinterpret_cast<const double*>(records + rows.of[k]); };
  const Four front = loaded(record(0), record(1), record(2), record(3));
  const Four back = loaded(record(0) + 4, record(1) + 4, record(2) + 4, record(3) + 4);
  const double* xy = reinterpret_cast<const double*>(points);
  const __m256d p01 = _mm256_loadu_pd(xy), p23 = _mm256_loadu_pd(xy + 4);
  const __m256d p02 = _mm256_permute2f128_pd(p01, p23, 0x20),
                p13 = _mm256_permute2f128_pd(p01, p23, 0x31);
  const __m256d dx = _mm256_sub_pd(_mm256_unpacklo_pd(p02, p13), front.a),
                dy = _mm256_sub_pd(_mm256_unpackhi_pd(p02, p13), front.b);
  const __m256d s = _mm256_add_pd(_mm256_mul_pd(dx, front.c), _mm256_mul_pd(dy, front.d));
  const __m256d v = _mm256_sub_pd(_mm256_mul_pd(dy, front.c), _mm256_mul_pd(dx, front.d));
  const __m256d past_begin = _mm256_sub_pd(s, _mm256_mul_pd(v, back.b));
  const __m256d width = _mm256_add_pd(back.a, _mm256_mul_pd(v, _mm256_sub_pd(back.c, back.b)));
  const __m256d fraction = _mm256_div_pd(past_begin, width);
  // The two floats in each lane of back.d: right bounds to the lower half, left bounds to the
  // upper.
  const __m256 bounds =
      _mm256_permutevar8x32_ps(_mm256_castpd_ps(back.d), _mm256_setr_epi32(0, 2, 4, 6, 1, 3, 5, 7));
  const __m256d right = _mm256_cvtps_pd(_mm256_castps256_ps128(bounds)),
                left = _mm256_cvtps_pd(_mm256_extractf128_ps(bounds, 1));
  const __m256d along =
      _mm256_and_pd(_mm256_cmp_pd(fraction, _mm256_setzero_pd(), _CMP_GE_OQ),
                    _mm256_cmp_pd(fraction, _mm256_set1_pd(1.0 - kNearMitre), _CMP_LT_OQ));
  const __m256d across =
      _mm256_and_pd(_mm256_cmp_pd(v, right, _CMP_GE_OQ), _mm256_cmp_pd(v, left, _CMP_LE_OQ));
  places = {fraction, v};
  return _mm256_movemask_pd(_mm256_and_pd(along, across)) == 15;
}

// Heights of the road there; NaN where it has none. `advance`: in rows, since the last query.
KERBSTONE_AVX2_INLINE __m256d heights_at(const HeightField& heights, const Rows& rows,
                                         const Places& places, __m256d advance) {
  const __m256d columns =
      _mm256_mul_pd(_mm256_sub_pd(places.v_m, _mm256_set1_pd(heights.v_right_m())),
                    _mm256_set1_pd(heights.per_v_step()));
  const __m128i column = _mm_min_epi32(_mm256_cvttpd_epi32(columns),
                                       _mm_set1_epi32(static_cast<int>(heights.columns()) - 2));
  const __m256d fv = _mm256_sub_pd(columns, _mm256_cvtepi32_pd(column));
  alignas(16) int column_of[4];
  _mm_store_si128(reinterpret_cast<__m128i*>(column_of), column);
  const float* node[4];
  for (int k = 0; k < 4; ++k)
    node[k] = heights.node(rows.of[k], static_cast<std::size_t>(column_of[k]));
  const int backwards = _mm256_movemask_pd(advance);
  for (int k = 0; k < 4; ++k)
    prefetch_row(node[k],
                 (backwards & (1 << k)) != 0 ? -heights.ahead_bytes() : heights.ahead_bytes());

  const Pairs low = pairs(node, 0), high = pairs(node, heights.columns());
  const __m256d grid = between(between(low.right, low.left, fv), between(high.right, high.left, fv),
                               places.fraction);
  const auto line_at = [&](int k) {
    return reinterpret_cast<const double*>(heights.line() + rows.of[k]);
  };
  const Four line = loaded(line_at(0), line_at(1), line_at(2), line_at(3));
  return _mm256_add_pd(_mm256_add_pd(grid, between(line.a, line.c, places.fraction)),
                       _mm256_mul_pd(between(line.b, line.d, places.fraction), places.v_m));
}

}  // namespace

bool four_wheels_available() noexcept { return __builtin_cpu_supports("avx2"); }

KERBSTONE_AVX2 bool z_of_four_wheels(const Locator& locator, const HeightField& heights,
                                     const Point2* points, Cursor* cursors, double* z_m) noexcept {
  static_assert(sizeof(Cursor) == 32 && sizeof(Point2) == 16 && sizeof(SegmentRecord) == 64 &&
                sizeof(LineNode) == 16);
  const auto cursor_at = [&](int k) { return reinterpret_cast<double*>(cursors + k); };
  const Four cursor = loaded(cursor_at(0), cursor_at(1), cursor_at(2), cursor_at(3));
  Rows rows;
  Places places;
  if (!expected_rows(cursor, locator.segments(), rows) ||
      !places_on(locator.records(), rows, points, places))
    return false;
  const __m256d advance = _mm256_add_pd(_mm256_sub_pd(rows.steps, cursor.b), places.fraction);
  const __m256d z = heights_at(heights, rows, places, advance);
  if (_mm256_movemask_pd(_mm256_cmp_pd(z, z, _CMP_UNORD_Q)) != 0) return false;
  _mm256_storeu_pd(z_m, z);
  const Four moved =
      transposed({_mm256_castsi256_pd(rows.segment), places.fraction, advance, advance});
  _mm256_storeu_pd(cursor_at(0), moved.a);
  _mm256_storeu_pd(cursor_at(1), moved.b);
  _mm256_storeu_pd(cursor_at(2), moved.c);
  _mm256_storeu_pd(cursor_at(3), moved.d);
  return true;
}

#else

bool four_wheels_available() noexcept { return false; }
bool z_of_four_wheels(const Locator&, const HeightField&, const Point2*, Cursor*,
                      double*) noexcept {
  return false;
}

#endif

}  // namespace crg
