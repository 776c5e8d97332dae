// Heights as game engines and image programs take them: a raster of 16 bits, north up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "crg/surface.h"

namespace road {

/// Row 0 lies in the north; sample (row, column) at (x_m + column cell_m, y_m - row cell_m).
/// Level 0: no road. Every other level is a height of z_m + z_step_m level.
struct HeightRaster {
  std::size_t rows = 0, columns = 0;
  double cell_m = 0.0;
  double x_m = 0.0, y_m = 0.0;  ///< of the first sample
  double z_m = 0.0, z_step_m = 0.0;
  std::vector<std::uint16_t> levels;

  double height(std::size_t row, std::size_t column) const;  ///< NaN: no road
};

/// What a raster loses: heights between its samples, and what is under a bridge.
struct RasterLoss {
  double at_samples_m = 0.0;         ///< at most: half a level
  double between_samples_m = 0.0;    ///< the largest at nodes of the road with road around them
  double rms_m = 0.0;                ///< of the same
  double nodes_without = 0.0;        ///< share of the nodes without four samples of road around
  double nodes_of_other_legs = 0.0;  ///< share where the raster has a leg above or below
};

/// The heights of the road every `cell_m`, on whole multiples of it. A height range of less than
/// 65 m gets levels of 1 mm, larger ones as many as fit. Where legs lie above each other, the
/// height of the one that `uv_of_xy` finds. Throws Error beyond 64 million samples, with the cell
/// that fits.
HeightRaster height_raster(const crg::Surface& road, double cell_m);
RasterLoss raster_loss(const HeightRaster& raster, const crg::Surface& road);

/// Two bytes a sample, the low one first, rows from north to south.
std::string raw_bytes(const HeightRaster& raster);
/// The same as a PNG of 16 bits, shades of grey.
std::string png_bytes(const HeightRaster& raster);

}  // namespace road
