#include "colour_tone.h"

#include <cmath>
#include <map>

namespace road {
namespace {

// Chroma over chroma and lightness together, which does not change with the light: asphalt and
// concrete have 0.05 to 0.2, dry grass, sand and earth 0.3 and more.
constexpr double kGrey = 0.20, kColoured = 0.27;
constexpr double kBlack = 8.0, kWhite = 88.0;  // lightness
constexpr double kAlike = 12.0;                // distance of colours

double to_lab(double x) { return x > 0.008856 ? std::cbrt(x) : 7.787 * x + 16.0 / 116.0; }

}  // namespace

Eigen::Vector3d lab_of(const LinearColour& colour) {
  const double r = static_cast<double>(colour[0]), g = static_cast<double>(colour[1]),
               b = static_cast<double>(colour[2]);
  const double x = to_lab((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505);
  const double y = to_lab(0.2126 * r + 0.7152 * g + 0.0722 * b);
  const double z = to_lab((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089);
  return {116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)};
}

Tone tone_of(const std::optional<LinearColour>& colour) {
  if (!colour) return Tone::unknown;
  const Eigen::Vector3d lab = lab_of(*colour);
  if (lab.x() < kBlack || lab.x() > kWhite) return Tone::unsure;
  const double saturation = lab.tail<2>().norm() / lab.norm();
  return saturation <= kGrey ? Tone::grey : saturation >= kColoured ? Tone::coloured : Tone::unsure;
}

std::vector<std::uint32_t> colour_groups(const std::vector<MeshObject>& objects) {
  std::vector<Eigen::Vector3d> middles;
  std::map<LinearColour, std::uint32_t> known;
  std::vector<std::uint32_t> groups;
  groups.reserve(objects.size());
  for (const MeshObject& object : objects) {
    if (!object.colour) {
      groups.push_back(kNoGroup);
      continue;
    }
    const auto [at, added] = known.try_emplace(*object.colour, 0);
    if (added) {
      const Eigen::Vector3d lab = lab_of(*object.colour);
      std::size_t best = 0;
      while (best < middles.size() && (middles[best] - lab).norm() > kAlike) ++best;
      if (best == middles.size()) middles.push_back(lab);
      at->second = static_cast<std::uint32_t>(best);
    }
    groups.push_back(at->second);
  }
  return groups;
}

}  // namespace road
