#include "edge_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh/error.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kReach_m = 30.0;  // along an edge, around where it should be met
constexpr double kNear_m = 15.0;   // the same, where it is nearest
// A normal that goes this many times as far to an edge as the nearest way is not square to it.
constexpr double kSlanted = 1.5, kSlack_m = 0.5;

// A closed line starts this much before the first row of LEFT: between its last node and its first
// is a gap of 1 mm, wider on the outside of a bend, in which a query finds no height.
constexpr double kSeamMargin_m = 5e-3;

/// A place on the line or straight on beyond it; u from its first node.
struct LinePlace {
  Vector2d at, heading;
};

LinePlace place_on(const crg::ReferenceLine& line, double u) {
  if (line.closed) {
    const double length = line.u_step_m * static_cast<double>(line.size() - 1);
    u -= std::floor(u / length) * length;
  }
  const double position = u / line.u_step_m;
  const auto i =
      static_cast<std::size_t>(std::clamp(position, 0.0, static_cast<double>(line.size() - 2)));
  const double t = position - static_cast<double>(i);
  const Vector2d a(line.x_m[i], line.y_m[i]), b(line.x_m[i + 1], line.y_m[i + 1]);
  const double h0 = line.heading_rad[i + 1];  // of this segment
  const bool inside = t >= 0.0 && t <= 1.0;
  double before = h0, after = h0;
  if (i > 0)
    before = line.heading_rad[i];
  else if (line.closed)
    before = h0 - std::remainder(h0 - line.heading_rad.back(), 2.0 * std::numbers::pi);
  if (i + 2 < line.size())
    after = line.heading_rad[i + 2];
  else if (line.closed)
    after = h0 + std::remainder(line.heading_rad[1] - h0, 2.0 * std::numbers::pi);
  const double heading = !inside   ? h0
                         : t < 0.5 ? h0 + (before - h0) * (0.5 - t)
                                   : h0 + (after - h0) * (t - 0.5);
  return {a + t * (b - a), {std::cos(heading), std::sin(heading)}};
}

/// u of the place whose normal goes through p, searched from u_guess.
double beside(const crg::ReferenceLine& line, const Vector2d& p, double u_guess) {
  double u = u_guess;
  for (int i = 0; i < 50; ++i) {
    const LinePlace here = place_on(line, u);
    const double step = std::clamp((p - here.at).dot(here.heading), -5.0, 5.0);
    u += step;
    if (std::abs(step) < 1e-7) break;
  }
  return u;
}

}  // namespace

EdgeSection cut_edges(const EdgeCurve& left, const EdgeCurve& right, const Rung& guess,
                      const Vector2d& at, const Vector2d& normal) {
  // In bends about as tight as half the road the normal may miss an edge, or meet it far behind the
  // bend: then the edge lies where it is nearest.
  const auto met = [&](const EdgeCurve& curve, double s_guess_m, double side) {
    EdgeMeeting by_normal = meet_edge(curve, s_guess_m, kReach_m, at, normal);
    EdgeMeeting nearest = nearest_on_edge(curve, s_guess_m, kNear_m, at);
    if (!nearest.found ||
        (by_normal.found && std::abs(by_normal.v_m) <= kSlanted * nearest.v_m + kSlack_m))
      return by_normal;
    nearest.v_m *= side;
    return nearest;
  };
  return {met(left, guess.left_s_m, 1.0), met(right, guess.right_s_m, -1.0)};
}

void refuse_missed(const EdgeSection& section, const EdgeCurve& left, const EdgeCurve& right,
                   double u) {
  if (section.left.found && section.right.found) return;
  throw Error(
      fmt::format("{}: the edge does not run beside the road at u = {:.1f} m; wanted both edges "
                  "all along: a piece "
                  "may be missing, or a point far off",
                  (section.left.found ? right : left).path, u));
}

Centreline recut(const EdgeCurve& left, const EdgeCurve& right, const crg::ReferenceLine& line,
                 Rung guess, double share) {
  const double u_begin =
      beside(line, left.at(0.0).head<2>(), 0.0) - (left.closed ? kSeamMargin_m : 0.0);
  const double length = line.u_step_m * static_cast<double>(line.size() - 1);
  double u_end = u_begin + length;
  if (!left.closed) {
    u_end = std::min(beside(line, left.at(left.length_m).head<2>(), length),
                     beside(line, right.at(right.length_m).head<2>(), length));
  }
  const auto count =
      static_cast<std::size_t>(std::max(4.0, std::round((u_end - u_begin) / kStationStep_m)));
  Centreline out;
  out.closed = left.closed;
  for (std::size_t k = 0; k < (out.closed ? count : count + 1); ++k) {
    const double u =
        u_begin + (u_end - u_begin) * static_cast<double>(k) / static_cast<double>(count);
    const LinePlace here = place_on(line, u);
    const Vector2d normal(-here.heading.y(), here.heading.x());
    const EdgeSection section = cut_edges(left, right, guess, here.at, normal);
    refuse_missed(section, left, right, u - u_begin);
    guess = {section.left.s_m, section.right.s_m};
    const Vector2d middle = here.at + 0.5 * share * (section.left.v_m + section.right.v_m) * normal;
    if (!out.points_m.empty()) out.length_m += (middle - out.points_m.back().head<2>()).norm();
    out.points_m.emplace_back(middle.x(), middle.y(), 0.5 * (section.left.z_m + section.right.z_m));
    out.half_width_m.push_back(0.5 * (section.left.v_m - section.right.v_m));
  }
  if (out.closed) out.length_m += (out.points_m.front() - out.points_m.back()).head<2>().norm();
  return out;
}

}  // namespace road
