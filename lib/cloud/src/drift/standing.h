// Which cells of the road have something that stands there, by all sections that look at them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cloud/road_frame.h"

namespace cloud {

inline constexpr double kSectionCell_m = 0.5;

struct Sections;

struct Standing {
  Standing(const RoadFrame& frame, std::size_t sections);
  /// The road's cell `ahead_m` before a place on the road, in a column of cells across it.
  std::size_t cell_at(double row, double ahead_m, std::size_t column) const;
  /// A section saw something stand in a cell, or within 1 m of it, or did not.
  void saw(std::size_t road_cell, bool standing);
  /// It keeps the cell as the next one of its list.
  void keep(std::size_t section, std::size_t road_cell);
  /// From far away beams meet only the feet of walls and poles: cells in which as many sections
  /// saw something stand as did not, but for those that saw both it and the ground beside it.
  void leave_out_feet(Sections& sections) const;

  struct Seen {
    std::uint32_t standing = 0, clear = 0;
  };
  std::vector<Seen> seen;                        ///< by cell of the road
  std::vector<std::vector<std::uint32_t>> kept;  ///< of each section's cells, that of the road

 private:
  double u_step_m_, length_m_;
  bool closed_;
  std::size_t along_, across_;
};

}  // namespace cloud
