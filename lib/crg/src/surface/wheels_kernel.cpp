#include "wheels_kernel.h"

#include <array>
#include <cstdint>
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

// Lanes belong to the wheels 0, 2, 1, 3: so two numbers of each of four wheels part with one
// instruction for each kind, and none crosses the middle of a register.
struct Two {
  __m256d first, second;
};

KERBSTONE_AVX2_INLINE Two parted(__m256d of_0_1, __m256d of_2_3) {
  return {_mm256_unpacklo_pd(of_0_1, of_2_3), _mm256_unpackhi_pd(of_0_1, of_2_3)};
}

KERBSTONE_AVX2_INLINE __m256d both(const double* low, const double* high) {
  return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(low)), _mm_loadu_pd(high), 1);
}

// From four pointers, in the order of the lanes.
template <typename T>
struct At {
  const T* of_0;
  const T* of_2;
  const T* of_1;
  const T* of_3;
};

KERBSTONE_AVX2_INLINE Two parted(const At<double>& at, std::size_t offset) {
  return parted(both(at.of_0 + offset, at.of_1 + offset), both(at.of_2 + offset, at.of_3 + offset));
}

// a + t (b - a)
KERBSTONE_AVX2_INLINE __m256d between(__m256d a, __m256d b, __m256d t) {
  return _mm256_add_pd(a, _mm256_mul_pd(t, _mm256_sub_pd(b, a)));
}

// Two neighbouring nodes under each wheel, as the right ones and the left ones.
struct Pairs {
  __m256d right, left;
};

KERBSTONE_AVX2_INLINE __m128 two_floats_each(const float* low, const float* high) {
  double a, b;  // not aligned as a double is
  std::memcpy(&a, low, sizeof a);
  std::memcpy(&b, high, sizeof b);
  return _mm_castpd_ps(_mm_set_pd(b, a));
}

KERBSTONE_AVX2_INLINE Pairs pairs(const At<float>& node, std::size_t offset) {
  const __m128 first = two_floats_each(node.of_0 + offset, node.of_2 + offset),
               last = two_floats_each(node.of_1 + offset, node.of_3 + offset);
  return {_mm256_cvtps_pd(_mm_shuffle_ps(first, last, 0x88)),
          _mm256_cvtps_pd(_mm_shuffle_ps(first, last, 0xDD))};
}

// base + stride * number, for the four numbers in a register.
template <typename T>
KERBSTONE_AVX2_INLINE At<T> at(const T* base, std::size_t stride, __m128i numbers) {
  const auto low = static_cast<std::uint64_t>(_mm_cvtsi128_si64(numbers)),
             high = static_cast<std::uint64_t>(_mm_extract_epi64(numbers, 1));
  return {base + stride * static_cast<std::uint32_t>(low), base + stride * (low >> 32U),
          base + stride * static_cast<std::uint32_t>(high), base + stride * (high >> 32U)};
}

// Where each wheel is on its segment, and how that lies.
struct Places {
  __m256d fraction, v_m;
  __m256d cos, sin, width, begin_lean, lean_change;
};

// False: one of them is not certain to be on the expected segment.
KERBSTONE_AVX2_INLINE bool places_on(const At<double>& record, const Point2* points,
                                     Places& places) {
  const double* xy = reinterpret_cast<const double*>(points);
  const Two d = parted(_mm256_sub_pd(_mm256_loadu_pd(xy), both(record.of_0, record.of_1)),
                       _mm256_sub_pd(_mm256_loadu_pd(xy + 4), both(record.of_2, record.of_3)));
  const auto [cos, sin] = parted(record, 2);
  const auto [length, begin_lean] = parted(record, 4);
  const auto [lean_change, certain] = parted(record, 6);
  const __m256d s = _mm256_add_pd(_mm256_mul_pd(d.first, cos), _mm256_mul_pd(d.second, sin));
  const __m256d v = _mm256_sub_pd(_mm256_mul_pd(d.second, cos), _mm256_mul_pd(d.first, sin));
  const __m256d past_begin = _mm256_sub_pd(s, _mm256_mul_pd(v, begin_lean));
  const __m256d width = _mm256_add_pd(length, _mm256_mul_pd(v, lean_change));
  const __m256d fraction = _mm256_div_pd(past_begin, width);
  // The two floats in each lane of `certain`: right bounds to the lower half, left bounds to the
  // upper.
  const __m256 bounds = _mm256_permutevar8x32_ps(_mm256_castpd_ps(certain),
                                                 _mm256_setr_epi32(0, 2, 4, 6, 1, 3, 5, 7));
  const __m256d right = _mm256_cvtps_pd(_mm256_castps256_ps128(bounds)),
                left = _mm256_cvtps_pd(_mm256_extractf128_ps(bounds, 1));
  const __m256d along =
      _mm256_and_pd(_mm256_cmp_pd(fraction, _mm256_setzero_pd(), _CMP_GE_OQ),
                    _mm256_cmp_pd(fraction, _mm256_set1_pd(1.0 - kNearMitre), _CMP_LT_OQ));
  const __m256d across =
      _mm256_and_pd(_mm256_cmp_pd(v, right, _CMP_GE_OQ), _mm256_cmp_pd(v, left, _CMP_LE_OQ));
  places = {fraction, v, cos, sin, width, begin_lean, lean_change};
  return _mm256_movemask_pd(_mm256_and_pd(along, across)) == 15;
}

// Nodes around each wheel, the line beside it, and where it is between them.
struct Cells {
  Pairs low, high;
  Two here, next;
  __m256d fv;
};

KERBSTONE_AVX2_INLINE Cells cells_at(const HeightField& heights, __m128i row, __m256d v_m,
                                     bool back) {
  const __m256d columns = _mm256_mul_pd(_mm256_sub_pd(v_m, _mm256_set1_pd(heights.v_right_m())),
                                        _mm256_set1_pd(heights.per_v_step()));
  const auto in_row = static_cast<int>(heights.columns());
  const __m128i column = _mm_min_epi32(_mm256_cvttpd_epi32(columns), _mm_set1_epi32(in_row - 2));
  const At<float> node = at(heights.node(0, 0), 1,
                            _mm_add_epi32(_mm_mullo_epi32(row, _mm_set1_epi32(in_row)), column));
  const std::ptrdiff_t ahead = heights.ahead_bytes(back);
  prefetch_row(node.of_0, ahead);
  prefetch_row(node.of_2, ahead);
  prefetch_row(node.of_1, ahead);
  prefetch_row(node.of_3, ahead);
  const At<double> line =
      at(reinterpret_cast<const double*>(heights.line()), sizeof(LineNode) / sizeof(double), row);
  return {pairs(node, 0), pairs(node, heights.columns()), parted(line, 0), parted(line, 2),
          _mm256_sub_pd(columns, _mm256_cvtepi32_pd(column))};
}

// Heights of the road there; NaN where it has none.
KERBSTONE_AVX2_INLINE __m256d heights_at(const HeightField& heights, __m128i row,
                                         const Places& places, bool back) {
  const Cells c = cells_at(heights, row, places.v_m, back);
  const __m256d grid = between(between(c.low.right, c.low.left, c.fv),
                               between(c.high.right, c.high.left, c.fv), places.fraction);
  return _mm256_add_pd(
      _mm256_add_pd(grid, between(c.here.first, c.next.first, places.fraction)),
      _mm256_mul_pd(between(c.here.second, c.next.second, places.fraction), places.v_m));
}

// HeightField::at_simple(), then the slope as a Sample has it.
struct Slopes {
  __m256d z_m, dzdx, dzdy;
};

KERBSTONE_AVX2_INLINE Slopes slopes_at(const HeightField& heights, __m128i row,
                                       const Places& places, bool back) {
  const Cells c = cells_at(heights, row, places.v_m, back);
  const __m256d fu = places.fraction, v = places.v_m;
  const __m256d low_step = _mm256_sub_pd(c.low.left, c.low.right),
                high_step = _mm256_sub_pd(c.high.left, c.high.right);
  const __m256d low = _mm256_add_pd(c.low.right, _mm256_mul_pd(c.fv, low_step)),
                high = _mm256_add_pd(c.high.right, _mm256_mul_pd(c.fv, high_step));
  const __m256d change = _mm256_sub_pd(high, low);
  const __m256d grid = _mm256_add_pd(low, _mm256_mul_pd(fu, change));
  const __m256d step = between(low_step, high_step, fu);
  const __m256d line_change = _mm256_sub_pd(c.next.first, c.here.first),
                bank_change = _mm256_sub_pd(c.next.second, c.here.second);
  const __m256d line = _mm256_add_pd(c.here.first, _mm256_mul_pd(fu, line_change)),
                bank = _mm256_add_pd(c.here.second, _mm256_mul_pd(fu, bank_change));
  const __m256d along_u = _mm256_mul_pd(
      _mm256_add_pd(_mm256_add_pd(change, line_change), _mm256_mul_pd(bank_change, v)),
      _mm256_set1_pd(heights.per_u_step()));
  const __m256d along_v =
      _mm256_add_pd(_mm256_mul_pd(step, _mm256_set1_pd(heights.per_v_step())), bank);
  const __m256d along =
      _mm256_mul_pd(along_u, _mm256_div_pd(_mm256_set1_pd(heights.u_step_m()), places.width));
  const __m256d lean = _mm256_add_pd(places.begin_lean, _mm256_mul_pd(fu, places.lean_change));
  const __m256d across = _mm256_sub_pd(along_v, _mm256_mul_pd(lean, along));
  return {_mm256_add_pd(_mm256_add_pd(grid, line), _mm256_mul_pd(bank, v)),
          _mm256_sub_pd(_mm256_mul_pd(along, places.cos), _mm256_mul_pd(across, places.sin)),
          _mm256_add_pd(_mm256_mul_pd(along, places.sin), _mm256_mul_pd(across, places.cos))};
}

// In the order of the wheels.
KERBSTONE_AVX2_INLINE void put(std::array<double, 4>& to, __m256d lanes) {
  _mm256_storeu_pd(to.data(), _mm256_permute4x64_pd(lanes, 0xD8));
}

// segment_ahead() of four cursors, in the order of the lanes.
KERBSTONE_AVX2_INLINE __m128i segments_ahead(__m256d ahead) {
  const __m256i bits = _mm256_srli_epi64(_mm256_castpd_si256(ahead), kFractionBits);
  return _mm256_castsi256_si128(
      _mm256_permutevar8x32_epi32(bits, _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6)));
}

// Where each wheel is, if all are where their cursors lead.
KERBSTONE_AVX2_INLINE bool places_ahead(const Locator& locator,
                                        const std::array<const Cursor*, 4>& cursors,
                                        const Point2* points, Places& places) {
  const std::size_t of_0 = segment_ahead(*cursors[0]), of_1 = segment_ahead(*cursors[1]),
                    of_2 = segment_ahead(*cursors[2]), of_3 = segment_ahead(*cursors[3]);
  const std::size_t end = locator.segments();
  if (of_0 >= end || of_1 >= end || of_2 >= end || of_3 >= end) return false;
  const auto* records = reinterpret_cast<const double*>(locator.records());
  constexpr std::size_t kRecord = sizeof(SegmentRecord) / sizeof(double);
  return places_on({records + kRecord * of_0, records + kRecord * of_2, records + kRecord * of_1,
                    records + kRecord * of_3},
                   points, places);
}

}  // namespace

bool four_wheels_available() noexcept { return __builtin_cpu_supports("avx2"); }

KERBSTONE_AVX2 bool z_of_four_wheels(const Locator& locator, const HeightField& heights,
                                     const Point2* points, Cursor* cursors, double* z_m) noexcept {
  static_assert(sizeof(Cursor) == 16 && sizeof(Point2) == 16 && sizeof(SegmentRecord) == 64 &&
                sizeof(LineNode) == 16);
  double* cursor = reinterpret_cast<double*>(cursors);
  Places places;
  if (!places_ahead(locator, {&cursors[0], &cursors[1], &cursors[2], &cursors[3]}, points, places))
    return false;
  const auto [before, expected] = parted(_mm256_loadu_pd(cursor), _mm256_loadu_pd(cursor + 4));
  const __m256d z =
      heights_at(heights, segments_ahead(expected), places,
                 _mm256_movemask_pd(_mm256_cmp_pd(expected, before, _CMP_LT_OQ)) == 15);
  if (_mm256_movemask_pd(_mm256_cmp_pd(z, z, _CMP_UNORD_Q)) != 0) return false;
  _mm256_storeu_pd(z_m, _mm256_permute4x64_pd(z, 0xD8));
  const __m256d begin = _mm256_and_pd(expected, _mm256_castsi256_pd(_mm256_set1_epi64x(
                                                    static_cast<std::int64_t>(kSegmentMask)))),
                now = _mm256_add_pd(begin, places.fraction);
  // now + (now - before), but with less to do once the fraction is known
  const __m256d ahead = _mm256_add_pd(_mm256_add_pd(begin, _mm256_sub_pd(begin, before)),
                                      _mm256_add_pd(places.fraction, places.fraction));
  _mm256_storeu_pd(cursor, _mm256_unpacklo_pd(now, ahead));
  _mm256_storeu_pd(cursor + 4, _mm256_unpackhi_pd(now, ahead));
  return true;
}

KERBSTONE_AVX2 bool ground_of_four_points(const Locator& locator, const HeightField& heights,
                                          double least_width_m, const Point2* points,
                                          Cursor* const* cursors, FourGrounds& out) noexcept {
  Places places;
  if (!places_ahead(locator, {cursors[0], cursors[1], cursors[2], cursors[3]}, points, places))
    return false;
  double* const of[] = {&cursors[0]->last, &cursors[1]->last, &cursors[2]->last, &cursors[3]->last};
  const auto [before, expected] = parted(both(of[0], of[1]), both(of[2], of[3]));
  const __m128i row = segments_ahead(expected);
  const Slopes slopes = slopes_at(
      heights, row, places, _mm256_movemask_pd(_mm256_cmp_pd(expected, before, _CMP_LT_OQ)) == 15);
  const __m256d known =
      _mm256_and_pd(_mm256_cmp_pd(slopes.z_m, slopes.z_m, _CMP_ORD_Q),
                    _mm256_cmp_pd(places.width, _mm256_set1_pd(least_width_m), _CMP_GE_OQ));
  if (_mm256_movemask_pd(known) != 15) return false;
  const __m256d u =
      _mm256_add_pd(_mm256_set1_pd(heights.u_begin_m()),
                    _mm256_mul_pd(_mm256_add_pd(_mm256_cvtepi32_pd(row), places.fraction),
                                  _mm256_set1_pd(heights.u_step_m())));
  put(out.u_m, u);
  put(out.v_m, places.v_m);
  put(out.z_m, slopes.z_m);
  put(out.dzdx, slopes.dzdx);
  put(out.dzdy, slopes.dzdy);
  const __m256d begin = _mm256_and_pd(expected, _mm256_castsi256_pd(_mm256_set1_epi64x(
                                                    static_cast<std::int64_t>(kSegmentMask)))),
                now = _mm256_add_pd(begin, places.fraction);
  const __m256d ahead = _mm256_add_pd(now, _mm256_sub_pd(now, before));
  const __m256d first = _mm256_unpacklo_pd(now, ahead), last = _mm256_unpackhi_pd(now, ahead);
  _mm_storeu_pd(of[0], _mm256_castpd256_pd128(first));
  _mm_storeu_pd(of[1], _mm256_extractf128_pd(first, 1));
  _mm_storeu_pd(of[2], _mm256_castpd256_pd128(last));
  _mm_storeu_pd(of[3], _mm256_extractf128_pd(last, 1));
  return true;
}

#else

bool four_wheels_available() noexcept { return false; }
bool ground_of_four_points(const Locator&, const HeightField&, double, const Point2*,
                           Cursor* const*, FourGrounds&) noexcept {
  return false;
}
bool z_of_four_wheels(const Locator&, const HeightField&, const Point2*, Cursor*,
                      double*) noexcept {
  return false;
}

#endif

}  // namespace crg
