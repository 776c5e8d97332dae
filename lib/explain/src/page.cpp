#include "explain/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace explain {
namespace {

std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&') out += "&amp;";
    else if (c == '<') out += "&lt;";
    else if (c == '>') out += "&gt;";
    else if (c == '"') out += "&quot;";
    else if (static_cast<unsigned char>(c) < 32) out += ' ';
    else out += c;
  }
  return out;
}

constexpr const char* kStyle = R"(body{font:15px/1.45 system-ui,sans-serif;color:#1c2430;max-width:1080px;margin:2em auto;padding:0 1em}
h1{font-size:1.5em}h2{font-size:1.15em;margin-top:2em;border-bottom:1px solid #d5dbe3}table{border-collapse:collapse;width:100%}
td,th{text-align:left;padding:.25em .6em;border-bottom:1px solid #e6eaef;vertical-align:top}td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}
.verdict{display:inline-block;padding:.15em .7em;border-radius:1em;color:#fff;background:#3d6fb4}.none{background:#2e8b57}.unknown{background:#b5472f}.tie{background:#a3742a}
.small{color:#5a6675;font-size:.9em}svg{background:#fbfcfd;border:1px solid #e1e6ec;display:block;margin:.5em 0})";

const char* meaning(const std::string& verdict) {
  if (verdict == "none") return "Nothing is missing that these recordings can show.";
  if (verdict == "explained") return "What was found explains everything significant.";
  if (verdict == "tie") return "Something is missing, but these recordings cannot tell two explanations apart.";
  return "Something is missing that no mechanism tried here explains.";
}

std::string map_of(const Findings& f, const Signals& s) {
  double x0 = 1e300, x1 = -1e300, y0 = 1e300, y1 = -1e300;
  for (std::size_t i = 0; i < s.n; ++i)
    if (std::isfinite(s.u_m[i])) {
      x0 = std::min(x0, s.x[kX][i]), x1 = std::max(x1, s.x[kX][i]);
      y0 = std::min(y0, s.x[kY][i]), y1 = std::max(y1, s.x[kY][i]);
    }
  if (!(x1 > x0)) return "";
  const double width = 620, scale = (width - 40) / std::max(1.0, x1 - x0), height = (y1 - y0) * scale + 40;
  const auto point = [&](std::size_t i) { return fmt::format("{:.1f},{:.1f} ", 20 + (s.x[kX][i] - x0) * scale, height - 20 - (s.x[kY][i] - y0) * scale); };
  std::string out = fmt::format("<svg width='{:.0f}' height='{:.0f}' role='img' aria-label='track map'>", width, height), all;
  for (std::size_t i = 0; i < s.n; i += 4)
    if (std::isfinite(s.u_m[i])) all += point(i);
  out += "<polyline fill='none' stroke='#c3ccd6' stroke-width='5' points='" + all + "'/>";
  const auto stretch = [&](const std::vector<Place>& where, const char* colour) {
    for (const Place& p : where) {
      std::string part;
      double last = -1;
      for (std::size_t i = 0; i < s.n; i += 2) {
        const bool in = s.u_m[i] >= p.u_begin_m && s.u_m[i] < p.u_end_m;
        if ((!in || s.u_m[i] < last) && !part.empty()) {
          out += fmt::format("<polyline fill='none' stroke='{}' stroke-width='5' points='{}'/>", colour, part);
          part.clear();
          break;
        }
        if (in) part += point(i), last = s.u_m[i];
      }
      if (!part.empty()) out += fmt::format("<polyline fill='none' stroke='{}' stroke-width='5' points='{}'/>", colour, part);
    }
  };
  for (const Unexplained& u : f.unexplained) stretch(u.where, "#b5472f");
  for (const Finding& x : f.findings) stretch(x.where, "#3d6fb4");
  return out + "</svg><p class='small'>Blue: found on the road. Red: unexplained. Grey: driven.</p>";
}

/// Means over 10 m of u, before and after.
std::string plot(const Trace& t, double length_m) {
  const auto cells = static_cast<std::size_t>(length_m / 10) + 1;
  std::vector<double> b(cells), a(cells), n(cells);
  for (std::size_t i = 0; i < t.u_m.size(); ++i) {
    const std::size_t k = std::min(cells - 1, static_cast<std::size_t>(std::max(0.0, t.u_m[i]) / 10));
    b[k] += t.before[i], a[k] += t.after[i], n[k] += 1;
  }
  double most = 1e-9;
  for (std::size_t k = 0; k < cells; ++k)
    if (n[k] > 0) most = std::max({most, std::abs(b[k] / n[k]), std::abs(a[k] / n[k])});
  constexpr double kWidth = 1000, kHeight = 130;
  const auto line = [&](const std::vector<double>& v, const char* colour) {
    std::string points;
    for (std::size_t k = 0; k < cells; ++k)
      if (n[k] > 0) points += fmt::format("{:.1f},{:.1f} ", 60 + (kWidth - 70) * static_cast<double>(k) / static_cast<double>(cells), kHeight / 2 - 0.42 * kHeight * v[k] / n[k] / most);
    return fmt::format("<polyline fill='none' stroke='{}' stroke-width='1.5' points='{}'/>", colour, points);
  };
  return fmt::format("<h3>{} <span class='small'>({}; mean over the laps, held out in turn)</span></h3><svg width='{}' height='{}' role='img' aria-label='{} along u'>"
                     "<line x1='60' x2='{}' y1='{}' y2='{}' stroke='#d5dbe3'/><text x='4' y='16' font-size='11'>{:.3g}</text><text x='4' y='{}' font-size='11'>{:.3g}</text>"
                     "<text x='60' y='{}' font-size='11'>u = 0</text><text x='{}' y='{}' font-size='11' text-anchor='end'>{:.0f} m</text>{}{}</svg>",
                     escape(t.channel), escape(t.unit), kWidth, kHeight, escape(t.channel), kWidth - 10, kHeight / 2, kHeight / 2, most, kHeight - 16, -most, kHeight - 3, kWidth - 10,
                     kHeight - 3, length_m, line(b, "#d08a3a"), line(a, "#3d6fb4"));
}

}  // namespace

std::string findings_page(const Findings& f, const std::vector<Signals>& logs, const std::string& title) {
  std::string out = fmt::format("<!doctype html><html lang='en'><head><meta charset='utf-8'><title>{}</title><style>{}</style></head><body>", escape(title), kStyle);
  out += fmt::format("<h1>{}</h1><p><span class='verdict {}'>{}</span> {}</p>", escape(title), escape(f.verdict), escape(f.verdict), meaning(f.verdict));
  if (!logs.empty()) out += map_of(f, logs.front());
  out += "<h2>Found</h2>";
  if (f.findings.empty()) out += "<p>Nothing.</p>";
  for (const Finding& x : f.findings) {
    out += fmt::format("<h3>{}{}</h3><p>{}. <span class='small'>{}</span></p><ul>", escape(x.mechanism), x.channel.empty() ? "" : " in " + escape(x.channel), escape(x.physics), escape(x.equation));
    for (const FoundParameter& p : x.parameters)
      out += fmt::format("<li>{} = {:.4g} {} <span class='small'>(90 %: {:.4g} to {:.4g})</span></li>", escape(p.name), p.value, escape(p.unit), p.low, p.high);
    for (const Place& w : x.where) out += fmt::format("<li>u from {:.0f} to {:.0f} m</li>", w.u_begin_m, w.u_end_m);
    for (const Rival& r : x.rivals)
      out += fmt::format("<li>{} <b>{}</b>{}{}</li>", r.separable ? "Fits worse:" : "Cannot be told from", escape(r.mechanism), r.channel.empty() ? "" : " in " + escape(r.channel), r.separable ? "" : ": " + escape(r.separating_experiment));
    out += "</ul>";
  }
  if (!f.findings.empty() && !f.findings.front().held_out.empty()) {
    out += "<h2>Laps that were not used</h2><p class='small'>Before: the stated car with its parameters refitted. After: the same with the findings. Trivial: nothing changes within the horizon "
           "(horizon 0: the stated car without refit).</p><table><tr><th>channel</th><th class=n>horizon, s</th><th class=n>before</th><th class=n>after</th><th class=n>trivial</th><th class=n>drop, 90 %</th></tr>";
    for (const HeldOut& h : f.findings.front().held_out)
      out += fmt::format("<tr><td>{}, {}</td><td class=n>{:.1f}</td><td class=n>{:.4g}</td><td class=n>{:.4g}</td><td class=n>{:.4g}</td><td class=n>{:.1f} to {:.1f} %</td></tr>", escape(h.channel), escape(h.unit),
                         h.horizon_s, h.rmse_before, h.rmse_after, h.trivial_rmse, 100 * h.drop_low, 100 * h.drop_high);
    out += "</table>";
  }
  out += "<h2>Unexplained</h2>";
  if (f.unexplained.empty()) out += "<p>Nothing significant.</p>";
  for (const Unexplained& u : f.unexplained)
    out += fmt::format("<p>{}: a pattern over {}{} ({:.0f} % of the residual there)</p>", escape(u.channel), escape(u.locked_to),
                       u.where.empty() ? "" : fmt::format(", u {:.0f} to {:.0f} m", u.where[0].u_begin_m, u.where[0].u_end_m), 100 * u.share);
  out += "<h2>Parameters, refitted</h2><table><tr><th>parameter</th><th class=n>stated</th><th class=n>value</th><th class=n>90 %</th><th>unit</th></tr>";
  for (const ParameterValue& p : f.parameters)
    out += fmt::format("<tr><td>{}</td><td class=n>{:.4g}</td><td class=n>{:.4g}</td><td class=n>{:.4g} to {:.4g}</td><td>{}</td></tr>", escape(p.name), p.stated, p.value, p.low, p.high, escape(p.unit));
  out += fmt::format("</table><h2>Everything that was tried</h2><p class='small'>Score in standard deviations; {:.1f} is exceeded by 0.7 % of {} null replicates of this log over all mechanisms together.</p><table><tr><th>mechanism</th><th>channel</th><th>amount</th><th class=n>score</th><th class=n>gain on laps left out</th></tr>",
                     f.threshold, f.null_replicates);
  for (const Evidence& e : f.evidence)
    out += fmt::format("<tr><td>{}</td><td>{}</td><td>{:.3g} {} <span class='small'>{}</span></td><td class=n>{:.1f}</td><td class=n>{:.1f}</td></tr>", escape(e.mechanism), escape(e.channel), e.amount, escape(e.unit),
                       escape(e.detail), e.statistic, e.cv_gain);
  out += "</table><h2>Not testable with these recordings</h2><table>";
  for (const Untestable& u : f.untestable) out += fmt::format("<tr><td>{}</td><td>{}</td></tr>", escape(u.mechanism), escape(u.reason));
  out += "</table><h2>Along the road</h2><p class='small'>Orange: before. Blue: after.</p>";
  if (!logs.empty())
    for (const Trace& t : f.traces) out += plot(t, logs.front().length_m);
  return out + "</body></html>\n";
}

}  // namespace explain
