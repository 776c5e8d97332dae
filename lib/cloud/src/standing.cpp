#include "standing.h"

#include <algorithm>
#include <cmath>

namespace cloud {
namespace {

constexpr double kHigh_m = 0.05;  // no bump, nor a base that is a little off

}  // namespace

Standing::Standing(const RoadFrame& frame, std::size_t sections)
    : frame_(frame),
      along_(static_cast<std::size_t>(frame.length_m() / kSectionCell_m) + 1),
      across_(
          static_cast<std::size_t>((frame.v_m().back() - frame.v_m().front()) / kSectionCell_m) +
          1),
      seen_(along_ * across_),
      kept_(sections) {}

std::size_t Standing::cell_at(double row, double ahead_m, std::size_t column) const {
  double u_m = row * frame_.u_step_m() + ahead_m;
  if (frame_.closed()) u_m -= frame_.length_m() * std::floor(u_m / frame_.length_m());
  const auto along = static_cast<std::size_t>(std::max(0.0, u_m / kSectionCell_m));
  return std::min(along, along_ - 1) * across_ + std::min(column, across_ - 1);
}

void Standing::keep(std::size_t section, std::size_t road_cell, double above_base_m) {
  ++seen_[road_cell].clear;
  kept_[section].push_back({static_cast<std::uint32_t>(road_cell), above_base_m > kHigh_m});
}

void Standing::leave_out_feet(Sections& sections) const {
  for (std::size_t s = 0; s < sections.list.size(); ++s) {
    std::vector<SectionCell>& cells = sections.list[s].cells;
    std::size_t kept = 0;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const Seen& seen = seen_[kept_[s][k].road_cell];
      if (kept_[s][k].high && seen.standing >= seen.clear)
        sections.on_obstacles += static_cast<std::size_t>(cells[k].points);
      else
        cells[kept++] = cells[k];
    }
    cells.resize(kept);
  }
}

}  // namespace cloud
