// Heights over the base in cells of the road, from the sections of one pass or of all.
#pragma once

#include "sections.h"

namespace cloud {

/// Median of the sections' heights over the base per cell of kSectionCell_m; NaN without any.
struct HeightCells {
  std::size_t along = 0, across = 0;
  double cell_rows = 1.0, v_begin_m = 0.0, cell_m = kSectionCell_m;
  bool closed = false;
  std::vector<float> height_m;
  /// Grass hangs over this cell or one beside it: points more than this over the ground do not
  /// belong to it; 0: none does.
  std::vector<float> cut_above_m;
  /// Most of the sections see a wall in this cell: points as near to it are of its foot.
  std::vector<Sheet> sheet;
  /// The ground changed: passes before this one do not belong to the cell; empty: nowhere.
  std::vector<std::uint16_t> first_pass;
  bool older = false;  ///< instead, where it changed, only they do
  /// But what they saw within so much of `height_m` does; as long as that.
  std::vector<float> agrees_m;

  /// Bilinear between the middles of cells; NaN where one of the four is missing.
  double at(const GridPlace& place) const;
  /// Beside the middles of cells as well: on along the line of the two before it, across the road.
  double at_edge(std::size_t i, std::size_t j, double v_m) const;
  /// Whether what a pass shows of a cell is its ground: as it is now, or as it was.
  bool holds(std::size_t i, std::size_t j, int pass) const;
  /// The same of a point in it, which lies so high.
  bool holds(std::size_t i, std::size_t j, int pass, const GridPlace& place, double above_m) const;
  /// Cell of a place; false beside.
  bool cell_of(const GridPlace& place, std::size_t& i, std::size_t& j) const;
};

/// `pass` < 0: all passes, but in each cell those before `first_pass`; `older`: as HeightCells.
HeightCells cells_of(const Sections& sections, const std::vector<Correction>& corrections,
                     const RoadFrame& frame, int pass, unsigned threads,
                     std::vector<std::uint16_t> first_pass = {}, bool older = false);

}  // namespace cloud
