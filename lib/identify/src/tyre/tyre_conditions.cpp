#include <algorithm>
#include <cmath>

#include "base/statistics.h"
#include "identify/tyre_fit.h"
#include "tyre_varied.h"

namespace identify {
namespace {

constexpr double kPurity = 0.1;
constexpr std::size_t kFewestOfCell = 10;

template <std::size_t n>
std::size_t cell_of(const std::array<double, n>& edges, double value) {
  std::size_t out = 0;
  while (out + 1 < n && value >= edges[out + 1]) ++out;
  return out;
}

vehicle::TyreInput<double> upright(const TyreFit& fit, double fz_n, bool lateral, double slip) {
  vehicle::TyreInput<double> in{.fz_n = fz_n, .vx_mps = fit.tyre.nominal_speed_mps};
  (lateral ? in.tan_alpha : in.kappa) = slip;
  return in;
}

/// Root mean square of what was measured; NaN where nothing was.
struct MeanSquare {
  double sum = 0.0, rows = 0.0;

  void add(double value) {
    if (std::isnan(value)) return;
    sum += value * value;
    rows += 1.0;
  }
  double rms() const { return std::sqrt(sum / rows); }
};
struct Left {
  MeanSquare fx, fy;
};

double nominal_n(const TyreFit& fit) { return fit.tyre.nominal_load_n * fit.tyre.lfzo; }

bool fitted(const TyreFit& fit, SlipKind kind) {
  return std::any_of(fit.stages.begin(), fit.stages.end(), [&](const TyreStage& stage) {
    return stage.kind == kind && stage.why_not.empty();
  });
}

TyreRange range_of(const TyreSamples& samples) {
  TyreRange out{INFINITY, 0.0, INFINITY, -INFINITY};
  for (const auto& c : samples.conditions) {
    out.fz_low_n = std::min(out.fz_low_n, c.fz_n);
    out.fz_high_n = std::max(out.fz_high_n, c.fz_n);
    out.gamma_low_rad = std::min(out.gamma_low_rad, c.gamma_rad);
    out.gamma_high_rad = std::max(out.gamma_high_rad, c.gamma_rad);
  }
  return out;
}

/// The load that stands for a cell: the median of its rows.
using LoadCells = std::array<std::vector<double>, kLoadEdges.size()>;

NextMeasurement next_measurement(const TyreFit& fit, const TyreRange& range, double peak_tan,
                                 double peak_kappa) {
  NextMeasurement out;
  for (int l = 0; l < 4; ++l)
    for (int c = 0; c < 3; ++c)
      for (const double a : {0.0, -0.5, 0.5, -1.0, 1.0, -1.5, 1.5})
        for (const double k : {0.0, -0.5, 0.5, -1.0, 1.0, -1.5, 1.5}) {
          if (a == 0.0 && k == 0.0) continue;
          const vehicle::TyreInput<double> in{
              range.fz_low_n + (range.fz_high_n - range.fz_low_n) * l / 3.0,
              k * peak_kappa,
              a * peak_tan,
              range.gamma_low_rad + (range.gamma_high_rad - range.gamma_low_rad) * c / 2.0,
              fit.tyre.nominal_speed_mps,
              0.0};
          const SlipKind kind = k == 0.0   ? SlipKind::kLateral
                                : a == 0.0 ? SlipKind::kLongitudinal
                                           : SlipKind::kCombined;
          if (!fitted(fit, kind)) continue;
          const ForceBand band = force_band(fit, in);
          if (std::max(band.fx_sd_n, band.fy_sd_n) <= out.sd_n) continue;
          const bool is_fx = band.fx_sd_n > band.fy_sd_n;
          out = {kind, in, is_fx ? band.fx_n : band.fy_n, is_fx ? band.fx_sd_n : band.fy_sd_n};
        }
  return out;
}

}  // namespace

TyreConditions tyre_conditions(const TyreFit& fit, const TyreSamples& samples) {
  TyreConditions out;
  out.measured = range_of(samples);
  LoadCells loads;
  for (const auto& c : samples.conditions)
    loads[cell_of(kLoadEdges, c.fz_n / nominal_n(fit))].push_back(c.fz_n);
  std::array<std::array<double, kLoadEdges.size()>, 2> peak{};  // lateral, longitudinal
  for (std::size_t l = 0; l < loads.size(); ++l)
    for (std::size_t k = 0; k < 2; ++k)
      if (!loads[l].empty())
        peak[k][l] = peak_slip(fit.tyre, fit.alpha, base::median(loads[l]), k == 0);

  constexpr SlipKind kKinds[] = {SlipKind::kLateral, SlipKind::kLongitudinal, SlipKind::kCombined};
  for (const SlipKind kind : kKinds)
    for (std::size_t l = 0; l < kLoadEdges.size(); ++l)
      for (std::size_t c = 0; c < kCamberEdges_deg.size(); ++c)
        for (std::size_t s = 0; s < kSlipEdges.size(); ++s) out.cells.push_back({kind, l, c, s});
  std::array<LoadCells, 2> pure;  // slips of rows of pure slip
  std::vector<Left> left(out.cells.size());
  for (std::size_t i = 0; i < samples.rows(); ++i) {
    const auto& in = samples.conditions[i];
    const std::size_t load = cell_of(kLoadEdges, in.fz_n / nominal_n(fit));
    const double a = std::abs(in.tan_alpha) / peak[0][load], k = std::abs(in.kappa) / peak[1][load];
    const std::size_t kind = k <= kPurity && k <= a ? 0 : a <= kPurity ? 1 : k <= kPurity ? 0 : 2;
    if (kind < 2)
      pure[kind][load].push_back(kind == 0 ? std::abs(in.tan_alpha) : std::abs(in.kappa));
    const std::size_t camber = cell_of(kCamberEdges_deg, in.gamma_rad / kDegree),
                      slip = cell_of(kSlipEdges, std::hypot(a, k));
    const std::size_t cell =
        ((kind * kLoadEdges.size() + load) * kCamberEdges_deg.size() + camber) * kSlipEdges.size() +
        slip;
    ++out.cells[cell].rows;
    const auto force =
        vehicle::tyre_forces(fit.tyre, in, {}, {.alpha = fit.alpha, .moments = false});
    left[cell].fx.add(samples.fx_n[i] - force.fx_n);
    left[cell].fy.add(samples.fy_n[i] - force.fy_n);
  }
  for (std::size_t i = 0; i < left.size(); ++i) {
    out.cells[i].fx_left_n = left[i].fx.rms();
    out.cells[i].fy_left_n = left[i].fy.rms();
  }
  for (std::size_t k = 0; k < 2; ++k)
    for (std::size_t l = 0; l < kLoadEdges.size(); ++l) {
      if (pure[k][l].size() < kFewestOfCell || !fitted(fit, kKinds[k])) continue;
      PeakReach one{kKinds[k], l, peak[k][l], base::quantile(pure[k][l], 0.99)};
      // The larger side of the curve, as on a car.
      const auto in =
          upright(fit, base::median(loads[l]), k == 0, k == 0 ? -one.peak_slip : one.peak_slip);
      const ForceBand band = force_band(fit, in);
      one.peak_n = std::abs(k == 0 ? band.fy_n : band.fx_n);
      one.sd_n = k == 0 ? band.fy_sd_n : band.fx_sd_n;
      one.reached = one.measured_slip > 1.05 * one.peak_slip && one.peak_slip < kMostSlip;
      out.peaks.push_back(one);
    }
  double tan_most = 0.1, kappa_most = 0.1;
  for (std::size_t l = 0; l < kLoadEdges.size(); ++l) {
    tan_most = std::max(tan_most, peak[0][l]);
    kappa_most = std::max(kappa_most, peak[1][l]);
  }
  out.next =
      next_measurement(fit, out.measured, std::min(tan_most, 0.3), std::min(kappa_most, 0.3));
  return out;
}

}  // namespace identify
