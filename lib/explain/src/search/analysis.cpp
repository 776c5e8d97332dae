#include "analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/parallel.h"
#include "explain/plausible_car.h"
#include "not_known.h"
#include "road_profiles.h"
#include "vehicle/error.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Of driving in which about four relations hold.
double seconds_of(std::size_t rows) { return 0.3 * static_cast<double>(rows) / 4; }

}  // namespace

Analysis::Analysis(const std::vector<Signals>& logs, const vehicle::Vehicle& car,
                   const ExplainOptions& options)
    : logs_(logs), car_(car), options_(options) {
  if (logs.empty()) throw vehicle::Error("no recordings");
  inventory_ = inventory(logs, car);
  const auto by_forces = [&](const Unknown& u) {
    const auto& columns = logs.front().column;
    return u.role == Role::kCandidate && (is_of_the_car(u.kind) || u.channel == columns[kSteer] ||
                                          u.channel == columns[kBrakeFront]);
  };
  if (!options.forces) {
    std::erase_if(inventory_.unknowns, by_forces);
    // Where a front wheel runs is said by the centre of mass too, and by the side slip.
    for (Unknown& u : inventory_.unknowns)
      u.stays_held = u.stays_held || vehicle::find_parameter(u.name).has_value();
  }
  for (std::size_t k = 0; k < inventory_.unknowns.size(); ++k)
    (inventory_.unknowns[k].role == Role::kCandidate ? candidate_ : refit_).push_back(k);
  cells_ = static_cast<int>(logs.front().length_m / kCell_m) + 1;
  stated_.p = car.parameters;
  const std::vector<KnownDrive> fine = choose_substeps();
  std::vector<Residuals> base;
  for (std::size_t k = 0; k < logs.size(); ++k)
    base.push_back(residuals(logs[k], car, fine[k].setting, {.known = &fine[k]}));
  for (Residuals& of_log : base)
    for (std::size_t k = 0; k < kRelationCount && !options.forces; ++k)
      if (!relations()[k].sensors_only) std::fill(of_log.r[k].begin(), of_log.r[k].end(), kNaN);
  rows_ = make_rows(logs, base);
  if (options.forces && rows_.row.size() < selection::kLeastRows)
    throw vehicle::Error(fmt::format(
        "{}: {:.0f} s of usable driving on this road; at least {:.0f} s are wanted: give a longer "
        "log, or more with --log",
        logs.front().name, seconds_of(rows_.row.size()), seconds_of(selection::kLeastRows)));
  // Laps held out take no part in any choice: their weight is zero.
  for (const Row& row : rows_.row) training_.push_back(options.hold_out.count(row.lap) == 0);
  if (options.forces && !enough_rows())
    throw vehicle::Error(fmt::format("the held-out laps leave less than {:.0f} s for the analysis",
                                     seconds_of(selection::kLeastRows)));
  amounts_ = VectorXd::Zero(static_cast<Index>(refit_.size()));
  r_ = stated_rows_ = gather(rows_, base);
  find_what_fine_steps_add();
}

bool Analysis::enough_rows() const {
  return std::count(training_.begin(), training_.end(), true) >=
         static_cast<std::ptrdiff_t>(selection::kLeastRows);
}

Findings Analysis::begin() const {
  Findings out;
  out.laps = static_cast<std::size_t>(rows_.laps);
  for (const Signals& s : logs_) {
    out.remarks.insert(out.remarks.end(), s.remarks.begin(), s.remarks.end());
    out.rounds += s.closed ? s.rounds : 0.0;
    out.broken_columns = out.broken_columns || s.broken;
  }
  out.remarks.insert(out.remarks.end(), remarks_.begin(), remarks_.end());
  return out;
}

Setting Analysis::setting_with(const VectorXd& amounts) const {
  Setting s = stated_;
  s.along = turning_road_;
  for (std::size_t k = 0; k < refit_.size(); ++k)
    inventory_.unknowns[refit_[k]].set(s, amounts[static_cast<Index>(k)]);
  auto at = static_cast<Index>(refit_.size());
  for (const Accepted& a : accepted_) {
    if (has_one_amount(a)) inventory_.unknowns[a.unknown].set(s, amounts[at++]);
    if (a.shapes.size() > 0) s.along.*inventory_.unknowns[a.unknown].profile = values_along(a);
  }
  return s;
}

void Analysis::weigh() {
  const VectorXd e =
      weight_.size() == 0 ? r_ : VectorXd(model().fitted.e.cwiseQuotient(weight_.cwiseMax(1e-12)));
  Noise noise = noise_of(rows_, e, training_);
  weight_ = std::move(noise.weight);
  sigma_ = noise.sigma;
  spread_ = noise.spread;
}

void Analysis::leave_exact_rows(MatrixXd& columns) const {
  auto everywhere = static_cast<Index>(refit_.size()), along = moves_.cols();
  for (const Accepted& a : accepted_) {
    const Index begin = has_one_amount(a) ? everywhere++ : along;
    const Index size =
        has_one_amount(a) ? std::min<Index>(1, moves_.cols() - begin) : a.columns.cols();
    along += a.columns.cols();
    for (Index i = 0; i < columns.rows() && a.kinematic; ++i)
      if (!relations()[rows_.row[static_cast<std::size_t>(i)].relation].sensors_only)
        columns.row(i).segment(begin, size).setZero();
  }
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
      m.precision[k] =
          1.0 / (width(static_cast<std::size_t>(k)) * width(static_cast<std::size_t>(k)));
      before[k] = amounts_[k];
    }
  Index at = moves_.cols();
  for (const Accepted& a : accepted_) {
    if (has_one_amount(a)) continue;
    x.middleCols(at, a.columns.cols()) = a.columns;
    m.precision.segment(at, a.columns.cols()) = a.precision;
    if (a.amounts.size() > 0) before.segment(at, a.columns.cols()) = a.amounts;
    at += a.columns.cols();
  }
  leave_exact_rows(x);
  m.fitted = fit(w.asDiagonal() * x, w.cwiseProduct(r_), m.precision, before);
  return m;
}

VectorXd Analysis::careful_weights(Stage stage) const {
  // Errors of the stated curves come back in every state and every lap: more rows do not make them
  // smaller, so that a relation with forces counts as no more than this many independent ones.
  std::array<double, kRelationCount> rows{};
  for (const Row& row : rows_.row) rows[row.relation] += 1;
  VectorXd w = weights(stage);
  for (Index i = 0; i < w.size(); ++i) {
    const std::size_t k = rows_.row[static_cast<std::size_t>(i)].relation;
    if (!relations()[k].sensors_only)
      w[i] *= std::sqrt(std::min(1.0, selection::kIndependentRows * spread_[k] / rows[k]));
  }
  return w;
}

VectorXd Analysis::weights(Stage stage) const {
  if (stage == Stage::kForces) return weight_;
  VectorXd w = weight_;
  for (Index i = 0; i < w.size(); ++i)
    if (!relations()[rows_.row[static_cast<std::size_t>(i)].relation].sensors_only) w[i] = 0.0;
  return w;
}

std::vector<const Unknown*> Analysis::free_unknowns() const {
  std::vector<const Unknown*> free;
  for (const std::size_t k : refit_) free.push_back(&inventory_.unknowns[k]);
  for (const Accepted& a : accepted_)
    if (has_one_amount(a)) free.push_back(&inventory_.unknowns[a.unknown]);
  return free;
}

void Analysis::update_moves(std::size_t from) {
  const std::vector<const Unknown*> free = free_unknowns();
  const std::vector<const Unknown*> wanted(free.begin() + static_cast<std::ptrdiff_t>(from),
                                           free.end());
  const MatrixXd columns = columns_of(wanted, "refit of the parameters");
  moves_.conservativeResize(columns.rows(), static_cast<Index>(free.size()));
  moves_.rightCols(columns.cols()) = columns;
}

void Analysis::widen_forms() {
  for (std::size_t k = 0; k < refit_.size(); ++k) {
    Unknown& u = inventory_.unknowns[refit_[k]];
    if (!u.by_curve_across) continue;
    // The amount that takes the place of a lateral force that is off by a share, everywhere.
    double both = 0.0, moved = 0.0;
    for (std::size_t i = 0; i < rows_.row.size(); ++i) {
      const double by_one = moves_(static_cast<Index>(i), static_cast<Index>(k));
      if (rows_.row[i].relation != kForceY || !training_[i] || !std::isfinite(rows_.row[i].ay))
        continue;
      const double off =
          selection::kCurveAcross + selection::kLostBySwing * rows_.row[i].pressed_swing;
      both += off * std::abs(by_one * rows_.row[i].ay);
      moved += by_one * by_one;
    }
    if (moved > 0) u.form = std::max(u.form, both / moved);
  }
}

void Analysis::move_amounts() {
  const std::vector<const Unknown*> free = free_unknowns();
  const Model m = careful_model();
  const VectorXd move = m.fitted.amount.head(moves_.cols());
  // No further than 1.5 prior widths at once: the relations are not linear in everything.
  for (Index k = 0; k < static_cast<Index>(refit_.size()); ++k) {
    const Unknown& u = *free[static_cast<std::size_t>(k)];
    const double most = 1.5 * std::min(width(static_cast<std::size_t>(k)), 2 * u.width);
    const double far = limit(u);
    amounts_[k] = std::clamp(amounts_[k] + std::clamp(move[k], -most, most), -far, far);
  }
  for (Index k = static_cast<Index>(refit_.size()); k < moves_.cols(); ++k) amounts_[k] += move[k];
  Index place = moves_.cols();
  for (Accepted& a : accepted_) {
    if (a.amounts.size() > 0) a.amounts += m.fitted.amount.segment(place, a.columns.cols());
    place += a.columns.cols();
  }
}

void Analysis::refit(int rounds) {
  // One Jacobian serves all rounds (chord method); only columns that are new are computed again.
  const bool fresh = moves_.size() == 0;
  const auto known = static_cast<std::size_t>(moves_.cols());
  look();
  if (fresh) {
    update_moves(0);
    widen_forms();
  } else if (known < free_unknowns().size()) {
    update_moves(known);
  }
  for (int round = 0; round < rounds; ++round) {
    if (weight_.size() == 0) weigh();
    move_amounts();
    look();
    weigh();
  }
  if (fresh) {
    find_what_fine_steps_add();
    look();
    update_moves(0);
  }
  // The amounts of accepted unknowns are where they are wanted.
  auto at = static_cast<Index>(refit_.size());
  for (Accepted& a : accepted_)
    if (has_one_amount(a)) a.amount = amounts_[at++];
}

void Analysis::move_columns() {
  if (freed_.empty() && accepted_.empty()) return;
  find_what_fine_steps_add();
  update_moves(0);
  refit(2);
}

void Analysis::differentiate_candidates() {
  std::vector<const Unknown*> wanted;
  for (const std::size_t k : candidate_) wanted.push_back(&inventory_.unknowns[k]);
  candidate_moves_ = columns_of(wanted, "one derivative per mechanism");
  careful_ = careful_weights();
}

bool Analysis::used(const Unknown& u) const {
  return settled(u) || std::any_of(accepted_.begin(), accepted_.end(), [&](const Accepted& a) {
           const Unknown& other = inventory_.unknowns[a.unknown];
           return std::tie(other.id, other.channel, other.name) ==
                  std::tie(u.id, u.channel, u.name);
         });
}

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

}  // namespace explain
