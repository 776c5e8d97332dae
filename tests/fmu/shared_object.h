// The functions of the shared object, as an importer finds them.
#pragma once

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "driven_car.h"
#include "fmi2_types.h"
#include "fmi3_types.h"
#include "unit_under_test.h"

namespace fmu_tests {

/// The binary in an unpacked unit, loaded.
class SharedObject {
 public:
  explicit SharedObject(const std::string& path) : handle_(::dlopen(path.c_str(), RTLD_NOW)) {
    EXPECT_NE(handle_, nullptr) << ::dlerror();
  }
  SharedObject(const SharedObject&) = delete;
  SharedObject& operator=(const SharedObject&) = delete;
  ~SharedObject() { ::dlclose(handle_); }

  /// Null where there is none.
  template <class Function>
  Function find(const char* name) const {
    return reinterpret_cast<Function>(::dlsym(handle_, name));
  }
  /// Calls the function with arguments of exactly the standard's types.
  template <class Result = int, class... Arguments>
  Result call(const char* name, Arguments... arguments) const {
    const auto function = find<Result (*)(Arguments...)>(name);
    EXPECT_NE(function, nullptr) << name;
    return function(arguments...);
  }

 private:
  void* handle_;
};

/// An instance by the functions of FMI 2.0, and what it logged.
class Fmi2 {
 public:
  explicit Fmi2(const Unit& unit, const std::string& token = "")
      : library_(unit.folder().path("unit/binaries/linux64/kerbstone_car.so")) {
    functions_.logger = &Fmi2::take_line;
    functions_.environment = this;
    const std::string resources = "file://" + unit.resources();
    component = library_.call<void*>("fmi2Instantiate", static_cast<const char*>("car"), 1,
                                     token.empty() ? unit.token().c_str() : token.c_str(),
                                     resources.c_str(),
                                     static_cast<const fmi2CallbackFunctions*>(&functions_), 0, 0);
  }
  Fmi2(const Fmi2&) = delete;
  Fmi2& operator=(const Fmi2&) = delete;
  ~Fmi2() { library_.call<void>("fmi2FreeInstance", component); }

  template <class... Arguments>
  int call(const char* name, Arguments... arguments) const {
    return library_.call(name, component, arguments...);
  }
  template <class Function>
  Function find(const char* name) const {
    return library_.find<Function>(name);
  }
  int set(const std::string& name, double value) const {
    const unsigned reference = reference_of(name);
    return call("fmi2SetReal", static_cast<const unsigned*>(&reference), std::size_t{1},
                static_cast<const double*>(&value));
  }
  int set_whole(const std::string& name, int value, const char* with = "fmi2SetInteger") const {
    const unsigned reference = reference_of(name);
    return call(with, static_cast<const unsigned*>(&reference), std::size_t{1},
                static_cast<const int*>(&value));
  }
  int set_text(const std::string& name, const std::string& value) const {
    const unsigned reference = reference_of(name);
    const char* const words = value.c_str();
    return call("fmi2SetString", static_cast<const unsigned*>(&reference), std::size_t{1}, &words);
  }
  double get(const std::string& name) const {
    const unsigned reference = reference_of(name);
    double value = -1e300;
    EXPECT_EQ(call("fmi2GetReal", static_cast<const unsigned*>(&reference), std::size_t{1}, &value),
              0)
        << name;
    return value;
  }
  std::vector<double> get_first(std::size_t count) const {
    std::vector<unsigned> references;
    for (unsigned i = 0; references.size() < count; ++i)
      if (i != reference_of("car.gear")) references.push_back(i);
    std::vector<double> values(count);
    EXPECT_EQ(
        call("fmi2GetReal", static_cast<const unsigned*>(references.data()), count, values.data()),
        0);
    return values;
  }
  int initialise() const {
    const int setup = call("fmi2SetupExperiment", 0, 0.0, 0.0, 0, 0.0);
    const int enter = call("fmi2EnterInitializationMode");
    return std::max({setup, enter, call("fmi2ExitInitializationMode")});
  }
  int step(double time_s, double step_s = 0.001) const {
    return call("fmi2DoStep", time_s, step_s, 1);
  }
  void ask(const vehicle::Controls<double>& c) const {
    EXPECT_EQ(set("input.steering", c.steer_command_rad), 0);
    EXPECT_EQ(set("input.throttle", c.throttle_command), 0);
    static constexpr const char* kBrakes[] = {"input.brake.fl", "input.brake.fr", "input.brake.rl",
                                              "input.brake.rr"};
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(set(kBrakes[i], c.brake_command_pa[i]), 0);
    EXPECT_EQ(set_whole("input.gear", c.gear_command), 0);
    EXPECT_EQ(set("input.clutch", c.clutch_command), 0);
    EXPECT_EQ(set_whole("input.wake.active", c.opponent ? 1 : 0, "fmi2SetBoolean"), 0);
    EXPECT_EQ(set("input.wake.x", c.wake_x_m), 0);
    EXPECT_EQ(set("input.wake.y", c.wake_y_m), 0);
  }
  /// Drives on to a time, 1 ms at a time, by asked_of().
  void drive(int from_ms, int to_ms) const {
    for (int i = from_ms; i < to_ms; ++i) {
      ask(asked_of(0.001 * i, get("car.u"), get("car.v"), get("car.yaw"), get("car.vx")));
      ASSERT_EQ(step(0.001 * i), 0) << i;
    }
  }
  std::string serialised() const {
    void* state = nullptr;
    EXPECT_EQ(call("fmi2GetFMUstate", &state), 0);
    std::size_t size = 0;
    EXPECT_EQ(call("fmi2SerializedFMUstateSize", state, &size), 0);
    std::string bytes(size, '\0');
    EXPECT_EQ(call("fmi2SerializeFMUstate", state, bytes.data(), size), 0);
    EXPECT_EQ(call("fmi2FreeFMUstate", &state), 0);
    EXPECT_EQ(state, nullptr);
    return bytes;
  }
  int restore(const std::string& bytes) const {
    void* state = nullptr;
    const int read = call("fmi2DeSerializeFMUstate", static_cast<const char*>(bytes.data()),
                          bytes.size(), &state);
    if (read != 0) return read;
    const int set = call("fmi2SetFMUstate", state);
    EXPECT_EQ(call("fmi2FreeFMUstate", &state), 0);
    return set;
  }

  void* component = nullptr;
  std::vector<std::string> log;

 private:
  static void take_line(void* environment, const char*, int status, const char*,
                        const char* message, ...) {
    static_cast<Fmi2*>(environment)->log.push_back(std::to_string(status) + " " + message);
  }

  SharedObject library_;
  fmi2CallbackFunctions functions_{};
};

}  // namespace fmu_tests
