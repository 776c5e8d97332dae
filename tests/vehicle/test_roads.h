// Roads made of formulas for the tests of laps and contact.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>

#include "crg/surface.h"

/// A closed stadium, left turns: two straights of `straight_m`, two half circles of about
/// `radius_m`, 14 m wide, level. A polygon of equal steps, closed exactly.
inline crg::Crg stadium(double straight_m = 200.0, double radius_m = 40.0) {
  constexpr double kStep_m = 0.5;
  const auto straight_steps = static_cast<int>(std::lround(straight_m / kStep_m));
  const auto arc_steps = static_cast<int>(std::lround(std::numbers::pi * radius_m / kStep_m));
  crg::ReferenceLine line;
  line.u_step_m = kStep_m;
  line.closed = true;
  line.x_m.push_back(0.0);
  line.y_m.push_back(0.0);
  line.heading_rad.push_back(0.0);
  const auto go = [&](double heading_rad) {
    line.x_m.push_back(line.x_m.back() + kStep_m * std::cos(heading_rad));
    line.y_m.push_back(line.y_m.back() + kStep_m * std::sin(heading_rad));
    line.heading_rad.push_back(heading_rad);
  };
  for (int half = 0; half < 2; ++half) {
    for (int i = 0; i < straight_steps; ++i) go(half * std::numbers::pi);
    for (int i = 0; i < arc_steps; ++i) go((half + (i + 0.5) / arc_steps) * std::numbers::pi);
  }
  crg::Grid grid;
  grid.u_step_m = kStep_m;
  for (int j = -14; j <= 14; ++j) grid.v_m.push_back(0.5 * j);
  grid.z_m.assign(line.size() * grid.v_m.size(), 0.0f);
  return crg::make_crg(line, grid);
}

/// A closed figure of eight, 12 m wide, 1.1 km: bends of 70 m, joined by straights that cross, the
/// second time 6 m higher. A polygon of equal steps, closed exactly. The line lies 3 m to the right
/// of the road's middle, so at the crossing that of the other leg is nearer to a car.
inline crg::Crg figure_of_eight() {
  constexpr double kStep_m = 0.5;
  constexpr int kArcSteps = 586, kStraightSteps = 242;  // to the crossing; as many beyond it
  double lean_rad = 0.5;                                // of the straights, so that it closes
  const auto heading = [&](double share) {
    return -lean_rad + share * (std::numbers::pi + 2 * lean_rad);
  };
  for (int k = 0; k < 100; ++k) {
    double wide = 0.0;
    for (int i = 0; i < kArcSteps; ++i) wide += std::sin(heading((i + 0.5) / kArcSteps));
    lean_rad = std::asin(wide / (2 * kStraightSteps));
  }
  crg::ReferenceLine line;
  line.u_step_m = kStep_m;
  line.closed = true;
  line.x_m = line.y_m = {0.0};
  line.heading_rad = {-lean_rad};
  const auto go = [&](bool back, double share) {
    const double heading_rad = back ? std::numbers::pi - heading(share) : heading(share);
    line.x_m.push_back(line.x_m.back() + kStep_m * std::cos(heading_rad));
    line.y_m.push_back(line.y_m.back() + kStep_m * std::sin(heading_rad));
    line.heading_rad.push_back(heading_rad);
  };
  for (const bool back : {false, true}) {
    for (int i = 0; i < kArcSteps; ++i) go(back, (i + 0.5) / kArcSteps);
    for (int i = 0; i < 2 * kStraightSteps; ++i) go(back, 1.0);
  }
  crg::Grid grid;
  grid.u_step_m = kStep_m;
  for (int j = -6; j <= 18; ++j) grid.v_m.push_back(0.5 * j);
  grid.z_m.assign(line.size() * grid.v_m.size(), 0.0f);
  const double round = 2.0 * std::numbers::pi / static_cast<double>(line.size() - 1);
  for (std::size_t i = 0; i < line.size(); ++i)
    line.z_m.push_back(
        3.0 * (1.0 - std::cos(round * (static_cast<double>(i) - kArcSteps - kStraightSteps))));
  return crg::make_crg(line, grid);
}

/// A straight road along x, 10 m wide, nodes every step_m, z from a formula of u and v.
inline crg::Crg straight(double length_m, double step_m,
                         const std::function<double(double, double)>& z) {
  const auto n = static_cast<int>(std::lround(length_m / step_m));
  const auto m = static_cast<int>(std::lround(5.0 / step_m));
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = step_m;
  for (int j = -m; j <= m; ++j) grid.v_m.push_back(step_m * j);
  for (int i = 0; i <= n; ++i) {
    line.x_m.push_back(step_m * i);
    line.y_m.push_back(0.0);
    line.heading_rad.push_back(0.0);
    for (int j = -m; j <= m; ++j) grid.z_m.push_back(static_cast<float>(z(step_m * i, step_m * j)));
  }
  return crg::make_crg(line, grid);
}

/// A ramp that climbs `rise_m` per turn round a circle of 30 m radius, one and a half turns: the
/// last half turn lies above the first.
inline crg::Crg spiral(double rise_m) {
  crg::ReferenceLine line;
  crg::Grid grid;
  constexpr double kRadius = 30.0;
  const double turn = 2.0 * std::numbers::pi * kRadius;
  const int n = 600;
  line.u_step_m = grid.u_step_m = 1.5 * turn / n;
  for (int j = -4; j <= 4; ++j) grid.v_m.push_back(j);
  for (int i = 0; i <= n; ++i) {
    const double a = line.u_step_m * i / kRadius;
    line.x_m.push_back(kRadius * std::sin(a));
    line.y_m.push_back(kRadius * (1 - std::cos(a)));
    line.heading_rad.push_back(i == 0 ? 0.0 : a - 0.5 * line.u_step_m / kRadius);
    line.z_m.push_back(rise_m * line.u_step_m * i / turn);
    for (int j = -4; j <= 4; ++j) grid.z_m.push_back(0.0f);
  }
  return crg::make_crg(line, grid);
}
