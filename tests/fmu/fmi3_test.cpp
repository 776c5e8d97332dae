// The functions of FMI 3.0, through the shared object of an exported unit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "shared_object.h"

namespace fmi3_test {

using fmu_tests::DrivenCar, fmu_tests::SharedObject, fmu_tests::Unit;
using ::testing::HasSubstr;
constexpr int kOk = 0, kError = 3;

std::uint32_t array_reference(const std::string& name) {
  for (const fmu::Variable& v : fmu::variables())
    if (fmu::array_name(v) == name) return v.reference;
  ADD_FAILURE() << name;
  return 0;
}

class Fmi3 {
 public:
  explicit Fmi3(const Unit& unit)
      : library_(unit.folder().path("unit/binaries/x86_64-linux/kerbstone_car.so")) {
    fmi3LogMessageCallback logger = [](void* environment, int status, const char*,
                                       const char* message) {
      static_cast<Fmi3*>(environment)->log.push_back(std::to_string(status) + " " + message);
    };
    const std::string resources = unit.resources() + "/";
    component = library_.call<void*>("fmi3InstantiateCoSimulation", static_cast<const char*>("car"),
                                     unit.token().c_str(), resources.c_str(), false, false, false,
                                     false, static_cast<const std::uint32_t*>(nullptr),
                                     std::size_t{0}, static_cast<void*>(this), logger,
                                     static_cast<fmi3IntermediateUpdateCallback>(nullptr));
  }
  Fmi3(const Fmi3&) = delete;
  Fmi3& operator=(const Fmi3&) = delete;
  ~Fmi3() { library_.call<void>("fmi3FreeInstance", component); }

  template <class... Arguments>
  int call(const char* name, Arguments... arguments) const {
    return library_.call(name, component, arguments...);
  }
  int set(const std::string& name, const std::vector<double>& values) const {
    const std::uint32_t reference = array_reference(name);
    return call("fmi3SetFloat64", &reference, std::size_t{1}, values.data(), values.size());
  }
  std::vector<double> get(const std::string& name, std::size_t count) const {
    const std::uint32_t reference = array_reference(name);
    std::vector<double> values(count);
    EXPECT_EQ(call("fmi3GetFloat64", &reference, std::size_t{1}, values.data(), count), kOk);
    return values;
  }
  int step(double time_s) {
    return call("fmi3DoStep", time_s, 0.001, true, &event, &terminate, &early, &reached_s);
  }

  void* component = nullptr;
  std::vector<std::string> log;
  bool event = true, terminate = true, early = true;
  double reached_s = -1.0;

 private:
  SharedObject library_;
};

TEST(Fmi3, WheelsAreArraysAndTheCarIsTheLibrarys) {
  const Unit unit(fmu::Version::kFmi3);
  Fmi3 car(unit);
  ASSERT_NE(car.component, nullptr);
  ASSERT_EQ(car.set("start.speed", {10.0}), kOk);
  ASSERT_EQ(car.call("fmi3EnterInitializationMode", false, 0.0, 100.0, false, 0.0), kOk);
  ASSERT_EQ(car.call("fmi3ExitInitializationMode"), kOk);
  EXPECT_EQ(car.get("time", 1)[0], 100.0);
  DrivenCar own(unit.folder().path("circle.crg"));
  for (int i = 0; i < 2000; ++i) {
    const auto asked =
        fmu_tests::asked_of(0.001 * i, own.row()[1], own.row()[2], own.row()[8], own.row()[9]);
    ASSERT_EQ(car.set("input.steering", {asked.steer_command_rad}), kOk);
    ASSERT_EQ(car.set("input.throttle", {asked.throttle_command}), kOk);
    ASSERT_EQ(
        car.set("input.brake", {asked.brake_command_pa.begin(), asked.brake_command_pa.end()}),
        kOk);
    ASSERT_EQ(car.set("input.clutch", {asked.clutch_command}), kOk);
    ASSERT_EQ(car.step(100.0 + 0.001 * i), kOk);
    own.step(asked);
  }
  EXPECT_FALSE(car.event || car.terminate || car.early);
  EXPECT_NEAR(car.reached_s, 102.0, 1e-9);
  const std::vector<double> fz = car.get("wheel.fz", 4), travel = car.get("state.wheel.travel", 4);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(fz[i], own.detail().wheel[i].fz_n);
    EXPECT_EQ(travel[i], own.state()[vehicle::kTravel + i]);
  }
  EXPECT_EQ(car.get("car.v", 1)[0], own.row()[2]);
  std::int32_t gear = 0;
  std::uint32_t reference = array_reference("car.gear");
  EXPECT_EQ(car.call("fmi3GetInt32", &reference, std::size_t{1}, &gear, std::size_t{1}), kOk);
  EXPECT_EQ(gear, 1);
  bool on_road[4]{};
  reference = array_reference("wheel.on_road");
  EXPECT_EQ(car.call("fmi3GetBoolean", &reference, std::size_t{1}, &on_road[0], std::size_t{4}),
            kOk);
  EXPECT_TRUE(on_road[0] && on_road[1] && on_road[2] && on_road[3]);
}

TEST(Fmi3, LiesAreErrorsWithALineInTheLog) {
  const Unit unit(fmu::Version::kFmi3);
  const Fmi3 car(unit);
  EXPECT_EQ(car.set("input.brake", {1.0, 2.0, 3.0}), kError);
  EXPECT_THAT(car.log.back(), HasSubstr("fewer values than the variables have"));
  EXPECT_EQ(car.set("input.brake", {1, 2, 3, 4, 5}), kError);
  EXPECT_THAT(car.log.back(), HasSubstr("more values than the variables have"));
  const std::uint32_t inside = array_reference("input.brake") + 1;
  double value = 0.0;
  EXPECT_EQ(car.call("fmi3GetFloat64", &inside, std::size_t{1}, &value, std::size_t{1}), kError);
  EXPECT_THAT(car.log.back(), HasSubstr("within an array"));
  EXPECT_EQ(car.set("input.clutch", {std::nan("")}), kError);
  EXPECT_EQ(car.call("fmi3EnterEventMode"), kError);
  EXPECT_THAT(car.log.back(), HasSubstr("fmi3EnterEventMode: this unit does not provide it"));
  EXPECT_EQ(car.call("fmi3EnterStepMode"), kError);
}

// An importer may look for any function of the standard before it begins.
TEST(Fmi3, EveryFunctionOfTheStandardsIsThere) {
  const SharedObject library(places::kerbstone_car());
  for (const char* name : {"GetVersion",
                           "SetDebugLogging",
                           "InstantiateModelExchange",
                           "InstantiateCoSimulation",
                           "InstantiateScheduledExecution",
                           "FreeInstance",
                           "EnterInitializationMode",
                           "ExitInitializationMode",
                           "EnterEventMode",
                           "Terminate",
                           "Reset",
                           "GetFloat32",
                           "GetFloat64",
                           "GetInt8",
                           "GetUInt8",
                           "GetInt16",
                           "GetUInt16",
                           "GetInt32",
                           "GetUInt32",
                           "GetInt64",
                           "GetUInt64",
                           "GetBoolean",
                           "GetString",
                           "GetBinary",
                           "GetClock",
                           "SetFloat32",
                           "SetFloat64",
                           "SetInt8",
                           "SetUInt8",
                           "SetInt16",
                           "SetUInt16",
                           "SetInt32",
                           "SetUInt32",
                           "SetInt64",
                           "SetUInt64",
                           "SetBoolean",
                           "SetString",
                           "SetBinary",
                           "SetClock",
                           "GetNumberOfVariableDependencies",
                           "GetVariableDependencies",
                           "GetFMUState",
                           "SetFMUState",
                           "FreeFMUState",
                           "SerializedFMUStateSize",
                           "SerializeFMUState",
                           "DeserializeFMUState",
                           "GetDirectionalDerivative",
                           "GetAdjointDerivative",
                           "EnterConfigurationMode",
                           "ExitConfigurationMode",
                           "GetIntervalDecimal",
                           "GetIntervalFraction",
                           "GetShiftDecimal",
                           "GetShiftFraction",
                           "SetIntervalDecimal",
                           "SetIntervalFraction",
                           "SetShiftDecimal",
                           "SetShiftFraction",
                           "EvaluateDiscreteStates",
                           "UpdateDiscreteStates",
                           "EnterContinuousTimeMode",
                           "CompletedIntegratorStep",
                           "SetTime",
                           "SetContinuousStates",
                           "GetContinuousStateDerivatives",
                           "GetEventIndicators",
                           "GetContinuousStates",
                           "GetNominalsOfContinuousStates",
                           "GetNumberOfEventIndicators",
                           "GetNumberOfContinuousStates",
                           "EnterStepMode",
                           "GetOutputDerivatives",
                           "DoStep",
                           "ActivateModelPartition"})
    EXPECT_NE(library.find<void*>((std::string("fmi3") + name).c_str()), nullptr) << name;
  for (const char* name : {"GetTypesPlatform",
                           "GetVersion",
                           "SetDebugLogging",
                           "Instantiate",
                           "FreeInstance",
                           "SetupExperiment",
                           "EnterInitializationMode",
                           "ExitInitializationMode",
                           "Terminate",
                           "Reset",
                           "GetReal",
                           "GetInteger",
                           "GetBoolean",
                           "GetString",
                           "SetReal",
                           "SetInteger",
                           "SetBoolean",
                           "SetString",
                           "GetFMUstate",
                           "SetFMUstate",
                           "FreeFMUstate",
                           "SerializedFMUstateSize",
                           "SerializeFMUstate",
                           "DeSerializeFMUstate",
                           "GetDirectionalDerivative",
                           "SetRealInputDerivatives",
                           "GetRealOutputDerivatives",
                           "DoStep",
                           "CancelStep",
                           "GetStatus",
                           "GetRealStatus",
                           "GetIntegerStatus",
                           "GetBooleanStatus",
                           "GetStringStatus"}) {
    const std::string full = std::string("fmi2") + name;
    EXPECT_NE(library.find<void*>(full.c_str()), nullptr) << full;
  }
}

// Whole by itself: on another machine there is libc, and nothing else for sure.
TEST(Fmi3, TheSharedObjectNeedsLibcAloneAndIsSmall) {
  std::ifstream file(places::kerbstone_car(), std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  if (bytes.find("__asan_init") != std::string::npos ||
      bytes.find("__tsan_init") != std::string::npos)
    GTEST_SKIP() << "sanitized";
  EXPECT_LE(bytes.size(), 5000000u);
  for (const char* library :
       {"libstdc++.so", "libgcc_s.so", "libfmt.so", "libyaml-cpp.so", "libz.so", "libcrypto.so"})
    EXPECT_EQ(bytes.find(std::string(1, '\0') + library), std::string::npos) << library;
}

}  // namespace fmi3_test
