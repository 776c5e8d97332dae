// Where a recipe puts the road on the Earth.
#pragma once

#include <optional>
#include <string>

#include "crg/reference_line.h"
#include "road/align.h"
#include "road/guide.h"
#include "road/recipe.h"

namespace road {

struct Placement {
  std::string by;  ///< "control_points", "trajectory" or "values"
  AlignReport align;
  std::vector<std::string>
      point_names;  ///< of align.residual_m; empty for a trajectory, whose rms counts
  Projection projection;
};

/// From the recipe's control points or values, which need no road; empty when it has none. A
/// trajectory is only read, so that a damaged one is refused early. Throws Error as
/// fit_alignment(), naming the file, and for a free rotation or scale without control points.
std::optional<Placement> place_mesh(const Recipe& recipe);

/// The recipe's guide in the frame of the mesh as it is after its tilt and scale; empty when it has
/// none. A geographic one goes back through `placement`. Throws Error as read_guide() and
/// guide_along(), and for a geographic guide without a placement, naming the file.
std::optional<Guide> place_guide(const Recipe& recipe, const std::optional<Placement>& placement);

/// Puts the recipe's guide into the options of cleaning.
void set_guide(Recipe& recipe, const std::optional<Placement>& placement);

/// The same, or from the recipe's trajectory. `line` is the road's
/// in the frame of the mesh, its z_m may be empty (a trajectory then fits in plan, and its mean
/// height is not used). Throws Error as fit_alignment() and fit_to_trajectory(), naming the file.
std::optional<Placement> place_road(const Recipe& recipe, const crg::ReferenceLine& line);

}  // namespace road
