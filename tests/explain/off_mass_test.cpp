// A mass that is stated 8 % off, in a log without wheel loads: torque, drag and brakes that are off
// alike say as much, so that it is not named. It must not end in a green verdict.
#include <gtest/gtest.h>

#include <cmath>

#include "base/read_file.h"
#include "base/write_file.h"
#include "proof.h"

namespace off_mass_test {

using explain_test::Proof;
using nlohmann::json;

TEST(SlowOffMass, IsNoGreenVerdict) {
  Proof proof("none", 2);
  const std::string file = proof.path("vehicle.yaml");
  std::string car = base::read_file(file);
  const std::string key = "chassis.mass_kg: ";
  const std::size_t at = car.find(key) + key.size(), end = car.find('\n', at);
  const double mass = std::stod(car.substr(at, end - at));
  for (const double factor : {0.92, 1.08}) {
    std::string other = car;
    base::write_file(file, other.replace(at, end - at, fmt::format("{:.2f}", factor * mass)));
    const json found = proof.explain("run.csv", fmt::format("out{}", factor));
    EXPECT_NE(found.at("verdict"), "none") << factor;
    for (const json& p : found.at("parameters"))
      if (p.at("id") == "parameter.mass") {
        EXPECT_NEAR(p.at("value"), mass, 0.03 * mass);
        EXPECT_TRUE(p.at("unsure").get<bool>() || p.at("beyond_prior").get<bool>());
      }
  }
}

}  // namespace off_mass_test
