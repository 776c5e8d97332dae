#include "vehicle/step_many.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "test_car.h"
#include "test_roads.h"
#include "vehicle/error.h"

namespace step_many_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;

/// Cars of one file, no two alike, and what each was asked.
struct Field {
  std::vector<Car<double>> cars;
  std::vector<Simulation<double>> sims;

  std::vector<const Car<double>*> places() const {
    std::vector<const Car<double>*> out;
    for (const Car<double>& car : cars) out.push_back(&car);
    return out;
  }
};

Field make_field(const CarFiles& files, std::size_t count, const Road& road,
                 const Amplitudes<double>& terms = default_amplitudes(),
                 Contact contact = Contact::kSinglePoint) {
  Field out;
  for (std::size_t i = 0; i < count; ++i) {
    const double more = 0.02 * static_cast<double>(i);
    Parameters<double> p = test_parameters();
    p[P::chassis_mass_kg] *= 1.0 + more;
    p[P::front_spring_npm] *= 1.0 - more;
    p[P::steering_ratio] *= 1.0 + more;
    out.cars.push_back(make_car(files, p, terms, contact));
    StartOptions begin;
    begin.x_m = 20.0 + 3.0 * static_cast<double>(i);
    begin.y_m = -2.0 + 0.5 * static_cast<double>(i % 8);
    begin.speed_mps = i % 5 == 4 ? 0.0 : 5.0 + 4.0 * static_cast<double>(i % 8);
    begin.gear = 1 + static_cast<int>(i % 4);
    begin.fuel_kg = i % 4 == 3 ? 0.0 : 30.0;
    out.sims.push_back(start(out.cars.back(), road, begin));
  }
  return out;
}

/// Something else every tenth of a second, of every car: all pedals, shifts, neutral, reverse.
std::vector<Controls<double>> asked(std::mt19937& random, std::size_t count) {
  const auto share = [&] { return static_cast<double>(random() % 10001) / 1e4; };
  std::vector<Controls<double>> out(count);
  for (Controls<double>& c : out) {
    c.steer_command_rad = 0.4 * (share() - 0.5);
    c.throttle_command = random() % 3 == 0 ? 0.0 : share();
    if (random() % 3 == 0)
      for (double& pressure : c.brake_command_pa) pressure = 5e6 * share();
    c.gear_command = static_cast<int>(random() % 7) - 1;
    c.clutch_command = random() % 4 == 0 ? share() : 0.0;
    c.hold_n = random() % 8 == 0 ? 300.0 : 0.0;
    c.opponent = random() % 2 == 0;
    c.wake_x_m = 60.0 * share() - 5.0;
    c.wake_y_m = 8.0 * share() - 4.0;
  }
  return out;
}

/// What differs between two numbers of the same kind, bit for bit; empty: nothing.
template <std::size_t N>
std::string differing(const std::array<double, N>& a, const std::array<double, N>& b) {
  for (std::size_t i = 0; i < N; ++i)
    if (std::memcmp(&a[i], &b[i], sizeof a[i]) != 0 && !(std::isnan(a[i]) && std::isnan(b[i])))
      return std::to_string(i) + ": " + std::to_string(a[i]) + " and " + std::to_string(b[i]);
  return "";
}

std::string differing(const Detail<double>& a, const Detail<double>& b) {
  const auto rows = [](const Detail<double>& d) {
    std::vector<double> out{d.engine_nm,
                            d.clutch_nm,
                            d.gear_ratio,
                            d.drag_n,
                            d.boost,
                            d.specific_force_mps2.x,
                            d.specific_force_mps2.y,
                            d.power.sum(),
                            d.to_map.y.z,
                            d.inertia[5][5],
                            d.inputs.steer_rad,
                            d.down.z};
    for (const WheelDetail<double>& w : d.wheel)
      for (const double x : {w.fz_n, w.fx_n, w.fy_n, w.camber_rad, w.brake_nm, w.drive_nm,
                             w.deflection_m, w.couple.z, w.damper_n, w.road.z_m, w.road.u_m})
        out.push_back(x);
    return out;
  };
  const std::vector<double> of_a = rows(a), of_b = rows(b);
  for (std::size_t i = 0; i < of_a.size(); ++i)
    if (std::memcmp(&of_a[i], &of_b[i], sizeof of_a[i]) != 0) return "detail " + std::to_string(i);
  return "";
}

struct Drive {
  int steps = 1500;
  StepOptions options;
  Lanes lanes = Lanes::kBest;
};

/// Drives a field in packs beside single steps; returns how many cars ended by a problem.
std::size_t drive_both(const Field& field, const Road& road, const Drive& drive) {
  Field alone = field, together = field;
  const std::size_t n = field.cars.size();
  CarPacks packs(together.places(), drive.options.step_s, drive.lanes);
  std::vector<StepResult> of_alone(n), of_together(n);
  std::vector<Detail<double>> details(n);
  std::mt19937 random(7);
  std::vector<Controls<double>> controls;
  Detail<double> detail;
  for (int k = 0; k < drive.steps; ++k) {
    if (k % 100 == 0) controls = asked(random, n);
    const bool seen = k % 50 == 0;
    step_many(packs, together.sims, controls, road, drive.options, of_together,
              seen ? std::span(details) : std::span<Detail<double>>());
    for (std::size_t i = 0; i < n; ++i) {
      if (!of_alone[i].ok()) continue;
      of_alone[i] = step(alone.cars[i], alone.sims[i], controls[i], road, drive.options, detail);
      const Simulation<double>&a = alone.sims[i], &b = together.sims[i];
      const std::string what = differing(a.state.value, b.state.value);
      EXPECT_EQ(what, "") << "car " << i << " step " << k;
      EXPECT_EQ(of_alone[i].problem, of_together[i].problem) << i << " " << k;
      EXPECT_EQ(of_alone[i].index, of_together[i].index) << i << " " << k;
      EXPECT_EQ(a.time_s, b.time_s);
      EXPECT_EQ(std::memcmp(&a.discrete.ledges, &b.discrete.ledges, sizeof a.discrete.ledges), 0);
      if (seen) {
        EXPECT_EQ(differing(detail, details[i]), "") << "car " << i << " step " << k;
      }
      if (testing::Test::HasFailure()) return n;
    }
  }
  std::size_t failed = 0;
  for (const StepResult& result : of_together) failed += result.ok() ? 0 : 1;
  return failed;
}

class EachLanes : public testing::TestWithParam<Lanes> {
  void SetUp() override {
    if (!has_lanes(GetParam())) GTEST_SKIP() << "not on this processor";
  }
};

/// 60 m of waves, then steps of 3 cm, then level; 12 m wide.
const Road& rough_road() {
  static const crg::Surface surface(straight(900.0, 0.1, [](double u, double v) {
    if (u < 60.0) return 0.01 * std::sin(3.0 * u) * std::cos(v);
    return u < 120.0 && std::fmod(u, 10.0) < 5.0 ? 0.03 : 0.0;
  }));
  static const Road road(surface);
  return road;
}

// Five of eight lanes have cars, one brakes at rest, some burn no fuel, all terms act.
TEST_P(EachLanes, GoBitForBitWhereSingleStepsGo) {
  const CarFiles files = test_car_files();
  for (const std::size_t count : {5u, 8u, 13u})
    drive_both(make_field(files, count, rough_road()), rough_road(), {400, {}, GetParam()});
}

TEST_P(EachLanes, GoOnWhereOneHasNoRoadAndOneRollsOver) {
  const CarFiles files = test_car_files();
  Field field = make_field(files, 8, rough_road());
  field.sims[2].state[kY] = 400.0;   // beside the road
  field.sims[5].state[kRoll] = 1.3;  // on its way over
  field.sims[5].state[kRollRate] = 9.0;
  field.sims[6].state[kFuel] = std::nan("");
  Drive drive{200, {}, GetParam()};
  drive.options.stop_off_road = true;
  const std::size_t failed = drive_both(field, rough_road(), drive);
  EXPECT_GE(failed, 3u);
  EXPECT_LT(failed, 8u);
}

TEST_P(EachLanes, KnowEveryKindOfCar) {
  CarFiles turbo = test_car_files();
  turbo.turbo = Turbo::kFull;
  const Road slope(0.03, -0.02);
  drive_both(make_field(turbo, 5, slope), slope, {300, {}, GetParam()});
  Amplitudes<double> half = default_amplitudes();
  for (double& amplitude : half.value) amplitude = 0.5;
  const CarFiles files = test_car_files();
  drive_both(make_field(files, 5, slope, half), slope, {300, {}, GetParam()});
  drive_both(make_field(files, 5, rough_road(), half, Contact::kStrip), rough_road(),
             {100, {}, GetParam()});
  drive_both(make_field(files, 5, rough_road(), half, Contact::kFourPoint), rough_road(),
             {200, {}, GetParam()});
  Drive euler{200, {}, GetParam()};
  euler.options.integrator = Integrator::kExplicitEuler;
  drive_both(make_field(files, 5, slope), slope, euler);
}

// Heavier or lighter from step to step, as on crests, with grip that comes and goes.
TEST_P(EachLanes, TakeParametersThatMove) {
  constexpr std::array kMoving{P::environment_gravity_mps2, P::front_tyre_grip};
  const CarFiles files = test_car_files();
  const Road road;
  Field alone = make_field(files, 5, road), together = alone;
  CarPacks packs(together.places(), 0.001, GetParam());
  const std::vector<Controls<double>> controls(5);
  std::vector<StepResult> results(5);
  Detail<double> detail;
  for (int k = 0; k < 200; ++k) {
    for (std::size_t i = 0; i < 5; ++i)
      for (Field* field : {&alone, &together}) {
        auto& p = field->cars[i].parameters;
        p[kMoving[0]] = 9.81 + 3.0 * std::sin(0.1 * k + static_cast<double>(i));
        p[kMoving[1]] = 0.7 + 0.2 * std::cos(0.1 * k);
      }
    packs.take(kMoving);
    step_many(packs, together.sims, controls, road, {}, results);
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_TRUE(step(alone.cars[i], alone.sims[i], controls[i], road, {}, detail).ok());
      ASSERT_EQ(differing(alone.sims[i].state.value, together.sims[i].state.value), "")
          << "car " << i << " step " << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Step, EachLanes,
                         testing::Values(Lanes::kOne, Lanes::kAvx2, Lanes::kAvx512));

TEST(StepMany, PutsOnlyCarsTogetherThatComputeTheSame) {
  const CarFiles files = test_car_files(), others = test_car_files();
  const Road road;
  Field field = make_field(files, 4, road);
  Field other = make_field(others, 4, road);
  std::vector<const Car<double>*> places = field.places();
  EXPECT_EQ(CarPacks(places, 0.001, Lanes::kOne).packs(), 4u);
  if (!has_lanes(Lanes::kAvx2)) GTEST_SKIP();
  EXPECT_EQ(CarPacks(places, 0.001, Lanes::kAvx2).packs(), 1u);
  for (const Car<double>* car : other.places()) places.push_back(car);
  EXPECT_EQ(CarPacks(places, 0.001, Lanes::kAvx2).packs(), 2u);
  field.cars[1].terms[Term::brake_radiation] = 0.0;
  EXPECT_EQ(CarPacks(places, 0.001, Lanes::kAvx2).packs(), 3u);
}

TEST(StepMany, RefusesWhatDoesNotFit) {
  const CarFiles files = test_car_files();
  const Road road;
  Field field = make_field(files, 3, road);
  CarPacks packs(field.places(), 0.001);
  std::vector<Controls<double>> controls(3);
  std::vector<StepResult> results(2);
  EXPECT_THROW(step_many(packs, field.sims, controls, road, {}, results), Error);
  results.resize(3);
  StepOptions longer;
  longer.step_s = 0.002;
  EXPECT_THROW(step_many(packs, field.sims, controls, road, longer, results), Error);
  EXPECT_THROW(CarPacks(field.places(), 0.02), Error);
}

}  // namespace step_many_test
