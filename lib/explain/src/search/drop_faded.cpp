// What was accepted and did not last, and what left no trace.
#include <algorithm>
#include <cmath>

#include "analysis.h"

namespace explain {

using Eigen::Index;
using Eigen::VectorXd;

bool lasts(const Finding& f) {
  const FoundParameter& amount = f.parameters.front();
  const double more = f.kind == "road" ? 0.5 * (amount.high - amount.low) : 0.0;
  return amount.low - more > 0 || amount.high + more < 0;
}

std::optional<std::size_t> Analysis::faded(const Findings& out) const {
  auto place = static_cast<Index>(refit_.size());
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    if (!has_one_amount(accepted_[k])) continue;
    const Unknown& u = inventory_.unknowns[accepted_[k].unknown];
    const double amount = amounts_[place++];
    if (std::abs(amount) < u.least || std::abs(amount) > u.most || (u.one_sided && amount < 0))
      return k;
  }
  Findings described = out;
  describe(described);
  for (std::size_t k = 0; k < accepted_.size(); ++k)
    if (!lasts(described.findings[k])) return k;
  return std::nullopt;
}

void Analysis::drop(std::size_t k, Findings& out) {
  const auto at = static_cast<std::ptrdiff_t>(k);
  if (has_one_amount(accepted_[k])) {
    // amounts_ and moves_ have those that act everywhere, in the order of accepted_.
    const Index place = static_cast<Index>(refit_.size()) +
                        std::count_if(accepted_.begin(), accepted_.begin() + at,
                                      [](const Accepted& a) { return has_one_amount(a); });
    const Index behind = moves_.cols() - place - 1;
    moves_.middleCols(place, behind) = moves_.rightCols(behind).eval();
    moves_.conservativeResize(moves_.rows(), moves_.cols() - 1);
    amounts_.segment(place, behind) = amounts_.tail(behind).eval();
    amounts_.conservativeResize(amounts_.size() - 1);
  }
  out.findings.erase(out.findings.begin() + at);
  accepted_.erase(accepted_.begin() + at);
}

void Analysis::drop_faded(Findings& out) {
  while (const std::optional<std::size_t> k = faded(out)) {
    drop(*k, out);
    refit(2);  // the others move
  }
}

void Analysis::list_untouched(Findings& out) const {
  for (std::size_t k = 0; k < candidate_.size(); ++k) {
    const Unknown& u = inventory_.unknowns[candidate_[k]];
    const auto same = [&](const Evidence& e) { return is_of(e, u) && e.detail == u.name; };
    if (settled(u) || std::any_of(out.evidence.begin(), out.evidence.end(), same)) continue;
    // Tested where these recordings could have shown it, else named.
    const VectorXd column = weight_.cwiseProduct(candidate_moves_.col(static_cast<Index>(k)));
    if (!(column.squaredNorm() > 0))
      out.untestable.push_back(
          {u.id, "it would change nothing in these recordings with the stated car"});
    else if ((u.kind == "vehicle" || u.kind == "environment") && !apart_from_curves(candidate_[k]))
      out.untestable.push_back(
          {u.id, "in these recordings the uncertain curves of the stated car can take its place"});
    else
      out.evidence.push_back({u.id, u.channel, u.name, 0.0, 0.0, 0.0, u.unit});
  }
}

void Analysis::list_untestable(Findings& out) const {
  // What was held for want of evidence and found nevertheless was tested after all.
  const auto found = [&](const Untestable& u) {
    return std::any_of(out.findings.begin(), out.findings.end(), [&](const Finding& f) {
      return (f.kind == "parameter" || f.kind == "road") && is_about(f, u.mechanism);
    });
  };
  std::vector<Untestable> first;
  for (const Untestable& u : inventory_.untestable)
    if (!found(u)) first.push_back(u);
  out.untestable.insert(out.untestable.begin(), first.begin(), first.end());
}

}  // namespace explain
