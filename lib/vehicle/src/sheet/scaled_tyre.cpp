#include "scaled_tyre.h"

#include <fmt/format.h>

#include "vehicle/tyre_file.h"

namespace vehicle {

std::string scaled_tyre(const TyreScale& scale) {
  const std::string reference = reference_tyre_text();
  const TyreCoefficients r = parse_tyre(reference, "reference.tir").coefficients;
  const double load = scale.nominal_n / r.nominal_load_n;
  // The same share of the radius under the nominal load.
  const double spring = load * r.unloaded_radius_m / scale.size.radius_m;
  const double off = scale.static_n / scale.nominal_n - 1.0;
  const double grip = scale.grip / (r.pdy1 + r.pdy2 * off);
  const auto text = with_tyre_values(
      reference, {{"UNLOADED_RADIUS", scale.size.radius_m},
                  {"MASS", scale.mass_kg},
                  {"IYY", 0.52 * scale.mass_kg * scale.size.radius_m * scale.size.radius_m},
                  {"FNOMIN", scale.nominal_n},
                  {"FZMAX", 3.0 * scale.nominal_n},
                  {"VERTICAL_STIFFNESS", spring * r.vertical_stiffness_npm},
                  {"VERTICAL_DAMPING", spring * r.vertical_damping_nspm},
                  {"LONGITUDINAL_STIFFNESS", spring * r.longitudinal_stiffness_npm},
                  {"LATERAL_STIFFNESS", spring * r.lateral_stiffness_npm},
                  {"PDX1", grip * r.pdx1},
                  {"PDX2", grip * r.pdx2},
                  {"PDY1", grip * r.pdy1},
                  {"PDY2", grip * r.pdy2},
                  {"PKX1", scale.stiffness * r.pkx1},
                  {"PKX2", scale.stiffness * r.pkx2},
                  {"PKY1", scale.stiffness * r.pky1},
                  {"PKY6", scale.stiffness * r.pky6}});
  return fmt::format(
             "$ {}, made by crgdrive new: the front tyre of vehicles/open_wheel, scaled. No "
             "measurement.\n"
             "$ Radius {:.4g} m by the size. Nominal load {:.0f} N: a guess.\n"
             "$ Peak side friction {:.3g} at the {:.0f} N of the standing car: {}.\n"
             "$ Cornering and slip stiffness over load: {:.3g} of the reference's: a guess.\n"
             "$ Stiffness of the carcass: as much of the radius under the nominal load.\n",
             scale.name, scale.size.radius_m, scale.nominal_n, scale.grip, scale.static_n,
             scale.grip_source, scale.stiffness) +
         text.substr(text.find("[MDI_HEADER]"));
}

}  // namespace vehicle
