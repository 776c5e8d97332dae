// The axis of a mesh file that points up, and the proper rotation that brings it to +z.
#pragma once

#include <Eigen/Core>
#include <string_view>

namespace road {

enum class UpAxis { automatic, x, y, z, minus_x, minus_y, minus_z };

struct NamedUp {
  UpAxis up;
  const char* name;
};
/// Every axis but `automatic`.
inline constexpr NamedUp kUps[] = {{UpAxis::x, "x"},        {UpAxis::y, "y"},
                                   {UpAxis::z, "z"},        {UpAxis::minus_x, "-x"},
                                   {UpAxis::minus_y, "-y"}, {UpAxis::minus_z, "-z"}};

/// automatic for any other word.
constexpr UpAxis up_called(std::string_view name) {
  for (const NamedUp& known : kUps)
    if (name == known.name) return known.up;
  return UpAxis::automatic;
}

/// "x" to "-z", or "automatic".
constexpr const char* name_of(UpAxis up) {
  for (const NamedUp& known : kUps)
    if (up == known.up) return known.name;
  return "automatic";
}

/// 0, 1, 2 for x, y, z of either sign; -1 for automatic.
constexpr int line_of(UpAxis up) {
  return up == UpAxis::automatic ? -1 : (static_cast<int>(up) - 1) % 3;
}

constexpr bool is_minus(UpAxis up) {
  return static_cast<int>(up) >= static_cast<int>(UpAxis::minus_x);
}

/// The axis along `line` (0, 1, 2), or against it.
constexpr UpAxis up_along(int line, bool minus) {
  return static_cast<UpAxis>(1 + line + (minus ? 3 : 0));
}

/// From the axes of a file to z up; automatic counts as z. Left stays left: y becomes (x, -z, y),
/// -z becomes (x, -y, -z).
inline Eigen::Vector3d turned_up(const Eigen::Vector3d& v, UpAxis up) {
  switch (up) {
    case UpAxis::x:
      return {v.y(), v.z(), v.x()};
    case UpAxis::y:
      return {v.x(), -v.z(), v.y()};
    case UpAxis::minus_x:
      return {v.z(), v.y(), -v.x()};
    case UpAxis::minus_y:
      return {v.x(), v.z(), -v.y()};
    case UpAxis::minus_z:
      return {v.x(), -v.y(), -v.z()};
    default:
      return v;
  }
}

/// Back again.
inline Eigen::Vector3d turned_from_z(const Eigen::Vector3d& v, UpAxis up) {
  switch (up) {
    case UpAxis::x:
      return {v.z(), v.x(), v.y()};
    case UpAxis::y:
      return {v.x(), v.z(), -v.y()};
    case UpAxis::minus_x:
      return {-v.z(), v.y(), v.x()};
    case UpAxis::minus_y:
      return {v.x(), -v.z(), v.y()};
    case UpAxis::minus_z:
      return {v.x(), -v.y(), -v.z()};
    default:
      return v;
  }
}

}  // namespace road
