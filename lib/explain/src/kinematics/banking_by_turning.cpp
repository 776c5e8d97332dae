#include "explain/banking_by_turning.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/statistics.h"
#include "explain/unknowns.h"
#include "leaning_road.h"
#include "selection.h"

namespace explain {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

double tangent_of(double deficit) {
  const double cosine = std::clamp(1 - deficit, 0.1, 1.0);
  return std::sqrt(1 - cosine * cosine) / cosine;
}

/// What the lean takes from the cosine in all, averaged over places by how much the road turns
/// there, and its standard deviation; the lean into the turn that does, and half of its 90 %
/// interval.
struct Mean {
  double deficit = 0.0, sd = 0.0, lean = 0.0, ci90 = 0.0;
};
Mean mean_over(const LeaningRoad& f, const std::vector<Index>& places) {
  VectorXd share = VectorXd::Zero(f.added.size());
  for (const Index k : places) share[k] = std::abs(f.turned.turned_rad[k]);
  share /= std::max(1e-300, share.sum());
  const VectorXd bank = f.turned.bank + f.added;
  const VectorXd cosine = (1 + bank.array().square()).rsqrt();
  const VectorXd by_amount =
      f.moves.transpose() * VectorXd(share.array() * bank.array() * cosine.array().cube());
  Mean m;
  m.deficit = share.dot((1 - cosine.array()).matrix());
  m.sd = std::sqrt(by_amount.dot(f.covariance * by_amount));
  m.lean = tangent_of(m.deficit);
  const double half = selection::k90 * m.sd;
  m.ci90 = std::max(tangent_of(m.deficit + half) - m.lean, m.lean - tangent_of(m.deficit - half));
  return m;
}

/// Half of the interval of a lean whose cosine is known as well as this half says: of a small lean
/// nothing but its square is seen, down to none.
double half_of_lean(double bank, double half) {
  const double lean = std::abs(bank), deficit = 1 - 1 / std::hypot(1, lean);
  const double of_deficit = lean * half / std::pow(std::hypot(1, lean), 3);
  return std::max(
      {half, tangent_of(deficit + of_deficit) - lean, lean - tangent_of(deficit - of_deficit)});
}

/// What is saved of the loss of each half lap, and of that of the gyro's errors, where the road
/// does not lean; and how much that varies between half laps.
struct Saved {
  double all = 0.0, sd = 0.0;
};
Saved saved_against(const LeaningRoad& f, const WithoutLean& other) {
  const VectorXd saved =
      f.weight.cwiseAbs2().cwiseProduct(other.left_rad.cwiseAbs2() - f.left_rad.cwiseAbs2());
  std::vector<double> of_fold(static_cast<std::size_t>(f.windows.folds)), share = of_fold;
  for (Index i = 0; i < saved.size(); ++i) {
    const auto k = static_cast<std::size_t>(f.windows.fold[static_cast<std::size_t>(i)]);
    of_fold[k] += saved[i];
    share[k] += 1 / static_cast<double>(saved.size());
  }
  Saved out{saved.sum(), 0.0};
  for (std::size_t k = 0; k < of_fold.size(); ++k)
    out.sd = std::hypot(out.sd, of_fold[k] - share[k] * out.all);
  out.all += other.unusual - f.unusual;
  return out;
}

/// Half of the way that is turned there leans more, half less: the ends of a turn count little.
double median_over(const LeaningRoad& f, const std::vector<BankingPlace>& places,
                   const std::vector<Index>& in) {
  std::vector<std::pair<double, double>> lean;
  double all = 0.0;
  for (const Index k : in) {
    const double turned = std::abs(f.turned.turned_rad[k]);
    lean.emplace_back(f.side[k] * places[static_cast<std::size_t>(k)].added, turned);
    all += turned;
  }
  std::sort(lean.begin(), lean.end());
  double sum = 0.0;
  for (const auto& [value, turned] : lean)
    if ((sum += turned) >= 0.5 * all) return value;
  return 0.0;
}

/// Where the road leans for sure beyond the file and takes half of the most from the cosine that it
/// does.
std::vector<Index> leaning(const std::vector<BankingPlace>& places,
                           const std::vector<bool>& turns) {
  double most = 0.0;
  for (std::size_t k = 0; k < places.size(); ++k)
    if (turns[k] && std::abs(places[k].added) > places[k].ci90)
      most = std::max(most, std::abs(places[k].added));
  std::vector<Index> out;
  for (std::size_t k = 0; k < places.size(); ++k)
    if (const BankingPlace& p = places[k];
        turns[k] && std::abs(p.added) - p.ci90 > std::max(std::sqrt(0.5) * most, kRoad[0].least))
      out.push_back(static_cast<Index>(k));
  return out;
}

/// An apron or a pit lane beside the line that is usually driven leans otherwise: there no place is
/// known.
std::vector<Turning> on_the_usual_line(std::vector<Turning> logs) {
  constexpr double kPlace_m = 20.0, kBeside_m = 6.0,
                   kDriven_mps = 6.0;  // who stands drives no line
  const auto place = [](double u_m) {
    return std::isfinite(u_m) ? static_cast<int>(std::floor(u_m / kPlace_m)) : -1;
  };
  std::map<int, std::vector<double>> beside;
  for (const Turning& log : logs)
    for (std::size_t i = 0; i < log.u_m.size(); ++i)
      if (std::isfinite(log.u_m[i] + log.v_m[i]) && log.speed_mps[i] > kDriven_mps)
        beside[place(log.u_m[i])].push_back(log.v_m[i]);
  std::map<int, double> usual;
  for (auto& [at, v_m] : beside) usual[at] = base::median(std::move(v_m));
  for (Turning& log : logs)
    for (std::size_t i = 0; i < log.u_m.size(); ++i)
      if (const auto at = usual.find(place(log.u_m[i]));
          std::isfinite(log.u_m[i] + log.v_m[i]) && at != usual.end() &&
          std::abs(log.v_m[i] - at->second) > kBeside_m)
        log.u_m[i] = std::numeric_limits<double>::quiet_NaN();
  return logs;
}

}  // namespace

BankingByTurning banking_by_turning(const std::vector<Turning>& recorded, double length_m,
                                    bool closed) {
  const std::vector<Turning> logs = on_the_usual_line(recorded);
  BankingByTurning out;
  for (const Turning& log : logs) out.by = std::max(out.by, log.by);
  if (out.by == TurningBy::kNone) return out;
  const std::optional<LeaningRoad> road = fit_leaning_road(logs, length_m, closed);
  if (!road) return out;
  const LeaningRoad& f = *road;
  out.windows = static_cast<std::size_t>(f.windows.more_rad.size());
  out.delay_s = f.delay_s;
  out.gain = f.gain;
  out.bias_radps = f.bias_radps;
  out.any_gain = f.with_any_gain.gain;
  const Saved saved = saved_against(f, f.stated);
  out.saved = saved.all;
  out.threshold = std::max(selection::kProfileGain, selection::kSure * saved.sd);
  const Saved beside_gain = saved_against(f, f.with_any_gain);
  out.saved_beside_gain = beside_gain.all;
  out.gain_threshold = std::max(selection::kProfileGain, selection::kProfileSure * beside_gain.sd);
  out.may_be_gain = out.saved_beside_gain < out.gain_threshold &&
                    std::abs(out.any_gain) < selection::kMostGyroGain;

  for (Index k = 0; k < f.added.size(); ++k) {
    const auto move = f.moves.row(k);
    double ci90 = half_of_lean(f.turned.bank[k] + f.added[k],
                               selection::kNarrowerTurning * selection::k90 *
                                   std::sqrt(move.dot(f.covariance * move.transpose())));
    if (!f.turns[static_cast<std::size_t>(k)])  // nothing is seen
      ci90 = std::max(
          {ci90, std::abs(f.turned.bank[k] + f.added[k]), selection::k90 * selection::kLeanUnseen});
    out.places.push_back({static_cast<double>(k) * f.place_m, f.added[k], ci90, f.pivot_v_m[k]});
  }
  const std::vector<Index> in = leaning(out.places, f.turns);
  for (const Index k : in) {
    const double u_m = out.places[static_cast<std::size_t>(k)].u_m;
    const double begin = std::max(0.0, u_m - 0.5 * f.place_m),
                 end = std::min(length_m, u_m + 0.5 * f.place_m);
    if (!out.where_m.empty() && begin - out.where_m.back().second < 4 * f.place_m)
      out.where_m.back().second = end;
    else
      out.where_m.emplace_back(begin, end);
  }
  if (!in.empty()) {
    const Mean m = mean_over(f, in);
    out.lean = median_over(f, out.places, in);
    out.lean_ci90 = m.ci90;
    out.counts = out.saved > out.threshold && out.lean > out.lean_ci90 &&
                 m.deficit - selection::k90 * m.sd > selection::kLeastDeficit;
  }
  std::vector<Index> turning;
  for (Index k = 0; k < f.side.size(); ++k)
    if (f.turns[static_cast<std::size_t>(k)]) turning.push_back(k);
  const Mean m = mean_over(f, turning);
  out.limit =
      tangent_of(m.deficit + selection::kTurningLimit * std::max(m.sd, selection::kUsualGyroGain));
  return out;
}

}  // namespace explain
