// The line a lap is driven on, and how fast.
#pragma once

#include <cstddef>
#include <vector>

#include "crg/surface.h"
#include "vehicle/car.h"

namespace vehicle {

/// A path over a road at stations of equal u, closed or open. All vectors have the same length.
struct RacingLine {
  bool closed = false;
  double u_begin_m = 0.0, u_step_m = 1.0;
  std::vector<double> v_m;  ///< offset from the reference line
  std::vector<double> x_m, y_m;
  std::vector<double> s_m;            ///< arc length from the first station
  double length_m = 0.0;              ///< of the whole path, round to the first station if closed
  std::vector<double> curvature_1pm;  ///< left turn positive
  std::vector<double> heading_rad;    ///< unwrapped
  std::vector<double> bank;           ///< m/m across the path, rise to the left
  std::vector<double> grade;          ///< m/m along the path
  std::vector<double> vertical_curvature_1pm;  ///< of the path seen from the side, dip positive
  /// The road's factor on the tyres' grip: the least within 1 m to either side, halfway to the
  /// stations beside.
  std::vector<double> friction;
  std::vector<double> speed_mps;  ///< filled by plan_speed
  /// What the driver takes for the engine, N m over rad/s and throttle (steady_engine.h), filled by
  /// plan_speed; empty: the car's engine map.
  Map2 engine_torque_nm;
};

struct RacingLineOptions {
  double station_m = 4.0;  ///< spacing; short against the shortest corner
  double margin_m = 2.0;   ///< centre of the car to the edge of valid road: half a car and reserve
  int rounds = 400;        ///< at most, of the optimisation
};

/// The path of least integral of the squared curvature (over its own length, in plan) that keeps
/// `margin_m` from the edges of the valid road and from the nearest hole. Deterministic. Throws
/// Error where the road is narrower than twice the margin.
RacingLine plan_line(const crg::Surface& road, const RacingLineOptions& options = {});

/// The largest margin_m for which plan_line finds a line: half of the road's narrowest place.
double largest_margin_m(const crg::Surface& road, const RacingLineOptions& options = {});

struct SpeedOptions {
  double grip_usage = 0.75;  ///< share of the tyres' peak friction the driver uses
  double tyre_k = 360.0;     ///< temperature of the tyres he reckons with
  double fuel_kg = 30.0;
  double top_mps = 110.0;
  bool standing_start = false;
  double begin_mps = 0.0;  ///< open road: speed at its begin; 0: as fast as the engine holds there
};

/// Fills line.engine_torque_nm where the car has the full turbocharged engine, and line.speed_mps:
/// everywhere at most what the car can corner, brake and accelerate with,
/// from its own tyres, mass, drag, downforce and engine, quasi-statically, with bank, grade,
/// vertical curvature and friction of the road.
void plan_speed(RacingLine& line, const Car<double>& car, const SpeedOptions& options);

}  // namespace vehicle
