#include "road/align.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <numeric>
#include <random>

#include "base/csv.h"
#include "base/read_file.h"
#include "base/statistics.h"
#include "base/text_lines.h"
#include "road/error.h"

namespace road {
namespace {

constexpr double kSmallestSpread_m = 3.0;
// An alignment that leaves more than this share of the extent is none; surveys leave a thousandth.
constexpr double kWorstFit = 0.02;
constexpr double kWorstFit_m = 1.0;
constexpr double kSteepestTilt_rad =
    20.0 * std::numbers::pi / 180.0;   // more is another axis that points up
constexpr double kLargestScale = 2.0;  // more, or less than its inverse, is another unit
constexpr std::size_t kMostTriples = 5000;
// A line that lies on the road in two ways so different, and in one of them not clearly worse.
constexpr double kOtherWayRound_rad = 0.2;
constexpr double kClearlyWorse = 2.0;
constexpr double kDriven_m = 0.5;  // nobody drives on the middle more exactly
constexpr std::size_t kBeginnings = 6;

using Indices = std::vector<std::size_t>;

/// Rotation about z and translation by least squares: the angle that turns the summed dot and cross
/// products of the centred points into one another (the plane case of Umeyama 1991).
RotoTranslation fit(const std::vector<ControlPoint>& points, const Indices& used,
                    double mirror = 1.0) {
  Eigen::Vector3d mesh_mean = Eigen::Vector3d::Zero(), global_mean = Eigen::Vector3d::Zero();
  const auto mesh = [&](std::size_t i) {
    return Eigen::Vector3d(points[i].mesh_m.x(), mirror * points[i].mesh_m.y(),
                           points[i].mesh_m.z());
  };
  for (const std::size_t i : used) {
    mesh_mean += mesh(i) / static_cast<double>(used.size());
    global_mean += points[i].global_m / static_cast<double>(used.size());
  }
  double cross = 0.0, dot = 0.0;
  for (const std::size_t i : used) {
    const Eigen::Vector2d a = (mesh(i) - mesh_mean).head<2>(),
                          b = (points[i].global_m - global_mean).head<2>();
    cross += a.x() * b.y() - a.y() * b.x();
    dot += a.dot(b);
  }
  RotoTranslation T;
  T.yaw_rad = std::atan2(cross, dot);
  T.translation_m =
      global_mean - Eigen::AngleAxisd(T.yaw_rad, Eigen::Vector3d::UnitZ()) * mesh_mean;
  return T;
}

double residual(const RotoTranslation& T, const ControlPoint& point, double mirror = 1.0) {
  const Eigen::Vector3d mesh(point.mesh_m.x(), mirror * point.mesh_m.y(), point.mesh_m.z());
  return (Eigen::AngleAxisd(T.yaw_rad, Eigen::Vector3d::UnitZ()) * mesh + T.translation_m -
          point.global_m)
      .norm();
}

double rms(const RotoTranslation& T, const std::vector<ControlPoint>& points, const Indices& used,
           double mirror = 1.0) {
  double sum = 0.0;
  for (const std::size_t i : used) sum += std::pow(residual(T, points[i], mirror), 2);
  return std::sqrt(sum / static_cast<double>(used.size()));
}

double spread(const std::vector<ControlPoint>& points, const Indices& used) {
  double widest = 0.0;
  for (const std::size_t i : used) {
    for (const std::size_t j : used)
      widest = std::max(widest, (points[i].mesh_m - points[j].mesh_m).head<2>().norm());
  }
  return widest;
}

using Rotation = AlignOptions::Rotation;

double residual(const Similarity& T, const ControlPoint& point) {
  return (T.scale * (T.rotation * point.mesh_m) + T.translation_m - point.global_m).norm();
}

double rms(const Similarity& T, const std::vector<ControlPoint>& points, const Indices& used) {
  double sum = 0.0;
  for (const std::size_t i : used) sum += std::pow(residual(T, points[i]), 2);
  return std::sqrt(sum / static_cast<double>(used.size()));
}

/// Least squares over the points used, as the options want it. Throws Error on a degenerate set.
Similarity fit_as(const AlignOptions& options, const std::vector<ControlPoint>& points,
                  const Indices& used) {
  if (options.rotation == Rotation::free) {
    std::vector<ControlPoint> some;
    for (const std::size_t i : used) some.push_back(points[i]);
    return fit_similarity(some, options.scale);
  }
  Similarity T;
  T.rotation = Eigen::AngleAxisd(fit(points, used).yaw_rad, Eigen::Vector3d::UnitZ());
  Eigen::Vector3d mesh_mean = Eigen::Vector3d::Zero(), global_mean = Eigen::Vector3d::Zero();
  for (const std::size_t i : used) {
    mesh_mean += points[i].mesh_m / static_cast<double>(used.size());
    global_mean += points[i].global_m / static_cast<double>(used.size());
  }
  if (options.scale) {
    double product = 0.0, square = 0.0;
    for (const std::size_t i : used) {
      const Eigen::Vector3d a = T.rotation * (points[i].mesh_m - mesh_mean);
      product += a.dot(points[i].global_m - global_mean);
      square += a.squaredNorm();
    }
    T.scale = product / square;
  }
  T.translation_m = global_mean - T.scale * (T.rotation * mesh_mean);
  return T;
}

/// The smallest sets of points that fix a motion, spread over all: pairs, or triples for a free
/// rotation.
std::vector<Indices> smallest_sets(const AlignOptions& options,
                                   const std::vector<ControlPoint>& points) {
  const std::size_t n = points.size();
  const auto apart = [&](std::size_t i, std::size_t j) {
    return (points[i].mesh_m - points[j].mesh_m).head<2>().norm() >= kSmallestSpread_m;
  };
  std::vector<Indices> sets;
  if (options.rotation == Rotation::about_z) {
    // Pairs far apart fix the rotation; more than 20,000 pairs tell nothing new.
    const std::size_t step = std::max<std::size_t>(1, n * n / 40'000);
    std::size_t pair = 0;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        if (pair++ % step == 0 && apart(i, j)) sets.push_back({i, j});
      }
    }
    return sets;
  }
  const auto add = [&](std::size_t i, std::size_t j, std::size_t k) {
    const Eigen::Vector3d a = points[j].mesh_m - points[i].mesh_m,
                          b = points[k].mesh_m - points[i].mesh_m;
    // Twice as high over its longest side as points have to be apart.
    if (apart(i, j) && apart(i, k) && apart(j, k) &&
        a.cross(b).norm() >=
            2.0 * kSmallestSpread_m * std::max({a.norm(), b.norm(), (a - b).norm()}))
      sets.push_back({i, j, k});
  };
  if (n * n * n <= 6 * kMostTriples) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        for (std::size_t k = j + 1; k < n; ++k) add(i, j, k);
      }
    }
    return sets;
  }
  std::mt19937_64 random(1);
  for (std::size_t tries = 0; tries < kMostTriples; ++tries) {
    const std::size_t i = random() % n, j = random() % n, k = random() % n;
    if (i != j && j != k && k != i) add(i, j, k);
  }
  return sets;
}

/// Least median of squares (Rousseeuw 1984) over the smallest sets, then least squares over what
/// agrees with it.
Indices inliers(const std::vector<ControlPoint>& points, const AlignOptions& options) {
  Indices all(points.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const std::size_t least = options.rotation == Rotation::free ? 3 : 2;
  if (!options.reject_outliers || points.size() < least + 2) return all;
  double best = std::numeric_limits<double>::infinity();
  Similarity best_T;
  for (const Indices& set : smallest_sets(options, points)) {
    const Similarity T = fit_as(options, points, set);
    std::vector<double> distances;
    for (const ControlPoint& point : points) distances.push_back(residual(T, point));
    const double middle = base::median(std::move(distances));
    if (middle < best) {
      best = middle;
      best_T = T;
    }
  }
  Indices used;
  for (int pass = 0; pass < 3; ++pass) {
    // 1.48 medians are one standard deviation of normal noise; so few points fit a little worse
    // than all.
    const double limit_m = std::max(options.smallest_outlier_m, 4.0 * 1.48 * best);
    used.clear();
    std::vector<double> distances;
    for (const std::size_t i : all) {
      if (residual(best_T, points[i]) <= limit_m) used.push_back(i);
    }
    if (used.size() < least) break;
    best_T = fit_as(options, points, used);
    for (const std::size_t i : used) distances.push_back(residual(best_T, points[i]));
    best = base::median(std::move(distances));
  }
  return used.size() * 2 > points.size() ? used : all;
}

/// Why nothing fits, where the reason has a name.
std::string reason_of_misfit(const std::vector<ControlPoint>& points, const Indices& used,
                             double rms_m) {
  const double mirrored_m = rms(fit(points, used, -1.0), points, used, -1.0);
  double mesh_m = 0.0, global_m = 0.0;
  for (const std::size_t i : used) {
    for (const std::size_t j : used) {
      mesh_m += (points[i].mesh_m - points[j].mesh_m).head<2>().norm();
      global_m += (points[i].global_m - points[j].global_m).head<2>().norm();
    }
  }
  const double ratio = global_m / mesh_m;
  if (mirrored_m < 0.2 * rms_m)
    return "their mirror image fits; look for latitude and longitude swapped, a wrong hemisphere "
           "or a wrong axis";
  if (std::abs(ratio - 1.0) > kWorstFit)
    return fmt::format("their distances are {:.4g} times those in the mesh; look for a wrong unit",
                       ratio);
  return "check which point is which";
}

/// The motion as what the mesh does and what the road does after it.
void take_apart(const Similarity& T, const Eigen::Vector3d& about_m, AlignReport& report) {
  const Eigen::Quaterniond all(T.rotation);
  const Eigen::Quaterniond about_z = Eigen::Quaterniond(all.w(), 0.0, 0.0, all.z()).normalized();
  const Eigen::Quaterniond tilt = about_z.conjugate() * all;
  report.T_global_mesh.yaw_rad =
      std::remainder(2.0 * std::atan2(about_z.z(), about_z.w()), 2.0 * std::numbers::pi);
  report.tilt_and_scale.about_m = about_m;
  report.tilt_and_scale.linear = T.scale * tilt.toRotationMatrix();
  report.T_global_mesh.translation_m =
      T.scale * (T.rotation * about_m) + T.translation_m - about_z * about_m;
  report.tilt_rad = Eigen::AngleAxisd(tilt).angle();
  report.scale = T.scale;
}

}  // namespace

AlignReport fit_alignment(const std::vector<ControlPoint>& points, const AlignOptions& options) {
  const bool free = options.rotation == Rotation::free;
  if (points.size() < (free ? 3 : 2)) {
    throw Error(
        free ? fmt::format(
                   "{} control points; a free rotation needs at least 3, not all on one line",
                   points.size())
             : fmt::format("{} control points; an alignment needs at least 2", points.size()));
  }
  Indices all(points.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const auto refuse_narrow = [&](const Indices& used) {
    const double spread_m = spread(points, used);
    if (!(spread_m >= kSmallestSpread_m)) {
      throw Error(
          fmt::format("the control points lie within {:.2f} m of each other; wanted at least {} m "
                      "so that they fix a "
                      "rotation",
                      spread_m, kSmallestSpread_m));
    }
    return spread_m;
  };
  refuse_narrow(all);
  fit_as(options, points, all);  // refuses points on one line before any is left out
  const Indices used = inliers(points, options);
  const double spread_m = refuse_narrow(used);

  const Similarity motion = fit_as(options, points, used);
  AlignReport report;
  report.rms_m = rms(motion, points, used);
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    report.residual_m.push_back(residual(motion, points[i]));
    middle_m += points[i].mesh_m / static_cast<double>(points.size());
    if (!std::binary_search(used.begin(), used.end(), i)) report.outliers.push_back(points[i].name);
  }
  const double worst_m = std::max(kWorstFit_m, kWorstFit * spread_m);
  if (report.rms_m > worst_m) {
    throw Error(
        fmt::format("no rotation and translation fits the {} control points: {:.2f} m rms left "
                    "over {:.0f} m; wanted at most "
                    "{:.2f} m; {}",
                    used.size(), report.rms_m, spread_m, worst_m,
                    reason_of_misfit(points, used, report.rms_m)));
  }
  if (free || options.scale) take_apart(motion, middle_m, report);
  if (free && report.tilt_rad > kSteepestTilt_rad) {
    throw Error(
        fmt::format("the {} control points tilt the mesh by {:.1f} degrees; wanted at most {:.0f}; "
                    "look for another axis that points "
                    "up (--up), or latitude and longitude swapped",
                    used.size(), report.tilt_rad * 180.0 / std::numbers::pi,
                    kSteepestTilt_rad * 180.0 / std::numbers::pi));
  }
  if (options.scale && !(motion.scale <= kLargestScale && motion.scale >= 1.0 / kLargestScale)) {
    throw Error(
        fmt::format("the {} control points scale the mesh by {:.4g}; wanted {} to {}; look for a "
                    "wrong unit (--unit)",
                    used.size(), motion.scale, 1.0 / kLargestScale, kLargestScale));
  }
  if (free) return report;
  report.tilt_rad = std::numeric_limits<double>::quiet_NaN();
  if (!options.scale) report.T_global_mesh = fit(points, used);
  if (used.size() >= 3) {
    std::vector<ControlPoint> kept;
    for (const std::size_t i : used) kept.push_back(points[i]);
    try {
      const Similarity check = fit_similarity(kept, true);
      report.scale = options.scale ? motion.scale : check.scale;
      report.tilt_rad = std::acos(std::clamp(check.rotation(2, 2), -1.0, 1.0));
    } catch (const Error&) {
      // On a line: what was not applied stays NaN, as the header says.
    }
  }
  return report;
}

void apply_to_mesh(const TiltAndScale& tilt_and_scale, Mesh& mesh) {
  if (tilt_and_scale.is_identity()) return;
  mesh.origin_m = tilt_and_scale(mesh.origin_m);
  for (Eigen::Vector3d& p : mesh.vertices_m) p = tilt_and_scale.linear * p;
}

Similarity fit_similarity(const std::vector<ControlPoint>& points, bool with_scale) {
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::Matrix3Xd mesh(3, count), global(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    mesh.col(i) = points[static_cast<std::size_t>(i)].mesh_m;
    global.col(i) = points[static_cast<std::size_t>(i)].global_m;
  }
  if (count >= 1) {
    // Centred first: UTM coordinates would cost the products half of their digits.
    const Eigen::Vector3d mesh_mean = mesh.rowwise().mean(), global_mean = global.rowwise().mean();
    const Eigen::Matrix3Xd a = mesh.colwise() - mesh_mean, b = global.colwise() - global_mean;
    const Eigen::Vector3d extent = Eigen::JacobiSVD<Eigen::Matrix3Xd>(a).singularValues();
    if (count >= 3 && extent[1] >= kSmallestSpread_m) {
      const Eigen::Matrix4d T = Eigen::umeyama(a, b, with_scale);
      Similarity out;
      const Eigen::Matrix3d linear = T.topLeftCorner<3, 3>();
      out.scale = with_scale ? std::cbrt(linear.determinant()) : 1.0;
      out.rotation = linear / out.scale;
      out.translation_m = global_mean - linear * mesh_mean + T.topRightCorner<3, 1>();
      double sum = 0.0;
      for (Eigen::Index i = 0; i < count; ++i) {
        out.residual_m.push_back((linear * a.col(i) + T.topRightCorner<3, 1>() - b.col(i)).norm());
        sum += out.residual_m.back() * out.residual_m.back();
      }
      out.rms_m = std::sqrt(sum / static_cast<double>(count));
      return out;
    }
  }
  throw Error(fmt::format(
      "{} control points that span no plane; a free rotation needs at least 3, not all on one line",
      points.size()));
}

AlignReport fit_to_trajectory(const std::vector<Eigen::Vector3d>& middle_m, bool closed,
                              const std::vector<Eigen::Vector3d>& trajectory_m) {
  if (middle_m.size() < 10 || trajectory_m.size() < 10) {
    throw Error(
        fmt::format("{} points of the road and {} of the trajectory; wanted at least 10 of each",
                    middle_m.size(), trajectory_m.size()));
  }
  // Both resampled at equal steps of path length; all starts and both directions are tried.
  const auto resample = [](std::vector<Eigen::Vector3d> points, bool ring, double step_m) {
    if (ring) points.push_back(points.front());
    std::vector<Eigen::Vector3d> out{points.front()};
    double left_m = step_m;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      Eigen::Vector3d from = points[i];
      double length_m = (points[i + 1] - from).head<2>().norm();
      while (length_m >= left_m && length_m > 0.0) {
        from += (points[i + 1] - from) * (left_m / length_m);
        out.push_back(from);
        length_m = (points[i + 1] - from).head<2>().norm();
        left_m = step_m;
      }
      left_m -= length_m;
    }
    return out;
  };
  double length_m = 0.0;
  for (std::size_t i = 0; i + 1 < middle_m.size(); ++i)
    length_m += (middle_m[i + 1] - middle_m[i]).head<2>().norm();
  if (closed) length_m += (middle_m.front() - middle_m.back()).head<2>().norm();
  const double step_m = length_m / 300.0;
  std::vector<Eigen::Vector3d> road = resample(middle_m, closed, step_m);
  if (closed && (road.back() - road.front()).head<2>().norm() < 0.5 * step_m) road.pop_back();
  const std::vector<Eigen::Vector3d> driven = resample(trajectory_m, false, step_m);
  const std::size_t n = road.size();
  // More than one lap adds nothing to the search.
  const std::size_t count = std::min(driven.size(), n);
  struct Coarse {
    double error_m;
    RotoTranslation T;
  };
  std::vector<Coarse> tried;
  for (const int direction : {1, -1}) {
    for (std::size_t start = 0; start < n; ++start) {
      std::vector<ControlPoint> pairs;
      for (std::size_t k = 0; k < count; k += 4) {
        const std::ptrdiff_t raw =
            static_cast<std::ptrdiff_t>(start) + direction * static_cast<std::ptrdiff_t>(k);
        const auto size = static_cast<std::ptrdiff_t>(n);
        if (!closed && (raw < 0 || raw >= size)) break;
        pairs.push_back(
            {"", road[static_cast<std::size_t>(((raw % size) + size) % size)], driven[k]});
      }
      if (pairs.size() * 4 + 4 < count || pairs.size() < 3) continue;
      Indices used(pairs.size());
      std::iota(used.begin(), used.end(), std::size_t{0});
      const RotoTranslation candidate = fit(pairs, used);
      tried.push_back({rms(candidate, pairs, used), candidate});
    }
  }
  // Then every point against the line beside it, whose direction leaves it free to slide along
  // (Chen and Medioni 1992).
  const auto refined = [&](RotoTranslation T) {
    AlignReport report;
    for (int pass = 0; pass < 50; ++pass) {
      report.residual_m.clear();
      Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
      Eigen::Vector3d right = Eigen::Vector3d::Zero();
      double above_m = 0.0;
      const Eigen::AngleAxisd back(-T.yaw_rad, Eigen::Vector3d::UnitZ());
      for (const Eigen::Vector3d& point : trajectory_m) {
        const Eigen::Vector3d local = back * (point - T.translation_m);
        double nearest = std::numeric_limits<double>::infinity();
        Eigen::Vector3d place = middle_m.front();
        Eigen::Vector2d along = Eigen::Vector2d::UnitX();
        for (std::size_t i = 0; i + (closed ? 0 : 1) < middle_m.size(); ++i) {
          const Eigen::Vector3d& a = middle_m[i];
          const Eigen::Vector3d ab = middle_m[(i + 1) % middle_m.size()] - a;
          const double square = ab.head<2>().squaredNorm();
          if (!(square > 0.0)) continue;
          const double s = std::clamp(ab.head<2>().dot((local - a).head<2>()) / square, 0.0, 1.0);
          const double distance = (local - a - s * ab).head<2>().squaredNorm();
          if (distance < nearest) {
            nearest = distance;
            place = a + s * ab;
            along = ab.head<2>() / std::sqrt(square);
          }
        }
        report.residual_m.push_back(std::sqrt(nearest));
        const Eigen::Vector2d across(-along.y(), along.x());
        // Turned by `angle` and moved by d, the point is off by error + J (angle, d).
        const Eigen::Vector3d J(across.dot(Eigen::Vector2d(-local.y(), local.x())) / length_m,
                                across.x(), across.y());
        normal += J * J.transpose();
        right -= J * across.dot((local - place).head<2>());
        above_m += (local - place).z() / static_cast<double>(trajectory_m.size());
      }
      const Eigen::Vector3d step = normal.completeOrthogonalDecomposition().solve(right);
      T.yaw_rad -= step.x() / length_m;
      T.translation_m -= Eigen::AngleAxisd(T.yaw_rad, Eigen::Vector3d::UnitZ()) *
                         Eigen::Vector3d(step.y(), step.z(), -above_m);
      if (step.norm() + std::abs(above_m) < 1e-4) break;
    }
    report.T_global_mesh = T;
    for (const double r : report.residual_m)
      report.rms_m += r * r / static_cast<double>(report.residual_m.size());
    report.rms_m = std::sqrt(report.rms_m);
    return report;
  };
  // From the best beginning in each direction: an oval lies on itself after half a turn, and then
  // nothing in its shape tells which way round it is.
  const auto differ = [](const RotoTranslation& a, const RotoTranslation& b) {
    return std::abs(std::remainder(a.yaw_rad - b.yaw_rad, 2.0 * std::numbers::pi)) >
           kOtherWayRound_rad;
  };
  std::sort(tried.begin(), tried.end(),
            [](const Coarse& a, const Coarse& b) { return a.error_m < b.error_m; });
  std::vector<RotoTranslation> begun;
  std::vector<AlignReport> ended;
  for (const Coarse& one : tried) {
    if (begun.size() == kBeginnings) break;
    if (!std::all_of(begun.begin(), begun.end(),
                     [&](const RotoTranslation& other) { return differ(one.T, other); }))
      continue;
    begun.push_back(one.T);
    ended.push_back(refined(one.T));
  }
  if (ended.empty()) throw Error("the trajectory is longer than this road");
  std::stable_sort(ended.begin(), ended.end(),
                   [](const AlignReport& a, const AlignReport& b) { return a.rms_m < b.rms_m; });
  AlignReport& report = ended.front();
  const double worst_m = std::max(10.0, 0.01 * length_m);
  if (!(report.rms_m <= worst_m)) {
    throw Error(
        fmt::format("the trajectory does not follow this road: {:.1f} m rms beside its middle; "
                    "wanted at most {:.1f} m; check "
                    "that both are the same track",
                    report.rms_m, worst_m));
  }
  for (const AlignReport& other : ended)
    if (differ(other.T_global_mesh, report.T_global_mesh) &&
        other.rms_m < kClearlyWorse * report.rms_m + std::min(kDriven_m, 0.002 * length_m))
      throw Error(fmt::format(
          "the road's shape is the same when it is turned by {:.0f} deg, so its line alone does "
          "not "
          "tell how it lies ({:.2f} and {:.2f} m rms); give control points",
          180.0 / std::numbers::pi *
              std::abs(std::remainder(other.T_global_mesh.yaw_rad - report.T_global_mesh.yaw_rad,
                                      2.0 * std::numbers::pi)),
          report.rms_m, other.rms_m));
  return report;
}

Trajectory read_trajectory(const std::string& path, Projection::Kind kind) {
  const base::CsvTable table =
      base::read_csv(path, {}, {"x_m", "y_m", "z_m", "lat_deg", "lon_deg", "h_m"});
  const bool projected = table.present[0] && table.present[1] && table.present[2];
  const bool geographic = !projected && table.present[3] && table.present[4] && table.present[5];
  if (!projected && !geographic)
    throw Error(fmt::format(
        "{}: no columns lat_deg,lon_deg,h_m or x_m,y_m,z_m; a trajectory needs all three of either",
        path));
  Trajectory out;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const std::size_t first = projected ? 0 : 3;
    const Eigen::Vector3d p(table.value(i, first), table.value(i, first + 1),
                            table.value(i, first + 2));
    if (!p.allFinite()) continue;
    if (projected) {
      out.points_m.push_back(p);
      continue;
    }
    try {
      if (out.points_m.empty()) out.projection = projection_at(kind, p.x(), p.y());
      utm_zone(p.x(), p.y());
      const Eigen::Vector2d plane = project(out.projection, p.x(), p.y());
      out.points_m.emplace_back(plane.x(), plane.y(), p.z());
    } catch (const Error& error) {
      throw Error(fmt::format("{}:{}: {}", path, table.line[i], error.what()));
    }
  }
  if (out.points_m.size() < 10)
    throw Error(fmt::format("{}: {} positions; wanted at least 10 along the road", path,
                            out.points_m.size()));
  return out;
}

ControlPoints read_control_point_file(const std::string& path, Projection::Kind kind) {
  const std::string text = base::read_file(path);
  const auto cells_of = [](std::string_view line) {
    std::vector<std::string_view> cells;
    while (true) {
      const std::size_t comma = line.find(',');
      std::string_view cell = line.substr(0, comma);
      while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
      while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t')) cell.remove_suffix(1);
      cells.push_back(cell);
      if (comma == std::string_view::npos) return cells;
      line.remove_prefix(comma + 1);
    }
  };
  constexpr std::array<const char*, 3> kMesh{"mesh_x_m", "mesh_y_m", "mesh_z_m"};
  constexpr std::array<const char*, 3> kProjected{"x_m", "y_m", "z_m"};
  constexpr std::array<const char*, 3> kGeographic{"lat_deg", "lon_deg", "h_m"};
  base::Lines lines(text);
  std::string_view line;
  bool has_header = false, geographic = false;
  std::size_t columns = 0, name_column = std::string_view::npos;
  std::array<std::size_t, 6> column{};
  ControlPoints out;
  while (lines.next(line)) {
    if (lines.number() == 1 && line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);
    if (line.find_first_not_of(" \t") == std::string_view::npos || line.starts_with('#')) continue;
    const std::vector<std::string_view> cells = cells_of(line);
    if (!has_header) {
      has_header = true;
      columns = cells.size();
      const auto find = [&](std::string_view name) {
        return static_cast<std::size_t>(std::find(cells.begin(), cells.end(), name) -
                                        cells.begin());
      };
      const auto take = [&](const std::array<const char*, 3>& names, std::size_t at) {
        bool found = true;
        for (std::size_t k = 0; k < 3; ++k) {
          column[at + k] = find(names[k]);
          found = found && column[at + k] < columns;
        }
        return found;
      };
      const bool mesh = take(kMesh, 0);
      const bool projected = take(kProjected, 3);
      geographic = !projected && take(kGeographic, 3);
      if (!mesh || (!projected && !geographic)) {
        throw Error(
            fmt::format("{}:{}: header '{}'; wanted [name,]mesh_x_m,mesh_y_m,mesh_z_m and "
                        "x_m,y_m,z_m or lat_deg,lon_deg,h_m",
                        path, lines.number(), line.substr(0, 120)));
      }
      if (find("name") < columns) name_column = find("name");
      continue;
    }
    if (cells.size() < columns) {
      throw Error(fmt::format("{}:{}: {} cells; wanted {} as in the header", path, lines.number(),
                              cells.size(), columns));
    }
    std::array<double, 6> value{};
    for (std::size_t k = 0; k < 6; ++k) {
      const auto number = base::to_number<double>(cells[column[k]]);
      if (!number || !std::isfinite(*number)) {
        throw Error(
            fmt::format("{}:{}: '{}'; wanted a number: a control point needs all six coordinates",
                        path, lines.number(), cells[column[k]]));
      }
      value[k] = *number;
    }
    ControlPoint point;
    point.name = name_column < cells.size() && !cells[name_column].empty()
                     ? std::string(cells[name_column])
                     : fmt::format("point {}", out.points.size() + 1);
    point.mesh_m = {value[0], value[1], value[2]};
    if (geographic) {
      try {
        if (out.points.empty()) out.projection = projection_at(kind, value[3], value[4]);
        if (std::abs(value[3]) > 90.0) utm_zone(value[3], value[4]);
        const Eigen::Vector2d plane = project(out.projection, value[3], value[4]);
        point.global_m = {plane.x(), plane.y(), value[5]};
        out.latitude_longitude_deg.emplace_back(value[3], value[4]);
      } catch (const Error& error) {
        throw Error(fmt::format("{}:{}: {}", path, lines.number(), error.what()));
      }
    } else {
      point.global_m = {value[3], value[4], value[5]};
    }
    out.points.push_back(std::move(point));
  }
  if (!has_header)
    throw Error(
        fmt::format("{}: no header; wanted [name,]mesh_x_m,mesh_y_m,mesh_z_m,x_m,y_m,z_m", path));
  return out;
}

std::vector<ControlPoint> read_control_points(const std::string& path) {
  return read_control_point_file(path).points;
}

void apply_alignment(const RotoTranslation& T_global_mesh, crg::ReferenceLine& line) {
  const double cosine = std::cos(T_global_mesh.yaw_rad), sine = std::sin(T_global_mesh.yaw_rad);
  const Eigen::Vector3d& shift = T_global_mesh.translation_m;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const double x = line.x_m[i], y = line.y_m[i];
    line.x_m[i] = cosine * x - sine * y + shift.x();
    line.y_m[i] = sine * x + cosine * y + shift.y();
    line.heading_rad[i] += T_global_mesh.yaw_rad;
  }
  // Height moves with the line, in double: added to the grid it would cost float32 its last digits.
  if (line.z_m.empty()) line.z_m.assign(line.size(), 0.0);
  for (double& z : line.z_m) z += shift.z();
}

}  // namespace road
