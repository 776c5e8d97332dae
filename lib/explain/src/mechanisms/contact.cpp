// What short waves show: a road that has them, or a tyre that rolls over them. Both are found by a
// search of their own, short_waves.cpp.
#include <cmath>

#include "car_changes.h"
#include "listing.h"

namespace explain::contact {
namespace {

/// Between the middles of the bins linearly.
void add_patch(crg::Crg& road, bool, const Finding& f) {
  const HeightPatch& patch = f.patch;
  if (patch.dz_m.empty()) return;
  const auto rows = static_cast<std::ptrdiff_t>(patch.dz_m.size() / patch.columns);
  const auto columns = static_cast<std::ptrdiff_t>(patch.columns);
  const auto value = [&](std::ptrdiff_t i, std::ptrdiff_t j) {
    return i < 0 || j < 0 || i >= rows || j >= columns
               ? 0.0
               : patch.dz_m[static_cast<std::size_t>(i * columns + j)];
  };
  crg::Grid& grid = road.grid;
  for (std::size_t r = 0; r < grid.rows(); ++r)
    for (std::size_t c = 0; c < grid.columns(); ++c) {
      const double u = static_cast<double>(r) * grid.u_step_m / patch.u_step_m - 0.5;
      const double v = (grid.v_m[c] - patch.right_m) / patch.v_step_m - 0.5;
      const auto i = static_cast<std::ptrdiff_t>(std::floor(u));
      const auto j = static_cast<std::ptrdiff_t>(std::floor(v));
      const double fu = u - static_cast<double>(i), fv = v - static_cast<double>(j);
      grid.at(r, c) +=
          static_cast<float>((1 - fu) * ((1 - fv) * value(i, j) + fv * value(i, j + 1)) +
                             fu * ((1 - fv) * value(i + 1, j) + fv * value(i + 1, j + 1)));
    }
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kKerbOrRoughness,
           .list = [](const Listing& l) { untestable(l, kKerbOrRoughness, kTooShort); },
           .physics = "the road has short waves or a kerb that the file does not have (or the "
                      "other way round)",
           .equation = "z = z_file + what even and odd laps agree on",
           .write_heights = add_patch},
          {.id = kMultiPointContact,
           .list = [](const Listing& l) { untestable(l, kMultiPointContact, kTooShort); },
           .physics = "the tyre rolls over short waves and does not follow them with one point",
           .equation = "z = contact of two tandem cams with the strip of road under the tyre",
           .write_car = [](CarChanges& out, const Finding&) { out.strip = true; }}};
}

}  // namespace explain::contact
