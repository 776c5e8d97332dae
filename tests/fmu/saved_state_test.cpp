#include "fmu/saved_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"

namespace saved_state_test {

using fmu::SavedState;
using ::testing::HasSubstr;

SavedState some_state() {
  SavedState out;
  out.phase = fmu::Phase::kStepping;
  out.started = true;
  out.begin_s = 0.25;
  out.texts[1] = "a setup.txt";
  const std::vector<fmu::Variable> list = fmu::variables();
  out.numbers.resize(fmu::count_values(list) - fmu::kTextCount);
  out.given.resize(out.numbers.size());
  for (const fmu::Variable& v : list)
    for (std::size_t i = 0; i < v.size && v.source != fmu::Source::kText; ++i)
      out.numbers[v.reference + i] = v.start;
  out.given[400] = 1;
  double value = 0.1;
  for (double& x : out.simulation.state.value) x = value += 0.37;
  auto& d = out.simulation.discrete;
  d.brake[3].history[511] = 1.0 / 3.0;
  d.steer.place = -0.7;
  d.brake_stick[2].moving = -1;
  d.gear = 0;
  d.gear_wanted = -1;
  d.shift_left_s = 0.03;
  d.step = 123456789012;
  out.place = {10.5, -1.25, 3.0, 4.0};
  return out;
}

std::string message(const std::string& bytes, const std::string& token = "{a}") {
  try {
    (void)fmu::from_bytes(bytes, token, fmu::variables());
  } catch (const base::Error& error) {
    return error.what();
  }
  return "taken";
}

TEST(SavedState, ComesBackWhole) {
  const SavedState state = some_state();
  const std::string bytes = fmu::to_bytes(state, "{a}");
  const SavedState back = fmu::from_bytes(bytes, "{a}", fmu::variables());
  EXPECT_EQ(fmu::to_bytes(back, "{a}"), bytes);
  EXPECT_EQ(back.phase, state.phase);
  EXPECT_EQ(back.texts, state.texts);
  EXPECT_EQ(back.numbers, state.numbers);
  EXPECT_EQ(back.given, state.given);
  EXPECT_EQ(back.simulation.state.value, state.simulation.state.value);
  EXPECT_EQ(back.simulation.discrete.brake[3].history[511], 1.0 / 3.0);
  EXPECT_EQ(back.simulation.discrete.brake_stick[2].moving, -1);
  EXPECT_EQ(back.simulation.discrete.gear_wanted, -1);
  EXPECT_EQ(back.simulation.discrete.step, 123456789012);
  EXPECT_EQ(back.place.v_m, -1.25);
}

// Whatever of the simulation is changed, the bytes are: no field is left out.
TEST(SavedState, NoFieldOfTheSimulationIsForgotten) {
  const std::string before = fmu::to_bytes(some_state(), "{a}");
  using Change = void (*)(vehicle::Simulation<double>&);
  constexpr Change kChanges[] = {[](auto& s) { s.state[vehicle::kTurbo] += 1; },
                                 [](auto& s) { s.discrete.throttle.history[0] += 1; },
                                 [](auto& s) { s.discrete.throttle.rate += 1; },
                                 [](auto& s) { s.discrete.stuck_steer_rad += 1; },
                                 [](auto& s) { s.discrete.last_steer_rad += 1; },
                                 [](auto& s) { s.discrete.steer_stick.output += 1; },
                                 [](auto& s) { s.discrete.throttle_stick.output += 1; },
                                 [](auto& s) { s.discrete.steer_stick.drive += 1; },
                                 [](auto& s) { s.discrete.steer_stick.moving += 1; },
                                 [](auto& s) { s.discrete.played_steer_rad += 1; },
                                 [](auto& s) { s.discrete.ledge[3].known = true; },
                                 [](auto& s) { s.discrete.ledge[0].hub_m.x += 1; },
                                 [](auto& s) { s.discrete.ledge[1].normal.z += 1; },
                                 [](auto& s) { s.discrete.ledge[2].radius_m += 1; },
                                 [](auto& s) { s.discrete.ledge[3].pressed_m += 1; },
                                 [](auto& s) { s.discrete.ledge[3].sunk_m += 1; },
                                 [](auto& s) { s.discrete.ledge[3].lent_j += 1; },
                                 [](auto& s) { s.discrete.ledge[3].lent_at_m.y += 1; },
                                 [](auto& s) { s.discrete.ledges.work_j += 1; },
                                 [](auto& s) { s.discrete.ledges.most_j += 1; },
                                 [](auto& s) { s.discrete.ledges.u_m += 1; },
                                 [](auto& s) { s.discrete.ledges.v_m += 1; },
                                 [](auto& s) { s.discrete.gear += 1; },
                                 [](auto& s) { s.discrete.shift_left_s += 1; },
                                 [](auto& s) { s.discrete.step += 1; },
                                 [](auto& s) { s.time_s += 1; }};
  for (std::size_t i = 0; i < std::size(kChanges); ++i) {
    SavedState changed = some_state();
    kChanges[i](changed.simulation);
    EXPECT_NE(fmu::to_bytes(changed, "{a}"), before) << i;
  }
  // A new member must be written too: this is what there is today.
  EXPECT_EQ(sizeof(vehicle::Discrete<double>),
            6 * sizeof(vehicle::laws::Actuator<double>) + 6 * sizeof(vehicle::laws::Stick<double>) +
                6 * sizeof(double) + 4 * sizeof(vehicle::laws::Ledge<double>) +
                sizeof(vehicle::laws::LedgeTotal));
  EXPECT_EQ(sizeof(vehicle::laws::Ledge<double>), 14 * sizeof(double));
}

TEST(SavedState, RefusesWhatIsNone) {
  const std::string bytes = fmu::to_bytes(some_state(), "{a}");
  EXPECT_EQ(message(bytes), "taken");
  EXPECT_THAT(message(""), HasSubstr("it does not begin with 'kerbstone car'"));
  EXPECT_THAT(message(bytes, "{b}"), HasSubstr("another unit"));
  EXPECT_THAT(message(bytes + "x"), HasSubstr("checksum"));
  for (std::size_t size = 0; size < bytes.size(); size += 97)
    EXPECT_NE(message(bytes.substr(0, size)), "taken");
  std::string newer = bytes;
  newer[14] = 9;
  EXPECT_THAT(message(newer), HasSubstr("version 9 seen, 5 wanted"));
  for (std::size_t at = 0; at < bytes.size(); at += 41)
    for (int bit = 0; bit < 8; ++bit) {
      std::string flipped = bytes;
      flipped[at] = static_cast<char>(flipped[at] ^ (1 << bit));
      EXPECT_NE(message(flipped), "taken") << at << ", bit " << bit;
    }
  SavedState wrong = some_state();
  wrong.simulation.discrete.gear = 11;
  EXPECT_THAT(message(fmu::to_bytes(wrong, "{a}")), HasSubstr("a gear"));
  wrong = some_state();
  wrong.simulation.discrete.step = -1;
  EXPECT_THAT(message(fmu::to_bytes(wrong, "{a}")), HasSubstr("a count of steps"));
  wrong = some_state();
  wrong.simulation.state[vehicle::kVx] = std::numeric_limits<double>::infinity();
  EXPECT_THAT(message(fmu::to_bytes(wrong, "{a}")), HasSubstr("a state that no car has"));
  wrong = some_state();
  wrong.place.x_m = 1e300;
  EXPECT_THAT(message(fmu::to_bytes(wrong, "{a}")), HasSubstr("a place"));
  wrong = some_state();
  wrong.simulation.discrete.ledge[1].normal.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message(fmu::to_bytes(wrong, "{a}")), HasSubstr("a plane under a wheel"));
  wrong = some_state();
  wrong.simulation.discrete.ledge[1].sunk_m = -0.1;
  EXPECT_THAT(message(fmu::to_bytes(wrong, "{a}")), HasSubstr("a deflection"));
  wrong = some_state();
  for (const fmu::Variable& v : fmu::variables())
    if (v.name == "parameter.chassis.mass_kg")
      wrong.numbers[v.reference] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message(fmu::to_bytes(wrong, "{a}")), HasSubstr("parameter.chassis.mass_kg = nan"));
}

}  // namespace saved_state_test
