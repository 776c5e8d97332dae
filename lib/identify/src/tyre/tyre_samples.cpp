#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "identify/tyre_fit.h"

namespace identify {

void add_tyre_samples(TyreSamples& samples, const recording::Table& table,
                      const std::string& name) {
  const auto column = [&](const char* wanted) -> const std::vector<double>& {
    if (const auto* found = table.find(wanted)) return *found;
    throw base::Error(fmt::format(
        "{}: no column '{}'; wanted are fz_n, kappa, alpha_rad, gamma_rad, vx_mps, and fx_n or "
        "fy_n or both",
        name, wanted));
  };
  const auto &fz_n = column("fz_n"), &kappa = column("kappa"), &alpha_rad = column("alpha_rad"),
             &gamma_rad = column("gamma_rad"), &vx_mps = column("vx_mps");
  const auto *pressure_pa = table.find("pressure_pa"), *fx_n = table.find("fx_n"),
             *fy_n = table.find("fy_n"), *mz_nm = table.find("mz_nm");
  if (fx_n == nullptr && fy_n == nullptr) column("fx_n' or 'fy_n");
  const auto check = [&](std::size_t row, const char* what, double value, double most) {
    if (std::abs(value) > most)
      throw base::Error(fmt::format("{}: row {} has {} = {:.4g}, wanted {:g} at most; other units?",
                                    name, row + 1, what, value, most));
  };
  if (mz_nm != nullptr) samples.mz_nm.resize(samples.rows(), NAN);
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double fx = fx_n ? (*fx_n)[i] : NAN, fy = fy_n ? (*fy_n)[i] : NAN;
    const double pressure = pressure_pa ? (*pressure_pa)[i] : 0.0;
    const double sum = kappa[i] + alpha_rad[i] + gamma_rad[i] + vx_mps[i] + pressure;
    if (!(fz_n[i] > 0.0) || std::isnan(sum) || (std::isnan(fx) && std::isnan(fy))) {
      ++samples.left_out;
      continue;
    }
    if (!(std::abs(alpha_rad[i]) < std::numbers::pi / 2))
      throw base::Error(
          fmt::format("{}: row {} has alpha_rad = {}, wanted radians, less than a "
                      "right angle",
                      name, i + 1, alpha_rad[i]));
    check(i, "fz_n", fz_n[i], 1e6);
    check(i, "kappa", kappa[i], 100.0);
    check(i, "gamma_rad", gamma_rad[i], 1.6);
    check(i, "vx_mps", vx_mps[i], 1e3);
    check(i, "pressure_pa", pressure, 1e8);
    check(i, "fx_n", fx, 1e6);
    check(i, "fy_n", fy, 1e6);
    samples.conditions.push_back(
        {fz_n[i], kappa[i], std::tan(alpha_rad[i]), gamma_rad[i], vx_mps[i], pressure});
    samples.fx_n.push_back(fx);
    samples.fy_n.push_back(fy);
    if (samples.mz_nm.empty() && mz_nm == nullptr) continue;
    const double mz = mz_nm ? (*mz_nm)[i] : NAN;
    check(i, "mz_nm", mz, 1e5);
    samples.mz_nm.push_back(mz);
  }
}

TyreSamples thinned(const TyreSamples& samples, std::size_t most) {
  TyreSamples out;
  out.left_out = samples.left_out;
  out.fx_share = samples.fx_share;
  out.fy_share = samples.fy_share;
  const std::size_t every = (samples.rows() + most - 1) / most;
  for (std::size_t i = 0; i < samples.rows(); i += every) out.add_row(samples, i);
  return out;
}

void TyreSamples::add_row(const TyreSamples& from, std::size_t row) {
  conditions.push_back(from.conditions[row]);
  for (const auto column : {&TyreSamples::fx_n, &TyreSamples::fy_n, &TyreSamples::mz_nm,
                            &TyreSamples::fx_more, &TyreSamples::fy_more})
    if (!(from.*column).empty()) (this->*column).push_back((from.*column)[row]);
}

}  // namespace identify
