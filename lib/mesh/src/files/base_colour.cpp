// The colour that a material states.
#include <algorithm>
#include <cmath>

#include "raw_mesh.h"
#include "report/mean_colour.h"

namespace road {
namespace {

// White, and what exporters write where nobody chose: 0.588, 0.6, 0.64, 0.8, 1.
constexpr double kNobodysGrey = 0.58, kEqual = 0.005;

}  // namespace

std::optional<LinearColour> base_colour(const std::array<double, 3>& stated, bool is_linear) {
  const auto [least, most] = std::minmax_element(stated.begin(), stated.end());
  const bool is_nobodys = *most - *least < kEqual && *least >= kNobodysGrey;
  LinearColour colour{};
  for (std::size_t k = 0; k < 3; ++k) {
    if (!std::isfinite(stated[k]) || is_nobodys) return std::nullopt;
    const double value = std::clamp(stated[k], 0.0, 1.0);
    colour[k] = static_cast<float>(is_linear ? value : report::linear_light(255.0 * value));
  }
  return colour;
}

}  // namespace road
