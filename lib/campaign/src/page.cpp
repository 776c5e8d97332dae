#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "campaign/results.h"
#include "facts.h"
#include "report/plot_page.h"

namespace campaign {
namespace {

using report::html_text;

/// A path as the target of a link: every byte that means something to a browser is escaped.
std::string link_of(const std::string& path) {
  std::string link;
  for (const char c : path) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '/' || c == '.' || c == '_' || c == '-';
    if (plain)
      link += c;
    else
      link += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return "./" + link;
}

std::string subject_of(const Job& job) {
  const std::string words = html_text(job.subject);
  return job.page.empty() ? words : fmt::format("<a href='{}'>{}</a>", link_of(job.page), words);
}

std::string number(double value) { return fmt::format("{:.6g}", value); }

std::string value_of(const Job& job, const Fact& fact) {
  if (!std::isfinite(fact.value)) return html_text(fact.text);
  const double seen = fact.value * shown(job.kind, fact).factor;
  return number(fact.name == "length" ? std::round(seen * 10.0) / 10.0
                                      : std::strtod(fmt::format("{:.4g}", seen).c_str(), nullptr));
}

/// The facts that any job of a kind has, in the order of the first that has them.
std::vector<Fact> columns_of(const std::vector<const Job*>& jobs) {
  std::vector<Fact> columns;
  for (const Job* job : jobs)
    for (const Fact& fact : job->facts)
      if (std::none_of(columns.begin(), columns.end(),
                       [&](const Fact& known) { return known.name == fact.name; }))
        columns.push_back(fact);
  return columns;
}

std::string section(const std::string& kind, const std::vector<const Job*>& jobs) {
  const std::vector<Fact> columns = columns_of(jobs);
  std::string html = "<section><h2>" + html_text(kind) + "</h2><table><tr><th>name<th>state";
  for (const Fact& column : columns) {
    const std::string unit = shown(kind, column).unit;
    html += "<th>" + html_text(column.name) +
            (unit.empty() ? "" : " <small>" + html_text(unit) + "</small>");
  }
  html += "\n";
  for (const Job* job : jobs) {
    html += "<tr><td>" + subject_of(*job) + "<td>" + word_of(job->state);
    for (const Fact& column : columns) {
      const auto fact = std::find_if(job->facts.begin(), job->facts.end(),
                                     [&](const Fact& one) { return one.name == column.name; });
      html += "<td>" + (fact == job->facts.end() ? "" : value_of(*job, *fact));
    }
    html += "\n";
  }
  return html + "</table></section>\n";
}

/// What is not done and why: first on the page.
std::string troubles(const Campaign& campaign) {
  std::string rows;
  for (const Job& job : campaign.jobs)
    if (job.state != State::done)
      rows += "<tr><td>" + html_text(job.kind) + "<td>" + subject_of(job) + "<td>" +
              word_of(job.state) + "<td>" + html_text(job.message) + "\n";
  if (rows.empty()) return "";
  return "<section><h2>Not done</h2><table><tr><th>job<th>name<th>state<th>message\n" + rows +
         "</table></section>\n";
}

}  // namespace

std::string page_of(const Campaign& campaign) {
  std::map<State, std::size_t> states;
  std::vector<std::string> kinds;
  std::map<std::string, std::vector<const Job*>> jobs;
  for (const Job& job : campaign.jobs) {
    ++states[job.state];
    if (jobs[job.kind].empty()) kinds.push_back(job.kind);
    jobs[job.kind].push_back(&job);
  }
  std::string html = report::page_head(campaign.name), counts;
  for (const auto& [state, count] : states)
    counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, word_of(state));
  html += fmt::format(
      "<p>{} jobs: {}. The same numbers in SI units: <a href='./campaign.csv'>"
      "campaign.csv</a>, <a href='./campaign.sqlite'>campaign.sqlite</a>.</p>\n",
      campaign.jobs.size(), counts.empty() ? "none" : counts);
  html += troubles(campaign);
  for (const std::string& kind : kinds) html += section(kind, jobs[kind]);
  return html + "</html>\n";
}

}  // namespace campaign
