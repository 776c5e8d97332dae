// What an analysis reports once its model stands: sizes with intervals, what is left, held-out laps.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis.h"
#include "road_profiles.h"
#include "places.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Below these a leftover is of no use to anyone who drives or tunes: in the relation's unit.
constexpr std::array<double, kRelationCount> kLeast{0.004, 0.004, 0.08, 0.2, 0.5, 0.12, 0.15, 0.3, 0.25, 0.4, 0.3, 0.4, 0.4, 0.4, 0.001, 0.01, 3e4};

/// Standard deviations by which a parameter must lie beyond its prior width to be a finding: on 599 trial
/// recordings 18 false ones and 3 right ones lay between 1.6 and this.
constexpr double kBeyond = 2.2;

}  // namespace

void Analysis::describe(Findings& out) const {
  const Model m = model();
  const MatrixXd covariance = m.fitted.normal.solve(MatrixXd::Identity(m.fitted.x.cols(), m.fitted.x.cols()));
  constexpr double k90 = 1.645;
  // What is wrong with the curves comes back at the same places every lap: the spread of a parameter
  // is that between stretches of road, where it is larger than that of the noise.
  const Index columns = m.fitted.x.cols();
  MatrixXd pull = MatrixXd::Zero(columns, stretches());
  for (Index i = 0; i < m.fitted.e.size(); ++i) pull.col(stretch(rows_.row[static_cast<std::size_t>(i)])) += m.fitted.e[i] * m.fitted.x.row(i).transpose();
  const MatrixXd influence = m.fitted.normal.solve(pull);
  const VectorXd spread = influence.rowwise().squaredNorm();
  const Model careful = careful_model();
  const MatrixXd careful_covariance = careful.fitted.normal.solve(MatrixXd::Identity(m.fitted.x.cols(), m.fitted.x.cols()));
  const auto deviation = [&](Index j) { return std::sqrt(std::max({0.0, covariance(j, j), spread[j]})); };
  std::vector<std::pair<std::ptrdiff_t, Finding>> named;
  for (std::size_t k = 0; k < refit_.size(); ++k) {
    const Unknown& u = inventory_.unknowns[refit_[k]];
    if (u.role != Role::kParameter) continue;
    const auto i = static_cast<Index>(k);
    const double value = u.stated + amounts_[i], half = k90 * std::hypot(std::sqrt(std::max(0.0, careful_covariance(i, i))), u.form);
    ParameterValue p{u.id, u.name, u.unit, u.stated, value, value - half, value + half, false, false};
    p.at_limit = !u.assumed && std::abs(amounts_[i]) > 0.99 * limit(u);
    if (std::abs(amounts_[i]) > 0.99 * limit(u))
      out.remarks.push_back(fmt::format("{}: the refit runs into its limit at {:.4g} {}; these recordings do not determine it", u.name, value, u.unit));
    p.beyond_prior = !p.at_limit && std::abs(amounts_[i]) - kBeyond / k90 * half > u.width;
    const auto let_go = std::find_if(freed_.begin(), freed_.end(), [&](const Freed& f) { return f.place == k; });
    p.beyond_prior = p.beyond_prior && !u.assumed;
    out.parameters.push_back(p);
    if (!p.beyond_prior || let_go == freed_.end()) continue;
    Finding f;
    f.unknown = refit_[k];
    f.mechanism = u.id;
    f.kind = u.kind;
    f.physics = u.physics;
    f.equation = u.equation;
    f.parameters.push_back({u.name, u.unit, value, value - half, value + half});
    f.statistic = amounts_[i] / std::max(1e-300, half / k90);
    f.stability = 1.0;
    for (const std::size_t rival : let_go->rivals) {
      const Unknown& other = inventory_.unknowns[refit_[rival]];
      if (other.id != u.id) f.rivals.push_back({other.id, "", "vary speed, load and throttle independently: coast down, and hold constant speeds", 0.0, false});
    }
    // Another parameter that does nearly the same: what is left of this column without it.
    for (std::size_t o = 0; o < refit_.size(); ++o) {
      const Unknown& other = inventory_.unknowns[refit_[o]];
      if (o == k || other.role != Role::kParameter) continue;
      const auto j = static_cast<Index>(o);
      const double correlation = covariance(i, j) / std::sqrt(std::max(1e-300, covariance(i, i) * covariance(j, j)));
      if (std::abs(correlation) < 0.9) continue;
      f.rivals.push_back({other.id, "", "vary speed, load and throttle independently: coast down, and hold constant speeds", 0.0, std::abs(correlation) < 0.95});
    }
    named.emplace_back(let_go - freed_.begin(), std::move(f));
  }
  // What cost most comes first.
  std::stable_sort(named.begin(), named.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (auto& [place, f] : named) out.findings.push_back(std::move(f));
  Index everywhere = static_cast<Index>(refit_.size()), cell_column = moves_.cols();
  std::size_t at = 0;
  for (const Accepted& a : accepted_) {
    Finding& f = out.findings[at++];
    const Unknown& u = inventory_.unknowns[a.unknown];
    if (has_one_amount(a)) {
      const double careful_deviation = a.by_cost ? std::sqrt(std::max(0.0, careful_covariance(everywhere, everywhere))) : 0.0;
      const double half = k90 * std::max(careful_deviation, std::hypot(deviation(everywhere), 0.25 * u.least));
      const double value = amounts_[everywhere];
      f.parameters.push_back({u.name, u.unit, value, value - half, value + half});
      for (const auto& [name, held] : u.constants)
        f.parameters.push_back({name, std::string(vehicle::parameter_list()[static_cast<std::size_t>(*vehicle::find_parameter(name))].unit), held, held, held});
      std::vector<double> u_m, energy;
      for (Index i = 0; i < m.fitted.e.size(); ++i) {
        const double part = m.fitted.x(i, everywhere) * value;
        u_m.push_back(rows_.row[static_cast<std::size_t>(i)].u_m);
        energy.push_back(part * part);
      }
      if (u.kind == "vehicle") f.where = concentrated(u_m, energy, logs_.front().length_m);
      ++everywhere;
    } else if (a.shapes.size() > 0) {
      const Index size = a.columns.cols();
      describe_profile(f, u, a, a.amounts + careful.fitted.amount.segment(cell_column, size),
                       careful_covariance.block(cell_column, cell_column, size, size),
                       logs_.front().length_m, logs_.front().closed);
      cell_column += size;
    } else {
      double mean = 0, count = 0;
      for (std::size_t k = 0; k < a.cells.size(); ++k) {
        const Index j = cell_column + static_cast<Index>(k);
        const double half = k90 * std::sqrt(std::max(0.0, covariance(j, j)));
        const double u_m = (a.cells[k] + 0.5) * kCell_m;
        f.profile.push_back({u_m, m.fitted.amount[j], half});
        if (u_m > f.where.front().u_begin_m && u_m < f.where.front().u_end_m) mean += m.fitted.amount[j], count += 1;
      }
      const double variance = [&] {
        double sum = 0;
        for (std::size_t k = 0; k < a.cells.size(); ++k)
          for (std::size_t l = 0; l < a.cells.size(); ++l)
            if (a.cells[k] * kCell_m >= f.where.front().u_begin_m && (a.cells[k] + 1) * kCell_m <= f.where.front().u_end_m &&
                a.cells[l] * kCell_m >= f.where.front().u_begin_m && (a.cells[l] + 1) * kCell_m <= f.where.front().u_end_m)
              sum += covariance(cell_column + static_cast<Index>(k), cell_column + static_cast<Index>(l));
        return sum / std::max(1.0, count * count);
      }();
      const double half = k90 * std::sqrt(std::max(0.0, variance));
      mean /= std::max(1.0, count);
      f.parameters.push_back({u.name + ", mean over the stretch", u.unit, mean, mean - half, mean + half});
      cell_column += a.columns.cols();
    }
  }
}

std::vector<Family> Analysis::structures() const {
  // Generic patterns in one relation: along u, over a regime, over time.
  std::vector<Family> out;
  for (std::size_t relation = 0; relation < kRelationCount; ++relation) {
    Family f;
    f.column = VectorXd::Zero(r_.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < rows_.row.size(); ++i)
      if (rows_.row[i].relation == relation) f.column[static_cast<Index>(i)] = weight_[static_cast<Index>(i)], ++count;
    if (count < 100 || f.column.squaredNorm() == 0) continue;
    const auto over = [&](std::size_t what, int cells, std::vector<int> lengths, auto place) {
      Family g = f;
      g.id = relation * 10 + what;
      g.cells = cells;
      g.lengths = std::move(lengths);
      g.cell.resize(rows_.row.size());
      for (std::size_t i = 0; i < rows_.row.size(); ++i) g.cell[i] = std::clamp(static_cast<int>(place(rows_.row[i])), 0, cells - 1);
      out.push_back(std::move(g));
    };
    over(0, cells_, {2, 4, 8, 16, 32}, [&](const Row& r) { return r.u_m / kCell_m; });
    over(1, 12, {1, 2, 4}, [](const Row& r) { return r.speed / 7.0; });
    over(2, 12, {1, 2, 4}, [](const Row& r) { return 6 + r.ax / 2.5; });
    over(3, 12, {1, 2, 4}, [](const Row& r) { return 6 + r.ay / 4.0; });
    if (std::isfinite(rows_.row.front().throttle)) over(4, 6, {1, 2, 3}, [](const Row& r) { return std::isfinite(r.throttle) ? r.throttle * 6 : 0.0; });
    over(5, 6, {1, 2, 3}, [](const Row& r) { return r.brake > 3e4 ? 1 + r.brake / 1e6 : 0.0; });
    const int laps = rows_.laps;
    if (laps > 1) over(6, laps, {1, 2, 4}, [](const Row& r) { return r.lap; });
  }
  return out;
}

void Analysis::leftovers(Findings& out) {
  static constexpr const char* kOver[] = {"u", "speed", "ax", "ay", "throttle", "brake", "lap"};
  const Model m = model();
  const std::vector<Family> families = structures();
  const Scan s = scan(m.fitted, families, rows_, options_.nulls, m.fitted.e);
  const auto p_of = [&](double z) {
    const auto over = static_cast<double>(s.null_max.end() - std::lower_bound(s.null_max.begin(), s.null_max.end(), std::abs(z)));
    return (over + 1) / (static_cast<double>(s.null_max.size()) + 1);
  };
  const auto local_share = [&](const Test& t) {
    const Family& f = families[t.family];
    double energy = 0;
    for (Index i = 0; i < f.column.size(); ++i) {
      const int cell = f.cell[static_cast<std::size_t>(i)];
      if (f.column[i] != 0 && cell >= t.begin && cell < t.end) energy += m.fitted.e[i] * m.fitted.e[i];
    }
    // e is whitened for correlation too; undo it for a share of the plain residual.
    return std::min(1.0, t.gain / std::max(1e-300, energy * spread_[families[t.family].id / 10]));
  };
  for (const Test& t : s.best) {
    if (std::abs(t.z) < s.threshold) continue;
    const std::size_t relation = families[t.family].id / 10, what = families[t.family].id % 10;
    if (std::abs(t.amount) < kLeast[relation]) continue;
    Unexplained x;
    x.channel = relations()[relation].name;
    x.locked_to = kOver[what];
    x.size = t.amount;
    x.unit = relations()[relation].unit;
    if (what == 0) {
      x.where.push_back({t.begin * kCell_m, t.end * kCell_m, {}});
    } else {
      // Where on the road that regime is driven, weighed by what is left there.
      const Family& f = families[t.family];
      std::vector<double> u_m, energy;
      for (Index i = 0; i < f.column.size(); ++i)
        if (const int cell = f.cell[static_cast<std::size_t>(i)]; f.column[i] != 0 && cell >= t.begin && cell < t.end) {
          u_m.push_back(rows_.row[static_cast<std::size_t>(i)].u_m);
          energy.push_back(m.fitted.e[i] * m.fitted.e[i]);
        }
      x.where = concentrated(u_m, energy, logs_.front().length_m);
    }
    x.share = local_share(t);
    x.p_adjusted = p_of(t.z);
    out.unexplained.push_back(x);
  }
  // Mismatches: the same patterns before anything was explained, parameters refitted or not.
  Fitted raw = m.fitted;
  const VectorXd stated = weight_.cwiseProduct(stated_rows_);
  raw.x = MatrixXd::Zero(stated.size(), 1);
  raw = fit(raw.x, stated, VectorXd::Ones(1), VectorXd::Zero(1));
  std::vector<Family> along;
  for (const Family& f : families) if (f.id % 10 == 0) along.push_back(f);
  const Scan before = scan(raw, along, rows_, options_.nulls, raw.e);
  for (const Test& t : before.best) {
    const std::size_t relation = along[t.family].id / 10;
    const auto over = static_cast<double>(before.null_max.end() - std::lower_bound(before.null_max.begin(), before.null_max.end(), std::abs(t.z)));
    const double p = (over + 1) / (static_cast<double>(before.null_max.size()) + 1);
    if (p > 0.05) continue;
    Mismatch x;
    x.channel = relations()[relation].name;
    x.unit = relations()[relation].unit;
    x.size = t.amount;
    x.p_adjusted = p;
    double total = 0, speed = 0, ay = 0, ax = 0, count = 0;
    Place place{t.begin * kCell_m, t.end * kCell_m, {}};
    for (std::size_t i = 0; i < rows_.row.size(); ++i) {
      const Row& r = rows_.row[i];
      if (r.relation != relation) continue;
      total += raw.e[static_cast<Index>(i)] * raw.e[static_cast<Index>(i)];
      if (r.u_m < place.u_begin_m || r.u_m >= place.u_end_m) continue;
      speed += r.speed, ax += r.ax, ay += r.ay, count += 1;
      if (place.laps.empty() || place.laps.back() != r.lap) place.laps.push_back(r.lap);
    }
    if (count > 0)
      x.regime = fmt::format("{:.0f} m/s, {}{}", speed / count, ax / count > 1.5 ? "accelerating" : ax / count < -1.5 ? "braking" : "steady",
                             std::abs(ay / count) > 3 ? (ay > 0 ? ", turning left" : ", turning right") : "");
    x.where.push_back(place);
    x.share_of_residual = total > 0 ? std::min(1.0, t.gain / total / spread_[relation]) : 0.0;
    out.mismatches.push_back(x);
  }
}

void Analysis::prove(Findings& out) {
  const Model m = model();
  // Columns of the findings: those behind the refitted parameters.
  const auto p = static_cast<Index>(refit_.size());
  const Index q = m.fitted.x.cols() - p;
  VectorXd before_e = m.fitted.e, after_e = m.fitted.e;
  // The rows without the findings: what the accepted amounts explain is put back.
  VectorXd r0 = r_;
  if (!accepted_.empty()) {
    Setting without = stated_;
    for (std::size_t k = 0; k < refit_.size(); ++k) inventory_.unknowns[refit_[k]].set(without, amounts_[static_cast<Index>(k)]);
    r0 = rows_at(without);
  }
  // Whole laps in rotation, or the laps named.
  std::vector<int> laps;
  if (options_.hold_out.empty())
    for (int lap = 0; lap < rows_.laps; ++lap) laps.push_back(lap);
  else laps.assign(options_.hold_out.begin(), options_.hold_out.end());
  VectorXd w = weight_;
  if (!options_.hold_out.empty())
    for (Index i = 0; i < w.size(); ++i)
      if (!training_[static_cast<std::size_t>(i)]) {
        const std::size_t relation = rows_.row[static_cast<std::size_t>(i)].relation;
        w[i] = sigma_[relation] > 0 ? 1.0 / std::sqrt(sigma_[relation] * sigma_[relation] * spread_[relation]) : 0.0;
      }
  const VectorXd inverse = w.unaryExpr([](double x) { return x > 0 ? 1 / x : 0.0; });
  MatrixXd x(r_.size(), p + q);
  x.leftCols(moves_.cols()) = moves_;
  Index at = moves_.cols();
  for (const Accepted& a : accepted_) {
    if (has_one_amount(a)) continue;
    x.middleCols(at, a.columns.cols()) = a.columns;
    at += a.columns.cols();
  }
  // Along the tangent at what was found: what acts by a cosine is not linear from nothing.
  VectorXd found = VectorXd::Zero(x.cols());
  found.segment(p, moves_.cols() - p) = amounts_.tail(moves_.cols() - p);
  at = moves_.cols();
  for (const Accepted& a : accepted_) {
    if (a.shapes.size() > 0) found.segment(at, a.columns.cols()) = a.amounts;
    at += a.columns.cols();
  }
  const VectorXd with_found = w.cwiseProduct(r_ + x * found);
  x = w.asDiagonal() * x;
  const VectorXd target = w.cwiseProduct(r0);
  std::vector<bool> judged(rows_.row.size(), false);
  for (const int lap : laps) {
    MatrixXd normal = MatrixXd::Zero(p + q, p + q);
    MatrixXd kept = x;
    VectorXd y = target, y_found = with_found;
    for (Index i = 0; i < x.rows(); ++i) {
      const Row& row = rows_.row[static_cast<std::size_t>(i)];
      const bool out_of_it = options_.hold_out.empty() ? row.lap == lap : !training_[static_cast<std::size_t>(i)];
      if (out_of_it) kept.row(i).setZero(), y[i] = y_found[i] = 0;
    }
    const Fitted with = fit(kept, y_found, m.precision, VectorXd::Zero(p + q));
    const Fitted without = fit(kept.leftCols(p), y, m.precision.head(p), VectorXd::Zero(p));
    for (Index i = 0; i < x.rows(); ++i) {
      if (rows_.row[static_cast<std::size_t>(i)].lap != lap) continue;
      after_e[i] = inverse[i] * (with_found[i] - x.row(i).dot(with.amount));
      before_e[i] = inverse[i] * (target[i] - x.row(i).head(p).dot(without.amount));
      judged[static_cast<std::size_t>(i)] = true;
    }
    if (!options_.hold_out.empty() && laps.size() > 1) continue;
  }
  // Errors of speed gathered over 0.6 s: two neighbouring means times their length.
  constexpr double kHorizon_s = 0.6;
  struct Gather { const char* channel; const char* unit; Relation relation; };
  std::vector<HeldOut> proof;
  for (std::size_t relation = 0; relation < kRelationCount; ++relation) {
    const bool rate = relation == Relation::kForceX || relation == Relation::kForceY || relation == Relation::kMomentZ;
    std::vector<double> drop, before2, after2, trivial2;
    std::ptrdiff_t last = -1;
    double spare_t = 0;
    for (std::size_t i = 0; i < rows_.row.size(); ++i) {
      const Row& row = rows_.row[i];
      if (row.relation != relation || !judged[i] || !(w[static_cast<Index>(i)] > 0)) continue;
      const Signals& s = logs_[row.log];
      if (!rate) {
        before2.push_back(before_e[static_cast<Index>(i)] * before_e[static_cast<Index>(i)]);
        after2.push_back(after_e[static_cast<Index>(i)] * after_e[static_cast<Index>(i)]);
        trivial2.push_back(stated_rows_[static_cast<Index>(i)] * stated_rows_[static_cast<Index>(i)]);
        drop.push_back(before2.back() - after2.back());
        continue;
      }
      if (last >= 0 && rows_.row[static_cast<std::size_t>(last)].log == row.log && std::abs(row.t_s - spare_t - 0.3) < 0.01) {
        const double b = 0.3 * (before_e[static_cast<Index>(i)] + before_e[last]), a = 0.3 * (after_e[static_cast<Index>(i)] + after_e[last]);
        const auto k0 = static_cast<std::size_t>(std::lround(spare_t / Signals::kStep_s)) - 3;
        const std::size_t k1 = std::min(s.n - 1, k0 + 12);
        const Channel c = relation == Relation::kForceX ? kVx : relation == Relation::kForceY ? kVy : kYawRate;
        const double change = s.x[c][k1] - s.x[c][k0];  // "nothing changes in 0.6 s"
        if (std::isfinite(change)) {
          before2.push_back(b * b);
          after2.push_back(a * a);
          trivial2.push_back(change * change);
          drop.push_back(b * b - a * a);
        }
        last = -1;
        continue;
      }
      last = static_cast<std::ptrdiff_t>(i);
      spare_t = row.t_s;
    }
    if (before2.size() < 30) continue;
    const auto rms = [](const std::vector<double>& v) {
      double sum = 0;
      for (const double z : v) sum += z;
      return std::sqrt(sum / static_cast<double>(v.size()));
    };
    HeldOut h;
    static constexpr const char* kNames[] = {"vx_mps", "vy_mps", "yaw_rate_radps"};
    static constexpr const char* kUnits[] = {"m/s", "m/s", "rad/s"};
    if (rate) {
      h.channel = kNames[relation - Relation::kForceX];
      h.unit = kUnits[relation - Relation::kForceX];
      h.horizon_s = kHorizon_s;
    } else {
      h.channel = relations()[relation].name;
      h.unit = relations()[relation].unit;
      h.horizon_s = 0.0;
    }
    h.rmse_before = rms(before2);
    h.rmse_after = rms(after2);
    h.trivial_rmse = rms(trivial2);
    // Blocks of about 3 s drawn again and again: how sure is the drop?
    const std::size_t size = rate ? 5 : 10, blocks = (before2.size() + size - 1) / size;
    Dice dice{4711 + relation};
    std::vector<double> drops;
    for (int draw = 0; draw < 400; ++draw) {
      double b = 0, a = 0;
      for (std::size_t k = 0; k < blocks; ++k) {
        const auto block = static_cast<std::size_t>(dice.roll() * static_cast<double>(blocks));
        for (std::size_t i = block * size; i < std::min(before2.size(), (block + 1) * size); ++i) b += before2[i], a += after2[i];
      }
      drops.push_back(b > 0 ? 1.0 - std::sqrt(a / b) : 0.0);
    }
    std::sort(drops.begin(), drops.end());
    h.drop_low = drops[20];
    h.drop_high = drops[379];
    proof.push_back(h);
  }
  out.held_out = proof;
  for (Finding& f : out.findings) f.held_out = proof;
  // For the page.
  for (std::size_t relation = 0; relation < kRelationCount; ++relation) {
    Trace t;
    t.channel = relations()[relation].name;
    t.unit = relations()[relation].unit;
    for (std::size_t i = 0; i < rows_.row.size(); ++i) {
      if (rows_.row[i].relation != relation || !judged[i]) continue;
      t.u_m.push_back(rows_.row[i].u_m);
      t.lap.push_back(rows_.row[i].lap);
      t.before.push_back(before_e[static_cast<Index>(i)]);
      t.after.push_back(after_e[static_cast<Index>(i)]);
    }
    if (!t.u_m.empty()) out.traces.push_back(std::move(t));
  }
}

}  // namespace explain
