#include "explain/columns.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace explain {

void name_late_columns(const Signals& log, Findings& findings) {
  std::vector<std::string> columns = log.late.columns;
  if (columns.empty()) return;
  // The analysis had these columns already moved.
  for (Finding& f : findings.findings) {
    const auto at = std::find(columns.begin(), columns.end(), f.channel);
    if (f.mechanism != kSensorDelay || at == columns.end()) continue;
    columns.erase(at);
    for (FoundParameter& p : f.parameters)
      p.value += log.late.delay_s, p.low += log.late.delay_s, p.high += log.late.delay_s;
  }
  if (columns.empty()) return;
  Finding f;
  f.mechanism = kSensorDelay;
  f.kind = "sensor";
  f.channel = fmt::format("{}", fmt::join(columns, ","));
  f.physics = "these columns come late together: their device has a clock of its own";
  f.equation = "logged(t) = true(t - delay)";
  // By how well the shift is known: what nothing-missing recordings of another simulator show.
  constexpr double kHalf_s = 0.01;
  f.parameters = {
      {"delay", "s", log.late.delay_s, log.late.delay_s - kHalf_s, log.late.delay_s + kHalf_s}};
  findings.findings.insert(findings.findings.begin(), f);
}

void hold_back_beside_broken_columns(Findings& findings) {
  if (!findings.broken_columns) return;
  for (Finding& f : findings.findings)
    if (f.kind != "sensor" && f.not_used.empty()) f.not_used = "a column is broken: mend it first";
}

}  // namespace explain
