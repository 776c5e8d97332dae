// Laws on one number or on a pack of cars: choices that both make, and the pack.
//
// A law that branches on a number of its scalar asks select(), choose() or any(). For double and
// for automatic differentiation these are the ordinary conditional; for a pack every car takes its
// own branch, and a branch that no car takes is not computed. Each lane of a pack does what the
// single number does, operation by operation, so that its bits are the same.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace vehicle {

template <int N>
struct Mask;
template <int N>
struct Pack;

/// What belongs to a scalar T: an answer yes or no, a number without derivatives, a whole number.
template <class T>
struct LaneTypes {
  using Flag = bool;
  using Real = double;
  using Int = int;
};
template <int N>
struct LaneTypes<Pack<N>> {
  using Flag = Mask<N>;
  using Real = Pack<N>;
  using Int = std::array<int, N>;
};
template <class T>
using Flag = typename LaneTypes<T>::Flag;
template <class T>
using Real = typename LaneTypes<T>::Real;
template <class T>
using Int = typename LaneTypes<T>::Int;

inline bool any(bool which) { return which; }
inline bool all(bool which) { return which; }

/// `a` where `which` says so, else `b`; both are there already.
template <class T>
T select(bool which, const T& a, const T& b) {
  return which ? a : b;
}

/// a() where `which` says so, else b(); what nobody takes is not called.
template <class A, class B>
auto choose(bool which, const A& a, const B& b) -> decltype(a()) {
  return which ? a() : b();
}

template <class T>
T larger(const T& a, const T& b) {
  return select(a < b, b, a);
}
template <class T>
T smaller(const T& a, const T& b) {
  return select(b < a, b, a);
}

/// The compiler's vectors of N numbers of 8 bytes.
template <int N>
struct Vectors;
template <>
struct Vectors<2> {
  using Doubles [[gnu::vector_size(16)]] = double;
  using Ints [[gnu::vector_size(16)]] = std::int64_t;
  using Bits [[gnu::vector_size(16)]] = std::uint64_t;
};
template <>
struct Vectors<4> {
  using Doubles [[gnu::vector_size(32)]] = double;
  using Ints [[gnu::vector_size(32)]] = std::int64_t;
  using Bits [[gnu::vector_size(32)]] = std::uint64_t;
};
template <>
struct Vectors<8> {
  using Doubles [[gnu::vector_size(64)]] = double;
  using Ints [[gnu::vector_size(64)]] = std::int64_t;
  using Bits [[gnu::vector_size(64)]] = std::uint64_t;
};

/// Answers of N cars.
template <int N>
struct Mask {
  using Vector = typename Vectors<N>::Ints;
  Vector v;

  Mask() = default;
  [[gnu::always_inline]] explicit Mask(const Vector& lanes) : v(lanes) {}
  [[gnu::always_inline]] Mask(bool all)
      : v(Vector{} - (all ? 1 : 0)) {}  // NOLINT: as a bool among bools

  [[gnu::always_inline]] bool operator[](std::size_t lane) const { return v[lane] != 0; }
  [[gnu::always_inline]] void set(std::size_t lane, bool which) { v[lane] = which ? -1 : 0; }
  [[gnu::always_inline]] friend Mask operator&&(const Mask& a, const Mask& b) {
    return Mask(Vector(a.v & b.v));
  }
  [[gnu::always_inline]] friend Mask operator||(const Mask& a, const Mask& b) {
    return Mask(Vector(a.v | b.v));
  }
  [[gnu::always_inline]] friend Mask operator!(const Mask& a) { return Mask(Vector(~a.v)); }
};

// For the instruction set that the pack is for: any() and sqrt(); of two lanes below, of more in
// lanes/native.h.
template <int N>
bool any(const Mask<N>& which);
template <>
[[gnu::always_inline]] inline bool any(const Mask<2>& which) {
#if defined(__SSE2__)
  return _mm_movemask_pd(reinterpret_cast<__m128d>(which.v)) != 0;
#else
  return (which.v[0] | which.v[1]) != 0;
#endif
}
template <int N>
[[gnu::always_inline]] inline bool all(const Mask<N>& which) {
  return !any(!which);
}

/// One number of each of N cars.
template <int N>
struct Pack {
  using Vector = typename Vectors<N>::Doubles;
  using Bits = typename Vectors<N>::Bits;
  Vector v;

  Pack() = default;
  [[gnu::always_inline]] explicit Pack(const Vector& lanes) : v(lanes) {}
  [[gnu::always_inline]] Pack(double each)
      : v(each - Vector{}) {}  // NOLINT: a number among packs; keeps the sign of 0

  [[gnu::always_inline]] double operator[](std::size_t lane) const { return v[lane]; }
  [[gnu::always_inline]] void set(std::size_t lane, double x) { v[lane] = x; }
  [[gnu::always_inline]] Bits bits() const { return reinterpret_cast<Bits>(v); }

  [[gnu::always_inline]] Pack& operator+=(const Pack& b) {
    v += b.v;
    return *this;
  }
  [[gnu::always_inline]] Pack& operator-=(const Pack& b) {
    v -= b.v;
    return *this;
  }
  [[gnu::always_inline]] Pack& operator*=(const Pack& b) {
    v *= b.v;
    return *this;
  }
  [[gnu::always_inline]] Pack& operator/=(const Pack& b) {
    v /= b.v;
    return *this;
  }
  [[gnu::always_inline]] friend Pack operator+(const Pack& a, const Pack& b) {
    return Pack(Vector(a.v + b.v));
  }
  [[gnu::always_inline]] friend Pack operator-(const Pack& a, const Pack& b) {
    return Pack(Vector(a.v - b.v));
  }
  [[gnu::always_inline]] friend Pack operator*(const Pack& a, const Pack& b) {
    return Pack(Vector(a.v * b.v));
  }
  [[gnu::always_inline]] friend Pack operator/(const Pack& a, const Pack& b) {
    return Pack(Vector(a.v / b.v));
  }
  [[gnu::always_inline]] friend Pack operator-(const Pack& a) { return Pack(Vector(-a.v)); }
  [[gnu::always_inline]] friend Mask<N> operator<(const Pack& a, const Pack& b) {
    return as_mask(a.v < b.v);
  }
  [[gnu::always_inline]] friend Mask<N> operator>(const Pack& a, const Pack& b) {
    return as_mask(a.v > b.v);
  }
  [[gnu::always_inline]] friend Mask<N> operator<=(const Pack& a, const Pack& b) {
    return as_mask(a.v <= b.v);
  }
  [[gnu::always_inline]] friend Mask<N> operator>=(const Pack& a, const Pack& b) {
    return as_mask(a.v >= b.v);
  }
  [[gnu::always_inline]] friend Mask<N> operator==(const Pack& a, const Pack& b) {
    return as_mask(a.v == b.v);
  }
  [[gnu::always_inline]] friend Mask<N> operator!=(const Pack& a, const Pack& b) {
    return as_mask(a.v != b.v);
  }

 private:
  template <class Lanes>
  [[gnu::always_inline]] static Mask<N> as_mask(const Lanes& lanes) {
    return Mask<N>(typename Mask<N>::Vector(lanes));
  }
};

template <class T>
inline constexpr bool kIsPack = false;
template <int N>
inline constexpr bool kIsPack<Pack<N>> = true;

template <int N>
[[gnu::always_inline]] inline Pack<N> select(const Mask<N>& which, const Pack<N>& a,
                                             const Pack<N>& b) {
  return Pack<N>(typename Pack<N>::Vector(which.v ? a.v : b.v));
}
template <int N>
[[gnu::always_inline]] inline Mask<N> select(const Mask<N>& which, const Mask<N>& a,
                                             const Mask<N>& b) {
  return (which && a) || (!which && b);
}
template <int N, class A, class B>
[[gnu::always_inline]] inline auto choose(const Mask<N>& which, const A& a, const B& b)
    -> decltype(a()) {
  if (all(which)) return a();
  if (!any(which)) return b();
  return select(which, a(), b());
}

template <int N>
[[gnu::always_inline]] inline Pack<N> abs(const Pack<N>& x) {
  const typename Pack<N>::Bits bits = x.bits() & 0x7fffffffffffffffu;
  return Pack<N>(reinterpret_cast<typename Pack<N>::Vector>(bits));
}

// Packs of two are of one car: its left and right wheel, two of its angles. Every processor has
// them.
[[gnu::always_inline]] inline Pack<2> pair(double first, double second) {
  return Pack<2>(Pack<2>::Vector{first, second});
}
[[gnu::always_inline]] inline Pack<2> looked_up(const double* table, const Pack<2>& shifted,
                                                std::uint64_t bits) {
  const Pack<2>::Bits index = shifted.bits() & bits;
  return pair(table[index[0]], table[index[1]]);
}
[[gnu::always_inline]] inline Pack<2> sqrt(const Pack<2>& x) {
#if defined(__SSE2__)
  return Pack<2>(_mm_sqrt_pd(x.v));
#else
  return pair(std::sqrt(x[0]), std::sqrt(x[1]));
#endif
}

}  // namespace vehicle
