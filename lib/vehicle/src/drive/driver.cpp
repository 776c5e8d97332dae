#include "vehicle/driver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "vehicle/steady_engine.h"

namespace vehicle {
namespace {

double ratio_of(const Car<double>& car, int gear) { return overall_ratio(car.parameters, gear); }

/// Value of `values` at arc length s between stations; `lap` is what one round adds to it.
double at_length(const RacingLine& line, const std::vector<double>& values, double s_m,
                 double lap) {
  const std::size_t n = line.s_m.size();
  double rounds = 0.0;
  if (line.closed) {
    rounds = std::floor(s_m / line.length_m);
    s_m -= rounds * line.length_m;
  }
  const auto upper = std::upper_bound(line.s_m.begin(), line.s_m.end(), s_m);
  const std::size_t i =
      upper == line.s_m.begin() ? 0 : static_cast<std::size_t>(upper - line.s_m.begin()) - 1;
  if (i + 1 >= n && !line.closed) return values[n - 1];
  const double begin = line.s_m[i];
  const double end = i + 1 < n ? line.s_m[i + 1] : line.length_m;
  const double next = i + 1 < n ? values[i + 1] : values[0] + lap;
  const double t = end > begin ? std::clamp((s_m - begin) / (end - begin), 0.0, 1.0) : 0.0;
  return values[i] + t * (next - values[i]) + rounds * lap;
}

/// Finds his place on the line anew: the nearest segment around the last one.
void find_place(Driver& driver, const RacingLine& line, const State<double>& state) {
  const std::size_t n = line.s_m.size();
  double best = 1e300, left_m = 0.0;
  std::size_t station = driver.station;
  double s = driver.s_m;
  for (std::ptrdiff_t k = -2; k <= 4; ++k) {
    const auto size = static_cast<std::ptrdiff_t>(n);
    std::ptrdiff_t index = static_cast<std::ptrdiff_t>(driver.station) + k;
    if (line.closed) index = (index % size + size) % size;
    if (index < 0 || index + 1 > size - (line.closed ? 0 : 1)) continue;
    const auto i = static_cast<std::size_t>(index);
    const std::size_t j = (i + 1) % n;
    const double dx = line.x_m[j] - line.x_m[i], dy = line.y_m[j] - line.y_m[i];
    const double length2 = std::max(1e-12, dx * dx + dy * dy);
    const double t = std::clamp(
        ((state[kX] - line.x_m[i]) * dx + (state[kY] - line.y_m[i]) * dy) / length2, 0.0, 1.0);
    const double distance =
        std::hypot(state[kX] - line.x_m[i] - t * dx, state[kY] - line.y_m[i] - t * dy);
    if (distance < best) {
      best = distance;
      station = i;
      s = line.s_m[i] + t * std::sqrt(length2);
      left_m =
          ((state[kY] - line.y_m[i]) * dx - (state[kX] - line.x_m[i]) * dy) / std::sqrt(length2);
    }
  }
  // Over the seam of a lap, or put back somewhere else, he begins anew.
  const double gone_m = s - driver.s_m;
  if (gone_m > 0.0 && gone_m < 5.0) driver.drift_m2 += left_m * gone_m;
  driver.drift_m2 = std::clamp(driver.drift_m2, -60.0, 60.0);
  driver.station = station;
  driver.s_m = s;
}

/// How far apart the axles of a car without slip would be that turns by an angle of its road wheels
/// as this one does at a speed, m. Loads are those of steady driving: what bumps and brakes make of
/// them for a moment would shake the wheels, or turn them out of a bend that is braked into.
double turning_base_m(const Car<double>& car, double vx_mps) {
  using P = Parameter;
  constexpr double kLeast = 0.3;  // of the wheelbase, however much the car oversteers
  const Parameters<double>& p = car.parameters;
  const double wheelbase = p[P::chassis_wheelbase_m];
  const double front = p[P::chassis_cog_behind_front_m], rear = wheelbase - front;
  std::array<Stiffness<double>, 2> axle{};
  for (std::size_t a = 0; a < 2; ++a) {
    const double air_n = 0.25 * p[P::aero_density_kgpm3] * car.terms[Term::aero_downforce] *
                         p.axle(a, P::front_lift_area_m2) * vx_mps * vx_mps;
    const Stiffness<double> wheel =
        tyre_stiffness(car.files->tyre[a],
                       std::max(car.static_load_n[a] + air_n, 0.2 * car.static_load_n[a]), 0.0);
    axle[a] = {2.0 * std::abs(wheel.slip_n), std::max(1.0, 2.0 * std::abs(wheel.cornering_npr))};
  }
  const double understeer = p[P::chassis_mass_kg] / wheelbase *
                            (rear / axle[0].cornering_npr - front / axle[1].cornering_npr);
  // The wheels of a locked axle slip along their way in a bend: the tyres turn the car against
  // them.
  const double half_m = 0.5 * p[P::rear_track_m];
  const double scrub = car.terms[Term::locked_differential] * axle[1].slip_n * half_m * half_m /
                       wheelbase * (1.0 / axle[0].cornering_npr + 1.0 / axle[1].cornering_npr);
  return scrub + std::max(kLeast * wheelbase, wheelbase + understeer * vx_mps * vx_mps);
}

/// The arc through a point ahead, seen from the rear axle, and what understeer costs.
double steer(const Driver& driver, const RacingLine& line, const Car<double>& car,
             const State<double>& state) {
  using P = Parameter;
  const Parameters<double>& p = car.parameters;
  const DriverOptions& o = driver.options;
  const double s = driver.s_m, vx = state[kVx];
  const double cy = std::cos(state[kYaw]), sy = std::sin(state[kYaw]);
  const double rear = p[P::chassis_wheelbase_m] - p[P::chassis_cog_behind_front_m];
  const double ahead = o.preview_m + o.preview_s * std::max(0.0, vx);
  const double tx = at_length(line, line.x_m, s + ahead, 0.0);
  const double ty = at_length(line, line.y_m, s + ahead, 0.0);
  const double rx = tx - (state[kX] - rear * cy), ry = ty - (state[kY] - rear * sy);
  const double along = rx * cy + ry * sy, across = -rx * sy + ry * cy;
  const double arc = 2.0 * across / std::max(1.0, along * along + across * across) -
                     o.drift_gain * driver.drift_m2 / (ahead * ahead * ahead);
  const double wheelbase = p[P::chassis_wheelbase_m];
  // A tail that comes round turns the car faster than the arc asks, or the other way: he steers
  // harder against that than where front tyres turn it too little, which would saw.
  const double turn = state[kYawRate] / std::max(vx, 5.0);
  const double beyond = turn - std::clamp(turn, std::min(arc, 0.0), std::max(arc, 0.0));
  const double against = wheelbase * (o.yaw_damping * (arc - turn) - o.tail_damping * beyond);
  return laws::steering_command(car.files->steering, p[P::steering_ratio],
                                std::clamp(arc * turning_base_m(car, vx) + against, -0.45, 0.45));
}

/// What the road leaves of the slips he allows wheels: a tyre's stiffness does not change with the
/// road's grip, so its forces peak at a slip that shrinks with it.
double slip_share(const Driver& driver, const RacingLine& line, const Car<double>& car) {
  const double grip = car.parameters[Parameter::environment_road_grip] *
                      (line.friction.empty() ? 1.0 : line.friction[driver.station]);
  return std::min(1.0, 1.0 + car.terms[Term::road_friction] * (grip - 1.0));
}

/// An engine that lacks boost gives less than its throttle does in the long run: he presses on
/// until it gives what he wants, over a fifth of a second, by no more than what the engine has at
/// all.
void press_for_boost(Driver& driver, double wanted_nm, double given_nm, double most_nm) {
  constexpr double kSoon_s = 0.2;
  driver.missing_nm =
      std::clamp(driver.missing_nm + driver.options.step_s / kSoon_s * (wanted_nm - given_nm), 0.0,
                 std::max(0.0, most_nm));
}

constexpr double kSlide = 0.11;  ///< sideways slip of the rear axle above which he lifts
constexpr double kPress_1ps = 10.0, kLift_1ps = 20.0;  ///< how fast a foot moves, share per second

/// Throttle for a force; `gain` is force per torque of the engine, `closed` its torque without
/// throttle.
double press_throttle(Driver& driver, const RacingLine& line, const Car<double>& car,
                      const State<double>& state, const Detail<double>& detail, double force,
                      double gain, double closed) {
  const DriverOptions& o = driver.options;
  const double factor = car.parameters[Parameter::engine_torque];
  const double full = laws::map_torque(factor, engine_map(car, line), state[kEngine], 1.0);
  double throttle = std::clamp((force / gain - closed) / std::max(1.0, full - closed), 0.0, 1.0);
  if (!line.engine_torque_nm.empty()) {
    const double wanted_nm = force / gain / factor;
    press_for_boost(driver, wanted_nm, detail.turbo.engine_nm, (full - closed) / factor);
    throttle = throttle_for(line.engine_torque_nm, state[kEngine], wanted_nm + driver.missing_nm);
  }
  if (force < gain * closed) throttle = 0.0;
  const double spin = std::max(detail.wheel[2].kappa, detail.wheel[3].kappa);
  const double most = o.slip_drive * slip_share(driver, line, car);
  if (spin > most) throttle *= std::clamp(1.0 - (spin - most) / most, 0.0, 1.0);
  // A tail that slides has no grip left to pull with.
  const double slide =
      0.5 * (std::abs(detail.wheel[2].tan_alpha) + std::abs(detail.wheel[3].tan_alpha));
  if (slide > kSlide) throttle *= std::clamp(2.0 - slide / kSlide, 0.0, 1.0);
  driver.throttle +=
      std::clamp(throttle - driver.throttle, -kLift_1ps * o.step_s, kPress_1ps * o.step_s);
  return driver.throttle;
}

/// Pressures that brake with a force, shared by the wheels' loads.
std::array<double, kWheels> press_brakes(const Driver& driver, const RacingLine& line,
                                         const Car<double>& car, const Detail<double>& detail,
                                         double braking) {
  using P = Parameter;
  const Parameters<double>& p = car.parameters;
  const DriverOptions& o = driver.options;
  std::array<double, kWheels> pressures{};
  const double most = o.slip_brake * slip_share(driver, line, car);
  double total = 1.0;
  for (const WheelDetail<double>& wheel : detail.wheel) total += wheel.fz_n;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = axle_of(i);
    const double torque = braking * detail.wheel[i].fz_n / total * car.static_radius_m[a];
    double pressure =
        torque / (2.0 * p.axle(a, P::front_brake_friction) * p.axle(a, P::front_brake_area_m2) *
                  p.axle(a, P::front_brake_radius_m));
    const double slip = -detail.wheel[i].kappa;
    if (slip > most) pressure *= std::clamp(1.0 - (slip - most) / most, 0.0, 1.0);
    pressures[i] = std::min(pressure, o.full_brake_pa);
  }
  return pressures;
}

/// Shifted down, an engine that turns too slowly drags the driven wheels; where the road gives
/// little grip they slide and the tail comes round. What they slip by beyond what he allows brakes,
/// he lets the clutch slip by. Where there is grip he needs no clutch: logs do not tell of it.
double press_clutch(const Driver& driver, const RacingLine& line, const Car<double>& car,
                    const Detail<double>& detail) {
  const double slip = -std::min(detail.wheel[2].kappa, detail.wheel[3].kappa);
  const double share = slip_share(driver, line, car);
  if (share >= 1.0) return 0.0;
  const double most = driver.options.slip_brake * share;
  return std::clamp((slip - most) / most, 0.0, 1.0);
}

}  // namespace

int choose_gear(const Car<double>& car, double vx_mps, int gear_now) {
  const double limit = car.parameters[Parameter::engine_limit_radps];
  const double wheel = std::max(0.0, vx_mps) / car.static_radius_m[1];
  int gear = std::clamp(gear_now, 1, kMostGears);
  while (gear > 1 && !(ratio_of(car, gear) > 0.0)) --gear;  // no such gear
  while (ratio_of(car, gear + 1) > 0.0 && wheel * ratio_of(car, gear) > 0.95 * limit) ++gear;
  while (gear > 1 && wheel * ratio_of(car, gear - 1) < 0.80 * limit) --gear;
  return gear;
}

Controls<double> drive(Driver& driver, const RacingLine& line, const Car<double>& car,
                       const State<double>& state, const Detail<double>& detail) {
  using P = Parameter;
  const Parameters<double>& p = car.parameters;
  const double vx = state[kVx];
  find_place(driver, line, state);
  const double s = driver.s_m;
  Controls<double> out;
  out.steer_command_rad = steer(driver, line, car, state);

  // Speed: the profile a moment ahead, and its own slope.
  const double look = 0.10 * std::max(vx, 1.0);
  const double wanted = at_length(line, line.speed_mps, s + look, 0.0);
  const double slope = (at_length(line, line.speed_mps, s + look + 4.0, 0.0) - wanted) / 4.0;
  const double acceleration = driver.options.speed_gain_1ps * (wanted - vx) + slope * vx;
  const double mass = p[P::chassis_mass_kg] + state[kFuel];
  const double grade = at_length(line, line.grade, s, 0.0);
  const double force =
      mass * (acceleration + p[P::environment_gravity_mps2] * grade) + detail.drag_n;

  driver.gear = choose_gear(car, vx, driver.gear);
  out.gear_command = driver.gear;
  const double gain =
      ratio_of(car, driver.gear) * p[P::gearbox_efficiency] / car.static_radius_m[1];
  const double closed =
      laws::map_torque(p[P::engine_torque], engine_map(car, line), state[kEngine], 0.0);
  out.throttle_command = press_throttle(driver, line, car, state, detail, force, gain, closed);
  out.clutch_command = press_clutch(driver, line, car, detail);
  const double braking = std::max(0.0, gain * closed - force - 0.02 * mass);
  if (braking > 0.0 && wanted < vx + 0.5)
    out.brake_command_pa = press_brakes(driver, line, car, detail, braking);
  return out;
}

}  // namespace vehicle
