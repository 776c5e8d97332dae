// Rates of the states and directional derivatives, against differences.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numeric>

#include "fmu/instance.h"
#include "shared_object.h"
#include "vehicle/telemetry.h"

namespace derivatives_test {

using fmu::Instance, fmu::Type, fmu_tests::reference_of, fmu_tests::Unit;
using ::testing::HasSubstr;

constexpr double kStep_s = 0.001;

/// Of all states, one after another.
std::vector<std::uint32_t> references(const std::string& first, std::size_t count) {
  std::vector<std::uint32_t> out(count);
  std::iota(out.begin(), out.end(), reference_of(first));
  return out;
}
std::vector<std::uint32_t> all_rates() { return references("der(state.x)", vehicle::kStateSize); }

std::vector<double> read(Instance& car, const std::vector<std::uint32_t>& of) {
  std::vector<double> out;
  for (const std::uint32_t reference : of) out.push_back(car.number(reference, Type::kReal));
  return out;
}

void set(Instance& car, const std::string& name, double value) {
  EXPECT_EQ(car.set_number(reference_of(name), Type::kReal, value), "");
}

/// In a bend, on the throttle, tyres bent and warm.
void drive(Instance& car, int steps = 700) {
  set(car, "start.speed", 15.0);
  car.enter_initialisation(0.0);
  car.leave_initialisation();
  car.set_number(reference_of("input.gear"), Type::kInteger, 2);
  set(car, "input.steering", 0.05);
  set(car, "input.throttle", 0.3);
  for (int i = 0; i < steps; ++i) car.step(kStep_s * i, kStep_s);
}

TEST(Derivatives, RatesAreWhatTheNextStepAdds) {
  const Unit unit;
  Instance car(unit.resources(), unit.token());
  drive(car, 0);
  const auto states = references("state.x", vehicle::kStateSize);
  double largest = 0.0;
  for (int i = 0; i < 1500; ++i) {
    set(car, "input.brake.fl", i > 1000 ? 1e6 : 0.0);
    set(car, "input.brake.rr", i > 1000 ? 5e5 : 0.0);
    const std::vector<double> before = read(car, states), rates = read(car, all_rates());
    car.step(kStep_s * i, kStep_s);
    const std::vector<double> after = read(car, states);
    for (std::size_t k = 0; k < vehicle::kStateSize; ++k) {
      if (vehicle::kStates[k].moves != vehicle::Moves::kByRate) continue;
      const double moved = (after[k] - before[k]) / kStep_s;
      // What a difference of such numbers can tell.
      const double rounding = 4e-16 * (std::abs(after[k]) + 1.0) / kStep_s;
      EXPECT_NEAR(rates[k], moved, rounding + 1e-12 * std::abs(moved)) << vehicle::state_name(k);
      largest = std::max(largest, std::abs(moved));
    }
  }
  EXPECT_GT(largest, 100.0) << "it moved";
}

TEST(Derivatives, ReadingRatesChangesNothing) {
  const Unit unit;
  Instance car(unit.resources(), unit.token()), other(unit.resources(), unit.token());
  drive(car, 100);
  drive(other, 100);
  for (int i = 100; i < 200; ++i) {
    read(other, all_rates());
    other.derivatives(all_rates(), std::array{reference_of("state.vx")}, std::array{1.0});
    for (Instance* one : {&car, &other}) one->step(kStep_s * i, kStep_s);
  }
  EXPECT_TRUE(fmu::to_bytes(car.save(), unit.token()) == fmu::to_bytes(other.save(), unit.token()));
}

/// Central differences of all rates.
std::vector<double> differences(const std::function<std::vector<double>(double)>& rates_at,
                                double small) {
  const std::vector<double> above = rates_at(small), below = rates_at(-small);
  std::vector<double> out;
  for (std::size_t k = 0; k < above.size(); ++k)
    out.push_back((above[k] - below[k]) / (2.0 * small));
  return out;
}

/// Within 1e-5 of the largest of the same column: what these differences can tell.
void expect_alike(const std::vector<double>& exact, const std::vector<double>& differences,
                  const std::vector<double>& rates, double small) {
  ASSERT_EQ(exact.size(), differences.size());
  double largest = 0.0;
  for (const double x : differences) largest = std::max(largest, std::abs(x));
  for (std::size_t k = 0; k < exact.size(); ++k) {
    const double rounding = 1e-14 * std::abs(rates[k]) / small;
    EXPECT_NEAR(exact[k], differences[k],
                1e-5 * std::abs(differences[k]) + 1e-7 * largest + rounding)
        << "rate of " << vehicle::state_name(k);
  }
}

// On the plane, which is its own tangent plane.
TEST(Derivatives, OfRatesAfterEveryStateAreThoseOfDifferences) {
  const Unit unit(fmu::Version::kFmi2, false);
  Instance car(unit.resources(), unit.token());
  drive(car);
  const fmu::SavedState here = car.save();
  const std::vector<double> rates = read(car, all_rates());
  for (std::size_t k = 0; k < vehicle::kStateSize; ++k) {
    SCOPED_TRACE(std::string("after ") + std::string(vehicle::state_name(k)));
    const std::array known{static_cast<std::uint32_t>(reference_of("state.x") + k)};
    const std::vector<double> exact = car.derivatives(all_rates(), known, std::array{1.0});
    const double small = vehicle::kStates[k].small;
    expect_alike(exact,
                 differences(
                     [&](double change) {
                       fmu::SavedState moved = here;
                       moved.simulation.state[k] += change;
                       Instance there(unit.resources(), unit.token());
                       there.restore(moved);
                       return read(there, all_rates());
                     },
                     small),
                 rates, small);
  }
}

TEST(Derivatives, OfRatesAfterInputsAreThoseOfDifferences) {
  const Unit unit(fmu::Version::kFmi2, false);
  Instance car(unit.resources(), unit.token());
  // Without dead times and lags what is asked for acts at once.
  for (const char* term : {"term.steering_actuator", "term.throttle_actuator",
                           "term.brake_actuator", "term.steering_friction", "term.brake_friction",
                           "term.throttle_friction", "term.steering_backlash"})
    set(car, term, 0.0);
  drive(car);
  set(car, "input.clutch", 0.4);
  for (const char* brake : {"input.brake.fl", "input.brake.fr", "input.brake.rl", "input.brake.rr"})
    set(car, brake, 2e5);
  const auto set_flag = [&](const char* name, double value) {
    car.set_number(reference_of(name), Type::kBoolean, value);
  };
  const double x_m = car.number(reference_of("car.x"), Type::kReal),
               y_m = car.number(reference_of("car.y"), Type::kReal);
  set_flag("input.opponent[1].active", 1.0);  // far behind: not the one that counts
  set(car, "input.opponent[1].x", x_m - 500.0);
  set_flag("input.opponent[3].active", 1.0);
  const double yaw_rad = car.number(reference_of("car.yaw"), Type::kReal);
  set(car, "input.opponent[3].x", x_m + 12.0 * std::cos(yaw_rad) - 0.7 * std::sin(yaw_rad));
  set(car, "input.opponent[3].y", y_m + 12.0 * std::sin(yaw_rad) + 0.7 * std::cos(yaw_rad));
  std::size_t acts = 0;
  const auto look = [&](const std::string& name, double small) {
    SCOPED_TRACE("after " + name);
    const std::uint32_t reference = reference_of(name);
    const double is = car.number(reference, Type::kReal);
    const std::vector<double> rates = read(car, all_rates());
    const std::vector<double> exact =
        car.derivatives(all_rates(), std::array{reference}, std::array{1.0});
    expect_alike(exact,
                 differences(
                     [&](double change) {
                       set(car, name, is + change);
                       const std::vector<double> out = read(car, all_rates());
                       set(car, name, is);
                       return out;
                     },
                     small),
                 rates, small);
    for (const double x : exact) acts += x != 0.0 ? 1 : 0;
  };
  for (const auto& [name, small] : {std::pair{"input.steering", 1e-6},
                                    {"input.throttle", 1e-6},
                                    {"input.clutch", 1e-6},
                                    {"input.brake.fl", 1.0},
                                    {"input.brake.rr", 1.0},
                                    {"input.opponent[3].x", 1e-4},
                                    {"input.opponent[3].y", 1e-4},
                                    {"input.opponent[1].x", 1e-4}})
    look(name, small);
  EXPECT_GT(acts, 60u);
  // The wake is felt at another place when the car moves or turns, too.
  const fmu::SavedState here = car.save();
  for (const std::size_t k : {vehicle::kX, vehicle::kY, vehicle::kYaw}) {
    const std::array known{static_cast<std::uint32_t>(reference_of("state.x") + k)};
    const std::vector<double> exact = car.derivatives(all_rates(), known, std::array{1.0});
    const std::vector<double> rates = read(car, all_rates());
    expect_alike(exact,
                 differences(
                     [&](double change) {
                       fmu::SavedState moved = here;
                       moved.simulation.state[k] += change;
                       Instance there(unit.resources(), unit.token());
                       there.restore(moved);
                       return read(there, all_rates());
                     },
                     1e-5),
                 rates, 1e-5);
    EXPECT_NE(exact[vehicle::kVx], 0.0) << "grip and engine do not ask where it is; the wake does";
  }
  set_flag("input.wake.active", 1.0);
  set(car, "input.wake.x", 10.0);
  set(car, "input.wake.y", 0.5);
  look("input.wake.x", 1e-4);
  look("input.wake.y", 1e-4);
  look("input.opponent[3].x", 1e-4);  // not looked at now
}

// An output is a state, the place along the road, or of the last step.
TEST(Derivatives, OfOutputsAreThoseOfTheStatesBehindThem) {
  const Unit unit;
  Instance car(unit.resources(), unit.token());
  drive(car);
  std::vector<std::uint32_t> outputs;
  std::size_t states = 0;
  for (const fmu::Variable& v : fmu::variables())
    for (std::size_t i = 0; i < v.size; ++i) {
      if (v.causality != fmu::Causality::kOutput || v.type != Type::kReal) continue;
      const auto reference = static_cast<std::uint32_t>(v.reference + i);
      outputs.push_back(reference);
      const std::vector<std::size_t> behind = fmu::states_behind(v, i);
      if (behind.size() != 1) continue;
      ++states;
      EXPECT_EQ(
          car.number(reference, Type::kReal),
          car.number(static_cast<std::uint32_t>(reference_of("state.x") + behind[0]), Type::kReal))
          << fmu::value_name(v, i);
    }
  EXPECT_EQ(states, 29u);
  const std::array knowns{reference_of("state.vx"), reference_of("input.throttle"),
                          reference_of("state.wheel.fl.spin")};
  const std::vector<double> along = car.derivatives(outputs, knowns, std::array{3.0, 5.0, 7.0});
  for (std::size_t k = 0; k < outputs.size(); ++k)
    EXPECT_EQ(along[k], outputs[k] == reference_of("car.vx")          ? 3.0
                        : outputs[k] == reference_of("wheel.fl.spin") ? 7.0
                                                                      : 0.0)
        << outputs[k];
}

TEST(Derivatives, OfThePlaceAlongTheRoadAreThoseOfItsLine) {
  const Unit unit;
  Instance car(unit.resources(), unit.token());
  drive(car, 2000);
  const crg::Surface road(crg::read(unit.folder().path("circle.crg")));
  const double x_m = car.number(reference_of("car.x"), Type::kReal),
               y_m = car.number(reference_of("car.y"), Type::kReal);
  vehicle::RoadTracker tracker(road);
  constexpr double kSmall_m = 0.01;  // well within a segment of the line
  for (const double turned_rad : {0.0, 1.0, 2.0}) {
    const double dx = std::cos(turned_rad), dy = std::sin(turned_rad);
    const crg::UV ahead = tracker.at(x_m + kSmall_m * dx, y_m + kSmall_m * dy),
                  behind = tracker.at(x_m - kSmall_m * dx, y_m - kSmall_m * dy);
    const std::vector<double> exact = car.derivatives(
        std::array{reference_of("car.u"), reference_of("car.v")},
        std::array{reference_of("state.x"), reference_of("state.y")}, std::array{dx, dy});
    // The line is made of segments of 0.5 m on a circle of 60 m: headings to 0.004.
    EXPECT_NEAR(exact[0], (ahead.u_m - behind.u_m) / (2.0 * kSmall_m), 0.005);
    EXPECT_NEAR(exact[1], (ahead.v_m - behind.v_m) / (2.0 * kSmall_m), 0.005);
  }
  EXPECT_GT(std::abs(car.number(reference_of("car.v"), Type::kReal)), 0.01);
}

TEST(Derivatives, DirectionsAddUpAndArraysAreTakenWhole) {
  const Unit unit(fmu::Version::kFmi3);
  Instance car(unit.resources(), unit.token());
  drive(car);
  const auto spins = references("state.wheel.fl.spin", 4);
  const std::vector<double> seed{1.0, -2.0, 0.5, 3.0};
  const std::vector<double> together = car.derivatives(all_rates(), spins, seed);
  std::vector<double> sum(together.size(), 0.0);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::vector<double> one =
        car.derivatives(all_rates(), std::array{spins[i]}, std::array{seed[i]});
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += one[k];
  }
  for (std::size_t k = 0; k < sum.size(); ++k)
    EXPECT_NEAR(together[k], sum[k], 1e-9 * (1.0 + std::abs(sum[k]))) << vehicle::state_name(k);
}

TEST(Derivatives, RefuseWhatTheyAreNotOf) {
  const Unit unit;
  Instance car(unit.resources(), unit.token());
  const auto refusal = [&](const char* unknown, const char* known, double seed = 1.0) {
    try {
      car.derivatives(std::array{reference_of(unknown)}, std::array{reference_of(known)},
                      std::array{seed});
    } catch (const base::Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(refusal("car.vx", "state.vx"), HasSubstr("after the initialisation"));
  drive(car, 10);
  EXPECT_EQ(refusal("car.vx", "state.vx"), "");
  EXPECT_THAT(refusal("state.vx", "state.vx"), HasSubstr("of state.vx, wanted a real output"));
  EXPECT_THAT(refusal("car.gear", "state.vx"), HasSubstr("of car.gear"));
  EXPECT_THAT(refusal("car.vx", "input.gear"), HasSubstr("after input.gear, wanted a real input"));
  EXPECT_THAT(refusal("car.vx", "parameter.chassis.mass_kg"), HasSubstr("after parameter.chassis"));
  EXPECT_THAT(refusal("car.vx", "state.vx", std::nan("")), HasSubstr("no number"));
  EXPECT_THAT(refusal("car.vx", "der(state.vx)"), HasSubstr("after der(state.vx)"));
}

// Through the functions of the standard, as an importer linearises.
TEST(Derivatives, AreThereByBothVersionsOfTheStandard) {
  const Unit unit;
  fmu_tests::Fmi2 car(unit);
  ASSERT_EQ(car.set("start.speed", 10.0), 0);
  ASSERT_EQ(car.initialise(), 0);
  car.drive(0, 200);
  const std::array unknowns{reference_of("der(state.vx)"), reference_of("car.vx")};
  const std::array knowns{reference_of("state.vx"), reference_of("input.clutch")};
  const std::array seed{2.0, 0.0};
  std::array<double, 2> out{};
  const auto ask = [&](const unsigned* unknown, const double* along) {
    return car.call("fmi2GetDirectionalDerivative", unknown, std::size_t{2}, knowns.data(),
                    std::size_t{2}, along, out.data());
  };
  ASSERT_EQ(ask(unknowns.data(), seed.data()), 0) << ::testing::PrintToString(car.log);
  EXPECT_EQ(out[1], 2.0);
  Instance own(unit.resources(), unit.token());
  own.restore(fmu::from_bytes(car.serialised(), unit.token(), own.list()));
  EXPECT_EQ(out[0], own.derivatives(unknowns, knowns, seed)[0]);
  EXPECT_LT(out[0], 0.0) << "faster: more drag";
  EXPECT_EQ(ask(nullptr, seed.data()), 3);
  EXPECT_EQ(ask(unknowns.data(), nullptr), 3);
}

}  // namespace derivatives_test
