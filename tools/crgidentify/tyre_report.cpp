#include "tyre_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "report/plot_page.h"

namespace crgidentify {
namespace {

using identify::SlipKind;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double k90 = 1.645;       // standard deviations of a 90 % interval
constexpr double kTogether = 0.95;  // correlation that is named
constexpr double kHardlyFromData =
    0.5;  // share of the prior variance that is left to the reference

const char* word(SlipKind kind) {
  return kind == SlipKind::kLateral        ? "side"
         : kind == SlipKind::kLongitudinal ? "longitudinal"
                                           : "combined";
}

struct Pair {
  std::string a, b;
  double r;
};

std::vector<Pair> correlated(const identify::TyreFit& fit) {
  std::vector<Pair> out;
  const std::size_t n = fit.coefficients.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const auto &a = fit.coefficients[i], &b = fit.coefficients[j];
      const double r = a.sd > 0 && b.sd > 0 ? fit.covariance[i * n + j] / (a.sd * b.sd) : 0.0;
      if (std::abs(r) >= kTogether) out.push_back({a.keyword, b.keyword, r});
    }
  std::stable_sort(out.begin(), out.end(),
                   [](const Pair& a, const Pair& b) { return std::abs(a.r) > std::abs(b.r); });
  return out;
}

template <std::size_t n>
std::string span_of(const std::array<double, n>& edges, std::size_t i) {
  return i + 1 < n ? fmt::format("{:g} to {:g}", edges[i], edges[i + 1])
                   : fmt::format("over {:g}", edges[i]);
}

std::string camber_span(std::size_t i) {
  return i == 0 ? "below -3" : span_of(identify::kCamberEdges_deg, i);
}

std::string cells_text(const identify::TyreConditions& conditions) {
  std::string out =
      "Rows by load (of the nominal), camber (degrees) and slip (of the peak's: to 0.35, 0.75, "
      "1.05, over)\n";
  out += fmt::format("{:>12} {:>9} | {:^27} | {:^27} | {:^27}\n", "load", "camber", "side",
                     "longitudinal", "combined");
  const std::size_t loads = identify::kLoadEdges.size(),
                    cambers = identify::kCamberEdges_deg.size(),
                    slips = identify::kSlipEdges.size();
  for (std::size_t l = 0; l < loads; ++l)
    for (std::size_t c = 0; c < cambers; ++c) {
      out += fmt::format("{:>12} {:>9}", span_of(identify::kLoadEdges, l), camber_span(c));
      for (std::size_t k = 0; k < 3; ++k) {
        out += " |";
        for (std::size_t s = 0; s < slips; ++s) {
          const std::size_t rows =
              conditions.cells[((k * loads + l) * cambers + c) * slips + s].rows;
          out += rows == 0 ? fmt::format("{:>7}", "-") : fmt::format("{:>7}", rows);
        }
      }
      out += "\n";
    }
  return out;
}

std::string residual_text(const char* name, const identify::TyreResiduals& r) {
  if (r.rows == 0) return fmt::format("{}: not measured\n", name);
  return fmt::format(
      "{}: {} rows, {:.1f} N rms left, noise {:.1f} N, {:.1f} % of the rows further away than four "
      "of it{}\n",
      name, r.rows, r.rms_n, r.noise_n, 100.0 * r.far,
      r.repeats > 1.5
          ? fmt::format("; {:.1f} rows count as one, because errors follow each other", r.repeats)
          : "");
}

/// The last quarters of the drives, which the fit did not see; empty of a bench.
std::string held_text(const TyreResult& result) {
  const identify::HeldOut &f = result.held_fitted, &r = result.held_reference;
  if (f.rows == 0) return {};
  return fmt::format(
      "Kept back, the last quarter of every drive ({} rows): fx_n is missed by {:.1f} N, by the "
      "reference by {:.1f} (of {:.0f}); fy_n by {:.1f} and {:.1f} (of {:.0f})\nTreads at {:.0f} K: "
      "the tyre is that of these temperatures\nForces of drives are split between the wheels of an "
      "axle by load and the tyre that they were estimated with: load and camber are told apart "
      "less "
      "than the intervals say\n",
      f.rows, f.fx_left_n, r.fx_left_n, f.fx_n, f.fy_left_n, r.fy_left_n, f.fy_n, result.tyre_k);
}

std::string place(const vehicle::TyreInput<double>& in) {
  return fmt::format("load {:.0f} N, camber {:.1f} degrees, slip angle {:.1f} degrees, slip {:.3f}",
                     in.fz_n, in.gamma_rad / kDegree, std::atan(in.tan_alpha) / kDegree, in.kappa);
}

}  // namespace

std::string tyre_text(const TyreResult& result) {
  const auto& fit = result.fit;
  std::string out = fmt::format("{} rows, {} looked at, {} left out\n", result.rows_given, fit.rows,
                                result.rows_left_out);
  for (const auto& stage : fit.stages)
    out += stage.why_not.empty()
               ? fmt::format("{} slip: {} rows, {} of {} starts agree\n", word(stage.kind),
                             stage.rows, stage.agreeing, stage.starts)
               : fmt::format("{} slip: not fitted, the reference's values stay: {}\n",
                             word(stage.kind), stage.why_not);
  if (fit.camber_follows)
    out +=
        "Camber goes with side slip and load in these rows, and is not told from them: its "
        "coefficients are the reference's, their prior counts in the intervals\n";
  out += residual_text("fx_n", fit.fx) + residual_text("fy_n", fit.fy);
  out += held_text(result);
  out += fmt::format("{:8} {:>12} {:>12} {:>12}  {}\n", "", "value", "90 %: +-", "reference",
                     "from the data");
  for (const auto& c : fit.coefficients)
    out += fmt::format(
        "{:8} {:>12.5g} {:>12.2g} {:>12.5g}  {}\n", c.keyword, c.value, k90 * c.sd, c.reference,
        c.at_bound ? "at its bound: no interval"
        : c.from_data < kHardlyFromData
            ? fmt::format("{:.0f} %: mostly the reference's word", 100.0 * c.from_data)
            : fmt::format("{:.0f} %", 100.0 * c.from_data));
  const auto pairs = correlated(fit);
  if (!pairs.empty()) {
    out += "Found together only (correlation):";
    for (std::size_t i = 0; i < std::min<std::size_t>(12, pairs.size()); ++i)
      out += fmt::format("{} {} {} {:.3f}", i ? "," : "", pairs[i].a, pairs[i].b, pairs[i].r);
    out += pairs.size() > 12 ? fmt::format(", and {} pairs more\n", pairs.size() - 12) : "\n";
  }
  out += cells_text(result.conditions);
  for (const auto& p : result.conditions.peaks)
    out += fmt::format(
        "{} force, load {}: peak {:.0f} N +- {:.0f} at slip {:.3f}{}\n", word(p.kind),
        span_of(identify::kLoadEdges, p.load), p.peak_n, k90 * p.sd_n, p.peak_slip,
        p.reached
            ? ""
            : fmt::format(": not reached (rows end at {:.3f}), a bound only", p.measured_slip));
  const auto& next = result.conditions.next;
  if (next.sd_n > 0)
    out +=
        fmt::format("Most useful next: {} slip, {}: force {:.0f} N is known to +- {:.0f} N there\n",
                    word(next.kind), place(next.condition), next.force_n, k90 * next.sd_n);
  for (const auto& f : result.faults)
    out += fmt::format("Must not be used: load {:.0f} N, camber {:.1f} degrees: {}\n", f.fz_n,
                       f.gamma_rad / kDegree, f.what);
  return out;
}

nlohmann::ordered_json tyre_json(const TyreResult& result) {
  using Json = nlohmann::ordered_json;
  const auto& fit = result.fit;
  const auto residuals = [](const identify::TyreResiduals& r) {
    return Json{{"rows", r.rows},
                {"rms_n", r.rms_n},
                {"noise_n", r.noise_n},
                {"far_share", r.far},
                {"rows_that_count_as_one", r.repeats}};
  };
  Json out{{"rows", result.rows_given},
           {"rows_looked_at", fit.rows},
           {"rows_left_out", result.rows_left_out},
           {"camber_follows_side_slip", fit.camber_follows},
           {"fx", residuals(fit.fx)},
           {"fy", residuals(fit.fy)}};
  for (const auto& s : fit.stages)
    out["stages"].push_back({{"slip", word(s.kind)},
                             {"rows", s.rows},
                             {"starts", s.starts},
                             {"agreeing", s.agreeing},
                             {"not_fitted_because", s.why_not}});
  for (const auto& c : fit.coefficients)
    out["coefficients"].push_back({{"keyword", c.keyword},
                                   {"value", c.value},
                                   {"sd", c.sd},
                                   {"low_90", c.value - k90 * c.sd},
                                   {"high_90", c.value + k90 * c.sd},
                                   {"reference", c.reference},
                                   {"from_data", c.from_data},
                                   {"at_bound", c.at_bound}});
  out["correlations"] = Json::array();
  for (const auto& p : correlated(fit)) out["correlations"].push_back({p.a, p.b, p.r});
  for (const auto& c : result.conditions.cells)
    out["cells"].push_back({{"slip", word(c.kind)},
                            {"load_of_nominal", span_of(identify::kLoadEdges, c.load)},
                            {"camber_deg", camber_span(c.camber)},
                            {"slip_of_peak", span_of(identify::kSlipEdges, c.slip)},
                            {"rows", c.rows}});
  out["peaks"] = Json::array();
  for (const auto& p : result.conditions.peaks)
    out["peaks"].push_back({{"slip", word(p.kind)},
                            {"load_of_nominal", span_of(identify::kLoadEdges, p.load)},
                            {"peak_n", p.peak_n},
                            {"sd_n", p.sd_n},
                            {"peak_slip", p.peak_slip},
                            {"measured_slip", p.measured_slip},
                            {"reached", p.reached}});
  const auto& next = result.conditions.next;
  out["next"] = {{"slip", word(next.kind)},
                 {"fz_n", next.condition.fz_n},
                 {"kappa", next.condition.kappa},
                 {"alpha_rad", std::atan(next.condition.tan_alpha)},
                 {"gamma_rad", next.condition.gamma_rad},
                 {"force_n", next.force_n},
                 {"sd_n", next.sd_n}};
  out["faults"] = Json::array();
  for (const auto& f : result.faults)
    out["faults"].push_back({{"fz_n", f.fz_n}, {"gamma_rad", f.gamma_rad}, {"what", f.what}});
  if (result.held_fitted.rows > 0) {
    const auto held = [](const identify::HeldOut& h) {
      return Json{{"fx_rms_n", h.fx_left_n}, {"fy_rms_n", h.fy_left_n}};
    };
    out["kept_back"] = {
        {"rows", result.held_fitted.rows},          {"fx_n", result.held_fitted.fx_n},
        {"fy_n", result.held_fitted.fy_n},          {"fitted", held(result.held_fitted)},
        {"reference", held(result.held_reference)}, {"tread_k", result.tyre_k}};
  }
  return out;
}

std::string tyre_page(const TyreResult& result, const vehicle::TyreCoefficients& reference,
                      const std::string& name) {
  report::PlotPage page;
  page.title = "Fitted tyre " + name;
  page.sentences = {
      "Pure slip, upright, at the nominal share of load in the title; the band is the 90 % "
      "interval of the fitted curve."};
  const double nominal_n = reference.nominal_load_n * reference.lfzo;
  const vehicle::TyreOptions law{.alpha = result.fit.alpha, .moments = false};
  for (const auto& peak : result.conditions.peaks) {
    const bool lateral = peak.kind == SlipKind::kLateral;
    const bool last = peak.load + 1 == identify::kLoadEdges.size();
    const double share =
        last ? identify::kLoadEdges[peak.load]
             : 0.5 * (identify::kLoadEdges[peak.load] + identify::kLoadEdges[peak.load + 1]);
    report::Plot plot{
        fmt::format("{} force at {:.2f} of the nominal load{}", lateral ? "Side" : "Longitudinal",
                    share, peak.reached ? "" : " (peak not reached: a bound only)"),
        lateral ? "alpha, degrees" : "kappa",
        "N",
        {}};
    report::PlotLine fitted{"fitted", {}, {}}, low{"90 % low", {}, {}}, high{"90 % high", {}, {}},
        before{"reference", {}, {}};
    constexpr int kPoints = 100;
    for (int i = -kPoints; i <= kPoints; ++i) {
      vehicle::TyreInput<double> in;
      in.fz_n = share * nominal_n;
      in.vx_mps = reference.nominal_speed_mps;
      const double slip = 1.3 * peak.peak_slip * i / kPoints;
      (lateral ? in.tan_alpha : in.kappa) = slip;
      const auto band = identify::force_band(result.fit, in);
      const auto was = vehicle::tyre_forces(reference, in, {}, law);
      const double x = lateral ? std::atan(slip) / kDegree : slip;
      const double y = lateral ? band.fy_n : band.fx_n, sd = lateral ? band.fy_sd_n : band.fx_sd_n;
      for (auto* line : {&fitted, &low, &high, &before}) line->x.push_back(x);
      fitted.y.push_back(y);
      low.y.push_back(y - k90 * sd);
      high.y.push_back(y + k90 * sd);
      before.y.push_back(lateral ? was.fy_n : was.fx_n);
    }
    plot.lines = {fitted, low, high, before};
    page.plots.push_back(plot);
  }
  return report::plot_page(page);
}

}  // namespace crgidentify
