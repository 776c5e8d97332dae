// Steady-state tyre forces: the Magic Formula 6.2 (5.2 and 6.1 are special cases of it).
//
// Source: H. B. Pacejka, Tire and Vehicle Dynamics, 3rd edition (2012), section 4.3.2, equations
// (4.E1) to (4.E78); turn slip: laws/turn_slip.h (without it all zeta = 1). Numbers in the comments
// below are those equations. Signs, ISO-W axes (x forward, y left, z up) and coefficients are those
// of the file: for a usual file a negative slip angle gives a positive Fy.
#pragma once

#include <cmath>

#include "vehicle/laws/turn_slip.h"
#include "vehicle/maths.h"
#include "vehicle/tyre_file.h"

namespace vehicle {

/// Which angle enters the lateral formulas where the literature and the programs differ.
enum class AlphaConvention {
  kTangent,  ///< alpha* = tan(alpha) everywhere, as in the book (4.E3)
  kAngle  ///< alpha itself in the pure side force and the moment, tan(alpha) in the combined part
};

/// Stiffnesses of the upright tyre at zero slip: dFx/dkappa, and dFy/dalpha signed as in the file.
template <class T>
struct Stiffness {
  T slip_n = T(0), cornering_npr = T(0);
  T within_slip_n = T(0), within_cornering_npr = T(0);  ///< of the load within FZMAX
};

/// What a tyre is asked. T is double or an automatic differentiation type.
template <class T>
struct TyreInput {
  T fz_n = T(0);         ///< contact load; at or below zero every force is zero
  T kappa = T(0);        ///< longitudinal slip, -1 = locked wheel
  T tan_alpha = T(0);    ///< lateral slip: tangent of the slip angle
  T gamma_rad = T(0);    ///< inclination against the road, positive to the right (ISO)
  T vx_mps = T(0);       ///< forward speed of the contact point
  T pressure_pa = T(0);  ///< 0 = the file's INFLPRES
  T turn_1pm =
      T(0);  ///< turning of the wheel's plane, CCW, over its speed; exactly 0: no turn slip
  const Stiffness<T>* upright = nullptr;  ///< tyre_stiffness() of the same, where it is known
};

/// Factors on the file's tyre, all 1 for the tyre as measured: temperature, road friction and
/// identification act through the first four, switches through the last three.
template <class T>
struct TyreFactors {
  T grip_x = T(1), grip_y = T(1);            ///< on the peak friction coefficients
  T stiffness_x = T(1), stiffness_y = T(1);  ///< on slip and cornering stiffness
  T combined_slip = T(1);     ///< 0 = longitudinal and lateral slip do not see each other
  T load_sensitivity = T(1);  ///< 0 = all coefficients as at nominal load
  T camber = T(1);            ///< 0 = upright tyre
};

/// Forces and moments on the wheel at the contact point, newton and newton metre, and the
/// stiffnesses behind them.
template <class T>
struct TyreForces {
  T fx_n = T(0), fy_n = T(0), mx_nm = T(0), my_nm = T(0), mz_nm = T(0);
  T slip_stiffness_n = T(0);         ///< dFx/dkappa of pure slip at the origin
  T cornering_stiffness_npr = T(0);  ///< dFy/dalpha of pure slip, signed as in the file
  T mu_x = T(0), mu_y = T(0);        ///< peak friction coefficients

  friend TyreForces select(const Flag<T>& which, const TyreForces& a, const TyreForces& b) {
    const auto one = [&](T TyreForces::*m) { return vehicle::select(which, a.*m, b.*m); };
    using F = TyreForces;
    return {one(&F::fx_n),
            one(&F::fy_n),
            one(&F::mx_nm),
            one(&F::my_nm),
            one(&F::mz_nm),
            one(&F::slip_stiffness_n),
            one(&F::cornering_stiffness_npr),
            one(&F::mu_x),
            one(&F::mu_y)};
  }
};

namespace tyre_detail {

template <class T>
T sign(const T& x) {
  return select(x > T(0), T(1), select(x < T(0), T(-1), T(0)));
}

template <class T>
T at_most_one(const T& x) {
  return select(x > T(1), T(1), x);
}

/// The argument of sin or cos in every Magic Formula: C atan(Bx - E(Bx - atan Bx)).
template <class T>
T curve(const T& b_times_x, const T& c, const T& e) {
  using maths::atan;
  // E is mostly 0 in weights of combined slip.
  const auto bent = [&] { return T(b_times_x - e * (b_times_x - atan(b_times_x))); };
  return c * atan(choose(
                 exactly_zero(e), [&] { return b_times_x; }, bent));
}

/// cos(atan(x)), cheaper.
template <class T>
T cos_atan(const T& x) {
  using std::sqrt;
  return T(1) / sqrt(T(T(1) + x * x));
}

/// (4.E15)
template <class T>
T slip_stiffness(const TyreCoefficients& t, const TyreFactors<T>& f, const T& fz, const T& dfz,
                 const T& dpi) {
  using maths::exp;
  return fz * (t.pkx1 + t.pkx2 * dfz) * exp(T(t.pkx3 * dfz)) *
         (1.0 + dpi * (t.ppx1 + t.ppx2 * dpi)) * t.lkx * f.stiffness_x;
}

/// (4.E25). It saturates with load; without load sensitivity it is proportional to the load.
template <class T>
T cornering_stiffness(const TyreCoefficients& t, const TyreFactors<T>& f, const T& fz, const T& dpi,
                      const T& gamma) {
  using maths::atan;
  using maths::sin;
  using std::abs;
  const double fz0 = t.lfzo * t.nominal_load_n;
  const T peak_load = (t.pky2 + t.pky5 * gamma * gamma) * (1.0 + t.ppy2 * dpi);
  const T saturating = sin(T(t.pky4 * atan(T(fz / fz0 / peak_load))));
  const auto partly = [&] {
    const T proportional = sin(T(t.pky4 * atan(T(1.0 / peak_load)))) * fz / fz0;
    return T(proportional + f.load_sensitivity * (saturating - proportional));
  };
  const T shape = choose(f.load_sensitivity != T(1), partly, [&] { return saturating; });
  return t.pky1 * fz0 * (1.0 + t.ppy1 * dpi) * (1.0 - t.pky3 * abs(gamma)) * shape * t.lky *
         f.stiffness_y;
}

/// (4.E2b); 0 Pa: as in the file.
template <class T>
T pressure_change(const TyreCoefficients& t, const T& pressure_pa) {
  if (!(t.nominal_pressure_pa > 0)) return T(0);
  const T pressure = select(pressure_pa == T(0), T(t.pressure_pa), pressure_pa) * t.lip;
  return (pressure - t.nominal_pressure_pa) / t.nominal_pressure_pa;
}

/// Load and pressure as the formulas see them.
template <class T>
struct Condition {
  T fz, dfz, dpi;
  T beyond;  ///< load over FZMAX where it is above, else 1
};

template <class T>
Condition<T> condition(const TyreCoefficients& t, const TyreFactors<T>& f, const T& fz_n,
                       const T& pressure_pa) {
  const double fz0 = t.lfzo * t.nominal_load_n;
  Condition<T> c;
  const auto overloaded = fz_n > T(t.fz_max_n);
  c.fz = select(overloaded, T(t.fz_max_n), fz_n);
  c.beyond = select(overloaded, T(fz_n / t.fz_max_n), T(1));
  c.dfz = f.load_sensitivity * ((c.fz - fz0) / fz0);  // (4.E2a)
  c.dpi = pressure_change(t, pressure_pa);
  return c;
}

/// (4.E13), `gamma` scaled by LGAX.
template <class T>
T peak_friction_x(const TyreCoefficients& t, const TyreFactors<T>& f, const T& dfz, const T& dpi,
                  const T& gamma) {
  return (t.pdx1 + t.pdx2 * dfz) * (1.0 + dpi * (t.ppx3 + t.ppx4 * dpi)) *
         (1.0 - t.pdx3 * gamma * gamma) * (t.lmux * f.grip_x);
}

/// (4.E23), `gamma` scaled by LGAY.
template <class T>
T peak_friction_y(const TyreCoefficients& t, const TyreFactors<T>& f, const T& dfz, const T& dpi,
                  const T& gamma) {
  return (t.pdy1 + t.pdy2 * dfz) * (1.0 + dpi * (t.ppy3 + t.ppy4 * dpi)) *
         (1.0 - t.pdy3 * (gamma * gamma)) * t.lmuy * f.grip_y;
}

/// (4.E30)
template <class T>
T camber_stiffness(const TyreCoefficients& t, const T& fz, const T& dfz, const T& dpi) {
  return fz * (t.pky6 + t.pky7 * dfz) * (1.0 + t.ppy5 * dpi) * t.lkyc;
}

/// (4.E59) to (4.E65): what longitudinal slip leaves of the side force.
template <class T>
T weight_on_y(const TyreCoefficients& t, const T& dfz, const T& kappa, const T& tan_alpha,
              const T& gamma) {
  using maths::cos;
  const T gamma2 = gamma * gamma;
  const T shift_hyk = t.rhy1 + t.rhy2 * dfz;
  const T b_yk = (t.rby1 + t.rby4 * gamma2) * cos_atan(T(t.rby2 * (tan_alpha - t.rby3))) * t.lyka;
  const T e_yk = at_most_one(T(t.rey1 + t.rey2 * dfz));
  const T c_yk = T(t.rcy1);
  const T weight = cos(curve(T(b_yk * (kappa + shift_hyk)), c_yk, e_yk));
  if (t.rhy1 == 0.0 && t.rhy2 == 0.0) return weight;
  return weight / cos(curve(T(b_yk * shift_hyk), c_yk, e_yk));
}

/// What is left of two pure forces where both slips act, without the weights of (4.E50) to (4.E67).
template <class T>
struct EllipseShare {
  T x, y;
};

/// FE_METHOD = 'YES' of PAC2002, the friction ellipse of MSC Adams (Using the PAC2002 tire model;
/// also in chrono, ChPac02Tire.cpp) with both of its fractions multiplied out, so that no slip is
/// 0/0: `x`, `y` the slips from where the pure forces vanish, the second as a sine; `fx`, `fy` the
/// pure forces without vertical shifts, `most_x`, `most_y` their peaks, `k_x`, `k_y` their slopes.
template <class T>
EllipseShare<T> ellipse_share(const T& x, const T& y, const T& fx, const T& fy, const T& most_x,
                              const T& most_y, const T& k_x, const T& k_y) {
  using std::sqrt;
  const T secant_x = choose(
      exactly_zero(x), [&] { return k_x; }, [&] { return T(fx / x); });
  const T secant_y = choose(
      exactly_zero(y), [&] { return k_y; }, [&] { return T(fy / y); });
  const T of_y = y * secant_x / most_y, of_x = x * secant_y / most_x;
  return {T(1.0 / sqrt(T(1.0 + of_y * of_y))), T(1.0 / sqrt(T(1.0 + of_x * of_x)))};
}

/// Forward 1, backward -1, in proportion below VXLOW.
template <class T>
T direction_of(const TyreCoefficients& t, const T& vx_mps) {
  const T direction = vx_mps / t.low_speed_mps;
  return select(direction > T(1), T(1), select(direction < T(-1), T(-1), direction));
}

/// What a friction factor does to the vertical shifts. 6.x, (4.E8): they fade with the grip below
/// lambda = 0.1 only; 5.2: in proportion.
template <class T>
T shift_scale(const TyreCoefficients& t, const T& lambda) {
  return t.version == 52 ? lambda : T(10.0 * lambda / (1.0 + 9.0 * lambda));
}

/// What the pure side force at one inclination consists of; the moment needs the parts.
template <class T>
struct SideForce {
  T fy, b, c, d, shift_h, shift_v, stiffness, mu;
};

/// (4.E19) to (4.E30). `alpha` is alpha* of the chosen convention; `stiffness` (4.E25) if known.
template <class T>
SideForce<T> pure_side_force(const TyreCoefficients& t, const TyreFactors<T>& f, const T& fz,
                             const T& dfz, const T& dpi, const T& alpha, const T& g,
                             const TurnSlip<T>* turning = nullptr, const T* stiffness = nullptr) {
  using maths::sin;
  const T gamma = g * t.lgay;
  const T gamma2 = gamma * gamma;
  SideForce<T> out;
  out.mu = peak_friction_y(t, f, dfz, dpi, gamma);
  const T shift_lambda = shift_scale(t, T(t.lmuy * f.grip_y));

  out.stiffness = stiffness != nullptr ? *stiffness : cornering_stiffness(t, f, fz, dpi, gamma);

  T shift_v_gamma = fz * (t.pvy3 + t.pvy4 * dfz) * gamma * t.lkyc * shift_lambda;  // (4.E28)
  if (turning != nullptr) {
    out.stiffness *= turning->stiffness_y;
    shift_v_gamma *= turning->peak_y;
    out.shift_v =
        fz * (t.pvy1 + t.pvy2 * dfz) * t.lvy * shift_lambda * turning->peak_y + shift_v_gamma;
  } else {
    out.shift_v = fz * (t.pvy1 + t.pvy2 * dfz) * t.lvy * shift_lambda + shift_v_gamma;  // (4.E29)
  }
  out.shift_h = (t.phy1 + t.phy2 * dfz) * t.lhy;
  if (t.version == 52) {
    out.shift_h += t.phy3 * gamma * t.lkyc;
  } else {  // (4.E27), (4.E30)
    const T k = out.stiffness + select(out.stiffness < T(0), T(-1e-6), T(1e-6));
    if (turning != nullptr)
      out.shift_h += turning->shift_h - shift_v_gamma / k;  // (4.84), zeta 0 = 0
    else
      out.shift_h += (camber_stiffness(t, fz, dfz, dpi) * gamma - shift_v_gamma) / k;
  }

  const T alpha_y = alpha + out.shift_h;
  out.c = T(t.pcy1 * t.lcy);
  out.d = out.mu * fz;
  if (turning != nullptr) out.d *= turning->peak_y;
  const T e =
      at_most_one((t.pey1 + t.pey2 * dfz) *
                  (1.0 + t.pey5 * gamma2 - (t.pey3 + t.pey4 * gamma) * sign(alpha_y)) * t.ley);
  const T cd = out.c * out.d;
  out.b = out.stiffness / (cd + select(cd < T(0), T(-1e-6), T(1e-6)));
  out.fy = out.d * sin(curve(T(out.b * alpha_y), out.c, e)) + out.shift_v;
  return out;
}

}  // namespace tyre_detail

/// Which outputs are wanted: the aligning moment costs as much as both forces together.
struct TyreOptions {
  AlphaConvention alpha = AlphaConvention::kTangent;
  bool moments = true;    ///< false leaves mx, my and mz at zero
  bool mirrored = false;  ///< true: the tyre on the other side of the car than the file's
};

namespace tyre_detail {

/// tyre_forces() at a load above 0; `turns`: with turn slip.
template <class T>
TyreForces<T> loaded_tyre_forces(const TyreCoefficients& t, const TyreInput<T>& in,
                                 const TyreFactors<T>& f, const TyreOptions& options, bool turns) {
  using maths::atan;
  using maths::cos;
  using maths::pow;
  using maths::sin;
  using std::abs;
  using std::sqrt;

  TyreForces<T> out;
  const Condition<T> at = condition(t, f, in.fz_n, in.pressure_pa);
  const T &fz = at.fz, &dfz = at.dfz, &dpi = at.dpi, &beyond = at.beyond;
  const double side = options.mirrored ? -1.0 : 1.0;
  const T tan_alpha = side * in.tan_alpha;
  const T inclination = side * in.gamma_rad * f.camber;
  const T gamma = sin(inclination);  // gamma*, (4.E4)
  const T alpha_pure = options.alpha == AlphaConvention::kTangent ? tan_alpha : T(atan(tan_alpha));
  const T& kappa = in.kappa;

  TyreFactors<T> factors = f;
  if (t.lmuv != 0.0) {  // (4.E7): grip that falls with sliding speed
    const T slide = kappa * kappa + tan_alpha * tan_alpha;
    const T v_s = choose(
        slide > T(0), [&] { return T(abs(in.vx_mps) * sqrt(slide)); }, [] { return T(0); });
    const T fade = 1.0 / (1.0 + t.lmuv * v_s / t.nominal_speed_mps);
    factors.grip_x *= fade;
    factors.grip_y *= fade;
  }

  // Longitudinal force at pure slip, (4.E9) to (4.E18).
  const T gamma_x = inclination * t.lgax;  // (4.E13) has gamma itself
  const T lambda_x = t.lmux * factors.grip_x;
  const T shift_hx = (t.phx1 + t.phx2 * dfz) * t.lhx;
  const T shift_vx = fz * (t.pvx1 + t.pvx2 * dfz) * t.lvx * shift_scale(t, T(lambda_x));
  const T kappa_x = kappa + shift_hx;
  out.mu_x = peak_friction_x(t, factors, dfz, dpi, T(gamma_x));
  const T d_x = out.mu_x * fz;
  const T c_x = T(t.pcx1 * t.lcx);
  const T e_x = at_most_one((t.pex1 + dfz * (t.pex2 + t.pex3 * dfz)) *
                            (1.0 - t.pex4 * sign(kappa_x)) * t.lex);
  const T k_x =
      in.upright != nullptr ? in.upright->within_slip_n : slip_stiffness(t, factors, fz, dfz, dpi);
  const T* const upright = in.upright != nullptr ? &in.upright->within_cornering_npr : nullptr;
  const T b_x = k_x / (c_x * d_x + 1e-6);
  T fx_pure = d_x * sin(curve(T(b_x * kappa_x), c_x, e_x)) + shift_vx;

  TurnSlip<T> turned;
  if (turns) {
    TurnSlipInput<T> ask;
    ask.fz_n = fz;
    ask.dfz = dfz;
    ask.kappa = kappa;
    ask.tan_alpha = tan_alpha;
    ask.gamma = gamma;
    ask.turn_1pm = side * in.turn_1pm;
    ask.direction = direction_of(t, in.vx_mps);
    ask.cornering_stiffness_n =
        upright != nullptr ? *upright : cornering_stiffness(t, factors, fz, dpi, T(0));
    ask.camber_stiffness_n = camber_stiffness(t, fz, dfz, dpi);
    ask.mu_y = peak_friction_y(t, factors, dfz, dpi, T(gamma * t.lgay));
    ask.weight_y = T(1);
    if (any(f.combined_slip != T(0)))
      ask.weight_y = 1.0 + f.combined_slip * (weight_on_y(t, dfz, kappa, tan_alpha, gamma) - 1.0);
    turned = turn_slip(t, ask);
    // Dx and SVx shrink, the slip stiffness stays.
    const T b = k_x / (c_x * d_x * turned.peak_x + 1e-6);
    fx_pure = turned.peak_x * (d_x * sin(curve(T(b * kappa_x), c_x, e_x)) + shift_vx);
  }
  const SideForce<T> lateral =
      pure_side_force(t, factors, fz, dfz, dpi, alpha_pure, gamma, turns ? &turned : nullptr);
  out.mu_y = lateral.mu;
  out.slip_stiffness_n = beyond * k_x;
  out.cornering_stiffness_npr = beyond * lateral.stiffness;

  // Combined slip: weights on the pure forces, (4.E50) to (4.E67).
  T weight_x = T(1), weight_y = T(1), shift_vyk = T(0);
  const bool combined = any(f.combined_slip != T(0));
  if (combined && t.friction_ellipse) {
    const EllipseShare<T> share =
        ellipse_share(T(kappa_x + shift_vx / k_x),
                      T(sin(alpha_pure + lateral.shift_h + lateral.shift_v / lateral.stiffness)),
                      T(fx_pure - shift_vx), T(lateral.fy - lateral.shift_v), d_x, lateral.d, k_x,
                      lateral.stiffness);
    weight_x = 1.0 + f.combined_slip * (share.x - 1.0);
    weight_y = 1.0 + f.combined_slip * (share.y - 1.0);
  } else if (combined) {
    const T gamma2 = gamma * gamma;
    const T b_xa = (t.rbx1 + t.rbx3 * gamma2) * cos_atan(T(t.rbx2 * kappa)) * t.lxal;
    const T e_xa = at_most_one(T(t.rex1 + t.rex2 * dfz));
    const T c_xa = T(t.rcx1);
    weight_x = cos(curve(T(b_xa * (tan_alpha + t.rhx1)), c_xa, e_xa));
    if (t.rhx1 != 0.0) weight_x /= cos(curve(T(b_xa * t.rhx1), c_xa, e_xa));

    weight_y = weight_on_y(t, dfz, kappa, tan_alpha, gamma);
    if (t.rvy1 != 0.0 || t.rvy2 != 0.0 || t.rvy3 != 0.0)
      shift_vyk = lateral.mu * fz * (t.rvy1 + t.rvy2 * dfz + t.rvy3 * gamma) *
                  cos_atan(T(t.rvy4 * tan_alpha)) * sin(T(t.rvy5 * atan(T(t.rvy6 * kappa)))) *
                  t.lvyka;
    if (turns) shift_vyk *= turned.peak_y;
    const auto partly = f.combined_slip != T(1);
    if (any(partly)) {
      weight_x = select(partly, T(1.0 + f.combined_slip * (weight_x - 1.0)), weight_x);
      weight_y = select(partly, T(1.0 + f.combined_slip * (weight_y - 1.0)), weight_y);
      shift_vyk = select(partly, T(f.combined_slip * shift_vyk), shift_vyk);
    }
  }
  const T fx = weight_x * fx_pure;
  const T fy = weight_y * lateral.fy + shift_vyk;
  out.fx_n = beyond * fx;
  out.fy_n = side * beyond * fy;
  if (!options.moments) return out;

  const double r0 = t.unloaded_radius_m;
  // The moments refer to the nominal load without LFZO, as in the paper (A42), (A47), (A48), (A56):
  // I. J. M. Besselink, A. J. C. Schmeitz, H. B. Pacejka, An improved Magic Formula/Swift tyre
  // model that can handle inflation pressure changes, Vehicle System Dynamics 48 (2010) S1.
  const double load0 = t.nominal_load_n;
  // Overturning couple, (4.E69), with the arc of the square as in the draft of that paper (49); the
  // book's square of the arc gives other values than the programs of its authors. QSX12 to QSX14
  // are from that draft too.
  const T fz_rel = fz / load0;
  const T fy_rel = fy / load0;
  T couple = t.qsx1 * t.lvmx - t.qsx2 * gamma * (1.0 + t.ppmx1 * dpi) -
             t.qsx12 * gamma * abs(gamma) + t.qsx3 * fy_rel;
  if (t.qsx4 != 0.0) {
    const T load_arc = atan(T((t.qsx6 * fz_rel) * (t.qsx6 * fz_rel)));
    couple += t.qsx4 * cos(T(t.qsx5 * load_arc)) *
              sin(T(t.qsx7 * gamma + t.qsx8 * atan(T(t.qsx9 * fy_rel))));
  }
  if (t.qsx10 != 0.0) couple += t.qsx10 * atan(T(t.qsx11 * fz_rel)) * gamma;
  out.mx_nm = side * beyond * r0 * fz * t.lmx * couple;
  out.mx_nm += side * beyond * r0 * fy * t.lmx * (t.qsx13 + t.qsx14 * abs(gamma));

  // Rolling resistance, (4.E70): against the direction of travel, fading out below VXLOW.
  const T v_rel = abs(in.vx_mps) / t.nominal_speed_mps;
  const T roll = t.qsy1 + t.qsy2 * fx / load0 + t.qsy3 * v_rel +
                 t.qsy4 * v_rel * v_rel * v_rel * v_rel +
                 (t.qsy5 + t.qsy6 * fz_rel) * gamma * gamma;
  T load_power = t.qsy7 == 1.0 ? fz_rel : T(pow(fz_rel, t.qsy7));
  if (t.qsy8 != 0.0 && t.nominal_pressure_pa > 0) load_power *= pow(T(1.0 + dpi), t.qsy8);
  out.my_nm = -beyond * direction_of(t, in.vx_mps) * r0 * load0 * roll * load_power * t.lmy;

  // Aligning moment: trail times the side force of the upright tyre, plus the residual moment,
  // plus the arm of Fx; (4.E31) to (4.E49) and (4.E71) to (4.E78).
  const T gamma_z = gamma * t.lgaz;
  const T grip_y = t.lmuy * factors.grip_y;
  const T stiffness = lateral.stiffness + select(lateral.stiffness < T(0), T(-1e-6), T(1e-6));
  const T alpha_t = alpha_pure + t.qhz1 + t.qhz2 * dfz + (t.qhz3 + t.qhz4 * dfz) * gamma_z;
  const T alpha_r = alpha_pure + lateral.shift_h + lateral.shift_v / stiffness;
  T alpha_t_eq = alpha_t, alpha_r_eq = alpha_r;
  const auto longitudinal = kappa != T(0) && combined && !t.friction_ellipse;
  if (any(longitudinal)) {
    const T ratio = f.combined_slip * kappa * out.slip_stiffness_n / (beyond * stiffness);
    const T extra = ratio * ratio;
    alpha_t_eq =
        select(longitudinal, T(sign(alpha_t) * sqrt(T(alpha_t * alpha_t + extra))), alpha_t);
    alpha_r_eq =
        select(longitudinal, T(sign(alpha_r) * sqrt(T(alpha_r * alpha_r + extra))), alpha_r);
  }
  const T cos_alpha = cos_atan(tan_alpha);
  const T b_t = (t.qbz1 + dfz * (t.qbz2 + t.qbz3 * dfz)) *
                (1.0 + t.qbz4 * gamma_z + t.qbz5 * abs(gamma_z)) * t.lky * factors.stiffness_y /
                (grip_y + 1e-9);
  const T c_t = T(t.qcz1);
  const T d_t = fz * (r0 / load0) * (t.qdz1 + t.qdz2 * dfz) * (1.0 - t.ppz1 * dpi) *
                (1.0 + gamma_z * (t.qdz3 + t.qdz4 * gamma_z)) * t.ltr;
  T e_alpha = T(1);
  if (t.qez4 != 0.0 || t.qez5 != 0.0)
    e_alpha +=
        (t.qez4 + t.qez5 * gamma_z) * (2.0 / 3.14159265358979323846) * atan(T(b_t * c_t * alpha_t));
  const T e_t = at_most_one(T((t.qez1 + dfz * (t.qez2 + t.qez3 * dfz)) * e_alpha));
  const T trail = d_t * cos(curve(T(b_t * alpha_t_eq), c_t, e_t)) * cos_alpha;
  const T b_r =
      t.qbz9 * t.lky * factors.stiffness_y / (grip_y + 1e-9) + t.qbz10 * lateral.b * lateral.c;
  const T d_r =
      fz * r0 *
      ((t.qdz6 + t.qdz7 * dfz) * t.lres +
       ((t.qdz8 + t.qdz9 * dfz) * (1.0 + t.ppz2 * dpi) + (t.qdz10 + t.qdz11 * dfz) * abs(gamma_z)) *
           gamma_z * t.lkzc) *
      grip_y * cos_alpha;
  T residual = d_r * cos_atan(T(b_r * alpha_r_eq));  // C_r = 1, (4.E46)
  T trail_left = trail;
  if (turns) {  // zeta 0 = 0: the inclination is part of the turning
    const T rolling =
        fz * r0 * (t.qdz6 + t.qdz7 * dfz) * t.lres * turned.peak_y * grip_y * cos_alpha;
    residual = (rolling + turned.moment_nm) *
               cos(T(turned.residual_shape * atan(T(b_r * turned.residual_slope * alpha_r_eq))));
    trail_left *= turned.trail;
  }
  // 5.2 has the inclined tyre's own side force there.
  const T fy_upright = choose(
      !turns && (gamma == T(0) || t.version == 52), [&] { return T(weight_y * lateral.fy); },
      [&] {
        return T(weight_y * pure_side_force(t, factors, fz, dfz, dpi, alpha_pure, T(0),
                                            static_cast<const TurnSlip<T>*>(nullptr), upright)
                                .fy);
      });
  const T arm = r0 * (t.ssz1 + t.ssz2 * fy_rel + (t.ssz3 + t.ssz4 * dfz) * gamma_z) * t.ls;
  T moment = -trail_left * fy_upright + residual;
  const auto backs = in.vx_mps < T(0);
  if (any(backs)) {  // rolling backward the patch's rear is its front, (4.E42), (4.E47)
    const T share = 1.0 + 2.0 * in.vx_mps / t.low_speed_mps;
    const T backward = select(share < T(-1), T(-1), share);
    const T turned_round =
        turns ? T(backward * (moment - turned.moment_nm) + turned.moment_nm) : T(moment * backward);
    moment = select(backs, turned_round, moment);
  }
  out.mz_nm = side * beyond * (moment + arm * fx);
  return out;
}

}  // namespace tyre_detail

/// The forces of a rolling tyre in steady state. Load, slips, inclination and pressure may have any
/// finite value: the load coefficients stop changing at FZMAX of the file, and beyond it forces
/// grow in proportion to the load. Zero load gives exactly zero everywhere. Checked against two
/// independent programs to 1e-5 N in Fx; what is known of Mx, My and Mz: docs/crgdrive.md.
template <class T>
TyreForces<T> tyre_forces(const TyreCoefficients& t, const TyreInput<T>& in,
                          const TyreFactors<T>& f = {}, const TyreOptions& options = {}) {
  const auto loaded = in.fz_n > T(0);
  if (!any(loaded)) return {};
  const auto turning = has_turn_slip(t) && !exactly_zero(in.turn_1pm);
  const auto forces = [&](bool turns) {
    return tyre_detail::loaded_tyre_forces(t, in, f, options, turns);
  };
  TyreForces<T> out = choose(
      turning, [&] { return forces(true); }, [&] { return forces(false); });
  if (!all(loaded)) out = select(loaded, out, TyreForces<T>{});
  return out;
}

template <class T>
Stiffness<T> tyre_stiffness(const TyreCoefficients& t, const T& fz_n, const T& pressure_pa,
                            const TyreFactors<T>& f = {}) {
  const auto loaded = fz_n > T(0);
  if (!any(loaded)) return {};
  const auto at = tyre_detail::condition(t, f, fz_n, pressure_pa);
  const T slip = tyre_detail::slip_stiffness(t, f, at.fz, at.dfz, at.dpi);
  const T cornering = tyre_detail::cornering_stiffness(t, f, at.fz, at.dpi, T(0));
  return {select(loaded, T(at.beyond * slip), T(0)), select(loaded, T(at.beyond * cornering), T(0)),
          slip, cornering};
}

/// Peak friction coefficients of the upright tyre, without what sliding speed takes (LMUV).
template <class T>
struct Friction {
  T x, y;
};

template <class T>
Friction<T> peak_friction(const TyreCoefficients& t, const T& fz_n, const T& pressure_pa,
                          const TyreFactors<T>& f = {}) {
  const auto at = tyre_detail::condition(t, f, fz_n, pressure_pa);
  return {tyre_detail::peak_friction_x(t, f, at.dfz, at.dpi, T(0)),
          tyre_detail::peak_friction_y(t, f, at.dfz, at.dpi, T(0))};
}

/// Effective rolling radius of a tyre with free radius `free_radius_m` at its speed. Empirical in
/// the load (BREFF, DREFF, FREFF); files without these get the rule of thumb that a third of the
/// deflection shortens the rolling radius. All three stated as 0: no load shortens it.
template <class T>
T rolling_radius(const TyreCoefficients& t, const T& fz_n, const T& free_radius_m,
                 const T& deflection_m) {
  using maths::atan;
  if (!t.states_rolling_radius)
    return select(deflection_m > T(0), T(free_radius_m - t.deflection_share * deflection_m),
                  free_radius_m);
  const T load = fz_n / t.nominal_load_n;
  return free_radius_m - t.nominal_load_n / (t.vertical_stiffness_npm * t.lcz) *
                             (t.freff * load + t.dreff * atan(T(t.breff * load)));
}

/// Load of a tyre that stands, by the points of its file, and the other way round.
template <class T>
T load_by_curve(const LoadCurve& c, const T& deflection_m) {
  const auto by_segment = [&](std::size_t i) {
    return T(c.load_n[i - 1] +
             (deflection_m - c.deflection_m[i - 1]) *
                 ((c.load_n[i] - c.load_n[i - 1]) / (c.deflection_m[i] - c.deflection_m[i - 1])));
  };
  T load_n = by_segment(1);
  for (std::size_t i = 1; i + 1 < c.points; ++i) {
    const auto beyond = deflection_m > T(c.deflection_m[i]);
    if (!any(beyond)) break;
    load_n = select(beyond, by_segment(i + 1), load_n);
  }
  return load_n;
}

template <class T>
T deflection_by_curve(const LoadCurve& c, const T& load_n) {
  std::size_t i = 1;
  while (i + 1 < c.points && load_n > T(c.load_n[i])) ++i;
  return c.deflection_m[i - 1] +
         (load_n - c.load_n[i - 1]) *
             ((c.deflection_m[i] - c.deflection_m[i - 1]) / (c.load_n[i] - c.load_n[i - 1]));
}

/// What speed, pressure and LCZ make of a tyre's load; (4.E68).
template <class T>
T load_factor(const TyreCoefficients& t, const T& wheel_radps, const T& pressure_pa) {
  using std::abs;
  const T speed = 1.0 + t.qv2 * abs(wheel_radps) * t.unloaded_radius_m / t.nominal_speed_mps;
  if (!(t.nominal_pressure_pa > 0)) return speed * t.lcz;
  const T inflation = select(pressure_pa == T(0), T(t.pressure_pa), pressure_pa) * t.lip;
  const T pressure = 1.0 + t.pfz1 * (inflation - t.nominal_pressure_pa) / t.nominal_pressure_pa;
  return speed * pressure * t.lcz;
}

/// Load of a tyre pressed `deflection_m` (> 0) into a plane, without damping: by the file's curve
/// where it has one, else (4.E68) without the influence of the horizontal forces. Falls back to the
/// linear stiffness where Q_FZ2 is absent.
template <class T>
T tyre_load(const TyreCoefficients& t, const T& deflection_m, const T& wheel_radps,
            const T& pressure_pa) {
  const auto pressed = deflection_m > T(0);
  if (!any(pressed)) return T(0);
  const T factor = load_factor(t, wheel_radps, pressure_pa);
  if (t.load_curve.points > 0)
    return select(pressed, T(factor * load_by_curve(t.load_curve, deflection_m)), T(0));
  const double r0 = t.unloaded_radius_m;
  // The linear coefficient follows from the stiffness at nominal load, which is what files state.
  const double stiffness = t.vertical_stiffness_npm * r0 / t.nominal_load_n;
  const double square = stiffness * stiffness - 4.0 * t.qfz2;
  const double linear = square > 0.0 ? std::sqrt(square) : stiffness;
  const double quadratic = square > 0.0 ? t.qfz2 : 0.0;
  const T x = deflection_m / r0;
  return select(pressed, T(factor * t.nominal_load_n * x * (linear + quadratic * x)), T(0));
}

/// Relaxation lengths in metres, longitudinal and lateral: stiffness of the rolling contact over
/// that of the carcass (6.x files), PTX/PTY polynomials (5.2). A lightly loaded tyre keeps
/// `shortest_m`: explicit Euler at 1 ms is stable up to 2 * shortest_m / 1 ms = 120 m/s.
template <class T>
struct Relaxation {
  T longitudinal_m, lateral_m;
};

template <class T>
Relaxation<T> relaxation_lengths(const TyreCoefficients& t, const T& fz_n,
                                 const T& slip_stiffness_n, const T& cornering_stiffness_npr,
                                 const T& gamma_rad = T(0), const T& pressure_pa = T(0),
                                 double shortest_m = 0.06) {
  using maths::atan;
  using maths::exp;
  using maths::sin;
  using std::abs;
  const double fz0 = t.lfzo * t.nominal_load_n;
  const T dfz = (fz_n - fz0) / fz0;
  const T dpi = tyre_detail::pressure_change(t, pressure_pa);
  Relaxation<T> out{T(shortest_m), T(shortest_m)};
  const auto loaded = fz_n > T(0);
  if (!any(loaded)) return out;
  if (t.longitudinal_stiffness_npm > 0) {
    const T carcass =
        t.longitudinal_stiffness_npm * (1.0 + dfz * (t.pcfx1 + t.pcfx2 * dfz) + t.pcfx3 * dpi);
    out.longitudinal_m = select(carcass > T(0), T(slip_stiffness_n / carcass), out.longitudinal_m);
  } else if (t.ptx1 != 0) {
    out.longitudinal_m = fz_n * (t.ptx1 + t.ptx2 * dfz) * exp(T(-t.ptx3 * dfz)) *
                         (t.unloaded_radius_m / t.nominal_load_n);
  }
  if (t.lateral_stiffness_npm > 0) {
    const T carcass =
        t.lateral_stiffness_npm * (1.0 + dfz * (t.pcfy1 + t.pcfy2 * dfz) + t.pcfy3 * dpi);
    out.lateral_m =
        select(carcass > T(0), T(abs(cornering_stiffness_npr) / carcass), out.lateral_m);
  } else if (t.pty1 != 0) {
    out.lateral_m = t.pty1 * sin(T(2.0 * atan(T(fz_n / (t.pty2 * fz0))))) *
                    (1.0 - t.pky3 * abs(gamma_rad * t.lgay)) * t.unloaded_radius_m * t.lfzo;
  }
  out.longitudinal_m *= t.lsgkp;
  out.lateral_m *= t.lsgal;
  out.longitudinal_m =
      select(loaded && out.longitudinal_m > T(shortest_m), out.longitudinal_m, T(shortest_m));
  out.lateral_m = select(loaded && out.lateral_m > T(shortest_m), out.lateral_m, T(shortest_m));
  return out;
}

}  // namespace vehicle
