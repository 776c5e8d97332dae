#include "explain/explain.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "analysis.h"
#include "road_profiles.h"
#include "base/parallel.h"
#include "vehicle/error.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Findings explain(const std::vector<Signals>& logs, const vehicle::Vehicle& car, const ExplainOptions& options) {
  return Analysis(logs, car, options).run();
}

Analysis::Analysis(const std::vector<Signals>& logs, const vehicle::Vehicle& car, const ExplainOptions& options)
    : logs_(logs), car_(car), options_(options) {
  if (logs.empty()) throw vehicle::Error("no recordings");
  inventory_ = inventory(logs, car);
  for (std::size_t k = 0; k < inventory_.unknowns.size(); ++k)
    (inventory_.unknowns[k].role == Role::kCandidate ? candidate_ : refit_).push_back(k);
  cells_ = static_cast<int>(logs.front().length_m / kCell_m) + 1;
  stated_.p = car.parameters;
  choose_substeps();
  std::vector<Residuals> base;
  for (std::size_t k = 0; k < logs.size(); ++k)
    base.push_back(residuals(logs[k], car, stated_, {.known = &drives_[k]}));
  rows_ = make_rows(logs, base);
  if (rows_.row.size() < 200)
    throw vehicle::Error(fmt::format("{}: {:.0f} s of usable driving on this road; at least 30 s are wanted", logs.front().name,
                                     0.3 * static_cast<double>(rows_.row.size()) / 4));
  // Laps held out take no part in any choice: their weight is zero.
  for (const Row& row : rows_.row) training_.push_back(options.hold_out.count(row.lap) == 0);
  if (std::count(training_.begin(), training_.end(), true) < 200)
    throw vehicle::Error("the held-out laps leave less than 30 s for the analysis");
  amounts_ = VectorXd::Zero(static_cast<Index>(refit_.size()));
  stated_rows_ = gather(rows_, base);
}

Setting Analysis::setting_with(const VectorXd& amounts) const {
  Setting s = stated_;
  for (std::size_t k = 0; k < refit_.size(); ++k) inventory_.unknowns[refit_[k]].set(s, amounts[static_cast<Index>(k)]);
  auto at = static_cast<Index>(refit_.size());
  for (const Accepted& a : accepted_) {
    if (has_one_amount(a)) inventory_.unknowns[a.unknown].set(s, amounts[at++]);
    if (a.shapes.size() > 0) s.along.*inventory_.unknowns[a.unknown].profile = values_along(a);
  }
  return s;
}

void Analysis::choose_substeps() {
  // Mean square of the difference over that which is let pass: what a good logger's mean over 0.3 s
  // just tells (0.03 m/s2, rad/s2, N per kg), or 3 % of the quantity itself.
  const auto apart = [](const std::vector<double>& coarse, const std::vector<double>& fine,
                        double unit) {
    double sum = 0, square = 0, count = 0;
    for (std::size_t i = 0; i < fine.size(); ++i) {
      if (!std::isfinite(fine[i])) continue;
      if (!std::isfinite(coarse[i])) return HUGE_VAL;  // lost
      sum += (coarse[i] - fine[i]) * (coarse[i] - fine[i]);
      square += fine[i] * fine[i];
      count += 1;
    }
    return count > 0 ? sum / std::max(0.03 * 0.03 * count * unit * unit, 0.03 * 0.03 * square) : 0.0;
  };
  const double mass = car_.parameters[vehicle::Parameter::chassis_mass_kg];
  const auto alike = [&](const Led& coarse, const Led& fine) {
    return std::max({apart(coarse.force_x_mps2, fine.force_x_mps2, 1.0),
                     apart(coarse.force_y_mps2, fine.force_y_mps2, 1.0),
                     apart(coarse.yaw_radps2, fine.yaw_radps2, 1.0),
                     apart(coarse.load_front_n, fine.load_front_n, mass),
                     apart(coarse.load_rear_n, fine.load_rear_n, mass)}) < 1.0;
  };
  std::vector<KnownDrive> coarse;
  for (const int substeps : {10, 20, 40, 80}) {
    stated_.substeps = substeps;
    drives_.assign(logs_.size(), {});
    base::parallel_for(logs_.size(), 1, options_.threads, [&](std::size_t k, std::size_t) {
      residuals(logs_[k], car_, stated_, {.keep = &drives_[k]});
    });
    bool enough = !coarse.empty();
    for (std::size_t k = 0; k < coarse.size(); ++k)
      enough = enough && alike(coarse[k].led, drives_[k].led);
    if (enough) {
      stated_.substeps = coarse.front().setting.substeps;
      drives_ = std::move(coarse);
      return;
    }
    coarse = drives_;
  }
  for (const KnownDrive& drive : drives_) {
    const auto seconds = [](const std::vector<double>& x) {
      return Signals::kStep_s * static_cast<double>(std::count_if(
                                    x.begin(), x.end(), [](double v) { return std::isfinite(v); }));
    };
    const double led = seconds(drive.led.force_x_mps2), wanted = seconds(drive.by.vx_mps);
    if (led < 0.9 * wanted)
      remarks_.push_back(fmt::format(
          "the car of the vehicle file cannot follow this recording: in {:.0f} of {:.0f} s its "
          "equations of motion are lost even in steps of {:.2g} ms; forces are compared where they "
          "hold; crgdrive replay shows where",
          wanted - led, wanted, 1e3 * Signals::kStep_s / stated_.substeps));
  }
}

VectorXd Analysis::rows_at(const Setting& setting) const {
  std::vector<Residuals> r;
  for (std::size_t k = 0; k < logs_.size(); ++k)
    r.push_back(residuals(logs_[k], car_, setting, {.known = &drives_[k]}));
  VectorXd out = gather(rows_, r);
  for (Index i = 0; i < out.size(); ++i)
    if (!std::isfinite(out[i])) out[i] = stated_rows_[i];
  return out;
}

void Analysis::look() {
  const Setting setting = setting_with(amounts_);
  base::parallel_for(logs_.size(), 1, options_.threads, [&](std::size_t k, std::size_t) {
    residuals(logs_[k], car_, setting, {.keep = &drives_[k]});
  });
  r_ = rows_at(setting);
}

void Analysis::weigh() {
  const VectorXd e = weight_.size() == 0 ? r_ : VectorXd(model().fitted.e.cwiseQuotient(weight_.cwiseMax(1e-12)));
  Noise noise = noise_of(rows_, e, training_);
  weight_ = std::move(noise.weight);
  sigma_ = noise.sigma;
  spread_ = noise.spread;
}

Analysis::Model Analysis::model(const VectorXd& w) const {
  Model m;
  Index columns = moves_.cols();
  for (const Accepted& a : accepted_) columns += a.columns.cols();
  MatrixXd x(r_.size(), columns);
  m.precision = VectorXd::Zero(columns);
  VectorXd before = VectorXd::Zero(columns);
  x.leftCols(moves_.cols()) = moves_;
  for (Index k = 0; k < moves_.cols(); ++k)
    if (k < static_cast<Index>(refit_.size())) {
      m.precision[k] = 1.0 / (width(static_cast<std::size_t>(k)) * width(static_cast<std::size_t>(k)));
      before[k] = amounts_[k];
    }
  auto everywhere = static_cast<Index>(refit_.size());
  for (const Accepted& a : accepted_) {
    if (!has_one_amount(a)) continue;
    for (Index i = 0; i < x.rows() && a.kinematic && everywhere < moves_.cols(); ++i)
      if (!relations()[rows_.row[static_cast<std::size_t>(i)].relation].sensors_only) x(i, everywhere) = 0.0;
    ++everywhere;
  }
  Index at = moves_.cols();
  for (const Accepted& a : accepted_) {
    if (has_one_amount(a)) continue;
    x.middleCols(at, a.columns.cols()) = a.columns;
    m.precision.segment(at, a.columns.cols()) = a.precision;
    if (a.shapes.size() > 0) before.segment(at, a.columns.cols()) = a.amounts;
    at += a.columns.cols();
  }
  m.fitted = fit(w.asDiagonal() * x, w.cwiseProduct(r_), m.precision, before);
  return m;
}

VectorXd Analysis::careful_weights() const {
  // Errors of the stated curves come back in every state and every lap: more rows do not make them
  // smaller, so that a relation with forces counts as no more than this many independent ones.
  constexpr double kIndependent = 60.0;
  std::array<double, kRelationCount> rows{};
  for (const Row& row : rows_.row) rows[row.relation] += 1;
  VectorXd w = weights();
  for (Index i = 0; i < w.size(); ++i) {
    const std::size_t k = rows_.row[static_cast<std::size_t>(i)].relation;
    if (!relations()[k].sensors_only) w[i] *= std::sqrt(std::min(1.0, kIndependent * spread_[k] / rows[k]));
  }
  return w;
}

VectorXd Analysis::weights() const {
  if (!kinematic_) return weight_;
  VectorXd w = weight_;
  for (Index i = 0; i < w.size(); ++i)
    if (!relations()[rows_.row[static_cast<std::size_t>(i)].relation].sensors_only) w[i] = 0.0;
  return w;
}

bool Analysis::in_stage(std::size_t candidate) const {
  // A sensor that redundant channels can judge is judged by them alone, before any force.
  const Unknown& u = inventory_.unknowns[candidate_[candidate]];
  if (u.kind == "road") return true;
  double kinematic = 0, all = 0;
  for (Index i = 0; i < weight_.size(); ++i) {
    const double c = careful_[i] * candidate_moves_(i, static_cast<Index>(candidate));
    all += c * c;
    if (relations()[rows_.row[static_cast<std::size_t>(i)].relation].sensors_only) kinematic += c * c;
  }
  // So is what command and outcome show, where both are logged.
  const bool redundant = kinematic > (u.kind == "sensor" ? 0.1 : 0.9) * all;
  return redundant == kinematic_;
}

void Analysis::refit(int rounds) {
  std::vector<const Unknown*> free;
  for (const std::size_t k : refit_) free.push_back(&inventory_.unknowns[k]);
  for (const Accepted& a : accepted_)
    if (has_one_amount(a)) free.push_back(&inventory_.unknowns[a.unknown]);
  // One Jacobian serves all rounds (chord method); only columns that are new are computed again.
  const bool fresh = moves_.size() == 0;
  const auto known = static_cast<std::size_t>(moves_.cols());
  const auto reckon = [&](std::size_t from) {
    const std::vector<const Unknown*> wanted(free.begin() + static_cast<std::ptrdiff_t>(from), free.end());
    const MatrixXd columns = derivatives(logs_, car_, setting_with(amounts_), wanted, rows_, options_.threads, [&](double share) { progress("refit of the parameters", share); });
    moves_.conservativeResize(columns.rows(), static_cast<Index>(free.size()));
    moves_.rightCols(columns.cols()) = columns;
  };
  look();
  if (fresh) reckon(0);
  else if (known < free.size()) reckon(known);
  for (int round = 0; round < rounds; ++round) {
    if (weight_.size() == 0) weigh();
    const Model m = careful_model();
    VectorXd move = m.fitted.amount.head(moves_.cols());
    // No further than 1.5 prior widths at once: the relations are not linear in everything.
    for (Index k = 0; k < static_cast<Index>(refit_.size()); ++k) {
      const double most = 1.5 * std::min(width(static_cast<std::size_t>(k)), 2 * free[static_cast<std::size_t>(k)]->width);
      move[k] = std::clamp(move[k], -most, most);
      const double far = limit(*free[static_cast<std::size_t>(k)]);
      amounts_[k] = std::clamp(amounts_[k] + move[k], -far, far);
    }
    for (Index k = static_cast<Index>(refit_.size()); k < moves_.cols(); ++k) amounts_[k] += move[k];
    Index place = moves_.cols();
    for (Accepted& a : accepted_) {
      if (a.shapes.size() > 0) a.amounts += m.fitted.amount.segment(place, a.columns.cols());
      place += a.columns.cols();
    }
    look();
    weigh();
  }
  if (fresh) reckon(0);
  // The amounts of accepted unknowns are where they are wanted.
  auto at = static_cast<Index>(refit_.size());
  for (Accepted& a : accepted_)
    if (has_one_amount(a)) a.amount = amounts_[at++];
}

bool Analysis::used(const Unknown& u) const {
  return std::any_of(accepted_.begin(), accepted_.end(), [&](const Accepted& a) {
    const Unknown& other = inventory_.unknowns[a.unknown];
    return other.id == u.id && other.channel == u.channel && other.name == u.name;
  });
}

std::vector<Family> Analysis::candidates() const {
  std::vector<Family> out;
  std::vector<int> cell(rows_.row.size());
  for (std::size_t i = 0; i < rows_.row.size(); ++i) cell[i] = std::clamp(static_cast<int>(rows_.row[i].u_m / kCell_m), 0, cells_ - 1);
  for (std::size_t k = 0; k < candidate_.size(); ++k) {
    Family f;
    f.id = candidate_[k];
    const Unknown& u = inventory_.unknowns[f.id];
    f.column = weights().cwiseProduct(candidate_moves_.col(static_cast<Index>(k)));
    f.sign = u.one_sided ? 1 : 0;
    if (used(u) || !in_stage(k)) f.column.setZero();
    if (u.along_road) {
      f.cell = cell;
      f.cells = cells_;
      f.lengths = {4, 8, 16, 32, 64};
    }
    out.push_back(std::move(f));
  }
  return out;
}

namespace {

/// Errors of the stated curves and of the road's slopes return every lap, which turned signs do not show:
/// factor on the nulls' threshold where they take part, set on 200 recordings without any effect.
constexpr double kMargin = 1.25;
constexpr double kGrouped = 4.0;  ///< standard deviations between groups that a finding must reach

}  // namespace

Finding Analysis::finding_of(std::size_t unknown) const {
  const Unknown& u = inventory_.unknowns[unknown];
  Finding f;
  f.unknown = unknown;
  f.mechanism = u.id;
  f.kind = u.kind;
  f.channel = u.channel;
  f.physics = u.physics;
  f.equation = u.equation;
  return f;
}

double Analysis::stability(const Fitted& model, const VectorXd& column, double amount) const {
  // Half of the folds, twenty times: does it keep its sign and stand out?
  Dice dice{77};
  int kept = 0;
  const VectorXd c = beyond(model, column);
  for (int draw = 0; draw < 20; ++draw) {
    std::vector<bool> in(static_cast<std::size_t>(rows_.folds));
    for (std::size_t f = 0; f < in.size(); ++f) in[f] = dice.roll() < 0.5;
    double product = 0, energy = 0;
    for (Index i = 0; i < c.size(); ++i)
      if (in[static_cast<std::size_t>(rows_.row[static_cast<std::size_t>(i)].fold)]) product += c[i] * model.e[i], energy += c[i] * c[i];
    if (energy <= 0 || product * amount > 0) kept += 1;
  }
  return kept / 20.0;
}

void Analysis::accept(Findings& out, Finding found, Accepted a) {
  out.findings.push_back(std::move(found));
  if (has_one_amount(a)) {
    // amounts_ lists those that act everywhere in the order of accepted_.
    amounts_.conservativeResize(amounts_.size() + 1);
    amounts_[amounts_.size() - 1] = a.amount;
  }
  accepted_.push_back(std::move(a));
  refit(2);
}

bool Analysis::step(Findings& out, bool first) {
  const Model m = model();
  const std::vector<Family> families = candidates();
  const Scan s = scan(m.fitted, families, rows_, options_.nulls, without_best(m.fitted, families, rows_));
  if (first) {
    // Both stages may raise an alarm.
    out.threshold = s.threshold;
    out.null_replicates = s.null_max.size();
    out.null_false_alarm += s.false_alarms;
  }
  // One judgement per family; the most promising ones that act everywhere are refitted exactly.
  struct Tried {
    std::size_t family = 0, unknown = 0;
    Test test;
    double gain = 0.0, amount = 0.0;
    VectorXd column;
  };
  std::vector<Tried> tried;
  for (const Test& t : s.best)
    if (t.gain > 0) tried.push_back({t.family, families[t.family].id, t, t.gain, t.amount, {}});
  std::stable_sort(tried.begin(), tried.end(), [](const Tried& a, const Tried& b) { return a.gain > b.gain; });
  // Of what differs only in a constant the best three are enough.
  std::map<std::string, int> alike;
  std::vector<bool> exactly;
  int most = 10;
  for (const Tried& t : tried) {
    const Unknown& u = inventory_.unknowns[t.unknown];
    exactly.push_back(!u.along_road && most > 0 && t.gain > 9 &&
                      ++alike[u.id + u.channel + u.name] <= 3);
    if (exactly.back()) --most;
  }
  std::atomic<std::size_t> done{0};
  base::parallel_for(tried.size(), 1, options_.threads, [&](std::size_t k, std::size_t) {
    Tried& t = tried[k];
    t.column = within(families[t.family].column, families[t.family].cell, t.test.begin, t.test.end);
    if (exactly[k]) {
      const Saved x = exact(t.unknown, t.amount, m, weights());
      if (x.gain > 0) t.gain = x.gain, t.amount = x.amount, t.column = x.column;
    }
    progress("tests of mechanisms", static_cast<double>(++done) / static_cast<double>(tried.size()));
  });
  std::stable_sort(tried.begin(), tried.end(), [](const Tried& a, const Tried& b) { return a.gain > b.gain; });
  const auto gains = [&](const Tried& t) { return cross_validate(m.fitted, t.column, m.precision, VectorXd::Zero(1), rows_); };
  const auto total = [](const std::vector<double>& g) {
    double sum = 0, square = 0;
    for (const double x : g) sum += x;
    const double mean = sum / static_cast<double>(g.size());
    for (const double x : g) square += (x - mean) * (x - mean);
    const double se = g.size() > 1 ? std::sqrt(square * static_cast<double>(g.size()) / static_cast<double>(g.size() - 1)) : 1e300;
    return std::pair{sum, se};
  };
  if (first)
    for (const Tried& t : tried) {
      const Unknown& u = inventory_.unknowns[t.unknown];
      Evidence e{u.id, u.channel, u.name, t.amount, t.test.z, t.gain > 9 ? total(gains(t)).first : 0.0, u.unit};
      if (u.along_road) e.detail += fmt::format(", u {:.0f} to {:.0f} m", t.test.begin * kCell_m, t.test.end * kCell_m);
      if (!kinematic_ || !u.along_road) out.evidence.push_back(e);
    }
  int looked = 0;
  for (std::size_t k = 0; k < tried.size() && looked < 6; ++k) {
    const Tried& t = tried[k];
    const Unknown& u = inventory_.unknowns[t.unknown];
    if (std::abs(t.amount) < u.least || std::abs(t.amount) > u.most) continue;
    ++looked;
    const double threshold = s.threshold * (u.kind == "sensor" && kinematic_ ? 1.0 : kMargin);
    // Where the exact amount was sought it decides, not the straight line to it.
    if (std::sqrt(t.gain) < threshold) continue;
    if (u.along_road && !stands_out(families[t.family], t.test, s.threshold)) continue;
    const std::vector<double> g = gains(t);
    const auto [cv, se] = total(g);
    if (!(cv > 2 * se) && !(cv > 0.8 * t.gain && cv > 3 * se * 0.5)) continue;
    if (!(cv > 0)) continue;
    const VectorXd c = beyond(m.fitted, t.column);
    // What is left once it is in, gathered by stretch of road (by time, for the road itself): errors
    // of the stated curves return every lap and must not pass for it.
    VectorXd groups = VectorXd::Zero(u.along_road ? static_cast<Index>(rows_.blocks) : stretches());
    const double strength = c.squaredNorm() > 0 ? c.dot(m.fitted.e) / c.squaredNorm() : 0.0;
    for (Index i = 0; i < c.size(); ++i) {
      const Row& row = rows_.row[static_cast<std::size_t>(i)];
      groups[u.along_road ? static_cast<Index>(row.block) : stretch(row)] += c[i] * (m.fitted.e[i] - strength * c[i]);
    }
    if (std::abs(c.dot(m.fitted.e)) < kGrouped * groups.norm()) continue;
    Finding found = finding_of(t.unknown);
    found.stability = stability(m.fitted, t.column, t.amount);
    if (found.stability < 0.8) continue;
    found.cv_gain = cv;
    found.statistic = std::copysign(std::sqrt(t.gain), t.amount);
    found.threshold = threshold;
    // Rivals: nearly the same column, or nearly the same gain.
    for (const Tried& other : tried) {
      const Unknown& o = inventory_.unknowns[other.unknown];
      if (&other == &t || (o.id == u.id && o.channel == u.channel)) continue;
      if (other.gain < 0.3 * t.gain) continue;
      const bool listed = std::any_of(found.rivals.begin(), found.rivals.end(), [&](const Rival& r) { return r.mechanism == o.id && r.channel == o.channel; });
      if (listed) continue;
      const VectorXd d = beyond(m.fitted, other.column);
      const double cosine = std::abs(c.dot(d)) / std::sqrt(std::max(1e-300, c.squaredNorm() * d.squaredNorm()));
      std::vector<double> difference = gains(other);
      for (std::size_t f = 0; f < difference.size(); ++f) difference[f] = g[f] - difference[f];
      const auto [lead, lead_se] = total(difference);
      Rival r;
      r.mechanism = o.id;
      r.channel = o.channel;
      r.cv_gain = total(gains(other)).first;
      // A tenth of the gain is what these relations, not exact, may get wrong about a column's shape;
      // two errors of one sensor are judged by the same kinematics, which are.
      const double inexact = u.kind == "sensor" && o.kind == "sensor" && u.channel == o.channel ? 0.03 : 0.1;
      r.separable = !(t.gain - other.gain < std::max(8.0, inexact * t.gain) || (cosine > 0.95 && lead < 2 * lead_se && t.gain - other.gain < 25.0));
      if (std::abs(other.amount) < o.least || std::abs(other.amount) > o.most) continue;
      r.separating_experiment = o.separating.empty() || o.separating == u.separating ? u.separating : u.separating + "; or: " + o.separating;
      found.rivals.push_back(r);
    }
    Accepted a;
    a.unknown = t.unknown;
    a.amount = t.amount;
    a.kinematic = kinematic_ && u.kind == "sensor";
    if (u.along_road) {
      // A profile: every cell near the run that was found, held together by a prior; as secants, because the less
      // grip there is, the more the next piece takes away.
      Setting moved = setting_with(amounts_);
      u.set(moved, t.amount);
      const VectorXd per_unit = (r_ - rows_at(moved)) / t.amount;
      const int reach = std::max(3, (t.test.end - t.test.begin) / 2);
      const int begin = std::max(0, t.test.begin - reach), end = std::min(cells_, t.test.end + reach);
      const double width = 1.5 * std::abs(t.amount);
      a.precision = VectorXd::Constant(end - begin, 1 / (width * width));
      a.columns = MatrixXd::Zero(r_.size(), end - begin);
      for (Index i = 0; i < r_.size(); ++i) {
        const int cell = families[t.family].cell[static_cast<std::size_t>(i)];
        if (cell >= begin && cell < end) a.columns(i, cell - begin) = per_unit[i];
      }
      for (int cell = begin; cell < end; ++cell) a.cells.push_back(cell);
      found.where.push_back({t.test.begin * kCell_m, t.test.end * kCell_m, {}});
    }
    kinematic_ = false;
    accept(out, std::move(found), std::move(a));
    return true;
  }
  return false;
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
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    const auto& amount = described.findings[k].parameters.front();
    if (amount.low <= 0 && amount.high >= 0) return k;
  }
  return std::nullopt;
}

void Analysis::drop_faded(Findings& out) {
  while (const std::optional<std::size_t> k = faded(out)) {
    const auto at = static_cast<std::ptrdiff_t>(*k);
    if (has_one_amount(accepted_[*k])) {
      // amounts_ and moves_ have those that act everywhere, in the order of accepted_.
      const Index place =
          static_cast<Index>(refit_.size()) +
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
    refit(2);  // the others move
  }
}

void Analysis::untouched(Findings& out) const {
  // What was asked and left no trace: tested where these recordings could have shown it, else named.
  for (std::size_t k = 0; k < candidate_.size(); ++k) {
    const Unknown& u = inventory_.unknowns[candidate_[k]];
    const auto same = [&](const Evidence& e) { return e.mechanism == u.id && e.channel == u.channel && e.detail.starts_with(u.name); };
    if (std::any_of(out.evidence.begin(), out.evidence.end(), same)) continue;
    const VectorXd column = weight_.cwiseProduct(candidate_moves_.col(static_cast<Index>(k)));
    if (!(column.squaredNorm() > 0)) out.untestable.push_back({u.id, "it would change nothing in these recordings with the stated car"});
    else if ((u.kind == "vehicle" || u.kind == "environment") && !apart_from_curves(candidate_[k])) out.untestable.push_back({u.id, "in these recordings the uncertain curves of the stated car can take its place"});
    else out.evidence.push_back({u.id, u.channel, u.name, 0.0, 0.0, 0.0, u.unit});
  }
}

Findings Analysis::run() {
  Findings out;
  out.laps = static_cast<std::size_t>(rows_.laps);
  for (const Signals& s : logs_)
    for (const std::string& remark : s.remarks) out.remarks.push_back(remark);
  out.remarks.insert(out.remarks.end(), remarks_.begin(), remarks_.end());
  if (options_.mechanisms) find_road_profiles(out);
  refit(4);
  if (!options_.mechanisms) {
    prove(out);
    return out;
  }
  std::vector<const Unknown*> wanted;
  for (const std::size_t k : candidate_) wanted.push_back(&inventory_.unknowns[k]);
  candidate_moves_ = derivatives(logs_, car_, setting_with(amounts_), wanted, rows_, options_.threads,
                                 [&](double share) { progress("one derivative per mechanism", share); });
  careful_ = careful_weights();
  free_parameters();
  constexpr int kMost = 4;
  for (const bool kinematic : {true, false}) {
    bool more = true;
    for (int k = 0; k < kMost && more; ++k) {
      kinematic_ = kinematic;
      more = step(out, k == 0);
      kinematic_ = false;
    }
  }
  out.null_false_alarm += alarms_by_cost();
  for (int k = 0; k < kMost && step_by_cost(out); ++k) {}
  drop_faded(out);
  untouched(out);
  describe(out);
  leftovers(out);
  prove(out);
  // Two components of one thing are one finding.
  for (std::size_t k = 0; k < out.findings.size(); ++k)
    for (std::size_t l = out.findings.size(); l-- > k + 1;) {
      Finding &a = out.findings[k], &b = out.findings[l];
      if (a.mechanism != b.mechanism || a.channel != b.channel || a.kind != "environment") continue;
      a.parameters.insert(a.parameters.end(), b.parameters.begin(), b.parameters.end());
      out.findings.erase(out.findings.begin() + static_cast<std::ptrdiff_t>(l));
    }
  // What was held for want of evidence and found nevertheless was tested after all.
  std::erase_if(inventory_.untestable, [&](const Untestable& u) {
    return std::any_of(out.findings.begin(), out.findings.end(), [&](const Finding& f) { return f.mechanism == u.mechanism && f.kind == "parameter"; });
  });
  out.untestable.insert(out.untestable.begin(), inventory_.untestable.begin(), inventory_.untestable.end());
  bool tie = false;
  for (const Finding& f : out.findings)
    for (const Rival& r : f.rivals) tie = tie || !r.separable;
  if (tie) out.verdict = "tie";
  else if (!out.unexplained.empty()) out.verdict = "unknown";
  else if (!out.findings.empty()) out.verdict = "explained";
  progress("done", 1.0);
  return out;
}

}  // namespace explain
