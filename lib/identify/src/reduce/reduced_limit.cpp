#include <algorithm>
#include <cmath>

#include "reduce_fit.h"

namespace identify {

double steady_limit(const ReducedCar& car, PlanarState in, bool two_tracks, double most_rad) {
  constexpr double kStep_rad = 0.008;
  const double most_missing_n = 0.01 * car.mass_kg * in.an_mps2;
  const auto at = [&](double front_rad, double rear_rad) {
    ReducedForces out;
    for (int round = 0; round < 3; ++round) {  // the yaw rate belongs to the lateral acceleration
      in.vy_mps = -std::tan(rear_rad) * in.vx_mps + car.rear_m * in.yaw_rate_radps;
      in.steer_rad =
          front_rad + std::atan((in.vy_mps + car.front_m * in.yaw_rate_radps) / in.vx_mps);
      out = two_tracks ? double_track(car, in) : single_track(car, in);
      const double yaw_rate = out.ay_mps2 / in.vx_mps;
      const bool settled = std::abs(yaw_rate - in.yaw_rate_radps) < 1e-4;
      in.yaw_rate_radps = yaw_rate;
      if (settled) break;
    }
    return out;
  };
  // One slip angle grows, the other is the one without yaw moment; both ways, as either axle may
  // be the first at its limit.
  double most = 0.0;
  for (const bool front_grows : {true, false}) {
    in.yaw_rate_radps = 0.0;
    double other = 0.0, most_n = 0.0;
    const int steps = static_cast<int>(std::ceil(most_rad / kStep_rad));
    for (int step = 1; step <= steps; ++step) {
      const double grows = most_rad * step / steps;
      const double sign = front_grows ? 1.0 : -1.0;  // of the moment over the growing angle
      double low = std::max(-0.02, other - 0.03), high = std::min(most_rad, other + 0.05);
      ReducedForces found;
      const auto moment = [&](double x) {
        found = front_grows ? at(grows, x) : at(x, grows);
        return sign * found.yaw_moment_nm;
      };
      double at_low = moment(low), at_high = moment(high);
      if (at_low < 0.0 || at_high > 0.0) {
        other = at_low < 0.0 ? low : high;  // no balance here: may come back
        continue;
      }
      for (int i = 0; i < 14 && high - low > 2e-5; ++i) {
        other =
            i % 3 == 2 ? 0.5 * (low + high) : (low * -at_high + high * at_low) / (at_low - at_high);
        const double m = moment(other);
        (m > 0.0 ? low : high) = other;
        (m > 0.0 ? at_low : at_high) = m;
      }
      const double force_n = found.axle_fy_n[front_grows ? 0 : 1];
      if (force_n < kPastPeak * most_n) break;  // from here on the car slides
      most_n = std::max(most_n, force_n);
      if (found.missing_n < most_missing_n) most = std::max(most, found.ay_mps2);
    }
  }
  return most;
}

}  // namespace identify
