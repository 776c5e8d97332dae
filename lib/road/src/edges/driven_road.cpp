#include "road/driven_road.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/statistics.h"
#include "mesh/error.h"
#include "road/guide.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kUsualLap_m = 600.0;  // a shorter lap is that of a narrower road, or of a model
constexpr double kSmooth_m = 30.0, kSmoothShare = 1.0 / 60.0;  // wavelength of which half is left
constexpr double kLeastSide_m = 5.0, kBeside_m = 3.0, kFarthest_m = 20.0;
constexpr double kLeast_m = 10.0;
constexpr std::size_t kLeastPlaces = 10;
constexpr double kSameWay = 0.7;     // cosine between a place's way and the road's
constexpr double kTightest = 0.8;    // of the radius, to the inner edge
constexpr double kNarrowing = 0.25;  // m of width a metre along

/// Places with a height that is not known, without those that leap there and back.
std::vector<Vector3d> known_places(const DrivenPlaces& drive, std::size_t& leaps) {
  std::vector<Vector3d> all;
  for (std::size_t i = 0; i < std::min(drive.x_m.size(), drive.y_m.size()); ++i)
    if (std::isfinite(drive.x_m[i]) && std::isfinite(drive.y_m[i]))
      all.emplace_back(drive.x_m[i], drive.y_m[i], std::numeric_limits<double>::quiet_NaN());
  if (all.size() < 3)
    throw Error(fmt::format("{}: {} rows with a place; wanted a drive", drive.name, all.size()));
  const auto apart_m = [&](std::size_t i) { return (all[i + 1] - all[i]).head<2>().norm(); };
  std::vector<double> steps_m;
  for (std::size_t i = 0; i + 1 < all.size(); ++i) steps_m.push_back(apart_m(i));
  const double most_m = 5.0 * base::quantile(steps_m, 0.95);
  std::vector<Vector3d> out;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool leaps_there =
        i > 0 && i + 1 < all.size() && steps_m[i - 1] > most_m && steps_m[i] > most_m;
    leaps += leaps_there ? 1 : 0;
    if (!leaps_there) out.push_back(all[i]);
  }
  return out;
}

/// A line through places, with a value at any way along it.
class Line {
 public:
  Line(std::vector<Vector2d> points, bool closed) : points_(std::move(points)), closed_(closed) {
    for (std::size_t i = 0; i < points_.size(); ++i) {
      s_m_.push_back(length_m_);
      if (i + 1 < points_.size() || closed_)
        length_m_ += (points_[(i + 1) % points_.size()] - points_[i]).norm();
    }
  }
  std::size_t size() const { return points_.size(); }
  double length_m() const { return length_m_; }
  double s_m(std::size_t i) const { return s_m_[i]; }
  Vector2d at(double s) const {
    const auto next = std::upper_bound(s_m_.begin(), s_m_.end(), s) - s_m_.begin();
    const auto i = static_cast<std::size_t>(next) - 1;
    if (i + 1 == points_.size() && !closed_) return points_.back();
    const double end = i + 1 == points_.size() ? length_m_ : s_m_[i + 1];
    const double share = end > s_m_[i] ? (s - s_m_[i]) / (end - s_m_[i]) : 0.0;
    return points_[i] + share * (points_[(i + 1) % points_.size()] - points_[i]);
  }

 private:
  std::vector<Vector2d> points_;
  std::vector<double> s_m_;
  double length_m_ = 0.0;
  bool closed_;
};

/// All places of the guide's lap or way: the guide itself has been thinned.
std::vector<Vector2d> places_of(const Guide& guide, const std::vector<Vector3d>& places,
                                double step_m) {
  const auto is = [](const Vector3d& p) {
    return [&p](const Vector3d& q) { return p.head<2>() == q.head<2>(); };
  };
  const auto first = std::find_if(places.begin(), places.end(), is(guide.points_m.front()));
  auto last = std::find_if(first, places.end(), is(guide.points_m.back()));
  if (last != places.end()) ++last;
  std::vector<Vector2d> out;
  for (auto p = first; p != last; ++p)
    if (out.empty() || (p->head<2>() - out.back()).norm() > step_m) out.emplace_back(p->head<2>());
  return out;
}

/// The lap, its end moved across onto its beginning, bit by bit along it.
Line lap_of(const Guide& guide, const std::vector<Vector3d>& places, double& gap_m) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < guide.points_m.size(); ++i)
    length_m += (guide.points_m[i] - guide.points_m[i - 1]).head<2>().norm();
  const double step_m = std::min(1.0, length_m / kUsualLap_m);
  std::vector<Vector2d> points = places_of(guide, places, step_m);
  if (guide.closed && points.size() >= kLeastPlaces) {
    const Vector2d begins = (points[5] - points[0]).normalized();
    // What is past the beginning already has been driven twice.
    const auto ahead_m = [&] { return begins.dot(points.back() - points.front()); };
    while (points.size() > kLeastPlaces && std::abs(ahead_m()) < length_m / 4 &&
           ahead_m() > -0.5 * step_m)
      points.pop_back();
    // Over the gap the way goes as before it, as after it, or between the two.
    const Vector2d ends = (points.back() - points[points.size() - 6]).normalized(),
                   over = points.front() - points.back();
    Vector2d move = over;
    for (const Vector2d& along : {begins, ends, Vector2d((begins + ends).normalized())})
      if (const Vector2d across = over - along.dot(over) * along; across.norm() < move.norm())
        move = across;
    const Line open(points, false);
    gap_m = move.norm();
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i] += open.s_m(i) / open.length_m() * move;
  }
  return {std::move(points), guide.closed};
}

/// Smoothed by a bell whose loss is given back once: bends keep their size. Beyond the ends of an
/// open line lies its mirror image about the end.
std::vector<Vector2d> smoothed(const std::vector<Vector2d>& points, bool closed, double sigma) {
  const auto n = static_cast<std::ptrdiff_t>(points.size()),
             reach = std::min(n - 1, static_cast<std::ptrdiff_t>(std::ceil(4.0 * sigma)));
  const auto bell = [&](const std::vector<Vector2d>& of) {
    const auto at = [&](std::ptrdiff_t i) -> Vector2d {
      const auto p = [&](std::ptrdiff_t k) { return of[static_cast<std::size_t>(k)]; };
      if (closed) return p((i % n + n) % n);
      return i < 0 ? 2.0 * p(0) - p(-i) : i >= n ? 2.0 * p(n - 1) - p(2 * n - 2 - i) : p(i);
    };
    std::vector<Vector2d> out;
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      Vector2d sum = Vector2d::Zero();
      double weights = 0.0;
      for (std::ptrdiff_t k = -reach; k <= reach; ++k) {
        const double away = static_cast<double>(k) / sigma, weight = std::exp(-0.5 * away * away);
        sum += weight * at(i + k), weights += weight;
      }
      out.push_back(sum / weights);
    }
    return out;
  };
  std::vector<Vector2d> out = bell(points);
  const std::vector<Vector2d> twice = bell(out);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = 2.0 * out[i] - twice[i];
  return out;
}

/// The smooth line with its direction.
struct Rows {
  std::vector<Vector2d> at, along;
  double step_m = 0.0;
  bool closed = false;

  std::size_t beside(std::size_t i, std::ptrdiff_t steps) const {
    const auto n = static_cast<std::ptrdiff_t>(at.size());
    const std::ptrdiff_t k = static_cast<std::ptrdiff_t>(i) + steps;
    return static_cast<std::size_t>(closed ? (k % n + n) % n
                                           : std::clamp<std::ptrdiff_t>(k, 0, n - 1));
  }
};

Rows rows_along(const Line& lap, bool closed, double scale) {
  Rows rows;
  rows.closed = closed;
  const auto n =
      static_cast<std::size_t>(std::clamp(std::ceil(lap.length_m() / (2.0 * scale)), 20.0, 100e3));
  rows.step_m = lap.length_m() / static_cast<double>(closed ? n : n - 1);
  for (std::size_t i = 0; i < n; ++i)
    rows.at.push_back(lap.at(rows.step_m * static_cast<double>(i)));
  // Twice applied, a wave of this length keeps a half.
  const double wave_m = std::min(kSmooth_m, kSmoothShare * lap.length_m());
  const double sigma_m =
      wave_m * std::sqrt(-2.0 * std::log(1.0 - std::sqrt(0.5))) / (2.0 * std::numbers::pi);
  rows.at = smoothed(rows.at, closed, sigma_m / rows.step_m);
  for (std::size_t i = 0; i < n; ++i)
    rows.along.push_back((rows.at[rows.beside(i, 1)] - rows.at[rows.beside(i, -1)]).normalized());
  return rows;
}

/// How far to the left each place lies; those far off or on another way counted apart.
std::vector<double> across_m(const std::vector<Vector3d>& places, const Rows& rows, double scale,
                             double& beside_share) {
  std::vector<double> out;
  std::size_t looked_at = 0;
  Vector2d last = places.front().head<2>();
  for (const Vector3d& place : places) {
    const Vector2d p = place.head<2>(), way = p - last;
    if (way.norm() < rows.step_m) continue;  // a car that stands says nothing
    last = p;
    ++looked_at;
    double best_m = kFarthest_m * scale, left_m = 0.0;
    for (std::size_t i = 0; i < rows.at.size(); ++i) {
      const Vector2d off = p - rows.at[i];
      if (off.norm() >= best_m || way.normalized().dot(rows.along[i]) < kSameWay) continue;
      best_m = off.norm();
      left_m = rows.along[i].x() * off.y() - rows.along[i].y() * off.x();
    }
    if (best_m < kFarthest_m * scale) out.push_back(left_m);
  }
  beside_share =
      looked_at == 0 ? 0.0 : 1.0 - static_cast<double>(out.size()) / static_cast<double>(looked_at);
  return out;
}

/// The width to one side of each row, less where the bend is tight and around.
std::vector<double> widths_m(const Rows& rows, double side_m, double sign) {
  const std::size_t n = rows.at.size();
  std::vector<double> out(n, side_m);
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d &a = rows.along[rows.beside(i, -1)], &b = rows.along[rows.beside(i, 1)];
    const double curvature_1pm = sign *
                                 std::asin(std::clamp(a.x() * b.y() - a.y() * b.x(), -1.0, 1.0)) /
                                 (2.0 * rows.step_m);
    if (curvature_1pm * side_m > kTightest) out[i] = kTightest / curvature_1pm;
  }
  for (const bool forward : {true, false})  // twice round: what is tight at one end reaches over it
    for (std::size_t k = 1; k < 2 * n; ++k) {
      const std::size_t i = forward ? k % n : n - 1 - k % n;
      if (!rows.closed && k == n) continue;
      const double before = out[rows.beside(i, forward ? -1 : 1)];
      out[i] = std::min(out[i], before + kNarrowing * rows.step_m);
    }
  return out;
}

Edge edge_along(const Rows& rows, const std::string& name, double side_m, double sign) {
  Edge edge;
  edge.path = name;
  edge.keep_open = !rows.closed;
  const std::vector<double> width = widths_m(rows, side_m, sign);
  for (std::size_t i = 0; i < rows.at.size(); ++i) {
    const Vector2d left(-rows.along[i].y(), rows.along[i].x());
    const Vector2d p = rows.at[i] + sign * width[i] * left;
    edge.points_m.emplace_back(p.x(), p.y(), 0.0);
  }
  return edge;
}

}  // namespace

EdgeRoad road_under(const DrivenPlaces& drive, DrivenRoadReport* report) {
  DrivenRoadReport result;
  const std::vector<Vector3d> places = known_places(drive, result.leaps);
  const Guide guide = guide_along(places);
  const Line lap = lap_of(guide, places, result.gap_m);
  if (lap.size() < kLeastPlaces || !(lap.length_m() > kLeast_m))
    throw Error(fmt::format("{}: {} places along a way of {:.1f} m; wanted a drive", drive.name,
                            lap.size(), lap.length_m()));
  const double scale = std::min(1.0, lap.length_m() / kUsualLap_m);
  const Rows rows = rows_along(lap, guide.closed, scale);
  const std::vector<double> left_m = across_m(places, rows, scale, result.beside_share);
  const auto side = [&](double share, double sign) {
    const double driven_m = left_m.empty() ? 0.0 : sign * base::quantile(left_m, share);
    return std::max(kLeastSide_m * scale, driven_m + kBeside_m * scale);
  };
  result.left_m = side(0.99, 1.0);
  result.right_m = side(0.01, -1.0);
  EdgeOptions options;
  options.u_step_m = options.v_step_m = 0.5 * scale;
  EdgeRoad road = road_between_edges(edge_along(rows, drive.name, result.left_m, 1.0),
                                     edge_along(rows, drive.name, result.right_m, -1.0), options,
                                     &result.edges);
  result.length_m = road.line.u_step_m * static_cast<double>(road.line.size() - 1);
  if (report != nullptr) *report = std::move(result);
  return road;
}

}  // namespace road
