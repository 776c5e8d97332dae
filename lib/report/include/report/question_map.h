// The roads that could be meant, numbered, over a mesh from above.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

namespace report {

struct QuestionLine {
  std::vector<std::array<double, 2>> points_m;  ///< map coordinates
  bool closed = false;
  std::string text;  ///< what stands beside its number
};

/// North is up; a scale bar; each line in a colour of its own with its number at its beginning and
/// an arrow in its direction. The longer side has 1600 pixels. Throws std::invalid_argument where
/// coordinates are not finite or there is nothing to show.
std::string question_map(const std::string& title,
                         std::span<const std::array<std::array<double, 2>, 3>> triangles,
                         std::span<const QuestionLine> lines);

}  // namespace report
