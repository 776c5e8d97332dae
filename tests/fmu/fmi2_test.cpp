// The functions of FMI 2.0, through the shared object of an exported unit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <thread>

#include "shared_object.h"
#include "support/figure.h"

namespace fmi2_test {

using fmu_tests::asked_of, fmu_tests::DrivenCar, fmu_tests::Fmi2, fmu_tests::Unit;
using ::testing::ElementsAre, ::testing::HasSubstr, ::testing::IsEmpty;
constexpr int kOk = 0, kWarning = 1, kError = 3;

void begin(const Fmi2& car) {
  ASSERT_NE(car.component, nullptr);
  ASSERT_EQ(car.set("start.speed", 10.0), kOk);
  ASSERT_EQ(car.initialise(), kOk);
}

// Every output against the library's own calls, every millisecond for a minute.
TEST(Fmi2, IsTheLibrarysCar) {
  const Unit unit;
  Fmi2 car(unit);
  begin(car);
  DrivenCar own(unit.folder().path("circle.crg"));
  double largest = 0.0;
  const auto look = [&](double seen, double wanted) {
    largest = std::max(largest, std::abs(seen - wanted));
  };
  const std::size_t channels = own.row().size();
  std::vector<unsigned> references(channels);
  std::vector<double> row(channels);
  const unsigned gear = fmu_tests::reference_of("car.gear");
  for (unsigned i = 0; i < channels; ++i) references[i] = i == gear ? 0 : i;
  for (int i = 0; i < 60000; ++i) {
    const auto asked = asked_of(0.001 * i, own.row()[1], own.row()[2], own.row()[8], own.row()[9]);
    car.ask(asked);
    ASSERT_EQ(car.step(0.001 * i), kOk) << ::testing::PrintToString(car.log);
    own.step(asked);
    ASSERT_EQ(car.call("fmi2GetReal", static_cast<const unsigned*>(references.data()), channels,
                       row.data()),
              kOk);
    for (std::size_t k = 0; k < channels; ++k)
      if (k != gear) look(row[k], own.row()[k]);
  }
  for (std::size_t k = 0; k < vehicle::kStateSize; ++k) {
    const unsigned reference = fmu_tests::reference_of("state.x") + static_cast<unsigned>(k);
    double value = 0.0;
    ASSERT_EQ(car.call("fmi2GetReal", &reference, std::size_t{1}, &value), kOk);
    look(value, own.state()[k]);
  }
  EXPECT_EQ(car.get("wheel.rl.fx"), own.detail().wheel[2].fx_n);
  EXPECT_EQ(car.get("wheel.fr.road_v"), own.detail().wheel[1].road.v_m);
  EXPECT_EQ(car.get("car.drag"), own.detail().drag_n);
  support::figure("largest_difference", largest);
  EXPECT_EQ(largest, 0.0);  // bound: 1e-12; the same instructions give the same bits
  EXPECT_THAT(car.log, IsEmpty());
  // It went somewhere: more than a lap of 377 m, on the road, and was shifted.
  EXPECT_GT(60.0 * own.row()[9], 377.0);
  EXPECT_LT(std::abs(own.row()[2]), 6.0);
}

TEST(Fmi2, LongerStepsAreTheSameSolverSteps) {
  const Unit unit;
  Fmi2 fine(unit), coarse(unit);
  for (const Fmi2* car : {&fine, &coarse}) {
    begin(*car);
    ASSERT_EQ(car->set("input.steering", 0.05), kOk);
    ASSERT_EQ(car->set("input.throttle", 0.2), kOk);
  }
  for (int i = 0; i < 100; ++i) ASSERT_EQ(fine.step(0.001 * i), kOk);
  // 0.1 is no sum of binary fractions; importers do such sums.
  ASSERT_EQ(coarse.step(0.0, 0.1 + 1e-15), kOk);
  EXPECT_TRUE(fine.serialised() == coarse.serialised());
  EXPECT_EQ(coarse.step(0.1, 0.0), kError);
  EXPECT_EQ(coarse.step(0.1, -0.001), kError);
  EXPECT_EQ(coarse.step(0.1, std::nan("")), kError);
  EXPECT_EQ(coarse.step(0.1, 1e9), kError);
  EXPECT_EQ(coarse.step(0.05, 0.001), kError);
  // More than half a solver step of 1 ms away.
  EXPECT_EQ(coarse.step(0.0994, 0.001), kError);
  EXPECT_EQ(coarse.step(0.1006, 0.001), kError);
  EXPECT_EQ(coarse.step(std::nan(""), 0.001), kError);
  EXPECT_THAT(coarse.log[0], HasSubstr("a step of 0 s was asked for, wanted 1e-06 to 3600 s"));
  EXPECT_THAT(coarse.log[4], HasSubstr("from t = 0.05 s was asked for, but the car is at 0.1 s"));
  EXPECT_EQ(coarse.step(0.1), kOk);  // none of these did anything
}

TEST(Fmi2, AnyStepIsTaken) {
  const Unit unit;
  Fmi2 fine(unit), odd(unit);
  for (Fmi2* const car : {&fine, &odd}) {
    ASSERT_EQ(car->set("start.speed", 20.0), kOk);
    begin(*car);
    ASSERT_EQ(car->set("input.throttle", 0.3), kOk);
  }
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(fine.step(0.001 * i), kOk);
  double time_s = 0.0;
  for (int i = 0; i < 60; ++i, time_s += 1.0 / 60.0) ASSERT_EQ(odd.step(time_s, 1.0 / 60.0), kOk);
  EXPECT_NEAR(odd.get("time"), 1.0, 1e-9);
  EXPECT_NEAR(odd.get("car.vx"), fine.get("car.vx"), 1e-3);
  EXPECT_NEAR(odd.get("car.u"), fine.get("car.u"), 1e-3);
  for (const double step_s : {0.0012, 0.0004, 0.001, 0.0107}) {
    ASSERT_EQ(odd.step(time_s, step_s), kOk) << odd.log.back();
    time_s += step_s;
    EXPECT_NEAR(odd.get("time"), time_s, 1e-9);
  }
}

TEST(Fmi2, AnImportersClockMayRunAway) {
  const Unit unit;
  Fmi2 car(unit);
  begin(car);
  // In float the sum of 0.001 s is 0.1 s off after 100 s.
  float time_s = 0.0f;
  for (int i = 0; i < 20'000; ++i, time_s += 0.001f)
    ASSERT_EQ(car.step(time_s, 0.001), kOk) << i << ": " << car.log.back();
  EXPECT_NEAR(car.get("time"), static_cast<double>(time_s), 0.001);
}

TEST(Fmi2, TwoInstancesInterleavedAndInThreadsAreEachAlone) {
  const Unit unit;
  const auto alone = [&] {
    Fmi2 car(unit);
    begin(car);
    car.drive(0, 1500);
    return car.serialised();
  };
  const std::string wanted = alone();
  Fmi2 one(unit), other(unit);
  begin(one);
  begin(other);
  for (int i = 0; i < 1500; i += 10) {
    one.drive(i, i + 10);
    ASSERT_EQ(other.set("input.steering", 0.02), kOk);
    ASSERT_EQ(other.step(0.001 * i, 0.01), kOk);
  }
  EXPECT_TRUE(one.serialised() == wanted);
  EXPECT_FALSE(other.serialised() == wanted);
  std::array<std::string, 4> found;
  std::vector<std::thread> threads;
  threads.reserve(found.size());
  for (std::string& bytes : found) threads.emplace_back([&] { bytes = alone(); });
  for (std::thread& thread : threads) thread.join();
  for (const std::string& bytes : found) EXPECT_TRUE(bytes == wanted);
}

TEST(Fmi2, GoesOnFromSavedBytesAsIfNothingHadBeen) {
  const Unit unit;
  const auto drive_to_the_end = [&] {
    Fmi2 car(unit);
    begin(car);
    car.drive(0, 700);
    ASSERT_EQ(car.set("parameter.environment.wind_mps", 7.0), kOk);
    unit.folder().file("middle", car.serialised());
    car.drive(700, 1400);
    const std::string end = car.serialised();
    // Back within the same instance, too.
    ASSERT_EQ(car.restore(unit.folder().read("middle")), kOk);
    car.drive(700, 1400);
    EXPECT_TRUE(car.serialised() == end);
    unit.folder().file("end", end);
  };
  // In a process of its own, which ends.
  const pid_t child = ::fork();
  if (child == 0) {
    drive_to_the_end();
    ::_exit(::testing::Test::HasFailure() ? 1 : 0);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_EQ(status, 0);
  const std::string middle = unit.folder().read("middle");
  Fmi2 again(unit);  // not even initialised
  ASSERT_EQ(again.restore(middle), kOk) << ::testing::PrintToString(again.log);
  EXPECT_TRUE(again.serialised() == middle);
  EXPECT_EQ(again.get("parameter.environment.wind_mps"), 7.0);
  again.drive(700, 1400);
  EXPECT_TRUE(again.serialised() == unit.folder().read("end"));
}

TEST(Fmi2, StateHandlesAreChecked) {
  const Unit unit;
  Fmi2 car(unit);
  begin(car);
  int stranger = 0;
  void* handle = &stranger;
  EXPECT_EQ(car.call("fmi2SetFMUstate", handle), kError);
  EXPECT_EQ(car.call("fmi2FreeFMUstate", &handle), kError);
  EXPECT_EQ(car.call("fmi2GetFMUstate", &handle), kError);
  void* const none = nullptr;
  EXPECT_EQ(car.call("fmi2SetFMUstate", none), kError);
  const std::string bytes = car.serialised();
  EXPECT_EQ(car.restore(bytes.substr(0, bytes.size() - 1)), kError);
  EXPECT_EQ(car.restore("x"), kError);
  handle = nullptr;
  ASSERT_EQ(car.call("fmi2GetFMUstate", &handle), kOk);
  std::string small(10, '\0');
  EXPECT_EQ(car.call("fmi2SerializeFMUstate", handle, small.data(), small.size()), kError);
  EXPECT_EQ(car.call("fmi2GetFMUstate", &handle), kOk);  // written over
  EXPECT_EQ(car.call("fmi2FreeFMUstate", &handle), kOk);
}

TEST(Fmi2, LiesAreErrorsWithALineInTheLog) {
  const Unit unit;
  Fmi2 car(unit);
  begin(car);
  unsigned reference = 1000000;
  double number = 1.0;
  int whole = 0;
  const char* text = nullptr;
  EXPECT_EQ(car.call("fmi2GetReal", &reference, std::size_t{1}, &number), kError);
  EXPECT_THAT(car.log.back(), HasSubstr("3 there is no value reference 1000000"));
  EXPECT_EQ(car.call("fmi2GetString", &reference, std::size_t{1}, &text), kError);
  reference = fmu_tests::reference_of("input.gear");
  EXPECT_EQ(car.call("fmi2GetReal", &reference, std::size_t{1}, &number), kError);
  EXPECT_THAT(car.log.back(), HasSubstr("input.gear is a whole number, but a real number"));
  EXPECT_EQ(car.call("fmi2GetReal", static_cast<unsigned*>(nullptr), std::size_t{1}, &number),
            kError);
  EXPECT_EQ(car.set("input.steering", std::nan("")), kError);
  EXPECT_THAT(car.log.back(), HasSubstr("input.steering = nan, wanted a number"));
  EXPECT_EQ(car.set("input.throttle", INFINITY), kError);
  EXPECT_EQ(car.set("input.throttle", 1.5), kWarning);
  EXPECT_THAT(car.log.back(), HasSubstr("1 input.throttle = 1.5, wanted 0 to 1; 1 is taken"));
  EXPECT_EQ(car.get("input.throttle"), 1.0);
  EXPECT_EQ(car.set_whole("input.gear", 11), kError);
  EXPECT_EQ(car.set_whole("input.wake.active", 2, "fmi2SetBoolean"), kError);
  EXPECT_EQ(car.set("parameter.chassis.mass_kg", -1), kError);
  EXPECT_EQ(car.set("wheel.fl.fz", 1), kError);
  EXPECT_THAT(car.log.back(), HasSubstr("cannot be set"));
  EXPECT_EQ(car.set("start.u", 1), kError);
  EXPECT_EQ(car.set_text("road", ""), kError);
  EXPECT_THAT(car.log.back(), HasSubstr("road cannot be set after initialisation"));
  EXPECT_EQ(car.call("fmi2EnterInitializationMode"), kError);
  EXPECT_EQ(car.call("fmi2CancelStep"), kError);
  EXPECT_EQ(car.call("fmi2GetStringStatus", 0, &text), kError);
  EXPECT_EQ(car.call("fmi2GetRealStatus", 2, &number), kOk);
  EXPECT_EQ(number, 0.0);
  EXPECT_EQ(car.call("fmi2GetIntegerStatus", 0, &whole), kError);
  EXPECT_EQ(car.step(0.0), kOk);
  EXPECT_EQ(car.call("fmi2Terminate"), kOk);
  EXPECT_EQ(car.step(0.001), kError);
  EXPECT_EQ(car.call("fmi2Reset"), kOk);
  begin(car);
  EXPECT_EQ(car.step(0.0), kOk);
  for (const std::string& line : car.log) EXPECT_EQ(line.find('\n'), std::string::npos);
}

TEST(Fmi2, AWrongTokenMissingResourcesAndNullsMakeNoInstance) {
  const Unit unit;
  const Fmi2 wrong(unit, "{nonsense 100%}");
  EXPECT_EQ(wrong.component, nullptr);
  ASSERT_EQ(wrong.log.size(), 1u);
  EXPECT_THAT(wrong.log[0], HasSubstr("3 asked for the unit {nonsense 100%%}"));  // for printf
  EXPECT_EQ(wrong.step(0.0), kError);  // of no instance at all
  const std::string file = unit.resources() + "/car/front.tir";
  std::filesystem::rename(file, file + "_");
  const Fmi2 missing(unit);
  EXPECT_EQ(missing.component, nullptr);
  ASSERT_EQ(missing.log.size(), 1u);
  EXPECT_THAT(missing.log[0], HasSubstr("front.tir"));
  std::filesystem::remove_all(unit.resources());
  const Fmi2 none(unit);
  EXPECT_EQ(none.component, nullptr);
  ASSERT_EQ(none.log.size(), 1u);
  EXPECT_THAT(none.log[0], HasSubstr("unit.txt"));
}

TEST(Fmi2, AnotherRoadSetupOrCarIsTakenWithoutExportingAgain) {
  const Unit unit(fmu::Version::kFmi2, false);
  Fmi2 car(unit);
  EXPECT_EQ(car.get("start.u"), 0.0);
  ASSERT_EQ(car.set_text("road", unit.folder().path("circle.crg")), kOk);
  ASSERT_EQ(car.set_text("setup", unit.folder().file("stiff.txt", "front.spring_npm = 250000\n")),
            kOk);
  ASSERT_EQ(car.set("start.u", 94.2), kOk);
  begin(car);
  EXPECT_EQ(car.get("parameter.front.spring_npm"), 250000);
  EXPECT_NEAR(car.get("car.u"), 94.2, 0.1);
  EXPECT_NEAR(car.get("car.yaw"), 94.2 / 60.0, 0.02);
  // What was given by number is not what the files say.
  ASSERT_EQ(car.call("fmi2Reset"), kOk);
  ASSERT_EQ(car.set("parameter.front.spring_npm", 123456), kOk);
  ASSERT_EQ(car.set_text("vehicle", places::source() + "/vehicles/av21/vehicle.yaml"), kOk);
  begin(car);
  EXPECT_EQ(car.get("parameter.front.spring_npm"), 123456);
  const double mass = vehicle::read_vehicle(places::source() + "/vehicles/av21/vehicle.yaml")
                          .parameters[vehicle::Parameter::chassis_mass_kg];
  EXPECT_EQ(car.get("parameter.chassis.mass_kg"), mass);
  EXPECT_NE(mass, 720.0);
  // So it is with one that is that of the exported car, but not with all of them, which some
  // importers set by themselves.
  for (const bool all : {false, true}) {
    ASSERT_EQ(car.call("fmi2Reset"), kOk);
    for (const fmu::Variable& v : fmu::variables()) {
      const bool is_own = v.source == fmu::Source::kParameter || v.source == fmu::Source::kTerm;
      if (is_own && (all || v.name == "parameter.chassis.mass_kg")) {
        ASSERT_EQ(car.set(v.name, car.get(v.name)), kOk) << v.name;
      }
    }
    const double exported = car.get("parameter.chassis.mass_kg");
    ASSERT_EQ(car.set_text("vehicle", places::source() + "/vehicles/av21/vehicle.yaml"), kOk);
    begin(car);
    EXPECT_EQ(car.get("parameter.chassis.mass_kg"), all ? mass : exported);
    EXPECT_NE(mass, exported);
  }
  // Files that are not there are said at the end of initialisation, and can be put right.
  ASSERT_EQ(car.call("fmi2Reset"), kOk);
  ASSERT_EQ(car.set_text("road", "nowhere.crg"), kOk);
  EXPECT_EQ(car.initialise(), kError);
  EXPECT_THAT(car.log.back(), HasSubstr("nowhere.crg"));
  ASSERT_EQ(car.set_text("road", ""), kOk);
  EXPECT_EQ(car.call("fmi2ExitInitializationMode"), kOk);
  EXPECT_EQ(car.step(0.0), kOk);
}

TEST(Fmi2, WhatFailedAtTheBeginIsTriedAgain) {
  const Unit unit;
  Fmi2 car(unit);
  ASSERT_EQ(car.set("start.v", 50.0), kOk);
  EXPECT_EQ(car.initialise(), kError);
  EXPECT_THAT(car.log.back(), HasSubstr("no road at start.u = 0 m, start.v = 50 m"));
  EXPECT_EQ(car.call("fmi2ExitInitializationMode"), kError);
  EXPECT_EQ(car.step(0.0), kError);
  ASSERT_EQ(car.set("start.v", 1.0), kOk);
  EXPECT_EQ(car.call("fmi2ExitInitializationMode"), kOk);
  EXPECT_NEAR(car.get("car.v"), 1.0, 0.02);
  // A parameter that fits no car is refused by the step, and can be put right.
  EXPECT_EQ(car.set("parameter.chassis.mass_kg", 10.0), kOk);
  EXPECT_EQ(car.step(0.0), kError);
  EXPECT_THAT(car.log.back(), HasSubstr("chassis.mass_kg"));
  EXPECT_EQ(car.step(0.0), kError);
  EXPECT_EQ(car.set("parameter.chassis.mass_kg", 700.0), kOk);
  EXPECT_EQ(car.step(0.0), kOk);
}

TEST(Fmi2, ACarThatLeavesTheRoadIsAnErrorThatSaysWhere) {
  const Unit unit;
  Fmi2 car(unit);
  ASSERT_EQ(car.set("start.speed", 60.0), kOk);
  ASSERT_EQ(car.initialise(), kOk);
  ASSERT_EQ(car.set("parameter.environment.gravity_mps2", 0.0), kOk);
  ASSERT_EQ(car.set("term.aero_downforce", 0.0), kOk);
  int status = kOk;
  for (int i = 0; i < 60000 && status == kOk; ++i) status = car.step(0.001 * i);
  EXPECT_EQ(status, kError);
  ASSERT_FALSE(car.log.empty());
  EXPECT_THAT(car.log.back(), ::testing::AnyOf(HasSubstr("no road under"), HasSubstr("rolled")));
  EXPECT_EQ(car.step(60.0), kError);
  EXPECT_THAT(car.log.back(), HasSubstr("the run has ended with an error; reset the unit"));
  EXPECT_EQ(car.call("fmi2Reset"), kOk);
}

TEST(Fmi2, OpponentsAreSeenFromTheCar) {
  const Unit unit(fmu::Version::kFmi2, false);
  Fmi2 by_place(unit), by_wake(unit), alone(unit);
  for (const Fmi2* car : {&by_place, &by_wake, &alone}) {
    ASSERT_EQ(car->set("start.speed", 50.0), kOk);
    ASSERT_EQ(car->initialise(), kOk);
  }
  for (int i = 0; i < 50; ++i) {
    const double x = by_place.get("car.x"), y = by_place.get("car.y");
    ASSERT_EQ(by_place.set_whole("input.opponent[2].active", 1, "fmi2SetBoolean"), kOk);
    ASSERT_EQ(by_place.set("input.opponent[2].x", x + 10.0), kOk);
    ASSERT_EQ(by_place.set("input.opponent[2].y", y), kOk);
    ASSERT_EQ(by_wake.set_whole("input.wake.active", 1, "fmi2SetBoolean"), kOk);
    ASSERT_EQ(by_wake.set("input.wake.x", 10.0), kOk);
    for (const Fmi2* car : {&by_place, &by_wake, &alone}) ASSERT_EQ(car->step(0.001 * i), kOk);
  }
  EXPECT_NEAR(by_place.get("car.drag"), by_wake.get("car.drag"), 1e-3);
  EXPECT_LT(by_place.get("car.drag"), 0.95 * alone.get("car.drag"));
}

}  // namespace fmi2_test
