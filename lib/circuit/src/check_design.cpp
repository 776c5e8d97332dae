#include "check_design.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <string>

#include "mesh/error.h"

namespace road {
namespace {

// Splines through more take hours; no track has such.
constexpr std::size_t kMostKnots = 1000;

void check_knots(const CircuitDesign& design, const char* what, const Knots& knots, double length_m,
                 double lowest, double highest) {
  if (knots.u_m.empty() || knots.u_m.size() != knots.value.size()) {
    throw Error(fmt::format("{}: {} has {} positions and {} values; give at least one pair",
                            design.name, what, knots.u_m.size(), knots.value.size()));
  }
  if (knots.u_m.size() > kMostKnots) {
    throw Error(fmt::format("{}: {} has {} knots; at most {} wanted", design.name, what,
                            knots.u_m.size(), kMostKnots));
  }
  for (std::size_t i = 0; i < knots.u_m.size(); ++i) {
    const double u = knots.u_m[i];
    if (!(u >= 0.0) || !(u <= length_m) || (design.closed && u >= length_m)) {
      throw Error(fmt::format("{}: {} has a knot at u = {} m; the circuit is {:.3f} m long",
                              design.name, what, u, length_m));
    }
    if (i > 0 && !(u > knots.u_m[i - 1])) {
      throw Error(
          fmt::format("{}: {} has knots at u = {} m and then {} m; give them in ascending order",
                      design.name, what, knots.u_m[i - 1], u));
    }
    if (!(knots.value[i] >= lowest) || !(knots.value[i] <= highest)) {
      throw Error(fmt::format("{}: {} is {} at u = {} m; give {} to {}", design.name, what,
                              knots.value[i], u, lowest, highest));
    }
  }
}

void check_range(const CircuitDesign& design, const char* what, double begin_m, double end_m,
                 double length_m) {
  if (!(begin_m >= 0.0) || !(end_m > begin_m) || !(end_m <= length_m)) {
    throw Error(
        fmt::format("{}: {} from u = {} m to {} m; give 0 <= begin < end <= {:.3f} m (split it "
                    "at the start line)",
                    design.name, what, begin_m, end_m, length_m));
  }
}

void check_kerbs(const CircuitDesign& design, double length_m) {
  for (std::size_t i = 0; i < design.kerbs.size(); ++i) {
    const KerbDesign& kerb = design.kerbs[i];
    const std::string what = fmt::format("kerb {}", i);
    check_range(design, what.c_str(), kerb.u_begin_m, kerb.u_end_m, length_m);
    const KerbProfile& profile = kerb.profile;
    if (profile.t.size() < 2 || profile.t.size() != profile.height.size() ||
        profile.t.front() != 0.0 || profile.t.back() != 1.0 || profile.height.front() != 0.0 ||
        profile.height.back() != 0.0 ||
        std::adjacent_find(profile.t.begin(), profile.t.end(), std::greater_equal<>()) !=
            profile.t.end()) {
      throw Error(
          fmt::format("{}: {} needs a profile with t ascending from 0 to 1 and height 0 at both "
                      "ends",
                      design.name, what));
    }
    if (!(kerb.width_m > 0.0) || !(kerb.taper_m >= 0.0) ||
        2.0 * kerb.taper_m > kerb.u_end_m - kerb.u_begin_m) {
      throw Error(fmt::format(
          "{}: {} has width {} m and tapers of {} m on {} m; give a positive width and "
          "tapers that fit",
          design.name, what, kerb.width_m, kerb.taper_m, kerb.u_end_m - kerb.u_begin_m));
    }
    for (std::size_t j = 0; j < i; ++j) {
      const KerbDesign& other = design.kerbs[j];
      if (other.side == kerb.side && kerb.u_begin_m < other.u_end_m + 0.5 &&
          other.u_begin_m < kerb.u_end_m + 0.5) {
        throw Error(
            fmt::format("{}: kerbs {} and {} on the same side overlap or are closer than 0.5 m",
                        design.name, j, i));
      }
    }
  }
}

void check_bumps(const CircuitDesign& design, double length_m) {
  for (const BumpDesign& bump : design.bumps) {
    if (!(bump.length_m > 0.0) || !(bump.width_m >= 0.0) || !(bump.u_m >= 0.0) ||
        !(bump.u_m <= length_m)) {
      throw Error(
          fmt::format("{}: bump at u = {} m, {} m long and {} m wide; give 0 <= u <= {:.3f} and a "
                      "positive length",
                      design.name, bump.u_m, bump.length_m, bump.width_m, length_m));
    }
  }
}

void check_scenery(const CircuitDesign& design, double length_m) {
  for (const BarrierDesign& item : design.barriers) {
    check_range(design, "barrier", item.u_begin_m, item.u_end_m, length_m);
  }
  for (const TreeRow& item : design.trees) {
    check_range(design, "tree row", item.u_begin_m, item.u_end_m, length_m);
    if (!(item.spacing_m > 0.5)) {
      throw Error(
          fmt::format("{}: trees every {} m; give more than 0.5 m", design.name, item.spacing_m));
    }
  }
  for (const Grandstand& item : design.grandstands) {
    check_range(design, "grandstand", item.u_begin_m, item.u_end_m, length_m);
  }
  for (const BridgeDesign& item : design.bridges) {
    check_range(design, "bridge", item.u_begin_m, item.u_end_m, length_m);
  }
  for (const StartStrip& item : design.start_strips) {
    check_range(design, "start strip", item.u_begin_m, item.u_end_m, length_m);
  }
  for (const Gantry& item : design.gantries) {
    check_range(design, "gantry", item.u_m, item.u_m + item.length_m, length_m);
  }
}

}  // namespace

void check_design(const CircuitDesign& design, double length_m) {
  check_knots(design, "width_left", design.width_left_m, length_m, 1.0, 30.0);
  check_knots(design, "width_right", design.width_right_m, length_m, 1.0, 30.0);
  check_knots(design, "elevation", design.elevation_m, length_m, -9000.0, 9000.0);
  check_knots(design, "banking", design.banking, length_m, -1.0, 1.0);
  check_knots(design, "runoff_left", design.runoff_left_m, length_m, 0.0, 100.0);
  check_knots(design, "runoff_right", design.runoff_right_m, length_m, 0.0, 100.0);
  check_knots(design, "runoff_slope_left", design.runoff_slope_left, length_m, -1.0, 1.0);
  check_knots(design, "runoff_slope_right", design.runoff_slope_right, length_m, -1.0, 1.0);
  check_kerbs(design, length_m);
  check_bumps(design, length_m);
  check_scenery(design, length_m);
}

}  // namespace road
