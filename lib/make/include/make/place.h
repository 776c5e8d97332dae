// Where a recipe puts the road on the Earth.
#pragma once

#include <optional>
#include <string>

#include "base/answer.h"
#include "crg/reference_line.h"
#include "make/recipe.h"
#include "road/align.h"
#include "road/guide.h"

namespace road {

struct Placement {
  std::string by;  ///< "control_points", "trajectory", "guide" or "values"
  AlignReport align;
  std::vector<std::string>
      point_names;  ///< of align.residual_m; empty for a trajectory or guide, whose rms counts
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

/// Whether the recipe's guide is geographic and nothing in the recipe tells where the mesh lies.
bool guide_lays_mesh(const Recipe& recipe, const std::optional<Placement>& placement);

/// Where the mesh lies by a geographic guide alone: the guide is laid along the roads that the mesh
/// is found to have without it (the one that a build would take, else candidates()). By the shape
/// in plan, within what a car is beside the middle. Throws Error naming the file when the guide
/// has the shape of none of them, of several, or of one that lies on itself when it is turned.
Placement place_by_guide(Recipe recipe, const Mesh& mesh);

/// The recipe's geographic guide in metres, and the projection it is in.
Guide guide_on_the_earth(const Recipe& recipe, Projection& projection);

/// fit_to_trajectory() with a guide as the trajectory. Heights count where the guide has all of
/// them; otherwise the road keeps its own.
base::Answer<AlignReport> fit_guide(const std::vector<Eigen::Vector3d>& middle_m, bool closed,
                                    const Guide& guide);

/// Puts the recipe's guide into the options of cleaning.
void set_guide(Recipe& recipe, const std::optional<Placement>& placement);

/// What cleaning the mesh tells, for those who look at it. A refusal of cleaning, and of a file
/// that the recipe names beside the mesh.
base::Answer<CleanReport> report_of_cleaning(Recipe recipe, const Mesh& mesh);

/// As place_mesh(), or from the recipe's trajectory. `line` is the road's
/// in the frame of the mesh, its z_m may be empty (a trajectory then fits in plan, and its mean
/// height is not used). Throws Error as fit_alignment() and fit_to_trajectory(), naming the file.
std::optional<Placement> place_road(const Recipe& recipe, const crg::ReferenceLine& line);

}  // namespace road
