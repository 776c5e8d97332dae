#include "crg/options.h"

#include <cmath>

#include "crg/error.h"
#include "text.h"

namespace crg {
namespace {

double bounded(const Crg& crg, const char* key, double otherwise, double low, double high) {
  const double value = find_value(crg.options, key).value_or(otherwise);
  if (!(value >= low && value <= high)) {
    throw Error(std::string("$ROAD_CRG_OPTS ") + key + " = " + shortest(value) + ": want " +
                shortest(low) + " to " + shortest(high));
  }
  return value;
}

int whole(const Crg& crg, const char* key, int otherwise, int low, int high) {
  const double value = bounded(crg, key, otherwise, low, high);
  if (value != std::floor(value)) {
    throw Error(std::string("$ROAD_CRG_OPTS ") + key + " = " + shortest(value) +
                ": want a whole number");
  }
  return static_cast<int>(value);
}

}  // namespace

Options options_of(const Crg& crg) {
  constexpr double kFar = 1e9;
  Options options;
  options.border_mode_u = static_cast<BorderMode>(whole(crg, "BORDER_MODE_U", 2, 0, 4));
  options.border_mode_v = static_cast<BorderMode>(whole(crg, "BORDER_MODE_V", 2, 0, 4));
  options.border_offset_u_m = bounded(crg, "BORDER_OFFSET_U", 0.0, -kFar, kFar);
  options.border_offset_v_m = bounded(crg, "BORDER_OFFSET_V", 0.0, -kFar, kFar);
  options.smooth_begin_m = bounded(crg, "BORDER_SMOOTH_UBEG", 0.0, 0.0, kFar);
  options.smooth_end_m = bounded(crg, "BORDER_SMOOTH_UEND", 0.0, 0.0, kFar);
  options.close_track = whole(crg, "REFLINE_CONTINUATION", 0, 0, 1) == 1;
  options.check_curvature_local = bounded(crg, "WARN_CURV_LOCAL", 0.0, -1.0, kFar) > 0.0;
  options.check_curvature_global = bounded(crg, "WARN_CURV_GLOBAL", 1.0, -1.0, kFar) != 0.0;
  options.check_eps = bounded(crg, "CHECK_EPS", options.check_eps, 1e-6, 1e-2);
  options.check_increment_m = bounded(crg, "CHECK_INC", options.check_increment_m, 1e-6, kFar);
  options.check_tolerance_m = bounded(crg, "CHECK_TOL", 0.1 * options.check_increment_m, 0.0, kFar);
  options.check_projection_m = bounded(crg, "CHECK_PRO", options.check_projection_m, 0.0, kFar);
  options.check_wgs_m = bounded(crg, "CHECK_WGS", options.check_wgs_m, 0.0, kFar);
  return options;
}

}  // namespace crg
