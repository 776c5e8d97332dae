// What is known of a trajectory, and of the base's even error, before the points are looked at.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"
#include "joint.h"

namespace cloud {
namespace {

// A base that falls otherwise to both sides of its line everywhere would be believed on one of
// them.
constexpr double kCrownReach_m = 4.0, kLeastCrown = 0.0005, kEnoughOfCrown = 40.0;
constexpr std::size_t kLeastSections = 4;

}  // namespace

void JointProblem::add_prior(std::vector<Eigen::Triplet<double>>& entries) const {
  const auto n = static_cast<std::ptrdiff_t>(sections_.list.size());
  const auto penalise = [&](std::initializer_list<std::pair<std::ptrdiff_t, double>> terms, int k,
                            double sigma) {
    for (const auto& [i, a] : terms)
      for (const auto& [j, b] : terms)
        if (i >= j)
          entries.emplace_back(static_cast<int>(6 * i + k), static_cast<int>(6 * j + k),
                               a * b / (sigma * sigma));
  };
  // Without a base the trajectory is all that says where the road lies: what all poses have in
  // common is as good as 100 m of its drift. Beside a base that may be tilted hardly anything is
  // known about the roll that they have in common, however many they are.
  const double root = std::sqrt(std::max(1.0, static_cast<double>(n)));
  const auto own = [&](int k) {
    if (options_.trust_base)
      return k < 2 ? aside_m_ : k == 2 ? kAnywhere_m : k == 3 && fine_ ? root * 0.03 : 0.03;
    return root * (k < 3 ? options_.drift_m_per_100m : options_.drift_rad_per_100m);
  };
  for (std::ptrdiff_t i = 0; i < n; ++i)
    for (int k = 0; k < 6; ++k) {
      // Slopes averaged over 50 m by a raised cosine: an rms change of 1 over 100 m is a slope of
      // 1/53 per m whose own slope is 0.073 of it per m.
      const double slope = (k < 3 ? options_.drift_m_per_100m : options_.drift_rad_per_100m) / 53.0;
      const double h = kSectionLength_m;
      penalise({{i, 1.0}}, k, own(k));
      const auto together = [&](std::ptrdiff_t a) {
        return a < n && sections_.list[static_cast<std::size_t>(a)].piece ==
                            sections_.list[static_cast<std::size_t>(i)].piece;
      };
      if (together(i + 1)) penalise({{i, -1.0}, {i + 1, 1.0}}, k, slope * h);
      if (together(i + 2))
        penalise({{i, 1.0}, {i + 1, -2.0}, {i + 2, 1.0}}, k, 0.073 * slope * h * h);
    }
}

void JointProblem::hold_as_a_whole(std::vector<Correction>& now) const {
  const std::size_t n = now.size();
  if (n == 0) return;
  std::vector<Eigen::Triplet<double>> entries;
  add_prior(entries);
  const auto dimension = static_cast<Eigen::Index>(6 * n);
  Eigen::SparseMatrix<double> lower(dimension, dimension);
  lower.setFromTriplets(entries.begin(), entries.end());
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Section& section : sections_.list) middle += section.position_m;
  middle /= static_cast<double>(n);
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(dimension, 6);  // moves and turns of everything
  Eigen::VectorXd sum(dimension);
  for (std::size_t i = 0; i < n; ++i) {
    const Section& section = sections_.list[i];
    const auto at = static_cast<Eigen::Index>(6 * i);
    whole.block<3, 3>(at, 0).setIdentity();
    for (int k = 0; k < 3; ++k)
      whole.block<3, 1>(at, 3 + k) = Eigen::Vector3d::Unit(k).cross(section.position_m - middle);
    whole.block<3, 3>(at + 3, 3) = section.axes.transpose();
    sum.segment<6>(at) = now[i] + before_[i];
  }
  const Eigen::MatrixXd stiff = lower.selfadjointView<Eigen::Lower>() * whole;
  const Eigen::Matrix<double, 6, 1> move =
      (whole.transpose() * stiff).ldlt().solve(stiff.transpose() * sum);
  const Eigen::VectorXd step = whole * move;
  for (std::size_t i = 0; i < n; ++i) now[i] -= step.segment<6>(static_cast<Eigen::Index>(6 * i));
}

void JointProblem::find_crown() {
  const std::size_t sections = sections_.list.size();
  std::vector<double> found;
  std::vector<Eigen::Vector3d> fits(sections, Eigen::Vector3d::Zero());
  for (std::size_t s = 0; s < sections; ++s) {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double left = 0.0, all = 0.0;
    for (std::size_t k = first_[s]; k < first_[s + 1]; ++k) {
      if (views_[k].cell == View::kNone) continue;
      const double v_m = nodes_of(views_[k].cell).v_m;
      if (std::abs(v_m) > kCrownReach_m) continue;
      const Eigen::Vector3d j(1.0, v_m, std::abs(v_m));
      matrix += j * j.transpose(), right += static_cast<double>(views_[k].residual_m) * j;
      left += v_m > 0.0 ? 1.0 : 0.0, all += 1.0;
    }
    if (std::min(left, all - left) < kEnoughOfCrown) continue;
    fits[s] = matrix.ldlt().solve(right), found.push_back(fits[s][2]);
  }
  if (found.size() < kLeastSections) return;
  const double crown = base::median(found);
  for (double& of_section : found) of_section = std::abs(of_section - crown);
  if (std::abs(crown) < std::max(kLeastCrown, 4.0 * base::median(found))) return;
  // How far out it goes on: what lies beyond, as of the road's edge, is moved by as much.
  std::vector<std::vector<double>> beyond_m(across_);
  for (std::size_t s = 0; s < sections; ++s)
    for (std::size_t k = first_[s]; k < first_[s + 1] && fits[s][2] != 0.0; ++k) {
      if (views_[k].cell == View::kNone) continue;
      const double v_m = nodes_of(views_[k].cell).v_m;
      beyond_m[views_[k].cell % across_].push_back(static_cast<double>(views_[k].residual_m) -
                                                   fits[s][0] - fits[s][1] * v_m);
    }
  double least = std::numeric_limits<double>::infinity();
  for (double out_m = kCrownReach_m; out_m < frame_.v_m().back(); out_m += 0.5 * kSectionCell_m) {
    double off = 0.0;
    for (std::size_t j = 0; j < across_; ++j)
      if (!beyond_m[j].empty())
        off += std::abs(base::median(beyond_m[j]) -
                        crown * std::min(std::abs(nodes_of(j).v_m), out_m));
    if (off < least) least = off, crown_out_m_ = out_m;
  }
  crown_ = crown;
}

void JointProblem::refine() {
  if (fine_ || !options_.trust_base) return;
  fine_ = true;
  std::vector<double> slopes;
  for (const Node& node : nodes_)
    if (node.height_m != 0.0) slopes.push_back(node.slope);
  common_slope_ = base::median_or(0.0, std::move(slopes));
}

void JointProblem::refine_at(double base_tilt) {
  fine_ = true, common_slope_ = base_tilt;
  for (Node& node : nodes_) node.slope = base_tilt;
}

void JointProblem::add_prior_of_base(const JointScales& scales,
                                     std::vector<Eigen::Triplet<double>>& entries) {
  for (Node& node : nodes_) {
    node.height_weight = geman_mcclure(node.height_m, scales.node_m);
    node.slope_weight = geman_mcclure(node.slope - common_slope_, scales.node_slope);
  }
  const std::size_t n = sections_.list.size();
  const int common = static_cast<int>(6 * n + 2 * nodes_.size());
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const int at = static_cast<int>(6 * n + 2 * k);
    entries.emplace_back(
        at, at, 1.0 + nodes_[k].height_weight / (scales.node_stddev_m * scales.node_stddev_m));
    const double slope =
        100.0 + nodes_[k].slope_weight / (scales.node_slope_stddev * scales.node_slope_stddev);
    entries.emplace_back(at + 1, at + 1, slope);
    entries.emplace_back(common, at + 1, -slope);
    entries.emplace_back(common, common, slope);
  }
  common_weight_ = geman_mcclure(common_slope_, scales.common_slope) /
                   (scales.common_slope_stddev * scales.common_slope_stddev);
  entries.emplace_back(common, common, common_weight_);
}

}  // namespace cloud
