// The part of the C header that is the same for every car: reduced_car.cpp, in C.
#pragma once

namespace identify {

inline constexpr char kControlTypes[] = R"(#include <math.h>

typedef struct {
  double load_n, mu[3], wy[3], wx[3], k[2], e[2], mx[2], kx[2];
  double mu_camber, c, cx, ex, shift_camber, shift_side, push_camber, push_side, shift_kappa;
} control_curve;

typedef struct {
  double mass_kg, yaw_inertia_kgm2, wheelbase_m, front_m, rear_m, cog_behind_m, cog_height_m;
  double track_m[2], radius_m[2], ackermann, gravity_mps2, density_kgpm3;
  double lift_m2[2][6], transfer_mass[2], transfer_force[2], transfer_speed[2], camber[2][3];
  double side_area_m2, side_behind_m, drag_area_m2;
  control_curve wheel[2], axle[2];
  double sigma_m[2], trail_m[2], trail_slip[2], roll_m[2];
  double preload_nm, drive_ramp, coast_ramp, stick_radps, lock_nms;
} control_car;

/* Axes: x forward, y left. Angles and forces to the left are positive. vx, vy: of the point
   front_m behind the front axle. ax, an: specific force along and normal to the road. fx: both
   wheels of the axle; drive_nm: of the engine at both rear wheels. grip, stiffness: 1 as on the
   rig. */
typedef struct {
  double vx_mps, vy_mps, yaw_rate_radps, steer_rad, ax_mps2, an_mps2, fx_n[2], drive_nm;
  double grip[2], stiffness[2];
} control_state;

typedef struct {
  double ay_mps2, yaw_moment_nm, axle_fz_n[2], axle_fy_n[2];
  double fz_n[4], fy_n[4], fx_n[4], differential_nm, missing_n;
} control_forces;
)";

inline constexpr char kControlCurves[] = R"(
static inline double control_clip(double x, double low, double high) {
  return x < low ? low : (x > high ? high : x);
}

static inline double control_magic(double x, double stiffness, double most, double c, double e) {
  double bx;
  if (!(fabs(most) > 1e-9)) return 0.0;
  bx = stiffness / (c * most) * x;
  return most * sin(c * atan(bx - e * (bx - atan(bx))));
}

static inline double control_weight(const double *w, double other, double own, double shift) {
  const double b = w[0] / sqrt(1.0 + w[1] * w[1] * other * other);
  return cos(w[2] * atan(b * (own + shift))) / fmax(0.1, cos(w[2] * atan(b * shift)));
}

/* side: 1 left wheel, -1 right wheel, 0 axle; gamma: inclination of the wheel */
static inline void control_curve_forces(const control_curve *c, double fz, double tan_alpha,
                                        double kappa, double gamma, double side, double grip,
                                        double stiffness, double *fx, double *fy) {
  double f, most, k, x, e;
  *fx = *fy = 0.0;
  if (fz < 1.0) return;
  f = fz / c->load_n - 1.0;
  most = fmax(0.05, c->mu[0] + c->mu[1] * f + c->mu[2] * f * f) *
         fmax(0.1, 1.0 - c->mu_camber * gamma * gamma) * fz * grip;
  k = c->k[0] * c->load_n * sin(2.0 * atan(fz / (c->k[1] * c->load_n))) * stiffness;
  x = tan_alpha + c->shift_camber * gamma + side * c->shift_side;
  e = fmin(1.0, c->e[0] + c->e[1] * f);
  *fy = control_weight(c->wy, tan_alpha, kappa, c->shift_kappa) *
            control_magic(x, k, most, c->c, e) +
        fz * grip * (c->push_camber * gamma + side * c->push_side);
  *fx = control_weight(c->wx, kappa, tan_alpha, 0.0) *
        control_magic(kappa, (c->kx[0] + c->kx[1] * f) * fz * stiffness,
                      (c->mx[0] + c->mx[1] * f) * fz * grip, c->cx, c->ex);
}

/* The longitudinal slip that makes fx; where the wheel cannot, that of its largest force. */
static inline double control_slip_for_force(const control_curve *c, double fz, double tan_alpha,
                                            double grip, double stiffness, double fx) {
  const double f = fz / c->load_n - 1.0, peak = 1.5707963267948966 / c->cx;
  const double most = (c->mx[0] + c->mx[1] * f) * fz * grip;
  const double k = (c->kx[0] + c->kx[1] * f) * fz * stiffness;
  double kappa = 0.0;
  int round, i;
  if (fz < 1.0 || fx == 0.0 || !(most > 1e-9) || !(k > 1e-9)) return 0.0;
  for (round = 0; round < 4; ++round) {
    const double g = control_weight(c->wx, kappa, tan_alpha, 0.0);
    const double ratio = g > 1e-6 ? fx / (most * g) : (fx > 0.0 ? 1.0 : -1.0);
    const double angle = fabs(ratio) < 1.0 ? asin(ratio) / c->cx : (ratio > 0.0 ? peak : -peak);
    const double wanted = tan(control_clip(angle, -1.55, 1.55));
    double y = wanted;
    for (i = 0; i < 12; ++i) {
      const double miss = y - c->ex * (y - atan(y)) - wanted;
      y -= miss / (1.0 - c->ex + c->ex / (1.0 + y * y));
      if (fabs(miss) < 1e-12 * (1.0 + fabs(wanted))) break;
    }
    kappa = control_clip(y / (k / (c->cx * most)), -0.4, 0.4);
  }
  return kappa;
}

/* Slip angles follow with vx over this length. */
static inline double control_relaxation_m(const control_curve *c, double sigma_m, double fz) {
  return sigma_m * sin(2.0 * atan(fmax(0.0, fz) / (c->k[1] * c->load_n))) /
         sin(2.0 * atan(1.0 / c->k[1]));
}

/* What presses the car on the road: gravity, bank, dips and crests. Slopes m/m, bank upwards to the
   left, grade upwards ahead; curvatures 1/m, left turns and dips positive. */
static inline double control_normal_mps2(double gravity_mps2, double vx_mps, double curvature_1pm,
                                         double bank, double grade, double vertical_1pm) {
  const double cb = 1.0 / sqrt(1.0 + bank * bank), cg = 1.0 / sqrt(1.0 + grade * grade);
  const double v2 = vx_mps * vx_mps * cg * cg;
  return gravity_mps2 * cb * cg - v2 * curvature_1pm * bank * cb + v2 * vertical_1pm * cg * cb;
}

static inline void control_axle_loads(const control_car *p, const control_state *in, double ay,
                                      double *fz) {
  const double front = p->front_m + p->cog_behind_m, rear = p->wheelbase_m - front;
  const double along = p->mass_kg * in->ax_mps2 * p->cog_height_m / p->wheelbase_m;
  const double v2 = in->vx_mps * in->vx_mps, q = 0.5 * p->density_kgpm3 * v2;
  const double beta = fabs(in->vy_mps) / fmax(1.0, fabs(in->vx_mps));
  int a;
  for (a = 0; a < 2; ++a) {
    const double *l = p->lift_m2[a];
    const double lift = l[0] + l[1] * v2 + l[2] * in->ax_mps2 +
                        l[3] * (in->an_mps2 - p->gravity_mps2) + l[4] * beta + l[5] * ay * ay;
    fz[a] = fmax(0.0, p->mass_kg * in->an_mps2 * (a == 0 ? rear : front) / p->wheelbase_m +
                          (a == 0 ? -along : along) + q * lift);
  }
}

/* Lateral load transfer of an axle, from the left to the right wheel. */
static inline double control_moved_load(const control_car *p, int a, double ay, double fy,
                                        double vx) {
  return p->transfer_mass[a] * p->mass_kg * ay + p->transfer_force[a] * fy +
         p->transfer_speed[a] * p->mass_kg * ay * vx * vx;
}

static inline double control_aligning(const control_car *p, int a, double fy, double tan_alpha) {
  const double x = tan_alpha / p->trail_slip[a];
  return -fy * p->trail_m[a] / (1.0 + x * x);
}
)";

inline constexpr char kControlDifferential[] = R"(
static inline double control_braked_n(const control_car *p, const control_state *in,
                                      const double *fz, int i) {
  return (in->fx_n[1] - in->drive_nm / p->radius_m[1]) * fz[i] / fmax(1.0, fz[0] + fz[1]);
}

static inline double control_rolling_radps(const control_car *p, const control_state *in,
                                           const double *fz, int i) {
  return (in->vx_mps - (i == 0 ? 0.5 : -0.5) * p->track_m[1] * in->yaw_rate_radps) /
         (p->roll_m[0] + p->roll_m[1] * (fz[i] / p->wheel[1].load_n - 1.0));
}

/* Slips of the rear wheels with a locked or limited slip differential; returns the torque that it
   moves from the left to the right wheel. fz, tan_alpha: left, right. */
static inline double control_rear_slips(const control_car *p, const control_state *in,
                                        const double *fz, const double *tan_alpha,
                                        double *kappa) {
  const double grip = in->grip[1], stiffness = in->stiffness[1];
  double low, high, moved = 0.0, apart = 0.0;
  int i, k, round;
  if (p->lock_nms > 0.0) {
    const double mean =
        0.5 * (control_rolling_radps(p, in, fz, 0) + control_rolling_radps(p, in, fz, 1));
    for (round = 0; round < 3; ++round) {
      double fx[2] = {0.0, 0.0}, fy;
      low = -0.4;
      high = 0.4;
      for (k = 0; k < 26; ++k) {
        const double speed = mean * (1.0 + 0.5 * (low + high));
        for (i = 0; i < 2; ++i) {
          kappa[i] = control_clip((speed + (i == 0 ? 0.5 : -0.5) * apart) /
                                          control_rolling_radps(p, in, fz, i) - 1.0, -0.4, 0.4);
          control_curve_forces(&p->wheel[1], fz[i], tan_alpha[i], kappa[i], 0.0, 0.0, grip,
                               stiffness, &fx[i], &fy);
        }
        if (fx[0] + fx[1] < in->fx_n[1])
          low = 0.5 * (low + high);
        else
          high = 0.5 * (low + high);
      }
      moved = 0.5 * p->radius_m[1] * ((fx[1] - control_braked_n(p, in, fz, 1)) -
                                      (fx[0] - control_braked_n(p, in, fz, 0)));
      apart = moved / p->lock_nms;
    }
    return moved;
  }
  high = 0.5 * (p->preload_nm +
                (in->drive_nm > 0.0 ? p->drive_ramp : p->coast_ramp) * fabs(in->drive_nm));
  low = -high;
  for (k = 0; k < 40; ++k) {
    const double capacity = 0.5 * (p->preload_nm + (in->drive_nm > 0.0 ? p->drive_ramp
                                                                       : p->coast_ramp) *
                                                       fabs(in->drive_nm));
    double speed[2];
    moved = 0.5 * (low + high);
    for (i = 0; i < 2; ++i) {
      kappa[i] = control_slip_for_force(
          &p->wheel[1], fz[i], tan_alpha[i], grip, stiffness,
          control_braked_n(p, in, fz, i) +
              (0.5 * in->drive_nm + (i == 0 ? -moved : moved)) / p->radius_m[1]);
      speed[i] = control_rolling_radps(p, in, fz, i) * (1.0 + kappa[i]);
    }
    if (capacity * tanh((speed[0] - speed[1]) / p->stick_radps) - moved > 0.0)
      low = moved;
    else
      high = moved;
  }
  return moved;
}

static inline double control_balance(const control_car *p, const control_state *in, double front_y,
                                     double rear_y, double other_nm, double *moment_nm) {
  const double q = 0.5 * p->density_kgpm3;
  const double speed = sqrt(in->vx_mps * in->vx_mps + in->vy_mps * in->vy_mps);
  const double side = -q * p->side_area_m2 * speed * in->vy_mps;
  const double drag = -q * p->drag_area_m2 * speed * in->vy_mps;
  *moment_nm = (p->front_m + p->cog_behind_m) * front_y - (p->rear_m - p->cog_behind_m) * rear_y +
               (p->cog_behind_m - p->side_behind_m) * side + p->cog_behind_m * drag + other_nm;
  return (front_y + rear_y + side + drag) / p->mass_kg;
}
)";

inline constexpr char kControlSingle[] = R"(
/* Steady forces by effective axle characteristics. */
static inline control_forces control_single_track(const control_car *p, const control_state *in) {
  control_forces out = {0};
  double slip[2], front_y, ay;
  int round, a, i;
  slip[0] = tan(in->steer_rad -
                atan2(in->vy_mps + p->front_m * in->yaw_rate_radps, in->vx_mps));
  slip[1] = -(in->vy_mps - p->rear_m * in->yaw_rate_radps) / in->vx_mps;
  for (round = 0; round < 12; ++round) {
    double other = 0.0, fz[2], tan_alpha[2], kappas[2];
    control_axle_loads(p, in, out.ay_mps2, out.axle_fz_n);
    out.missing_n = 0.0;
    for (a = 0; a < 2; ++a) {
      double fx;
      const double kappa = control_slip_for_force(&p->axle[a], out.axle_fz_n[a], slip[a],
                                                  in->grip[a], in->stiffness[a], in->fx_n[a]);
      control_curve_forces(&p->axle[a], out.axle_fz_n[a], slip[a], kappa, 0.0, 0.0, in->grip[a],
                           in->stiffness[a], &fx, &out.axle_fy_n[a]);
      out.missing_n += fabs(fx - in->fx_n[a]);
    }
    front_y = out.axle_fy_n[0] * cos(in->steer_rad) + in->fx_n[0] * sin(in->steer_rad);
    for (a = 0; a < 2; ++a) {
      const double load = fmax(1.0, out.axle_fz_n[a]);
      const double moved = control_clip(
          control_moved_load(p, a, out.ay_mps2, out.axle_fy_n[a], in->vx_mps), -0.5 * load,
          0.5 * load);
      const double drive = a == 1 ? in->drive_nm / p->radius_m[1] : 0.0;
      const double turned = a == 0 ? sin(in->steer_rad) : 0.0;
      other += control_aligning(p, a, out.axle_fy_n[a], slip[a]) +
               p->track_m[a] * moved / load * (in->fx_n[a] - drive - out.axle_fy_n[a] * turned);
      if (a == 1)
        for (i = 0; i < 2; ++i) {
          fz[i] = 0.5 * load + (i == 0 ? -moved : moved);
          tan_alpha[i] = slip[1];
        }
    }
    out.differential_nm = control_rear_slips(p, in, fz, tan_alpha, kappas);
    other += p->track_m[1] * out.differential_nm / p->radius_m[1];
    ay = control_balance(p, in, front_y, out.axle_fy_n[1], other, &out.yaw_moment_nm);
    if (fabs(ay - out.ay_mps2) < 1e-6) round = 12;
    out.ay_mps2 = ay;
  }
  return out;
}
)";

inline constexpr char kControlDouble[] = R"(
/* Steady forces of the four wheels: front left, front right, rear left, rear right. */
static inline control_forces control_double_track(const control_car *p, const control_state *in) {
  control_forces out = {0};
  double steer[4], slip[4], gamma[4], ay;
  const double more = p->ackermann * in->steer_rad * in->steer_rad * p->track_m[0] /
                      (2.0 * p->wheelbase_m);
  int round, i;
  steer[0] = in->steer_rad + more;
  steer[1] = in->steer_rad - more;
  steer[2] = steer[3] = 0.0;
  for (i = 0; i < 4; ++i) {
    const double x = i < 2 ? p->front_m : -p->rear_m;
    const double y = (i % 2 == 0 ? 0.5 : -0.5) * p->track_m[i / 2];
    slip[i] = tan(steer[i] - atan2(in->vy_mps + x * in->yaw_rate_radps,
                                   in->vx_mps - y * in->yaw_rate_radps));
  }
  for (round = 0; round < 12; ++round) {
    double force[2] = {0.0, 0.0}, moment = 0.0, side_fy[2] = {0.0, 0.0}, kappas[2];
    control_axle_loads(p, in, out.ay_mps2, out.axle_fz_n);
    for (i = 0; i < 4; ++i) {
      const int a = i / 2;
      const double side = i % 2 == 0 ? 1.0 : -1.0, half = 0.5 * out.axle_fz_n[a];
      const double moved = control_moved_load(p, a, out.ay_mps2, out.axle_fy_n[a], in->vx_mps);
      out.fz_n[i] = control_clip(half - side * moved, 0.0, 2.0 * half);
      gamma[i] = side * (p->camber[a][0] + p->camber[a][1] * out.fz_n[i]) +
                 p->camber[a][2] * out.ay_mps2;
    }
    out.differential_nm = control_rear_slips(p, in, &out.fz_n[2], &slip[2], kappas);
    for (i = 0; i < 4; ++i) {
      const int a = i / 2;
      const double side = i % 2 == 0 ? 1.0 : -1.0, cs = cos(steer[i]), ss = sin(steer[i]);
      const double kappa =
          a == 1 ? kappas[i - 2]
                 : control_slip_for_force(&p->wheel[0], out.fz_n[i], slip[i], in->grip[0],
                                          in->stiffness[0],
                                          in->fx_n[0] * out.fz_n[i] / fmax(1.0, out.axle_fz_n[0]));
      control_curve_forces(&p->wheel[a], out.fz_n[i], slip[i], kappa, gamma[i], side, in->grip[a],
                           in->stiffness[a], &out.fx_n[i], &out.fy_n[i]);
      force[a] += out.fy_n[i] * cs + out.fx_n[i] * ss;
      side_fy[a] += out.fy_n[i];
      moment += control_aligning(p, a, out.fy_n[i], slip[i]) -
                0.5 * side * p->track_m[a] * (out.fx_n[i] * cs - out.fy_n[i] * ss);
    }
    out.axle_fy_n[0] = side_fy[0];
    out.axle_fy_n[1] = side_fy[1];
    out.missing_n = fabs(out.fx_n[0] + out.fx_n[1] - in->fx_n[0]) +
                    fabs(out.fx_n[2] + out.fx_n[3] - in->fx_n[1]);
    ay = control_balance(p, in, force[0], force[1], moment, &out.yaw_moment_nm);
    if (fabs(ay - out.ay_mps2) < 1e-5) round = 12;
    out.ay_mps2 = ay;
  }
  return out;
}
)";

inline constexpr char kControlBorder[] = R"(
/* How far out a place of the g-g diagram is: 1 on the border, more beyond; NaN where the border was
   not found. Between its nodes of speed and pressing acceleration by straight lines. */
static inline double control_border_radius(double vx_mps, double an_mps2, double ax_mps2,
                                           double ay_mps2) {
  double e[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, along, most, power, v, n;
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
  along = ax_mps2 - e[1];
  most = along > 0.0 ? e[2] - e[1] : e[1] - e[3];
  power = along > 0.0 ? e[4] : e[5];
  return pow(pow(fabs(along) / most, power) + pow(fabs(ay_mps2) / e[0], power), 1.0 / power);
}
)";

}  // namespace identify
