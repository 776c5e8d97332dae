// What is judged by its score against null replicates: sensors and road first, then everything.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "analysis.h"
#include "base/parallel.h"
#include "base/random.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A sum over folds and its standard error.
struct Total {
  double sum = 0.0, error = 0.0;
};

Total total(const std::vector<double>& g) {
  double sum = 0, square = 0;
  for (const double x : g) sum += x;
  const double mean = sum / static_cast<double>(g.size());
  for (const double x : g) square += (x - mean) * (x - mean);
  const auto n = static_cast<double>(g.size());
  return {sum, g.size() > 1 ? std::sqrt(square * n / (n - 1)) : 1e300};
}

bool matters(const Unknown& u, double amount) {
  return std::abs(amount) >= u.least && std::abs(amount) <= u.most;
}

bool more_gain(const auto& a, const auto& b) { return a.gain > b.gain; }

}  // namespace

std::string experiment_between(const Unknown& u, const Unknown& rival) {
  return rival.separating.empty() || rival.separating == u.separating
             ? u.separating
             : u.separating + "; or: " + rival.separating;
}

bool is_rival(const Finding& f, const std::string& mechanism) {
  return std::any_of(f.rivals.begin(), f.rivals.end(),
                     [&](const Rival& r) { return is_about(r, mechanism); });
}

bool Analysis::in_stage(std::size_t candidate, Stage stage) const {
  // A sensor that redundant channels can judge is judged by them alone, before any force; one of
  // the motion that forces feel far more, once more beside them.
  const Unknown& u = inventory_.unknowns[candidate_[candidate]];
  if (u.kind == "road") return true;
  double kinematic = 0, all = 0;
  for (Index i = 0; i < weight_.size(); ++i) {
    const double c = careful_[i] * candidate_moves_(i, static_cast<Index>(candidate));
    all += c * c;
    if (relations()[rows_.row[static_cast<std::size_t>(i)].relation].sensors_only)
      kinematic += c * c;
  }
  // So is what command and outcome show, where both are logged.
  const bool redundant = kinematic > (u.kind == "sensor" ? 0.1 : 0.9) * all;
  return stage == Stage::kSensors ? redundant || u.of_motion : !redundant;
}

std::vector<Family> Analysis::candidates(Stage stage) const {
  std::vector<Family> out;
  std::vector<int> cell(rows_.row.size());
  for (std::size_t i = 0; i < rows_.row.size(); ++i)
    cell[i] = std::clamp(static_cast<int>(rows_.row[i].u_m / kCell_m), 0, cells_ - 1);
  for (std::size_t k = 0; k < candidate_.size(); ++k) {
    Family f;
    f.id = candidate_[k];
    const Unknown& u = inventory_.unknowns[f.id];
    f.column = weights(stage).cwiseProduct(candidate_moves_.col(static_cast<Index>(k)));
    f.sign = u.one_sided ? 1 : 0;
    if (used(u) || !in_stage(k, stage)) f.column.setZero();
    if (stage == Stage::kSensors && u.of_motion) f.least_left = selection::kLeastLeftOfMotion;
    if (u.along_road) {
      f.cell = cell;
      f.cells = cells_;
      f.lengths = {4, 8, 16, 32, 64};
    }
    out.push_back(std::move(f));
  }
  return out;
}

double Analysis::stability(const Fitted& model, const VectorXd& column, double amount) const {
  // Half of the folds, twenty times: does it keep its sign and stand out?
  base::Random dice(77);
  int kept = 0;
  const VectorXd c = beyond(model, column);
  for (int draw = 0; draw < 20; ++draw) {
    std::vector<bool> in(static_cast<std::size_t>(rows_.folds));
    for (std::size_t f = 0; f < in.size(); ++f) in[f] = dice.uniform() < 0.5;
    double product = 0, energy = 0;
    for (Index i = 0; i < c.size(); ++i)
      if (in[static_cast<std::size_t>(rows_.row[static_cast<std::size_t>(i)].fold)])
        product += c[i] * model.e[i], energy += c[i] * c[i];
    if (energy <= 0 || product * amount > 0) kept += 1;
  }
  return kept / 20.0;
}

Analysis::Trial Analysis::trial(Stage stage) const {
  Trial out{stage, model(stage), candidates(stage), {}, {}};
  const Fitted& fitted = out.model.fitted;
  out.scan = scan(fitted, out.families, rows_, options_.nulls,
                  without_what_stands_out(fitted, out.families, rows_));
  std::vector<Tried>& tried = out.tried;
  for (const Test& t : out.scan.best)
    if (t.gain > 0) tried.push_back({t.family, out.families[t.family].id, t, t.gain, t.amount, {}});
  std::stable_sort(tried.begin(), tried.end(), more_gain<Tried, Tried>);
  // The most promising ones that act everywhere are refitted exactly; of what differs only in a
  // constant the best few are enough.
  std::map<std::string, int> alike;
  std::vector<Start> from;
  std::vector<std::size_t> exactly;
  for (std::size_t k = 0; k < tried.size(); ++k) {
    Tried& t = tried[k];
    const Family& f = out.families[t.family];
    t.column = within(f.column, f.cell, t.test.begin, t.test.end);
    const Unknown& u = inventory_.unknowns[t.unknown];
    if (u.along_road || exactly.size() == selection::kMostExact ||
        !(t.gain > selection::kWorthALook) ||
        ++alike[u.id + u.channel + u.name] > selection::kMostAlike)
      continue;
    exactly.push_back(k);
    from.push_back({t.unknown, t.amount});
  }
  std::vector<Saved> saved = exact(from, out.model, weights(stage), stage);
  base::parallel_for(exactly.size(), 1, options_.threads, [&](std::size_t n, std::size_t) {
    Tried& t = tried[exactly[n]];
    Saved& x = saved[n];
    if (x.gain > 0) t.gain = x.gain, t.amount = x.amount, t.column = std::move(x.column);
    t.gain += louder(inventory_.unknowns[t.unknown], t.amount, weights(stage));
  });
  std::stable_sort(tried.begin(), tried.end(), more_gain<Tried, Tried>);
  return out;
}

std::vector<double> Analysis::gains(const Trial& trial, const Tried& t) const {
  return cross_validate(trial.model.fitted, t.column, trial.model.precision, VectorXd::Zero(1),
                        rows_);
}

void Analysis::list_evidence(Findings& out, const Trial& trial) const {
  for (const Tried& t : trial.tried) {
    const Unknown& u = inventory_.unknowns[t.unknown];
    // A stretch of road counts in the stage that sees all of it.
    if (trial.stage == Stage::kSensors && u.along_road) continue;
    Evidence e{u.id, u.channel, u.name, t.amount, t.test.z, 0.0, u.unit, {}, u.least};
    if (t.gain > selection::kWorthALook) e.cv_gain = total(gains(trial, t)).sum;
    if (u.along_road)
      e.place = fmt::format(", u {:.0f} to {:.0f} m", t.test.begin * kCell_m, t.test.end * kCell_m);
    out.evidence.push_back(e);
  }
}

bool Analysis::comes_back(const Trial& trial, const Tried& t) const {
  const Fitted& m = trial.model.fitted;
  const bool along_road = inventory_.unknowns[t.unknown].along_road;
  const VectorXd c = beyond(m, t.column);
  // What is left once it is in, gathered by stretch of road (by time, for the road itself): errors
  // of the stated curves return every lap and must not pass for it.
  VectorXd groups = VectorXd::Zero(along_road ? static_cast<Index>(rows_.blocks) : stretches());
  const double strength = c.squaredNorm() > 0 ? c.dot(m.e) / c.squaredNorm() : 0.0;
  for (Index i = 0; i < c.size(); ++i) {
    const Row& row = rows_.row[static_cast<std::size_t>(i)];
    groups[along_road ? static_cast<Index>(row.block) : stretch(row)] +=
        c[i] * (m.e[i] - strength * c[i]);
  }
  return !(std::abs(c.dot(m.e)) < selection::kGrouped * groups.norm());
}

bool Analysis::is_denied(const Trial& trial, const Tried& t) const {
  if (inventory_.unknowns[t.unknown].kind != "road") return false;
  double energy = 0, product = 0;
  for (Index i = 0; i < t.column.size(); ++i) {
    const Relation relation =
        static_cast<Relation>(rows_.row[static_cast<std::size_t>(i)].relation);
    // An ax that is the derivative of the speed would deny every grade.
    if (!relations()[relation].sensors_only || relation == kAccelX) continue;
    energy += t.column[i] * t.column[i];
    product += t.column[i] * trial.model.fitted.e[i];
  }
  return std::abs(t.amount * energy - product) > selection::kDenied * std::sqrt(energy);
}

std::optional<Finding> Analysis::judged(const Trial& trial, const Tried& t) const {
  const Unknown& u = inventory_.unknowns[t.unknown];
  const bool by_sensors = u.kind == "sensor" && trial.stage == Stage::kSensors;
  const double threshold = trial.scan.threshold * (by_sensors ? 1.0 : selection::kMargin);
  // Where the exact amount was sought it decides, not the straight line to it.
  if (std::sqrt(t.gain) < threshold || (u.along_road && std::abs(t.test.z) < threshold))
    return std::nullopt;
  if (is_denied(trial, t) || (u.along_road && !stands_out(trial, t))) return std::nullopt;
  const auto [cv, se] = total(gains(trial, t));
  if (!(cv > selection::kSure * se) &&
      !(cv > selection::kNearlyWhole * t.gain && cv > selection::kSureEnough * se))
    return std::nullopt;
  if (!(cv > 0) || !comes_back(trial, t)) return std::nullopt;
  Finding found = finding_of(t.unknown);
  found.stability = stability(trial.model.fitted, t.column, t.amount);
  if (found.stability < selection::kStable) return std::nullopt;
  found.cv_gain = cv;
  found.statistic = std::copysign(std::sqrt(t.gain), t.amount);
  found.threshold = threshold;
  add_rivals(found, trial, t);
  return found;
}

void Analysis::add_rivals(Finding& found, const Trial& trial, const Tried& t) const {
  // Nearly the same column, or nearly the same gain.
  const Unknown& u = inventory_.unknowns[t.unknown];
  const VectorXd c = beyond(trial.model.fitted, t.column);
  const std::vector<double> own = gains(trial, t);
  for (const Tried& other : trial.tried) {
    const Unknown& o = inventory_.unknowns[other.unknown];
    const bool itself = &other == &t || std::tie(o.id, o.channel) == std::tie(u.id, u.channel);
    if (itself || other.gain < selection::kRival * t.gain || !matters(o, other.amount) ||
        is_denied(trial, other))
      continue;
    const auto same = [&](const Rival& r) { return is_of(r, o); };
    if (std::any_of(found.rivals.begin(), found.rivals.end(), same)) continue;
    const VectorXd d = beyond(trial.model.fitted, other.column);
    const double cosine =
        std::abs(c.dot(d)) / std::sqrt(std::max(1e-300, c.squaredNorm() * d.squaredNorm()));
    const std::vector<double> gain = gains(trial, other);
    std::vector<double> difference = gain;
    for (std::size_t f = 0; f < difference.size(); ++f) difference[f] = own[f] - difference[f];
    const auto [lead, lead_error] = total(difference);
    const bool one_sensor = u.kind == "sensor" && o.kind == "sensor" && u.channel == o.channel;
    const double ahead = t.gain - other.gain;
    const bool as_good =
        ahead < std::max(selection::kLead,
                         (one_sensor ? selection::kInexactSensor : selection::kInexact) * t.gain);
    const bool parallel = cosine > selection::kParallel &&
                          lead < selection::kParallelSure * lead_error &&
                          ahead < selection::kParallelLead;
    found.rivals.push_back(
        {o.id, o.channel, experiment_between(u, o), total(gain).sum, !(as_good || parallel)});
  }
}

Accepted Analysis::accepted_of(const Trial& trial, const Tried& t) const {
  const Unknown& u = inventory_.unknowns[t.unknown];
  Accepted a;
  a.unknown = t.unknown;
  a.amount = t.amount;
  a.kinematic = trial.stage == Stage::kSensors && (u.kind == "sensor" || u.along_road);
  if (!u.along_road) return a;
  // A profile: every cell near the run that was found, held together by a prior; as secants,
  // because the less grip there is, the more the next piece takes away.
  Setting moved = setting_with(amounts_);
  u.set(moved, t.amount);
  const VectorXd per_unit = (r_ - rows_at(moved)) / t.amount;
  const int reach = std::max(3, (t.test.end - t.test.begin) / 2);
  const int begin = std::max(0, t.test.begin - reach), end = std::min(cells_, t.test.end + reach);
  const double width = 1.5 * std::abs(t.amount);
  a.precision = VectorXd::Constant(end - begin, 1 / (width * width));
  a.columns = MatrixXd::Zero(r_.size(), end - begin);
  for (Index i = 0; i < r_.size(); ++i) {
    const int cell = trial.families[t.family].cell[static_cast<std::size_t>(i)];
    if (cell >= begin && cell < end) a.columns(i, cell - begin) = per_unit[i];
  }
  for (int cell = begin; cell < end; ++cell) a.cells.push_back(cell);
  if (a.kinematic) a.amounts = VectorXd::Zero(end - begin);
  return a;
}

bool Analysis::add_by_score(Findings& out, Stage stage, bool first) {
  const Trial trial = this->trial(stage);
  if (first) {
    // Both stages may raise an alarm.
    out.threshold = trial.scan.threshold;
    out.null_replicates = trial.scan.null_max.size();
    out.null_false_alarm += trial.scan.false_alarms;
    list_evidence(out, trial);
  }
  int looked = 0;
  for (const Tried& t : trial.tried) {
    if (looked == selection::kMostJudged) break;
    const Unknown& u = inventory_.unknowns[t.unknown];
    if (!matters(u, t.amount)) continue;
    ++looked;
    std::optional<Finding> found = judged(trial, t);
    if (!found) continue;
    if (u.along_road) found->where.push_back({t.test.begin * kCell_m, t.test.end * kCell_m, {}});
    accept(out, std::move(*found), accepted_of(trial, t));
    return true;
  }
  return false;
}

void Analysis::name_by_score(Findings& out, Stage stage) {
  for (int k = 0; k < selection::kMostFindings && add_by_score(out, stage, k == 0); ++k) {
  }
}

}  // namespace explain
