#include "joint.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/statistics.h"

namespace cloud {
namespace {

constexpr double kGradientReach_m = 0.25;
// A cell's mean: noise of single heights, and what does not average out (footprint, place of the
// points in the cell). Only their ratio matters: the scale is measured.
constexpr double kPointNoise_m = 0.002, kCellNoise_m = 0.0004;

}  // namespace

JointProblem::JointProblem(const Sections& sections, const RoadFrame& frame,
                           const MapOptions& options, std::vector<Correction> before)
    : sections_(sections), frame_(frame), options_(options), before_(std::move(before)) {
  if (before_.empty()) before_.assign(sections.list.size(), Correction::Zero());
  along_ = std::max<std::size_t>(1, static_cast<std::size_t>(frame.length_m() / kSectionCell_m));
  cell_rows_ = static_cast<double>(frame.rows() - 1) / static_cast<double>(along_);
  across_ =
      static_cast<std::size_t>((frame.v_m().back() - frame.v_m().front()) / kSectionCell_m) + 1;
  rows_per_stretch_ = static_cast<std::size_t>(kStretch_m / kSectionCell_m + 0.5);
  stretches_ = (along_ + rows_per_stretch_ - 1) / rows_per_stretch_;
  first_.assign(1, 0);
  for (const Section& section : sections.list)
    first_.push_back(first_.back() + section.cells.size());
  views_.resize(first_.back());
  cells_.resize(along_ * across_);
  nodes_.resize(2 * stretches_ + 1);
  // Those of a place stand together: passes that see each other, and the nodes there.
  std::vector<std::uint32_t> block_of;
  for (const Section& section : sections.list) {
    const double stretch = section.row / cell_rows_ / static_cast<double>(rows_per_stretch_);
    block_of.insert(
        block_of.end(), 6,
        static_cast<std::uint32_t>(std::clamp(stretch, 0.0, static_cast<double>(stretches_ - 1))));
  }
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    block_of.insert(block_of.end(), 2, static_cast<std::uint32_t>(std::min(k / 2, stretches_ - 1)));
  block_of.push_back(static_cast<std::uint32_t>(stretches_));  // the common slope
  matrix_ = BlockMatrix(block_of);
}

double JointProblem::even_error(std::size_t cell) const {
  const CellNodes at = nodes_of(cell);
  return (1.0 - at.share) * (nodes_[at.before].height_m + at.v_m * nodes_[at.before].slope) +
         at.share * (nodes_[at.after].height_m + at.v_m * nodes_[at.after].slope);
}

Eigen::Vector4d JointProblem::within_cell(const View& view, const CellNodes& nodes) {
  const auto on = static_cast<double>(view.on), beside = static_cast<double>(view.beside_m),
             there = nodes.v_m + beside;
  return {-on, (1.0 - nodes.share) * beside - on * there, on, nodes.share * beside + on * there};
}

void JointProblem::linearise(std::size_t s, const std::vector<Correction>& at) {
  const Section& section = sections_.list[s];
  const Mover move(sections_, at, s);
  double near = section.row;  // the cells follow each other along the road
  for (std::size_t k = 0; k < section.cells.size(); ++k) {
    const SectionCell& cell = section.cells[k];
    View& view = views_[first_[s] + k];
    view.cell = View::kNone, view.section = static_cast<std::uint32_t>(s);
    if (cell.beyond || cell.beside || cell.apart) continue;
    const Eigen::Vector3d p = move(cell);
    const std::optional<GridPlace> place = frame_.project(p.x(), p.y(), near);
    if (!place) continue;
    near = place->row;
    const double a = place->row / cell_rows_,
                 b = (place->v_m - frame_.v_m().front()) / kSectionCell_m;
    if (!(a >= 0.0 && b >= 0.0 && b < static_cast<double>(across_))) continue;
    const double base =
        frame_.height(*place) + crown_ * std::min(std::abs(place->v_m), crown_out_m_);
    Eigen::Vector2d g = frame_.gradient(*place, kGradientReach_m);
    if (!std::isfinite(base) || !g.allFinite() || g.norm() > 0.5) continue;
    const std::size_t i = std::min(static_cast<std::size_t>(a), along_ - 1),
                      j = static_cast<std::size_t>(b);
    // Where the road has another shape than the base, its cells have a slope of their own: views
    // stand for the middle of the cell.
    const Eigen::Vector2d slope = slope_of(i, j);
    const double on = a - static_cast<double>(i) - 0.5, beside = b - static_cast<double>(j) - 0.5;
    const double beyond = (slope.x() * on + slope.y() * beside) * kSectionCell_m;
    view.beside_m = view.on = 0.0f;
    if (fine_) {
      view.beside_m = static_cast<float>(beside * kSectionCell_m);
      view.on = static_cast<float>(on / (0.5 * static_cast<double>(rows_per_stretch_)));
    }
    const Eigen::Vector2d ahead = frame_.ahead(place->row);
    g += slope.x() * ahead +
         (slope.y() +
          (std::abs(place->v_m) < crown_out_m_ ? std::copysign(crown_, place->v_m) : 0.0) +
          (fine_ ? even_slope(i) : 0.0)) *
             Eigen::Vector2d(-ahead.y(), ahead.x());
    const Eigen::Vector3d normal(-g.x(), -g.y(), 1.0),
        arm = p - section.position_m - at[s].head<3>();
    const Eigen::Vector3d moment = arm.cross(normal);
    const Eigen::Vector3d turn = section.axes.transpose() * moment;
    for (int n = 0; n < 3; ++n)
      view.jacobian[n] = static_cast<float>(normal[n]),
      view.jacobian[n + 3] = static_cast<float>(turn[n]);
    view.residual_m = static_cast<float>(p.z() - frame_.z_origin_m() - base - beyond);
    view.weight =
        static_cast<float>(1.0 / (kPointNoise_m * kPointNoise_m / static_cast<double>(cell.points) +
                                  kCellNoise_m * kCellNoise_m));
    view.cell = static_cast<std::uint32_t>(i * across_ + j);
  }
}

void JointProblem::linearise(const std::vector<Correction>& at) {
  const auto all = [&] {
    base::parallel_for(sections_.list.size(), 1, options_.threads,
                       [&](std::size_t from, std::size_t to) {
                         for (std::size_t s = from; s < to; ++s) linearise(s, at);
                       });
  };
  const bool first = at_.empty();
  at_ = at;
  all();
  if (first && options_.trust_base) {
    find_crown();
    if (crown_ != 0.0) all();
  }
  std::vector<std::uint32_t> begin(along_ * across_ + 1, 0);
  for (const View& view : views_)
    if (view.cell != View::kNone) ++begin[view.cell + 1];
  for (std::size_t i = 0; i + 1 < begin.size(); ++i) begin[i + 1] += begin[i];
  order_.resize(begin.back());
  stretch_begin_.assign(stretches_ + 1, order_.size());
  for (std::size_t k = 0; k < stretches_; ++k)
    stretch_begin_[k] = begin[k * rows_per_stretch_ * across_];
  for (std::size_t i = 0; i < views_.size(); ++i)
    if (views_[i].cell != View::kNone)
      order_[begin[views_[i].cell]++] = static_cast<std::uint32_t>(i);
}

double JointProblem::even_slope(std::size_t i) const {
  const CellNodes at = nodes_of(i * across_);
  return (1.0 - at.share) * nodes_[at.before].slope + at.share * nodes_[at.after].slope;
}

Eigen::Vector2d JointProblem::slope_of(std::size_t i, std::size_t j) const {
  if (!weighed_) return Eigen::Vector2d::Zero();
  const auto between = [&](std::size_t a, std::size_t b) {
    const float p = cells_[a].height_m, q = cells_[b].height_m;
    if (p == 0.0f || q == 0.0f) return 0.0;
    const double even = fine_ ? even_error(b) - even_error(a) : 0.0;
    return (static_cast<double>(q - p) - even) / (2.0 * kSectionCell_m);
  };
  const std::size_t before = i > 0             ? i - 1
                             : frame_.closed() ? along_ - 1
                                               : i,
                    after = i + 1 < along_    ? i + 1
                            : frame_.closed() ? 0
                                              : i;
  return {between(before * across_ + j, after * across_ + j),
          j > 0 && j + 1 < across_ ? between(i * across_ + j - 1, i * across_ + j + 1) : 0.0};
}

void JointProblem::find_slants() {
  if (!weighed_ || !options_.trust_base) return;
  base::parallel_for(along_, 64, options_.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<float> slants;
    for (std::size_t i = begin; i < end; ++i) {
      Cell* const row = cells_.data() + i * across_;
      const auto is_seen = [&](std::size_t j) { return j < across_ && row[j].height_m != 0.0f; };
      slants.clear();
      for (std::size_t j = 0; j < across_; ++j) {
        row[j].slant_m = 0.0f;
        if (!is_seen(j)) continue;
        const std::size_t from = is_seen(j - 1) ? j - 1 : j, to = is_seen(j + 1) ? j + 1 : j;
        if (from == to) continue;
        row[j].slant_m = (row[to].height_m - row[from].height_m) / static_cast<float>(to - from);
        slants.push_back(row[j].slant_m);
      }
      // A base that is tilted there has the shape that it should have.
      const float even_m = base::median_or(0.0f, slants);
      for (std::size_t j = 0; j < across_; ++j)
        if (is_seen(j) && row[j].slant_m != 0.0f) row[j].slant_m -= even_m;
    }
  });
}

double JointProblem::residual_of(const View& view, const CellNodes& nodes,
                                 const std::vector<Correction>& now) const {
  const Correction& a = at_[view.section];
  const Correction& b = now[view.section];
  double r = static_cast<double>(view.residual_m);
  for (int k = 0; k < 6; ++k) r += static_cast<double>(view.jacobian[k]) * (b[k] - a[k]);
  const Eigen::Vector4d within = within_cell(view, nodes);
  return r - within[0] * nodes_[nodes.before].height_m - within[1] * nodes_[nodes.before].slope -
         within[2] * nodes_[nodes.after].height_m - within[3] * nodes_[nodes.after].slope;
}

double JointProblem::value_of(std::size_t unknown, const std::vector<Correction>& now) const {
  const std::size_t first_node = 6 * sections_.list.size(), common = first_node + 2 * nodes_.size();
  if (unknown < first_node) {
    const auto e = static_cast<Eigen::Index>(unknown % 6);
    return now[unknown / 6][e] + before_[unknown / 6][e];
  }
  if (unknown == common) return common_slope_;
  const Node& node = nodes_[(unknown - first_node) / 2];
  return unknown % 2 == 0 ? node.height_m : node.slope;
}

std::vector<Correction> JointProblem::stepped(std::vector<Correction> now,
                                              const Eigen::VectorXd& step) {
  for (std::size_t i = 0; i < now.size(); ++i)
    now[i] += step.segment<6>(static_cast<Eigen::Index>(6 * i));
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(6 * now.size() + 2 * k);
    nodes_[k].height_m += step[at], nodes_[k].slope += step[at + 1];
  }
  common_slope_ += step[static_cast<Eigen::Index>(6 * now.size() + 2 * nodes_.size())];
  return now;
}

std::vector<Correction> JointProblem::solve(const std::vector<Correction>& now,
                                            const JointScales& scales) {
  find_slants();
  assemble_all(now, scales);
  weighed_ = true;
  std::vector<Eigen::Triplet<double>> entries;
  add_prior(entries);
  add_prior_of_base(scales, entries);
  // The right side so far is the gradient at `now`; the prior's is that of `now` itself.
  const auto value = [&](int i) { return value_of(static_cast<std::size_t>(i), now); };
  for (const auto& entry : entries) {
    right_[entry.row()] -= entry.value() * value(entry.col());
    if (entry.row() != entry.col()) right_[entry.col()] -= entry.value() * value(entry.row());
  }
  factorise(entries);
  return stepped(now, factor_.solve(right_));
}

void JointProblem::factorise(const std::vector<Eigen::Triplet<double>>& known) {
  factor_ = matrix_;
  for (const auto& entry : known)
    factor_.add(static_cast<std::size_t>(entry.row()), static_cast<std::size_t>(entry.col()),
                entry.value());
  if (!factor_.factorise())
    throw Misfit(
        "the equations of the drift have no answer in numbers of 16 digits: --drift-m and "
        "--drift-rad as large as the trajectory drifts give them one");
}

}  // namespace cloud
