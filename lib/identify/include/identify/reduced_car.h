// A car for planning and control: few formulas, few numbers, nothing that has to be integrated but
// the planar motion.
//
// Axes: x forward along the road, y left, normal up. Slip angles and side forces: positive to the
// left. The formulas are C text (src/reduce/control_*.inc), which control_header() writes too: the
// numbers of its structs and of these stand in the same order.
#pragma once

#include <array>

namespace identify {

/// Side and longitudinal force of one wheel, or of a whole axle ("effective": load transfer, camber
/// and toe are then in the numbers). Magic Formula (H. B. Pacejka), shortened:
///
///   f = fz / load_n - 1
///   mu_y = (mu[0] + mu[1] f + mu[2] f^2) (1 - mu_camber gamma^2)
///   K = k[0] load_n sin(2 atan(fz / (k[1] load_n)))            cornering stiffness
///   y0 = D sin(c atan(B x - e (B x - atan(B x)))), D = mu_y fz, B = K / (c D), e = e[0] + e[1] f
///   with x = tan(alpha) + shift_camber gamma + side shift_side
///   y = G_y y0 + fz (push_camber gamma + side push_side),
///   G_y = cos(wy[2] atan(By (kappa + shift_kappa))) / cos(wy[2] atan(By shift_kappa)),
///   By = wy[0] cos(atan(wy[1] tan(alpha)))
///   x0 and x: the same with mx, kx (Kx = fz (kx[0] + kx[1] f)), cx, ex, kappa, and G_x of wx,
///   without a shift
///
/// gamma: inclination as in tyre files; side: 1 left, -1 right wheel; an axle has neither. Factors
/// grip and stiffness scale mu and K: tread temperature, wet road.
struct WheelCurve {
  double load_n = 1.0;  ///< around which f counts
  std::array<double, 3> mu{}, wy{}, wx{};
  std::array<double, 2> k{}, e{}, mx{}, kx{};
  double mu_camber = 0.0, c = 1.5, cx = 1.5, ex = 0.0;
  double shift_camber = 0.0, shift_side = 0.0, push_camber = 0.0, push_side = 0.0;
  double shift_kappa = 0.0;  ///< tyres may have most side force while they drive or brake a little
};

struct CurveInput {
  double fz_n = 0.0, tan_alpha = 0.0, kappa = 0.0;
  double gamma_rad = 0.0, side = 0.0;
  double grip = 1.0, stiffness = 1.0;
};
struct CurveForces {
  double fx_n = 0.0, fy_n = 0.0;
};
CurveForces curve_forces(const WheelCurve& curve, const CurveInput& in);

/// The slip of least size that makes `fx_n` at that slip angle; where the wheel cannot, the slip of
/// its largest force.
double slip_for_force(const WheelCurve& curve, CurveInput in, double fx_n);

/// The relaxation length at a load, m.
double relaxation_m(const WheelCurve& curve, double sigma_m, double fz_n);

/// All numbers of a reduced car. Index 0 front, 1 rear.
struct ReducedCar {
  // Geometry and masses, of the full car with `fuel_kg`.
  double mass_kg = 0.0, yaw_inertia_kgm2 = 0.0, wheelbase_m = 0.0;
  double front_m = 0.0,
         rear_m = 0.0;  ///< axles ahead of and behind the point that vx, vy belong to
  double cog_behind_m = 0.0, cog_height_m = 0.0;  ///< of the centre of mass behind that point
  std::array<double, 2> track_m{}, radius_m{};
  double ackermann = 0.0, gravity_mps2 = 9.80665;

  // Loads of the axles: weight, grade and downforce.
  //   fz = m (an rest / L -/+ ax h / L) + q (a[0] + a[1] v^2 + a[2] ax + a[3] (an - g) + a[4]
  //   |beta|
  //        + a[5] ay^2), q = density / 2 v^2
  double density_kgpm3 = 1.2;
  std::array<std::array<double, 6>, 2> lift_m2{};
  // Lateral transfer of an axle, from the left to the right wheel (reduced roll axis):
  //   d = m ay (transfer_mass + transfer_speed v^2 + transfer_pressed (an - g))
  //       + transfer_force Fy(axle)
  // and what ax moves along, beside the above: along_pressed m ax (an - g). A pressed car sinks,
  // and a leaning one brings its weight to a side.
  std::array<double, 2> transfer_mass{}, transfer_force{}, transfer_speed{};
  std::array<double, 2> transfer_pressed{}, along_pressed{};
  // Inclination of a wheel: gamma = side (g[0] + g[1] fz) + g[2] ay
  std::array<std::array<double, 3>, 2> camber{};
  double side_area_m2 = 0.0, side_behind_m = 0.0;  ///< side force of the air
  double drag_area_m2 = 0.0;                       ///< its part in side slip

  std::array<WheelCurve, 2> wheel{};  ///< double-track
  std::array<WheelCurve, 2> axle{};   ///< single-track: effective axle characteristics
  std::array<double, 2> sigma_m{};    ///< relaxation length at the curve's load
  // Aligning moment of an axle: M = -Fy trail / (1 + (tan(alpha) / trail_slip)^2)
  std::array<double, 2> trail_m{}, trail_slip{0.1, 0.1};
  // Rolling radius of a rear wheel: r[0] + r[1] (fz / load_n - 1)
  std::array<double, 2> roll_m{};

  // Differential: what is moved from the left to the right wheel, N m.
  double preload_nm = 0.0, drive_ramp = 0.0, coast_ramp = 0.0, stick_radps = 1.0, lock_nms = 0.0;

  double fuel_kg = 0.0;  ///< that these numbers are with
};

/// Where the car is in the plane and what presses it.
struct PlanarState {
  double vx_mps = 0.0, vy_mps = 0.0, yaw_rate_radps = 0.0, steer_rad = 0.0;
  double ax_mps2 = 0.0, an_mps2 = 9.80665;  ///< specific force along and normal to the road
  std::array<double, 2> fx_n{};             ///< of both wheels of an axle
  double drive_nm = 0.0;                    ///< of the engine at both rear wheels together
  std::array<double, 2> grip{1.0, 1.0}, stiffness{1.0, 1.0};
};

/// Lags of the slip angles; plain numbers that the caller keeps. Not valid before the first use.
struct SlipLags {
  int begun = 0;
  std::array<double, 4> wheel{};
  std::array<double, 2> axle{};
};

struct ReducedForces {
  double ay_mps2 = 0.0, yaw_moment_nm = 0.0;
  std::array<double, 2> axle_fz_n{}, axle_fy_n{};
  std::array<double, 4> fz_n{}, fy_n{}, fx_n{};  ///< double-track only
  double differential_nm = 0.0;
  double missing_n = 0.0;  ///< longitudinal force that was asked for and that the tyres do not have
};

/// Tangents of the kinematic slip angles of the axles (their middles) and of the wheels, toe left
/// out: that is in the curves.
std::array<double, 2> axle_slips(const ReducedCar& car, const PlanarState& in);
std::array<double, 4> wheel_slips(const ReducedCar& car, const PlanarState& in);
/// Steering angles of the wheels, toe left out.
std::array<double, 4> wheel_angles(const ReducedCar& car, double steer_rad);

/// Load of the axles at a lateral acceleration.
std::array<double, 2> axle_loads(const ReducedCar& car, const PlanarState& in, double ay_mps2);

/// The share of road shape in what presses the car on the road, m/s2: gravity's part normal to the
/// road, what a bank makes of a turn, and dips and crests. `bank`: slope upwards to the left,
/// `grade`: upwards ahead, both m/m; curvatures 1/m, left turns and dips positive.
struct NormalShares {
  double gravity = 0.0, bank = 0.0, vertical = 0.0;
  double sum() const { return gravity + bank + vertical; }
};
NormalShares normal_shares(double gravity_mps2, double vx_mps, double curvature_1pm, double bank,
                           double grade, double vertical_curvature_1pm);

/// Slips of the rear wheels and what the differential moves from the left to the right one, N m.
/// Limited slip: the root of its law over what it moves, wheels before their peaks. Locked: both
/// turn at one speed, the one that makes the axle's force, also where a wheel is beyond its peak.
struct RearSlips {
  std::array<double, 2> kappa{};
  double moved_nm = 0.0;
};
RearSlips rear_slips(const ReducedCar& car, const PlanarState& in,
                     const std::array<CurveInput, 2>& rear);

/// Steady answers; with `lags` and a step, the slip angles follow with their relaxation lengths.
ReducedForces single_track(const ReducedCar& car, const PlanarState& in, SlipLags* lags = nullptr,
                           double step_s = 0.0);
ReducedForces double_track(const ReducedCar& car, const PlanarState& in, SlipLags* lags = nullptr,
                           double step_s = 0.0);

/// How far out a place of a g-g diagram is: 1 on its border. `ellipse`: largest ay, ax there,
/// largest ax driving and braking, the powers of both.
double ellipse_radius(const std::array<double, 6>& ellipse, double ax_mps2, double ay_mps2);

/// Largest steady lateral acceleration, without yaw moment, at this speed, load and longitudinal
/// forces: `in` without its planar motion. Slip angles up to `most_rad` are looked at, those beyond
/// the largest side force of the axle that leads are not; 0: the tyres do not have the longitudinal
/// forces.
double steady_limit(const ReducedCar& car, PlanarState in, bool two_tracks, double most_rad = 0.25);

}  // namespace identify
