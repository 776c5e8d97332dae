// Twenty cars as textbooks have them, reduced: their models are within the bounds.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "base/random.h"
#include "identify/proving_road.h"
#include "identify/reduce.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "vehicle/vehicle_file.h"

namespace textbook_cars_test {

using identify::LapError, identify::Reduction;

/// A tyre of few coefficients: friction, stiffnesses over the load, and load sensitivity.
struct Tyre {
  double load_n = 3000.0, mu_y = 1.2, mu_x = 1.2, cornering = 15.0, slip = 20.0;
  double shape = 1.4, sensitivity = 0.0, shift = 0.0;
};

std::string tir_of(const Tyre& t) {
  return fmt::format(
      "[MDI_HEADER]\nFILE_TYPE = 'tir'\nFILE_VERSION = 3\nFILE_FORMAT = 'ASCII'\n[UNITS]\nLENGTH = "
      "'meter'\nFORCE = 'newton'\nANGLE = 'radians'\nMASS = 'kg'\nTIME = 'second'\n[MODEL]\nFITTYP "
      "= 62\nTYRESIDE = 'LEFT'\nLONGVL = 30\nVXLOW = 1\n[DIMENSION]\nUNLOADED_RADIUS = 0.32\n"
      "[OPERATING_CONDITIONS]\nINFLPRES = 150000\nNOMPRES = 150000\n[INERTIA]\nMASS = 10\nIYY = "
      "0.6\n[VERTICAL]\nFNOMIN = {0}\nVERTICAL_STIFFNESS = 240000\nVERTICAL_DAMPING = 250\nBREFF = "
      "8\nDREFF = 0.25\nFREFF = 0.07\n[STRUCTURAL]\nLONGITUDINAL_STIFFNESS = 260000\n"
      "LATERAL_STIFFNESS = 160000\n[VERTICAL_FORCE_RANGE]\nFZMIN = 0\nFZMAX = {1}\n"
      "[LONG_SLIP_RANGE]\nKPUMIN = -1\nKPUMAX = 1\n[SLIP_ANGLE_RANGE]\nALPMIN = -0.6\nALPMAX = "
      "0.6\n[LONGITUDINAL_COEFFICIENTS]\nPCX1 = 1.6\nPDX1 = {2}\nPDX2 = {3}\nPKX1 = {4}\nRBX1 = "
      "10\nRBX2 = 8\nRCX1 = 1\n[LATERAL_COEFFICIENTS]\nPCY1 = {5}\nPDY1 = {6}\nPDY2 = {3}\nPKY1 = "
      "{7}\nPKY2 = 2\nPKY4 = 2\nRBY1 = 10\nRBY2 = 8\nRCY1 = 1\nRHY1 = {8}\n"
      "[ALIGNING_COEFFICIENTS]\nQBZ1 = 10\nQBZ9 = 10\nQCZ1 = 1.1\nQDZ1 = 0.1\nQEZ1 = -2\n",
      t.load_n, 4.0 * t.load_n, t.mu_x, t.sensitivity, t.slip, t.shape, t.mu_y, -t.cornering,
      t.shift);
}

/// One car of the ranges below in a folder of its own. Even numbers are single-track cars, whose
/// centre of mass lies on the road; every other pair has tyres that hardly saturate.
vehicle::Vehicle textbook_car(int number, const cli::Folder& folder) {
  base::Random dice = base::random_of(static_cast<std::uint64_t>(number), "textbook car");
  const auto from_to = [&](double low, double high) { return dice.uniform(low, high); };
  const bool wide = number % 2 == 1, saturates = number % 4 < 2, pressed = (number / 4) % 2 == 1;
  std::filesystem::copy(
      places::source() + "/vehicles/open_wheel", folder.path(),
      std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing);
  const double mass = from_to(700.0, 2000.0), wheelbase = from_to(2.4, 3.2),
               share = from_to(0.4, 0.6);
  Tyre tyre;
  tyre.load_n = mass * 9.81 / 4.0;
  tyre.mu_y = saturates ? from_to(0.9, 1.6) : 2.5;
  tyre.cornering = saturates ? from_to(10.0, 22.0) : from_to(9.0, 14.0);
  tyre.shape = saturates ? from_to(1.3, 1.6) : 1.0;
  tyre.sensitivity = wide ? from_to(-0.2, 0.0) : 0.0;
  tyre.mu_x = from_to(1.0, 1.6);
  tyre.slip = from_to(15.0, 30.0);
  cli::write(folder / "front.tir", tir_of(tyre));
  tyre.cornering *= from_to(0.9, 1.1);
  tyre.shift = dice.below(3) == 0 ? 0.01 : 0.0;
  cli::write(folder / "rear.tir", tir_of(tyre));
  vehicle::Vehicle out = vehicle::read_vehicle(folder / "vehicle.yaml");
  const auto set = [&](const std::string& key, double value) {
    vehicle::apply_setting(out, fmt::format("{}={:.17g}", key, value), "test");
  };
  set("chassis.mass_kg", mass);
  set("chassis.wheelbase_m", wheelbase);
  set("chassis.cog_behind_front_m", wheelbase * (1.0 - share));
  set("fuel.tank_behind_front_m", wheelbase * (1.0 - share));
  const double track = from_to(1.4, 1.7), most_g = saturates ? tyre.mu_y : 0.22 * tyre.cornering,
               height = wide ? std::min(from_to(0.3, 0.6), from_to(0.4, 0.6) * 0.5 * track / most_g)
                             : 0.02;
  set("chassis.cog_height_m", height);
  set("fuel.tank_height_m", wide ? 0.3 : 0.02);
  set("aero.drag_height_m", wide ? 0.35 : 0.02);
  set("chassis.yaw_inertia_kgm2",
      mass * share * (1.0 - share) * wheelbase * wheelbase * from_to(0.8, 1.1));
  set("chassis.roll_inertia_kgm2", 0.25 * mass);
  set("chassis.pitch_inertia_kgm2", 1.2 * mass);
  set("engine.torque", std::min(5.0, mass / 720.0));
  set("aero.drag_area_m2", from_to(0.5, 1.2));
  for (const char* term :
       {"aero_ride_height", "aero_yaw", "bump_stop", "tyre_camber", "locked_differential"})
    set(term, 0.0);
  set("limited_slip", number % 3 == 0 ? 1.0 : 0.0);
  if (!wide) set("tyre_moments", 0.0), set("suspension_kinematics", 0.0);
  // As much roll stiffness as lets it lean by 1.5 to 5 degrees at 1 g, 45 to 65 % of it in front.
  const double roll_nm = mass * 9.81 * height / (from_to(1.5, 5.0) * std::numbers::pi / 180.0),
               in_front = from_to(0.45, 0.65);
  for (const std::string axle : {"front.", "rear."}) {
    const double on_wheel = 0.5 * mass * (axle[0] == 'f' ? share : 1.0 - share),
                 natural = 2.0 * std::numbers::pi * from_to(1.5, 3.0) * (wide ? 1.0 : 2.0),
                 spring = natural * natural * on_wheel,
                 damping = 1.4 * std::sqrt(spring * on_wheel);
    set(axle + "spring_npm", spring);
    set(axle + "bump_damping_nspm", damping);
    set(axle + "rebound_damping_nspm", damping);
    set(axle + "damper_fast_share", 1.0);
    set(axle + "anti_roll_npm",
        wide ? std::max(0.0,
                        roll_nm * (axle[0] == 'f' ? in_front : 1.0 - in_front) / (track * track) -
                            0.5 * spring)
             : 0.0);
    set(axle + "roll_centre_m", wide ? from_to(0.0, 0.1) : 0.0);
    for (const char* none :
         {"camber_rad", "toe_rad", "camber_gain_radpm", "toe_gain_radpm", "anti_slope"})
      set(axle + none, 0.0);
    set(axle + "track_m", track);
    set(axle + "lift_area_m2", pressed ? from_to(0.3, 1.5) : 0.0);
    set(axle + "brake_area_m2", (axle[0] == 'f' ? 0.004 : 0.003) * mass / 720.0);
  }
  return out;
}

// Masses of 700 to 2,000 kg, wheelbases of 2.4 to 3.2 m, 40 to 60 % of the weight in front, tyres
// that saturate or hardly do, half of the cars pressed by the air; heights at which none rolls
// over.
TEST(SlowTextbookCars, AreReducedWithinTheBounds) {
  const crg::Surface road(identify::proving_road());
  int single = 0;
  for (int number = 0; number < 20; ++number) {
    SCOPED_TRACE(number);
    const cli::Folder folder;
    const vehicle::Vehicle v = textbook_car(number, folder);
    const auto car = make_car(v.files, v.parameters, v.terms, v.contact);
    identify::ReduceOptions options;
    options.speeds = 3;
    options.slips = 12;
    const Reduction r = identify::reduce_car(car, options);
    const LapError lap = identify::compare_on_lap(car, r, vehicle::Road(road));
    EXPECT_EQ(identify::why_refused(r, lap, {}, true), "");
    // One curve for two wheels of unlike loads: not for every car, and then the place is said.
    const std::string refused = identify::why_refused(r, lap, {}, false);
    single += refused.empty() ? 1 : 0;
    if (!refused.empty()) {
      EXPECT_THAT(refused, ::testing::HasSubstr("m/s, pressed by"));
    }
    for (const auto& model : {lap.single, lap.two})
      support::figure_of_case("ay_percent", 100.0 * model.ay_rms);
    for (const auto& limit : {r.limit_single, r.limit_double})
      support::figure_of_case("limit_percent", 100.0 * limit.rms);
  }
  support::figure("single_track_of_20", single);
  EXPECT_GE(single, 16);
}

}  // namespace textbook_cars_test
