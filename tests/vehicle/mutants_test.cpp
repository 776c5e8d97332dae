// Every file of a car with bytes changed, lines lost, doubled and cut off: each ends in an error or
// in a car whose numbers are finite. Runs under the sanitizers too.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>

#include "fuzz/mutated.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "vehicle/error.h"
#include "vehicle/sensors.h"
#include "vehicle/step.h"
#include "vehicle/vehicle_file.h"

namespace mutants_test {

using namespace vehicle;  // NOLINT: a test of this library

TEST(Mutants, EndInAnErrorOrInACarThatRolls) {
  const std::string from = places::source() + "/vehicles/open_wheel/";
  const cli::Folder folder;
  const std::vector<std::string> files{
      "vehicle.yaml",  "setup.txt",      "front.tir",     "rear.tir",         "engine.csv",
      "drag.csv",      "front_lift.csv", "rear_lift.csv", "pad_friction.csv", "wake_drag.csv",
      "wake_lift.csv", "yaw_drag.csv",   "yaw_lift.csv",  "devices.yaml"};
  const auto put = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder / name, std::ios::binary) << text;
  };
  for (const std::string& name : files) put(name, cli::read(from + name));
  std::mt19937_64 random(3);
  const int mutants = std::getenv("KERBSTONE_HEAVY") != nullptr ? 715 : 120;  // of each file
  int cars = 0, errors = 0;
  for (const std::string& name : files) {
    const std::string good = cli::read(from + name);
    for (int k = 0; k < mutants; ++k) {
      put(name, fuzz::mutated(good, random));
      try {
        (void)read_devices(folder / "devices.yaml");
        const Vehicle v = read_vehicle(folder / "vehicle.yaml");
        const Car<double> car = make_car(v.files, v.parameters, v.terms, v.contact);
        StartOptions begin;
        begin.speed_mps = 20;
        begin.gear = 2;
        Simulation<double> sim = start(car, Road(), begin);
        Detail<double> detail{};
        StepResult result;
        for (int i = 0; i < 20 && result.ok(); ++i)
          result = step(car, sim, Controls<double>{}, Road(), {}, detail);
        // A problem is named; without one every number is finite.
        if (result.ok()) {
          for (const double value : sim.state.value) ASSERT_TRUE(std::isfinite(value)) << name;
        }
        ++cars;
      } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        ++errors;
      }
    }
    put(name, good);
  }
  EXPECT_GT(cars, 80);
  EXPECT_GT(errors, 100);
}

}  // namespace mutants_test
