#include "tyre_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace crgidentify {
namespace {

using identify::SlipKind;
constexpr double kTogether = 0.95;  // correlation that is named
constexpr double kHardlyFromData =
    0.5;  // share of the prior variance that is left to the reference

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

std::string residual_text(const char* name, const char* unit, const identify::TyreResiduals& r) {
  if (r.rows == 0) return fmt::format("{}: not measured\n", name);
  return fmt::format(
      "{}: {} rows, {:.1f} {} rms left, noise {:.1f} {}, {:.1f} % of the rows further away than "
      "four of it{}\n",
      name, r.rows, r.rms, unit, r.noise, unit, 100.0 * r.far,
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

const char* word(SlipKind kind) {
  return kind == SlipKind::kLateral        ? "side"
         : kind == SlipKind::kLongitudinal ? "longitudinal"
         : kind == SlipKind::kCombined     ? "combined"
                                           : "aligning";
}

std::string tyre_text(const TyreResult& result) {
  const auto& fit = result.fit;
  std::string out = fmt::format("{} rows, {} looked at, {} left out\n", result.rows_given, fit.rows,
                                result.rows_left_out);
  for (const auto& stage : fit.stages) {
    const char* what = stage.kind == SlipKind::kAligning ? "moment" : "slip";
    out += stage.why_not.empty()
               ? fmt::format("{} {}: {} rows, {} of {} starts agree\n", word(stage.kind), what,
                             stage.rows, stage.agreeing, stage.starts)
               : fmt::format("{} {}: not fitted, the reference's values stay: {}\n",
                             word(stage.kind), what, stage.why_not);
  }
  if (fit.camber_follows)
    out +=
        "Camber goes with side slip and load in these rows, and is not told from them: its "
        "coefficients are the reference's, their prior counts in the intervals\n";
  out += residual_text("fx_n", "N", fit.fx) + residual_text("fy_n", "N", fit.fy) +
         residual_text("mz_nm", "Nm", fit.mz);
  out += held_text(result);
  out += fmt::format("{:8} {:>12} {:>12} {:>12}  {}\n", "", "value", "90 %: +-", "reference",
                     "from the data");
  for (const auto& c : fit.coefficients)
    out +=
        fmt::format("{:8} {:>12.5g} {:>12.2g} {:>12.5g}  {}\n", c.keyword, c.value,
                    kNormal90 * c.sd, c.reference,
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
    out +=
        fmt::format("{} force, load {}: {}{:.0f} N +- {:.0f} at slip {:.3f}{}\n", word(p.kind),
                    span_of(identify::kLoadEdges, p.load),
                    p.peak_slip < identify::kMostSlip ? "peak " : "only rises, ", p.peak_n,
                    kNormal90 * p.sd_n, p.peak_slip,
                    p.reached ? ""
                              : fmt::format(": peak not reached (rows end at {:.3f}), a bound only",
                                            p.measured_slip));
  const auto& next = result.conditions.next;
  if (next.sd_n > 0)
    out +=
        fmt::format("Most useful next: {} slip, {}: force {:.0f} N is known to +- {:.0f} N there\n",
                    word(next.kind), place(next.condition), next.force_n, kNormal90 * next.sd_n);
  for (const auto& f : result.faults)
    out += fmt::format("Must not be used: load {:.0f} N, camber {:.1f} degrees: {}\n", f.fz_n,
                       f.gamma_rad / kDegree, f.what);
  return out;
}

nlohmann::ordered_json tyre_json(const TyreResult& result) {
  using Json = nlohmann::ordered_json;
  const auto& fit = result.fit;
  const auto residuals = [](const identify::TyreResiduals& r, const std::string& unit = "n") {
    return Json{{"rows", r.rows},
                {"rms_" + unit, r.rms},
                {"noise_" + unit, r.noise},
                {"far_share", r.far},
                {"rows_that_count_as_one", r.repeats}};
  };
  Json out{{"rows", result.rows_given},
           {"rows_looked_at", fit.rows},
           {"rows_left_out", result.rows_left_out},
           {"camber_follows_side_slip", fit.camber_follows},
           {"fx", residuals(fit.fx)},
           {"fy", residuals(fit.fy)},
           {"mz", residuals(fit.mz, "nm")}};
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
                                   {"low_90", c.value - kNormal90 * c.sd},
                                   {"high_90", c.value + kNormal90 * c.sd},
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
                            {"rows", c.rows},
                            {"fx_left_n", c.fx_left_n},
                            {"fy_left_n", c.fy_left_n}});
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

}  // namespace crgidentify
