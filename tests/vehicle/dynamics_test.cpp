#include "vehicle/dynamics.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <utility>

#include "test_car.h"

namespace dynamics_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;

constexpr int kRandomStates = 20;
constexpr P kSplits[] = {P::front_camber_split_rad, P::rear_toe_split_rad,
                         P::front_spring_split_npm, P::rear_perch_split_n};

/// A car for ovals: left wheels set otherwise than right ones.
Parameters<double> oval_parameters() {
  Parameters<double> p = test_parameters();
  p[P::front_camber_split_rad] = 0.02;
  p[P::rear_toe_split_rad] = -0.003;
  p[P::front_spring_split_npm] = 20000.0;
  p[P::rear_perch_split_n] = 400.0;
  return p;
}

template <class T>
struct Answer {
  State<T> rate;
  Detail<T> detail;
};

template <class T, TermSet Built = kAllTerms>
Answer<T> answer(const Car<T>& car, const State<T>& s, const Inputs<T>& in,
                 const Road& road = Road(0.03, -0.02)) {
  Answer<T> out;
  RoadCursors cursors;
  derivative<T, Built>(car, s, in, road, cursors, out.rate, out.detail);
  return out;
}

template <class T, std::size_t N>
std::array<T, N> lifted(const std::array<double, N>& values) {
  std::array<T, N> out;
  for (std::size_t i = 0; i < N; ++i) out[i] = T(values[i]);
  return out;
}

template <class T>
Inputs<T> lifted(const Inputs<double>& in) {
  Inputs<T> out;
  out.steer_rad = T(in.steer_rad);
  out.throttle = T(in.throttle);
  for (std::size_t i = 0; i < kWheels; ++i) out.brake_pa[i] = T(in.brake_pa[i]);
  out.gear = in.gear;
  out.opponent = in.opponent;
  out.wake_x_m = T(in.wake_x_m);
  out.wake_y_m = T(in.wake_y_m);
  return out;
}

// The derivative of the energy along the motion is the sum of all powers, whatever the state: no
// term may push without its power being counted, and constraint forces do no work.
TEST(Dynamics, ChangesItsEnergyByItsPowersOnly) {
  using Jet = ceres::Jet<double, 1>;
  const CarFiles files = test_car_files();
  std::mt19937 random(1);
  for (int trial = 0; trial < kRandomStates; ++trial) {
    Amplitudes<double> terms = default_amplitudes();
    terms[Term::locked_differential] = trial % 2;
    const Car<double> car = make_car(files, oval_parameters(), terms);
    const State<double> s = random_state(random);
    const Inputs<double> in = random_inputs(random);
    const Answer<double> a = answer(car, s, in);
    const Car<Jet> moving =
        make_car<Jet>(files, {lifted<Jet>(car.parameters.value)}, {lifted<Jet>(terms.value)});
    State<Jet> along;
    for (std::size_t i = 0; i < kStateSize; ++i) {
      along[i] = Jet(s[i]);
      along[i].v[0] = a.rate[i];
    }
    const Powers<double>& p = a.detail.power;
    const double scale = std::abs(p.tyre_normal) + std::abs(p.engine) + std::abs(p.brake) +
                         std::abs(p.driveline) + std::abs(p.tyre_x) + 1000.0;
    EXPECT_NEAR(energy(moving, along).v[0], p.sum(), 1e-9 * scale) << "trial " << trial;
  }
}

TEST(Dynamics, IsMirrorSymmetric) {
  const CarFiles files = test_car_files();
  Parameters<double> p = oval_parameters();
  p[P::environment_wind_heading_rad] = 0.0;
  const Car<double> car = make_car(files, p, default_amplitudes());
  for (const P split : kSplits) p[split] = -p[split];
  const Car<double> mirrored = make_car(files, p, default_amplitudes());
  std::mt19937 random(2);
  for (int trial = 0; trial < kRandomStates; ++trial) {
    const State<double> s = random_state(random);
    const Inputs<double> in = random_inputs(random);
    const auto mirror = [](State<double> m) {
      for (const std::size_t i : {kY, kRoll, kYaw, kVy, kRollRate, kYawRate}) m[i] = -m[i];
      for (const std::size_t group :
           {kTravel, kTravelRate, kSpin, kSlipX, kSlipY, kTyre, kDiscSurface, kDiscCore})
        for (std::size_t left = 0; left < kWheels; left += 2)
          std::swap(m[group + left], m[group + left + 1]);
      for (std::size_t i = 0; i < kWheels; ++i) m[kSlipY + i] = -m[kSlipY + i];
      return m;
    };
    Inputs<double> other = in;
    other.steer_rad = -in.steer_rad;
    other.wake_y_m = -in.wake_y_m;
    std::swap(other.brake_pa[0], other.brake_pa[1]);
    std::swap(other.brake_pa[2], other.brake_pa[3]);
    const State<double> expected = mirror(answer(car, s, in, Road(0.03, 0.02)).rate);
    const State<double> got = answer(mirrored, mirror(s), other, Road(0.03, -0.02)).rate;
    for (std::size_t i = 0; i < kStateSize; ++i)
      EXPECT_NEAR(got[i], expected[i], 1e-9 * (std::abs(expected[i]) + 10.0)) << state_name(i);
  }
}

template <std::size_t T>
void expect_absent_when_off(CarFiles files) {
  constexpr Term kTerm = static_cast<Term>(T);
  if (kTerm == Term::compressor_map || kTerm == Term::intercooler || kTerm == Term::wastegate ||
      kTerm == Term::overrun_valve || kTerm == Term::turbine_map) {
    files.turbo = Turbo::kFull;
    files.turbine_flow = {{100, 600}, {1.0, 3.0}, {2.0, 9.0, 2.0, 8.0}};
    files.turbine_efficiency = {{100, 600}, {1.0, 3.0}, {0.5, 0.6, 0.6, 0.7}};
    files.compressor_kgps = {{5000, 20000}, {1.0, 3.0}, {0.1, 0.0, 0.4, 0.2}};
  }
  std::mt19937 random(3);
  bool matters = false;
  for (int trial = 0; trial < 5; ++trial) {
    Amplitudes<double> terms = default_amplitudes();
    terms[Term::locked_differential] = 1.0;
    terms[Term::brake_vanes] = 0.5;
    State<double> s = random_state(random);
    if (files.turbo == Turbo::kFull) s[kCharge] = 2.3e5;  // so that the wastegate is open
    if (trial == 4) {                                     // low speed, where some terms only act
      s[kVx] = 0.5;
      for (std::size_t i = 0; i < kWheels; ++i) s[kSpin + i] = 2.0;
      s[kTravel] = 0.08;
      s[kEngine] = 160.0;
    }
    const Inputs<double> in = random_inputs(random);
    const Car<double> on = make_car(files, test_parameters(), terms);
    terms[static_cast<Term>(T)] = 0.0;
    const Car<double> off = make_car(files, test_parameters(), terms);
    const State<double> without_it = answer<double, without(static_cast<Term>(T))>(on, s, in).rate;
    const State<double> at_zero = answer(off, s, in).rate;
    EXPECT_EQ(std::memcmp(&without_it, &at_zero, sizeof at_zero), 0) << term_list()[T].name;
    const State<double> with_it = answer(on, s, in).rate;
    matters = matters || std::memcmp(&with_it, &at_zero, sizeof at_zero) != 0;
  }
  // The actuators act between the steps, not in the equations; step_test looks at them.
  const Term term = static_cast<Term>(T);
  const bool between_steps = term == Term::steering_actuator || term == Term::steering_friction ||
                             term == Term::throttle_actuator || term == Term::brake_actuator ||
                             term == Term::steering_backlash || term == Term::brake_friction ||
                             term == Term::throttle_friction;
  const bool flat_friction = term == Term::road_friction;  // the plane has grip 1 everywhere
  EXPECT_EQ(matters, !between_steps && !flat_friction) << term_list()[T].name;
}

template <std::size_t... T>
void expect_all_absent_when_off(std::index_sequence<T...>) {
  const CarFiles files = test_car_files();
  (expect_absent_when_off<T>(files), ...);
}

TEST(Dynamics, IsBitForBitTheSameWithATermAtZeroAsWithoutIt) {
  expect_all_absent_when_off(std::make_index_sequence<kTermCount>());
}

// Derivatives after every parameter and amplitude in turn against central differences. The bound
// is relative to the largest rate of that kind: 1e-6, the noise of the differences.
TEST(Dynamics, DifferentiatesLikeCentralDifferences) {
  using Jet = ceres::Jet<double, 1>;
  const CarFiles files = test_car_files();
  Amplitudes<double> terms = default_amplitudes();
  for (double& value : terms.value) value = 0.6;
  std::mt19937 random(4);
  const State<double> s = random_state(random);
  const Inputs<double> in = random_inputs(random);
  const Parameters<double> p = oval_parameters();
  const Car<double> car = make_car(files, p, terms);
  const State<double> plain = answer(car, s, in).rate;
  State<Jet> lifted_state{lifted<Jet>(s.value)};
  const Inputs<Jet> lifted_in = lifted<Jet>(in);
  for (std::size_t k = 0; k < kParameterCount + kTermCount; ++k) {
    Parameters<Jet> pj{lifted<Jet>(p.value)};
    Amplitudes<Jet> tj{lifted<Jet>(terms.value)};
    const bool is_parameter = k < kParameterCount;
    if (is_parameter)
      pj.value[k].v[0] = 1.0;
    else
      tj.value[k - kParameterCount].v[0] = 1.0;
    const std::string_view name =
        is_parameter ? parameter_list()[k].name : term_list()[k - kParameterCount].name;
    if (is_parameter && p.value[k] == 0.0 && name.ends_with("tyre_pressure_pa"))
      continue;  // 0 selects the file's
    const Car<Jet> cj = make_car(files, pj, tj);
    const State<Jet> rate = answer(cj, lifted_state, lifted_in).rate;
    const double x = is_parameter ? p.value[k] : terms.value[k - kParameterCount];
    const auto at = [&](double value) {
      Parameters<double> pd = p;
      Amplitudes<double> td = terms;
      (is_parameter ? pd.value[k] : td.value[k - kParameterCount]) = value;
      return answer(make_car(files, pd, td), s, in).rate;
    };
    const double h = 1e-4 * (std::abs(x) + (is_parameter ? parameter_list()[k].prior : 0.0));
    const bool one_sided = is_parameter && x - 2 * h < parameter_list()[k].low;
    if (one_sided) continue;
    const State<double> a = at(x + h), b = at(x - h), c = at(x + 2 * h), d = at(x - 2 * h);
    for (std::size_t i = 0; i < kStateSize; ++i) {
      EXPECT_NEAR(rate[i].a, plain[i], 1e-12 * (std::abs(plain[i]) + 1000.0)) << name;
      const double expected = (8 * (a[i] - b[i]) - (c[i] - d[i])) / (12 * h);
      const double noise = 1e-15 * 1e6 / h;  // of differences of rates around 1e3
      EXPECT_NEAR(
          rate[i].v[0], expected,
          1e-6 * std::abs(expected) + 1e-6 * std::abs(plain[i]) / (std::abs(x) + 1.0) + noise)
          << state_name(i) << " after " << name;
    }
  }
}

TEST(Dynamics, SpringsCarryTheCarAtDesignHeight) {
  CarFiles files = test_car_files();
  files.tyre[0] = files.tyre[1] = symmetric_tyre();  // others pull even without slip
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::aero_downforce] = 0.0;
  terms[Term::suspension_kinematics] = 0.0;
  Parameters<double> p = test_parameters();
  for (const P which : {P::front_camber_rad, P::rear_camber_rad, P::front_toe_rad, P::rear_toe_rad,
                        P::environment_wind_mps})
    p[which] = 0.0;
  const Car<double> car = make_car(files, p, terms);
  State<double> s{};
  s[kZ] = p[P::chassis_cog_height_m];
  for (std::size_t i = 0; i < kWheels; ++i) {
    s[kTyre + i] = 350;
    s[kDiscSurface + i] = s[kDiscCore + i] = 300;
  }
  const Answer<double> a = answer(car, s, {}, Road());
  double sum = 0.0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    EXPECT_NEAR(a.detail.wheel[i].fz_n, car.static_load_n[axle_of(i)], 1e-6);
    EXPECT_NEAR(a.rate[kTravelRate + i], 0.0, 1e-9);
    sum += a.detail.wheel[i].fz_n;
  }
  EXPECT_NEAR(sum, p[P::chassis_mass_kg] * p[P::environment_gravity_mps2], 1e-6);
  EXPECT_NEAR(a.rate[kVz], 0.0, 1e-9);
  EXPECT_NEAR(a.rate[kPitchRate], 0.0, 1e-9);
  EXPECT_NEAR(a.detail.specific_force_mps2.z, p[P::environment_gravity_mps2], 1e-9);
}

// A body that squats goes on through still air along its level way: downforce still points down and
// drag back, seen from the ground. Tilted with the body, 3 kN would push it by 60 N.
TEST(Dynamics, AirPushesAlongAndAcrossTheFlowHoweverTheBodyLies) {
  Amplitudes<double> terms = default_amplitudes();
  for (const Term off : {Term::wind, Term::aero_ride_height, Term::aero_yaw}) terms[off] = 0.0;
  const Car<double> car = make_car(test_car_files(), test_parameters(), terms);
  State<double> s{};
  s[kZ] = 10.0;
  const double pitch_rad = s[kPitch] = -0.02, speed_mps = 60.0;  // nose up
  const double forward = std::cos(pitch_rad), up = std::sin(pitch_rad);
  s[kVx] = speed_mps * forward;
  s[kVz] = speed_mps * up;
  for (std::size_t i = 0; i < kWheels; ++i) {
    s[kTyre + i] = 350;
    s[kDiscSurface + i] = s[kDiscCore + i] = 300;
  }
  const Detail<double> d = answer(car, s, {}, Road()).detail;
  // From the body's axes to the ground's.
  const auto along = [&](const Vec3<double>& a) { return forward * a.x + up * a.z; };
  const auto above = [&](const Vec3<double>& a) { return forward * a.z - up * a.x; };
  const double downforce_n = d.front_downforce_n + d.rear_downforce_n;
  EXPECT_GT(downforce_n, 3000.0);
  EXPECT_NEAR(downforce_n * along(d.down), 0.0, 1e-9);
  EXPECT_NEAR(above(d.down), -1.0, 1e-3);  // sqrt(1 + tan^2), 0.0002
  EXPECT_NEAR(along(d.drag), -d.drag_n, 1e-3 * d.drag_n);
  EXPECT_NEAR(above(d.drag), 0.0, 1e-9);
  EXPECT_NEAR(d.power.downforce, 0.0, 1e-6);  // of what moves across it
  EXPECT_NEAR(d.power.drag, -d.drag_n * speed_mps, 1e-3 * d.drag_n * speed_mps);
}

// A wheel that slows down pushes the nose down by its inertia times its deceleration: on a body
// that is otherwise free to pitch, by hand, torque over inertia; and amplitude halves it.
TEST(Dynamics, WheelsThatSlowDownPitchTheBody) {
  const CarFiles files = test_car_files();
  std::mt19937 random(5);
  State<double> s = random_state(random);
  s[kYawRate] = s[kRollRate] = 0.0;
  for (std::size_t i = 0; i < kWheels; ++i) s[kTravel + i] = -1.0;  // off the ground
  Parameters<double> p = test_parameters();
  p[P::front_toe_rad] = p[P::rear_toe_rad] = p[P::front_camber_rad] = p[P::rear_camber_rad] = 0.0;
  Inputs<double> in;
  in.brake_pa = {2e6, 2e6, 2e6, 2e6};
  const auto pitch = [&](double amplitude) {
    Amplitudes<double> terms = default_amplitudes();
    terms[Term::wheel_reaction] = amplitude;
    terms[Term::suspension_kinematics] = terms[Term::bump_stop] = 0.0;
    s[kZ] = 10.0;
    return answer(make_car(files, p, terms), s, in, Road());
  };
  const auto with = pitch(1.0), half = pitch(0.5), without_it = pitch(0.0);
  double torque_nm = 0.0;
  for (std::size_t i = 0; i < kWheels; ++i) torque_nm -= with.detail.wheel[i].brake_nm;
  ASSERT_GT(torque_nm, 1000.0);
  // The wheels slide freely along their travel, so the body turns with less than the whole inertia.
  double inertia_kgm2 = p[P::chassis_pitch_inertia_kgm2];
  const Car<double> car = make_car(files, p, default_amplitudes());
  for (std::size_t i = 0; i < kWheels; ++i)
    inertia_kgm2 -=
        p.axle(axle_of(i), P::front_unsprung_mass_kg) * car.wheel_m[i].x * car.wheel_m[i].x;
  const double by_hand = torque_nm / inertia_kgm2;
  EXPECT_NEAR(with.rate[kPitchRate] - without_it.rate[kPitchRate], by_hand, 0.1 * by_hand);
  EXPECT_NEAR(half.rate[kPitchRate], 0.5 * (with.rate[kPitchRate] + without_it.rate[kPitchRate]),
              1e-9);
}

// Surface and core under constant heat, without losses: the mean rises with q / (c1 + c2), the
// difference tends to its steady value with the rate G (1/c1 + 1/c2).
TEST(Dynamics, HeatsTheTwoNodeDiscAsTheExactSolution) {
  const CarFiles files = test_car_files();
  Amplitudes<double> terms = default_amplitudes();
  for (const Term off : {Term::brake_convection, Term::brake_radiation, Term::brake_heat_capacity,
                         Term::brake_friction_temperature})
    terms[off] = 0.0;
  const Parameters<double> p = test_parameters();
  const Car<double> car = make_car(files, p, terms);
  std::mt19937 random(5);
  State<double> s = random_state(random);
  s[kDiscSurface] = s[kDiscCore] = 300.0;
  Inputs<double> in;
  in.brake_pa = {3e6, 0, 0, 0};
  const double heat = [&] {
    const Answer<double> a = answer(car, s, in);
    return -p[P::brake_disc_share] * a.detail.wheel[0].brake_nm * (s[kSpin]);
  }();
  // Spin relative to the body enters; still the same number in every step, as only the disc moves.
  const Answer<double> first = answer(car, s, in);
  const double c1 = p[P::front_disc_surface_capacity_jpk], c2 = p[P::front_disc_core_capacity_jpk];
  const double q = first.rate[kDiscSurface] * c1;
  EXPECT_NEAR(q / heat, 1.0, 0.01);
  const double g = p[P::front_disc_conductance_wpk];
  const double h = 1e-4, duration = 6.0;
  for (double t = 0; t < duration - h / 2; t += h) {
    const Answer<double> a = answer(car, s, in);
    s[kDiscSurface] += h * a.rate[kDiscSurface];
    s[kDiscCore] += h * a.rate[kDiscCore];
  }
  const double rate = g * (1 / c1 + 1 / c2);
  const double difference = q / (c1 * rate) * (1 - std::exp(-rate * duration));
  const double mean = 300 + q * duration / (c1 + c2);
  EXPECT_NEAR((s[kDiscSurface] - 300) / (mean - 300 + difference * c2 / (c1 + c2)), 1.0, 1e-3);
  EXPECT_NEAR((s[kDiscCore] - 300) / (mean - 300 - difference * c1 / (c1 + c2)), 1.0, 1e-3);
}

TEST(Dynamics, CoolsTheDiscByAirAndRadiation) {
  const CarFiles files = test_car_files();
  Amplitudes<double> terms = default_amplitudes();
  const Car<double> all = make_car(files, test_parameters(), terms);
  terms[Term::brake_convection] = 0.0;
  const Car<double> no_air = make_car(files, test_parameters(), terms);
  terms[Term::brake_radiation] = 0.0;
  const Car<double> neither = make_car(files, test_parameters(), terms);
  std::mt19937 random(6);
  State<double> s = random_state(random);
  for (std::size_t i = 0; i < kWheels; ++i) s[kDiscSurface + i] = 900;
  const double with_all = answer(all, s, {}).rate[kDiscSurface];
  const double with_radiation = answer(no_air, s, {}).rate[kDiscSurface];
  const double with_none = answer(neither, s, {}).rate[kDiscSurface];
  EXPECT_LT(with_all, with_radiation);
  EXPECT_LT(with_radiation, with_none);
  s[kVx] *= 2;
  EXPECT_LT(answer(all, s, {}).rate[kDiscSurface], with_all);
}

TEST(Dynamics, TyreGripRisesIsFlatAndFallsWithTemperature) {
  const CarFiles files = test_car_files();
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::tyre_relaxation] = 0.0;
  const Car<double> car = make_car(files, test_parameters(), terms);
  StartOptions begin;
  begin.speed_mps = 40.0;
  State<double> s = start(car, Road(), begin).state;
  const auto side = [&](double kelvin) {
    s[kTyre] = kelvin;
    return std::abs(answer(car, s, {}, Road()).detail.wheel[0].fy_n);
  };
  s[kVy] = 0.25 * s[kVx];  // beyond the peak
  EXPECT_LT(side(300), 0.9 * side(325));
  EXPECT_LT(side(325), 0.95 * side(350));
  EXPECT_NEAR(side(352) / side(375), 1.0, 0.02);
  EXPECT_LT(side(420), 0.9 * side(376));
  s[kVy] = 0.02 * s[kVx];
  EXPECT_GT(side(300), 1.05 * side(340));
  EXPECT_GT(side(340), 1.05 * side(400));
}

TEST(Dynamics, SplitsTorqueAsTheDifferentialDoes) {
  const CarFiles files = test_car_files();
  std::mt19937 random(8);
  State<double> s = random_state(random);
  s[kSpin + 2] = 100;
  s[kSpin + 3] = 120;
  s[kEngine] = 700;
  Inputs<double> in;
  in.throttle = 1.0;
  in.gear = 2;
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::limited_slip] = 0.0;
  const auto open = answer(make_car(files, test_parameters(), terms), s, in).detail;
  EXPECT_EQ(open.wheel[2].drive_nm, open.wheel[3].drive_nm);
  terms[Term::limited_slip] = 1.0;
  const auto limited = answer(make_car(files, test_parameters(), terms), s, in).detail;
  EXPECT_GT(limited.wheel[2].drive_nm, limited.wheel[3].drive_nm);
  const Parameters<double> p = test_parameters();
  const double total = limited.wheel[2].drive_nm + limited.wheel[3].drive_nm;
  EXPECT_NEAR(limited.wheel[2].drive_nm - limited.wheel[3].drive_nm,
              p[P::differential_preload_nm] + p[P::differential_drive_ramp] * total, 1e-6);
  terms[Term::limited_slip] = 0.0;
  terms[Term::locked_differential] = 1.0;
  const auto locked = answer(make_car(files, test_parameters(), terms), s, in).detail;
  EXPECT_GT(locked.wheel[2].drive_nm - locked.wheel[3].drive_nm, 10000.0);
}

// The torque of the longitudinal force on the wheels: by the loaded or the rolling radius.
TEST(Dynamics, TurnsWheelsByTheArmThatTheVehicleFileNames) {
  CarFiles files = test_car_files();
  const Parameters<double> p = test_parameters();
  std::mt19937 random(8);
  const State<double> s = random_state(random);
  const Inputs<double> in = random_inputs(random);
  const auto loaded = answer(make_car(files, p, default_amplitudes()), s, in, Road());
  files.fx_arm = FxArm::kRollingRadius;
  const auto rolling = answer(make_car(files, p, default_amplitudes()), s, in, Road());
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelDetail<double>& w = rolling.detail.wheel[i];
    const TyreCoefficients& tyre = files.tyre[axle_of(i)];
    const double speed = w.spin_radps * tyre.unloaded_radius_m / tyre.nominal_speed_mps;
    const double loaded_m =
        tyre.unloaded_radius_m * (tyre.qre0 + tyre.qv1 * speed * speed) - w.deflection_m;
    const double more_nm = p.axle(axle_of(i), P::front_wheel_inertia_kgm2) *
                           (rolling.rate[kSpin + i] - loaded.rate[kSpin + i]);
    EXPECT_NEAR(more_nm, -w.fx_n * (w.rolling_radius_m - loaded_m), 1e-9 * std::abs(w.fx_n));
  }
}

TEST(Dynamics, FollowsAnOpponentWithLessDrag) {
  const CarFiles files = test_car_files();
  const Car<double> car = make_car(files, test_parameters(), default_amplitudes());
  std::mt19937 random(9);
  const State<double> s = random_state(random);
  Inputs<double> in;
  const double alone = answer(car, s, in).detail.drag_n;
  in.opponent = true;
  in.wake_x_m = 5.0;
  const double behind = answer(car, s, in).detail.drag_n;
  EXPECT_NEAR(behind / alone, 0.6, 1e-12);
  in.wake_y_m = 3.0;
  EXPECT_NEAR(answer(car, s, in).detail.drag_n / alone, 1.0, 1e-12);
}

TEST(Dynamics, BuildsBoostFasterAtHighEngineSpeed) {
  const CarFiles files = test_car_files();
  const Car<double> car = make_car(files, test_parameters(), default_amplitudes());
  std::mt19937 random(10);
  State<double> s = random_state(random);
  s[kBoost] = 0.2;
  Inputs<double> in;
  in.throttle = 1.0;
  s[kEngine] = 300;
  const auto slow = answer(car, s, in);
  s[kEngine] = 600;
  const auto fast = answer(car, s, in);
  EXPECT_NEAR(fast.rate[kBoost] / slow.rate[kBoost], 2.0, 1e-9);
  s[kBoost] = 1.0;
  EXPECT_GT(answer(car, s, in).detail.engine_nm, fast.detail.engine_nm);
}

TEST(Dynamics, ColdTyresGripLessUntilDrivingWarmsThem) {
  CarFiles files = test_car_files();
  files.tyre[0] = files.tyre[1] = symmetric_tyre();
  Parameters<double> p = default_parameters();
  p[Parameter::tyre_warm_up_loss] = 0.2;
  p[Parameter::tyre_warm_up_s] = 50;
  for (const Parameter angle : {Parameter::front_toe_rad, Parameter::rear_toe_rad,
                                Parameter::front_camber_rad, Parameter::rear_camber_rad})
    p[angle] = 0;
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::tyre_relaxation] = terms[Term::suspension_kinematics] = 0.0;
  const Car<double> car = make_car(files, p, terms);
  std::mt19937 random(12);
  State<double> s = random_state(random);
  s[kRoll] = s[kPitch] = s[kRollRate] = s[kPitchRate] = s[kYawRate] = s[kVz] = 0;
  s[kZ] = p[Parameter::chassis_cog_height_m];
  for (std::size_t i = 0; i < kWheels; ++i) s[kTravel + i] = s[kTravelRate + i] = 0;
  const auto cold_over_warm = [&](double vy_mps, std::size_t wheel) {
    s[kVy] = vy_mps;
    for (std::size_t i = 0; i < kWheels; ++i) s[kSpin + i] = s[kVx] / 0.29;
    s[kTyreWarmth] = 1;
    const auto warm = answer(car, s, {}, Road());
    s[kTyreWarmth] = 0;
    const auto cold = answer(car, s, {}, Road());
    EXPECT_EQ(warm.rate[kTyreWarmth], 0);
    EXPECT_NEAR(cold.rate[kTyreWarmth],
                std::min(3.0, 0.2 + std::abs(cold.detail.specific_force_mps2.y) / 8) / 50, 1e-12);
    return cold.detail.wheel[wheel].fy_n / warm.detail.wheel[wheel].fy_n;
  };
  for (std::size_t i = 0; i < kWheels; ++i) {
    EXPECT_NEAR(cold_over_warm(1e-3, i), 0.9, 0.002)
        << i;  // sliding little: half of it is stiffness
    EXPECT_NEAR(cold_over_warm(s[kVx], i), 0.8, 0.02) << i;  // sliding much: grip
  }
}

TEST(Dynamics, BrakesFadeWithTheHeatOfTheirPadsAndHotDiscsConductBetter) {
  const CarFiles files = test_car_files();
  Parameters<double> p = default_parameters();
  p[Parameter::brake_fade_1pmj] = 0.25;
  p[Parameter::brake_fade_s] = 20;
  p[Parameter::brake_conductance_slope_1pk] = 0.002;
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::brake_convection] = terms[Term::brake_radiation] = 0.0;
  terms[Term::brake_heat_capacity] = 0.0;
  const Car<double> car = make_car(files, p, terms);
  std::mt19937 random(11);
  State<double> s = random_state(random);
  s[kPadHeat] = 0;
  Inputs<double> in;
  for (double& pressure : in.brake_pa) pressure = 2e6;
  const auto cold = answer(car, s, in);
  s[kPadHeat] = 1.2e6;
  const auto hot = answer(car, s, in);
  // 1.2 MJ take 30 %.
  for (std::size_t i = 0; i < kWheels; ++i)
    EXPECT_NEAR(hot.detail.wheel[i].brake_nm / cold.detail.wheel[i].brake_nm, 0.7, 1e-12);
  EXPECT_NEAR(cold.rate[kPadHeat], -cold.detail.power.brake, 1e-6);
  EXPECT_NEAR(hot.rate[kPadHeat], -hot.detail.power.brake - 1.2e6 / 20, 1e-6);
  // Without brakes only conduction heats the cores: at a mean of 700 K 1.4 times as well as at 500.
  in.brake_pa = {};
  const auto into_core = [&](double mean_k) {
    for (std::size_t i = 0; i < kWheels; ++i) {
      s[kDiscSurface + i] = mean_k + 50;
      s[kDiscCore + i] = mean_k - 50;
    }
    return answer(car, s, in).rate[kDiscCore];
  };
  EXPECT_NEAR(into_core(700) / into_core(500), 1.4, 1e-9);
}

}  // namespace dynamics_test
