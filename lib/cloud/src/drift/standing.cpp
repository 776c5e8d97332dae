#include "standing.h"

#include <algorithm>
#include <cmath>

#include "sections.h"

namespace cloud {
Standing::Standing(const RoadFrame& frame, std::size_t sections)
    : kept(sections),
      u_step_m_(frame.u_step_m()),
      length_m_(frame.length_m()),
      closed_(frame.closed()),
      along_(static_cast<std::size_t>(frame.length_m() / kSectionCell_m) + 1),
      across_(
          static_cast<std::size_t>((frame.v_m().back() - frame.v_m().front()) / kSectionCell_m) +
          1) {
  seen.resize(along_ * across_);
}

std::size_t Standing::cell_at(double row, double ahead_m, std::size_t column) const {
  double u_m = row * u_step_m_ + ahead_m;
  if (closed_) u_m -= length_m_ * std::floor(u_m / length_m_);
  const auto along = static_cast<std::size_t>(std::max(0.0, u_m / kSectionCell_m));
  return std::min(along, along_ - 1) * across_ + std::min(column, across_ - 1);
}

void Standing::saw(std::size_t road_cell, bool standing) {
  ++(standing ? seen[road_cell].standing : seen[road_cell].clear);
}

void Standing::keep(std::size_t section, std::size_t road_cell) {
  kept[section].push_back(static_cast<std::uint32_t>(road_cell));
}

void Standing::leave_out_feet(Sections& sections) const {
  for (std::size_t s = 0; s < sections.list.size(); ++s) {
    std::vector<SectionCell>& cells = sections.list[s].cells;
    std::size_t left = 0;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const Seen& here = seen[kept[s][k]];
      if (!cells[k].beside && here.standing >= std::max(1u, here.clear))
        sections.on_obstacles += static_cast<std::size_t>(cells[k].points);
      else
        cells[left++] = cells[k];
    }
    cells.resize(left);
  }
}

}  // namespace cloud
