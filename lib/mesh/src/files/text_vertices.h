// Vertices of text formats: their numbers, and whether these lost digits. Private to the mesh
// readers.
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>

#include "base/text_lines.h"
#include "mesh/error.h"

namespace road {

/// Coordinates that lost digits: texts written from float32 numbers, too large for the digits
/// needed.
inline constexpr double kFloat32Suspect = 1e5;

struct TextBounds {
  Eigen::Vector3d lowest = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d highest = -lowest;
  std::array<std::size_t, 3> large{}, float32{}, odd{};  ///< per axis

  void add(const Eigen::Vector3d& vertex) {
    lowest = lowest.cwiseMin(vertex);
    highest = highest.cwiseMax(vertex);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double value = vertex[static_cast<int>(axis)];
      if (std::abs(value) < kFloat32Suspect) continue;
      ++large[axis];
      const auto single = static_cast<float>(value);
      if (static_cast<double>(single) != value) continue;
      ++float32[axis];
      std::uint32_t bits = 0;
      std::memcpy(&bits, &single, sizeof bits);
      odd[axis] += bits & 1u;
    }
  }

  /// All large coordinates are float32 numbers and many need the last bit: two axes at least, since
  /// a road drawn on whole metres is no sign of loss.
  bool float32_quantised() const {
    int axes = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (large[axis] < 100) continue;
      if (float32[axis] != large[axis]) return false;
      axes += 5 * odd[axis] >= large[axis] ? 1 : 0;
    }
    return axes >= 2;
  }
};

/// The three numbers at the beginning of `rest`. Throws Error.
inline Eigen::Vector3d take_vertex(std::string_view& rest, const std::string& path,
                                   std::size_t line_number, std::string_view line) {
  Eigen::Vector3d vertex;
  for (int axis = 0; axis < 3; ++axis) {
    const auto value = base::to_number<double>(base::take_word(rest));
    if (!value) {
      throw Error(
          fmt::format("{}:{}: '{}': wanted three coordinates; copy or export the mesh again", path,
                      line_number, line.substr(0, 60)));
    }
    if (!std::isfinite(*value) || std::abs(*value) > 1e10) {
      throw Error(fmt::format(
          "{}:{}: a coordinate is {}; wanted a finite number of at most 1e7 m; repair the "
          "object in the program that made it, or delete it",
          path, line_number, *value));
    }
    vertex[axis] = *value;
  }
  return vertex;
}

}  // namespace road
