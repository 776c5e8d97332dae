#include "explain/judge.h"

#include <algorithm>

namespace explain {
namespace {

bool has_equal(const Finding& f) {
  return std::any_of(f.rivals.begin(), f.rivals.end(), [](const Rival& r) { return !r.separable; });
}

}  // namespace

Verdict judge(const Findings& f) {
  if (f.broken_columns) return Verdict::kNotJudged;
  if (f.doubtful_car) return Verdict::kUnknown;
  if (std::any_of(f.findings.begin(), f.findings.end(), has_equal)) return Verdict::kTie;
  if (!f.unexplained.empty()) return Verdict::kUnknown;
  return f.findings.empty() ? Verdict::kNone : Verdict::kExplained;
}

}  // namespace explain
