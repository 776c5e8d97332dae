// How a ventilated brake disc gives heat to the air: outer faces and vanes apart.
#pragma once

#include <cmath>

#include "vehicle/maths.h"

namespace vehicle::laws {

inline constexpr double kAirConductivity = 0.026;  ///< W/(m K), near 300 K
inline constexpr double kAirViscosity = 1.6e-5;    ///< m2/s
inline constexpr double kAirPrandtl = 0.71;

/// Nusselt number, by the disc's diameter, of its outer faces.
/// Its own turning: a free disc, 0.36 Re^0.5 laminar and 0.015 Re^0.8 turbulent with Re = omega
/// r^2 / nu, Nu by the radius (E. C. Cobb and O. A. Saunders, Proc. R. Soc. A 236, 1956; turbulent
/// beyond Re 2.4e5). The air of the moving car: 0.70 Re^0.55 and 0.04 Re^0.8 with Re = v d / nu
/// (R. Limpert, Brake Design and Safety, 2nd edition, SAE 1999; turbulent beyond Re 2.4e5). Of both
/// pairs the greater acts, so that there is no jump: they meet at 4.0e4 and 9.4e4. Both parts and
/// that of the disc at rest, `still`, are joined by the third power (S. W. Churchill and R. Usagi,
/// AIChE J. 18, 1972). Speeds are absolute values.
template <class T>
T disc_face_nusselt(const T& diameter_m, const T& disc_radps, const T& air_mps, const T& still) {
  using maths::pow;
  using std::sqrt;
  const T own = 0.25 * disc_radps * diameter_m * diameter_m / kAirViscosity;
  const T turning = 2.0 * choose(
                              own < T(39840), [&] { return T(0.36 * sqrt(T(own + 1e-9))); },
                              [&] { return T(0.015 * pow(own, 0.8)); });
  const T air = air_mps * diameter_m / kAirViscosity;
  const T blown = choose(
      air < T(93789), [&] { return T(0.70 * pow(T(air + 1e-9), 0.55)); },
      [&] { return T(0.04 * pow(air, 0.8)); });
  return pow(T(turning * turning * turning + blown * blown * blown + still * still * still + 1e-30),
             1.0 / 3.0);
}

/// Mean speed of the air in radial vanes between two diameters: a disc turning at omega sucks it in
/// at omega / 2 sqrt(D^2 - d^2); outwards the channels widen as the radius (Limpert).
template <class T>
T vane_air_mps(const T& outer_m, const T& inner_m, const T& disc_radps) {
  using std::sqrt;
  return 0.5 * disc_radps * sqrt(T(outer_m * outer_m - inner_m * inner_m)) *
         (0.5 * (1.0 + inner_m / outer_m));
}

/// Nusselt number, by the hydraulic diameter, of vanes of that length: 1.86 (Re Pr)^(1/3)
/// (d / l)^0.33 laminar, 0.023 (1 + (d / l)^0.67) Re^0.8 Pr^0.33 turbulent (Limpert, who changes at
/// Re 1e4, where they differ by a factor of two). The greater acts: they meet near Re 2e3, and what
/// was measured between (A. D. McPhee and D. A. Johnson, Int. J. Thermal Sciences 47, 2008) lies
/// near the turbulent one.
template <class T>
T vane_nusselt(const T& hydraulic_m, const T& length_m, const T& air_mps) {
  using maths::pow;
  const T reynolds = air_mps * hydraulic_m / kAirViscosity + 1e-9;
  const T slender = hydraulic_m / length_m;
  const T laminar = 1.86 * pow(T(kAirPrandtl * reynolds), 1.0 / 3.0) * pow(slender, 0.33);
  const T turbulent =
      0.023 * (1.0 + pow(slender, 0.67)) * pow(reynolds, 0.8) * std::pow(kAirPrandtl, 0.33);
  return select(laminar > turbulent, laminar, turbulent);
}

}  // namespace vehicle::laws
