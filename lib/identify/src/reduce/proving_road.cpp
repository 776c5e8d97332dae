#include "identify/proving_road.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace identify {
namespace {

constexpr double kStep_m = 0.25;
constexpr double kEase_m = 40.0;  // from one curvature to the next

/// A piece of the plan: length with its transition at the begin, radius (0: straight on, left turns
/// positive), slope upwards to the left.
struct Piece {
  double length_m, radius_m, bank;
};

constexpr std::array<Piece, 13> kPieces{{{250.0, 0.0, 0.0},
                                         {230.0, 150.0, 0.0},
                                         {160.0, 0.0, 0.0},
                                         {110.0, -60.0, 0.1},
                                         {160.0, 0.0, 0.0},
                                         {60.0, -28.0, 0.0},
                                         {200.0, 0.0, 0.0},
                                         {190.0, 90.0, -0.1},
                                         {60.0, 0.0, 0.0},
                                         {150.0, -90.0, 0.0},
                                         {260.0, 0.0, 0.0},
                                         {80.0, 45.0, 0.0},
                                         {160.0, 0.0, 0.0}}};

double smooth(double t) { return t <= 0.0 ? 0.0 : t >= 1.0 ? 1.0 : t * t * (3.0 - 2.0 * t); }

/// Curvature or bank at a length along the plan.
struct Shape {
  double curvature_1pm = 0.0, bank = 0.0;
};
Shape shape_at(double s_m) {
  Shape before;
  double begin_m = 0.0;
  for (const Piece& piece : kPieces) {
    const Shape wanted{piece.radius_m == 0.0 ? 0.0 : 1.0 / piece.radius_m, piece.bank};
    if (s_m <= begin_m + piece.length_m) {
      const double share = smooth((s_m - begin_m) / kEase_m);
      return {before.curvature_1pm + share * (wanted.curvature_1pm - before.curvature_1pm),
              before.bank + share * (wanted.bank - before.bank)};
    }
    begin_m += piece.length_m;
    before = wanted;
  }
  return before;
}

/// A dip on the straight behind the first turn, a crest on the long straight near the end.
double height_at(double s_m) {
  const auto wave = [&](double begin_m, double length_m, double deep_m) {
    const double t = (s_m - begin_m) / length_m;
    if (t <= 0.0 || t >= 1.0) return 0.0;
    return 0.5 * deep_m * (1.0 - std::cos(2.0 * std::numbers::pi * t));
  };
  return wave(280.0, 360.0, -10.0) + wave(1500.0, 360.0, 10.0);
}

}  // namespace

crg::Crg proving_road() {
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = kStep_m;
  for (int j = -10; j <= 10; ++j) grid.v_m.push_back(0.5 * j);
  double whole_m = 0.0;
  for (const Piece& piece : kPieces) whole_m += piece.length_m;
  const auto rows = static_cast<std::size_t>(whole_m / kStep_m) + 1;
  double x = 0.0, y = 0.0, heading = 0.0, into = 0.0;  // into: of the segment before
  for (std::size_t i = 0; i < rows; ++i) {
    const double s = kStep_m * static_cast<double>(i);
    line.heading_rad.push_back(into);
    line.x_m.push_back(x);
    line.y_m.push_back(y);
    const double bank = shape_at(s).bank, height = height_at(s);
    for (const double v : grid.v_m) grid.z_m.push_back(static_cast<float>(height + bank * v));
    // One row on with the curvature in the middle.
    const double turn = kStep_m * shape_at(s + 0.5 * kStep_m).curvature_1pm;
    into = heading + 0.5 * turn;
    x += kStep_m * std::cos(into);
    y += kStep_m * std::sin(into);
    heading += turn;
  }
  return crg::make_crg(line, std::move(grid));
}

}  // namespace identify
