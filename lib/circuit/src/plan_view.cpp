#include "plan_view.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "mesh/error.h"

namespace road {
namespace {

// Spirals beyond take hours; no track has such.
constexpr double kMostTurned = 8.0 * std::numbers::pi;

// 10-point Gauss-Legendre rule on [-1, 1] (Abramowitz & Stegun, table 25.4).
constexpr std::array<double, 5> kGaussNode = {0.1488743389816312, 0.4333953941292472,
                                              0.6794095682990244, 0.8650633666889845,
                                              0.9739065285171717};

constexpr std::array<double, 5> kGaussWeight = {0.2955242247147529, 0.2692667193099963,
                                                0.2190863625159820, 0.1494513491505806,
                                                0.0666713443086881};

double heading_change(const PlanSegment& segment) {
  return 0.5 * (segment.curvature_begin_1pm + segment.curvature_end_1pm) * segment.length_m;
}

PlanPose end_of_plan(const CircuitDesign& design) {
  PlanPose pose{design.start_x_m, design.start_y_m, design.start_heading_rad};
  for (const PlanSegment& segment : design.plan) pose = advance(pose, segment, segment.length_m);
  return pose;
}

}  // namespace

/// x = integral of cos(heading), heading quadratic in s.
PlanPose advance(const PlanPose& start, const PlanSegment& segment, double s_m) {
  const double k0 = segment.curvature_begin_1pm;
  const double rate =
      segment.length_m > 0.0 ? (segment.curvature_end_1pm - k0) / segment.length_m : 0.0;
  const auto heading = [&](double s) { return start.heading_rad + s * (k0 + 0.5 * rate * s); };
  PlanPose end{start.x_m, start.y_m, heading(s_m)};
  if (rate == 0.0) {
    // sin(a)/a keeps full precision for straights and flat arcs: chord along the mean heading.
    const double half = 0.5 * k0 * s_m;
    const double chord = std::abs(half) < 1e-8 ? s_m : s_m * std::sin(half) / half;
    end.x_m += chord * std::cos(start.heading_rad + half);
    end.y_m += chord * std::sin(start.heading_rad + half);
    return end;
  }
  const double turned =
      s_m * std::max(std::abs(k0), std::abs(k0 + rate * s_m));  // bound on the heading change
  const int panels = 1 + static_cast<int>(turned / 0.5);
  const double panel = s_m / panels;
  for (int i = 0; i < panels; ++i) {
    const double middle = (i + 0.5) * panel;
    double dx = 0.0;
    double dy = 0.0;
    for (std::size_t k = 0; k < kGaussNode.size(); ++k) {
      for (const double sign : {-1.0, 1.0}) {
        const double angle = heading(middle + sign * 0.5 * panel * kGaussNode[k]);
        dx += kGaussWeight[k] * std::cos(angle);
        dy += kGaussWeight[k] * std::sin(angle);
      }
    }
    end.x_m += 0.5 * panel * dx;
    end.y_m += 0.5 * panel * dy;
  }
  return end;
}

void check_plan(const CircuitDesign& design) {
  if (design.plan.empty()) throw Error(design.name + ": plan is empty; give at least one segment");
  const std::size_t n = design.plan.size();
  for (std::size_t i = 0; i < n; ++i) {
    const PlanSegment& segment = design.plan[i];
    if (!std::isfinite(segment.length_m) || segment.length_m < 0.0 ||
        (segment.length_m == 0.0 && !segment.solve_length)) {
      throw Error(fmt::format("{}: plan segment {} is {} m long; give a positive length",
                              design.name, i, segment.length_m));
    }
    const double turned = segment.length_m * std::max(std::abs(segment.curvature_begin_1pm),
                                                      std::abs(segment.curvature_end_1pm));
    if (turned > kMostTurned) {
      throw Error(fmt::format("{}: plan segment {} turns up to {:.0f} deg; at most {:.0f} wanted",
                              design.name, i, turned / kDegree, kMostTurned / kDegree));
    }
    if (segment.solve_length &&
        (segment.curvature_begin_1pm != 0.0 || segment.curvature_end_1pm != 0.0)) {
      throw Error(fmt::format("{}: plan segment {} is curved; only straights can be solved for",
                              design.name, i));
    }
    if (i + 1 == n && !design.closed) break;
    const double jump = design.plan[(i + 1) % n].curvature_begin_1pm - segment.curvature_end_1pm;
    if (std::abs(jump) > 1e-9) {
      throw Error(fmt::format(
          "{}: curvature jumps by {:.4g} 1/m after plan segment {}; put a clothoid between",
          design.name, jump, i));
    }
  }
}

void close_plan(CircuitDesign& design) {
  std::vector<std::size_t> unknown;
  double turned = 0.0;
  for (std::size_t i = 0; i < design.plan.size(); ++i) {
    if (design.plan[i].solve_length) unknown.push_back(i);
    turned += heading_change(design.plan[i]);
  }
  if (!design.closed) {
    if (!unknown.empty()) {
      throw Error(design.name + ": an open plan has nothing to solve for; give every length");
    }
    return;
  }
  const double full_turn = 2.0 * std::numbers::pi;
  const double excess = turned - full_turn * std::round(turned / full_turn);
  if (std::abs(excess) > 1e-9) {
    throw Error(
        fmt::format("{}: the plan turns {:.6f} deg, {:.6f} deg off a multiple of 360; change "
                    "the angle of a corner",
                    design.name, turned / kDegree, excess / kDegree));
  }
  if (!unknown.empty()) {
    if (unknown.size() != 2) {
      throw Error(fmt::format("{}: {} straights are to be solved; two are needed to close a plan",
                              design.name, unknown.size()));
    }
    std::array<double, 2> heading{};
    double angle = design.start_heading_rad;
    for (std::size_t i = 0, k = 0; i < design.plan.size(); ++i) {
      if (k < 2 && i == unknown[k]) heading[k++] = angle;
      angle += heading_change(design.plan[i]);
    }
    for (const std::size_t i : unknown) design.plan[i].length_m = 0.0;
    const PlanPose end = end_of_plan(design);
    Eigen::Matrix2d direction;
    direction << std::cos(heading[0]), std::cos(heading[1]), std::sin(heading[0]),
        std::sin(heading[1]);
    if (std::abs(direction.determinant()) < 0.02) {
      throw Error(design.name +
                  ": the two straights to be solved are nearly parallel; solve for two "
                  "that are not");
    }
    const Eigen::Vector2d length =
        direction.inverse() *
        Eigen::Vector2d(design.start_x_m - end.x_m, design.start_y_m - end.y_m);
    for (int k = 0; k < 2; ++k) {
      if (!(length[k] > 0.1)) {
        throw Error(
            fmt::format("{}: closing needs plan segment {} to be {:.3f} m long; lengthen the "
                        "straights that run against it",
                        design.name, unknown[static_cast<std::size_t>(k)], length[k]));
      }
      design.plan[unknown[static_cast<std::size_t>(k)]].length_m = length[k];
    }
  }
  const PlanPose end = end_of_plan(design);
  const double gap = std::hypot(end.x_m - design.start_x_m, end.y_m - design.start_y_m);
  if (gap > 1e-3) {
    throw Error(
        fmt::format("{}: the plan ends {:.3f} m from its start (at most 0.001 m); mark two "
                    "straights `length_m: solve`",
                    design.name, gap));
  }
}

}  // namespace road
