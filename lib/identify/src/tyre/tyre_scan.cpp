#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/tyre_fit.h"

namespace identify {
namespace {

constexpr int kLoads = 9, kSlips = 240;
constexpr double kLetThrough = 2e-3;

/// Force over slip from 0 to the end; what is wrong with it, or nothing.
std::string fault_of(const std::vector<double>& force, const std::vector<double>& slip) {
  const double sign = force[force.size() / 20] < 0.0 ? -1.0 : 1.0;  // before it can have turned
  std::size_t peak = 0;
  for (std::size_t i = 0; i < force.size(); ++i)
    if (sign * force[i] > sign * force[peak]) peak = i;
  const double most = sign * force[peak];
  if (!(most > 0.0)) return "has no force";
  double best = sign * force[0], least = most;
  for (std::size_t i = 1; i < force.size(); ++i) {
    const double value = sign * force[i];
    if (i <= peak) {
      if (value < best - kLetThrough * most)
        return fmt::format("falls before its peak, at slip {:.3f}", slip[i]);
      best = std::max(best, value);
    } else {
      if (value > least + kLetThrough * most)
        return fmt::format("rises again behind its peak, at slip {:.3f}", slip[i]);
      least = std::min(least, value);
      if (value <= 0.0)
        return fmt::format("turns its sign behind its peak, at slip {:.3f}", slip[i]);
    }
  }
  return "";
}

}  // namespace

std::vector<TyreFault> scan_tyre(const vehicle::TyreCoefficients& tyre, const TyreRange& range,
                                 vehicle::AlphaConvention alpha) {
  const vehicle::TyreOptions law{.alpha = alpha, .moments = false};
  const double low_n = std::max(range.fz_low_n, 0.1 * tyre.nominal_load_n * tyre.lfzo);
  const auto at = [&](double fz_n, double gamma, double kappa, double tan_alpha) {
    vehicle::TyreInput<double> in{fz_n, kappa, tan_alpha, gamma, tyre.nominal_speed_mps, 0.0};
    return vehicle::tyre_forces(tyre, in, {}, law);
  };
  // A file may have Fy above or below zero for positive slip; it must not change.
  const double side =
      at(tyre.nominal_load_n, 0.0, 0.0, 0.0).cornering_stiffness_npr < 0.0 ? -1.0 : 1.0;
  std::vector<TyreFault> out;
  for (int l = 0; l < kLoads; ++l) {
    const double fz_n = low_n + (range.fz_high_n - low_n) * l / (kLoads - 1);
    for (const double gamma :
         {range.gamma_low_rad, 0.5 * (range.gamma_low_rad + range.gamma_high_rad),
          range.gamma_high_rad}) {
      const auto origin = at(fz_n, gamma, 0.0, 0.0);
      std::string what;
      if (!(origin.slip_stiffness_n > 0.0)) what = "slip stiffness is not above zero";
      if (!(side * origin.cornering_stiffness_npr > 0.0))
        what = "cornering stiffness turns its sign";
      if (!(origin.mu_x > 0.0) || !(origin.mu_y > 0.0)) what = "friction is not above zero";
      for (const bool lateral : {false, true})
        for (const double way : {-1.0, 1.0}) {
          if (!what.empty()) break;
          std::vector<double> force, slip;
          for (int i = 0; i <= kSlips; ++i) {
            slip.push_back(way * i / kSlips * (lateral ? range.tan_alpha_most : range.kappa_most));
            const auto f =
                lateral ? at(fz_n, gamma, 0.0, slip.back()) : at(fz_n, gamma, slip.back(), 0.0);
            force.push_back(lateral ? f.fy_n : f.fx_n);
          }
          const std::string fault = fault_of(force, slip);
          if (!fault.empty())
            what = fmt::format("{} force {}", lateral ? "side" : "longitudinal", fault);
        }
      if (!what.empty()) out.push_back({what, fz_n, gamma});
    }
  }
  return out;
}

double peak_slip(const vehicle::TyreCoefficients& tyre, vehicle::AlphaConvention alpha, double fz_n,
                 bool lateral) {
  constexpr int kPoints = 1000;
  vehicle::TyreInput<double> in{.fz_n = fz_n, .vx_mps = tyre.nominal_speed_mps};
  double most = 0.0, at = kMostSlip;
  for (int i = 1; i <= kPoints; ++i) {
    const double slip = kMostSlip * i / kPoints;
    double force = 0.0;
    for (const double way : {-slip, slip}) {
      (lateral ? in.tan_alpha : in.kappa) = way;
      const auto f = vehicle::tyre_forces(tyre, in, {}, {.alpha = alpha, .moments = false});
      force += std::abs(lateral ? f.fy_n : f.fx_n);
    }
    if (force > most) most = force, at = slip;
  }
  return at;
}

}  // namespace identify
