#include "ride.h"

#include <algorithm>

namespace trials {
namespace {

/// Height of the road that the wheel sees: a circle rolled over it, then the mean over the contact.
double seen(const Track& track, double s, double v, bool envelops) {
  if (!envelops || track.feature.empty()) return track.rough(s, v);
  constexpr double kRadius = 0.32, kReach = 0.12, kContact = 0.10;
  double sum = 0;
  constexpr int kParts = 4;
  for (int part = 0; part <= kParts; ++part) {
    const double at = s + kContact * (static_cast<double>(part) / kParts - 0.5);
    double top = -1;
    for (int k = -6; k <= 6; ++k) {
      const double x = kReach * k / 6.0;
      top = std::max(top, track.rough(at + x, v) + std::sqrt(kRadius * kRadius - x * x) - kRadius);
    }
    sum += top;
  }
  return sum / (kParts + 1);
}

}  // namespace

void shake(Drive& drive, const Track& track, const TruthCar& car, const Ride& ride) {
  constexpr double h = 0.0005;
  const double wheelbase = car.a + car.b;
  const std::array<double, 4> lx{car.a, car.a, -car.b, -car.b};
  const std::array<double, 4> ly{car.track_f / 2, -car.track_f / 2, car.track_r / 2,
                                 -car.track_r / 2};
  double body = car.mass;
  for (const double m : ride.unsprung) body -= 2 * m;
  // Deviations from standing on the plane; heights are those of the road below the wheels.
  double z = 0, roll = 0, pitch = 0, dz = 0, droll = 0, dpitch = 0;
  std::array<double, 4> w{}, dw{};
  bool placed = false;
  std::array<double, 4> last{};
  for (std::size_t k = 0; k < drive.row.size(); ++k) {
    auto& row = drive.row[k];
    std::array<double, 4> road{};
    const double along = row[kYaw] - track.at(row[kS]).heading;
    for (std::size_t i = 0; i < 4; ++i) {
      const double s = row[kS] + lx[i] * std::cos(along) - ly[i] * std::sin(along),
                   v = row[kV] + lx[i] * std::sin(along) + ly[i] * std::cos(along);
      road[i] = track.height(s) + v * true_bank(car, track, s) + seen(track, s, v, ride.envelops);
    }
    if (!placed) {
      z = 0.25 * (road[0] + road[1] + road[2] + road[3]);
      w = road;
      last = road;
      placed = true;
    }
    const double q = 0.5 * car.density * row[kVx] * row[kVx];
    double ddz = 0;
    std::array<double, 4> load{};
    for (int step = 0; step < 10; ++step) {
      const double part = (step + 1) / 10.0;
      // A left turn rolls the body to the right, driving lifts the nose.
      double force = 0, mx = car.mass * row[kAy] * car.h, my = -car.mass * row[kAx] * car.h;
      std::array<double, 4> up{};
      for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t axle = i / 2, other = i ^ 1u;
        const double corner = z - lx[i] * pitch + ly[i] * roll,
                     dcorner = dz - lx[i] * dpitch + ly[i] * droll;
        const double corner_other = z - lx[other] * pitch + ly[other] * roll;
        const double travel = w[i] - corner, rate = dw[i] - dcorner;
        up[i] = ride.spring[axle] * travel + ride.damping[axle] * rate +
                ride.bar[axle] * (travel - (w[other] - corner_other));
        force += up[i];
        mx += ly[i] * up[i];
        my += -lx[i] * up[i];
        const double down = q * (axle == 0 ? car.lift_f : car.lift_r) / 2;
        force -= down;
        my += lx[i] * down;
      }
      ddz = force / body;
      dz += h * ddz;
      droll += h * mx / ride.roll_inertia;
      dpitch += h * my / ride.pitch_inertia;
      for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t axle = i / 2;
        const double ground = last[i] + part * (road[i] - last[i]),
                     dground = (road[i] - last[i]) / 0.005;
        const double standing = car.mass * kGravity * (axle == 0 ? car.b : car.a) / wheelbase / 2;
        load[i] = std::max(
            0.0, standing + ride.tyre * (ground - w[i]) + ride.tyre_damping * (dground - dw[i]));
        dw[i] += h * (load[i] - standing - up[i]) / ride.unsprung[axle];
        w[i] += h * dw[i];
      }
      z += h * dz;
      roll += h * droll;
      pitch += h * dpitch;
    }
    last = road;
    row[kAz] = kGravity + ddz -
               true_bank(car, track, row[kS]) * track.at(row[kS]).curvature * row[kVx] * row[kVx];
    row[kRollRate] = droll;
    row[kPitchRate] = dpitch;
    for (std::size_t i = 0; i < 4; ++i) {
      row[kTravel + i] = w[i] - (z - lx[i] * pitch + ly[i] * roll);
      row[kLoad + i] = load[i];
    }
  }
}

void heat(Drive& drive, const TruthCar& car, const Discs& discs) {
  constexpr double kAir = 295;
  std::array<double, 2> ring{discs.begin_k, discs.begin_k}, hat = ring;
  for (auto& row : drive.row) {
    for (std::size_t axle = 0; axle < 2; ++axle) {
      const double omega =
          axle == 0 ? 0.5 * (row[kWfl] + row[kWfr]) : 0.5 * (row[kWrl] + row[kWrr]);
      const double power =
          0.9 * 0.5 * (axle == 0 ? car.brake_f : car.brake_r) * row[kBrake] * std::max(0.0, omega);
      constexpr int kParts = 5;
      for (int part = 0; part < kParts; ++part) {
        // Enthalpies: capacity rises by 6e-4 per kelvin. Film coefficient and radiation of a plain
        // disc.
        const double g = discs.conductance[axle] *
                         std::exp(discs.slope_1pk * (0.5 * (ring[axle] + hat[axle]) - 480));
        const double film =
            0.0095 * std::pow(row[kVx] + 3.0, 0.8) * (axle == 0 ? 120.0 : 104.0) * 0.11;
        const double glow = 0.55 * 5.67e-8 * (axle == 0 ? 0.11 : 0.095) *
                            (std::pow(ring[axle], 4) - std::pow(kAir, 4));
        const double flow = g * (ring[axle] - hat[axle]);
        ring[axle] += 0.005 / kParts * (power - flow - film * 12 * (ring[axle] - kAir) - glow) /
                      (discs.ring[axle] * (1 + 6e-4 * (ring[axle] - 300)));
        hat[axle] += 0.005 / kParts * flow / (discs.hat[axle] * (1 + 6e-4 * (hat[axle] - 300)));
      }
      row[kDisc + 2 * axle] = row[kDisc + 2 * axle + 1] = ring[axle];
    }
  }
}

}  // namespace trials
