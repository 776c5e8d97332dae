#include "settings.h"

#include <cmath>
#include <limits>

namespace opencrg {
namespace {

constexpr Setting kOptions[] = {
    {dCrgCpOptionBorderModeU, "BORDER_MODE_U", "border mode along u", true, false},
    {dCrgCpOptionBorderModeV, "BORDER_MODE_V", "border mode along v", true, false},
    {dCrgCpOptionCurvMode, "", "mode of curvature", true, false},
    {dCrgCpOptionBorderOffsetU, "BORDER_OFFSET_U", "offset beyond the ends [m]", false, true},
    {dCrgCpOptionBorderOffsetV, "BORDER_OFFSET_V", "offset beyond the sides [m]", false, true},
    {dCrgCpOptionSmoothUBegin, "BORDER_SMOOTH_UBEG", "zone at the begin [m]", false, true},
    {dCrgCpOptionSmoothUEnd, "BORDER_SMOOTH_UEND", "zone at the end [m]", false, true},
    {dCrgCpOptionRefLineSearchU, "REFLINE_SEARCH_U", "search from u [m]", false, true},
    {dCrgCpOptionRefLineSearchUFrac, "REFLINE_SEARCH_UFRAC", "search from share of u", false, true},
    {dCrgCpOptionRefLineClose, "REFLINE_SEARCH_CLOSE", "search, close [m]", false, true},
    {dCrgCpOptionRefLineFar, "REFLINE_SEARCH_FAR", "search, far [m]", false, true},
    {dCrgCpOptionRefLineContinue, "REFLINE_CONTINUATION", "continuation of the line", true, false},
    {dCrgCpOptionWarnMsgs, "WARN_MSGS", "number of warnings", true, false},
    {dCrgCpOptionCheckEps, "CHECK_EPS", "expected relative accuracy", false, true},
    {dCrgCpOptionCheckInc, "CHECK_INC", "expected smallest increment [m]", false, true},
    {dCrgCpOptionCheckTol, "CHECK_TOL", "expected tolerance [m]", false, true},
    {dCrgCpOptionWarnCurvLocal, "WARN_CURV_LOCAL", "check of local curvature", true, true},
    {dCrgCpOptionWarnCurvGlobal, "WARN_CURV_GLOBAL", "check of global curvature", true, true}};

constexpr Setting kModifiers[] = {
    {dCrgModScaleZ, "SCALE_Z_GRID", "scale of grid heights", false, true},
    {dCrgModScaleSlope, "SCALE_SLOPE", "scale of slope", false, true},
    {dCrgModScaleBank, "SCALE_BANKING", "scale of banking", false, true},
    {dCrgModScaleLength, "SCALE_LENGTH", "scale of length", false, true},
    {dCrgModScaleWidth, "SCALE_WIDTH", "scale of width", false, true},
    {dCrgModScaleCurvature, "SCALE_CURVATURE", "scale of curvature", false, true},
    {dCrgModGridNaNMode, "GRID_NAN_MODE", "mode of missing heights", true, false},
    {dCrgModGridNaNOffset, "GRID_NAN_OFFSET", "offset of missing heights [m]", false, true},
    {dCrgModRefPointV, "REFPOINT_V", "reference point v [m]", false, true},
    {dCrgModRefPointVFrac, "REFPOINT_V_FRACTION", "reference point, share of v", false, true},
    {dCrgModRefPointVOffset, "REFPOINT_V_OFFSET", "reference point, offset of v [m]", false, true},
    {dCrgModRefPointU, "REFPOINT_U", "reference point u [m]", false, true},
    {dCrgModRefPointUFrac, "REFPOINT_U_FRACTION", "reference point, share of u", false, true},
    {dCrgModRefPointUOffset, "REFPOINT_U_OFFSET", "reference point, offset of u [m]", false, true},
    {dCrgModRefPointX, "REFPOINT_X", "reference point to x [m]", false, true},
    {dCrgModRefPointY, "REFPOINT_Y", "reference point to y [m]", false, true},
    {dCrgModRefPointZ, "REFPOINT_Z", "reference point to z [m]", false, true},
    {dCrgModRefPointPhi, "REFPOINT_PHI", "reference point to heading [rad]", false, true},
    {dCrgModRefLineOffsetX, "REFLINE_OFFSET_X", "offset of x [m]", false, true},
    {dCrgModRefLineOffsetY, "REFLINE_OFFSET_Y", "offset of y [m]", false, true},
    {dCrgModRefLineOffsetZ, "REFLINE_OFFSET_Z", "offset of z [m]", false, true},
    {dCrgModRefLineOffsetPhi, "REFLINE_OFFSET_PHI", "offset of heading [rad]", false, true},
    {dCrgModRefLineRotCenterX, "REFLINE_ROTCENTER_X", "centre of rotation x [m]", false, true},
    {dCrgModRefLineRotCenterY, "REFLINE_ROTCENTER_Y", "centre of rotation y [m]", false, true}};

}  // namespace

std::span<const Setting> options() { return kOptions; }
std::span<const Setting> modifiers() { return kModifiers; }

const Setting* find_setting(unsigned int id) {
  for (const std::span<const Setting> list : {options(), modifiers()}) {
    for (const Setting& setting : list)
      if (setting.id == id) return &setting;
  }
  return nullptr;
}

bool Settings::set_int(unsigned int id, int value) {
  const Setting* setting = find_setting(id);
  if (setting == nullptr || !setting->as_int) return false;
  set_[id] = true;
  values_[id] = value;
  return true;
}

bool Settings::set_double(unsigned int id, double value) {
  const Setting* setting = find_setting(id);
  if (setting == nullptr || !setting->as_double || !std::isfinite(value)) return false;
  const bool zone = id == dCrgCpOptionSmoothUBegin || id == dCrgCpOptionSmoothUEnd;
  if (zone && value <= 0.0) return false;
  set_[id] = true;
  values_[id] = value;
  return true;
}

bool Settings::get_int(unsigned int id, int& value) const {
  const Setting* setting = find_setting(id);
  if (setting == nullptr || !setting->as_int || !has(id)) return false;
  if (!(std::abs(values_[id]) <= std::numeric_limits<int>::max())) return false;
  value = static_cast<int>(values_[id]);
  return true;
}

bool Settings::get_double(unsigned int id, double& value) const {
  const Setting* setting = find_setting(id);
  if (setting == nullptr || !setting->as_double || !has(id)) return false;
  value = values_[id];
  return true;
}

bool Settings::remove(unsigned int id) {
  if (id >= set_.size()) return false;
  set_[id] = false;
  return true;
}

void Settings::take(const std::vector<crg::HeaderEntry>& entries, std::span<const Setting> known) {
  for (const crg::HeaderEntry& entry : entries) {
    for (const Setting& setting : known) {
      if (entry.key != setting.key || entry.key.empty()) continue;
      constexpr double kMost = std::numeric_limits<int>::max();
      if (setting.as_double) {
        set_double(setting.id, entry.value);
      } else if (std::abs(entry.value) <= kMost) {
        set_int(setting.id, static_cast<int>(entry.value));
      }
    }
  }
}

std::vector<crg::HeaderEntry> Settings::entries(std::span<const Setting> known) const {
  std::vector<crg::HeaderEntry> entries;
  for (const Setting& setting : known) {
    if (has(setting.id) && *setting.key != '\0')
      entries.push_back({.key = setting.key, .value = values_[setting.id]});
  }
  return entries;
}

void Settings::print(const char* what) const {
  bool any = false;
  for (const std::span<const Setting> list : {options(), modifiers()}) {
    for (const Setting& setting : list) {
      if (!has(setting.id)) continue;
      any = true;
      crgMsgPrint(dCrgMsgLevelNotice, "%s %u, %s: %.10g\n", what, setting.id, setting.words,
                  values_[setting.id]);
    }
  }
  if (!any) crgMsgPrint(dCrgMsgLevelNotice, "no %s is set\n", what);
}

Settings default_options() {
  Settings settings;
  settings.set_int(dCrgCpOptionBorderModeU, dCrgBorderModeExKeep);
  settings.set_int(dCrgCpOptionBorderModeV, dCrgBorderModeExKeep);
  settings.set_int(dCrgCpOptionCurvMode, dCrgCurvLateral);
  settings.set_double(dCrgCpOptionCheckEps, 1e-6);
  settings.set_double(dCrgCpOptionCheckInc, 1e-3);
  settings.set_double(dCrgCpOptionCheckTol, 1e-4);
  return settings;
}

Settings default_modifiers() {
  Settings settings;
  settings.set_int(dCrgModGridNaNMode, dCrgGridNaNKeepLast);
  for (const unsigned int id :
       {dCrgModRefPointX, dCrgModRefPointY, dCrgModRefPointZ, dCrgModRefPointPhi})
    settings.set_double(id, 0.0);
  return settings;
}

}  // namespace opencrg
