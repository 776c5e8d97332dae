// Options and modifiers of a file in typed form.
#pragma once

#include "crg/file.h"

namespace crg {

/// What lies beyond the grid. None: no road; Zero: height 0; Keep: the height of the nearest edge;
/// Repeat, Reflect: the road again, shifted or mirrored.
enum class BorderMode { None = 0, Zero = 1, Keep = 2, Repeat = 3, Reflect = 4 };

/// $ROAD_CRG_OPTS as far as it matters for evaluation and checks, with the standard's defaults.
struct Options {
  BorderMode border_mode_u = BorderMode::Keep;
  BorderMode border_mode_v = BorderMode::Keep;
  double border_offset_u_m = 0.0;  ///< added beyond the begin and the end (Zero, Keep)
  double border_offset_v_m = 0.0;  ///< added beyond the sides
  double smooth_begin_m = 0.0;     ///< length over which heights rise from the line's start height
  double smooth_end_m = 0.0;       ///< length over which they return to its end height
  bool close_track = false;        ///< REFLINE_CONTINUATION 1
  bool check_curvature_local = false;  ///< WARN_CURV_LOCAL
  bool check_curvature_global = true;  ///< WARN_CURV_GLOBAL
  double check_eps = 1e-6;             ///< relative accuracy that checks expect
  double check_increment_m = 1e-3;     ///< smallest increment
  double check_tolerance_m = 1e-4;     ///< absolute tolerance of positions
  double check_projection_m = 5e-3;
  double check_wgs_m = 10.0;
};

/// Reads the options of a file; unknown keys are passed over. Throws Error for values outside the
/// standard's ranges.
Options options_of(const Crg& crg);

/// Whether `key` (upper case) is one of the standard's keys for $ROAD_CRG_OPTS, $ROAD_CRG_MODS.
bool is_option_key(std::string_view key);
bool is_modifier_key(std::string_view key);

/// $ROAD_CRG_MODS as the reference API applies it to a file without that section: NaN at the
/// edges become the nearest height of their row, and the right edge at the start moves to
/// (0, 0, 0) with heading 0.
std::vector<HeaderEntry> reference_default_modifiers(const Crg& crg);

/// The file with its modifiers worked into its data and header, in the standard's order: heights,
/// slope, banking, length, width, curvature, NaN, placement. The result has an empty modifier
/// section. A file without modifiers comes back as it is. Throws Error for values outside the
/// standard's ranges.
Crg apply_modifiers(Crg crg);

}  // namespace crg
