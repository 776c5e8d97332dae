#include "cloud/register.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nanoflann.hpp>
#include <optional>
#include <unordered_map>
#include <utility>

#include "base/parallel.h"
#include "cloud/error.h"

namespace cloud {
namespace {

using Points = std::vector<Eigen::Vector3d>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Means of the points per cube, in the order of the first point of each. Relative to `origin`.
Points thinned(const Cloud& cloud, const Eigen::Vector3d& origin, double voxel_m) {
  struct Sum {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double n = 0.0;
  };
  using Cube = std::array<std::int64_t, 3>;
  const auto hash = [](const Cube& cube) {
    std::uint64_t mixed = 0;
    for (const std::int64_t part : cube)
      mixed = (mixed ^ static_cast<std::uint64_t>(part)) * 0x9e3779b97f4a7c15u,
      mixed ^= mixed >> 32;
    return static_cast<std::size_t>(mixed);
  };
  std::unordered_map<Cube, std::size_t, decltype(hash)> index(1024, hash);
  std::vector<Sum> sums;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = cloud.point(i) + (cloud.origin_m - origin);
    const auto part = [&](int k) { return static_cast<std::int64_t>(std::floor(p[k] / voxel_m)); };
    const auto [found, is_new] = index.try_emplace({part(0), part(1), part(2)}, sums.size());
    if (is_new) sums.emplace_back();
    sums[found->second].sum += p, sums[found->second].n += 1.0;
  }
  Points points;
  for (const Sum& sum : sums) points.push_back(sum.sum / sum.n);
  return points;
}

/// Points relative to `origin`, moved in the map frame.
Points moved(Points points, const Eigen::Isometry3d& T, const Eigen::Vector3d& origin) {
  if (!T.isApprox(Eigen::Isometry3d::Identity(), 0.0))
    for (Eigen::Vector3d& p : points) p = T * (origin + p) - origin;
  return points;
}

/// What nanoflann wants to know about points.
struct Adaptor {
  const Points& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t k) const {
    return points[i][static_cast<Eigen::Index>(k)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Adaptor>,
                                                 Adaptor, 3, std::size_t>;

/// Unit normals from the neighbours; zero where fewer than six lie within reach.
Points normals_of(const Points& points, const Tree& tree, std::size_t neighbours, double reach_m,
                  unsigned threads) {
  Points normals(points.size(), Eigen::Vector3d::Zero());
  base::parallel_for(points.size(), 256, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<std::size_t> near(neighbours);
    std::vector<double> distance2(neighbours);
    for (std::size_t i = begin; i < end; ++i) {
      std::size_t n = tree.knnSearch(points[i].data(), neighbours, near.data(), distance2.data());
      while (n > 0 && distance2[n - 1] > reach_m * reach_m) --n;
      if (n < 6) continue;
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (std::size_t k = 0; k < n; ++k) mean += points[near[k]] / static_cast<double>(n);
      Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
      for (std::size_t k = 0; k < n; ++k)
        spread += (points[near[k]] - mean) * (points[near[k]] - mean).transpose();
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
      normals[i] = solver.eigenvectors().col(0);
    }
  });
  return normals;
}

constexpr double kPlainReach_m = 1.0;
constexpr std::size_t kManyPoints = 3000;  // enough to find the way
constexpr double kThickness =
    1e-3;  // of a surface against its extent, as variances (Segal et al. 2009)

/// Points with the normals of their surface, and a tree of them.
class Surface {
 public:
  Surface(Points points, const RegisterOptions& options)
      : points_(std::move(points)),
        tree_(3, adaptor_, nanoflann::KDTreeSingleIndexAdaptorParams(10)),
        // Farther, points are of other surfaces. 20 of one surface lie within 3 voxels.
        normals_(normals_of(points_, tree_, static_cast<std::size_t>(options.neighbours),
                            std::max(options.max_distance_m, 10.0 * options.voxel_m),
                            options.threads)) {}
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;

  std::size_t size() const { return points_.size(); }
  const Eigen::Vector3d& point(std::size_t i) const { return points_[i]; }
  const Eigen::Vector3d& normal(std::size_t i) const { return normals_[i]; }
  /// The nearest point, where it lies within reach and has a normal.
  std::optional<std::size_t> nearest(const Eigen::Vector3d& to, double reach_m) const {
    std::size_t near = 0;
    double distance2 = 0.0;
    if (tree_.knnSearch(to.data(), 1, &near, &distance2) == 0 || distance2 > reach_m * reach_m ||
        normals_[near].isZero())
      return std::nullopt;
    return near;
  }

 private:
  Points points_;
  Adaptor adaptor_{points_};
  Tree tree_;
  Points normals_;
};

/// What the motion turns about: its arms are in units of the radius.
struct Pivot {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double radius_m = 1e-3;
};

/// The middle of what lies near the target: the rest says nothing about the motion, and a few stray
/// points far away would make every turn look like none.
Pivot pivot_of(const Surface& target, const Surface& source, const RegisterOptions& options) {
  std::vector<std::uint8_t> meets(source.size(), 0);
  base::parallel_for(source.size(), 512, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      meets[i] =
          target.nearest(source.point(i), options.max_distance_m) && !source.normal(i).isZero() ? 1
                                                                                                : 0;
  });
  const auto meeting =
      std::max(1.0, static_cast<double>(std::count(meets.begin(), meets.end(), 1)));
  Pivot pivot;
  for (std::size_t i = 0; i < source.size(); ++i)
    if (meets[i]) pivot.middle += source.point(i) / meeting;
  double radius2 = 0.0;
  for (std::size_t i = 0; i < source.size(); ++i)
    if (meets[i]) radius2 += (source.point(i) - pivot.middle).squaredNorm() / meeting;
  pivot.radius_m = std::max(1e-3, std::sqrt(radius2));
  return pivot;
}

struct Pair {
  bool used = false;
  double residual2 = 0.0;  ///< squared distance along the target's normal
  Matrix6 information = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
};

/// Of the source's point i, moved by T, and the target's nearest. `loss_m` is the width of Cauchy's
/// loss, with which surfaces that only one cloud has lose their pull; 0: none.
Pair pair_of(const Surface& target, const Surface& source, std::size_t i,
             const Eigen::Isometry3d& T, const Pivot& pivot, double reach_m, double loss_m) {
  Pair pair;
  const Eigen::Vector3d p = T * source.point(i);
  const std::optional<std::size_t> near = target.nearest(p, reach_m);
  if (!near || source.normal(i).isZero()) return pair;
  // Both surfaces are thin along their normals and open along themselves: pairs whose normals
  // disagree hold the motion less.
  const Eigen::Vector3d &normal = target.normal(*near), turned = T.linear() * source.normal(i),
                        off = p - target.point(*near);
  const Eigen::Matrix3d spread =
      2.0 * Eigen::Matrix3d::Identity() -
      (1.0 - kThickness) * (normal * normal.transpose() + turned * turned.transpose());
  const Eigen::Matrix3d weight = kThickness * spread.inverse();
  Eigen::Matrix<double, 3, 6> jacobian;
  const Eigen::Vector3d arm = (p - pivot.middle) / pivot.radius_m;
  jacobian << Eigen::Matrix3d::Identity(),
      (Eigen::Matrix3d() << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0)
          .finished();
  pair.used = true;
  pair.residual2 = std::pow(normal.dot(off), 2);
  const double robust = loss_m > 0.0 ? 1.0 / (1.0 + pair.residual2 / std::pow(loss_m, 2)) : 1.0;
  pair.information = robust * jacobian.transpose() * weight * jacobian;
  pair.right = -robust * jacobian.transpose() * weight * off;
  return pair;
}

/// Sums over all pairs.
struct PairSums {
  std::size_t pairs = 0;
  double residual2 = 0.0;
  Matrix6 information = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
};

PairSums sums_of(const std::vector<Pair>& pairs) {
  PairSums sums;
  for (const Pair& pair : pairs) {
    if (!pair.used) continue;
    sums.information += pair.information;
    sums.right += pair.right;
    sums.residual2 += pair.residual2;
    ++sums.pairs;
  }
  return sums;
}

/// The step of x, y, z and turns (in units of the pivot's radius); none along what the pairs do not
/// fix. Reports what they tell of each direction.
Vector6 step_of(const PairSums& sums, RegisterReport& facts) {
  const auto pairs = static_cast<double>(sums.pairs);
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(sums.information / pairs);
  Vector6 step = Vector6::Zero();
  facts.unfixed.clear();
  const char* const names[] = {"x", "y", "z", "about x", "about y", "about z"};
  for (int k = 0; k < 6; ++k) {
    facts.information[static_cast<std::size_t>(k)] = solver.eigenvalues()[k];
    const Vector6 direction = solver.eigenvectors().col(k);
    // Surfaces alone, held by their thickness, would give a direction 2e-3 of the best one's
    // information.
    if (solver.eigenvalues()[k] < 5e-3 * solver.eigenvalues()[5]) {
      Eigen::Index largest = 0;
      direction.cwiseAbs().maxCoeff(&largest);
      facts.unfixed.push_back(fmt::format("mostly {} ({:.2f} {:.2f} {:.2f} | {:.2f} {:.2f} {:.2f})",
                                          names[largest], direction[0], direction[1], direction[2],
                                          direction[3], direction[4], direction[5]));
      continue;
    }
    step += direction * (direction.dot(sums.right) / pairs / solver.eigenvalues()[k]);
  }
  return step;
}

/// A motion that moves the pivot's middle and turns about it.
Eigen::Isometry3d motion_about(const Pivot& pivot, const Eigen::Vector3d& move_m,
                               const Eigen::Vector3d& turn_rad) {
  Eigen::Isometry3d change = Eigen::Isometry3d::Identity();
  if (turn_rad.norm() > 0.0)
    change.linear() = Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()).toRotationMatrix();
  change.translation() = move_m + pivot.middle - change.linear() * pivot.middle;
  return change;
}

}  // namespace

Eigen::Isometry3d register_clouds(const Cloud& target, const Cloud& source,
                                  const RegisterOptions& options, RegisterReport* report) {
  const Surface to(thinned(target, target.origin_m, options.voxel_m), options),
      from(moved(thinned(source, target.origin_m, options.voxel_m), options.start, target.origin_m),
           options);
  RegisterReport unused;
  RegisterReport& facts = report != nullptr ? *report : unused;
  facts = {};
  facts.points = from.size();
  const Pivot pivot = pivot_of(to, from, options);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  std::vector<Pair> pairs(from.size());
  // Nearer, pairs of a wrong side would be let go too early.
  const double narrowest = std::min(options.max_distance_m, 2.0 * options.voxel_m);
  // Plain from the beginning may end in a place of its own: the loss leads the way.
  bool loss = true;
  double reach = options.max_distance_m;
  for (facts.iterations = 1; facts.iterations <= options.max_iterations; ++facts.iterations) {
    if (options.progress)
      options.progress("register", static_cast<double>(facts.iterations) / options.max_iterations);
    const bool last = !loss || (options.robust && reach <= narrowest);
    const std::size_t every = !last && from.size() >= 3 * kManyPoints ? 3 : 1;
    base::parallel_for(from.size(), 512, options.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        pairs[i].used = false;
        if (i % every == 0)
          pairs[i] = pair_of(to, from, i, T, pivot, reach, loss ? 0.05 * reach : 0.0);
      }
    });
    const PairSums sums = sums_of(pairs);
    facts.inliers = sums.pairs;
    if (facts.inliers < 100)
      throw Error(
          fmt::format("the clouds do not overlap: {} of {} points have a neighbour on a plane "
                      "within {} m; 100 wanted",
                      facts.inliers, from.size(), reach));
    facts.rms_after_m = std::sqrt(sums.residual2 / static_cast<double>(sums.pairs));
    if (facts.iterations == 1) facts.rms_before_m = facts.rms_after_m;
    const Vector6 step = step_of(sums, facts);
    const Eigen::Vector3d move = step.head<3>(), turn = step.tail<3>() / pivot.radius_m;
    T = motion_about(pivot, move, turn) * T;
    if (!(move.norm() < (last ? 1e-4 : 5e-3) && turn.norm() < (last ? 1e-5 : 5e-4))) continue;
    if (last) {
      facts.converged = true;
      break;
    }
    if (reach <= narrowest)
      loss = false, reach = std::min(options.max_distance_m, std::max(narrowest, kPlainReach_m));
    else
      reach = std::max(narrowest, 0.6 * reach);
  }
  facts.iterations = std::min(facts.iterations, options.max_iterations);
  // Back from the target's local origin to the map frame.
  Eigen::Isometry3d in_map = T;
  in_map.translation() += target.origin_m - T.linear() * target.origin_m;
  return in_map * options.start;
}

}  // namespace cloud
