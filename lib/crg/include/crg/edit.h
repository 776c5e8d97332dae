// Editing a road as data. Every edit first works the file's modifiers in (apply_modifiers), keeps
// comment, options, projection and unknown sections, and describes the line by headings: x, y and u
// channels, LON/LAT/ALT and double heights end with the edit, unless noted. Throws Error.
#pragma once

#include <optional>

#include "crg/file.h"

namespace crg {

struct CropOptions {
  std::optional<double> u_begin_m = {}, u_end_m = {};   ///< the rows next to them; default: all
  std::optional<double> v_right_m = {}, v_left_m = {};  ///< columns within; default: all
};

/// The rows between those next to the bounds and the columns whose nodes lie within (1e-6 m of
/// tolerance); u and v stay what they were. Two parts cut at one u share a row, as append() wants.
/// A closed track of which rows are cut off becomes an open road.
Crg crop(Crg crg, const CropOptions& options);

struct ResampleOptions {
  std::optional<double> u_step_m =
      {};  ///< wanted; becomes the next that divides the length. Default: as it is
  std::optional<double> v_step_m =
      {};  ///< wanted; the v range stays. Default: the columns as they are
};

/// The same road on another grid: new nodes of the line lie on the old line, one new step apart,
/// from its start to its end; heights are those of the old surface at the new nodes' map positions.
Crg resample(Crg crg, const ResampleOptions& options);

/// The road driven the other way: last row first, left and right exchanged.
Crg reverse(Crg crg);

struct AppendOptions {
  bool move = false;  ///< bring the start of the second road to the end of the first, turned and
                      ///< raised to fit
};

/// Both roads in one: the rows of `second` behind those of `first`, their common row once. Wants
/// the same step and columns, cross sections that meet within 10 mm of height, and unless moved,
/// ends that meet within 2 mm and 1 mrad. A road that is moved is raised by the median of what its
/// columns are off; its slope along u stays. Closed where the end then meets the start alike.
Crg append(Crg first, Crg second, const AppendOptions& options = {});

}  // namespace crg
