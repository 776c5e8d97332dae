#include "vehicle/work.h"

namespace vehicle {

Powers<double> work_of_step(const Car<double>& car, const State<double>& before,
                            const State<double>& after, const Detail<double>& detail,
                            const StepOptions& options) {
  using P = Parameter;
  const Parameters<double>& p = car.parameters;
  const double h = options.step_s;
  const auto mean = [&](std::size_t i) { return 0.5 * (before[i] + after[i]); };
  const Vec3<double> V{mean(kVx), mean(kVy), mean(kVz)};
  const Vec3<double> omega{mean(kRollRate), mean(kPitchRate), mean(kYawRate)};
  Powers<double> work;

  std::array<double, kWheels> spin;  // against the body
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelDetail<double>& w = detail.wheel[i];
    const double rate = mean(kTravelRate + i);
    spin[i] = mean(kSpin + i) - dot(omega, w.axis);
    const Vec3<double> tread =
        V + cross(omega, w.contact_m) + rate * w.swing + spin[i] * cross(w.axis, w.arm);
    work.tyre_normal += h * w.fz_n * dot(w.normal, tread);
    work.tyre_x += h * w.fx_n * dot(w.heading, tread);
    work.tyre_y += h * w.fy_n * dot(w.left, tread);
    work.tyre_moment +=
        h * (dot(w.couple, omega) + w.couple_on_travel * rate + dot(w.couple, w.axis) * spin[i]);
    work.damper -= h * w.damper_n * rate;
    work.brake += h * w.brake_nm * spin[i];
    work.unfelt += (1.0 - car.terms[Term::wheel_reaction]) *
                   p.axle(axle_of(i), P::front_wheel_inertia_kgm2) *
                   (after[kSpin + i] - before[kSpin + i]) * dot(w.axis, omega);
  }

  const auto push = [&](const Vec3<double>& force, const Vec3<double>& at) {
    return h * (dot(force, V) + dot(cross(at, force), omega));
  };
  const double drag_height_m = p[P::aero_drag_height_m] - p[P::chassis_cog_height_m];
  work.drag = push(detail.drag, {0.0, 0.0, drag_height_m});
  work.side = push({0.0, detail.side_n, 0.0}, {-p[P::aero_side_behind_cog_m], 0.0, drag_height_m});
  work.downforce = push(detail.front_downforce_n * detail.down, {car.wheel_m[0].x, 0.0, 0.0}) +
                   push(detail.rear_downforce_n * detail.down, {car.wheel_m[2].x, 0.0, 0.0});

  const double engine = mean(kEngine);
  const double axle = 0.5 * (spin[2] + spin[3]), difference = spin[2] - spin[3];
  const double driven_nm = detail.clutch_nm * detail.gear_ratio * detail.drive_efficiency;
  work.engine = h * detail.engine_nm * engine;
  work.clutch = -h * detail.clutch_nm * (engine - detail.gear_ratio * axle);
  work.driveline =
      h * (driven_nm * axle - detail.clutch_nm * engine - detail.differential_nm * difference);
  work.fuel = h * detail.power.fuel;
  if (car.files->turbo == Turbo::kFull) work.turbo = h * detail.turbo.shaft_nm * mean(kTurbo);
  work.ledge = h * detail.power.ledge;
  work.hold = h * detail.inputs.hold_n * V.x;
  return work;
}

}  // namespace vehicle
