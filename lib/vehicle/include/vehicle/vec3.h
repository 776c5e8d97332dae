// Three numbers of any scalar, as a vector; columns of a rotation.
#pragma once

#include <cmath>

#include "vehicle/maths.h"
#include "vehicle/parameters.h"

namespace vehicle {

template <class T>
struct Vec3 {
  T x = T(0), y = T(0), z = T(0);

  Vec3& operator+=(const Vec3& b) {
    x += b.x;
    y += b.y;
    z += b.z;
    return *this;
  }
  Vec3& operator-=(const Vec3& b) {
    x -= b.x;
    y -= b.y;
    z -= b.z;
    return *this;
  }
};

template <class T>
Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
Vec3<T> operator-(const Vec3<T>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class T>
Vec3<T> operator*(const T& s, const Vec3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <int N>
Vec3<Pack<N>> select(const Mask<N>& which, const Vec3<Pack<N>>& a, const Vec3<Pack<N>>& b) {
  return {select(which, a.x, b.x), select(which, a.y, b.y), select(which, a.z, b.z)};
}
template <class T>
T norm(const Vec3<T>& a) {
  using std::sqrt;
  return sqrt(dot(a, a));
}
template <class T>
Vec3<T> unit(const Vec3<T>& a) {
  return (T(1) / norm(a)) * a;
}

/// A rotation as the images of the axes: map-frame directions of the body's x, y and z.
template <class T>
struct Rotation {
  Vec3<T> x, y, z;

  Vec3<T> apply(const Vec3<T>& a) const { return a.x * x + a.y * y + a.z * z; }
  Vec3<T> undo(const Vec3<T>& a) const { return {dot(x, a), dot(y, a), dot(z, a)}; }
};

/// Cosines and sines of roll, pitch and yaw.
template <class T>
struct Attitude {
  T cos_roll, sin_roll, cos_pitch, sin_pitch, cos_yaw, sin_yaw;
};

template <class T>
Attitude<T> attitude(const T& roll, const T& pitch, const T& yaw) {
  const auto [r, p] = maths::waves_of(roll, pitch);
  const auto y = maths::waves(yaw);
  return {r.cosine, r.sine, p.cosine, p.sine, y.cosine, y.sine};
}

/// R_map_body for yaw, then pitch (nose down positive), then roll (left side up positive).
template <class T>
Rotation<T> rotation(const Attitude<T>& a) {
  const T &cr = a.cos_roll, &sr = a.sin_roll, &cp = a.cos_pitch, &sp = a.sin_pitch;
  const T &cy = a.cos_yaw, &sy = a.sin_yaw;
  return {{cy * cp, sy * cp, -sp},
          {cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr},
          {cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr}};
}
template <class T>
Rotation<T> rotation(const T& roll, const T& pitch, const T& yaw) {
  return rotation(attitude(roll, pitch, yaw));
}

/// Values without derivatives.
template <class T>
Vec3<Real<T>> value_of(const Vec3<T>& v) {
  return {value_of(v.x), value_of(v.y), value_of(v.z)};
}
template <class T>
Rotation<Real<T>> value_of(const Rotation<T>& r) {
  return {value_of(r.x), value_of(r.y), value_of(r.z)};
}

}  // namespace vehicle
