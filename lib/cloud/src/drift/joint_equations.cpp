// The normal equations of the sections that see a stretch, with the heights of its cells
// eliminated.
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "joint.h"

namespace cloud {

/// What a section's views of half a stretch add to the equations, in one piece of memory.
struct JointProblem::Seen {
  Eigen::Matrix<double, 6, 6> own = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 4, 6> nodes = Eigen::Matrix<double, 4, 6>::Zero();
  Correction right = Correction::Zero();
};

/// Normal equations of the sections that see one stretch of the road.
struct JointProblem::Stretch {
  std::vector<std::uint32_t> sections, nodes;
  std::vector<std::uint32_t> place;  ///< of each section of the problem among those
  std::vector<Seen> seen;            ///< by them, of the half of a stretch at hand
  Eigen::MatrixXd matrix;            ///< lower triangle
  Eigen::VectorXd right;
};

/// Of a cell's height, which is no unknown of the equations: how a section's correction moves it.
struct JointProblem::Gone {
  std::size_t place = 0;  ///< of the section in the stretch
  Correction of;
};

void JointProblem::add(const Stretch& stretch) {
  std::vector<std::pair<std::size_t, Eigen::Index>> groups;  // first unknown, count
  for (const std::uint32_t section : stretch.sections)
    groups.emplace_back(6 * std::size_t{section}, 6);
  for (const std::uint32_t node : stretch.nodes)
    groups.emplace_back(6 * sections_.list.size() + 2 * std::size_t{node}, 2);
  Eigen::Index row = 0;
  for (std::size_t a = 0; a < groups.size(); row += groups[a++].second) {
    right_.segment(static_cast<Eigen::Index>(groups[a].first), groups[a].second) +=
        stretch.right.segment(row, groups[a].second);
    Eigen::Index column = 0;
    for (std::size_t b = 0; b <= a; column += groups[b++].second)
      matrix_.add(groups[a].first, groups[b].first,
                  stretch.matrix.block(row, column, groups[a].second, groups[b].second));
  }
}

void JointProblem::unknowns_of(std::size_t stretch, Stretch& out) const {
  out.sections.clear();
  out.place.assign(sections_.list.size(), 0);
  for (std::size_t k = stretch_begin_[stretch]; k < stretch_begin_[stretch + 1]; ++k)
    out.place[views_[order_[k]].section] = 1;
  for (std::size_t k = 0; k < out.place.size(); ++k) {
    if (out.place[k] == 0) continue;
    out.place[k] = static_cast<std::uint32_t>(out.sections.size());
    out.sections.push_back(static_cast<std::uint32_t>(k));
  }
  out.nodes.clear();
  for (std::size_t k = 2 * stretch; k <= 2 * stretch + 2; ++k)
    out.nodes.push_back(frame_.closed() && k > 0 && k * rows_per_stretch_ / 2 >= along_
                            ? 0
                            : static_cast<std::uint32_t>(k));
}

void JointProblem::take_away(const std::vector<Gone>& gone, const Eigen::Vector4d& of_nodes,
                             double pull, Stretch& out) {
  for (std::size_t a = 0; a < gone.size(); ++a) {
    const auto at = static_cast<Eigen::Index>(6 * gone[a].place);
    for (std::size_t b = 0; b < a; ++b)
      out.matrix.block<6, 6>(at, static_cast<Eigen::Index>(6 * gone[b].place)).noalias() -=
          gone[a].of * gone[b].of.transpose();
    Seen& seen = out.seen[gone[a].place];
    seen.own.noalias() -= gone[a].of * gone[a].of.transpose();
    seen.nodes.noalias() -= of_nodes * gone[a].of.transpose();
    seen.right += pull * gone[a].of;
  }
}

void JointProblem::put_seen(Eigen::Index node, Stretch& out) {
  for (std::size_t k = 0; k < out.seen.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(6 * k);
    Seen& seen = out.seen[k];
    out.matrix.block<6, 6>(at, at) += seen.own, out.matrix.block<4, 6>(node, at) += seen.nodes;
    out.right.segment<6>(at) += seen.right;
    seen = {};
  }
}

void JointProblem::assemble(std::size_t stretch, const std::vector<Correction>& now,
                            const JointScales& scales, Stretch& out) {
  const std::size_t from = stretch_begin_[stretch], to = stretch_begin_[stretch + 1];
  unknowns_of(stretch, out);
  out.seen.assign(out.sections.size(), {});
  const auto first_node = static_cast<Eigen::Index>(6 * out.sections.size());
  const Eigen::Index dimension = first_node + 6;  // three nodes
  out.matrix.setZero(dimension, dimension), out.right.setZero(dimension);
  std::vector<Gone> gone;  // what a cell takes away, of each section that sees it
  std::vector<double> weights, residuals;
  const double view_scale = 1.0 / (scales.view_factor * scales.view_together);
  Eigen::Index node = first_node;
  for (std::size_t k = from; k < to;) {
    std::size_t end = k;
    const std::uint32_t index = views_[order_[k]].cell;
    while (end < to && views_[order_[end]].cell == index) ++end;
    Cell& cell = cells_[index];
    const CellNodes nodes = nodes_of(index);
    weights.clear(), residuals.clear();
    double sum = 0.0, total = 0.0;
    for (std::size_t i = k; i < end; ++i) {
      const View& view = views_[order_[i]];
      const double r = residual_of(view, nodes, now);
      double w = static_cast<double>(view.weight);
      if (weighed_) w *= geman_mcclure(r - static_cast<double>(cell.height_m), scales.view_m);
      residuals.push_back(r), weights.push_back(w * view_scale);
      sum += w * r, total += w;
    }
    const double mean = total > 0.0 ? sum / total : 0.0;
    cell.height_m = static_cast<float>(mean);
    const double even = even_error(index);
    cell.believed =
        options_.trust_base ? static_cast<float>(belief(cell, mean - even, scales)) : 0.0f;
    const double prior = static_cast<double>(cell.believed) /
                         (scales.base_stddev_m * scales.base_stddev_m * scales.base_together);
    const double whole = total * view_scale + prior;
    const double share = nodes.share, v = nodes.v_m;
    const Eigen::Index here =
        first_node + 2 * static_cast<Eigen::Index>(nodes.before - 2 * stretch);
    if (here != node) put_seen(node, out);
    node = here;
    double pull = 0.0;
    const double root = std::sqrt(whole), per_root = 1.0 / root;
    gone.clear();
    // The base is one more observer; what it states is off by its even error.
    Eigen::Vector4d j_base;
    j_base << 1.0 - share, (1.0 - share) * v, share, share * v;
    Eigen::Matrix4d of_nodes = prior * j_base * j_base.transpose();
    Eigen::Vector4d right = -prior * even * j_base, gone_of_nodes = Eigen::Vector4d::Zero();
    for (std::size_t i = k; i < end; ++i) {
      const View& view = views_[order_[i]];
      const std::size_t place = out.place[view.section];
      Correction j;
      for (int n = 0; n < 6; ++n) j[n] = static_cast<double>(view.jacobian[n]);
      const double w = weights[i - k];
      // A view tells of the base's even error at its own place, not in the middle of its cell.
      const Eigen::Vector4d within = -within_cell(view, nodes), weighed = w * within;
      const Correction weighed_j = w * j;
      Seen& seen = out.seen[place];
      seen.own.noalias() += weighed_j * j.transpose();
      seen.nodes.noalias() += weighed * j.transpose();
      of_nodes.noalias() += weighed * within.transpose();
      seen.right -= residuals[i - k] * weighed_j, right -= residuals[i - k] * weighed;
      if (gone.empty() || gone.back().place != place) gone.push_back({place, Correction::Zero()});
      gone.back().of += per_root * weighed_j;
      gone_of_nodes += per_root * weighed;
      pull += w * residuals[i - k];
    }
    gone_of_nodes += prior / root * j_base;
    pull = (pull + prior * even) / root;
    take_away(gone, gone_of_nodes, pull, out);
    out.matrix.block<4, 4>(node, node) += of_nodes - gone_of_nodes * gone_of_nodes.transpose();
    out.right.segment<4>(node) += right + pull * gone_of_nodes;
    k = end;
  }
  put_seen(node, out);
}

void JointProblem::assemble_all(const std::vector<Correction>& now, const JointScales& scales) {
  matrix_.set_zero(), right_.setZero(matrix_.unknowns());
  constexpr std::size_t kAtOnce = 16;
  std::vector<Stretch> batch(kAtOnce);
  for (std::size_t first = 0; first < stretches_; first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, stretches_ - first);
    base::parallel_for(count, 1, options_.threads, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = from; k < to; ++k) assemble(first + k, now, scales, batch[k]);
    });
    for (std::size_t k = 0; k < count; ++k) add(batch[k]);
    if (tell_) tell_(static_cast<double>(first + count) / static_cast<double>(stretches_));
  }
}

}  // namespace cloud
