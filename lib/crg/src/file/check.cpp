#include "crg/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "checker.h"
#include "crg/error.h"
#include "header.h"
#include "text.h"

namespace crg {
namespace {

constexpr double kPi = std::numbers::pi;

}  // namespace

void Checker::compare(const char* key, double actual, double tolerance, const char* what) {
  const auto given = find_value(crg_.road, key);
  if (given && !(std::abs(*given - actual) <= tolerance)) {
    add(Severity::Warning, "header",
        std::string(key) + " = " + shortest(*given) + ", but " + what + " is " + shortest(actual) +
            " (tolerance " + shortest(tolerance) + ")");
  }
}

void Checker::check_options() {
  try {
    options_ = options_of(crg_);
  } catch (const Error& error) {
    add(Severity::Error, "options", error.what());
    options_ = {};
  }
  for (const HeaderEntry& entry : crg_.options) {
    if (entry.key != "*" && !is_option_key(entry.key)) {
      add(Severity::Note, "options.unknown",
          entry.key + " is not an option of the standard and has no effect");
    }
  }
}

void Checker::check_modifiers() {
  if (!crg_.has_modifier_section) {
    add(Severity::Warning, "modifiers.missing",
        "no $ROAD_CRG_MODS: the reference API, asked to apply modifiers, fills NaN and moves the "
        "road to the origin; "
        "an empty section prevents that");
  }
  const auto given = [&](const char* key) { return find_value(crg_.modifiers, key).has_value(); };
  bool reference_point = false, offsets = false;
  for (const HeaderEntry& entry : crg_.modifiers) {
    if (entry.key == "*") continue;
    if (!is_modifier_key(entry.key)) {
      add(Severity::Note, "modifiers.unknown",
          entry.key + " is not a modifier of the standard and has no effect");
    }
    reference_point |= entry.key.starts_with("REFPOINT_");
    offsets |= entry.key.starts_with("REFLINE_");
  }
  if (reference_point && offsets) {
    add(Severity::Warning, "modifiers.placement",
        "both REFPOINT_* and REFLINE_* place the road; REFPOINT_* wins");
  }
  for (const char* axis : {"U", "V"}) {
    const std::string absolute = std::string("REFPOINT_") + axis;
    if (given(absolute.c_str()) && given((absolute + "_FRACTION").c_str())) {
      std::string message = "both " + absolute;
      message += " and " + absolute;
      message += "_FRACTION are given; " + absolute;
      message += " wins";
      add(Severity::Warning, "modifiers.placement", message);
    }
  }
  try {
    // Placement and ranges are checked where they are applied, on a road of two rows.
    Crg probe;
    probe.road = crg_.road;
    probe.options = crg_.options;
    probe.modifiers = crg_.modifiers;
    probe.grid.u_begin_m = crg_.grid.u_begin_m;
    probe.grid.u_step_m = crg_.grid.u_step_m;
    probe.grid.v_m = {crg_.grid.v_m.front(), crg_.grid.v_m.back()};
    probe.grid.z_m.assign(4, 0.0F);
    apply_modifiers(std::move(probe));
  } catch (const Error& error) {
    add(Severity::Error, "modifiers", error.what());
  }
}

void Checker::check_increments() {
  const Grid& grid = crg_.grid;
  const double least = options_.check_increment_m * (1.0 - options_.check_eps);
  if (grid.u_step_m < least) {
    add(Severity::Error, "increment.u",
        "rows every " + shortest(grid.u_step_m) +
            " m: want at least CHECK_INC = " + shortest(options_.check_increment_m) + " m");
  }
  std::size_t narrow = 0, first = 0;
  for (std::size_t j = 1; j < grid.v_m.size(); ++j) {
    if (grid.v_m[j] - grid.v_m[j - 1] < least && narrow++ == 0) first = j;
  }
  if (narrow > 0) {
    add(Severity::Error, "increment.v",
        "long sections " + std::to_string(first) + " and " + std::to_string(first + 1) + " are " +
            shortest(grid.v_m[first] - grid.v_m[first - 1]) +
            " m apart: want at least CHECK_INC = " + shortest(options_.check_increment_m) + " m",
        {}, narrow);
  }
  const double length = grid.u_step_m * static_cast<double>(grid.rows() - 1);
  compare("REFERENCE_LINE_END_U", grid.u_begin_m + length,
          std::max(options_.check_tolerance_m, options_.check_eps * length), "u of the last row");
  compare("LONG_SECTION_V_RIGHT", grid.v_m.front(), options_.check_tolerance_m,
          "v of the rightmost section");
  compare("LONG_SECTION_V_LEFT", grid.v_m.back(), options_.check_tolerance_m,
          "v of the leftmost section");
  for (const double v : {grid.v_m.front(), grid.v_m.back()}) {
    if (std::abs(v) > 1000.0)
      add(Severity::Warning, "range.v", "v reaches " + shortest(v) + " m; is it in metres?");
  }
}

void Checker::check_header_against_channels() {
  const auto turn = [](double a, double b) { return std::abs(std::remainder(a - b, 2.0 * kPi)); };
  const auto compare_heading = [&](const char* key, double actual) {
    const auto given = find_value(crg_.road, key);
    if (given && turn(*given, actual) > options_.check_tolerance_m) {
      add(Severity::Warning, "header",
          std::string(key) + " = " + shortest(*given) + " rad, but the channel says " +
              shortest(actual));
    }
  };
  if (!crg_.heading_rad.empty()) {
    compare_heading("REFERENCE_LINE_END_PHI", crg_.heading_rad.back());
    const double first_turn = turn(line_.heading_rad[0], crg_.heading_rad[1]);
    if (first_turn > kPi / 2.0) {
      add(Severity::Warning, "header",
          "REFERENCE_LINE_START_PHI = " + shortest(line_.heading_rad[0]) + " rad is " +
              shortest(first_turn) + " rad off the first segment");
    }
  }
  if (!crg_.slope.empty())
    compare("REFERENCE_LINE_END_S", crg_.slope.back(), options_.check_tolerance_m,
            "the slope channel's last value");
  if (!crg_.banking.empty()) {
    compare("REFERENCE_LINE_START_B", crg_.banking.front(), options_.check_tolerance_m,
            "the banking channel's first value");
    compare("REFERENCE_LINE_END_B", crg_.banking.back(), options_.check_tolerance_m,
            "the banking channel's last value");
  }
  const std::array<std::pair<const char*, const char*>, 2> pairs = {
      {{"REFERENCE_LINE_START_X", "REFERENCE_LINE_START_Y"},
       {"REFERENCE_LINE_END_X", "REFERENCE_LINE_END_Y"}}};
  for (const auto& [x_key, y_key] : pairs) {
    if (find_value(crg_.road, x_key).has_value() != find_value(crg_.road, y_key).has_value()) {
      add(Severity::Warning, "header",
          std::string("only one of ") + x_key + " and " + y_key + " is given");
    }
  }
}

void Checker::check_projection() {
  if (crg_.projection.empty()) return;
  const auto text = [&](const char* key) {
    for (const HeaderEntry& entry : crg_.projection) {
      if (entry.key == key) return upper(entry.text.substr(0, entry.text.find_first_of(" \t")));
    }
    return std::string();
  };
  const std::string projection = text("PROJ_NM");
  const auto known = [&](const std::string& name) {
    return name == "TM" || name.starts_with("TM_") || name.starts_with("UTM_") ||
           name.starts_with("GK3_") || name.starts_with("GK6_");
  };
  if (!projection.empty() && !known(projection)) {
    add(Severity::Warning, "projection",
        "PROJ_NM = " + projection.substr(0, 40) + ": want GK3_n, GK6_n, UTM_nnX, TM_n or TM");
  }
  const std::string transformation = text("TRAN_NM");
  if (!transformation.empty() && transformation != "NOP" && transformation != "HL7" &&
      transformation != "HN7" && transformation != "HS7") {
    add(Severity::Warning, "projection",
        "TRAN_NM = " + transformation.substr(0, 40) + ": want NOP, HL7, HN7 or HS7");
  }
  for (const char* ellipsoid : {"GELL", "LELL"}) {
    const auto a = find_value(crg_.projection, std::string(ellipsoid) + "_A"),
               b = find_value(crg_.projection, std::string(ellipsoid) + "_B");
    if ((a && !(*a > 6.3e6 && *a < 6.4e6)) || (b && !(*b > 6.3e6 && *b < 6.4e6))) {
      add(Severity::Warning, "projection",
          std::string(ellipsoid) + "_A, _B: want the half axes of the Earth in metres");
    }
  }
}

void Checker::check_wgs() {
  std::array<std::optional<Point2>, 2> ends;  // (lon, lat) in degrees
  const std::array<std::string, 2> names = {"START", "END"};
  for (std::size_t k = 0; k < 2; ++k) {
    const std::string prefix = "REFERENCE_LINE_" + names[k] + "_";
    const auto lon = find_value(crg_.road, prefix + "LON"),
               lat = find_value(crg_.road, prefix + "LAT");
    if (lon.has_value() != lat.has_value())
      add(Severity::Warning, "wgs", "only one of " + prefix + "LON and _LAT is given");
    if ((lon && std::abs(*lon) > 180.0) || (lat && std::abs(*lat) > 90.0)) {
      add(Severity::Error, "wgs", prefix + "LON, _LAT: want degrees within 180 and 90");
    } else if (lon && lat) {
      ends[k] = Point2{*lon, *lat};
    }
  }
  if (!ends[0] || !ends[1]) return;
  // Local metres on WGS84 around the middle latitude; ends of one road are near enough.
  const double rad = kPi / 180.0, a = 6378137.0, e2 = 6.69437999014e-3;
  const double lat = 0.5 * (ends[0]->y_m + ends[1]->y_m) * rad;
  const double w = std::sqrt(1.0 - e2 * std::sin(lat) * std::sin(lat));
  const double north = (ends[1]->y_m - ends[0]->y_m) * rad * a * (1.0 - e2) / (w * w * w);
  const double east =
      std::remainder(ends[1]->x_m - ends[0]->x_m, 360.0) * rad * a / w * std::cos(lat);
  const double by_wgs = std::hypot(north, east);
  const double by_line =
      std::hypot(line_.x_m.back() - line_.x_m.front(), line_.y_m.back() - line_.y_m.front());
  if (by_wgs < 100e3 && std::abs(by_wgs - by_line) > options_.check_wgs_m) {
    add(Severity::Warning, "wgs",
        "start and end are " + shortest(by_wgs) + " m apart by LON/LAT and " + shortest(by_line) +
            " m by X/Y (tolerance CHECK_WGS = " + shortest(options_.check_wgs_m) + " m)");
  }
}

void Checker::run() {
  for (const std::string& note : crg_.notes) add(Severity::Note, "read", note);
  const Grid& grid = crg_.grid;
  if (grid.columns() < 2 || grid.rows() < 2 || grid.z_m.size() != grid.rows() * grid.columns()) {
    add(Severity::Error, "shape",
        "a grid of " + std::to_string(grid.rows()) + " x " + std::to_string(grid.columns()) +
            ": want at least 2 x 2, all filled");
    return;
  }
  check_options();
  try {
    line_ = integrate_reference_line(crg_);
  } catch (const Error& error) {
    add(Severity::Error, "line", error.what());
    return;
  }
  check_modifiers();
  check_increments();
  check_header_against_channels();
  check_line();
  check_curvature();
  check_closure();
  check_heights();
  check_projection();
  check_wgs();
}

std::size_t CheckReport::count(Severity severity) const {
  return static_cast<std::size_t>(
      std::count_if(findings.begin(), findings.end(),
                    [&](const Finding& finding) { return finding.severity == severity; }));
}

CheckReport check(const Crg& crg) {
  CheckReport report;
  Checker(crg, report).run();
  return report;
}

const char* name_of(Severity severity) {
  return severity == Severity::Error ? "error" : severity == Severity::Warning ? "warning" : "note";
}

}  // namespace crg
