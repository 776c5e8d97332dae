#include "edge_curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh/error.h"

namespace road {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr double kLongest_m = 200e3;  // longer than any road a grid of these steps could hold
constexpr double kRepeated_m = 1e-3;
constexpr double kDense_m = 0.1;
constexpr double kExtension_m = 100.0;  // beyond the ends of an open edge
constexpr double kClosingGap_m =
    20.0;  // about a road's width: nobody surveys an open road into a ring
constexpr double kUnusualGap = 2.0;     // times the usual step
constexpr double kComingRound_m = 1.0;  // across, from the first point
constexpr double kShortestLap_m = 50.0;

double angle(const Vector2d& a, const Vector2d& b) {
  return std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)));
}

std::string place(const Edge& edge, std::size_t i) {
  return i < edge.line.size() ? fmt::format("{}:{}", edge.path, edge.line[i]) : edge.path;
}

struct Points {
  std::vector<Vector3d> at;
  std::vector<std::size_t> source;  // index into the edge
  Vector2d step(std::size_t i) const { return (at[(i + 1) % at.size()] - at[i]).head<2>(); }
};

/// By how much the edge turns at a point, where its steps there are longer than noise.
double turn_rad(const Points& points, std::size_t i) {
  const Vector2d before = points.step(i - 1), after = points.step(i);
  return std::min(before.norm(), after.norm()) > 0.5 ? angle(before, after) : 0.0;
}

constexpr double kBack_rad = 120.0 * kRadPerDeg;

/// Whether the edge goes on over points `begin` to `end - 1` as if they were not there.
bool goes_on_without(const Points& points, std::size_t begin, std::size_t end, double longest_m) {
  const auto at = [&](std::size_t i) -> Vector2d { return points.at[i].head<2>(); };
  const Vector2d over = at(end) - at(begin - 1);
  return over.norm() <= longest_m &&
         angle(at(begin - 1) - at(begin - 2), over) < 45.0 * kRadPerDeg &&
         angle(over, at(end + 1) - at(end)) < 45.0 * kRadPerDeg;
}

/// Takes out up to five points in a row that stick out of an edge which goes on straight without
/// them, and says so.
void take_out_spikes(const Edge& edge, Points& points, std::vector<std::string>& remarks) {
  constexpr std::size_t kMost = 5;
  std::vector<double> steps_m;
  for (std::size_t i = 0; i + 1 < points.at.size(); ++i) steps_m.push_back(points.step(i).norm());
  std::nth_element(steps_m.begin(),
                   steps_m.begin() + static_cast<std::ptrdiff_t>(steps_m.size() / 2),
                   steps_m.end());
  const double usual_m = steps_m[steps_m.size() / 2];
  for (std::size_t i = 1; i + 1 < points.at.size(); ++i) {
    if (turn_rad(points, i) <= kBack_rad) continue;
    for (std::size_t many = 1, left = 1; left > 0 && many <= kMost; ++many)
      for (std::size_t begin = std::max<std::size_t>(2, i < many ? 2 : i - many + 1);
           begin <= i + 1; ++begin) {
        const std::size_t end = begin + many;
        if (end + 1 >= points.at.size() ||
            !goes_on_without(points, begin, end, (static_cast<double>(many) + 1.5) * usual_m))
          continue;
        remarks.push_back(
            fmt::format("{}: {} left out, from ({:.3f}, {:.3f}): sticking out of the edge",
                        place(edge, points.source[begin]),
                        many == 1 ? "a point" : fmt::format("{} points", many),
                        points.at[begin].x(), points.at[begin].y()));
        const auto cut = [&](auto& list) {
          list.erase(list.begin() + static_cast<std::ptrdiff_t>(begin),
                     list.begin() + static_cast<std::ptrdiff_t>(end));
        };
        cut(points.at);
        cut(points.source);
        left = 0;
        i = begin - 1;
        break;
      }
  }
}

void refuse_turning_back(const Edge& edge, const Points& points) {
  for (std::size_t i = 1; i + 1 < points.at.size(); ++i)
    if (const double turn = turn_rad(points, i); turn > kBack_rad)
      throw Error(fmt::format(
          "{}: the edge turns back on itself by {:.0f} degrees at ({:.3f}, {:.3f}); wanted points "
          "in driving order",
          place(edge, points.source[i]), turn / kRadPerDeg, points.at[i].x(), points.at[i].y()));
}

/// Number of points up to where the edge comes round to its first point; all of them when it does
/// not.
std::size_t one_lap(const Points& points) {
  const Vector2d origin = points.at[0].head<2>(), start = points.step(0).normalized();
  double gone = 0.0;
  for (std::size_t i = 0; i + 1 < points.at.size(); ++i) {
    const Vector2d step = points.step(i);
    gone += step.norm();
    if (gone < kShortestLap_m || angle(step, start) > 30.0 * kRadPerDeg) continue;
    const Vector2d a = points.at[i].head<2>() - origin, b = points.at[i + 1].head<2>() - origin;
    const double along_a = a.dot(start), along_b = b.dot(start);
    if (along_a >= 0.0 || along_b < 0.0) continue;
    const Vector2d crossing = a + (b - a) * (along_a / (along_a - along_b));
    if (crossing.norm() <= kComingRound_m) return i + 1;
  }
  return points.at.size();
}

bool comes_round(const Points& points, double median_m) {
  const Vector2d gap = (points.at.front() - points.at.back()).head<2>();
  const Vector2d last = (points.at.back() - points.at[points.at.size() - 2]).head<2>();
  return gap.norm() <= std::max(kClosingGap_m, 5.0 * median_m) &&
         angle(last, gap) < 60.0 * kRadPerDeg && angle(gap, points.step(0)) < 60.0 * kRadPerDeg;
}

/// d/ds at point i from the parabola through its neighbours, spaced by their distance.
Vector3d tangent(const Points& points, bool closed, std::size_t i, const Vector3d& straight) {
  const std::size_t n = points.at.size();
  if (!closed && (i == 0 || i + 1 == n)) return straight;
  const Vector3d& before = points.at[(i + n - 1) % n];
  const Vector3d& here = points.at[i];
  const Vector3d& after = points.at[(i + 1) % n];
  const double a = (here - before).head<2>().norm(), b = (after - here).head<2>().norm();
  if (std::max(a, b) > 3.0 * std::min(a, b) ||
      angle((here - before).head<2>(), (after - here).head<2>()) > 30.0 * kRadPerDeg) {
    return straight;
  }
  return ((here - before) / a * b + (after - here) / b * a) / (a + b);
}

void densify(const Points& points, EdgeCurve& curve) {
  const std::size_t n = points.at.size(), segments = curve.closed ? n : n - 1;
  const auto add = [&](const Vector3d& p) {
    if (!curve.points_m.empty()) curve.length_m += (p - curve.points_m.back()).head<2>().norm();
    curve.points_m.push_back(p);
    curve.s_m.push_back(curve.length_m);
  };
  for (std::size_t i = 0; i < segments; ++i) {
    const Vector3d &p = points.at[i], &q = points.at[(i + 1) % n];
    const double length = (q - p).head<2>().norm();
    const Vector3d straight = (q - p) / length;
    const Vector3d from = tangent(points, curve.closed, i, straight) * length,
                   to = tangent(points, curve.closed, (i + 1) % n, straight) * length;
    add(p);
    curve.s_of_given_m.push_back(curve.length_m);
    curve.given_m.push_back(p);
    const auto pieces = static_cast<std::size_t>(std::ceil(length / kDense_m));
    for (std::size_t k = 1; k < pieces; ++k) {
      const double t = static_cast<double>(k) / static_cast<double>(pieces), r = 1.0 - t;
      add(p * (r * r * (1.0 + 2.0 * t)) + from * (r * r * t) + q * (t * t * (3.0 - 2.0 * t)) -
          to * (t * t * r));
    }
  }
  if (curve.closed) {
    curve.length_m += (curve.points_m.front() - curve.points_m.back()).head<2>().norm();
    return;
  }
  add(points.at.back());
  curve.s_of_given_m.push_back(curve.length_m);
  curve.given_m.push_back(points.at.back());
  // Straight on beyond both ends, level: a normal near an end may meet the other edge only there.
  const Vector3d begin = points.at.front(), end = points.at.back();
  Vector3d out_begin = begin - points.at[1], out_end = end - points.at[n - 2];
  out_begin.z() = out_end.z() = 0.0;
  curve.points_m.insert(curve.points_m.begin(), begin + out_begin.normalized() * kExtension_m);
  curve.s_m.insert(curve.s_m.begin(), -kExtension_m);
  curve.points_m.push_back(end + out_end.normalized() * kExtension_m);
  curve.s_m.push_back(curve.length_m + kExtension_m);
}

}  // namespace

EdgeCurve edge_curve(const Edge& edge, bool reversed) {
  Points points;
  const std::size_t given = edge.points_m.size();
  for (std::size_t k = 0; k < given; ++k) {
    const std::size_t i = reversed ? given - 1 - k : k;
    if (!points.at.empty() && (edge.points_m[i] - points.at.back()).head<2>().norm() < kRepeated_m)
      continue;
    points.at.push_back(edge.points_m[i]);
    points.source.push_back(i);
  }
  const auto refuse_few = [&] {
    if (points.at.size() < 4) {
      throw Error(fmt::format("{}: {} different points; wanted at least 4 along the edge",
                              edge.path, points.at.size()));
    }
  };
  refuse_few();
  EdgeCurve curve;
  curve.path = edge.path;
  take_out_spikes(edge, points, curve.remarks);
  refuse_few();
  refuse_turning_back(edge, points);

  const bool ends_at_start = (points.at.front() - points.at.back()).head<2>().norm() < kRepeated_m;
  const std::size_t lap = ends_at_start ? points.at.size() - 1 : one_lap(points);
  curve.closed = ends_at_start || lap < points.at.size();
  if (!ends_at_start && lap < points.at.size()) {
    curve.remarks.push_back(
        fmt::format("{}: the edge has come round to its start; {} rows after that are left out",
                    place(edge, points.source[lap]), points.at.size() - lap));
  }
  points.at.resize(lap);
  points.source.resize(lap);
  refuse_few();
  curve.dropped = given - points.at.size();

  std::vector<double> steps;
  for (std::size_t i = 0; i + 1 < points.at.size(); ++i) steps.push_back(points.step(i).norm());
  double total = 0.0;
  for (const double step : steps) total += step;
  if (!(total <= kLongest_m)) {
    throw Error(
        fmt::format("{}: the edge is {:.0f} m long; wanted at most {:.0f} m; are these metres?",
                    edge.path, total, kLongest_m));
  }
  std::vector<double> sorted = steps;
  std::sort(sorted.begin(), sorted.end());
  const double median = sorted[sorted.size() / 2];
  if (!curve.closed) curve.closed = comes_round(points, median);
  const double gap_m = (points.at.front() - points.at.back()).head<2>().norm();
  if (curve.closed && !edge.keep_open && gap_m > kUnusualGap * median)
    curve.remarks.push_back(
        fmt::format("{}: {:.1f} m from its last point to its first, taken as straight; --open "
                    "keeps the road open there",
                    edge.path, gap_m));
  if (edge.keep_open) curve.closed = false;
  const auto widest = std::max_element(steps.begin(), steps.end());
  if (*widest > std::max(20.0, 10.0 * median)) {
    curve.remarks.push_back(fmt::format(
        "{}: {:.1f} m without a point; taken as straight",
        place(edge, points.source[static_cast<std::size_t>(widest - steps.begin())]), *widest));
  }
  densify(points, curve);
  return curve;
}

Vector3d EdgeCurve::at(double s) const {
  if (closed) s -= std::floor(s / length_m) * length_m;
  const auto next = std::upper_bound(s_m.begin(), s_m.end(), s);
  if (next == s_m.begin()) return points_m.front();
  const auto i = static_cast<std::size_t>(next - s_m.begin()) - 1;
  const bool last = i + 1 == points_m.size();
  if (last && !closed) return points_m.back();
  const Vector3d& to = points_m[last ? 0 : i + 1];
  const double end_s = last ? length_m : s_m[i + 1];
  return points_m[i] + (to - points_m[i]) * ((s - s_m[i]) / std::max(1e-12, end_s - s_m[i]));
}

EdgeMeeting meet_edge(const EdgeCurve& curve, double s_guess_m, double reach_m,
                      const Vector2d& from, const Vector2d& normal) {
  const auto n = static_cast<std::ptrdiff_t>(curve.points_m.size());
  const Vector2d along(normal.y(), -normal.x());
  double wrapped = s_guess_m, laps = 0.0;
  if (curve.closed) {
    laps = std::floor(s_guess_m / curve.length_m) * curve.length_m;
    wrapped -= laps;
  }
  const auto start = std::max<std::ptrdiff_t>(
      0, std::upper_bound(curve.s_m.begin(), curve.s_m.end(), wrapped) - curve.s_m.begin() - 1);
  EdgeMeeting best;
  // Segments start, start + 1, start - 1, ...: the first that is met lies nearest to the guess.
  bool forward_on = true, back_on = true;
  for (std::ptrdiff_t k = 0; (forward_on || back_on) && k <= n; ++k) {
    for (const std::ptrdiff_t sign : {+1, -1}) {
      bool& on = sign > 0 ? forward_on : back_on;
      if (!on || (k == 0 && sign < 0)) continue;
      const std::ptrdiff_t raw = start + sign * k;
      if (!curve.closed && (raw < 0 || raw + 1 >= n)) {
        on = false;
        continue;
      }
      const std::ptrdiff_t turns = raw >= 0 ? raw / n : -((n - 1 - raw) / n);
      const auto i = static_cast<std::size_t>(raw - turns * n);
      const std::size_t j = i + 1 == static_cast<std::size_t>(n) ? 0 : i + 1;
      const double s0 = curve.s_m[i] + static_cast<double>(turns) * curve.length_m;
      const double s1 = s0 + (j == 0 ? curve.length_m - curve.s_m[i] : curve.s_m[j] - curve.s_m[i]);
      if (sign > 0 ? s0 - wrapped > reach_m : wrapped - s1 > reach_m) {
        on = false;
        continue;
      }
      const Vector3d &p = curve.points_m[i], &q = curve.points_m[j];
      const double a = (p.head<2>() - from).dot(along), b = (q.head<2>() - from).dot(along);
      if ((a > 0.0) == (b > 0.0)) continue;
      const double t = a / (a - b);
      const Vector3d hit = p + t * (q - p);
      const double s = s0 + t * (s1 - s0) + laps;
      if (!best.found || std::abs(s - s_guess_m) < std::abs(best.s_m - s_guess_m)) {
        best = {true, (hit.head<2>() - from).dot(normal), s, hit.z()};
      }
    }
    if (best.found) return best;
  }
  return best;
}

EdgeMeeting nearest_on_edge(const EdgeCurve& curve, double s_guess_m, double reach_m,
                            const Vector2d& from) {
  EdgeMeeting best;
  const auto look = [&](double around_m, double within_m, double step_m) {
    for (double s_m = around_m - within_m; s_m <= around_m + within_m; s_m += step_m) {
      if (!curve.closed && (s_m < 0.0 || s_m > curve.length_m)) continue;
      const Vector3d p = curve.at(s_m);
      const double distance_m = (p.head<2>() - from).norm();
      if (!best.found || distance_m < best.v_m) best = {true, distance_m, s_m, p.z()};
    }
  };
  constexpr double kCoarse_m = 1.0;
  look(s_guess_m, reach_m, kCoarse_m);
  if (best.found) look(best.s_m, kCoarse_m, kDense_m);
  return best;
}

}  // namespace road
