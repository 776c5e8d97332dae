// Cross-sections of a surface along a guide: where the road lies beside the rough line. Private to
// cleaning and to trace_centreline.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "mesh/ray_surface.h"
#include "road/guide.h"

namespace road {

/// A cross-section; offsets are to the left of the guide.
struct GuideRow {
  Eigen::Vector2d at_m, heading;
  double z_m = 0.0;                    ///< of the layer; between two known ones where none is
  double left_m = 0.0, right_m = 0.0;  ///< where the road ends, right < left
  double middle_m = 0.0, half_width_m = 0.0;  ///< what its neighbours say where it is unlike them
  bool is_usual = false;                      ///< like its neighbours
  bool is_narrowed = false;  ///< more of what looks like road lies beside one of its sides
  bool has_surface = false;
  bool ends_left = false, ends_right = false;  ///< the road ends there; otherwise the row does
};

struct GuideRows {
  std::vector<GuideRow> rows;  ///< evenly spaced
  double step_m = 0.0;
  double reach_m = 0.0;   ///< how far a row looks to both sides
  double across_m = 0.0;  ///< how far its rays lie apart
  double usual_half_m = 0.0;
  bool closed = false;
};

using LooksLikeRoad = std::function<bool(std::uint32_t triangle)>;

/// Rows along a smooth curve through the guide's points. The layer is the one that goes on most
/// smoothly, looks like road, has headroom, and lies as high as the guide says where it says so.
/// From its middle a row reaches out to both sides as far as the surface goes on without a step or
/// a crease, and looks like road. Lengths shrink for guides shorter than 1.2 km, so that models are
/// seen alike.
GuideRows rows_along(const Guide& guide, const RaySurface& surface,
                     const LooksLikeRoad& looks_like_road);

/// Takes the width as given, and the guide as the middle, where the rows do not find this width.
void set_width(GuideRows& all, double width_m);

}  // namespace road
