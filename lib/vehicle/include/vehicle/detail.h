// What one evaluation of the equations of motion leaves behind beside the rates.
#pragma once

#include <array>

#include "vehicle/laws/turbocharger.h"
#include "vehicle/road.h"
#include "vehicle/state.h"
#include "vehicle/vec3.h"

namespace vehicle {

/// What happens at one wheel; vectors in the body frame.
template <class T>
struct WheelDetail {
  T fz_n = T(0), fx_n = T(0), fy_n = T(0);  ///< along the road's normal, the wheel's heading, left
  T kappa = T(0), tan_alpha = T(0);         ///< slips that the tyre formula was given
  T camber_rad = T(0);                      ///< inclination against the road
  T deflection_m = T(0);
  T slip_x_mps = T(0), slip_y_mps = T(0);    ///< velocity of the tread against the road
  T vx_mps = T(0);                           ///< of the contact point along the wheel's heading
  T brake_nm = T(0), drive_nm = T(0);        ///< torques on the wheel, forward positive
  T ride_m = T(0);                           ///< height of the floor over the road at this wheel
  Vec3<T> contact_m, heading, left, normal;  ///< contact point and axes on the road
  T rolling_radius_m = T(0);
  T decay_x_1ps = T(0), decay_y_1ps = T(0);  ///< of the contact patch's deflections
  T yield_x = T(1), yield_y = T(1);          ///< their rate per sliding speed, less by damping
  T spin_radps = T(0);                       ///< against the body
  T brake_capacity_nm = T(0);                ///< largest brake torque, either way
  Vec3<T> axis, arm, swing;  ///< spin axis; wheel centre to contact; contact per travel
  Vec3<T> centre, slide;     ///< wheel centre, and its path per travel
  Vec3<T> couple;            ///< moment of the tyre on the wheel
  T couple_on_travel = T(0), damper_n = T(0);
  RoadPointOf<Real<T>> road;
};

/// Powers that enter or leave the car, W; positive feeds the motion.
template <class T>
struct Powers {
  T tyre_normal = T(0);            ///< road on wheels along the normal, with the tyre's own spring
  T tyre_x = T(0), tyre_y = T(0);  ///< tangential forces at the tread
  T tyre_moment = T(0);            ///< rolling resistance, aligning, overturning
  T drag = T(0), downforce = T(0), side = T(0);
  T damper = T(0);
  T brake = T(0);
  T engine = T(0);     ///< torque of the engine on its own shaft
  T driveline = T(0);  ///< lost in clutch, gears and differential
  T clutch = T(0);     ///< the clutch's part of it
  T fuel = T(0);       ///< motion and height of the mass that burns
  T hold = T(0);       ///< the push from outside
  T unfelt = T(0);     ///< by what wheel_reaction below 1 leaves out of the body
  T turbo = T(0);      ///< on the turbocharger's shaft
  T ledge = T(0);      ///< of planes of the road that turn, see ledges.h

  T sum() const {
    return tyre_normal + tyre_x + tyre_y + tyre_moment + drag + downforce + side + damper + brake +
           engine + driveline + fuel + hold + unfelt + turbo + ledge;
  }
};

/// By-products of one evaluation, for telemetry, integration and checks.
template <class T>
struct Detail {
  Inputs<T> inputs;    ///< what the car was given
  Rotation<T> to_map;  ///< R_map_body
  std::array<WheelDetail<T>, kWheels> wheel;
  Powers<T> power;
  Vec3<T> specific_force_mps2;  ///< at the origin, body frame: what an accelerometer there measures
  T engine_nm = T(0), clutch_nm = T(0);
  T gear_ratio = T(0);  ///< engine over mean driven wheel; 0 in neutral, below 0 in reverse
  T drive_efficiency = T(1);
  T clutch_slip_radps = T(0);     ///< engine against gearbox
  T clutch_stiffness_nms = T(0);  ///< fall of the clutch torque per slip speed
  T differential_nm = T(0), differential_slip_radps = T(0), differential_stiffness_nms = T(0);
  T limited_slip_nm = T(0);    ///< the part of limited slip in the first, fully sliding
  T limited_slip_grip = T(0);  ///< share of it that acts, signed
  T drag_n = T(0), front_downforce_n = T(0), rear_downforce_n = T(0);
  T side_n = T(0);
  Vec3<T> drag, down;  ///< the drag's force, N; the downforce's direction; along the body's axes
  T boost = T(0);  ///< the state; full turbo: charge over wastegate pressure, both above the air
  laws::TurboRates<T> turbo;                  ///< of the full turbocharged engine
  std::array<std::array<T, 6>, 6> inertia{};  ///< of the body with its wheels, LDL^T factors
};

}  // namespace vehicle
