// Where a log has commands and what came of them, each gain is found where it acts.
#include "actuator_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "proof.h"

namespace explain_test {
namespace actuator_rows_test {

/// Pressed further and further in 10 s, with a response at once: what the rows leave over at the
/// end.
double left_over(double gain, double most) {
  std::vector<double> command, measured;
  for (int i = 0; i < 200; ++i) {
    command.push_back(0.005 * i);
    measured.push_back(std::min(1.0, 1.2 * command.back()));
  }
  std::vector<double> out(command.size(), NAN);
  explain::actuator_rows(out, measured, command, gain, most, 0.0, vehicle::default_parameters(),
                         vehicle::Parameter::throttle_dead_time_s);
  return out[198];
}

TEST(ActuatorRows, APedalIsNoFurtherOpenThanOpen) {
  EXPECT_NEAR(left_over(1.2, 1.0), 0.0, 1e-12);
  EXPECT_NEAR(left_over(1.2, std::numeric_limits<double>::infinity()), 1.0 - 1.2 * 0.99, 1e-12);
}

// Brakes that bite 22 % harder, road wheels and a throttle that go 15 % further than stated. The
// pressures that are logged follow their commands as stated.
TEST(SlowActuatorRows, GainsAreFoundWhereTheyAct) {
  Proof proof("third-gains", unless_heavy(3));
  const json found = proof.explain();
  std::map<std::string, double> named;
  for (const json& f : found.at("findings")) {
    named[f.at("mechanism").get<std::string>()] = value(f);
    fmt::print("{}: {:.4f}\n", f.at("mechanism").get<std::string>(), value(f));
  }
  ASSERT_TRUE(named.contains("parameter.brake_gain"));
  ASSERT_TRUE(named.contains("parameter.steering_ratio"));
  ASSERT_TRUE(named.contains("parameter.throttle_gain"));
  EXPECT_EQ(named.size(), 3u) << base::dump_json(found.at("findings"), 1);
  EXPECT_NEAR(named["parameter.brake_gain"], 1.22, 0.04);
  EXPECT_NEAR(named["parameter.throttle_gain"], 1.15, 0.01);
  EXPECT_NEAR(named["parameter.steering_ratio"], 1 / 1.15, 0.003);
  for (const json& p : found.at("parameters"))
    if (p.at("name") == "brake pressure over command, share") {
      EXPECT_NEAR(p.at("value").get<double>(), 1.0, 0.01);
    }
}

}  // namespace actuator_rows_test
}  // namespace explain_test
