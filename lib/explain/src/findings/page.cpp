#include "explain/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "not_known.h"
#include "report/plot_page.h"
#include "verdict_box.h"

namespace explain {
namespace {

using report::html_text;
constexpr double kCell_m = 10.0;        ///< of the means along the road
constexpr std::size_t kMostPlaces = 8;  ///< that a sentence or cell lists

std::string figure(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : "–";
}
std::string cell(const std::string& text) { return "<td>" + html_text(text); }
std::string number_cell(const std::string& text) { return "<td class=n>" + html_text(text); }
/// Numbers without a unit have "1" in findings.json.
std::string unit_of(const std::string& unit) { return unit == "1" ? "" : unit; }
std::string number_cell(double value) { return number_cell(figure(value)); }

std::string named(const std::string& mechanism, const std::string& channel) {
  return channel.empty() ? mechanism : mechanism + " in " + channel;
}

/// "u 160 to 320 m, 400 to 420 m and 12 more"
std::string places_text(const std::vector<Place>& where) {
  std::string out;
  for (std::size_t i = 0; i < std::min(where.size(), kMostPlaces); ++i)
    out += fmt::format("{}{:.0f} to {:.0f} m", i == 0 ? "u " : ", ", where[i].u_begin_m,
                       where[i].u_end_m);
  if (where.size() > kMostPlaces) out += fmt::format(" and {} more", where.size() - kMostPlaces);
  return out;
}

/// A table within a section that may be longer than a sheet of paper. head: `<th>` cells.
std::string table(const std::string& title, const std::string& words, const std::string& head,
                  const std::string& rows) {
  return "<section class=long><h2>" + title + "</h2>" +
         (words.empty() ? "" : "<p><small>" + words + "</small></p>") + "<table><thead><tr>" +
         head + "</thead><tbody>" + rows + "</tbody></table></section>\n";
}

/// Where the car went, as a drawing; u every few hundred metres.
class Map {
 public:
  explicit Map(const Signals& s) : s_(s) {
    for (std::size_t i = 0; i < s.n; ++i) {
      if (!std::isfinite(s.u_m[i]) || !std::isfinite(s.x[kX][i]) || !std::isfinite(s.x[kY][i]))
        continue;
      x0_ = std::min(x0_, s.x[kX][i]), x1_ = std::max(x1_, s.x[kX][i]);
      y0_ = std::min(y0_, s.x[kY][i]), y1_ = std::max(y1_, s.x[kY][i]);
    }
    scale_ = (kSize - 2 * kRoom) / std::max({1.0, x1_ - x0_, y1_ - y0_});
  }
  bool empty() const { return !(x1_ > x0_); }

  std::string draw(const Findings& f) const {
    std::string out = fmt::format(
        "<section><h2>Where</h2><p class=legend><span class=s1>found</span><span "
        "class=sb>unexplained</span>"
        "<span class=s0>driven</span></p><svg class=map viewBox='0 0 {:.0f} {:.0f}' role=img "
        "aria-label='track map'>",
        (x1_ - x0_) * scale_ + 2 * kRoom, (y1_ - y0_) * scale_ + 2 * kRoom);
    out += line("s0", 0, std::numeric_limits<double>::infinity(), s_.n, "");
    for (const Unexplained& u : f.unexplained)
      for (const Place& p : u.where) out += place("sb", p, u.channel);
    for (const Finding& x : f.findings)
      for (const Place& p : x.where) out += place("s1", p, named(x.mechanism, x.channel));
    double step = 100;
    while (s_.length_m / step > 12) step *= step < 300 ? 2.5 : 2;
    double next = 0;
    for (std::size_t i = 0; i < s_.n && next < s_.length_m; ++i)
      if (s_.u_m[i] >= next && s_.u_m[i] < next + 30) {
        const auto [px, py] = pixel(i);
        // At the right edge to the left of its place: a label beyond the drawing is cut off.
        const bool left = px > (x1_ - x0_) * scale_ + 2 * kRoom - 3 * kRoom;
        out += fmt::format("<text x={:.1f} y={:.1f}{}>{}{:.0f}</text>", left ? px - 8 : px + 8,
                           std::max(py - 6, 0.5 * kRoom), left ? " text-anchor=end" : "",
                           next == 0 ? "u = " : "", next);
        next += step;
      }
    return out + "</svg></section>\n";
  }

 private:
  static constexpr double kSize = 900, kRoom = 40;

  std::array<double, 2> pixel(std::size_t i) const {
    return {kRoom + (s_.x[kX][i] - x0_) * scale_, kRoom + (y1_ - s_.x[kY][i]) * scale_};
  }
  /// The first time that the car was there.
  std::string place(const char* colour, const Place& p, const std::string& name) const {
    return line(colour, p.u_begin_m, p.u_end_m, s_.n,
                fmt::format("{}, u {:.0f} to {:.0f} m", name, p.u_begin_m, p.u_end_m));
  }
  std::string line(const char* colour, double begin_m, double end_m, std::size_t n,
                   const std::string& name) const {
    std::string points;
    double last = -1;
    for (std::size_t i = 0; i < n; ++i) {
      const bool in = s_.u_m[i] >= begin_m && s_.u_m[i] < end_m;
      const bool once = std::isfinite(end_m);
      if (once && !points.empty() && (!in || s_.u_m[i] < last)) break;
      if (!in || (!once && i % 4 != 0)) continue;
      const auto [px, py] = pixel(i);
      points += fmt::format("{}{:.1f} {:.1f}", points.empty() ? "M" : "L", px, py);
      last = s_.u_m[i];
    }
    if (points.empty()) return "";
    return fmt::format("<path class='line {}' d='{}'><title>{}</title></path>", colour, points,
                       html_text(name));
  }

  const Signals& s_;
  double x0_ = 1e300, x1_ = -1e300, y0_ = 1e300, y1_ = -1e300, scale_ = 1.0;
};

/// What was measured, and nothing else: each kind of finding has its own figures.
std::string how_sure(const Finding& x) {
  if (x.kind == "parameter" && x.threshold == 0)
    return fmt::format(
        "{:.1f} standard deviations from what the vehicle file states, beyond its "
        "prior width",
        std::abs(x.statistic));
  if (x.threshold == 0 && x.cv_gain == 0) return "by what the columns say of each other";
  const std::string gain = x.cv_gain < 1000
                               ? fmt::format("gain of {:.3g} on laps left out", x.cv_gain)
                               : fmt::format("gain of {:.0f} on laps left out", x.cv_gain);
  // Discs have no score that must be reached.
  if (x.threshold == 0)
    return gain + fmt::format(", better in {:.0f} % of them", 100 * x.stability);
  return fmt::format("score {:.1f} where {:.1f} is needed, ", x.statistic, x.threshold) + gain +
         (std::isfinite(x.stability)
              ? fmt::format(", the same sign in {:.0f} % of half samples", 100 * x.stability)
              : "");
}

std::string found(const Finding& x) {
  std::string out = "<section><h2>" + html_text(named(x.mechanism, x.channel)) + " <small>" +
                    html_text(x.kind) + "</small></h2><p>" + html_text(x.physics) + ". <small>" +
                    html_text(x.equation) + "</small></p><table>";
  for (const FoundParameter& p : x.parameters)
    out += "<tr>" + cell(p.name) + "<td><b>" + html_text(figure(p.value) + " " + unit_of(p.unit)) +
           "</b>" +
           cell(p.low == p.high ? "held, not fitted"
                                : fmt::format("90 %: {} to {}", figure(p.low), figure(p.high)));
  out += "</table>";
  if (!x.where.empty()) out += "<p>Where: " + html_text(places_text(x.where)) + "</p>";
  out += "<p>How sure: " + how_sure(x) + ".</p>";
  if (!x.not_used.empty())
    out += "<p><b>Seen, not used</b> for the corrected inputs: " + html_text(x.not_used) + ".</p>";
  std::string worse;
  for (const Rival& r : x.rivals) {
    const std::string name = html_text(named(r.mechanism, r.channel));
    if (r.separable)
      worse += (worse.empty() ? "<p>Rivals that fit worse: " : ", ") + name;
    else
      out += "<p><b>Cannot be told from " + name + ".</b>" +
             (r.separating_experiment.empty()
                  ? ""
                  : " What would separate them: " + html_text(r.separating_experiment)) +
             "</p>";
  }
  return out + (worse.empty() ? "" : worse + ".</p>") + "</section>\n";
}

std::string held_out_table(const std::vector<HeldOut>& list, const std::vector<Remark>& remarks) {
  std::string rows, refits;
  for (const Remark& remark : remarks)
    if (remark.about == Remark::About::kRefit)
      refits += "</small></p><p><small>" + html_text(remark.text);
  for (const HeldOut& h : list)
    rows += "<tr>" + cell(h.whole_car ? "whole simulated car" : "one relation") + cell(h.channel) +
            cell(h.unit) + number_cell(h.horizon_s > 0 ? figure(h.horizon_s) : "at once") +
            number_cell(h.rmse_before) + number_cell(h.rmse_after) + number_cell(h.trivial_rmse) +
            number_cell(h.trend_rmse) +
            number_cell(fmt::format("{:.1f} to {:.1f} %", 100 * h.drop_low, 100 * h.drop_high));
  return table(
      "Laps that were not used",
      std::string(
          "RMS errors. Before: the stated car with its parameters refitted on the other laps. "
          "After: the same with what is used, or with all where nothing is. Trivial: nothing "
          "changes within the time (at once: the stated car without refit). Trend: it goes on as "
          "in the 0.2 s before. One relation: measured motion against that relation alone; whole "
          "simulated car: lib/vehicle on the recorded commands from recorded states.") +
          refits,
      "<th>judged by<th>channel<th>unit<th class=n>horizon, s<th class=n>before<th class=n>after"
      "<th class=n>trivial<th class=n>trend<th class=n>drop, 90 %",
      rows);
}

std::string mismatches_table(const std::vector<Mismatch>& list) {
  std::string rows;
  for (const Mismatch& m : list)
    rows += "<tr>" + cell(m.channel) + cell(places_text(m.where)) + cell(m.regime) +
            number_cell(fmt::format("{} {}", figure(m.size), unit_of(m.unit))) +
            number_cell(fmt::format("{:.2g}", m.p_adjusted)) +
            number_cell(fmt::format("{:.0f} %", 100 * m.share_of_residual));
  return table("Where simulation and recording differ",
               "Before anything is explained: the stretches that stand out, after the refit of the "
               "parameters.",
               "<th>relation<th>where<th>there<th class=n>size<th class=n>p, adjusted<th "
               "class=n>share of the residual",
               rows);
}

std::string unexplained_table(const std::vector<Unexplained>& list) {
  if (list.empty())
    return "<section><h2>What stays unexplained</h2><p>Nothing significant.</p></section>\n";
  std::string rows;
  std::set<std::string> said;
  for (const Unexplained& u : list) {  // the same pattern shows over much
    if (!said.insert(u.channel).second) continue;
    std::string also;
    for (const Unexplained& other : list)
      if (other.channel == u.channel && &other != &u)
        also += (also.empty() ? "; and over " : ", ") + other.locked_to;
    rows += "<tr>" + cell(u.channel) + cell(u.locked_to + also) + cell(places_text(u.where)) +
            number_cell(fmt::format("{} {}", figure(u.size), unit_of(u.unit))) +
            number_cell(fmt::format("{:.0f} %", 100 * u.share));
  }
  return table("What stays unexplained", "",
               "<th>relation<th>a pattern over<th>where<th class=n>size<th "
               "class=n>share of the residual there",
               rows);
}

std::string seen_table(const std::vector<Seen>& list) {
  std::string rows;
  for (const Seen& s : list)
    rows += "<tr>" + cell(named(s.mechanism, s.channel)) + cell(s.detail) +
            number_cell(figure(s.amount) + " " + unit_of(s.unit)) +
            number_cell(figure(s.low) + " to " + figure(s.high)) +
            number_cell(fmt::format("{:.1f}", std::abs(s.statistic))) + cell(s.why);
  return table("Seen, and not named",
               "Each alone, at the first step; the intervals go by the score alone.",
               "<th>mechanism<th>what<th class=n>amount<th class=n>90 %<th class=n>score<th>why it "
               "is not named",
               rows);
}

std::string parameters_table(const std::vector<ParameterValue>& list) {
  std::string rows;
  for (const ParameterValue& p : list)
    rows += "<tr>" + cell(p.name) + number_cell(p.stated) + number_cell(p.value) +
            number_cell(figure(p.low) + " to " + figure(p.high)) + cell(unit_of(p.unit)) +
            cell(p.at_limit       ? "at its limit: not determined"
                 : p.beyond_prior ? "beyond its prior width"
                 : p.unsure       ? "outside its prior width, not for sure"
                                  : "");
  return table("Parameters, refitted", "",
               "<th>parameter<th class=n>stated<th class=n>value<th class=n>90 %<th>unit<th>",
               rows);
}

std::string tried(const Findings& f) {
  std::string rows;
  for (const Evidence& e : f.evidence)
    rows += "<tr>" + cell(e.mechanism) + cell(e.channel) +
            number_cell(fmt::format("{:.3g}", e.amount)) + cell(unit_of(e.unit)) +
            cell(e.detail + e.place) + number_cell(fmt::format("{:.1f}", e.statistic)) +
            number_cell(fmt::format("{:.1f}", e.cv_gain));
  return table(
      "Everything that was tried",
      fmt::format("Each alone, at the first step. Score in standard deviations; {:.1f} is "
                  "exceeded by 0.45 % of {} null "
                  "replicates of these recordings, over all mechanisms together. Where a finding "
                  "needs less, forces counted as few measurements.",
                  f.threshold, f.null_replicates),
      "<th>mechanism<th>channel<th class=n>amount<th>unit<th>where<th class=n>score<th "
      "class=n>gain on laps left out",
      rows);
}

std::string untestable(const std::vector<Untestable>& list) {
  std::string rows;
  for (const Untestable& u : list) rows += "<tr>" + cell(u.mechanism) + cell(u.reason);
  return table("Not testable with these recordings", "", "<th>mechanism<th>why", rows);
}

std::vector<std::array<double, 2>> bands(const Findings& f) {
  std::vector<std::array<double, 2>> out;
  for (const Finding& x : f.findings)
    for (const Place& p : x.where) out.push_back({p.u_begin_m, p.u_end_m});
  return out;
}

/// One lap of the whole simulated car, and what it is off by.
void plot_driven(std::string& out, const DrivenTrace& t, const Findings& f) {
  const auto off = [](const DrivenTrace::Side& side) {
    std::vector<double> e(side.simulated.size());
    for (std::size_t i = 0; i < e.size(); ++i) e[i] = side.simulated[i] - side.recorded[i];
    return e;
  };
  report::Plot plot{
      fmt::format("{} on lap {}", t.channel, t.lap + 1), "u, m", t.unit, {}, bands(f)};
  plot.lines = {{"simulated, before", t.before.u_m, t.before.simulated},
                {"simulated, after", t.after.u_m, t.after.simulated},
                {"recorded", t.before.u_m, t.before.recorded}};
  out += report::plot_section(plot);
  plot.title = fmt::format("{} on lap {}, simulated less recorded", t.channel, t.lap + 1);
  plot.lines = {{"before", t.before.u_m, off(t.before)}, {"after", t.after.u_m, off(t.after)}};
  out += report::plot_section(plot);
}

/// Means of a relation over 10 m of u.
std::string plot_relation(const Trace& t, double length_m, const Findings& f) {
  const auto cells = static_cast<std::size_t>(length_m / kCell_m) + 1;
  std::vector<double> u(cells), before(cells), after(cells), n(cells);
  for (std::size_t i = 0; i < t.u_m.size(); ++i) {
    const std::size_t k =
        std::min(cells - 1, static_cast<std::size_t>(std::max(0.0, t.u_m[i]) / kCell_m));
    before[k] += t.before[i], after[k] += t.after[i], n[k] += 1;
  }
  for (std::size_t k = 0; k < cells; ++k) {
    u[k] = (static_cast<double>(k) + 0.5) * kCell_m;
    before[k] = n[k] > 0 ? before[k] / n[k] : kNaN;
    after[k] = n[k] > 0 ? after[k] / n[k] : kNaN;
  }
  return report::plot_section(
      {t.channel, "u, m", t.unit, {{"before", u, before}, {"after", u, after}}, bands(f)});
}

std::string along_the_road(const Findings& f, double length_m) {
  std::string out;
  if (!f.driven.empty())
    out +=
        "<h2>The whole simulated car along the road</h2><p><small>A lap that was left out of the "
        "refit: recorded commands, "
        "restarted from the recording every 8 s. Shaded: found there.</small></p>\n";
  for (const DrivenTrace& t : f.driven) plot_driven(out, t, f);
  if (!f.traces.empty())
    out +=
        "<h2>The relations along the road</h2><p><small>What each leaves over: means over 10 m "
        "and the laps, each predicted from "
        "the others. Where one colour is seen both are the same. Shaded: found "
        "there.</small></p>\n";
  for (const Trace& t : f.traces) out += plot_relation(t, length_m, f);
  return out;
}

/// Commands, and the experiments that tell apart what these recordings cannot.
std::string what_next(const Findings& f, const std::vector<NextStep>& next) {
  std::string rows;
  for (const NextStep& step : next)
    rows += "<p>" + html_text(step.what) + ": <code>" + html_text(step.how) + "</code></p>";
  for (const Finding& x : f.findings)
    for (const Rival& r : x.rivals)
      if (!r.separable)
        rows += "<p>tell " + html_text(named(x.mechanism, x.channel)) + " from " +
                html_text(named(r.mechanism, r.channel)) + ": " +
                html_text(r.separating_experiment) + "</p>";
  return rows.empty() ? "" : "<section><h2>What to do next</h2>" + rows + "</section>\n";
}

}  // namespace

std::string findings_page(const Findings& f, const std::vector<Signals>& logs,
                          const std::string& title, const std::vector<NextStep>& next) {
  std::string out = report::page_head(title) + verdict_box(f) + what_next(f, next);
  if (!logs.empty())
    if (const Map map(logs.front()); !map.empty()) out += map.draw(f);
  for (const Finding& x : f.findings) out += found(x);
  out += unexplained_table(f.unexplained);
  if (const std::vector<Seen> list = seen_and_not_named(f); !list.empty()) out += seen_table(list);
  const std::vector<HeldOut>& proof = f.findings.empty() ? f.held_out : f.findings.front().held_out;
  if (!proof.empty()) out += held_out_table(proof, f.remarks);
  if (!f.mismatches.empty()) out += mismatches_table(f.mismatches);
  if (!f.parameters.empty()) out += parameters_table(f.parameters);
  if (!f.evidence.empty()) out += tried(f);
  if (!f.untestable.empty()) out += untestable(f.untestable);
  if (!logs.empty()) out += along_the_road(f, logs.front().length_m);
  return out + "</html>\n";
}

}  // namespace explain
