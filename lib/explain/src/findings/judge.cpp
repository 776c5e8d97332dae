#include "explain/judge.h"

#include <algorithm>

namespace explain {
namespace {

bool has_equal(const Finding& f) {
  return std::any_of(f.rivals.begin(), f.rivals.end(), [](const Rival& r) { return !r.separable; });
}

/// Off by more than anybody would state, and named by no finding.
bool is_off_unnamed(const Findings& f, const ParameterValue& p) {
  const auto names_it = [&](const FoundParameter& found) { return found.name == p.name; };
  return (p.beyond_prior || p.at_limit || p.unsure) &&
         std::none_of(f.findings.begin(), f.findings.end(), [&](const Finding& x) {
           return is_about(x, p.id) &&
                  std::any_of(x.parameters.begin(), x.parameters.end(), names_it);
         });
}

}  // namespace

Verdict judge(const Findings& f) {
  if (f.broken_columns) return Verdict::kNotJudged;
  if (f.doubtful_car) return Verdict::kUnknown;
  if (std::any_of(f.findings.begin(), f.findings.end(), has_equal)) return Verdict::kTie;
  const auto off = [&](const ParameterValue& p) { return is_off_unnamed(f, p); };
  if (!f.unexplained.empty() || std::any_of(f.parameters.begin(), f.parameters.end(), off))
    return Verdict::kUnknown;
  return f.findings.empty() ? Verdict::kNone : Verdict::kExplained;
}

}  // namespace explain
