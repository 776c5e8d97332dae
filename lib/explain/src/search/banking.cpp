// Banking that only the turning of the cars shows: found first, kept as it was found.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "analysis.h"
#include "explain/banking_by_turning.h"
#include "explain/gyro_or_banking.h"

namespace explain {
namespace {

double degrees_of(double slope) { return std::atan(slope) * 180 / std::numbers::pi; }

/// What leaves the height of the line about which it leans as it was stated, at every place.
std::vector<double> kept_heights(const BankingByTurning& b) {
  std::vector<double> out;
  for (const BankingPlace& p : b.places) out.push_back(-p.added * p.pivot_v_m);
  return out;
}

/// The derivative along the road of heights at places that are equally far apart.
std::vector<double> derivative_of(const std::vector<double>& z_m, double place_m, bool closed) {
  const std::size_t n = z_m.size();
  std::vector<double> out(n, 0.0);
  for (std::size_t k = 0; k < n; ++k) {
    if (!closed && (k == 0 || k + 1 == n)) continue;
    out[k] = (z_m[(k + 1) % n] - z_m[(k + n - 1) % n]) / (2 * place_m);
  }
  return out;
}

Finding banking_finding(const BankingByTurning& b, const std::string& yaw_rate) {
  const RoadKind& kind = kRoad[0];
  Finding f;
  call_banking(f);
  f.cv_gain = b.saved;
  f.threshold = std::sqrt(b.threshold);
  f.statistic = std::sqrt(b.saved);
  double sum = 0.0;
  for (const BankingPlace& p : b.places) {
    f.profile.push_back({p.u_m, p.added, p.ci90});
    sum += p.added;
  }
  f.patch = {b.places[1].u_m, 0.0, 0.0, 1, kept_heights(b)};
  for (const auto& [begin, end] : b.where_m) f.where.push_back({begin, end, {}});
  // To the side to which most of the road leans.
  const double lean = std::copysign(b.lean, sum);
  f.parameters.push_back({std::string(kind.name) + ", in the turns", kind.unit, lean,
                          lean - b.lean_ci90, lean + b.lean_ci90});
  if (b.may_be_gain) add_gain_as_equal(f, yaw_rate, b.any_gain, b.saved - b.saved_beside_gain);
  return f;
}

}  // namespace

bool Analysis::settled(const Unknown& u) const {
  // Without forces and without a lateral acceleration only turning tells it, in windows.
  if (!by_turning_) return judged_by_turning_ && !options_.forces && u.id == kRoad[0].id;
  return u.kind == "road" || (u.id == kSensorGain && u.channel == logs_.front().column[kYawRate]);
}

void Analysis::find_banking_by_turning(Findings& out) {
  const Signals& first = logs_.front();
  if (first.present[kAy] && first.present[kVy]) return;
  std::vector<Turning> turnings;
  for (const Signals& s : logs_) turnings.push_back(turning_of(s));
  const BankingByTurning b = banking_by_turning(turnings, first.length_m, first.closed);
  judged_by_turning_ = !b.places.empty();
  if (!judged_by_turning_) return;
  if (!b.counts) {
    out.remarks.push_back(fmt::format(
        "by {} the road leans by at most {:.0f} degrees more than the file where it turns, if the "
        "gain of the yaw rate is right",
        name_of(b.by), std::ceil(degrees_of(b.limit))));
    return;
  }
  by_turning_ = banking_finding(b, first.column[kYawRate]);
  for (const BankingPlace& p : b.places) turning_road_.bank.push_back(p.added);
  turning_road_.grade = derivative_of(kept_heights(b), b.places[1].u_m, first.closed);
  out.remarks.push_back(fmt::format(
      "banking was told by {} in {} windows of 1 s: {:.1f} to {:.1f} degrees more than the file in "
      "the turns. Its side is that to which they turn; where the road does not turn nothing tells "
      "it",
      name_of(b.by), b.windows, degrees_of(b.lean - b.lean_ci90),
      degrees_of(b.lean + b.lean_ci90)));
}

void Analysis::tell_banking_by_turning(Findings& out) const {
  if (!by_turning_) return;
  out.findings.insert(out.findings.begin(), *by_turning_);
  std::string last;
  for (const std::size_t k : candidate_) {
    const Unknown& u = inventory_.unknowns[k];
    if (!settled(u) || u.id == last || is_about(*by_turning_, u.id)) continue;
    last = u.id;
    out.untestable.push_back(
        {u.id, u.kind == "road" ? "banking was told by turning alone, which leaves the height that "
                                  "was driven open"
                                : "of the yaw rate: beside a banking that only it tells, its gain "
                                  "is taken to be within 0.35 %"});
  }
}

}  // namespace explain
