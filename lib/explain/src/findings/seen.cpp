// What stands out of the noise and is not named: "none" does not mean that nothing was seen.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "explain/findings.h"
#include "selection.h"

namespace explain {
namespace {

/// Found itself, or said beside something found.
bool is_named(const Findings& f, const Evidence& e) {
  return std::any_of(f.findings.begin(), f.findings.end(), [&](const Finding& x) {
    const auto same = [&](const auto& item) {
      return is_about(item, e.mechanism) && item.channel == e.channel;
    };
    return same(x) || std::any_of(x.rivals.begin(), x.rivals.end(), same);
  });
}

std::string why_not(const Findings& f, const Evidence& e) {
  if (f.doubtful_car && !e.mechanism.starts_with("sensor.") && !e.mechanism.starts_with("road."))
    return "the vehicle file may be that of another car";
  if (std::abs(e.amount) < e.least)
    return fmt::format("less than {:.3g}{}{}, which is what counts", e.least,
                       e.unit == "1" ? "" : " ", e.unit == "1" ? "" : e.unit);
  if (std::abs(e.statistic) < f.threshold)
    return fmt::format(
        "score {:.1f} where {:.1f} is needed: the best of all that is tried reaches "
        "as much without any effect",
        std::abs(e.statistic), f.threshold);
  if (!(e.cv_gain > 0)) return "does not help on laps left out";
  return f.findings.empty() ? "not the same everywhere, or more than it can be"
                            : "what was found explains it, or it is not the same everywhere";
}

}  // namespace

std::vector<Seen> seen_and_not_named(const Findings& f) {
  std::vector<Seen> out;
  for (const Evidence& e : f.evidence) {
    const double score = std::abs(e.statistic);
    if (!(score >= (e.place.empty() ? selection::kSeen : f.threshold)) || is_named(f, e)) continue;
    const double half = std::abs(e.amount) * selection::k90 / score;
    out.push_back({e.mechanism, e.channel, e.detail + e.place, e.unit, why_not(f, e), e.amount,
                   e.amount - half, e.amount + half, e.statistic});
  }
  std::stable_sort(out.begin(), out.end(), [](const Seen& a, const Seen& b) {
    return std::abs(a.statistic) > std::abs(b.statistic);
  });
  return out;
}

}  // namespace explain
