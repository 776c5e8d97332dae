#include "tyre_checks.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>
#include <utility>

#include "vehicle/error.h"
#include "vehicle/magic_formula.h"

namespace vehicle {

void check_tyre(const TyreCoefficients& tyre, const TyrePlaces& places, const std::string& name) {
  const auto where = [&](std::string_view keyword) {
    const auto found = places.find(keyword);
    return found == places.end() ? name : fmt::format("{}:{}", name, found->second);
  };
  const auto between = [&](double value, std::string_view keyword, double least, double most,
                           std::string_view unit) {
    if (!(value >= least && value <= most))
      throw Error(fmt::format("{}: {} is {} {}, wanted {} to {}; do [UNITS] name the file's units?",
                              where(keyword), keyword, value, unit, least, most));
  };
  const auto positive = [&](double value, std::string_view keyword) {
    if (!(value > 0.0))
      throw Error(
          fmt::format("{}: {} = {}, wanted a number above 0", where(keyword), keyword, value));
  };
  between(tyre.unloaded_radius_m, "UNLOADED_RADIUS", 0.01, 5.0, "m");
  between(tyre.nominal_load_n, "FNOMIN", 0.1, 1e6, "N");
  if (!(tyre.vertical_stiffness_npm > 0.0))
    throw Error(
        fmt::format("{}: VERTICAL_STIFFNESS = {}, wanted a number above 0; give it in N/m, "
                    "or Q_FZ1, or the loads in [DEFLECTION_LOAD_CURVE]",
                    where("VERTICAL_STIFFNESS"), tyre.vertical_stiffness_npm));
  between(tyre.nominal_speed_mps, "LONGVL", 0.1, 200.0, "m/s");
  positive(tyre.low_speed_mps, "VXLOW");
  positive(tyre.pcx1, "PCX1");
  positive(tyre.pdx1, "PDX1");
  positive(tyre.pkx1, "PKX1");
  positive(tyre.pcy1, "PCY1");
  positive(std::abs(tyre.pdy1), "PDY1");
  positive(std::abs(tyre.pky1), "PKY1");
  positive(std::abs(tyre.pky2), "PKY2");
  positive(tyre.lfzo, "LFZO");
  positive(tyre.lcz, "LCZ");
  positive(tyre.lip, "LIP");
  positive(tyre.fz_max_n, "FZMAX");
  const auto not_negative = [&](double value, std::string_view keyword) {
    if (!(value >= 0.0))
      throw Error(fmt::format("{}: {} = {}, wanted 0 or more", where(keyword), keyword, value));
  };
  not_negative(tyre.mass_kg, "MASS");
  not_negative(tyre.vertical_damping_nspm, "VERTICAL_DAMPING");
  not_negative(tyre.longitudinal_stiffness_npm, "LONGITUDINAL_STIFFNESS");
  not_negative(tyre.lateral_stiffness_npm, "LATERAL_STIFFNESS");
  not_negative(tyre.lmux, "LMUX");
  not_negative(tyre.lmuy, "LMUY");
  const bool uses_pressure = tyre.ppx1 != 0 || tyre.ppx2 != 0 || tyre.ppx3 != 0 || tyre.ppx4 != 0 ||
                             tyre.ppy1 != 0 || tyre.ppy2 != 0 || tyre.ppy3 != 0 || tyre.ppy4 != 0 ||
                             tyre.ppy5 != 0 || tyre.ppz1 != 0 || tyre.ppz2 != 0 || tyre.pfz1 != 0;
  if (uses_pressure && (tyre.version != 52 || places.contains("NOMPRES")))
    positive(tyre.nominal_pressure_pa, "NOMPRES");
  for (const auto& [value, keyword] :
       {std::pair{tyre.pressure_pa, "INFLPRES"}, std::pair{tyre.nominal_pressure_pa, "NOMPRES"}})
    if (uses_pressure && value != 0.0) between(value, keyword, 5e3, 5e6, "Pa");
  const auto ordered = [&](double low, double high, std::string_view keyword) {
    if (!(low < high))
      throw Error(fmt::format("{}: {} = {} is not above the lower end of its range, {}",
                              where(keyword), keyword, high, low));
  };
  ordered(tyre.fz_min_n, tyre.fz_max_n, "FZMAX");
  ordered(tyre.kappa_min, tyre.kappa_max, "KPUMAX");
  ordered(tyre.alpha_min_rad, tyre.alpha_max_rad, "ALPMAX");
  ordered(tyre.gamma_min_rad, tyre.gamma_max_rad, "CAMMAX");
  ordered(tyre.pressure_min_pa, tyre.pressure_max_pa, "PRESMAX");
  if (tyre_stiffness(tyre, tyre.nominal_load_n, 0.0).cornering_npr > 0.0)
    throw Error(fmt::format(
        "{}: PKY1 = {} gives a positive side force for a positive slip angle, wanted a negative "
        "one "
        "(ISO-W axes: x forward, y left, z up); export the file in ISO-W (TYDEX W) axes, or give "
        "PKY1 the other sign if only that is wrong",
        where("PKY1"), tyre.pky1));
}

}  // namespace vehicle
