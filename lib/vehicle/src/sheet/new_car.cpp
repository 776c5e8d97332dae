#include "vehicle/new_car.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/one_line.h"
#include "basis.h"
#include "new_engine.h"
#include "scaled_tyre.h"

namespace vehicle {
namespace {

using P = Parameter;

constexpr double kNominalOverStatic = 1.5;
constexpr double kNominalAt_mps = 50.0;  // whose downforce the nominal load has in it
constexpr double kBrakeAt_mps = 80.0;    // from which both axles can be braked to their grip
constexpr double kFullPressure_pa = 8e6;
constexpr double kPadFriction = 0.42;
constexpr double kStop_m = 0.02;
constexpr double kPressedShare = 0.4;  // of the travel, by downforce at 70 m/s, at most

/// As YAML wants words that may hold anything.
std::string quoted(const std::string& words) {
  std::string out = "'";
  for (const char c : words) out += c == '\'' ? "''" : std::string(1, c);
  return out + "'";
}

Basis basis_of(const DataSheet& sheet, ParameterLines& lines) {
  Basis b{sheet,
          lines,
          value_for(sheet.cog_height_m, Guess::kCogHeight_m, sheet.kind),
          value_for(sheet.grip, Guess::kGrip, sheet.kind),
          value_for(sheet.drag_area_m2, Guess::kDragArea_m2, sheet.kind),
          sheet.downforce_area_m2.value_or(
              std::array{guessed_value(Guess::kFrontDownforce_m2, sheet.kind),
                         guessed_value(Guess::kRearDownforce_m2, sheet.kind)}),
          {},
          {},
          {}};
  const double weight_n = sheet.mass_kg * kSheetGravity;
  b.wheel_n = {0.5 * weight_n * sheet.front_weight, 0.5 * weight_n * (1.0 - sheet.front_weight)};
  // A wide and large tyre is made for more: the car's nominal load is shared by size.
  double nominal_n = 0.0, size = 0.0;
  const auto size_of = [&](std::size_t a) {
    return sheet.tyre[a].radius_m * sheet.tyre[a].width_m;
  };
  for (std::size_t a = 0; a < 2; ++a) {
    nominal_n += kNominalOverStatic * b.wheel_n[a] +
                 0.5 * std::max(0.0, air_force_n(b.downforce_m2[a], kNominalAt_mps));
    size += size_of(a);
  }
  for (std::size_t a = 0; a < 2; ++a) {
    b.nominal_n[a] = nominal_n * size_of(a) / size;
    b.unsprung_kg[a] = sheet.mass_kg * guessed_value(Guess::kUnsprung, sheet.kind);
  }
  return b;
}

void add_chassis(const Basis& b) {
  const DataSheet& s = b.sheet;
  b.lines.stated(P::chassis_mass_kg, s.mass_kg);
  b.lines.stated(P::chassis_wheelbase_m, s.wheelbase_m);
  b.lines.stated(P::front_track_m, s.track_m[0]);
  b.lines.stated(P::rear_track_m, s.track_m[1]);
  const double front_m = (1.0 - s.front_weight) * s.wheelbase_m, rear_m = s.wheelbase_m - front_m;
  b.lines.follows(P::chassis_cog_behind_front_m, front_m,
                  fmt::format("front_weight = {:g}", s.front_weight));
  add_or_guess(b, P::chassis_cog_height_m, s.cog_height_m.has_value(), b.cog_m,
               Guess::kCogHeight_m);
  const double track_m = 0.5 * (s.track_m[0] + s.track_m[1]);
  const double gyration_m = guessed_value(Guess::kRollGyration, s.kind) * track_m;
  const double yaw = guessed_value(Guess::kYawIndex, s.kind) * s.mass_kg * front_m * rear_m;
  add_guess(b, P::chassis_roll_inertia_kgm2, s.mass_kg * gyration_m * gyration_m,
            Guess::kRollGyration);
  add_guess(b, P::chassis_pitch_inertia_kgm2, 0.95 * yaw, Guess::kYawIndex);
  add_guess(b, P::chassis_yaw_inertia_kgm2, yaw, Guess::kYawIndex);
  b.lines.guessed(P::fuel_tank_behind_front_m, front_m, 0.2, "at the centre of mass");
  b.lines.guessed(P::fuel_tank_height_m, 0.9 * b.cog_m, 0.3, "a little below the centre of mass");
}

/// Springs by the frequency of the body, stiff enough for the downforce; anti-roll bars for the
/// rest of what holds the body upright, so that the front has a little more of it
/// than its weight.
void add_springs(const Basis& b) {
  const DataSheet& s = b.sheet;
  std::array<double, 2> spring{}, body_kg{}, held{};
  for (std::size_t a = 0; a < 2; ++a) {
    const double hz =
        s.ride_hz ? (*s.ride_hz)[a]
                  : guessed_value(a == 0 ? Guess::kFrontRide_hz : Guess::kRearRide_hz, s.kind);
    body_kg[a] = b.wheel_n[a] / kSheetGravity - b.unsprung_kg[a];
    const double by_downforce = 0.5 * air_force_n(b.downforce_m2[a], 70.0) /
                                (kPressedShare * guessed_value(Guess::kTravel_m, s.kind));
    spring[a] = std::max(body_kg[a] * std::pow(2.0 * std::numbers::pi * hz, 2),
                         s.ride_hz ? 0.0 : by_downforce);
    held[a] = 0.5 * spring[a] * s.track_m[a] * s.track_m[a];
  }
  const double centre_m = 0.75 * guessed_value(Guess::kRollCentre_m, s.kind);
  const double front_share =
      std::clamp(s.front_weight + guessed_value(Guess::kFrontHold, s.kind), 0.3, 0.75);
  const double wanted =
      s.mass_kg * kSheetGravity * (b.cog_m - centre_m) / guessed_value(Guess::kRoll_radpg, s.kind);
  const double whole = std::max({wanted, held[0] / front_share, held[1] / (1.0 - front_share)});
  for (std::size_t a = 0; a < 2; ++a) {
    const double hold = whole * (a == 0 ? front_share : 1.0 - front_share) - held[a];
    const double bar = std::max(0.0, hold) / (s.track_m[a] * s.track_m[a]);
    const Guess ride = a == 0 ? Guess::kFrontRide_hz : Guess::kRearRide_hz;
    if (s.ride_hz)
      b.lines.follows(of_axle(P::front_spring_npm, a), spring[a],
                      fmt::format("ride_hz = {:g}", (*s.ride_hz)[a]));
    else
      b.lines.guessed(of_axle(P::front_spring_npm, a), spring[a], 2.0 * guess(ride).prior,
                      guess(ride).why);
    b.lines.guessed(
        of_axle(P::front_anti_roll_npm, a), bar, bar > 0.0 ? 0.5 : 0.1 * spring[a],
        fmt::format("{}; {}", guess(Guess::kRoll_radpg).why, guess(Guess::kFrontHold).why));
    b.lines.guessed(of_axle(P::front_damper_knee_mps, a), 0.1, 0.5,
                    "where dampers give way, 0.05 to 0.2 m/s");
    add_guess(b, of_axle(P::front_damper_fast_share, a), guessed_value(Guess::kFastDamping, s.kind),
              Guess::kFastDamping);
    const double critical = 2.0 * std::sqrt(spring[a] * body_kg[a]);
    add_guess(b, of_axle(P::front_bump_damping_nspm, a),
              critical * guessed_value(Guess::kBumpDamping, s.kind), Guess::kBumpDamping);
    add_guess(b, of_axle(P::front_rebound_damping_nspm, a),
              critical * guessed_value(Guess::kReboundDamping, s.kind), Guess::kReboundDamping);
  }
}

void add_wheels(const Basis& b) {
  const DataSheet& s = b.sheet;
  for (std::size_t a = 0; a < 2; ++a) {
    const double radius_m = s.tyre[a].radius_m;
    add_guess(b, of_axle(P::front_unsprung_mass_kg, a), b.unsprung_kg[a], Guess::kUnsprung);
    b.lines.guessed(of_axle(P::front_wheel_inertia_kgm2, a),
                    (a == 0 ? 0.40 : 0.48) * b.unsprung_kg[a] * radius_m * radius_m, 0.25,
                    "0.4 of the unsprung mass as far out as the tread, half shafts behind");
    const double travel_m = guessed_value(Guess::kTravel_m, s.kind);
    add_guess(b, of_axle(P::front_bump_clearance_m, a), travel_m, Guess::kTravel_m);
    add_guess(b, of_axle(P::front_droop_clearance_m, a), 1.3 * travel_m, Guess::kTravel_m);
    b.lines.guessed(of_axle(P::front_bump_stop_npm2, a), b.wheel_n[a] / (kStop_m * kStop_m), 0.5,
                    "rubber: pressed by 20 mm it carries the standing wheel's load");
    const double camber = guessed_value(Guess::kCamber_rad, s.kind);
    add_guess(b, of_axle(P::front_camber_rad, a), a == 0 ? camber : camber * 2.0 / 3.0,
              Guess::kCamber_rad);
    const double centre_m = guessed_value(Guess::kRollCentre_m, s.kind);
    b.lines.guessed(of_axle(P::front_roll_centre_m, a), a == 0 ? 0.5 * centre_m : centre_m,
                    centre_m == 0.0 ? 0.02 : guess(Guess::kRollCentre_m).prior,
                    guess(Guess::kRollCentre_m).why);
  }
}

/// Brakes that hold the tyres' grip from a high speed at 8 MPa, with a reserve of 40 %.
void add_brakes(const Basis& b) {
  const DataSheet& s = b.sheet;
  const double weight_n = s.mass_kg * kSheetGravity;
  const double shifted_n = 0.5 * b.grip * weight_n * b.cog_m / s.wheelbase_m;
  for (std::size_t a = 0; a < 2; ++a) {
    const double disc_m = s.brake_disc_m ? (*s.brake_disc_m)[a] : 0.75 * s.tyre[a].rim_m;
    const double radius_m = 0.42 * disc_m;
    if (s.brake_disc_m)
      b.lines.stated(of_axle(P::front_disc_diameter_m, a), disc_m);
    else
      b.lines.guessed(of_axle(P::front_disc_diameter_m, a), disc_m, 0.15, "0.75 of the rim");
    b.lines.guessed(of_axle(P::front_brake_radius_m, a), radius_m, 0.05, "0.42 of the disc");
    const double load_n = b.wheel_n[a] + (a == 0 ? shifted_n : 0.0) +
                          0.5 * std::max(0.0, air_force_n(b.downforce_m2[a], kBrakeAt_mps));
    const double torque_nm = 1.4 * b.grip * load_n * s.tyre[a].radius_m;
    b.lines.guessed(of_axle(P::front_brake_area_m2, a),
                    torque_nm / (2.0 * kPadFriction * radius_m * kFullPressure_pa), 0.3,
                    fmt::format("8 MPa brake to 1.4 of the grip from {:g} m/s", kBrakeAt_mps));
    // The default disc has 0.28 m.
    const double size = disc_m / 0.28;
    const char* const why = "of a steel disc of this size";
    b.lines.guessed(of_axle(P::front_disc_area_m2, a), 0.11 * size * size, 0.2, why);
    b.lines.guessed(of_axle(P::front_disc_surface_capacity_jpk, a), 900.0 * std::pow(size, 3), 0.3,
                    why);
    b.lines.guessed(of_axle(P::front_disc_core_capacity_jpk, a), 1900.0 * std::pow(size, 3), 0.3,
                    why);
  }
}

void add_air(const Basis& b) {
  const DataSheet& s = b.sheet;
  add_or_guess(b, P::aero_drag_area_m2, s.drag_area_m2.has_value(), b.drag_m2, Guess::kDragArea_m2);
  b.lines.guessed(P::aero_drag_height_m, b.cog_m, 0.3, "as high as the centre of mass");
  b.lines.guessed(P::aero_side_area_m2, 1.3 * b.drag_m2, 0.4, "1.3 of the drag area");
  b.lines.guessed(P::aero_side_behind_cog_m, 0.05 * s.wheelbase_m, 1.0, "not far from the mass");
  for (std::size_t a = 0; a < 2; ++a) {
    const Guess by = a == 0 ? Guess::kFrontDownforce_m2 : Guess::kRearDownforce_m2;
    if (s.downforce_area_m2)
      b.lines.stated(of_axle(P::front_lift_area_m2, a), b.downforce_m2[a]);
    else
      b.lines.guessed(of_axle(P::front_lift_area_m2, a), b.downforce_m2[a],
                      b.downforce_m2[a] == 0.0 ? 0.1 : guess(by).prior, guess(by).why);
  }
}

std::string terms_of(const DataSheet& sheet) {
  const Differential guessed =
      sheet.kind == CarKind::kRoad
          ? Differential::kOpen
          : (sheet.kind == CarKind::kKart ? Differential::kLocked : Differential::kLimitedSlip);
  const Differential d = sheet.differential.value_or(guessed);
  return fmt::format(
      "terms:\n"
      "  limited_slip: {}{}\n"
      "  locked_differential: {}\n"
      "  tyre_thermal: 0  # grip as stated at any temperature: no sheet tells a tyre's window\n",
      d == Differential::kLimitedSlip ? 1 : 0,
      sheet.differential ? "" : "  # the differential is guessed: usual of its kind",
      d == Differential::kLocked ? 1 : 0);
}

std::string tyre_text(const Basis& b, std::size_t a) {
  const DataSheet& s = b.sheet;
  TyreScale scale;
  scale.name = base::visible(s.tyre_name[a]);
  scale.size = s.tyre[a];
  scale.nominal_n = b.nominal_n[a];
  scale.static_n = b.wheel_n[a];
  scale.grip = b.grip;
  scale.stiffness = guessed_value(Guess::kTyreStiffness, s.kind);
  scale.mass_kg = 0.5 * b.unsprung_kg[a];
  scale.grip_source = s.grip
                          ? "as the sheet says"
                          : fmt::format("a guess within {:g} %, {}",
                                        100.0 * guess(Guess::kGrip).prior, guess(Guess::kGrip).why);
  return scaled_tyre(scale);
}

}  // namespace

NewCar make_new_car(const DataSheet& sheet) {
  ParameterLines lines;
  const Basis b = basis_of(sheet, lines);
  add_chassis(b);
  add_wheels(b);
  add_springs(b);
  add_brakes(b);
  add_engine(b);
  add_gears(b);
  add_air(b);
  NewCar out;
  out.files["front.tir"] = tyre_text(b, 0);
  out.files["rear.tir"] = tyre_text(b, 1);
  out.files["engine.csv"] = engine_map_text(sheet);
  out.files["vehicle.yaml"] =
      "# Made by crgdrive new of a data sheet. Replace what is guessed by what you measure or "
      "know\n"
      "# (docs/vehicle_parameters.md); what stands nowhere has the default of that list.\n"
      "name: " +
      quoted(base::visible(sheet.name)) +
      "\n"
      "tyres: {front: front.tir, rear: rear.tir, alpha: tan}\n"
      "maps: {engine_torque_nm: engine.csv}\n"
      "contact: single_point\n"
      "parameters:\n" +
      lines.text() + terms_of(sheet);
  out.guessed = lines.guesses();
  return out;
}

}  // namespace vehicle
