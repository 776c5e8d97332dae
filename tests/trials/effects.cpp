#include "effects.h"

#include <algorithm>
#include <numbers>

namespace trials {
namespace {

/// A cosine bell of height 1 over the stretch, flat in the middle half.
double bell(const Effect& e, double s, double length) {
  const double u = std::fmod(s + length, length);
  if (u < e.begin_m || u > e.end_m) return 0;
  const double edge = 0.15 * (e.end_m - e.begin_m), d = std::min(u - e.begin_m, e.end_m - u);
  return d >= edge ? 1.0 : 0.5 - 0.5 * std::cos(std::numbers::pi * d / edge);
}

}  // namespace

double amount(const TruthCar& car, const char* mechanism) {
  double sum = 0;
  for (const Effect& e : car.effects)
    if (e.mechanism == mechanism) sum += e.amount;
  return sum;
}

double factor(const TruthCar& car, const char* mechanism) {
  for (const Effect& e : car.effects)
    if (e.mechanism == mechanism) return e.amount;
  return 1;
}

double road_extra(const TruthCar& car, const char* mechanism, double s, double length) {
  double sum = 0;
  for (const Effect& e : car.effects)
    if (e.mechanism == mechanism) sum += e.amount * bell(e, s, length);
  return sum;
}

double true_bank(const TruthCar& car, const Track& track, double s) {
  return track.bank(s) + road_extra(car, "road.banking", s, track.length_m);
}

Warp warp(const TruthCar& car, const Track& track, double s, double v) {
  constexpr double h = 2.0;
  const double before = true_bank(car, track, s - h), here = true_bank(car, track, s),
               after = true_bank(car, track, s + h);
  return {v * (after - before) / (2 * h), v * (after - 2 * here + before) / (h * h)};
}

RoadBelow road_below(const TruthCar& car, const Track& track, const State& x, double s, double vx,
                     const Warp& warped) {
  const double turned = x[2] - track.at(s).heading;
  const double up_along =
                   track.grade(s) + road_extra(car, "road.grade", s, track.length_m) + warped.grade,
               up_across = true_bank(car, track, s);
  const double vertical = warped.vertical + track.vertical(s) +
                          road_extra(car, "road.vertical_curvature", s, track.length_m);
  RoadBelow out{};
  out.grade = up_along * std::cos(turned) + up_across * std::sin(turned);
  out.bank = up_across * std::cos(turned) - up_along * std::sin(turned);
  // What presses on a leaning road is its own curvature: z = v bank falls away beside a straight.
  out.plus = kGravity + (vertical - out.bank * track.at(s).curvature) * vx * vx;
  out.grip = 1 + road_extra(car, "road.friction", s, track.length_m);
  return out;
}

Air air_past(const TruthCar& car, const State& x, double vx, double vy) {
  double wx = 0, wy = 0;
  for (const Effect& e : car.effects)
    if (e.mechanism == "environment.wind")
      wx += e.amount * std::cos(e.extra), wy += e.amount * std::sin(e.extra);
  return {vx - (wx * std::cos(x[2]) + wy * std::sin(x[2])),
          vy - (-wx * std::sin(x[2]) + wy * std::cos(x[2]))};
}

}  // namespace trials
