// Every lap predicted from the others: before, with the parameters refitted; after, with what was
// found.
#include <algorithm>
#include <cmath>

#include "analysis.h"
#include "base/random.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Errors of speed are gathered over this: two neighbouring means times their length.
constexpr double kMean_s = 0.3, kHorizon_s = 2 * kMean_s;

bool is_rate(Relation r) {
  return r == Relation::kForceX || r == Relation::kForceY || r == Relation::kMomentZ;
}

/// Squares of what is left, and of a trivial prediction.
struct Squares {
  std::vector<double> before, after, trivial;
};

double rms(const std::vector<double>& squares) {
  double sum = 0;
  for (const double z : squares) sum += z;
  return std::sqrt(sum / static_cast<double>(squares.size()));
}

/// How sure is the drop? Blocks of about 3 s drawn again and again.
void set_drop(HeldOut& h, const Squares& s, std::size_t size, unsigned long long seed) {
  const std::size_t blocks = (s.before.size() + size - 1) / size;
  base::Random dice(seed);
  std::vector<double> drops;
  for (int draw = 0; draw < 400; ++draw) {
    double b = 0, a = 0;
    for (std::size_t k = 0; k < blocks; ++k) {
      const auto block = static_cast<std::size_t>(dice.uniform() * static_cast<double>(blocks));
      for (std::size_t i = block * size; i < std::min(s.before.size(), (block + 1) * size); ++i)
        b += s.before[i], a += s.after[i];
    }
    drops.push_back(b > 0 ? 1.0 - std::sqrt(a / b) : 0.0);
  }
  std::sort(drops.begin(), drops.end());
  h.drop_low = drops[20];
  h.drop_high = drops[379];
}

/// A relation's rows one by one, each against that of the stated car without refit.
Squares squares_at_once(const std::vector<std::size_t>& rows, const VectorXd& before,
                        const VectorXd& after, const VectorXd& stated) {
  Squares s;
  for (const std::size_t row : rows) {
    const auto i = static_cast<Index>(row);
    s.before.push_back(before[i] * before[i]);
    s.after.push_back(after[i] * after[i]);
    s.trivial.push_back(stated[i] * stated[i]);
  }
  return s;
}

/// An acceleration over two neighbouring means: the error of a speed, against "nothing changes".
Squares squares_over_horizon(const std::vector<std::size_t>& rows, const VectorXd& before,
                             const VectorXd& after, const Rows& all,
                             const std::vector<Signals>& logs, Channel speed) {
  Squares s;
  std::ptrdiff_t last = -1;
  for (const std::size_t row : rows) {
    const Row& now = all.row[row];
    const auto i = static_cast<Index>(row);
    const Row* const then = last >= 0 ? &all.row[static_cast<std::size_t>(last)] : nullptr;
    if (then == nullptr || then->log != now.log ||
        !(std::abs(now.t_s - then->t_s - kMean_s) < 0.01)) {
      last = static_cast<std::ptrdiff_t>(row);
      continue;
    }
    const Signals& log = logs[now.log];
    const double b = kMean_s * (before[i] + before[last]);
    const double a = kMean_s * (after[i] + after[last]);
    const auto k0 = static_cast<std::size_t>(std::lround(then->t_s / Signals::kStep_s)) - 3;
    const std::size_t k1 = std::min(log.n - 1, k0 + 12);
    const double change = log.x[speed][k1] - log.x[speed][k0];
    if (std::isfinite(change)) {
      s.before.push_back(b * b);
      s.after.push_back(a * a);
      s.trivial.push_back(change * change);
    }
    last = -1;
  }
  return s;
}

}  // namespace

VectorXd Analysis::proof_weights() const {
  VectorXd w = weight_;
  if (options_.hold_out.empty()) return w;
  for (Index i = 0; i < w.size(); ++i) {
    if (training_[static_cast<std::size_t>(i)]) continue;
    const std::size_t relation = rows_.row[static_cast<std::size_t>(i)].relation;
    w[i] = sigma_[relation] > 0
               ? 1.0 / std::sqrt(sigma_[relation] * sigma_[relation] * spread_[relation])
               : 0.0;
  }
  return w;
}

Eigen::MatrixXd Analysis::all_moves(VectorXd& found) const {
  Index columns = moves_.cols();
  for (const Accepted& a : accepted_) columns += a.columns.cols();
  const auto p = static_cast<Index>(refit_.size());
  MatrixXd x(r_.size(), columns);
  found = VectorXd::Zero(columns);
  x.leftCols(moves_.cols()) = moves_;
  found.segment(p, moves_.cols() - p) = amounts_.tail(moves_.cols() - p);
  Index at = moves_.cols();
  for (const Accepted& a : accepted_) {
    if (has_one_amount(a)) continue;
    x.middleCols(at, a.columns.cols()) = a.columns;
    if (a.amounts.size() > 0) found.segment(at, a.columns.cols()) = a.amounts;
    at += a.columns.cols();
  }
  return x;
}

Analysis::Predicted Analysis::predicted() const {
  const Model m = model();
  const auto p = static_cast<Index>(refit_.size());
  Predicted out{m.fitted.e, m.fitted.e, proof_weights(),
                std::vector<bool>(rows_.row.size(), false)};
  const VectorXd& w = out.weight;
  const VectorXd inverse = w.unaryExpr([](double x) { return x > 0 ? 1 / x : 0.0; });
  // The rows without the findings: what the accepted amounts explain is put back.
  VectorXd r0 = r_;
  if (!accepted_.empty() || by_turning_) {
    Setting without = stated_;
    for (std::size_t k = 0; k < refit_.size(); ++k)
      inventory_.unknowns[refit_[k]].set(without, amounts_[static_cast<Index>(k)]);
    r0 = rows_at(without);
    for (const Accepted& a : accepted_)
      if (is_kinematic_stretch(a)) r0 += a.columns * a.amounts;
  }
  // Along the tangent at what was found: what acts by a cosine is not linear from nothing.
  VectorXd found;
  MatrixXd x = all_moves(found);
  const Index columns = x.cols();
  const VectorXd with_found = w.cwiseProduct(r_ + x * found);
  x = w.asDiagonal() * x;
  const VectorXd target = w.cwiseProduct(r0);
  // Whole laps in rotation, or the laps named.
  const bool in_turn = options_.hold_out.empty();
  std::vector<int> laps(options_.hold_out.begin(), options_.hold_out.end());
  for (int lap = 0; in_turn && lap < rows_.laps; ++lap) laps.push_back(lap);
  MatrixXd tells = x;
  leave_exact_rows(tells);
  for (const int lap : laps) {
    MatrixXd kept = tells;
    VectorXd y = target, y_found = with_found;
    for (Index i = 0; i < x.rows(); ++i) {
      const auto row = static_cast<std::size_t>(i);
      if (in_turn ? rows_.row[row].lap == lap : !training_[row])
        kept.row(i).setZero(), y[i] = y_found[i] = 0;
    }
    const Fitted with = fit(kept, y_found, m.precision, VectorXd::Zero(columns));
    const Fitted without = fit(kept.leftCols(p), y, m.precision.head(p), VectorXd::Zero(p));
    for (Index i = 0; i < x.rows(); ++i) {
      if (rows_.row[static_cast<std::size_t>(i)].lap != lap) continue;
      out.after[i] = inverse[i] * (with_found[i] - x.row(i).dot(with.amount));
      out.before[i] = inverse[i] * (target[i] - x.row(i).head(p).dot(without.amount));
      out.judged[static_cast<std::size_t>(i)] = true;
    }
  }
  return out;
}

std::optional<HeldOut> Analysis::held_out(Relation relation, const Predicted& p) const {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < rows_.row.size(); ++i)
    if (rows_.row[i].relation == relation && p.judged[i] && p.weight[static_cast<Index>(i)] > 0)
      rows.push_back(i);
  HeldOut h;
  h.channel = relations()[relation].name;
  h.unit = relations()[relation].unit;
  h.horizon_s = 0.0;
  Channel speed = kVx;
  if (relation == Relation::kForceX) h.channel = "vx_mps", h.unit = "m/s";
  if (relation == Relation::kForceY) h.channel = "vy_mps", h.unit = "m/s", speed = kVy;
  if (relation == Relation::kMomentZ)
    h.channel = "yaw_rate_radps", h.unit = "rad/s", speed = kYawRate;
  const bool rate = is_rate(relation);
  if (rate) h.horizon_s = kHorizon_s;
  const Squares s = rate ? squares_over_horizon(rows, p.before, p.after, rows_, logs_, speed)
                         : squares_at_once(rows, p.before, p.after, stated_rows_);
  if (s.before.size() < 30) return std::nullopt;
  h.rmse_before = rms(s.before);
  h.rmse_after = rms(s.after);
  h.trivial_rmse = rms(s.trivial);
  set_drop(h, s, rate ? 5 : 10, 4711 + relation);
  return h;
}

void Analysis::prove(Findings& out) const {
  const Predicted p = predicted();
  for (std::size_t relation = 0; relation < kRelationCount; ++relation) {
    if (const auto h = held_out(static_cast<Relation>(relation), p)) out.held_out.push_back(*h);
    // For the page.
    Trace t;
    t.channel = relations()[relation].name;
    t.unit = relations()[relation].unit;
    for (std::size_t i = 0; i < rows_.row.size(); ++i) {
      if (rows_.row[i].relation != relation || !p.judged[i]) continue;
      t.u_m.push_back(rows_.row[i].u_m);
      t.lap.push_back(rows_.row[i].lap);
      t.before.push_back(p.before[static_cast<Index>(i)]);
      t.after.push_back(p.after[static_cast<Index>(i)]);
    }
    if (!t.u_m.empty()) out.traces.push_back(std::move(t));
  }
  for (Finding& f : out.findings) f.held_out = out.held_out;
}

}  // namespace explain
