#include "vehicle/tyre_points.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "vehicle/error.h"

namespace vehicle {

recording::Table evaluate_tyre(const TyreCoefficients& tyre, const recording::Table& points,
                               const std::string& name, const TyreOptions& options) {
  const auto column = [&](const char* wanted) -> const std::vector<double>& {
    if (const auto* found = points.find(wanted)) return *found;
    throw Error(fmt::format("{}: no column '{}'", name, wanted));
  };
  const auto& fz_n = column("fz_n");
  const auto& kappa = column("kappa");
  const auto& alpha_rad = column("alpha_rad");
  const auto& gamma_rad = column("gamma_rad");
  const auto& vx_mps = column("vx_mps");
  const auto* pressure_pa = points.find("pressure_pa");
  const auto* turn_1pm = points.find("turn_1pm");

  recording::Table out = points;
  std::array<std::vector<double>, 5> results;
  for (auto& result : results) result.reserve(points.rows());
  for (std::size_t i = 0; i < points.rows(); ++i) {
    const double values[] = {fz_n[i],
                             kappa[i],
                             alpha_rad[i],
                             gamma_rad[i],
                             vx_mps[i],
                             pressure_pa ? (*pressure_pa)[i] : 0.0,
                             turn_1pm ? (*turn_1pm)[i] : 0.0};
    constexpr const char* kNames[] = {"fz_n",   "kappa",       "alpha_rad", "gamma_rad",
                                      "vx_mps", "pressure_pa", "turn_1pm"};
    for (std::size_t k = 0; k < std::size(kNames); ++k)
      if (std::isnan(values[k]))
        throw Error(fmt::format("{}: no value of {}; fill it in, or take the row out",
                                points.place(name, i), kNames[k]));
    if (!(std::abs(alpha_rad[i]) < std::numbers::pi / 2))
      throw Error(fmt::format("{}: alpha_rad is {}, wanted less than a right angle",
                              points.place(name, i), alpha_rad[i]));
    if (values[6] != 0.0 && !has_turn_slip(tyre))
      throw Error(
          fmt::format("{}: turn_1pm is {}, but the tyre file has no turn slip (6.x with QCRP1, "
                      "QDRP1, PHYP1, PHYP2 above 0, QDRP1 below 2); wanted 0, or no such column",
                      points.place(name, i), values[6]));
    const TyreInput<double> in{fz_n[i],   kappa[i], std::tan(alpha_rad[i]), gamma_rad[i], vx_mps[i],
                               values[5], values[6]};
    const TyreForces<double> f = tyre_forces(tyre, in, {}, options);
    const double row[] = {f.fx_n, f.fy_n, f.mz_nm, f.mx_nm, f.my_nm};
    for (std::size_t k = 0; k < results.size(); ++k) results[k].push_back(row[k]);
  }
  constexpr const char* kNames[] = {"fx_n", "fy_n", "mz_nm", "mx_nm", "my_nm"};
  for (std::size_t k = 0; k < results.size(); ++k) {
    if (points.find(kNames[k]))
      throw Error(
          fmt::format("{}: column '{}' would be written twice; remove it", name, kNames[k]));
    out.add(kNames[k], std::move(results[k]));
  }
  return out;
}

}  // namespace vehicle
