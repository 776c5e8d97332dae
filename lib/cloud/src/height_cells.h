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

  /// Bilinear between the middles of cells; NaN where one of the four is missing.
  double at(const GridPlace& place) const;
  /// Cell of a place; false beside.
  bool cell_of(const GridPlace& place, std::size_t& i, std::size_t& j) const;
};

/// `pass` < 0: all passes.
HeightCells cells_of(const Sections& sections, const std::vector<Correction>& corrections,
                     const RoadFrame& frame, int pass, unsigned threads);

/// Cells where the base has another shape than the points: a kerb or a bump that it lacks.
struct WrongPlaces {
  HeightCells cells;  ///< for its geometry
  std::vector<std::uint8_t> wrong;
  bool contains(const GridPlace& place) const {
    std::size_t i = 0, j = 0;
    return !wrong.empty() && cells.cell_of(place, i, j) && wrong[i * cells.across + j] != 0;
  }
};

/// Heights that differ by more than 5 mm from the median of the 5 m x 2.25 m around, and their
/// neighbours. Drift and bankings are even over such a window.
WrongPlaces wrong_places(HeightCells cells, unsigned threads);

}  // namespace cloud
