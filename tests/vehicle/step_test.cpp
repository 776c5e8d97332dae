#include "vehicle/step.h"

#include <ceres/jet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>
#include <type_traits>
#include <vector>

#include "test_car.h"
#include "vehicle/error.h"

namespace step_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;

static_assert(std::is_trivially_copyable_v<Simulation<double>>);

Amplitudes<double> only(std::initializer_list<Term> on) {
  Amplitudes<double> terms;
  terms.value.fill(0.0);
  for (const Term term : on) terms[term] = 1.0;
  return terms;
}

/// A car whose tyres run straight by themselves: no toe, no camber, no shifts.
Parameters<double> straight_parameters() {
  Parameters<double> p = default_parameters();
  for (const P which : {P::front_camber_rad, P::rear_camber_rad, P::front_toe_rad, P::rear_toe_rad})
    p[which] = 0.0;
  return p;
}

CarFiles straight_files() {
  CarFiles files = test_car_files();
  files.tyre[0] = files.tyre[1] = symmetric_tyre();
  return files;
}

struct Ride {
  Car<double> car;
  Road road;
  Simulation<double> sim;
  Detail<double> detail;
  StepOptions options;

  Ride(const CarFiles& files, const Parameters<double>& p, const Amplitudes<double>& terms,
       const StartOptions& begin, const Road& ground = Road())
      : car(make_car(files, p, terms)), road(ground), sim(start(car, road, begin)) {}

  void drive(double duration_s, const Controls<double>& controls) {
    const auto steps = static_cast<int>(std::lround(duration_s / options.step_s));
    for (int i = 0; i < steps; ++i) {
      const StepResult result = step(car, sim, controls, road, options, detail);
      ASSERT_TRUE(result.ok()) << describe(result, sim.time_s, detail.wheel[0].road.u_m,
                                           detail.wheel[0].road.v_m);
    }
  }
};

TEST(Step, StandsOnSlopeAndBankWithTheLoadsOfStatics) {
  const CarFiles files = straight_files();
  const Parameters<double> p = straight_parameters();
  for (const auto& [grade, bank] :
       {std::pair{0.0, 0.0}, std::pair{0.08, 0.0}, std::pair{0.0, 0.1}, std::pair{-0.05, 0.06}}) {
    Amplitudes<double> terms = default_amplitudes();
    terms[Term::suspension_kinematics] = terms[Term::tyre_moments] = 0.0;
    StartOptions begin;
    begin.fuel_kg = 0.0;
    begin.gear = 0;
    Ride run(files, p, terms, begin, Road(grade, bank));
    Controls<double> hold;
    hold.gear_command = 0;
    hold.brake_command_pa = {3e6, 3e6, 3e6, 3e6};
    run.drive(6.0, hold);
    // Statics: weight components along the road's axes, moments about the contact points. Height of
    // the centre of mass and contact points as they came to rest.
    const double tilt = 1.0 / std::sqrt(1 + grade * grade + bank * bank);
    const double weight = p[P::chassis_mass_kg] * p[P::environment_gravity_mps2];
    double sum = 0, left = 0, front = 0;
    for (std::size_t i = 0; i < kWheels; ++i) {
      const double fz = run.detail.wheel[i].fz_n;
      sum += fz;
      if (is_left(i)) left += fz;
      if (i < 2) front += fz;
    }
    EXPECT_NEAR(sum / (weight * tilt), 1.0, 1e-3);
    const Rotation<double> R =
        rotation(run.sim.state[kRoll], run.sim.state[kPitch], run.sim.state[kYaw]);
    const Vec3<double> g = R.undo({0, 0, -weight});
    // Moments of gravity (at the origin) and of the wheel forces must cancel about the body's axes.
    Vec3<double> moment, force = g;
    for (std::size_t i = 0; i < kWheels; ++i) {
      const WheelDetail<double>& w = run.detail.wheel[i];
      const Vec3<double> f = w.fz_n * w.normal + w.fx_n * w.heading + w.fy_n * w.left;
      force += f;
      moment += cross(w.contact_m, f);
    }
    EXPECT_LT(norm(force), 1e-3 * weight) << grade << " " << bank;
    EXPECT_LT(norm(moment), 1e-3 * weight * 0.3) << grade << " " << bank;
    // Closed form for the tilted table: lateral transfer = W sin(bank) h / track (equal tracks).
    EXPECT_NEAR(front * p[P::chassis_wheelbase_m],
                weight * tilt * (p[P::chassis_wheelbase_m] - p[P::chassis_cog_behind_front_m]) -
                    weight * tilt * grade * p[P::chassis_cog_height_m],
                1e-3 * weight * p[P::chassis_wheelbase_m]);
    // The brakes hold it: no creeping.
    EXPECT_LT(std::abs(run.sim.state[kVx]), 2e-3);
    EXPECT_LT(std::abs(run.sim.state[kVy]), 2e-3);
    if (bank != 0.0) {
      EXPECT_GT((sum - 2 * left) * bank, 0.0);
    }
  }
}

// Loads that move by d from one diagonal to the other, under a body that stays where it is: a tyre
// t gives by d / t, so its spring k is longer or shorter by as much, and the perch adds d + k d /
// t.
TEST(Step, PerchesMoveCrossWeightAsStaticsSay) {
  CarFiles files = straight_files();
  for (TyreCoefficients& tyre : files.tyre) tyre.qfz2 = 0.0;
  const double moved_n = 150.0, tyre_npm = files.tyre[0].vertical_stiffness_npm;
  Parameters<double> p = straight_parameters();
  p[P::rear_track_m] = p[P::front_track_m];
  p[P::front_perch_split_n] = moved_n * (1.0 + p[P::front_spring_npm] / tyre_npm);
  p[P::rear_perch_split_n] = -moved_n * (1.0 + p[P::rear_spring_npm] / tyre_npm);
  Amplitudes<double> terms = default_amplitudes();
  for (const Term off : {Term::suspension_kinematics, Term::tyre_moments, Term::anti_roll_bar})
    terms[off] = 0.0;
  StartOptions begin;
  begin.fuel_kg = 0.0;
  begin.gear = 0;
  Ride run(files, p, terms, begin);
  Controls<double> hold;
  hold.gear_command = 0;
  hold.brake_command_pa = {3e6, 3e6, 3e6, 3e6};
  run.drive(6.0, hold);
  const double shares[] = {1.0, -1.0, -1.0, 1.0};
  for (std::size_t i = 0; i < kWheels; ++i)
    EXPECT_NEAR(run.detail.wheel[i].fz_n, run.car.static_load_n[axle_of(i)] + shares[i] * moved_n,
                0.002 * moved_n);
  EXPECT_NEAR(run.sim.state[kRoll], 0.0, 1e-6);
}

TEST(Step, CoastsDownAsTheClosedForm) {
  const CarFiles files = straight_files();
  Parameters<double> p = straight_parameters();
  p[P::aero_drag_height_m] = p[P::chassis_cog_height_m];
  StartOptions begin;
  begin.speed_mps = 70;
  begin.gear = 0;
  begin.fuel_kg = 20;
  Ride run(files, p, only({Term::aero_drag, Term::tyre_relaxation, Term::tyre_load_sensitivity}),
           begin);
  Controls<double> coast;
  coast.gear_command = 0;
  run.drive(2.0, coast);  // slips and ride heights settle
  const double v0 = run.sim.state[kVx];
  // Wheels turn with the car: their inertia over the rolling radius squared rides along.
  double mass = p[P::chassis_mass_kg] + run.sim.state[kFuel];
  for (std::size_t i = 0; i < kWheels; ++i)
    mass += p.axle(axle_of(i), P::front_wheel_inertia_kgm2) /
            (run.detail.wheel[i].rolling_radius_m * run.detail.wheel[i].rolling_radius_m);
  const double duration = 20.0;
  run.drive(duration, coast);
  const double k = 0.5 * p[P::aero_density_kgpm3] * p[P::aero_drag_area_m2] / mass;
  const double expected = v0 / (1 + k * v0 * duration);
  EXPECT_NEAR((v0 - run.sim.state[kVx]) / (v0 - expected), 1.0, 1e-3);
}

TEST(Step, BrakesStraightAsTheClosedForm) {
  const CarFiles files = straight_files();
  const Parameters<double> p = straight_parameters();
  StartOptions begin;
  begin.speed_mps = 60;
  begin.gear = 0;
  begin.fuel_kg = 0;
  Ride run(files, p, only({Term::tyre_relaxation}), begin);
  Controls<double> brake;
  brake.gear_command = 0;
  brake.brake_command_pa = {1.2e6, 1.2e6, 0.9e6, 0.9e6};
  run.drive(1.5, brake);
  const double v0 = run.sim.state[kVx];
  run.drive(1.0, brake);
  // m a = sum F, F_i r_i = T_i - I a / R_i: torques over the loaded radius, inertia over both
  // radii.
  double force = 0, mass = p[P::chassis_mass_kg];
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = axle_of(i);
    const double torque = 2 * p.axle(a, P::front_brake_friction) * brake.brake_command_pa[i] *
                          p.axle(a, P::front_brake_area_m2) * p.axle(a, P::front_brake_radius_m);
    const WheelDetail<double>& w = run.detail.wheel[i];
    const double loaded = files.tyre[a].unloaded_radius_m - w.deflection_m;
    force += torque / loaded;
    mass += p.axle(a, P::front_wheel_inertia_kgm2) / (loaded * w.rolling_radius_m) * (1 + w.kappa);
  }
  EXPECT_NEAR((v0 - run.sim.state[kVx]) / (force / mass), 1.0, 1e-3);
}

TEST(Step, CornersSteadilyAsTheClosedForm) {
  const CarFiles files = straight_files();
  const Parameters<double> p = straight_parameters();
  StartOptions begin;
  begin.speed_mps = 30;
  begin.gear = 0;
  begin.fuel_kg = 0;
  Ride run(files, p, only({Term::tyre_relaxation, Term::tyre_load_sensitivity}), begin);
  Controls<double> turn;
  turn.gear_command = 0;
  turn.steer_command_rad = 2e-4;
  run.drive(10.0, turn);
  // Linear single track: yaw rate = v delta / (L + K v^2), K = m / L (b / C_front - a / C_rear).
  const double a = p[P::chassis_cog_behind_front_m], l = p[P::chassis_wheelbase_m], b = l - a;
  const auto stiffness = [&](std::size_t axle) {
    double sum = 0;
    for (std::size_t i = 2 * axle; i < 2 * axle + 2; ++i)
      sum -= tyre_stiffness(files.tyre[axle], run.detail.wheel[i].fz_n, 0.0).cornering_npr;
    return sum;
  };
  const double k = p[P::chassis_mass_kg] / l * (b / stiffness(0) - a / stiffness(1));
  const double v = run.sim.state[kVx];
  EXPECT_NEAR(run.sim.state[kYawRate] / (v * 2e-4 / (l + k * v * v)), 1.0, 1e-3);
}

// Two rotors brought together by a slipping clutch lose I1 I2 / (I1 + I2) / 2 times the square of
// their speed difference, however they slip. Without gravity and road the wheels hang free.
TEST(Step, LosesTheEnergyOfASlippingClutch) {
  CarFiles files = straight_files();
  for (double& torque : files.engine_torque_nm.z) torque = 0.0;
  Parameters<double> p = straight_parameters();
  p[P::environment_gravity_mps2] = 0.0;
  p[P::gearbox_efficiency] = 1.0;
  p[P::engine_idle_gain_nms] = 0.0;
  p[P::chassis_pitch_inertia_kgm2] = 1e6;
  StartOptions begin;
  begin.gear = 3;
  Ride run(files, p, only({}), begin);
  run.sim.state[kZ] = 100.0;
  run.sim.state[kEngine] = 600.0;
  run.options.step_s = 2e-5;
  Controls<double> engage;
  engage.gear_command = 3;
  const double g = p[P::gearbox_ratio_3] * p[P::gearbox_final];
  double lost = 0.0;
  for (int i = 0; i < 50000; ++i) {
    ASSERT_TRUE(step(run.car, run.sim, engage, run.road, run.options, run.detail).ok());
    lost -= run.detail.power.clutch * run.options.step_s;
  }
  const double i1 = p[P::engine_inertia_kgm2];
  const double i2 = 2 * p[P::rear_wheel_inertia_kgm2] / (g * g);
  EXPECT_NEAR(lost / (0.5 * i1 * i2 / (i1 + i2) * 600.0 * 600.0), 1.0, 1e-3);
  EXPECT_NEAR(run.sim.state[kEngine] / (600.0 * i1 / (i1 + i2)), 1.0, 1e-3);
}

TEST(Step, HalvesItsErrorWithItsStep) {
  const CarFiles files = test_car_files();
  Parameters<double> p = test_parameters();
  // A damper with a kink at standstill bends the paths once per crossing; not what is asked here.
  p[P::front_rebound_damping_nspm] = p[P::front_bump_damping_nspm];
  p[P::rear_rebound_damping_nspm] = p[P::rear_bump_damping_nspm];
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::steering_actuator] = terms[Term::throttle_actuator] = terms[Term::brake_actuator] =
      0.0;
  terms[Term::steering_friction] = 0.0;
  // Steering that jumps within a step turns the tyres the faster the shorter the step.
  terms[Term::tyre_turn_slip] = 0.0;
  for (const Integrator integrator : {Integrator::kExplicitEuler, Integrator::kSemiImplicit}) {
    StartOptions begin;
    begin.speed_mps = 40;
    begin.gear = 4;
    Ride settled(files, p, terms, begin);
    Controls<double> controls;
    controls.gear_command = 4;
    controls.throttle_command = 0.4;
    settled.drive(1.0, controls);
    controls.steer_command_rad = 0.02;
    // The path of one step length, sampled at the same times for all.
    const auto path = [&](double h) {
      Ride run = settled;
      run.options.step_s = h;
      run.options.integrator = integrator;
      std::vector<State<double>> samples;
      for (int i = 0; i < 40; ++i) {
        run.drive(0.01, controls);
        samples.push_back(run.sim.state);
      }
      return samples;
    };
    const auto a = path(2.5e-4), b = path(1.25e-4), c = path(6.25e-5);
    for (const std::size_t i : {kX, kY, kZ, kRoll, kPitch, kYaw, kVx, kVy, kYawRate}) {
      double coarse = 0.0, fine = 0.0;
      for (std::size_t k = 0; k < a.size(); ++k) {
        coarse = std::max(coarse, std::abs(a[k][i] - b[k][i]));
        fine = std::max(fine, std::abs(b[k][i] - c[k][i]));
      }
      EXPECT_GE(std::log2(coarse / fine), 0.95)
          << state_name(i)
          << (integrator == Integrator::kExplicitEuler ? " explicit" : " semi-implicit");
    }
  }
}

TEST(Step, AcceleratesFromStandstillToTopSpeedAndBackWithoutOscillation) {
  const CarFiles files = test_car_files();
  Parameters<double> p = test_parameters();
  p[P::environment_wind_mps] = 0.0;
  StartOptions begin;
  Ride run(files, p, default_amplitudes(), begin);
  Controls<double> controls;
  double top = 0.0, worst = 0.0;
  std::array<std::array<double, 3>, kWheels> last{};
  int count = 0;
  const auto one = [&] {
    const StepResult result = step(run.car, run.sim, controls, run.road, run.options, run.detail);
    ASSERT_TRUE(result.ok()) << describe(result, run.sim.time_s, 0, 0);
    // Oscillation at the step rate: second differences of the load that alternate in sign.
    for (std::size_t i = 0; i < kWheels; ++i) {
      auto& l = last[i];
      const double now = run.detail.wheel[i].fz_n;
      if (count > 300) {
        const double d1 = now - l[2], d2 = l[2] - l[1], d3 = l[1] - l[0];
        if (d1 * d2 < 0 && d2 * d3 < 0)
          worst = std::max(worst, std::min({std::abs(d1), std::abs(d2), std::abs(d3)}) /
                                      run.car.static_load_n[axle_of(i)]);
      }
      l = {l[1], l[2], now};
    }
    ++count;
  };
  for (int i = 0; i < 45000 && !HasFatalFailure(); ++i) {
    controls.throttle_command = run.sim.state[kVx] < 20 ? 0.5 : 1.0;
    if (run.sim.state[kEngine] > 740 && controls.gear_command < 6 &&
        run.sim.discrete.gear == controls.gear_command)
      ++controls.gear_command;
    one();
    top = std::max(top, run.sim.state[kVx]);
  }
  EXPECT_GT(top, 75.0);
  controls.throttle_command = 0;
  controls.gear_command = 0;
  controls.brake_command_pa = {2.5e6, 2.5e6, 1.5e6, 1.5e6};
  for (int i = 0; i < 15000 && !HasFatalFailure(); ++i) one();
  EXPECT_NEAR(run.sim.state[kVx], 0.0, 0.01);
  EXPECT_LT(worst, 0.01);
  RecordProperty("top_mps", std::to_string(top));
  RecordProperty("worst", std::to_string(worst));
}

// Where a step decides (a patch that slides slowly, wheels that their brakes hold or drag, a clutch
// and a differential that stick), derivatives after parameters against central differences of it.
TEST(Step, DifferentiatesLikeCentralDifferencesWhereFrictionsStick) {
  using Jet = ceres::Jet<double, 1>;
  const CarFiles files = test_car_files();
  const Parameters<double> p = default_parameters();
  const Road road;
  for (const bool held : {false, true}) {
    State<double> s = start(make_car(files, p, default_amplitudes()), road, {}).state;
    s[kVx] = 1.2;
    for (std::size_t i = 0; i < kWheels; ++i) {
      s[kSpin + i] = held ? 0.02 : 3.0;
      s[kSlipX + i] = -0.15;
      s[kSlipY + i] = 0.05;
    }
    s[kSpin + 3] += held ? 0.0 : 0.05;
    s[kEngine] = held ? 105.0 : 30.0;
    Inputs<double> in;
    in.gear = held ? 0 : 1;
    in.throttle = 0.3;
    in.brake_pa.fill(held ? 3e6 : 4e5);
    const auto after = [&]<class T>(const Parameters<T>& parameters) {
      const Car<T> car = make_car(files, parameters, [] {
        Amplitudes<T> terms;
        const Amplitudes<double> plain = default_amplitudes();
        for (std::size_t i = 0; i < kTermCount; ++i) terms.value[i] = T(plain.value[i]);
        terms[Term::centrifugal_clutch] = T(0);
        return terms;
      }());
      State<T> state, rate;
      for (std::size_t i = 0; i < kStateSize; ++i) state[i] = T(s[i]);
      Inputs<T> inputs;
      inputs.gear = in.gear;
      inputs.throttle = T(in.throttle);
      for (std::size_t i = 0; i < kWheels; ++i) inputs.brake_pa[i] = T(in.brake_pa[i]);
      RoadCursors cursors;
      Detail<T> detail;
      derivative(car, state, inputs, road, cursors, rate, detail);
      settle_frictions(car, 0.001, rate, detail);
      integrate(car, state, rate, detail, {});
      return state;
    };
    for (const P which :
         {P::chassis_mass_kg, P::front_brake_area_m2, P::rear_brake_friction, P::front_tyre_grip,
          P::rear_tyre_slip_stiffness, P::rear_wheel_inertia_kgm2, P::engine_inertia_kgm2,
          P::clutch_torque_nm, P::differential_preload_nm, P::differential_drive_ramp,
          P::chassis_pitch_inertia_kgm2, P::tyre_carcass_damping_s}) {
      Parameters<Jet> jets;
      for (std::size_t i = 0; i < kParameterCount; ++i) jets.value[i] = Jet(p.value[i]);
      jets[which].v[0] = 1.0;
      const State<Jet> exact = after(jets);
      const double h = 1e-4 * p[which];
      const auto moved = [&](double by) {
        Parameters<double> other = p;
        other[which] += by;
        return after(other);
      };
      const State<double> a = moved(h), b = moved(-h), c = moved(2 * h), d = moved(-2 * h);
      for (std::size_t i = 0; i < kStateSize; ++i) {
        const double expected = (8 * (a[i] - b[i]) - (c[i] - d[i])) / (12 * h);
        const double noise = 1e-14 * (std::abs(s[i]) + 1.0) / h;  // rounding of the differences
        EXPECT_NEAR(exact[i].v[0], expected, 1e-6 * std::abs(expected) + noise)
            << state_name(i) << " after " << parameter_list()[static_cast<std::size_t>(which)].name
            << (held ? ", held" : "");
      }
    }
  }
}

TEST(Step, GivesTheSameBytesForTheSameInputs) {
  const CarFiles files = test_car_files();
  const auto drive = [&] {
    StartOptions begin;
    begin.speed_mps = 30;
    begin.gear = 3;
    Ride run(files, test_parameters(), default_amplitudes(), begin, Road(0.02, 0.01));
    Controls<double> controls;
    controls.gear_command = 3;
    controls.throttle_command = 0.5;
    controls.steer_command_rad = 0.05;
    run.drive(2.0, controls);
    return run.sim.state;
  };
  const State<double> a = drive(), b = drive();
  EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
}

TEST(Step, GoesOnFromACopyAsIfNothingHappened) {
  const CarFiles files = test_car_files();
  StartOptions begin;
  begin.speed_mps = 30;
  Ride run(files, test_parameters(), default_amplitudes(), begin);
  Controls<double> controls;
  controls.throttle_command = 0.7;
  controls.gear_command = 2;
  run.drive(0.53, controls);
  Ride copy = run;
  copy.sim.cursors = {};
  run.drive(1.0, controls);
  copy.drive(1.0, controls);
  EXPECT_EQ(std::memcmp(&run.sim.state, &copy.sim.state, sizeof run.sim.state), 0);
}

TEST(Step, DelaysCommandsByTheDeadTimeAndLags) {
  const CarFiles files = test_car_files();
  Parameters<double> p = test_parameters();
  p[P::throttle_dead_time_s] = 0.0305;
  p[P::throttle_lag_s] = 0.0;
  const Car<double> car = make_car(files, p, only({Term::throttle_actuator}));
  Discrete<double> d{};
  Controls<double> controls;
  for (int i = 0; i < 40; ++i) {
    controls.throttle_command = i >= 5 ? 1.0 : 0.0;
    const double got = actuate(car, d, controls, 0.001).throttle;
    EXPECT_NEAR(got, i < 35 ? 0.0 : (i == 35 ? 0.5 : 1.0), 1e-9) << i;
  }
  p[P::throttle_dead_time_s] = 0.0;
  p[P::throttle_lag_s] = 0.05;
  const Car<double> lagging = make_car(files, p, only({Term::throttle_actuator}));
  d = {};
  controls.throttle_command = 1.0;
  double got = 0.0;
  for (int i = 0; i < 100; ++i) got = actuate(lagging, d, controls, 0.001).throttle;
  EXPECT_NEAR(got, 1.0 - (1.0 + 2.0) * std::exp(-2.0), 0.01);  // two equal lags after two of them
}

TEST(Step, SticksInTheSteeringByItsFriction) {
  const CarFiles files = test_car_files();
  Parameters<double> p = test_parameters();
  p[P::steering_friction_rad] = 0.002;
  const Car<double> car = make_car(files, p, only({Term::steering_friction}));
  Discrete<double> d{};
  Controls<double> controls;
  controls.steer_command_rad = 0.001;
  EXPECT_EQ(actuate(car, d, controls, 0.001).steer_rad, 0.0);
  controls.steer_command_rad = 0.01;
  EXPECT_NEAR(actuate(car, d, controls, 0.001).steer_rad, 0.008, 1e-12);
  controls.steer_command_rad = 0.007;
  EXPECT_NEAR(actuate(car, d, controls, 0.001).steer_rad, 0.008, 1e-12);
  controls.steer_command_rad = 0.0;
  EXPECT_NEAR(actuate(car, d, controls, 0.001).steer_rad, 0.002, 1e-12);
}

TEST(Step, ShiftsWithoutTorqueForTheShiftTime) {
  const CarFiles files = test_car_files();
  const Car<double> car = make_car(files, test_parameters(), default_amplitudes());
  Discrete<double> d{};
  d.gear = d.gear_wanted = 2;
  Controls<double> controls;
  controls.gear_command = 3;
  int empty = 0;
  while (actuate(car, d, controls, 0.001).gear == 0) ++empty;
  EXPECT_EQ(empty, 50);
  EXPECT_EQ(d.gear, 3);
}

TEST(Step, EngineControlTakesTheKickOutOfAShift) {
  const CarFiles files = straight_files();
  // Engine speed over that of the new gear when the shift ends, and the jump of the car's speed
  // that follows: on an upshift the engine's spin pushes, on a downshift it holds back.
  const auto shift = [&](int from, int to, double match) {
    Parameters<double> p = straight_parameters();
    p[P::gearbox_rev_match] = match;
    StartOptions begin;
    begin.speed_mps = 35;
    begin.gear = from;
    Amplitudes<double> terms = default_amplitudes();
    terms[Term::aero_drag] = terms[Term::throttle_actuator] = 0.0;
    Ride run(files, p, terms, begin);
    Controls<double> controls;
    controls.gear_command = from;
    run.drive(0.5, controls);
    controls.gear_command = to;
    run.drive(0.05, controls);
    const auto ratio =
        static_cast<std::size_t>(P::gearbox_ratio_1) + static_cast<std::size_t>(to) - 1;
    const double wheels = 0.5 * (run.sim.state[kSpin + 2] + run.sim.state[kSpin + 3]);
    const double over =
        run.sim.state[kEngine] / (wheels * p[static_cast<P>(ratio)] * p[P::gearbox_final]);
    const double before = run.sim.state[kVx];
    run.drive(0.2, controls);
    return std::pair{over, run.sim.state[kVx] - before};
  };
  for (const auto& [from, to] : {std::pair{2, 3}, std::pair{3, 2}}) {
    const auto [free_over, free_jump] = shift(from, to, 0.0);
    const auto [over, jump] = shift(from, to, 1.0);
    EXPECT_GT(std::abs(free_over - 1.0), 0.15);
    EXPECT_NEAR(over, 1.0, 0.01);
    EXPECT_GT(std::abs(free_jump - jump), 0.1);
    EXPECT_EQ(free_jump > jump, to > from);
  }
}

TEST(Step, NamesTheStateThatStoppedBeingANumber) {
  const CarFiles files = test_car_files();
  Ride run(files, test_parameters(), default_amplitudes(), {});
  run.sim.state[kTyre + 2] = std::nan("");
  const StepResult result = step(run.car, run.sim, {}, run.road, run.options, run.detail);
  EXPECT_EQ(result.problem, StepResult::Problem::kNotFinite);
  EXPECT_THAT(describe(result, 1.5, 20.0, -3.0),
              ::testing::HasSubstr("t = 1.500 s, u = 20.00 m, v = -3.00 m"));
}

TEST(Step, RefusesDeadTimesItCannotKeep) {
  Parameters<double> p = test_parameters();
  p[P::steering_dead_time_s] = 0.2;
  EXPECT_NO_THROW(check_step(p, {}));
  EXPECT_THROW(check_step(p, {.step_s = 1e-4}), Error);
  EXPECT_THROW(check_step(p, {.step_s = 0.0}), Error);
}

TEST(Step, RefusesCarsThatCannotBe) {
  const CarFiles files = test_car_files();
  const auto refusal = [&](P which, double value) -> std::string {
    Parameters<double> p = test_parameters();
    p[which] = value;
    try {
      make_car(files, p, default_amplitudes());
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(refusal(P::chassis_mass_kg, -1), HasSubstr("chassis.mass_kg = -1 kg"));
  EXPECT_THAT(refusal(P::chassis_mass_kg, 60), HasSubstr("wheels"));
  EXPECT_THAT(refusal(P::chassis_cog_behind_front_m, 5), HasSubstr("behind the rear axle"));
  EXPECT_THAT(refusal(P::chassis_yaw_inertia_kgm2, 100), HasSubstr("wheels alone"));
  EXPECT_THAT(refusal(P::front_spring_npm, std::nan("")), HasSubstr("front.spring_npm"));
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::wind] = 2.0;
  EXPECT_THROW(make_car(files, test_parameters(), terms), Error);
  CarFiles bad = files;
  bad.engine_torque_nm.x[1] = bad.engine_torque_nm.x[2];
  EXPECT_THROW(make_car(bad, test_parameters(), default_amplitudes()), Error);
}

}  // namespace step_test
