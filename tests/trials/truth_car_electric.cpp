#include "truth_car_electric.h"

#include <algorithm>
#include <numbers>

#include "electric_tyre.h"

namespace trials {
namespace {

constexpr std::size_t kWheelState[4]{kWheelFl, kWheelFr, kWheelRl, kWheelRr};

/// Where a wheel stands, from the centre of gravity, ahead and to the left.
struct Place {
  double x, y;
};
Place place_of(const TruthCar& car, std::size_t wheel) {
  const double side = wheel % 2 == 0 ? 0.5 : -0.5;
  return wheel < 2 ? Place{car.a, side * car.track_f} : Place{-car.b, side * car.track_r};
}

/// How stiff the posts of an axle are, tyre included: where both wheels move alike, and against
/// each other.
double heave_npm(const Electric& e, std::size_t axle) {
  return e.spring[axle] * e.tyre_npm / (e.spring[axle] + e.tyre_npm);
}
double roll_npm(const Electric& e, std::size_t axle) {
  const double spring = e.spring[axle] + 2 * e.bar[axle];
  return spring * e.tyre_npm / (spring + e.tyre_npm);
}
double damping_nspm(const Electric& e, std::size_t axle) {
  const double share = e.tyre_npm / (e.spring[axle] + e.tyre_npm);
  return e.damping[axle] * share * share;
}

/// Loads of the wheels from where the body is.
std::array<double, 4> loads_of(const TruthCar& car, const State& x, double mass) {
  const Electric& e = *car.electric;
  std::array<double, 4> in{}, rate{}, load{};
  for (std::size_t i = 0; i < 4; ++i) {
    const Place p = place_of(car, i);
    in[i] = -(x[kHeave] + p.y * x[kHeave + 1] + p.x * x[kHeave + 2]);
    rate[i] = -(x[kHeaveRate] + p.y * x[kHeaveRate + 1] + p.x * x[kHeaveRate + 2]);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t axle = i / 2;
    const double both = 0.5 * (in[i] + in[i ^ 1u]);
    const double standing = 0.5 * mass * kGravity * (axle == 0 ? car.b : car.a) / (car.a + car.b);
    load[i] =
        std::max(50.0, standing + heave_npm(e, axle) * both + roll_npm(e, axle) * (in[i] - both) +
                           damping_nspm(e, axle) * rate[i]);
  }
  return load;
}

/// The body's own motion on its posts.
void move_body(const TruthCar& car, const std::array<double, 4>& load, double plus, double mass,
               double lift_f, double lift_r, double rolling_nm, double pitching_nm, const State& x,
               State& d) {
  double up = -lift_f - lift_r, roll = rolling_nm,
         pitch = pitching_nm - car.a * lift_f + car.b * lift_r;
  for (std::size_t i = 0; i < 4; ++i) {
    const Place p = place_of(car, i);
    up += load[i];
    roll += p.y * load[i];
    pitch += p.x * load[i];
  }
  for (std::size_t k = 0; k < 3; ++k) d[kHeave + k] = x[kHeaveRate + k];
  d[kHeaveRate] = up / mass - plus;
  d[kHeaveRate + 1] = roll / car.electric->roll_inertia;
  d[kHeaveRate + 2] = pitch / car.electric->pitch_inertia;
}

/// Share of their grip that the tyres have while they are cold.
double warmth(const TruthCar& car, const State& x, double turning, State& d) {
  double warm = 1;
  for (const Effect& e : car.effects)
    if (e.mechanism == "vehicle.tyre_thermal") {
      warm -= e.amount * (1 - x[10]);
      d[10] = (1 - x[10]) / e.extra * (0.3 + 0.7 * std::min(2.0, turning / 8));
    }
  return warm;
}

/// A wheel on the road: its force in the car's directions, and along itself.
struct Grip {
  double x, y, along;
  Tyre tyre;
};
Grip grip_of(const TruthCar& car, const State& x, std::size_t i, double load, double grip,
             double warm, double vx, State& d) {
  const bool front = i < 2, left = i % 2 == 0;
  const double nominal = front ? car.load_f : car.load_r,
               radius = front ? car.radius_f : car.radius_r;
  const Place p = place_of(car, i);
  const double px = vx - p.y * x[5], py = x[4] + p.x * x[5];
  const double c = front ? std::cos(x[kSteered]) : 1, s = front ? std::sin(x[kSteered]) : 0;
  const double along = std::max(3.0, px * c + py * s), across = py * c - px * s;
  const double relax = std::max(0.15, factor(car, "vehicle.tyre_relaxation"));
  const double lag_m = (front ? car.relaxation_f : car.relaxation_r) * relax *
                       (0.4 + 0.6 * std::min(2.5, load / nominal));
  d[kSlip + i] = (across / along - x[kSlip + i]) * along / lag_m;

  ElectricTyre tyre{car.electric->tyre, nominal, front ? car.mu_f : car.mu_r,
                    car.mu_load,        car.ck,  (front ? car.c_f : car.c_r) * (0.5 + 0.5 * warm)};
  tyre.mu *= grip * warm * (1 + amount(car, "parameter.tyre_grip"));
  const double kappa = std::clamp(x[kWheelState[i]] * radius / along - 1, -0.95, 0.95);
  const double sensitivity = factor(car, "vehicle.tyre_load_sensitivity"),
               combined = factor(car, "vehicle.tyre_combined_slip");
  TyreForce f = electric_tyre(tyre, load, sensitivity, kappa, x[kSlip + i]);
  if (combined != 1) {
    const double alone_x = electric_tyre(tyre, load, sensitivity, kappa, 0).x,
                 alone_y = electric_tyre(tyre, load, sensitivity, 0, x[kSlip + i]).y;
    f = {combined * f.x + (1 - combined) * alone_x, combined * f.y + (1 - combined) * alone_y};
  }
  f.y += (left ? -1 : 1) * amount(car, "vehicle.tyre_camber") * car.camber * load;
  return {f.x * c - f.y * s, f.x * s + f.y * c, f.x, {f.x, f.y, load, kappa, x[kSlip + i]}};
}

/// Wheels, motor and brakes; returns the torque that drives both rear wheels.
double turn_wheels(const TruthCar& car, const State& x, const std::array<Grip, 4>& grip, double bf,
                   double br, State& d) {
  const double ratio = car.ratio[0] * car.final_drive;
  double torque = car.engine_nm(0.5 * (x[kWheelRl] + x[kWheelRr]) * ratio, x[kOpened]);
  torque *= 1 + amount(car, "parameter.engine_torque") * (torque > 0 ? 1 : 0);
  for (const Effect& e : car.effects)
    if (e.mechanism == "outside.misfire" && std::fmod(x[16], 23.0) < 2.0)
      torque *= 1 - e.amount * x[kOpened];
  const double drive = torque * ratio * (torque > 0 ? car.efficiency : 1 / car.efficiency);
  const double couple = amount(car, "vehicle.differential") * 900 * (x[kWheelRl] - x[kWheelRr]);
  for (const std::size_t i : {0u, 1u})
    d[kWheelState[i]] = (-0.5 * bf - grip[i].along * car.radius_f) / car.wheel_inertia;
  // The motor turns with the mean of its wheels; an open differential leaves them their difference.
  const double left = -0.5 * br - grip[2].along * car.radius_r - couple,
               right = -0.5 * br - grip[3].along * car.radius_r + couple;
  const double mean =
      (drive + left + right) / (2 * car.wheel_inertia + car.engine_inertia * ratio * ratio);
  const double apart = 0.5 * (left - right) / car.wheel_inertia;
  d[kWheelRl] = mean + apart;
  d[kWheelRr] = mean - apart;
  return drive;
}

}  // namespace

TruthCar electric_car(TyreLaw tyre) {
  TruthCar car;
  car.electric.emplace();
  car.electric->tyre = tyre;
  car.mass = 980, car.a = 1.46, car.b = 1.39, car.h = 0.34, car.inertia = 1250;
  car.track_f = 1.60, car.track_r = 1.58;
  car.mu_f = 1.6, car.mu_r = 1.68, car.mu_load = 0.10, car.c_f = 21, car.c_r = 24, car.ck = 27;
  car.load_f = 2600, car.load_r = 2800;
  car.drag = 0.85, car.lift_f = 0.75, car.lift_r = 0.95, car.rolling = 0.0125;
  car.torque = 300, car.engine_drag = 28, car.engine_inertia = 0.045, car.wheel_inertia = 1.0;
  car.radius_f = 0.312, car.radius_r = 0.318;
  car.final_drive = 8.2, car.ratio = {1, 0, 0, 0, 0, 0}, car.efficiency = 0.97;
  car.brake_f = 1.1e-3, car.brake_r = 0.66e-3;
  return car;
}

double motor_nm(const TruthCar& car, double omega, double throttle) {
  const double most = car.torque * std::min(1.0, car.electric->base_radps / std::max(1.0, omega));
  return throttle * most - (1 - throttle) * car.engine_drag * std::min(1.0, omega / 120);
}

void electric_rates(const TruthCar& car, const Track& track, const State& x, const Commands& c,
                    double s, const Warp& warped, State& d, Output* out) {
  const Electric& e = *car.electric;
  const double vx = std::max(3.0, x[3]), vy = x[4], r = x[5];
  const RoadBelow road = road_below(car, track, x, s, vx, warped);
  const double mass = car.mass * (1 + amount(car, "parameter.mass"));
  const Air air = air_past(car, x, vx, vy);
  const double speed = std::hypot(air.x, air.y), q = 0.5 * car.density * air.x * speed;
  const double drag = q * car.drag * factor(car, "vehicle.aero_drag") *
                      (1 + amount(car, "parameter.drag")),
               side_air = 0.5 * car.density * 1.2 * speed * air.y;
  const double down = q * factor(car, "vehicle.aero_downforce") *
                      (1 + amount(car, "parameter.downforce")) *
                      (1 - amount(car, "vehicle.aero_ride_height") * (1 - std::exp(-q / 1500)));
  double fade = 1 + amount(car, "parameter.brake_gain");
  for (const Effect& f : car.effects)
    if (f.mechanism == "vehicle.brake_friction_temperature")
      fade *= 1 - f.amount * std::tanh(x[11]);
  const double bf = car.brake_f * x[kPressed] * fade, br = car.brake_r * x[kPressed] * fade;

  d.fill(0);
  d[kSteered] = (c.steer - x[kSteered]) / e.steer_s;
  d[kOpened] = (c.throttle - x[kOpened]) / e.throttle_s;
  d[kPressed] = (c.brake_pa - x[kPressed]) / e.brake_s;
  const double warm = warmth(car, x, std::abs(r * vx), d);
  const std::array<double, 4> load = loads_of(car, x, mass);
  std::array<Grip, 4> grip{};
  double fx = -drag, fy = -side_air, mz = 0.15 * side_air, pressed = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    grip[i] = grip_of(car, x, i, load[i], road.grip, warm, vx, d);
    const Place p = place_of(car, i);
    const double along = grip[i].x - car.rolling * load[i];
    fx += along;
    fy += grip[i].y;
    mz += p.x * grip[i].y - p.y * along;
    pressed += load[i];
  }
  const double drive = turn_wheels(car, x, grip, bf, br, d);
  // Effects nobody has in a library.
  fx -= amount(car, "outside.slip_drag") * 40000 * (vy / vx) * (vy / vx) * vx;
  mz += amount(car, "outside.torque_steer") * drive * 0.05;
  mz += amount(car, "outside.brake_pull") * (bf + br) * 0.05;
  fx += amount(car, "outside.surge") * mass * std::sin(2 * std::numbers::pi * x[16] / 6.3);
  fy += amount(car, "outside.gust") * mass * (std::fmod(x[16], 41.0) < 3.0 ? 1.0 : 0.0);

  const double sfx = fx / mass, sfy = fy / mass;
  // Moments of all forces about the body: those at the road, and the air's at its height.
  move_body(car, load, road.plus, mass, down * car.lift_f, down * car.lift_r,
            mass * sfy * car.h + side_air * e.drag_height,
            mass * sfx * car.h + drag * e.drag_height, x, d);
  d[0] = vx * std::cos(x[2]) - vy * std::sin(x[2]);
  d[1] = vx * std::sin(x[2]) + vy * std::cos(x[2]);
  d[2] = r;
  d[3] = sfx - kGravity * road.grade + r * vy;
  d[4] = sfy - kGravity * road.bank - r * vx;
  d[5] = mz / car.inertia;
  d[11] = (bf + br) * vx / car.radius_f / 0.9e6 - x[11] / 14.0;
  d[16] = 1;
  if (out == nullptr) return;
  // What is fixed to the body leans with it; a levelled unit has taken that out.
  const double lean = e.levelled ? 0.0 : 1.0;
  const double up = (pressed - down * (car.lift_f + car.lift_r)) / mass;
  *out = {sfx + lean * up * x[kHeave + 2],
          sfy + lean * up * x[kHeave + 1],
          up - lean * (sfx * x[kHeave + 2] + sfy * x[kHeave + 1]),
          load[0] + load[1],
          load[2] + load[3],
          s,
          0,
          {grip[0].tyre, grip[1].tyre, grip[2].tyre, grip[3].tyre}};
}

}  // namespace trials
