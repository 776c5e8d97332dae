// The keys of options and modifiers that the standard knows.
#include <algorithm>
#include <array>
#include <string_view>

#include "crg/options.h"

namespace crg {
namespace {

constexpr std::array<std::string_view, 26> kOptionKeys = {"BORDER_MODE_U",
                                                          "BORDER_MODE_V",
                                                          "BORDER_OFFSET_U",
                                                          "BORDER_OFFSET_V",
                                                          "BORDER_SMOOTH_UBEG",
                                                          "BORDER_SMOOTH_UEND",
                                                          "REFLINE_CONTINUATION",
                                                          "REFLINE_SEARCH_FAR",
                                                          "REFLINE_SEARCH_CLOSE",
                                                          "REFLINE_SEARCH_U",
                                                          "REFLINE_SEARCH_UFRAC",
                                                          "WARN_MSGS",
                                                          "WARN_CURV_LOCAL",
                                                          "WARN_CURV_GLOBAL",
                                                          "LOG_MSGS",
                                                          "LOG_EVAL",
                                                          "LOG_EVAL_FREQ",
                                                          "LOG_HIST",
                                                          "LOG_HIST_FREQ",
                                                          "LOG_STAT",
                                                          "LOG_STAT_FREQ",
                                                          "CHECK_EPS",
                                                          "CHECK_INC",
                                                          "CHECK_TOL",
                                                          "CHECK_PRO",
                                                          "CHECK_WGS"};

constexpr std::array<std::string_view, 24> kModifierKeys = {
    "SCALE_Z_GRID",        "SCALE_SLOPE",         "SCALE_BANKING",       "SCALE_LENGTH",
    "SCALE_WIDTH",         "SCALE_CURVATURE",     "GRID_NAN_MODE",       "GRID_NAN_OFFSET",
    "REFPOINT_U",          "REFPOINT_U_FRACTION", "REFPOINT_U_OFFSET",   "REFPOINT_V",
    "REFPOINT_V_FRACTION", "REFPOINT_V_OFFSET",   "REFPOINT_X",          "REFPOINT_Y",
    "REFPOINT_Z",          "REFPOINT_PHI",        "REFLINE_ROTCENTER_X", "REFLINE_ROTCENTER_Y",
    "REFLINE_OFFSET_PHI",  "REFLINE_OFFSET_X",    "REFLINE_OFFSET_Y",    "REFLINE_OFFSET_Z"};

}  // namespace

bool is_option_key(std::string_view key) {
  return std::find(kOptionKeys.begin(), kOptionKeys.end(), key) != kOptionKeys.end();
}

bool is_modifier_key(std::string_view key) {
  return std::find(kModifierKeys.begin(), kModifierKeys.end(), key) != kModifierKeys.end();
}

}  // namespace crg
