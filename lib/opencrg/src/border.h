// Heights beyond the grid and in smoothing zones by the rules of the reference C API 2.0.1, which
// differ from those of lib/crg where two borders meet (docs/c-api.md).
#pragma once

#include <optional>

#include "crg/surface.h"
#include "settings.h"

namespace opencrg {

/// The options of a contact point that matter to heights, in the form that queries want.
struct Border {
  int mode_u = dCrgBorderModeNone;
  int mode_v = dCrgBorderModeExKeep;
  double offset_u_m = 0.0, offset_v_m = 0.0;
  double smooth_begin_m = 0.0, smooth_end_m = 0.0;  ///< 0: none
  bool smooth() const { return smooth_begin_m > 0.0 || smooth_end_m > 0.0; }
};

Border border_of(const Settings& settings);

/// The u range that a closed line covers; period 0 for lines that are not to be closed.
struct ClosedRange {
  double begin_m = 0.0, period_m = 0.0;
};

/// Height anywhere, NaN on holes, nothing beyond a border of mode none. `banking_folds`: banking
/// follows v into the copies of mode repeat and reflect. The surface's own border modes must be
/// none.
std::optional<double> height(const crg::Surface& surface, const Border& border,
                             const ClosedRange& closed, bool banking_folds, double u_m,
                             double v_m) noexcept;

}  // namespace opencrg
