#include "vehicle/state.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "vehicle/step.h"

namespace state_test {

using namespace vehicle;  // NOLINT: a test of this library

TEST(State, HasItsNamesAtItsPlaces) {
  EXPECT_EQ(kStateSize, 53u);
  EXPECT_EQ(state_name(kX), "x_m");
  EXPECT_EQ(state_name(kTravel + 3), "travel_rr_m");
  EXPECT_EQ(state_name(kSpin), "wheel_fl_radps");
  EXPECT_EQ(state_name(kDiscSurface + 1), "disc_surface_fr_k");
  EXPECT_EQ(kStates[kDiscSurface + 1].channel, "brake_disc_fr_k");
  EXPECT_EQ(state_name(kTurbo), "turbo_radps");
  std::set<std::string_view> names;
  for (const StateInfo& s : kStates) {
    EXPECT_TRUE(names.insert(s.name).second) << s.name;
    EXPECT_FALSE(s.meaning.empty());
    EXPECT_GT(s.small, 0.0);
  }
}

// Whatever is integrated ends where a state's own rate takes it, or is one of those that a step
// treats: with every rate 1, only place, attitude, travel and the patch move otherwise.
TEST(State, MovesByItsRateOrByTheStepsOwnRule) {
  std::set<std::string> otherwise;
  for (const StateInfo& s : kStates)
    if (s.moves == Moves::kOtherwise)
      otherwise.insert(std::string(s.name.substr(0, s.name.find('_'))));
  EXPECT_EQ(otherwise,
            (std::set<std::string>{"x", "y", "z", "roll", "pitch", "yaw", "travel", "slip"}));
  State<double> s{}, rate{};
  for (double& r : rate.value) r = 1.0;
  move_by_rate(s, rate, 0.001, std::make_index_sequence<kStateSize>());
  for (std::size_t i = 0; i < kStateSize; ++i)
    EXPECT_EQ(s[i], kStates[i].moves == Moves::kByRate ? 0.001 : 0.0) << state_name(i);
}

// What a replay's next window goes on with: temperatures, heats, pressures, fuel; nothing that
// moves.
TEST(State, KeepsTemperaturesAndPressuresOverWindows) {
  for (std::size_t i = 0; i < kStateSize; ++i) {
    const std::string name(state_name(i));
    const bool slow = name.ends_with("_k") || name.ends_with("_pa") || name.ends_with("_j") ||
                      name.ends_with("_kg") || name == "boost" || name == "tyre_warmth" ||
                      name == "turbo_radps";
    EXPECT_EQ(kStates[i].kept, slow) << name;
  }
}

}  // namespace state_test
