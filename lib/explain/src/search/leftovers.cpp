// What is left over: significant patterns along the road, over a regime or a lap, before and after.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis.h"
#include "places.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// What the patterns of structures() go over, in the order of their ids.
constexpr const char* kOver[] = {"u", "speed", "ax", "ay", "throttle", "brake", "lap"};
std::size_t relation_of(const Family& f) { return f.id / 10; }
std::size_t what_of(const Family& f) { return f.id % 10; }

/// Share of the nulls that reach as far.
double p_of(const Scan& s, double z) {
  const auto over = static_cast<double>(
      s.null_max.end() - std::lower_bound(s.null_max.begin(), s.null_max.end(), std::abs(z)));
  return (over + 1) / (static_cast<double>(s.null_max.size()) + 1);
}

/// Whether a row is in the stretch of cells that was found in a pattern.
bool is_inside(const Family& f, const Test& t, Index i) {
  const int cell = f.cell[static_cast<std::size_t>(i)];
  return f.column[i] != 0 && cell >= t.begin && cell < t.end;
}

}  // namespace

std::vector<Family> Analysis::structures() const {
  // Generic patterns in one relation: along u, over a regime, over time.
  std::vector<Family> out;
  for (std::size_t relation = 0; relation < kRelationCount; ++relation) {
    Family f;
    f.column = VectorXd::Zero(r_.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < rows_.row.size(); ++i)
      if (rows_.row[i].relation == relation)
        f.column[static_cast<Index>(i)] = weight_[static_cast<Index>(i)], ++count;
    if (count < 100 || f.column.squaredNorm() == 0) continue;
    const auto over = [&](std::size_t what, int cells, std::vector<int> lengths, auto place) {
      Family g = f;
      g.id = relation * 10 + what;
      g.cells = cells;
      g.lengths = std::move(lengths);
      g.cell.resize(rows_.row.size());
      for (std::size_t i = 0; i < rows_.row.size(); ++i)
        g.cell[i] = std::clamp(static_cast<int>(place(rows_.row[i])), 0, cells - 1);
      out.push_back(std::move(g));
    };
    over(0, cells_, {2, 4, 8, 16, 32}, [&](const Row& r) { return r.u_m / kCell_m; });
    over(1, 12, {1, 2, 4}, [](const Row& r) { return r.speed / 7.0; });
    over(2, 12, {1, 2, 4}, [](const Row& r) { return 6 + r.ax / 2.5; });
    over(3, 12, {1, 2, 4}, [](const Row& r) { return 6 + r.ay / 4.0; });
    if (std::isfinite(rows_.row.front().throttle))
      over(4, 6, {1, 2, 3},
           [](const Row& r) { return std::isfinite(r.throttle) ? r.throttle * 6 : 0.0; });
    over(5, 6, {1, 2, 3}, [](const Row& r) { return r.brake > 3e4 ? 1 + r.brake / 1e6 : 0.0; });
    const int laps = rows_.laps;
    if (laps > 1) over(6, laps, {1, 2, 4}, [](const Row& r) { return r.lap; });
  }
  return out;
}

Unexplained Analysis::leftover(const Fitted& m, const Family& f, const Test& t) const {
  const std::size_t relation = relation_of(f);
  Unexplained x;
  x.channel = relations()[relation].name;
  x.locked_to = kOver[what_of(f)];
  x.size = t.amount;
  x.unit = relations()[relation].unit;
  std::vector<double> u_m, energy;
  double sum = 0;
  for (Index i = 0; i < f.column.size(); ++i) {
    if (!is_inside(f, t, i)) continue;
    u_m.push_back(rows_.row[static_cast<std::size_t>(i)].u_m);
    energy.push_back(m.e[i] * m.e[i]);
    sum += energy.back();
  }
  if (what_of(f) == 0)
    x.where.push_back({t.begin * kCell_m, t.end * kCell_m, {}});
  else  // where on the road that regime is driven, weighed by what is left there
    x.where = concentrated(u_m, energy, logs_.front().length_m);
  // e is whitened for correlation too; undo it for a share of the plain residual.
  x.share = std::min(1.0, t.gain / std::max(1e-300, sum * spread_[relation]));
  return x;
}

Mismatch Analysis::mismatch(const Family& f, const Test& t, const VectorXd& residual) const {
  const std::size_t relation = relation_of(f);
  Mismatch x;
  x.channel = relations()[relation].name;
  x.unit = relations()[relation].unit;
  x.size = t.amount;
  double total = 0, speed = 0, ay = 0, ax = 0, count = 0;
  Place place{t.begin * kCell_m, t.end * kCell_m, {}};
  for (std::size_t i = 0; i < rows_.row.size(); ++i) {
    const Row& r = rows_.row[i];
    if (r.relation != relation) continue;
    total += residual[static_cast<Index>(i)] * residual[static_cast<Index>(i)];
    if (r.u_m < place.u_begin_m || r.u_m >= place.u_end_m) continue;
    speed += r.speed, ax += r.ax, ay += r.ay, count += 1;
    if (place.laps.empty() || place.laps.back() != r.lap) place.laps.push_back(r.lap);
  }
  if (count > 0)
    x.regime = fmt::format(
        "{:.0f} m/s, {}{}", speed / count,
        ax / count > 1.5    ? "accelerating"
        : ax / count < -1.5 ? "braking"
                            : "steady",
        std::abs(ay / count) > 3 ? (ay > 0 ? ", turning left" : ", turning right") : "");
  x.where.push_back(place);
  x.share_of_residual = total > 0 ? std::min(1.0, t.gain / total / spread_[relation]) : 0.0;
  return x;
}

void Analysis::find_mismatches(Findings& out, const std::vector<Family>& families) const {
  const VectorXd stated = weight_.cwiseProduct(stated_rows_);
  const Fitted raw =
      fit(MatrixXd::Zero(stated.size(), 1), stated, VectorXd::Ones(1), VectorXd::Zero(1));
  std::vector<Family> along;
  for (const Family& f : families)
    if (what_of(f) == 0) along.push_back(f);
  const Scan before = scan(raw, along, rows_, options_.nulls, raw.e);
  for (const Test& t : before.best) {
    const double p = p_of(before, t.z);
    if (p > selection::kMismatch) continue;
    out.mismatches.push_back(mismatch(along[t.family], t, raw.e));
    out.mismatches.back().p_adjusted = p;
  }
}

void Analysis::find_leftovers(Findings& out) const {
  const Model m = model();
  const std::vector<Family> families = structures();
  const Scan s = scan(m.fitted, families, rows_, options_.nulls, m.fitted.e);
  for (const Test& t : s.best) {
    const Family& f = families[t.family];
    if (std::abs(t.z) < s.threshold ||
        std::abs(t.amount) < selection::kLeastLeftover[relation_of(f)])
      continue;
    out.unexplained.push_back(leftover(m.fitted, f, t));
    out.unexplained.back().p_adjusted = p_of(s, t.z);
  }
  // The same patterns before anything was explained or refitted.
  find_mismatches(out, families);
}

}  // namespace explain
