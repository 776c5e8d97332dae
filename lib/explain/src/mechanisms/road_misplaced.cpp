// A road file that lies shifted along the track.
#include <algorithm>
#include <cmath>

#include "crg/surface.h"
#include "listing.h"

namespace explain::road_misplaced {
namespace {

constexpr const char* kId = "road.misplaced";

void list(const Listing& l) {
  double relief = 0.0;
  for (const Signals& s : l.logs)
    for (std::size_t i = 0; i < s.n; ++i)
      if (std::isfinite(s.grade[i]))
        relief = std::max(relief, std::abs(s.grade[i]) + std::abs(s.bank[i]));
  if (!(relief > 0.01))
    return untestable(l, kId, "the road file has no slopes whose place could be compared");
  // Beside a road that leans: slopes that are there, elsewhere.
  constexpr double kShift_m = 30.0;
  candidate(l, kId, {"shift along u", "m", 2.0, 1.5},
            {"the road file lies shifted along the track", "z(u) -> z(u + shift)",
             "survey two fixed points of the track"},
            [](Setting& s, double v) { s.shift_u += v; })
      .beside_road = {kShift_m, kShift_m};
}

/// Heights from further along by what was found; the reference line stays. Beyond the ends of an
/// open road those of its ends.
void write(crg::Crg& road, bool closed, const Finding& f) {
  if (f.parameters.empty()) return;
  const double shift_m = f.parameters[0].value;
  const crg::Surface old(road);
  crg::Grid& grid = road.grid;
  const double length = static_cast<double>(grid.rows() - 1) * grid.u_step_m;
  for (std::size_t i = 0; i < grid.rows(); ++i) {
    const double u = static_cast<double>(i) * grid.u_step_m;
    double from = u + shift_m;
    from = closed ? from - length * std::floor(from / length) : std::clamp(from, 0.0, length);
    for (std::size_t j = 0; j < grid.columns(); ++j)
      grid.at(i, j) += static_cast<float>(old.z_at_uv(from + grid.u_begin_m, grid.v_m[j]) -
                                          old.z_at_uv(u + grid.u_begin_m, grid.v_m[j]));
  }
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kId, .list = list, .write_heights = write, .turn = Turn::kFirst}};
}

}  // namespace explain::road_misplaced
