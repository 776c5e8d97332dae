// The page of crgexplain fleet.
#include <fmt/format.h>

#include "explain/fleet.h"
#include "report/plot_page.h"

namespace explain {
namespace {

using report::html_text;

constexpr std::size_t kMostRows = 500;  ///< of a table

std::string cell(const std::string& text) { return "<td>" + html_text(text); }
std::string number_cell(double value) { return fmt::format("<td class=n>{:.4g}", value); }

std::string table(const std::string& title, const std::string& words, const std::string& head,
                  const std::vector<std::string>& rows) {
  std::string out = "<section class=long><h2>" + title + "</h2>";
  if (!words.empty()) out += "<p><small>" + words + "</small></p>";
  out += "<table><thead><tr>" + head + "</thead><tbody>";
  for (std::size_t k = 0; k < std::min(rows.size(), kMostRows); ++k) out += rows[k];
  out += "</tbody></table>";
  if (rows.size() > kMostRows)
    out += fmt::format("<p><small>{} more are in fleet.json.</small></p>", rows.size() - kMostRows);
  return out + "</section>\n";
}

std::string verdict(const FleetFindings& all) {
  const char *colour = "good", *meaning = "Nothing is missing that these drives can show.";
  if (all.verdict == FleetVerdict::kDivided)
    meaning = "All that counts was found, and whether it is the road's, a car's or a sensor's.";
  if (all.verdict == FleetVerdict::kCannotTell)
    colour = "warn", meaning = "These drives do not say what is wrong, or whose it is.";
  std::size_t laps = 0;
  for (const FleetCar& car : all.cars) laps += car.laps;
  std::string out = fmt::format(
      "<section class='verdict {}'><strong>{}</strong>{}<p>{} drives of {} cars, {} laps; {} "
      "mechanisms of cars tested.</p>",
      colour, name_of(all.verdict), meaning, all.drives, all.cars.size(), laps, all.tested);
  for (const std::string& remark : all.remarks)
    out += "<p><small>" + html_text(remark) + "</small></p>";
  return out + "</section>\n";
}

std::string joined(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : ", ") + word;
  return out;
}

std::string places(const std::vector<Place>& where) {
  std::string out;
  for (const Place& w : where)
    out += fmt::format("{}{:.0f} to {:.0f} m", out.empty() ? "u " : ", ", w.u_begin_m, w.u_end_m);
  return out;
}

std::string findings(const FleetFindings& all) {
  if (all.findings.empty()) return "";
  std::vector<std::string> rows;
  for (const FleetFinding& f : all.findings)
    rows.push_back("<tr>" + cell(f.belongs_to) + cell(f.owner) +
                   cell(f.mechanism + (f.channel.empty() ? "" : " in " + f.channel)) +
                   cell(f.name) + number_cell(f.amount) + number_cell(f.low) + number_cell(f.high) +
                   cell(f.unit == "1" ? "" : f.unit) + number_cell(f.gain) +
                   number_cell(f.threshold) + cell(places(f.where)) + cell(joined(f.rivals)));
  return table("Found, and whose it is",
               "The interval holds 90 %. Gain: loss that it saves; of the road on cars left out.",
               "<th>of<th>owner<th>what<th>amount<th>value<th>from<th>to<th>unit<th>gain<th>needed"
               "<th>where<th>cannot be told from",
               rows);
}

std::string profiles(const FleetFindings& all) {
  std::string out;
  for (const FleetFinding& f : all.findings) {
    if (f.profile.empty()) continue;
    report::PlotLine value{"the road", {}, {}}, low{"90 % from", {}, {}}, high{"to", {}, {}};
    for (const ProfilePoint& p : f.profile) {
      for (report::PlotLine* line : {&value, &low, &high}) line->x.push_back(p.u_m);
      value.y.push_back(p.value);
      low.y.push_back(p.value - p.ci90);
      high.y.push_back(p.value + p.ci90);
    }
    report::Plot plot{
        f.mechanism + " along the lap", "u, m", f.name + ", " + f.unit, {value, low, high}};
    for (const Place& w : f.where) plot.bands.push_back({w.u_begin_m, w.u_end_m});
    out += report::plot_section(plot);
  }
  return out;
}

std::string undivided(const FleetFindings& all) {
  if (all.undivided.empty()) return "";
  std::vector<std::string> rows;
  for (const Undivided& u : all.undivided)
    rows.push_back("<tr>" + cell(u.owner) + cell(u.what) + cell(u.between) + number_cell(u.gain) +
                   cell(u.separating));
  return table("Seen, and not divided", "", "<th>car<th>what<th>between<th>gain<th>what would tell",
               rows);
}

std::string cars(const FleetFindings& all) {
  std::vector<std::string> rows;
  for (const FleetCar& car : all.cars)
    rows.push_back("<tr>" + cell(car.name) + number_cell(static_cast<double>(car.drives)) +
                   number_cell(static_cast<double>(car.laps)) + number_cell(car.driven_s) +
                   cell(car.sha256.substr(0, 10)));
  return table("Cars", "", "<th>car<th>drives<th>laps<th>driven, s<th>file", rows);
}

std::string parameters(const FleetFindings& all) {
  std::vector<std::string> rows;
  for (const FleetCar& car : all.cars)
    for (const ParameterValue& p : car.parameters)
      rows.push_back("<tr>" + cell(car.name) + cell(p.name) + number_cell(p.stated) +
                     number_cell(p.value) + number_cell(p.low) + number_cell(p.high) +
                     cell(p.unit == "1" ? "" : p.unit) + cell(p.beyond_prior ? "found" : ""));
  if (rows.empty()) return "";
  return table("Parameters",
               "Refitted with the widths that vehicle.yaml states; the interval holds 90 %.",
               "<th>car<th>parameter<th>stated<th>refitted<th>from<th>to<th>unit<th>", rows);
}

}  // namespace

std::string fleet_page(const FleetFindings& all, const std::string& title) {
  return report::page_head(title) + verdict(all) + findings(all) + profiles(all) + undivided(all) +
         cars(all) + parameters(all) + "</html>\n";
}

}  // namespace explain
