// Turn slip: what turning about the vertical does to a tyre, at parking speeds above all.
//
// Source: H. B. Pacejka, Tire and Vehicle Dynamics, 3rd edition (2012), section 4.3.3, equations
// (4.76) to (4.106); numbers in the comments are those. Frame as in magic_formula.h (z up), where a
// turn to the left is what an inclination to the right is.
#pragma once

#include <cmath>

#include "vehicle/maths.h"
#include "vehicle/parameters.h"
#include "vehicle/tyre_file.h"

namespace vehicle {

/// True where the file has what the moment of turning needs (QCRP1, QDRP1) and a shape for the side
/// force (PHYP1, PHYP2). Other files turn without a moment, as if this were not there.
inline bool has_turn_slip(const TyreCoefficients& t) {
  return t.version != 52 && t.qcrp1 > 0.0 && t.qdrp1 > 0.0 && t.qdrp1 < 2.0 && t.phyp1 > 0.0 &&
         t.phyp2 > 0.0;
}

/// What the Magic Formula knows when it asks: as the file counts it, mirrored tyres already turned.
template <class T>
struct TurnSlipInput {
  T fz_n, dfz;              ///< load, and its change over the nominal one
  T kappa, tan_alpha;       ///< slips
  T gamma;                  ///< sine of the inclination
  T turn_1pm;               ///< turning rate of the wheel's plane, CCW, over its speed
  T direction;              ///< -1 backward to 1 forward, in between below VXLOW
  T cornering_stiffness_n;  ///< (4.E25) upright, without turning; signed as in the file
  T camber_stiffness_n;     ///< (4.E30)
  T mu_y, weight_y;         ///< (4.E23), (4.E59)
};

/// The factors zeta, and what stands beside them.
template <class T>
struct TurnSlip {
  T peak_x = T(1);          ///< zeta 1, (4.105): of Dx and SVx
  T peak_y = T(1);          ///< zeta 2, (4.77): of Dy, SVy, DVyk and Dr
  T stiffness_y = T(1);     ///< zeta 3, (4.79): of Kya
  T shift_h = T(0);         ///< SHy phi, (4.80): instead of the inclination's own shift
  T trail = T(1);           ///< zeta 5, (4.91): of Dt
  T residual_slope = T(1);  ///< zeta 6, (4.102): of Br
  T residual_shape = T(1);  ///< zeta 7, (4.104): Cr
  T moment_nm = T(0);       ///< zeta 8 - 1 = Dr phi, (4.100): the torque that resists the turning
};

/// Precondition: has_turn_slip(t), fz_n > 0. Finite for every finite input: the moment tends to
/// (4.95) with the turning. A tyre that turns about nothing but its inclination (turn_1pm = 0) has,
/// to first order, the camber terms of the formula without turn slip. The spin of an inclined wheel
/// is taken as that of free rolling, and the turning's share of the side force fades out below
/// VXLOW and changes its sign backward; the moment does neither.
template <class T>
TurnSlip<T> turn_slip(const TyreCoefficients& t, const TurnSlipInput<T>& in) {
  using maths::acos;
  using maths::atan;
  using maths::sin;
  using std::abs;
  using std::sqrt;
  constexpr double kPi = 3.14159265358979323846;
  const auto cos_atan = [](const T& x) { return T(T(1) / sqrt(T(1.0 + x * x))); };
  const auto shape = [](const T& b_x, double c, double e) {
    return T(sin(c * atan(T(b_x - e * (b_x - atan(b_x))))));
  };
  const auto at_most_one = [](double e) { return e > 1.0 ? 1.0 : e; };
  const double r0 = t.unloaded_radius_m;
  const T camber_share = T(1) - t.pecp1 * (1.0 + t.pecp2 * in.dfz);  // 1 - epsilon gamma, (4.90)
  const T by_camber = camber_share * in.gamma;
  const T turn = r0 * in.turn_1pm;
  const T spin = turn + by_camber;  // R0 phi, (4.76)
  const T size = abs(spin);

  TurnSlip<T> z;
  const T b_x = t.pdxp1 * (1.0 + t.pdxp2 * in.dfz) * cos_atan(T(t.pdxp3 * in.kappa));  // (4.106)
  z.peak_x = cos_atan(T(b_x * spin));
  const T b_y = t.pdyp1 * (1.0 + t.pdyp2 * in.dfz) * cos_atan(T(t.pdyp3 * in.tan_alpha));  // (4.78)
  const auto rooted = [&] { return T(t.pdyp4 * sqrt(size)); };
  const T root = choose(t.pdyp4 != 0.0 && size > T(1e-12), rooted, [] { return T(0); });
  z.peak_y = cos_atan(T(b_y * (size + root)));
  z.stiffness_y = cos_atan(T(t.pkyp1 * spin * spin));

  // Slope of the shift at the origin: camber stiffness over cornering stiffness, (4.88), (4.89).
  const T d_hy = T(t.phyp2 + t.phyp3 * in.dfz);
  const T k = z.stiffness_y * in.cornering_stiffness_n;
  const T k_y = k + select(k < T(0), T(-1e-6), T(1e-6));
  const T b_hy = in.camber_stiffness_n / camber_share / (t.phyp1 * d_hy * k_y);
  z.shift_h =
      d_hy * shape(T(b_hy * (in.direction * turn + by_camber)), t.phyp1, at_most_one(t.phyp4));

  z.trail = cos_atan(T(t.qdtp1 * spin));
  z.residual_slope = cos_atan(T(t.qbrp1 * spin));

  // (4.95): the torque of a standing wheel that is turned on and on; (4.92) to (4.99).
  const double fz0 = t.lfzo * t.nominal_load_n;
  const T most_nm = t.qcrp1 * r0 * abs(in.mu_y) * in.fz_n * sqrt(T(in.fz_n / fz0)) * t.lmp + 1e-6;
  const double c_dr = t.qdrp1;
  const T d_dr = most_nm / std::sin(0.5 * kPi * c_dr);
  const T k_zgr = in.fz_n * r0 *
                  (t.qdz8 + t.qdz9 * in.dfz + (t.qdz10 + t.qdz11 * in.dfz) * abs(in.gamma)) *
                  t.lkzc;
  const T b_dr = k_zgr / (c_dr * d_dr * camber_share);
  z.moment_nm = d_dr * shape(T(b_dr * spin), c_dr, at_most_one(t.qdrp2));

  // (4.103), (4.104): the torque left at a slip angle of 90 degrees.
  const T sideways_nm = most_nm * (2.0 / kPi) * atan(T(t.qcrp2 * abs(turn))) * in.weight_y;
  const T left = sideways_nm / (abs(z.moment_nm) + 1e-6);
  const auto between = [&] { return T((2.0 / kPi) * acos(left)); };
  const auto below = [&] { return choose(left > T(0), between, [] { return T(1); }); };
  z.residual_shape = choose(left < T(1), below, [] { return T(0); });
  return z;
}

}  // namespace vehicle
