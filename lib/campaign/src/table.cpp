#include <fmt/format.h>

#include <cmath>

#include "campaign/results.h"

namespace campaign {
namespace {

std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string row(const Job& job, const Fact& fact) {
  return fmt::format("{},{},{},{},{},{},{},{}\n", cell(job.id), cell(job.kind), cell(job.subject),
                     word_of(job.state), cell(fact.name),
                     std::isfinite(fact.value) ? fmt::format("{}", fact.value) : "",
                     cell(fact.unit), cell(fact.text));
}

}  // namespace

std::string table_of(const Campaign& campaign) {
  std::string table = "job,kind,subject,state,fact,value,unit,text\n";
  for (const Job& job : campaign.jobs) {
    for (const Fact& fact : job.facts) table += row(job, fact);
    if (!job.message.empty() || job.facts.empty())
      table += row(job, {.name = "message", .unit = "", .text = job.message});
  }
  return table;
}

}  // namespace campaign
