#include <fmt/format.h>

#include <cmath>
#include <set>

#include "identify/reduce.h"
#include "reduce_fit.h"

namespace identify {
namespace {

template <class Numbers>
std::string yaml(const Numbers& values) {
  return fmt::format("[{:.9g}]", fmt::join(values, ", "));
}
template <class Numbers>
std::string c(const Numbers& values) {
  return fmt::format("{{{:.9g}}}", fmt::join(values, ", "));
}
template <std::size_t n>
std::string c(const double (&values)[2][n]) {
  return "{" + c(values[0]) + ", " + c(values[1]) + "}";
}

std::string curve_yaml(const WheelCurve& w, const char* pad, bool whole) {
  std::string out = fmt::format(
      "{0}load_n: {1:.9g}\n{0}mu: {2}\n{0}k: {3}\n{0}c: {4:.9g}\n{0}e: {5}\n{0}mx: {6}\n{0}kx: "
      "{7}\n{0}cx: {8:.9g}\n{0}ex: {9:.9g}\n{0}wy: {10}\n{0}wx: {11}\n{0}shift_kappa: {12:.9g}\n",
      pad, w.load_n, yaml(w.mu), yaml(w.k), w.c, yaml(w.e), yaml(w.mx), yaml(w.kx), w.cx, w.ex,
      yaml(w.wy), yaml(w.wx), w.shift_kappa);
  if (!whole)
    out += fmt::format(
        "{0}mu_camber: {1:.9g}\n{0}shift_camber: {2:.9g}\n{0}shift_side: {3:.9g}\n{0}push_camber: "
        "{4:.9g}\n{0}push_side: {5:.9g}\n",
        pad, w.mu_camber, w.shift_camber, w.shift_side, w.push_camber, w.push_side);
  return out;
}

std::string curve_c(const WheelCurve& w) {
  return fmt::format(
      "{{{:.9g}, {}, {}, {}, {}, {}, {}, {}, {:.9g}, {:.9g}, {:.9g}, {:.9g},\n    {:.9g}, {:.9g}, "
      "{:.9g}, {:.9g}, {:.9g}}}",
      w.load_n, c(w.mu), c(w.wy), c(w.wx), c(w.k), c(w.e), c(w.mx), c(w.kx), w.mu_camber, w.c, w.cx,
      w.ex, w.shift_camber, w.shift_side, w.push_camber, w.push_side, w.shift_kappa);
}

std::string part_yaml(const PartError& e) {
  return fmt::format(
      "  - {{what: \"{}\", rms_share: {:.3g}, largest_share: {:.3g}, of: {:.4g}, unit: {}, rows: "
      "{}}}\n",
      e.name, e.rms, e.most, e.of, e.unit, e.rows);
}

std::string model_yaml(const char* name, const LapError::Model& lap, const PartError& limit,
                       const std::string& refused) {
  return fmt::format(
      "{}:\n  error:\n    lap_ay_rms_share: {:.3g}\n    lap_ay_95_share: {:.3g}\n    "
      "lap_yaw_moment_rms_nm: {:.4g}\n    lap_load_rms_share: {:.3g}\n    limit_rms_share: "
      "{:.3g}\n    limit_largest_share: {:.3g}\n{}",
      name, lap.ay_rms, lap.ay_95, lap.yaw_rms_nm, lap.load_rms, limit.rms, limit.most,
      refused.empty() ? "" : "  refused: \"" + refused + "\"\n");
}

/// Where the limit is furthest off.
std::string place_of(const Reduction& r, double GripPoint::*reduced) {
  const GripPoint* worst = nullptr;
  const auto miss = [&](const GripPoint& p) { return p.*reduced / p.full_mps2 - 1.0; };
  for (const GripPoint& p : r.border)
    if (p.rolls_free && (worst == nullptr || std::abs(miss(p)) > std::abs(miss(*worst))))
      worst = &p;
  return worst == nullptr ? ""
                          : fmt::format("; {:+.2f} % at {:.0f} m/s, pressed by {:.3g} m/s2",
                                        100.0 * miss(*worst), worst->vx_mps, worst->an_mps2);
}

constexpr char kBorder[] = R"(
/* How far out a place of the g-g diagram is: 1 on the border, more beyond; NaN where the border was
   not found. Between its nodes of speed and pressing acceleration by straight lines. */
static inline double control_border_radius(double vx_mps, double an_mps2, double ax_mps2,
                                           double ay_mps2) {
  double e[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, v, n;
  int i = 0, j = 0, k, di, dj;
  while (i + 2 < CONTROL_SPEEDS && vx_mps > control_speed_mps[i + 1]) ++i;
  while (j + 2 < CONTROL_NORMALS && an_mps2 > control_normal[j + 1]) ++j;
  v = control_clip((vx_mps - control_speed_mps[i]) /
                       (control_speed_mps[i + 1] - control_speed_mps[i]), 0.0, 1.0);
  n = CONTROL_NORMALS > 1 ? control_clip((an_mps2 - control_normal[j]) /
                                (control_normal[j + 1] - control_normal[j]), 0.0, 1.0) : 0.0;
  for (di = 0; di < 2; ++di)
    for (dj = 0; dj < 2; ++dj) {
      const double w = (di ? v : 1.0 - v) * (dj ? n : 1.0 - n);
      if (w > 0.0)
        for (k = 0; k < 6; ++k) e[k] += w * control_border[i + di][j + dj][k];
    }
  return control_ellipse_radius(e, ax_mps2, ay_mps2);
}
)";

constexpr char kFormulas[] = R"yaml(formulas:
  axes: "x forward, y left, normal up; slip angles and forces to the left are positive; vx, vy at
    front_m behind the front axle"
  slip: "alpha_front = steer - atan((vy + front_m r) / vx), alpha_rear = -atan((vy - rear_m r) /
    vx); a wheel at its own place, front wheels turned by steer +/- ackermann steer^2 track / (2
    wheelbase)"
  normal: "cb = cos(atan(bank)), cg = cos(atan(grade)); an = g cb cg - (vx cg)^2 curvature bank cb
    + (vx cg)^2 vertical_curvature cg cb: gravity, bank, dips and crests"
  load: "fz = m (an rest / L -/+ ax h / L) + density / 2 v^2 (a0 + a1 v^2 + a2 ax + a3 (an - g) +
    a4 |vy / vx| + a5 ay^2) + along_pressed m ax (an - g)"
  transfer: "left to right: d = m ay (mass + speed v^2 + pressed (an - g)) + force Fy_axle (reduced
    roll axis)"
  inclination: "gamma = side (g0 + g1 fz) + g2 ay; side 1 left, -1 right"
  side_force: "f = fz / load_n - 1; D = (mu0 + mu1 f + mu2 f^2) (1 - mu_camber gamma^2) fz grip; K
    = k0 load_n sin(2 atan(fz / (k1 load_n))) stiffness; B = K / (c D); x = tan(alpha) +
    shift_camber gamma + side shift_side; b = wy0 cos(atan(wy1 tan(alpha))); y = cos(wy2 atan(b
    (kappa + shift_kappa))) / cos(wy2 atan(b shift_kappa)) D sin(c atan(B x - (e0 + e1 f) (B x -
    atan(B x)))) + fz grip (push_camber gamma + side push_side)"
  longitudinal_force: "D = (mx0 + mx1 f) fz grip; K = (kx0 + kx1 f) fz stiffness; x = cos(wx2
    atan(wx0 cos(atan(wx1 kappa)) tan(alpha))) D sin(cx atan(B kappa - ex (B kappa - atan(B
    kappa))))"
  relaxation: "slip angles follow over sigma sin(2 atan(fz / (k1 load_n))) / sin(2 atan(1 / k1))"
  aligning: "moment = -Fy trail / (1 + (tan(alpha) / trail_slip)^2)"
  differential: "left to right: m = (preload + ramp |drive torque|) / 2 tanh(d / stick) + lock d,
    d = left less right wheel speed at m"
  border: "|(ax - ax0) / (most_ax - ax0)|^n + |ay / most_ay|^n = 1; specific forces, drag included"
)yaml";

}  // namespace

std::string why_refused(const Reduction& r, const LapError& of_lap, const ReduceBounds& bounds,
                        bool two_tracks) {
  const LapError::Model& lap = two_tracks ? of_lap.two : of_lap.single;
  const PartError& limit = two_tracks ? r.limit_double : r.limit_single;
  const char* const name = two_tracks ? "double-track" : "single-track";
  // NaN is no answer either.
  if (!(lap.ay_rms <= bounds.lap_share))
    return fmt::format(
        "{}: its lateral acceleration on the lap is {:.2f} % of the largest from the full car's "
        "(root mean square), at most {:.2f} % is allowed",
        name, 100.0 * lap.ay_rms, 100.0 * bounds.lap_share);
  if (limit.rows == 0)
    return fmt::format("{}: the full car has no steady state at its limit to compare with", name);
  if (!(limit.rms <= bounds.limit_share))
    return fmt::format(
        "{}: its steady-state limit is {:.2f} % from the full car's (root mean square{}), at most "
        "{:.2f} % is allowed",
        name, 100.0 * limit.rms,
        place_of(r, two_tracks ? &GripPoint::double_mps2 : &GripPoint::single_mps2),
        100.0 * bounds.limit_share);
  return {};
}

std::string control_yaml(const Reduction& r, const LapError& lap, const ReduceBounds& bounds,
                         const std::string& source) {
  const ReducedCar& car = r.car;
  std::string out = fmt::format(
      "# {}\nvalid:\n  speed_mps: [{:.4g}, {:.4g}]\n  pressing_over_gravity: [{:.4g}]\n  "
      "slip_angle_rad: "
      "{:.3g}\n  slip: 0.25\n  tyres: \"at the temperature of full grip; grip and stiffness scale "
      "them\"\n  road: \"no kerbs; quasi-steady loads: nothing of springs and dampers in time\"\n"
      "  rig_runs: {}\n",
      source, r.least_mps, r.most_mps, fmt::join(r.gravities, ", "), r.most_slip_rad, r.runs);
  out += kFormulas;
  out += fmt::format(
      "body:\n  fuel_kg: {:.6g}\n  mass_kg: {:.9g}\n  yaw_inertia_kgm2: {:.9g}\n  wheelbase_m: "
      "{:.9g}\n  front_m: {:.9g}\n  rear_m: {:.9g}\n  cog_behind_m: {:.9g}\n  cog_height_m: "
      "{:.9g}\n  track_m: {}\n  radius_m: {}\n  ackermann: {:.9g}\n  gravity_mps2: {:.9g}\n",
      car.fuel_kg, car.mass_kg, car.yaw_inertia_kgm2, car.wheelbase_m, car.front_m, car.rear_m,
      car.cog_behind_m, car.cog_height_m, yaml(car.track_m), yaml(car.radius_m), car.ackermann,
      car.gravity_mps2);
  out += fmt::format(
      "air:\n  density_kgpm3: {:.9g}\n  front_lift_m2: {}\n  rear_lift_m2: {}\n  side_area_m2: "
      "{:.9g}\n  side_behind_m: {:.9g}\n  drag_area_m2: {:.9g}\n",
      car.density_kgpm3, yaml(car.lift_m2[0]), yaml(car.lift_m2[1]), car.side_area_m2,
      car.side_behind_m, car.drag_area_m2);
  out += fmt::format(
      "transfer:\n  mass: {}\n  force: {}\n  speed: {}\n  pressed: {}\n  along_pressed: {}\n",
      yaml(car.transfer_mass), yaml(car.transfer_force), yaml(car.transfer_speed),
      yaml(car.transfer_pressed), yaml(car.along_pressed));
  out += fmt::format("trails:\n  trail_m: {}\n  trail_slip: {}\n", yaml(car.trail_m),
                     yaml(car.trail_slip));
  out += fmt::format("relaxation:\n  sigma_m: {}\n", yaml(car.sigma_m));
  out += fmt::format(
      "differential:\n  preload_nm: {:.9g}\n  drive_ramp: {:.9g}\n  coast_ramp: {:.9g}\n  "
      "stick_radps: {:.9g}\n  lock_nms: {:.9g}\n  rolling_radius_m: {}\n",
      car.preload_nm, car.drive_ramp, car.coast_ramp, car.stick_radps, car.lock_nms,
      yaml(car.roll_m));
  const std::string single = why_refused(r, lap, bounds, false),
                    both = why_refused(r, lap, bounds, true);
  out += model_yaml("single_track", lap.single, r.limit_single, single);
  if (single.empty())
    out += "  front_axle:\n" + curve_yaml(car.axle[0], "    ", true) + "  rear_axle:\n" +
           curve_yaml(car.axle[1], "    ", true);
  out += model_yaml("double_track", lap.two, r.limit_double, both);
  if (both.empty())
    out += fmt::format("  camber_front: {}\n  camber_rear: {}\n  front_wheel:\n{}  rear_wheel:\n{}",
                       yaml(car.camber[0]), yaml(car.camber[1]),
                       curve_yaml(car.wheel[0], "    ", false),
                       curve_yaml(car.wheel[1], "    ", false));
  out += fmt::format(
      "shares_in_wheel_loads:  # root mean square error of the double-track's, over the mean\n  "
      "all: {:.3g}\n  without_bank: {:.3g}\n  without_vertical_curvature: {:.3g}\n",
      lap.two.load_rms, lap.load_rms_without_bank, lap.load_rms_without_vertical);
  out += fmt::format(
      "lap:\n  seconds: {:.3f}\n  grip_usage: {:.3g}\n  largest_ay_mps2: {:.4g}\n  rows: {}\n  "
      "left_out: {{on_kerbs: {}, "
      "other_speeds: {}, wheels_sliding: {}}}\n",
      lap.lap_s, lap.grip_usage, lap.largest_ay_mps2, lap.rows, lap.on_kerbs, lap.other_speeds,
      lap.sliding);
  out += "border:  # of the full car: vx, an, most_ay, ax0, most_ax driving, braking, n, n\n";
  for (const GripEllipse& e : r.ellipses)
    out += fmt::format("  - [{:.5g}, {:.5g}, {:.5g}, {:.5g}, {:.5g}, {:.5g}, {:.4g}, {:.4g}]\n",
                       e.vx_mps, e.an_mps2, e.ay_mps2, e.ax_mps2, e.drive_mps2, e.brake_mps2,
                       e.drive_power, e.brake_power);
  out += "errors:  # shares of the largest value of the full car on the rig\n";
  for (const PartError& e : r.parts) out += part_yaml(e);
  return out + part_yaml(r.ellipse_error);
}

std::string control_header(const Reduction& r, const LapError& lap, const ReduceBounds& bounds,
                           const std::string& source) {
  const ReducedCar& p = r.car;
  std::string safe = source;
  for (std::size_t at = 0; (at = safe.find("*/", at)) != std::string::npos;)
    safe.replace(at, 2, "* /");
  std::string out = fmt::format("/* {} */\n#ifndef CONTROL_CAR_H\n#define CONTROL_CAR_H\n", safe);
  out += "#include <math.h>\n\n";
  out += kControlCar;
  const std::string single = why_refused(r, lap, bounds, false),
                    both = why_refused(r, lap, bounds, true);
  out += fmt::format(
      "\nstatic const control_car control_car_values = {{\n    {:.9g}, {:.9g}, {:.9g}, {:.9g}, "
      "{:.9g}, {:.9g}, {:.9g},\n    {}, {}, {:.9g}, {:.9g}, {:.9g},\n    {},\n    {}, {}, {}, "
      "{}, {}, {},\n    {:.9g}, {:.9g}, {:.9g},\n    {{{},\n     {}}},\n    {{{},\n     {}}},\n    "
      "{}, {}, "
      "{}, {},\n    {:.9g}, {:.9g}, {:.9g}, {:.9g}, {:.9g}, {:.9g}}};\n",
      p.mass_kg, p.yaw_inertia_kgm2, p.wheelbase_m, p.front_m, p.rear_m, p.cog_behind_m,
      p.cog_height_m, c(p.track_m), c(p.radius_m), p.ackermann, p.gravity_mps2, p.density_kgpm3,
      c(p.lift_m2), c(p.transfer_mass), c(p.transfer_force), c(p.transfer_speed),
      c(p.transfer_pressed), c(p.along_pressed), c(p.camber), p.side_area_m2, p.side_behind_m,
      p.drag_area_m2, curve_c(p.wheel[0]), curve_c(p.wheel[1]), curve_c(p.axle[0]),
      curve_c(p.axle[1]), c(p.sigma_m), c(p.trail_m), c(p.trail_slip), c(p.roll_m), p.preload_nm,
      p.drive_ramp, p.coast_ramp, p.stick_radps, p.lock_nms, p.fuel_kg);
  out += single.empty() ? kControlSingle : "\n/* refused: " + single + " */\n";
  out += both.empty() ? kControlDouble : "\n/* refused: " + both + " */\n";
  std::set<double> speeds, normals;
  for (const GripEllipse& e : r.ellipses) {
    speeds.insert(e.vx_mps);
    normals.insert(e.an_mps2);
  }
  if (speeds.size() >= 2) {
    out += fmt::format(
        "\n#define CONTROL_SPEEDS {0}\n#define CONTROL_NORMALS {1}\nstatic const double "
        "control_speed_mps[{0} + 1] = {2};\nstatic const double control_normal[{1} + 1] = "
        "{3};\n/* most ay, ax0, most ax driving and braking, powers of both */\nstatic const "
        "double control_border[{0} + 1][{1} + 1][6] = {{\n",
        speeds.size(), normals.size(), c(speeds), c(normals));
    for (const double v : speeds) {
      out += "    {";
      for (const double n : normals) {
        std::string node = "{NAN, NAN, NAN, NAN, NAN, NAN}";
        for (const GripEllipse& e : r.ellipses)
          if (e.vx_mps == v && e.an_mps2 == n)
            node = c(std::array<double, 6>{e.ay_mps2, e.ax_mps2, e.drive_mps2, e.brake_mps2,
                                           e.drive_power, e.brake_power});
        out += node + ", ";
      }
      out += "},\n";
    }
    out += "};\n";
    out += kBorder;
  }
  return out + "\n#endif\n";
}

std::string axles_csv(const Reduction& r) {
  std::string out = "axle,fz_n,alpha_rad,fx_share,fx_n,fy_n\n";
  for (std::size_t a = 0; a < 2; ++a)
    for (const double load : {0.5, 1.0, 1.5, 2.0, 3.0})
      for (const double share : {-0.6, 0.0, 0.6})
        for (int k = 0; k <= 20; ++k) {
          const WheelCurve& curve = r.car.axle[a];
          CurveInput at;
          at.fz_n = load * curve.load_n;
          const double alpha = r.most_slip_rad * k / 20.0;
          at.tan_alpha = std::tan(alpha);
          const double wanted = share * (curve.mx[0] + curve.mx[1] * (load - 1.0)) * at.fz_n;
          at.kappa = slip_for_force(curve, at, wanted);
          const CurveForces f = curve_forces(curve, at);
          out += fmt::format("{},{:.6g},{:.6g},{:.2g},{:.6g},{:.6g}\n", a == 0 ? "front" : "rear",
                             at.fz_n, alpha, share, f.fx_n, f.fy_n);
        }
  return out;
}

std::string border_csv(const Reduction& r) {
  std::string out =
      "vx_mps,an_mps2,ax_mps2,ay_full_mps2,ay_single_mps2,ay_double_mps2,rolls_free\n";
  for (const GripPoint& p : r.border)
    out += fmt::format("{:.5g},{:.5g},{:.5g},{:.5g},{:.5g},{:.5g},{}\n", p.vx_mps, p.an_mps2,
                       p.ax_mps2, p.full_mps2, p.single_mps2, p.double_mps2, p.rolls_free ? 1 : 0);
  return out;
}

}  // namespace identify
