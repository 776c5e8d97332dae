#include "longitudinal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vehicle/laws/aero.h"

namespace identify {

using vehicle::kWheels;
using P = vehicle::Parameter;
using vehicle::Term;

AirFactors air_factors(const vehicle::Car<double>& car, const DriveWindow& w) {
  using vehicle::laws::map_factor;
  const auto& p = car.parameters;
  const vehicle::CarFiles& files = *car.files;
  const double by_ride = car.terms[Term::aero_ride_height], by_yaw = car.terms[Term::aero_yaw];
  std::array<double, 2> ride;
  for (std::size_t a = 0; a < 2; ++a)
    ride[a] = p.axle(a, P::front_ride_height_m) - 0.5 * (w.sink_m[2 * a] + w.sink_m[2 * a + 1]);
  const double yaw = std::abs(std::atan2(w.vy_mps, w.vx_mps));
  AirFactors out;
  out.drag = map_factor(by_ride, files.drag_factor, ride[0], ride[1]) *
             map_factor(by_yaw, files.yaw_drag_factor, yaw);
  const double turned = map_factor(by_yaw, files.yaw_lift_factor, yaw);
  out.lift = {map_factor(by_ride, files.front_lift_factor, ride[0], ride[1]) * turned,
              map_factor(by_ride, files.rear_lift_factor, ride[0], ride[1]) * turned};
  return out;
}

double load_of(const vehicle::Car<double>& car, const DriveWindow& w, std::size_t wheel,
               double mass_kg) {
  if (std::isfinite(w.load_n[wheel])) return w.load_n[wheel];
  const auto& p = car.parameters;
  const std::size_t a = vehicle::axle_of(wheel);
  const double length = p[P::chassis_wheelbase_m],
               to_rear = p[P::chassis_cog_behind_front_m] / length;
  const double q = 0.5 * p[P::aero_density_kgpm3] * w.air_mps2;
  const double transfer = mass_kg * w.speeding_mps2 * p[P::chassis_cog_height_m] / length;
  const double normal =
      std::isfinite(w.normal_mps2) ? w.normal_mps2 : p[P::environment_gravity_mps2];
  return std::max(0.0, 0.5 * (mass_kg * normal * (a == 0 ? 1.0 - to_rear : to_rear) +
                              (a == 0 ? -transfer : transfer) +
                              car.terms[Term::aero_downforce] * q * air_factors(car, w).lift[a] *
                                  p.axle(a, P::front_lift_area_m2)));
}

double rolling_torque(const vehicle::Car<double>& car, const DriveWindow& w, double mass_kg) {
  double out = 0.0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = vehicle::axle_of(i);
    const vehicle::TyreInput<double> in{
        .fz_n = load_of(car, w, i, mass_kg),
        .vx_mps = w.vx_mps,
        .pressure_pa = car.parameters.axle(a, P::front_tyre_pressure_pa)};
    out -= vehicle::tyre_forces(car.files->tyre[a], in).my_nm;
  }
  return car.terms[Term::rolling_resistance] * out;
}

Radii radii_under(const vehicle::Car<double>& car, std::size_t axle, double load_n, double v_mps) {
  const vehicle::TyreCoefficients& tyre = car.files->tyre[axle];
  const double r0 = tyre.unloaded_radius_m, speed = std::abs(v_mps) / tyre.nominal_speed_mps;
  const double free = r0 * (tyre.qre0 + tyre.qv1 * speed * speed);
  const double deflection =
      vehicle::static_deflection(tyre, load_n / (1.0 + tyre.qv2 * speed),
                                 car.parameters.axle(axle, P::front_tyre_pressure_pa));
  return {free - deflection, vehicle::rolling_radius(tyre, load_n, free, deflection)};
}

double force_arm(const vehicle::Car<double>& car, const DriveWindow& w, std::size_t axle,
                 double mass_kg) {
  const Radii radii = radii_under(
      car, axle,
      0.5 * (load_of(car, w, 2 * axle, mass_kg) + load_of(car, w, 2 * axle + 1, mass_kg)),
      w.vx_mps);
  const vehicle::FxArm arm = car.files->fx_arm;
  return arm == vehicle::FxArm::kRollingRadius ? radii.rolling_m
         : arm == vehicle::FxArm::kUnstated    ? 0.5 * (radii.loaded_m + radii.rolling_m)
                                               : radii.loaded_m;
}

std::optional<int> gear_of(const vehicle::Car<double>& car, const DriveWindow& w) {
  if (std::isfinite(w.gear)) return static_cast<int>(std::lround(w.gear));
  if (w.gear_recorded) return std::nullopt;  // it changed
  std::optional<int> only;
  for (int gear = 1; gear <= vehicle::kMostGears; ++gear) {
    if (!(overall_ratio(car.parameters, gear) > 0.0)) continue;
    if (only) return std::nullopt;
    only = gear;
  }
  return only;
}

double spin_up_radps2(const vehicle::Car<double>& car, const DriveWindow& w, std::size_t wheel,
                      double mass_kg) {
  // Slip builds up while brakes do: wheels slow more than the car then.
  if (std::isfinite(w.spin_up_radps2[wheel])) return w.spin_up_radps2[wheel];
  const double along_mps2 = w.speeding_mps2 - car.parameters[P::environment_gravity_mps2] *
                                                  w.slope / std::sqrt(1.0 + w.slope * w.slope);
  return along_mps2 / force_arm(car, w, vehicle::axle_of(wheel), mass_kg);
}

AlongForces along_forces(const vehicle::Car<double>& car, const DriveWindow& w, double mass_kg,
                         int gear, bool by_speed) {
  const auto& p = car.parameters;
  AlongForces out;
  out.inertia_n = mass_kg * (by_speed ? w.speeding_mps2 : w.along_mps2);
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = vehicle::axle_of(i);
    const double ratio = a == 1 && gear > 0 ? overall_ratio(p, gear) : 0.0;
    out.inertia_n +=
        (p.axle(a, P::front_wheel_inertia_kgm2) + 0.5 * p[P::engine_inertia_kgm2] * ratio * ratio) *
        spin_up_radps2(car, w, i, mass_kg) / force_arm(car, w, a, mass_kg);
  }
  out.rolling_n = rolling_torque(car, w, mass_kg) /
                  (0.5 * (force_arm(car, w, 0, mass_kg) + force_arm(car, w, 1, mass_kg)));
  out.drag_m2_n = car.terms[Term::aero_drag] * 0.5 * p[P::aero_density_kgpm3] * w.air_mps2 *
                  air_factors(car, w).drag;
  return out;
}

Gearing gearing(const vehicle::Car<double>& car, const DriveWindow& w, int gear, double mass_kg,
                bool pulls) {
  const auto& p = car.parameters;
  const double r = force_arm(car, w, 1, mass_kg), ratio = overall_ratio(p, gear);
  const double spin = std::isfinite(w.wheel_radps[2] + w.wheel_radps[3])
                          ? 0.5 * (w.wheel_radps[2] + w.wheel_radps[3])
                          : w.vx_mps / r;
  const double efficiency = p[P::gearbox_efficiency];
  return {ratio * (pulls ? efficiency : 1.0 / efficiency) / r, ratio * spin};
}

Along::Along(const vehicle::Car<double>& its_car, const Prior& its_prior, const DriveWindows& drive,
             const WeighedOptions& options)
    : car(its_car),
      prior(its_prior),
      weighed(options.mass_kg > 0.0),
      by_speed(!drive.accelerations || (options.body_axes && !drive.loads && !drive.travels)) {
  const double stated_kg = car.parameters[P::chassis_mass_kg];
  is.mass_kg = weighed ? options.mass_kg : stated_kg + options.fuel_kg;
  mass_sd_kg = weighed ? options.mass_sd_kg : share_sd(prior, P::chassis_mass_kg) * stated_kg;
}

std::vector<Granted> Along::moved(
    std::initializer_list<std::pair<double Granted::*, double>> deviations) const {
  std::vector<Granted> out;
  for (const auto& [number, by] : deviations) out.emplace_back(is).*number += by;
  return out;
}

void Along::with_loaded_arm(const std::function<void(const vehicle::Car<double>&)>& with) const {
  if (car.files->fx_arm != vehicle::FxArm::kUnstated) return;
  vehicle::CarFiles files = *car.files;
  files.fx_arm = vehicle::FxArm::kLoadedRadius;
  vehicle::Car<double> other = car;
  other.files = &files;
  with(other);
}

Eigen::MatrixXd Along::granted_covariance(
    const std::vector<P>& numbers, const std::vector<Granted>& moved,
    const std::function<Eigen::VectorXd(const vehicle::Car<double>&, const Granted&)>& solve)
    const {
  const Eigen::VectorXd value = solve(car, is);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(value.size(), value.size());
  const auto add = [&](const Eigen::VectorXd& other, double share) {
    out += share * share * (other - value) * (other - value).transpose();
  };
  for (const P number : numbers) {
    vehicle::Car<double> other = car;
    other.parameters[number] *= 1.0 + share_sd(prior, number);
    add(solve(other, is), 1.0);
  }
  with_loaded_arm([&](const vehicle::Car<double>& other) { add(solve(other, is), kBetween); });
  for (const Granted& granted : moved) add(solve(car, granted), 1.0);
  return out;
}

std::string Along::mass_words(const char* what) const {
  return fmt::format(
      "a mass of {:.1f} kg with fuel (standard deviation {:.2g}, by {}); {} as wrong as it",
      is.mass_kg, mass_sd_kg, weighed ? "the wheel loads" : "the vehicle file", what);
}

std::string Along::arm_words(const Windows& windows) const {
  const auto mean = [&](const vehicle::Car<double>& of, std::size_t axle) {
    double sum = 0.0;
    for (const DriveWindow* w : windows) sum += force_arm(of, *w, axle, is.mass_kg);
    return sum / static_cast<double>(windows.size());
  };
  const double front = mean(car, 0), rear = mean(car, 1);
  std::string out = fmt::format(
      "longitudinal forces turn the wheels at an arm of {:.4g} m in front, {:.4g} m behind: ",
      front, rear);
  if (car.files->fx_arm != vehicle::FxArm::kUnstated)
    return out +
           fmt::format("the {} radius, as the vehicle file states",
                       car.files->fx_arm == vehicle::FxArm::kRollingRadius ? "rolling" : "loaded");
  with_loaded_arm([&](const vehicle::Car<double>& other) {
    out += fmt::format(
        "halfway between loaded and rolling radius, as the vehicle file does not state fx_arm; "
        "torques rise with it, and the intervals reach from one to the other, {:.1f} % to a side",
        50.0 * (std::abs(mean(other, 0) / front - 1.0) + std::abs(mean(other, 1) / rear - 1.0)));
  });
  return out;
}

}  // namespace identify
