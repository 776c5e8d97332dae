// A road laid on a driven track.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "base/csv.h"
#include "mesh/error.h"
#include "point_fits.h"
#include "road/align.h"

namespace road {
namespace {

// A line that lies on the road in two ways so different, and in one of them not clearly worse.
constexpr double kOtherWayRound_rad = 0.2;
constexpr double kClearlyWorse = 2.0;
constexpr double kDriven_m = 0.5;  // nobody drives on the middle more exactly
constexpr std::size_t kBeginnings = 6;

using Points = std::vector<Eigen::Vector3d>;

/// At equal steps of path length in plan.
Points resampled(Points points, bool ring, double step_m) {
  if (ring) points.push_back(points.front());
  Points out{points.front()};
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
}

double length_of(const Points& points, bool closed) {
  double length_m = 0.0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    length_m += (points[i + 1] - points[i]).head<2>().norm();
  if (closed) length_m += (points.front() - points.back()).head<2>().norm();
  return length_m;
}

struct Coarse {
  double error_m;
  RotoTranslation T;
};

/// Both resampled at equal steps of path length; all starts and both directions are tried. The best
/// first.
std::vector<Coarse> all_beginnings(const Points& middle_m, bool closed, const Points& trajectory_m,
                                   double step_m) {
  Points road = resampled(middle_m, closed, step_m);
  if (closed && (road.back() - road.front()).head<2>().norm() < 0.5 * step_m) road.pop_back();
  const Points driven = resampled(trajectory_m, false, step_m);
  const std::size_t n = road.size();
  // More than one lap adds nothing to the search.
  const std::size_t count = std::min(driven.size(), n);
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
      const Indices used = all_of(pairs.size());
      const RotoTranslation candidate = fit(pairs, used);
      tried.push_back({rms(candidate, pairs, used), candidate});
    }
  }
  std::sort(tried.begin(), tried.end(),
            [](const Coarse& a, const Coarse& b) { return a.error_m < b.error_m; });
  return tried;
}

struct NearestPlace {
  double distance_m;
  Eigen::Vector3d place;
  Eigen::Vector2d along;
};

NearestPlace nearest_on(const Points& middle_m, bool closed, const Eigen::Vector3d& local) {
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
  return {std::sqrt(nearest), place, along};
}

/// The shortest x that solves A x = b in the least squares, A symmetric and without negative
/// eigenvalues: a line that is straight says nothing of how far along it the points lie.
Eigen::Vector3d smallest_solution(const Eigen::Matrix3d& A, const Eigen::Vector3d& b) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(A);
  const double least = 1e-14 * solver.eigenvalues()[2];
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d axis = solver.eigenvectors().col(k);
    if (solver.eigenvalues()[k] > least) x += axis * (axis.dot(b) / solver.eigenvalues()[k]);
  }
  return x;
}

/// Every point against the line beside it, whose direction leaves it free to slide along (Chen and
/// Medioni 1992).
AlignReport refined(RotoTranslation T, const Points& middle_m, bool closed,
                    const Points& trajectory_m, double length_m) {
  AlignReport report;
  for (int pass = 0; pass < 50; ++pass) {
    report.residual_m.clear();
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double above_m = 0.0;
    const Eigen::AngleAxisd back(-T.yaw_rad, Eigen::Vector3d::UnitZ());
    for (const Eigen::Vector3d& point : trajectory_m) {
      const Eigen::Vector3d local = back * (point - T.translation_m);
      const NearestPlace near = nearest_on(middle_m, closed, local);
      report.residual_m.push_back(near.distance_m);
      const Eigen::Vector2d across(-near.along.y(), near.along.x());
      // Turned by `angle` and moved by d, the point is off by error + J (angle, d).
      const Eigen::Vector3d J(across.dot(Eigen::Vector2d(-local.y(), local.x())) / length_m,
                              across.x(), across.y());
      normal += J * J.transpose();
      right -= J * across.dot((local - near.place).head<2>());
      above_m += (local - near.place).z() / static_cast<double>(trajectory_m.size());
    }
    const Eigen::Vector3d step = smallest_solution(normal, right);
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
}

double turned_by(const RotoTranslation& a, const RotoTranslation& b) {
  return std::abs(std::remainder(a.yaw_rad - b.yaw_rad, 2.0 * std::numbers::pi));
}

/// Why, where the best way to lie is none, or another one is about as good.
std::optional<base::Refusal> doubt_of_fit(const std::vector<AlignReport>& ended, double length_m) {
  const AlignReport& report = ended.front();
  const double worst_m = std::max(10.0, 0.01 * length_m);
  if (!(report.rms_m <= worst_m)) {
    return base::Refusal(
        fmt::format("the trajectory does not follow this road: {:.1f} m rms beside its middle; "
                    "wanted at most {:.1f} m; check that both are the same track",
                    report.rms_m, worst_m));
  }
  for (const AlignReport& other : ended) {
    const double turned = turned_by(other.T_global_mesh, report.T_global_mesh);
    if (turned > kOtherWayRound_rad &&
        other.rms_m < kClearlyWorse * report.rms_m + std::min(kDriven_m, 0.002 * length_m))
      return base::Refusal(fmt::format(
          "the road's shape is the same when it is turned by {:.0f} deg, so its line alone does "
          "not tell how it lies ({:.2f} and {:.2f} m rms); give control points",
          180.0 / std::numbers::pi * turned, report.rms_m, other.rms_m));
  }
  return std::nullopt;
}

}  // namespace

base::Answer<AlignReport> fit_to_trajectory(const std::vector<Eigen::Vector3d>& middle_m,
                                            bool closed,
                                            const std::vector<Eigen::Vector3d>& trajectory_m) {
  if (middle_m.size() < 10 || trajectory_m.size() < 10) {
    return base::Refusal(
        fmt::format("{} points of the road and {} of the trajectory; wanted at least 10 of each",
                    middle_m.size(), trajectory_m.size()));
  }
  const double length_m = length_of(middle_m, closed);
  // From the best beginning in each direction: an oval lies on itself after half a turn, and then
  // nothing in its shape tells which way round it is.
  std::vector<RotoTranslation> begun;
  std::vector<AlignReport> ended;
  for (const Coarse& one : all_beginnings(middle_m, closed, trajectory_m, length_m / 300.0)) {
    if (begun.size() == kBeginnings) break;
    if (!std::all_of(begun.begin(), begun.end(), [&](const RotoTranslation& other) {
          return turned_by(one.T, other) > kOtherWayRound_rad;
        }))
      continue;
    begun.push_back(one.T);
    ended.push_back(refined(one.T, middle_m, closed, trajectory_m, length_m));
  }
  if (ended.empty()) return base::Refusal("the trajectory is longer than this road");
  std::stable_sort(ended.begin(), ended.end(),
                   [](const AlignReport& a, const AlignReport& b) { return a.rms_m < b.rms_m; });
  if (auto doubt = doubt_of_fit(ended, length_m)) return *std::move(doubt);
  return ended.front();
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

}  // namespace road
