// The functions that the laws ask of a number or of a pack: the same operations for both, so that a
// lane has the bits of the single number, on every machine and whatever its library of mathematics.
//
// Each goes from the nearest value of a table, or from an interval that its argument is reduced to,
// by a Taylor series (tanh: by a continued fraction). Right to about the last place (maths_test).
// Arguments far from what laws ask go to the library's own functions, number by number.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "vehicle/lanes.h"
#include "vehicle/maths_tables.h"

namespace vehicle::maths {

using std::abs;
using std::sqrt;

/// Added to a number of less than 2^51 it leaves the nearest whole number in the last bits.
inline constexpr double kRounder = 6755399441055744.0;

inline constexpr double kTurn[] = {4.0 * 1.5707963267341256, 4.0 * 6.077100506303966e-11,
                                   4.0 * 2.0222662487959506e-21};
inline constexpr double kLn2[] = {0.6931471805601177, -1.7239444525614835e-13};
inline constexpr double kSixteenthOfLn2[] = {0.04332169878489367, 1.0291218489310676e-13};
inline constexpr double kPi = 3.141592653589793;

/// The value of a table that the last bits of `shifted` say; for packs: native.h.
inline double looked_up(const double* table, double shifted, std::uint64_t bits) {
  return table[std::bit_cast<std::uint64_t>(shifted) & bits];
}

/// 2^floor(k / 16) of `shifted`, k from -16000 to 16000 with kRounder added; 16368 is 16 times
/// 1023, the exponent of 1.
inline double power_of_two(double shifted) {
  return std::bit_cast<double>((std::bit_cast<std::uint64_t>(shifted) + 16368) >> 4 << 52);
}
template <int N>
[[gnu::always_inline]] inline Pack<N> power_of_two(const Pack<N>& shifted) {
  const typename Pack<N>::Bits bits = (shifted.bits() + 16368) >> 4 << 52;
  return Pack<N>(reinterpret_cast<typename Pack<N>::Vector>(bits));
}

/// x = fraction 2^exponent, fraction from 1 to below 2; x normal and above 0.
inline double fraction_of(double x) {
  return std::bit_cast<double>((std::bit_cast<std::uint64_t>(x) & 0xfffffffffffffu) |
                               0x3ff0000000000000u);
}
template <int N>
[[gnu::always_inline]] inline Pack<N> fraction_of(const Pack<N>& x) {
  const typename Pack<N>::Bits bits = (x.bits() & 0xfffffffffffffu) | 0x3ff0000000000000u;
  return Pack<N>(reinterpret_cast<typename Pack<N>::Vector>(bits));
}
inline double exponent_of(double x) {  // the exponent in the last bits of 2^52
  return std::bit_cast<double>((std::bit_cast<std::uint64_t>(x) >> 52) | 0x4330000000000000u) -
         (4503599627370496.0 + 1023.0);
}
template <int N>
[[gnu::always_inline]] inline Pack<N> exponent_of(const Pack<N>& x) {
  const typename Pack<N>::Bits bits = (x.bits() >> 52) | 0x4330000000000000u;
  return Pack<N>(reinterpret_cast<typename Pack<N>::Vector>(bits)) - (4503599627370496.0 + 1023.0);
}

/// x, or -x where the sign of `of` is negative.
inline double signed_as(double x, double of) {
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) ^
                               (std::bit_cast<std::uint64_t>(of) & 0x8000000000000000u));
}
template <int N>
[[gnu::always_inline]] inline Pack<N> signed_as(const Pack<N>& x, const Pack<N>& of) {
  const typename Pack<N>::Bits bits = x.bits() ^ (of.bits() & 0x8000000000000000u);
  return Pack<N>(reinterpret_cast<typename Pack<N>::Vector>(bits));
}

/// The library's function, number by number: for arguments that the series do not know.
template <class F>
double one_by_one(double x, const F& f) {
  return f(x);
}
template <int N, class F>
Pack<N> one_by_one(const Pack<N>& x, const F& f) {
  Pack<N> out(0.0);
  for (std::size_t lane = 0; lane < N; ++lane) out.set(lane, f(x[lane]));
  return out;
}

/// Sine and cosine of one angle.
template <class T>
struct Waves {
  T sine, cosine;

  friend Waves select(const Flag<T>& which, const Waves& a, const Waves& b) {
    return {vehicle::select(which, a.sine, b.sine), vehicle::select(which, a.cosine, b.cosine)};
  }
};

/// Of angles of less than kNearAngle, by the sum with that of the table.
inline constexpr double kNearAngle = 7.9;
template <class T>
[[gnu::always_inline]] inline Waves<T> near_waves(const T& x) {
  const T size = abs(x);
  const T shifted = size * 16.0 + kRounder;
  const T d = size - (shifted - kRounder) * (1.0 / 16.0);
  const T s = looked_up(kSines, shifted, 127), c = looked_up(kCosines, shifted, 127);
  const T z = d * d, z2 = z * z;
  const T of_d = d + d * (z * ((-1.0 / 6.0 + z * (1.0 / 120.0)) + z2 * (-1.0 / 5040.0)));
  const T less = z * ((-0.5 + z * (1.0 / 24.0)) + z2 * (-1.0 / 720.0 + z * (1.0 / 40320.0)));
  return {signed_as(T(s + (c * of_d + s * less)), x), c + (c * less - s * of_d)};
}

/// Of any angle: less whole turns (W. J. Cody and W. Waite, Software Manual for the Elementary
/// Functions, 1980: in three parts).
template <class T>
[[gnu::always_inline]] inline Waves<T> any_waves(const T& x) {
  const auto turned = [&] {
    const T n = (x * 0.15915494309189535 + kRounder) - kRounder;
    return near_waves(T(((x - n * kTurn[0]) - n * kTurn[1]) - n * kTurn[2]));
  };
  const auto far = [&] {
    return Waves<T>{one_by_one(x, [](double far_x) { return std::sin(far_x); }),
                    one_by_one(x, [](double far_x) { return std::cos(far_x); })};
  };
  const T size = abs(x);
  return choose(
      size < T(kNearAngle), [&] { return near_waves(x); },
      [&] { return choose(size < T(1e5), turned, far); });
}

/// x between -700 and 700.
template <class T>
[[gnu::always_inline]] inline T near_exponential(const T& x) {
  const T shifted = x * 23.083120654223414 + kRounder;
  const T k = shifted - kRounder;
  const T r = (x - k * kSixteenthOfLn2[0]) - k * kSixteenthOfLn2[1];
  const T s = looked_up(kSixteenths, shifted, 15);
  const T z = r * r;
  const T p = ((1.0 / 2.0 + r * (1.0 / 6.0)) + z * (1.0 / 24.0 + r * (1.0 / 120.0))) +
              (z * z) * (1.0 / 720.0 + r * (1.0 / 5040.0));
  return (s + s * (r + z * p)) * power_of_two(shifted);
}
template <class T>
T exponential(const T& x) {
  return choose(
      abs(x) < T(700), [&] { return near_exponential(x); },
      [&] { return one_by_one(x, [](double far_x) { return std::exp(far_x); }); });
}

/// ln(f 2^e) = e ln 2 + 2 artanh((f - 1) / (f + 1)).
template <class T>
T logarithm(const T& x) {
  const auto known = x > T(1e-300) && x < T(1e300);
  const T fraction = fraction_of(x);
  const auto large = fraction > T(1.4142135623730951);
  const T f = select(large, T(0.5 * fraction), fraction);
  const T e = exponent_of(x) + select(large, T(1.0), T(0.0));
  const T s = (f - 1.0) / (f + 1.0);
  const T z = s * s, z2 = z * z, z4 = z2 * z2;
  const T p = ((2.0 / 3.0 + z * (2.0 / 5.0)) + z2 * (2.0 / 7.0 + z * (2.0 / 9.0))) +
              z4 * (((2.0 / 11.0 + z * (2.0 / 13.0)) + z2 * (2.0 / 15.0 + z * (2.0 / 17.0))) +
                    z4 * (2.0 / 19.0 + z * (2.0 / 21.0)));
  const T near = e * kLn2[0] + ((s + s) + (s * (z * p) + e * kLn2[1]));
  if (all(known)) return near;
  return select(known, near, one_by_one(x, [](double far_x) { return std::log(far_x); }));
}

/// By atan x = atan c + atan((x - c) / (1 + c x)) with c of the table; x from 0 to 15.9.
template <class T>
[[gnu::always_inline]] inline T near_arc_tangent(const T& x) {
  const T shifted = x * 16.0 + kRounder;
  const T c = (shifted - kRounder) * (1.0 / 16.0);
  const T t = (x - c) / (1.0 + x * c);
  const T z = t * t;
  const T p = (-1.0 / 3.0 + z * (1.0 / 5.0)) +
              (z * z) * ((-1.0 / 7.0 + z * (1.0 / 9.0)) + (z * z) * (-1.0 / 11.0));
  return looked_up(kArcTangents, shifted, 255) + (t + t * (z * p));
}
template <class T>
T arc_tangent(const T& x) {
  const T size = abs(x);
  const auto within = size < T(15.9);
  const T beside = near_arc_tangent(choose(
      within, [&] { return size; }, [&] { return T(1.0 / size); }));
  return signed_as(select(within, beside, T(1.5707963267948966 - (beside - 6.123233995736766e-17))),
                   x);
}

/// Near zero the continued fraction x / (1 + x^2 / (3 + x^2 / (5 + ...))) to 15, else by exp.
template <class T>
T hyperbolic_tangent(const T& x) {
  const T size = abs(x);
  const auto low = [&] {
    const T z = x * x, z2 = z * z;
    const T above = (2027025.0 + z * 270270.0) + z2 * (6930.0 + z * 36.0);
    const T below = ((2027025.0 + z * 945945.0) + z2 * (51975.0 + z * 630.0)) + z2 * z2;
    return T(x * (above / below));
  };
  const auto high = [&] {
    const T held = select(size > T(22), T(22), size);  // there it is 1
    return signed_as(T(1.0 - 2.0 / (exponential(T(held + held)) + 1.0)), x);
  };
  return choose(size < T(0.625), low, high);
}

// What laws call: for one number compiled once, in maths.cpp.
double sin(double x);
double cos(double x);
Waves<double> waves(double x);
double atan(double x);
double exp(double x);
double log(double x);
double tanh(double x);

template <int N>
[[gnu::noinline]] Pack<N> sin(Pack<N> x) {
  return any_waves(x).sine;
}
template <int N>
[[gnu::noinline]] Pack<N> cos(Pack<N> x) {
  return any_waves(x).cosine;
}
template <int N>
[[gnu::noinline]] Waves<Pack<N>> waves(Pack<N> x) {
  return any_waves(x);
}
template <int N>
[[gnu::noinline]] Pack<N> atan(Pack<N> x) {
  return arc_tangent(x);
}
template <int N>
[[gnu::noinline]] Pack<N> exp(Pack<N> x) {
  return exponential(x);
}
template <int N>
[[gnu::noinline]] Pack<N> log(Pack<N> x) {
  return logarithm(x);
}
template <int N>
[[gnu::noinline]] Pack<N> tanh(Pack<N> x) {
  return hyperbolic_tangent(x);
}

/// Of other scalars by their own functions.
template <class T>
Waves<T> waves(const T& x) {
  return {sin(x), cos(x)};
}

/// Of two angles.
template <class T>
std::array<Waves<T>, 2> waves_of(const T& first, const T& second) {
  if constexpr (std::is_same_v<T, double>) {
    const Waves<Pack<2>> both = waves(pair(first, second));
    return {{{both.sine[0], both.cosine[0]}, {both.sine[1], both.cosine[1]}}};
  } else {
    return {waves(first), waves(second)};
  }
}

/// x at least 0.
template <class T>
T power(const T& x, double exponent) {
  return exp(T(exponent * log(x)));
}
inline double pow(double x, double exponent) { return power(x, exponent); }
template <int N>
Pack<N> pow(const Pack<N>& x, double exponent) {
  return power(x, exponent);
}

template <class T>
T arc_sine(const T& x) {
  return atan(T(x / sqrt(T((1.0 - x) * (1.0 + x)))));
}
inline double asin(double x) { return arc_sine(x); }
template <int N>
Pack<N> asin(const Pack<N>& x) {
  return arc_sine(x);
}

template <class T>
T arc_cosine(const T& x) {
  return 2.0 * atan(T(sqrt(T((1.0 - x) / (1.0 + x)))));
}
inline double acos(double x) { return arc_cosine(x); }
template <int N>
Pack<N> acos(const Pack<N>& x) {
  return arc_cosine(x);
}

/// Of finite numbers, not both 0.
template <class T>
T arc_tangent2(const T& y, const T& x) {
  const T forward = atan(T(y / x));  // y / 0 is infinite, its angle right
  return select(x < T(0), T(forward + signed_as(T(kPi), y)), forward);
}
inline double atan2(double y, double x) { return arc_tangent2(y, x); }
template <int N>
Pack<N> atan2(const Pack<N>& y, const Pack<N>& x) {
  return arc_tangent2(y, x);
}

}  // namespace vehicle::maths
