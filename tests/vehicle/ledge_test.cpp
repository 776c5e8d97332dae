// A road that stands still does no work: ledges take energy from a car or leave it, and never give.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "test_car.h"
#include "test_roads.h"
#include "vehicle/lap.h"

namespace ledge_test {

using namespace vehicle;  // NOLINT: a test of this library

constexpr double kLedge_at_m = 20.0;

crg::Surface ledge(double height_m, bool up) {
  return crg::Surface(straight(
      45.0, 0.05, [&](double u, double) { return (u >= kLedge_at_m) == up ? height_m : 0.0; }));
}

/// Nothing that gives or takes but road, springs and dampers.
Car<double> rolling_car(const CarFiles& files, Contact contact) {
  Parameters<double> p = default_parameters();
  p[Parameter::front_toe_rad] = p[Parameter::rear_toe_rad] = 0.0;
  Amplitudes<double> terms = default_amplitudes();
  for (const Term off : {Term::aero_drag, Term::aero_downforce, Term::rolling_resistance})
    terms[off] = 0.0;
  return make_car(files, p, terms, contact);
}

CarFiles rolling_files() {
  CarFiles files = test_car_files();
  files.tyre[0] = files.tyre[1] = symmetric_tyre();
  return files;
}

Simulation<double> rolling(const Car<double>& car, const Road& road, double speed_mps) {
  StartOptions begin;
  begin.x_m = 10.0;
  begin.speed_mps = speed_mps;
  begin.gear = 0;
  begin.fuel_kg = 0.0;
  return start(car, road, begin);
}

Controls<double> neutral() {
  Controls<double> out;
  out.gear_command = 0;
  return out;
}

/// What the tyres' springs hold.
double tyres_j(const Car<double>& car, const Detail<double>& detail) {
  double sum = 0.0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelDetail<double>& w = detail.wheel[i];
    const std::size_t a = axle_of(i);
    if (w.deflection_m > 0.0)
      sum += laws::spring_work(car.files->tyre[a], 0.0, w.deflection_m, w.spin_radps,
                               car.parameters.axle(a, Parameter::front_tyre_pressure_pa));
  }
  return sum;
}

struct Rolled {
  double rise = 0.0;  ///< largest above that before the ledge, share of the kinetic energy
  laws::LedgeTotal total;
};

/// Rolls over a ledge; `bounded` false: every step begins without knowledge of the last, so that
/// the law has nothing to compare.
Rolled roll_over(const Car<double>& car, const Road& road, double speed_mps, bool bounded) {
  Simulation<double> sim = rolling(car, road, speed_mps);
  Detail<double> detail;
  StepOptions options;
  double begin_j = 0.0, most_j = 0.0;
  for (int k = 0; k < 6000 && sim.state[kX] < 42.0 && sim.state[kX] > 5.0; ++k) {
    const State<double> before = sim.state;
    for (auto& one : sim.discrete.ledge) one.known = one.known && bounded;
    const bool ok = step(car, sim, neutral(), road, options, detail).ok();
    // The spring is that of this step's plane: what it was paid with goes in the same step.
    const double now_j =
        energy(car, before) + tyres_j(car, detail) + options.step_s * detail.power.ledge;
    if (before[kX] > kLedge_at_m - 5.0 && begin_j == 0.0) begin_j = most_j = now_j;
    most_j = std::max(most_j, now_j);
    if (!ok) break;  // some ledges end on the roof
  }
  const double kinetic_j = 0.5 * car.parameters[Parameter::chassis_mass_kg] * speed_mps * speed_mps;
  return {(most_j - begin_j) / kinetic_j, sim.discrete.ledges};
}

TEST(Ledge, GivesNoEnergyUpOrDownAtAnySpeed) {
  const CarFiles files = rolling_files();
  double worst = 0.0, worst_unbounded = 0.0;
  for (const Contact contact : {Contact::kSinglePoint, Contact::kFourPoint}) {
    const Car<double> car = rolling_car(files, contact);
    for (const bool up : {true, false})
      for (const double height_m : {0.001, 0.003, 0.01, 0.03, 0.05, 0.1, 0.2}) {
        const crg::Surface surface = ledge(height_m, up);
        for (const double speed_mps : {5.0, 10.0, 20.0, 40.0, 60.0}) {
          const double rise = roll_over(car, Road(surface), speed_mps, true).rise;
          EXPECT_LT(rise, 1e-3) << (up ? "up " : "down ") << height_m << " m, " << speed_mps
                                << " m/s, contact " << static_cast<int>(contact);
          worst = std::max(worst, rise);
        }
        worst_unbounded = std::max(worst_unbounded, roll_over(car, Road(surface), 5.0, false).rise);
      }
  }
  EXPECT_GT(worst_unbounded, 0.5);  // so the ledges are ones that would give
  RecordProperty("worst", std::to_string(worst));
}

// The explicit step too, and a smaller one.
TEST(Ledge, GivesNoEnergyByAnyIntegration) {
  const CarFiles files = rolling_files();
  const Car<double> car = rolling_car(files, Contact::kSinglePoint);
  const crg::Surface surface = ledge(0.05, false);
  for (const StepOptions options :
       {StepOptions{0.001, Integrator::kExplicitEuler}, StepOptions{0.0005}, StepOptions{0.002}}) {
    Simulation<double> sim = rolling(car, Road(surface), 20.0);
    Detail<double> detail;
    while (sim.state[kX] < 42.0)
      ASSERT_TRUE(step(car, sim, neutral(), Road(surface), options, detail).ok());
    EXPECT_LT(sim.state[kVx], 20.01) << options.step_s;
    EXPECT_GT(sim.state[kVx], 19.8) << options.step_s;
  }
}

// A wheel rolls off an edge: what lies below does not press it.
TEST(Ledge, GoingDownPressesNoWheel) {
  const CarFiles files = rolling_files();
  const Car<double> car = rolling_car(files, Contact::kSinglePoint);
  const crg::Surface surface = ledge(0.05, false);
  Simulation<double> sim = rolling(car, Road(surface), 20.0);
  Detail<double> detail;
  double most_n = 0.0;
  while (sim.state[kX] < 42.0) {
    ASSERT_TRUE(step(car, sim, neutral(), Road(surface), {}, detail).ok());
    if (sim.state[kX] > 15.0)
      for (const auto& wheel : detail.wheel) most_n = std::max(most_n, wheel.fz_n);
  }
  EXPECT_LT(most_n, 4.0 * car.static_load_n[1]);  // 12 times without the law
}

TEST(Ledge, LeavesSmoothRoadsAloneToTheBit) {
  const CarFiles files = test_car_files();
  const Car<double> car = make_car(files, test_parameters(), default_amplitudes());
  const crg::Surface surface(straight(300.0, 0.5, [](double u, double v) {
    return 0.4 * std::sin(u / 15.0) + 0.05 * v + 0.001 * std::sin(u * 3.0);
  }));
  const Road road(surface);
  StartOptions begin;
  begin.x_m = 5.0;
  begin.speed_mps = 40.0;
  begin.gear = 4;
  Simulation<double> with = start(car, road, begin), without = with;
  Detail<double> detail;
  Controls<double> drive;
  drive.throttle_command = 0.6;
  drive.gear_command = 4;
  for (int k = 0; k < 4000; ++k) {
    for (auto& one : without.discrete.ledge) one = {};
    ASSERT_TRUE(step(car, with, drive, road, {}, detail).ok());
    ASSERT_TRUE(step(car, without, drive, road, {}, detail).ok());
  }
  EXPECT_EQ(with.state.value, without.state.value);
  EXPECT_EQ(ledge_warning(with.discrete.ledges), "");
}

TEST(Ledge, IsSaidOnceWithPlaceAndWork) {
  const CarFiles files = rolling_files();
  const crg::Surface surface = ledge(0.05, true);
  for (const Contact contact : {Contact::kSinglePoint, Contact::kFourPoint}) {
    const Rolled r = roll_over(rolling_car(files, contact), Road(surface), 20.0, true);
    const std::string said = ledge_warning(r.total);
    EXPECT_THAT(said, ::testing::HasSubstr("kJ"));
    EXPECT_NEAR(r.total.u_m, kLedge_at_m, 0.3) << said;
    EXPECT_NEAR(std::abs(r.total.v_m), 0.8, 0.1) << said;
  }
  EXPECT_EQ(ledge_warning(
                roll_over(rolling_car(files, Contact::kStrip), Road(surface), 20.0, true).total),
            "");
}

// A car that is put elsewhere on the road between two steps has met no ledge.
TEST(Ledge, IsNotMetByACarThatIsPutElsewhere) {
  const CarFiles files = rolling_files();
  const Car<double> car = rolling_car(files, Contact::kSinglePoint);
  const crg::Surface surface(straight(45.0, 0.05, [](double u, double) {
    return u < kLedge_at_m ? 0.0 : 0.1 * (u - kLedge_at_m);
  }));
  Simulation<double> sim = rolling(car, Road(surface), 10.0);
  Detail<double> detail;
  for (int k = 0; k < 100; ++k)
    ASSERT_TRUE(step(car, sim, neutral(), Road(surface), {}, detail).ok());
  StartOptions there;
  there.x_m = 30.0;
  there.speed_mps = 10.0;
  there.gear = 0;
  sim.state = start(car, Road(surface), there).state;
  ASSERT_TRUE(step(car, sim, neutral(), Road(surface), {}, detail).ok());
  EXPECT_EQ(sim.discrete.ledges.work_j, 0.0);
  EXPECT_NEAR(sim.state[kVx], 10.0, 0.02);
}

}  // namespace ledge_test
