// What is judged by the loss that it saves where errors of the stated curves count as what they
// are, few independent measurements: parameters that are far off, and mechanisms of car and air
// that such curves can nearly take the place of. Many rows alone would let the curves win.
#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis.h"
#include "selection.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double Analysis::width(std::size_t place) const {
  // The file's width is where two standard deviations end; what the simulated car gets wrong adds
  // to it.
  const Unknown& u = inventory_.unknowns[refit_[place]];
  const bool freed =
      std::any_of(freed_.begin(), freed_.end(), [&](const Freed& f) { return f.place == place; });
  return freed        ? selection::kFreed * u.width
         : u.held > 0 ? u.held
                      : std::hypot(0.5 * u.width, u.form);
}

double Analysis::limit(const Unknown& u) { return std::max(8 * u.width, 0.5 * std::abs(u.stated)); }

Analysis::Freed Analysis::best_parameter(const Model& m) const {
  // A normal prior would share one large error among all parameters that can take a part of it. Few
  // parameters are far off: the one whose freedom saves most prior cost goes first.
  const MatrixXd gram = m.fitted.x.transpose() * m.fitted.x;
  const VectorXd right = m.fitted.x.transpose() * m.fitted.r;
  VectorXd before = VectorXd::Zero(gram.rows());
  const auto p = static_cast<Index>(refit_.size());
  before.head(p) = amounts_.head(p);
  const auto loss = [&](const VectorXd& precision) {
    MatrixXd a = gram;
    a.diagonal() += precision;
    steady(a);
    const VectorXd b = right - precision.cwiseProduct(before), move = a.ldlt().solve(b);
    return move.dot(gram * move) - 2 * move.dot(right) + precision.dot((before + move).cwiseAbs2());
  };
  const double held = loss(m.precision);
  std::vector<std::pair<double, std::size_t>> saved;
  for (std::size_t k = 0; k < refit_.size(); ++k) {
    const Unknown& u = inventory_.unknowns[refit_[k]];
    if (u.role != Role::kParameter || u.assumed || u.stays_held || undetermined_.count(k) > 0)
      continue;
    if (std::any_of(freed_.begin(), freed_.end(), [&](const Freed& f) { return f.place == k; }))
      continue;
    VectorXd precision = m.precision;
    const double free = selection::kFreed * u.width;
    precision[static_cast<Index>(k)] = 1.0 / (free * free);
    const double save = held - loss(precision) - (u.held > 0 ? selection::kHeldGo : 0.0);
    if (save > selection::kLetGo) saved.emplace_back(save, k);
  }
  std::stable_sort(saved.begin(), saved.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  Freed f;
  if (saved.empty()) return f;
  f.saved = saved.front().first;
  f.place = saved.front().second;
  for (std::size_t k = 1;
       k < saved.size() && saved[k].first > saved.front().first - selection::kLead; ++k)
    f.rivals.push_back(saved[k].second);
  return f;
}

Saved Analysis::saved_by(const Model& m, VectorXd column) {
  const VectorXd shared = m.fitted.x.transpose() * column;
  const double left = column.squaredNorm() - shared.dot(m.fitted.normal.solve(shared)),
               product = column.dot(m.fitted.e);
  if (!(left > 1e-12)) return {};
  return {product / left, product * product / left, std::move(column)};
}

std::vector<Saved> Analysis::exact(const std::vector<Start>& from, const Model& m,
                                   const VectorXd& weights, Stage stage) const {
  const Setting base = setting_with(amounts_);
  std::vector<Saved> best(from.size());
  std::vector<double> amount(from.size());
  std::vector<std::size_t> left;
  for (std::size_t k = 0; k < from.size(); ++k) amount[k] = from[k].amount, left.push_back(k);
  // All in the same round, so that their cars are led together.
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Setting> moved;
    std::erase_if(left, [&](std::size_t k) {
      const Unknown& u = inventory_.unknowns[from[k].unknown];
      if (u.one_sided) amount[k] = std::max(amount[k], 0.0);
      if (std::abs(amount[k]) < 1e-12) return true;
      u.set(moved.emplace_back(base), amount[k]);
      return false;
    });
    const auto tell = [&](double share) {
      progress("tests of mechanisms", (round + share) / kRounds);
    };
    std::vector<VectorXd> rows;
    if (stage == Stage::kForces)
      rows = rows_at(moved, tell);
    else
      for (const Setting& setting : moved) rows.push_back(rows_without_drive(setting)), tell(0.0);
    std::vector<std::size_t> on;
    for (std::size_t n = 0; n < left.size(); ++n) {
      const std::size_t k = left[n];
      Saved s = saved_by(m, weights.cwiseProduct(r_ - rows[n]) / amount[k]);
      if (s.gain == 0) continue;
      // Away from the best place of the secant the gain is that of the parabola.
      const double scale = s.amount / amount[k],
                   gain = s.gain * (1 - (1 - 1 / scale) * (1 - 1 / scale));
      if (gain > best[k].gain) best[k] = {amount[k], gain, std::move(s.column)};
      if (std::abs(scale - 1.0) < 0.02) continue;
      // Who asks takes none that is too small or too large.
      const Unknown& u = inventory_.unknowns[from[k].unknown];
      const double size = std::abs(amount[k]);
      if ((scale > 1.0 && size > u.most) || (scale < 1.0 && size < u.least)) continue;
      amount[k] *= std::clamp(scale, 0.4, 2.5);
      on.push_back(k);
    }
    left = std::move(on);
  }
  return best;
}

std::vector<Family> Analysis::families_by_cost() const {
  std::vector<Family> out;
  for (const std::size_t candidate : candidate_) {
    const Unknown& u = inventory_.unknowns[candidate];
    if ((u.kind != "vehicle" && u.kind != "environment") || used(u)) continue;
    Family f;
    f.id = candidate;
    f.column = careful_column(candidate);
    f.sign = u.one_sided ? 1 : 0;
    f.least_left = selection::kLeastLeft;
    out.push_back(std::move(f));
  }
  return out;
}

VectorXd Analysis::careful_column(std::size_t unknown, Stage stage) const {
  const auto k = std::find(candidate_.begin(), candidate_.end(), unknown) - candidate_.begin();
  return careful_weights(stage).cwiseProduct(candidate_moves_.col(k));
}

Analysis::Stretch Analysis::best_stretch(const Model& m) const {
  std::vector<Family> along;
  for (Family& f : candidates(Stage::kForces)) {
    if (f.cell.empty() || used(inventory_.unknowns[f.id])) continue;
    f.column = careful_column(f.id);
    along.push_back(std::move(f));
  }
  Stretch best;
  for (const Test& t : scan(m.fitted, along, rows_, 0, m.fitted.e).best)
    if (const Unknown& u = inventory_.unknowns[along[t.family].id];
        std::abs(t.amount) > u.least && std::abs(t.amount) < u.most && t.gain > best.gain)
      best = {along[t.family].id, t.gain,
              within(along[t.family].column, along[t.family].cell, t.begin, t.end)};
  return best;
}

bool Analysis::is_kept_back(const Model& m, const Freed& f) const {
  const Stretch stretch = best_stretch(m);
  if (!(stretch.gain > f.saved)) return false;
  Model with = m;
  Fitted& fitted = with.fitted;
  const Index all = fitted.x.cols();
  fitted.x.conservativeResize(Eigen::NoChange, all + 1);
  fitted.x.col(all) = stretch.column;
  with.precision.conservativeResize(all + 1);
  with.precision[all] = 0.0;
  const Freed then = best_parameter(with);
  return then.place != f.place || then.saved < selection::kStillSaves * f.saved;
}

bool Analysis::stands_out(const Trial& trial, const Tried& stretch) const {
  const Family& along = trial.families[stretch.family];
  const Test& t = stretch.test;
  const double saved =
      saved_by(careful_model(trial.stage),
               within(careful_column(along.id, trial.stage), along.cell, t.begin, t.end))
          .gain;
  return saved >
         (std::abs(t.local_z) < trial.scan.threshold ? selection::kPlaced : selection::kNamed);
}

bool Analysis::apart_from_curves(std::size_t unknown) const {
  const Model m = careful_model();
  const VectorXd c = careful_column(unknown), shared = m.fitted.x.transpose() * c;
  return c.squaredNorm() - shared.dot(m.fitted.normal.solve(shared)) >
         selection::kLeastLeft * c.squaredNorm();
}

double Analysis::alarms_by_cost() const {
  const Model m = careful_model();
  const std::vector<Family> families = families_by_cost();
  if (families.empty()) return 0.0;
  const Scan s = scan(m.fitted, families, rows_, options_.nulls,
                      without_what_stands_out(m.fitted, families, rows_));
  const auto over = s.null_max.end() - std::upper_bound(s.null_max.begin(), s.null_max.end(),
                                                        std::sqrt(selection::kNamed));
  return static_cast<double>(over) /
         static_cast<double>(std::max<std::size_t>(1, s.null_max.size()));
}

std::vector<Analysis::Weighed> Analysis::mechanisms_by_cost(const Model& m) const {
  const std::vector<Family> families = families_by_cost();
  const VectorXd w = careful_weights();
  std::vector<Test> best = scan(m.fitted, families, rows_, 0, m.fitted.e).best;
  std::erase_if(best, [](const Test& t) { return t.gain < 0.5 * selection::kNamed; });
  std::vector<Start> from;
  from.reserve(best.size());
  for (const Test& t : best) from.push_back({families[t.family].id, t.amount});
  std::vector<Saved> saved = exact(from, m, w, Stage::kForces);
  std::vector<Weighed> out;
  for (std::size_t k = 0; k < from.size(); ++k)
    out.push_back({from[k].unknown, std::move(saved[k])});
  std::erase_if(out, [&](const Weighed& x) {
    const Unknown& u = inventory_.unknowns[x.unknown];
    return std::abs(x.saved.amount) < u.least || std::abs(x.saved.amount) > u.most;
  });
  std::stable_sort(out.begin(), out.end(),
                   [](const Weighed& a, const Weighed& b) { return a.saved.gain > b.saved.gain; });
  return out;
}

void Analysis::free_parameters() {
  for (int round = 0; round < 2; ++round) {
    const Model m = careful_model();
    const Freed f = best_parameter(m);
    if (f.saved == 0) return;
    const std::vector<Weighed> rivals = mechanisms_by_cost(m);
    if (!rivals.empty() && rivals.front().saved.gain > f.saved) return;
    // A stretch of road that says as much is looked at first: tyres that let go everywhere would
    // hide it. What is off all the same beside it makes up such stretches.
    if (is_kept_back(m, f)) return;
    let_go(f);
  }
}

void Analysis::let_go(const Freed& f) {
  freed_.push_back(f);
  refit(2);
  // Far from what is stated its derivative may be another: a pedal past its end opens no further.
  moves_.col(static_cast<Index>(f.place)) =
      columns_of({&inventory_.unknowns[refit_[f.place]]}, "refit of the parameters");
  refit(2);
  // What was held for want of evidence and runs to its limit takes the blame for something else.
  const Unknown& u = inventory_.unknowns[refit_[f.place]];
  if (u.held == 0 ||
      std::abs(amounts_[static_cast<Index>(f.place)]) < selection::kAtLimit * limit(u))
    return;
  freed_.pop_back();
  undetermined_.insert(f.place);
  amounts_[static_cast<Index>(f.place)] = 0.0;
  refit(4);
}

bool Analysis::add_by_cost(Findings& out) {
  const Model m = careful_model();
  const Freed f = best_parameter(m);
  const std::vector<Weighed> rivals = mechanisms_by_cost(m);
  const double best = rivals.empty() ? 0.0 : rivals.front().saved.gain;
  if (f.saved >= best && f.saved > 0) {
    if (is_kept_back(m, f)) return false;  // as above
    let_go(f);
    return true;
  }
  if (best < selection::kNamed) return false;
  const Weighed& x = rivals.front();
  const Unknown& u = inventory_.unknowns[x.unknown];
  Finding found = finding_of(x.unknown);
  found.statistic = std::copysign(std::sqrt(best), x.saved.amount);
  found.threshold = std::sqrt(selection::kNamed);
  for (const double gain :
       cross_validate(m.fitted, x.saved.column, m.precision, VectorXd::Zero(1), rows_))
    found.cv_gain += gain;
  found.stability = stability(m.fitted, x.saved.column, x.saved.amount);
  if (!(found.cv_gain > 0) || found.stability < selection::kStable) return false;
  for (std::size_t k = 1; k < rivals.size(); ++k) {
    const Unknown& o = inventory_.unknowns[rivals[k].unknown];
    if (o.id == u.id || is_rival(found, o.id)) continue;
    found.rivals.push_back({o.id, o.channel, experiment_between(u, o), 0.0,
                            best - rivals[k].saved.gain > selection::kAsGood});
  }
  // The table of what was tested says what counted.
  std::erase_if(out.evidence, [&](const Evidence& e) { return is_of(e, u) && e.detail == u.name; });
  out.evidence.push_back({u.id,
                          u.channel,
                          u.name,
                          x.saved.amount,
                          found.statistic,
                          found.cv_gain,
                          u.unit,
                          {},
                          u.least});
  Accepted a;
  a.unknown = x.unknown;
  a.amount = x.saved.amount;
  a.by_cost = true;
  accept(out, std::move(found), std::move(a));
  return true;
}

void Analysis::free_what_was_kept_back() {
  for (int round = 0; round < 2; ++round) {
    const Model m = careful_model();
    Freed f = best_parameter(m);
    if (f.saved == 0) return;
    const std::vector<Weighed> rivals = mechanisms_by_cost(m);
    const Stretch stretch = best_stretch(m);
    if (stretch.gain > f.saved)
      f.instead = stretch.unknown;
    else if (!rivals.empty() && rivals.front().saved.gain > f.saved)
      f.instead = rivals.front().unknown;
    let_go(f);
  }
}

void Analysis::name_by_cost(Findings& out) {
  out.null_false_alarm += alarms_by_cost();
  for (int k = 0; k < selection::kMostFindings && add_by_cost(out); ++k) {
  }
}

}  // namespace explain
