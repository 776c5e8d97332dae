#include "identify/drive_tyres.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "base/statistics.h"
#include "identify/tyre_fit.h"

namespace identify {
namespace {

constexpr double kHeldFrom = 0.75;  ///< share of a drive after which rows judge
constexpr double kMostMore = 20.0;  ///< a row cannot be noisier than that
constexpr double kFirm = 0.1;       ///< share of large forces that are known best
constexpr double kEnds = 0.01;      ///< share of cambers and loads at either end that kerbs make

/// How much larger each number is than the median one, 1 at least.
std::vector<double> more_than_median(const std::vector<double>& sd) {
  std::vector<double> finite;
  for (const double v : sd)
    if (std::isfinite(v) && v > 0.0) finite.push_back(v);
  const double middle = base::median_or(1.0, finite);
  std::vector<double> out;
  for (const double v : sd)
    out.push_back(std::isfinite(v) ? std::clamp(v / middle, 1.0, kMostMore) : kMostMore);
  return out;
}

/// By how much the larger half of an axle's forces is uncertain at least: what rows share, because
/// the car's mass is not known better, and not what comes and goes with their noise.
double shared_by_rows(const std::vector<double>& force, const std::vector<double>& sd) {
  std::vector<double> size, share;
  for (const double f : force)
    if (std::isfinite(f)) size.push_back(std::abs(f));
  if (size.empty()) return 0.0;
  const double large = 0.5 * base::quantile(size, 0.95);
  for (std::size_t k = 0; k < force.size(); ++k)
    if (std::isfinite(sd[k]) && std::abs(force[k]) > large && large > 0.0)
      share.push_back(sd[k] / std::abs(force[k]));
  return share.empty() ? 0.0 : base::quantile(share, kFirm);
}

/// Cambers and loads of nearly all rows of two wheels.
struct Usual {
  double camber_low_rad = 0.0, camber_high_rad = 0.0, load_high_n = 0.0;
};

Usual usual(const std::array<const std::vector<double>*, 2>& camber,
            const std::array<const std::vector<double>*, 2>& load, double left_sign) {
  std::vector<double> cambers, loads;
  for (std::size_t w = 0; w < 2; ++w)
    for (std::size_t k = 0; k < load[w]->size(); ++k) {
      const double c = (*camber[w])[k], f = (*load[w])[k];
      if (!std::isfinite(c + f)) continue;
      cambers.push_back((w == 0 ? left_sign : -left_sign) * c);
      loads.push_back(f);
    }
  if (cambers.empty()) return {};
  return {base::quantile(cambers, kEnds), base::quantile(cambers, 1.0 - kEnds),
          base::quantile(loads, 1.0 - kEnds)};
}

}  // namespace

void add_drive_tyres(DriveTyres& out, const recording::Table& forces, std::size_t axle,
                     bool left_side, const std::string& name, double least_load_n) {
  const auto column = [&](const std::string& wanted) -> const std::vector<double>& {
    if (const auto* found = forces.find(wanted)) return *found;
    throw base::Error(fmt::format(
        "{}: no column '{}'; wanted is a table that crgidentify forces wrote", name, wanted));
  };
  const std::vector<double>& time_s = column("time_s");
  if (time_s.empty()) return;
  const double from_s = time_s.front() + kHeldFrom * (time_s.back() - time_s.front());
  const std::string end = axle == 0 ? "f" : "r", whole = axle == 0 ? "front" : "rear";
  const auto together = [&](const std::string& force, double& share) {
    share = std::max(share,
                     shared_by_rows(column(force + whole + "_n"), column(force + whole + "_sd_n")));
  };
  together("fx_", out.fit.fx_share);
  together("fy_", out.fit.fy_share);
  const Usual rows =
      usual({&column("camber_" + end + "l_rad"), &column("camber_" + end + "r_rad")},
            {&column("fz_" + end + "l_n"), &column("fz_" + end + "r_n")}, left_side ? 1.0 : -1.0);
  for (const bool left : {true, false}) {
    const std::string wheel = end + (left ? "l" : "r");
    const double side = left == left_side ? 1.0 : -1.0;
    const auto &fx = column("fx_" + wheel + "_n"), &fy = column("fy_" + wheel + "_n"),
               &fz = column("fz_" + wheel + "_n"), &kappa = column("kappa_" + wheel),
               &alpha = column("alpha_" + wheel + "_rad"),
               &camber = column("camber_" + wheel + "_rad"),
               &vx = column("wheel_vx_" + wheel + "_mps"), &kelvin = column("tyre_" + wheel + "_k");
    const auto fx_more = more_than_median(column("fx_" + wheel + "_sd_n")),
               fy_more = more_than_median(column("fy_" + wheel + "_sd_n"));
    for (std::size_t k = 0; k < time_s.size(); ++k) {
      TyreSamples& to = time_s[k] < from_s ? out.fit : out.held_out;
      const double all = fx[k] + fy[k] + kappa[k] + alpha[k] + camber[k] + vx[k];
      const double leans = side * camber[k];
      const bool kerb =
          leans < rows.camber_low_rad || leans > rows.camber_high_rad || fz[k] > rows.load_high_n;
      if (kerb || !(fz[k] >= least_load_n) || !std::isfinite(all) || std::abs(alpha[k]) > 1.5) {
        ++to.left_out;
        continue;
      }
      (time_s[k] < from_s ? out.fit_right : out.held_right).push_back(!left);
      to.conditions.push_back({fz[k], kappa[k], side * std::tan(alpha[k]), leans, vx[k], 0.0});
      to.fx_n.push_back(fx[k]);
      to.fy_n.push_back(side * fy[k]);
      to.fx_more.push_back(fx_more[k]);
      to.fy_more.push_back(fy_more[k]);
      if (std::isfinite(kelvin[k])) out.tyre_k.push_back(kelvin[k]);
    }
  }
}

HeldOut held_out(const vehicle::TyreCoefficients& tyre, const TyreSamples& samples,
                 vehicle::AlphaConvention alpha, const vehicle::TyreFactors<double>& factors) {
  HeldOut out;
  out.rows = samples.rows();
  if (out.rows == 0) return out;
  for (std::size_t i = 0; i < samples.rows(); ++i) {
    const auto f = vehicle::tyre_forces(tyre, samples.conditions[i], factors,
                                        {.alpha = alpha, .moments = false});
    out.fx_left_n += std::pow(f.fx_n - samples.fx_n[i], 2.0);
    out.fy_left_n += std::pow(f.fy_n - samples.fy_n[i], 2.0);
    out.fx_n += std::pow(samples.fx_n[i], 2.0);
    out.fy_n += std::pow(samples.fy_n[i], 2.0);
  }
  for (double* v : {&out.fx_left_n, &out.fy_left_n, &out.fx_n, &out.fy_n})
    *v = std::sqrt(*v / static_cast<double>(out.rows));
  return out;
}

namespace {

constexpr double kNearPeak = 0.75;  // of the peak's slip: from there on the curve bends

std::size_t index(SlipKind kind) { return static_cast<std::size_t>(kind); }

const char* word_of(SlipKind kind) {
  return kind == SlipKind::kLateral ? "side slip" : "longitudinal slip";
}

/// Where slips do not come near the reference's peak.
void hold_unseen_peaks(const TyreSamples& rows, const vehicle::TyreCoefficients& reference,
                       TyreFitOptions& options, std::vector<std::string>& kept) {
  for (const SlipKind kind : {SlipKind::kLateral, SlipKind::kLongitudinal}) {
    std::vector<double> slips, loads_n;
    for (const auto& c : rows.conditions) {
      slips.push_back(std::abs(kind == SlipKind::kLateral ? c.tan_alpha : c.kappa));
      loads_n.push_back(c.fz_n);
    }
    if (slips.empty()) continue;
    const double reach = base::quantile(slips, 0.99),
                 peak = peak_slip(reference, options.alpha, base::median(loads_n),
                                  kind == SlipKind::kLateral);
    if (reach >= kNearPeak * peak) continue;
    options.hold[index(kind)] = TyreHold::kPeak;
    options.hold[index(SlipKind::kCombined)] = TyreHold::kAll;
    kept.push_back(
        fmt::format("{}: shape and peak stay the reference's: 99 % of the slips are below {:.3f}, "
                    "its peak lies {} {:.3f}",
                    word_of(kind), reach, peak < kMostSlip ? "at" : "beyond", peak));
  }
}

/// More of one kind stays the reference's; false where all of it did.
bool hold_more(SlipKind kind, TyreHold at_least, const std::string& why, TyreFitOptions& options,
               std::vector<std::string>& kept) {
  TyreHold& hold = options.hold[index(kind)];
  if (hold == TyreHold::kAll) return false;
  hold = at_least == TyreHold::kAll || hold == TyreHold::kPeak ? TyreHold::kAll : TyreHold::kPeak;
  options.hold[index(SlipKind::kCombined)] = TyreHold::kAll;
  kept.push_back(fmt::format("{}: {} the reference's: {}", word_of(kind),
                             hold == TyreHold::kAll ? "all stays" : "shape and peak stay", why));
  return true;
}

}  // namespace

std::optional<DriveTyreFit> fit_drive_tyres(const DriveTyres& drives,
                                            const vehicle::TyreCoefficients& reference,
                                            TyreFitOptions options) {
  constexpr SlipKind kLateral = SlipKind::kLateral, kLongitudinal = SlipKind::kLongitudinal;
  DriveTyreFit out;
  out.reference = held_out(reference, drives.held_out, options.alpha);
  hold_unseen_peaks(drives.fit, reference, options, out.kept);
  while (options.hold[index(kLateral)] != TyreHold::kAll ||
         options.hold[index(kLongitudinal)] != TyreHold::kAll) {
    out.fit = fit_tyre(drives.fit, reference, options);
    out.fitted = held_out(out.fit.tyre, drives.held_out, options.alpha);
    bool more = false;
    for (const SlipKind kind : {kLateral, kLongitudinal}) {
      const auto& all = out.fit.coefficients;
      const auto bound = std::find_if(all.begin(), all.end(), [&](const FittedCoefficient& c) {
        return c.at_bound && c.kind == kind && (c.keyword[1] == 'C' || c.keyword[1] == 'D');
      });
      if (bound != all.end() &&
          hold_more(kind, TyreHold::kPeak, bound->keyword + " ran into its bound", options,
                    out.kept))
        more = true;
    }
    const auto worse = [&](SlipKind kind, double fitted_n, double reference_n) {
      if (more || !(fitted_n > reference_n)) return;
      more = hold_more(kind, TyreHold::kAll,
                       fmt::format("on what was kept back the fit misses {:.1f} N, the reference "
                                   "{:.1f} N",
                                   fitted_n, reference_n),
                       options, out.kept);
    };
    worse(kLongitudinal, out.fitted.fx_left_n, out.reference.fx_left_n);
    worse(kLateral, out.fitted.fy_left_n, out.reference.fy_left_n);
    if (!more) return out;
  }
  return std::nullopt;
}

}  // namespace identify
