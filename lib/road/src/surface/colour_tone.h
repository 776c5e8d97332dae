// What a colour says of a surface. Private to cleaning.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "mesh/mesh.h"

namespace road {

/// CIE L*a*b* (D65): lightness 0 to 100, and what leaves grey towards red and yellow. Distances are
/// about as large as the eye sees them.
Eigen::Vector3d lab_of(const LinearColour& colour);

enum class Tone : std::uint8_t {
  unknown,
  grey,      ///< as asphalt or concrete
  coloured,  ///< as grass, earth, water
  unsure     ///< between them, black or white
};
Tone tone_of(const std::optional<LinearColour>& colour);

/// A number per object: the same where colours are alike; kNoGroup without colour.
inline constexpr std::uint32_t kNoGroup = ~0U;
std::vector<std::uint32_t> colour_groups(const std::vector<MeshObject>& objects);

}  // namespace road
