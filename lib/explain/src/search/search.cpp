#include "search.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "base/random.h"
#include "selection.h"

namespace explain {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void steady(MatrixXd& normal) {
  normal.diagonal() = normal.diagonal() * (1 + 1e-9) + VectorXd::Constant(normal.rows(), 1e-12);
}

Fitted fit(const MatrixXd& x, const VectorXd& r, const VectorXd& precision,
           const VectorXd& before) {
  Fitted out;
  out.x = x;
  out.r = r;
  MatrixXd normal = MatrixXd::Zero(x.cols(), x.cols());
  normal.selfadjointView<Eigen::Lower>().rankUpdate(x.transpose());
  normal = normal.selfadjointView<Eigen::Lower>();
  normal.diagonal() += precision;
  steady(normal);
  out.normal.compute(normal);
  out.amount = out.normal.solve(x.transpose() * r - precision.cwiseProduct(before));
  out.e = r - x * out.amount;
  out.loss = out.e.squaredNorm() + precision.dot((before + out.amount).cwiseAbs2());
  return out;
}

MatrixXd held_too_near(const Fitted& model, const VectorXd& precision, const VectorXd& beyond) {
  // An amount that is one unit off pulls with the precision of its prior, and all amounts follow.
  const MatrixXd pulled = VectorXd(precision.cwiseProduct(beyond.cwiseSqrt())).asDiagonal();
  const MatrixXd moved = model.normal.solve(pulled);
  return moved * moved.transpose();
}

VectorXd beyond(const Fitted& model, const VectorXd& column) {
  return column - model.x * model.normal.solve(model.x.transpose() * column);
}

VectorXd within(const VectorXd& column, const std::vector<int>& cell, int begin, int end) {
  VectorXd out = column;
  for (Index i = 0; i < out.size() && !cell.empty(); ++i)
    if (const int here = cell[static_cast<std::size_t>(i)]; here < begin || here >= end)
      out[i] = 0.0;
  return out;
}

VectorXd without_what_stands_out(const Fitted& model, const std::vector<Family>& families,
                                 const Rows& rows) {
  Fitted left = model;
  for (int k = 0; k < selection::kMostFindings; ++k) {
    const Scan plain = scan(left, families, rows, 0, left.e);
    const auto best =
        std::max_element(plain.best.begin(), plain.best.end(),
                         [](const Test& a, const Test& b) { return a.gain < b.gain; });
    if (best == plain.best.end() || (k > 0 && std::abs(best->z) < selection::kPlanted)) break;
    const Family& f = families[best->family];
    left.e -= best->amount * beyond(model, within(f.column, f.cell, best->begin, best->end));
  }
  return left.e;
}

namespace {

/// Sums over the rows of each cell of a family: with the model's columns, of squares, with the
/// residual, and with the noise of each block.
struct Sums {
  int cells = 1;
  MatrixXd cx, cb;
  VectorXd cc, ce;
};

Sums sums_of(const Fitted& model, const Family& family, const Rows& rows, const VectorXd& noise) {
  const auto n = static_cast<Index>(rows.row.size());
  const Index p = model.x.cols(), blocks = rows.blocks;
  const int cells = family.cell.empty() ? 1 : family.cells;
  MatrixXd cx = MatrixXd::Zero(p, cells), cb = MatrixXd::Zero(cells, blocks);
  VectorXd cc = VectorXd::Zero(cells), ce = VectorXd::Zero(cells);
  for (Index i = 0; i < n; ++i) {
    const double c = family.column[i];
    if (c == 0.0) continue;
    const int cell = family.cell.empty() ? 0 : family.cell[static_cast<std::size_t>(i)];
    if (cell < 0) continue;
    cx.col(cell) += c * model.x.row(i).transpose();
    cc[cell] += c * c;
    ce[cell] += c * model.e[i];
    cb(cell, rows.row[static_cast<std::size_t>(i)].block) += c * noise[i];
  }
  return {cells, std::move(cx), std::move(cb), std::move(cc), std::move(ce)};
}

/// A run of cells; gain 0: none, or the model can do this already.
Test test_of(const Fitted& model, const Family& family, const Sums& sums, int begin, int end,
             VectorXd& taken) {
  Test test;
  test.begin = begin;
  test.end = end;
  double energy = 0, product = 0;
  VectorXd a = VectorXd::Zero(model.x.cols());
  for (int k = begin; k < end; ++k)
    energy += sums.cc[k], product += sums.ce[k], a += sums.cx.col(k);
  if (!(energy > 0)) return test;
  taken = model.normal.solve(a);
  const double left = energy - a.dot(taken);
  if (!(left > family.least_left * energy) || !(left > 1e-12)) return test;
  test.amount = product / left;
  test.z = product / std::sqrt(left);
  test.gain = test.z * test.z;
  return test;
}

/// The best of the runs whose ends lie within half a length of the best that was scanned: the
/// lengths that are scanned are few, and a run that is too long is weaker than what it holds.
Test with_better_ends(const Fitted& model, const Family& family, const Sums& sums,
                      const Test& scanned) {
  const int reach = (scanned.end - scanned.begin) / 2;
  VectorXd taken;
  Test best = scanned;
  for (int begin = std::max(0, scanned.begin - reach); begin < scanned.end; ++begin)
    for (int end = begin + 1; end <= std::min(sums.cells, scanned.end + reach); ++end) {
      const Test moved = test_of(model, family, sums, begin, end, taken);
      if (!(moved.gain > best.gain) || moved.amount * scanned.amount < 0) continue;
      std::tie(best.begin, best.end) = std::tie(begin, end);
      std::tie(best.amount, best.gain) = std::tie(moved.amount, moved.gain);
    }
  return best;
}

/// The tests of all runs of one length; what each block adds to the z of each goes to `shares`.
/// `block_x`: X'e of each block.
std::vector<Test> tests_of(const Fitted& model, const Family& family, std::size_t f,
                           const Sums& sums, int length, const MatrixXd& block_x,
                           std::vector<Eigen::VectorXf>& shares) {
  std::vector<Test> here;
  VectorXd taken;
  for (int begin = 0; begin + length <= sums.cells; begin += std::max(1, length / 2)) {
    Test test = test_of(model, family, sums, begin, begin + length, taken);
    if (test.gain == 0) continue;
    test.family = f;
    if (family.sign > 0 && test.amount < 0) test.gain = 0.0;
    here.push_back(test);
    VectorXd q = -(block_x.transpose() * taken);
    for (int k = begin; k < begin + length; ++k) q += sums.cb.row(k).transpose();
    shares.push_back((q * (test.amount / test.z)).cast<float>());
  }
  return here;
}

/// How wide z gets elsewhere on the road once the best is taken away: noise alone would make it 1.
double spread_elsewhere(const Fitted& model, const Family& family, const Test& best,
                        const std::vector<Test>& peers) {
  const auto n = static_cast<Index>(family.column.size());
  const int cells = family.cell.empty() ? 1 : family.cells;
  std::vector<double> elsewhere;
  if (!family.cell.empty() && best.gain > 0) {
    const VectorXd taken =
        best.amount * beyond(model, within(family.column, family.cell, best.begin, best.end));
    VectorXd ct = VectorXd::Zero(cells);
    for (Index i = 0; i < n; ++i)
      if (const int cell = family.cell[static_cast<std::size_t>(i)]; cell >= 0)
        ct[cell] += family.column[i] * taken[i];
    for (const Test& t : peers)
      if (const double root_left = t.z / t.amount;
          (t.end <= best.begin || t.begin >= best.end) && std::isfinite(root_left))
        elsewhere.push_back(std::abs(t.z - ct.segment(t.begin, t.end - t.begin).sum() / root_left));
  }
  double spread = 1.0;
  if (elsewhere.size() >= 8) {
    const auto middle = elsewhere.begin() + static_cast<std::ptrdiff_t>(elsewhere.size() / 2);
    std::nth_element(elsewhere.begin(), middle, elsewhere.end());
    spread = std::max(1.0, 1.4826 * *middle);
  }
  return spread;
}

/// Null: the same residuals with blocks turned round.
void draw_nulls(const std::vector<Eigen::VectorXf>& shares, Index blocks, std::size_t nulls,
                Scan& out) {
  const auto tests = static_cast<Index>(shares.size());
  if (tests == 0 || nulls == 0) return;
  Eigen::MatrixXf q(tests, blocks);
  for (Index k = 0; k < tests; ++k) q.row(k) = shares[static_cast<std::size_t>(k)].transpose();
  base::Random dice(20240607);
  constexpr std::size_t kAtOnce = 100;
  std::vector<double> drawn;
  for (std::size_t done = 0; done < 2 * nulls; done += kAtOnce) {
    const auto now = static_cast<Index>(std::min(kAtOnce, 2 * nulls - done));
    Eigen::MatrixXf signs(blocks, now);
    for (Index j = 0; j < now; ++j)
      for (Index b = 0; b < blocks; ++b) signs(b, j) = dice.uniform() < 0.5 ? -1.0f : 1.0f;
    const Eigen::MatrixXf z = q * signs;
    for (Index j = 0; j < now; ++j) drawn.push_back(z.col(j).cwiseAbs().maxCoeff());
  }
  // The first half sets the threshold, the second half says what it is worth.
  out.null_max.assign(drawn.begin(), drawn.begin() + static_cast<std::ptrdiff_t>(nulls));
  std::sort(out.null_max.begin(), out.null_max.end());
  out.threshold = out.null_max[static_cast<std::size_t>(
      selection::kNullQuantile * static_cast<double>(out.null_max.size() - 1))];
  double over = 0;
  for (std::size_t k = nulls; k < drawn.size(); ++k) over += drawn[k] > out.threshold ? 1 : 0;
  out.false_alarms = over / static_cast<double>(drawn.size() - nulls);
}

}  // namespace

Scan scan(const Fitted& model, const std::vector<Family>& families, const Rows& rows,
          std::size_t nulls, const VectorXd& noise) {
  const auto n = static_cast<Index>(rows.row.size());
  const Index blocks = rows.blocks;
  MatrixXd block_x = MatrixXd::Zero(model.x.cols(), blocks);
  for (Index i = 0; i < n; ++i)
    block_x.col(rows.row[static_cast<std::size_t>(i)].block) +=
        noise[i] * model.x.row(i).transpose();

  Scan out;
  std::vector<Eigen::VectorXf> shares;
  for (std::size_t f = 0; f < families.size(); ++f) {
    const Family& family = families[f];
    const Sums sums = sums_of(model, family, rows, noise);
    Test best;
    best.family = f;
    std::vector<Test> peers;
    const std::vector<int> whole{sums.cells};
    for (const int length : family.cell.empty() ? whole : family.lengths) {
      if (length > sums.cells) continue;
      const std::vector<Test> here = tests_of(model, family, f, sums, length, block_x, shares);
      for (const Test& t : here)
        if (t.gain > best.gain) best = t, peers = here;
    }
    best.local_z = best.z / spread_elsewhere(model, family, best, peers);
    if (!family.cell.empty() && best.gain > 0) best = with_better_ends(model, family, sums, best);
    out.best.push_back(best);
  }
  draw_nulls(shares, blocks, nulls, out);
  return out;
}

std::vector<double> cross_validate(const Fitted& model, const MatrixXd& more,
                                   const VectorXd& precision, const VectorXd& more_precision,
                                   const Rows& rows) {
  const Index p = model.x.cols(), q = more.cols(), all = p + q;
  const auto folds = static_cast<std::size_t>(rows.folds);
  std::vector<MatrixXd> normal(folds, MatrixXd::Zero(all, all));
  std::vector<VectorXd> right(folds, VectorXd::Zero(all));
  std::vector<std::vector<Index>> members(folds);
  // Of laps that are held out: their nothing would count as scatter of the gain.
  std::vector<bool> without_weight(folds);
  for (Index i = 0; i < model.x.rows(); ++i)
    members[static_cast<std::size_t>(rows.row[static_cast<std::size_t>(i)].fold)].push_back(i);
  MatrixXd sum = MatrixXd::Zero(all, all);
  VectorXd sum_right = VectorXd::Zero(all);
  for (std::size_t f = 0; f < folds; ++f) {
    MatrixXd part(static_cast<Index>(members[f].size()), all);
    VectorXd r(part.rows());
    for (Index k = 0; k < part.rows(); ++k) {
      const Index i = members[f][static_cast<std::size_t>(k)];
      part.row(k).head(p) = model.x.row(i);
      part.row(k).tail(q) = more.row(i);
      r[k] = model.r[i];
    }
    without_weight[f] = r.isZero(0.0);
    normal[f].noalias() = part.transpose() * part;
    right[f].noalias() = part.transpose() * r;
    sum += normal[f];
    sum_right += right[f];
  }
  std::vector<double> out;
  VectorXd lambda(all);
  lambda.head(p) = precision;
  lambda.tail(q) = more_precision;
  for (std::size_t f = 0; f < folds; ++f) {
    if (without_weight[f]) continue;
    MatrixXd a = sum - normal[f];
    const VectorXd b = sum_right - right[f];
    a.diagonal() += lambda;
    steady(a);
    const VectorXd with = a.ldlt().solve(b);
    VectorXd without = VectorXd::Zero(all);
    without.head(p) = a.topLeftCorner(p, p).ldlt().solve(b.head(p));
    const auto loss = [&](const VectorXd& x) { return x.dot(normal[f] * x) - 2 * x.dot(right[f]); };
    out.push_back(loss(without) - loss(with));
  }
  return out;
}

}  // namespace explain
