// The page of a fitted tyre.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/statistics.h"
#include "report/plot_page.h"
#include "tyre_report.h"

namespace crgidentify {
namespace {

using identify::SlipKind;
constexpr double kPure = 0.02;           // slip of the other direction beside which a row is drawn
constexpr std::size_t kMostDots = 1200;  // of a drawing; more are thinned evenly
constexpr std::size_t kKeptRows = 600;   // drawn of what was kept back

bool by_alpha(SlipKind kind) { return kind != SlipKind::kLongitudinal; }

/// The rows of pure slip in a cell of loads, and the load and camber that stand for them.
struct Cell {
  std::vector<std::size_t> rows;
  double fz_n = 0.0, gamma_rad = 0.0, most_slip = 0.0;
};

Cell cell_of(const identify::TyreSamples& samples, double low_n, double high_n, SlipKind kind) {
  Cell out;
  std::vector<double> load, camber;
  for (std::size_t i = 0; i < samples.rows(); ++i) {
    const auto& c = samples.conditions[i];
    if (c.fz_n < low_n || c.fz_n >= high_n ||
        std::abs(by_alpha(kind) ? c.kappa : c.tan_alpha) > kPure)
      continue;
    out.rows.push_back(i);
    load.push_back(c.fz_n);
    camber.push_back(c.gamma_rad);
    out.most_slip = std::max(out.most_slip, std::abs(by_alpha(kind) ? c.tan_alpha : c.kappa));
  }
  out.fz_n = base::median_or(0.5 * (low_n + std::min(high_n, 3.0 * low_n)), load);
  out.gamma_rad = base::median_or(0.0, camber);
  return out;
}

/// Fitted with its band, and by the reference, of a tyre at a load and camber.
void add_curves(report::Plot& plot, const TyreResult& result,
                const vehicle::TyreCoefficients& reference, const Cell& cell, double most_slip,
                SlipKind kind) {
  report::PlotLine fitted{"fitted, with its 90 % band", {}, {}}, before{"reference", {}, {}};
  const vehicle::TyreOptions law{.alpha = result.fit.alpha};
  constexpr int kPoints = 100;
  for (int i = -kPoints; i <= kPoints; ++i) {
    vehicle::TyreInput<double> in{
        .fz_n = cell.fz_n, .gamma_rad = cell.gamma_rad, .vx_mps = reference.nominal_speed_mps};
    const double slip = most_slip * i / kPoints;
    (by_alpha(kind) ? in.tan_alpha : in.kappa) = slip;
    const auto band = identify::force_band(result.fit, in);
    const auto was = vehicle::tyre_forces(reference, in, {}, law);
    const auto [y, sd, y_before] =
        kind == SlipKind::kLateral        ? std::tuple{band.fy_n, band.fy_sd_n, was.fy_n}
        : kind == SlipKind::kLongitudinal ? std::tuple{band.fx_n, band.fx_sd_n, was.fx_n}
                                          : std::tuple{band.mz_nm, band.mz_sd_nm, was.mz_nm};
    for (auto* line : {&fitted, &before})
      line->x.push_back(by_alpha(kind) ? std::atan(slip) / kDegree : slip);
    fitted.y.push_back(y);
    fitted.low.push_back(y - kNormal90 * sd);
    fitted.high.push_back(y + kNormal90 * sd);
    before.y.push_back(y_before);
  }
  plot.lines.push_back(std::move(fitted));
  plot.lines.push_back(std::move(before));
}

/// Those of either wheel; of a bench all.
void add_rows(report::Plot& plot, const identify::TyreSamples& samples,
              const std::vector<bool>& right, const Cell& cell, SlipKind kind) {
  const std::vector<double>& measured = kind == SlipKind::kLateral        ? samples.fy_n
                                        : kind == SlipKind::kLongitudinal ? samples.fx_n
                                                                          : samples.mz_nm;
  const std::size_t every = (cell.rows.size() + kMostDots - 1) / kMostDots;
  for (const bool side : {false, true}) {
    report::PlotLine rows{right.empty() ? "rows" : side ? "right wheel" : "left wheel", {}, {}};
    rows.dots = true;
    for (std::size_t k = 0; k < cell.rows.size(); k += every) {
      const std::size_t i = cell.rows[k];
      if ((!right.empty() && right[i]) != side) continue;
      const auto& c = samples.conditions[i];
      rows.x.push_back(by_alpha(kind) ? std::atan(c.tan_alpha) / kDegree : c.kappa);
      rows.y.push_back(measured[i]);
    }
    if (!rows.x.empty()) plot.lines.push_back(std::move(rows));
  }
}

/// What is left by load and slip, all cambers together.
std::vector<report::Fact> left_by_condition(const TyreResult& result) {
  std::vector<report::Fact> out;
  for (const bool lateral : {true, false})
    for (std::size_t load = 0; load < identify::kLoadEdges.size(); ++load) {
      std::string text;
      for (std::size_t slip = 0; slip < identify::kSlipEdges.size(); ++slip) {
        double squares = 0.0, rows = 0.0;
        for (const auto& cell : result.conditions.cells) {
          const double left_n = lateral ? cell.fy_left_n : cell.fx_left_n;
          const bool here = cell.load == load && cell.slip == slip &&
                            cell.kind != (lateral ? SlipKind::kLongitudinal : SlipKind::kLateral);
          if (!here || std::isnan(left_n)) continue;
          squares += left_n * left_n * static_cast<double>(cell.rows);
          rows += static_cast<double>(cell.rows);
        }
        if (rows > 0.0)
          text += fmt::format("{}{:.0f} N at slip {}", text.empty() ? "" : ", ",
                              std::sqrt(squares / rows), span_of(identify::kSlipEdges, slip));
      }
      if (!text.empty())
        out.push_back({fmt::format("{} force missed, load {}", lateral ? "Side" : "Longitudinal",
                                   span_of(identify::kLoadEdges, load)),
                       text});
    }
  return out;
}

/// The first rows of a wheel that were kept back: measured, by the fitted tyre, by the reference.
report::Plot kept_back(const TyreResult& result, const identify::DriveTyres& drives,
                       const vehicle::TyreCoefficients& reference, bool lateral) {
  report::Plot plot{
      fmt::format("{} force kept back from the fit, left wheel", lateral ? "Side" : "Longitudinal"),
      "row",
      "N",
      {{"by crgidentify forces", {}, {}}, {"fitted", {}, {}}, {"reference", {}, {}}}};
  const vehicle::TyreOptions law{.alpha = result.fit.alpha, .moments = false};
  for (std::size_t i = 0; i < drives.held_out.rows() && plot.lines[0].x.size() < kKeptRows; ++i) {
    if (drives.held_right[i]) continue;
    const auto& c = drives.held_out.conditions[i];
    const auto f = vehicle::tyre_forces(result.fit.tyre, c, {}, law),
               r = vehicle::tyre_forces(reference, c, {}, law);
    const double x = static_cast<double>(plot.lines[0].x.size());
    for (auto& line : plot.lines) line.x.push_back(x);
    plot.lines[0].y.push_back(lateral ? drives.held_out.fy_n[i] : drives.held_out.fx_n[i]);
    plot.lines[1].y.push_back(lateral ? f.fy_n : f.fx_n);
    plot.lines[2].y.push_back(lateral ? r.fy_n : r.fx_n);
  }
  return plot;
}

}  // namespace

std::string tyre_page(const TyreResult& result, const identify::TyreSamples& samples,
                      const identify::DriveTyres& drives,
                      const vehicle::TyreCoefficients& reference, const std::string& name) {
  report::PlotPage page;
  page.title = "Fitted tyre " + name;
  page.sentences = {
      "Curves are of pure slip, at the load and camber in the title, which are the medians of the "
      "rows beside them; the band is the 90 % interval of the fitted one. Dots are rows of nearly "
      "pure slip, each with its own load and camber.",
      "What is missed is the root mean square of measured less fitted force. Loads are shares of "
      "the nominal one, slips of that of the fitted peak."};
  page.facts = left_by_condition(result);
  const identify::HeldOut &f = result.held_fitted, &r = result.held_reference;
  if (f.rows > 0) {
    const auto missed = [&](double after_n, double before_n, double of_n) {
      return fmt::format("missed by {:.1f} N, by the reference by {:.1f}, of {:.0f}", after_n,
                         before_n, of_n);
    };
    page.facts.push_back({fmt::format("Kept back, {} rows: side force", f.rows),
                          missed(f.fy_left_n, r.fy_left_n, f.fy_n)});
    page.facts.push_back(
        {"Kept back: longitudinal force", missed(f.fx_left_n, r.fx_left_n, f.fx_n)});
  }
  const double nominal_n = reference.nominal_load_n * reference.lfzo;
  for (const auto& peak : result.conditions.peaks) {
    const bool last = peak.load + 1 == identify::kLoadEdges.size();
    const double low = identify::kLoadEdges[peak.load],
                 high = last ? INFINITY : identify::kLoadEdges[peak.load + 1];
    const auto add = [&](SlipKind kind, const char* what, const char* remark) {
      const Cell cell = cell_of(samples, low * nominal_n, high * nominal_n, kind);
      report::Plot plot{fmt::format("{} at {:.0f} N, camber {:.1f} degrees{}", what, cell.fz_n,
                                    cell.gamma_rad / kDegree, remark),
                        by_alpha(kind) ? "alpha, degrees" : "kappa",
                        kind == SlipKind::kAligning ? "Nm" : "N",
                        {}};
      add_rows(plot, samples, drives.fit_right, cell, kind);
      add_curves(plot, result, reference, cell, std::max(1.3 * peak.peak_slip, cell.most_slip),
                 kind);
      page.plots.push_back(std::move(plot));
    };
    const bool lateral = peak.kind == SlipKind::kLateral;
    add(peak.kind, lateral ? "Side force" : "Longitudinal force",
        peak.reached ? "" : " (peak not reached: a bound only)");
    if (lateral && result.fit.mz.rows > 0) add(SlipKind::kAligning, "Aligning moment", "");
  }
  if (f.rows > 0)
    for (const bool lateral : {true, false})
      page.plots.push_back(kept_back(result, drives, reference, lateral));
  return report::plot_page(page);
}

}  // namespace crgidentify
