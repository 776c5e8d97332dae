#include "sim/message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace message_test {

const std::vector<std::string> kNames{"throttle", "gear"};

std::string why_not(std::string_view bytes) {
  std::string why;
  EXPECT_FALSE(sim::read_command(bytes, kNames, why).has_value()) << bytes;
  return why;
}

std::string binary(std::uint32_t sequence, std::uint32_t flags, const std::vector<double>& values) {
  std::string bytes = "KSC1";
  for (const std::uint32_t number : {sequence, flags, static_cast<std::uint32_t>(values.size())})
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  bytes.append(reinterpret_cast<const char*>(values.data()), 8 * values.size());
  return bytes;
}

TEST(Message, CommandsAreReadInBothForms) {
  std::string why;
  auto json = sim::read_command(R"({"sequence": 7, "set": {"gear": 2}})", kNames, why);
  ASSERT_TRUE(json) << why;
  EXPECT_EQ(json->sequence, 7u);
  EXPECT_TRUE(std::isnan(json->values[0]));
  EXPECT_EQ(json->values[1], 2.0);
  EXPECT_FALSE(json->ends);
  const auto bytes = sim::read_command(binary(8, 1, {0.5, 3.0}), kNames, why);
  ASSERT_TRUE(bytes) << why;
  EXPECT_EQ(bytes->sequence, 8u);
  EXPECT_TRUE(bytes->ends);
  EXPECT_EQ(bytes->values, (std::vector{0.5, 3.0}));
}

TEST(Message, ACommandMayTellThePlan) {
  std::string why;
  const auto json =
      sim::read_command(R"({"sequence": 7, "plan": [[1, 2, 30], [3.5, -4, 29]]})", kNames, why);
  ASSERT_TRUE(json) << why;
  ASSERT_TRUE(json->plan);
  ASSERT_EQ(json->plan->size(), 2u);
  EXPECT_EQ((*json->plan)[1].x_m, 3.5);
  EXPECT_EQ((*json->plan)[1].y_m, -4.0);
  EXPECT_EQ((*json->plan)[1].speed_mps, 29.0);
  EXPECT_FALSE(sim::read_command(R"({"sequence": 7})", kNames, why)->plan) << "not told";
  EXPECT_TRUE(sim::read_command(R"({"plan": []})", kNames, why)->plan->empty()) << "none any more";

  const auto with_plan = [](std::uint32_t said, const std::vector<double>& numbers) {
    std::string bytes = binary(8, 8, {0.5, 3.0});
    bytes.append(reinterpret_cast<const char*>(&said), sizeof said);
    bytes.append(reinterpret_cast<const char*>(numbers.data()), 8 * numbers.size());
    return bytes;
  };
  const auto bytes = sim::read_command(with_plan(2, {1, 2, 30, 3.5, -4, 29}), kNames, why);
  ASSERT_TRUE(bytes) << why;
  ASSERT_EQ(bytes->plan->size(), 2u);
  EXPECT_EQ((*bytes->plan)[1].y_m, -4.0);
  EXPECT_EQ(bytes->values, (std::vector{0.5, 3.0}));

  const std::string no_plan = "a plan that is no list of at most 500 points x, y, speed";
  for (const char* text : {R"({"plan": 1})", R"({"plan": [1, 2, 3]})", R"({"plan": [[1, 2]]})",
                           R"({"plan": [[1, 2, 3, 4]]})", R"({"plan": [[1, 2, "3"]]})",
                           R"({"plan": [[1, [2], 3]]})", R"({"plan": null})"})
    EXPECT_EQ(why_not(text), no_plan) << text;
  EXPECT_EQ(why_not(R"({"plan": [[1, 1e999, 3]]})"), "no JSON object, or a number beyond 1e308");
  EXPECT_EQ(why_not(with_plan(1, {1, std::nan(""), 3})), "a value that is not finite");
  EXPECT_EQ(why_not(with_plan(2, {1, 2, 3})), no_plan) << "cut short";
  EXPECT_EQ(why_not(with_plan(1, {1, 2, 3, 4})), no_plan) << "too long";
  EXPECT_EQ(why_not(with_plan(0xffffffffu, {1, 2, 3})), no_plan) << "a lying number";
  EXPECT_EQ(why_not(binary(8, 8, {0.5, 3.0})), no_plan) << "none follows";
  std::string most = R"({"plan": [[1,2,3])";
  for (std::size_t k = 1; k < sim::kMostPlanPoints; ++k) most += ",[1,2,3]";
  EXPECT_TRUE(sim::read_command(most + "]}", kNames, why));
  EXPECT_EQ(why_not(most + ",[1,2,3]]}"), no_plan);
  EXPECT_EQ(why_not(R"({"plan": )" + std::string(1000, '[')),
            "more lists or tables than a command has");
}

TEST(Message, AResetHasStartsOfItsOwn) {
  std::string why;
  const auto json =
      sim::read_command(R"({"sequence": 1, "reset": {"start.speed": 20}})", kNames, why);
  ASSERT_TRUE(json) << why;
  EXPECT_TRUE(json->resets);
  ASSERT_EQ(json->starts.size(), 1u);
  EXPECT_EQ(json->starts[0].first, "start.speed");
  EXPECT_EQ(json->starts[0].second, 20.0);
  EXPECT_TRUE(sim::read_command(binary(8, 2, {0.5, 3.0}), kNames, why)->resets);
  EXPECT_FALSE(json->pauses.has_value());
  EXPECT_EQ(sim::read_command(R"({"pause": true})", kNames, why)->pauses, true);
  EXPECT_EQ(sim::read_command(binary(8, 4, {0.5, 3.0}), kNames, why)->pauses, true);
  EXPECT_EQ(sim::read_command(binary(8, 0, {0.5, 3.0}), kNames, why)->pauses, false);
  EXPECT_EQ(why_not(R"({"pause": 1})"), "pause is neither true nor false");
  EXPECT_EQ(why_not(R"({"reset": true})"), "reset is no object of starts");
  EXPECT_EQ(why_not(R"({"reset": {"start.speed": "20"}})"),
            R"('start.speed' is said to be "20"; a finite number wanted)");
}

TEST(Message, AStateIsSavedAndGoneBackTo) {
  std::string why;
  EXPECT_EQ(sim::read_command(R"({"save": "corner"})", kNames, why)->save, "corner");
  const auto back = sim::read_command(R"({"reset": {"state": "corner"}})", kNames, why);
  ASSERT_TRUE(back) << why;
  EXPECT_TRUE(back->resets);
  EXPECT_EQ(back->state, "corner");
  EXPECT_TRUE(back->starts.empty());
  const auto start = sim::read_command(R"({"reset": {"state": 2}})", kNames, why);
  ASSERT_TRUE(start) << why;
  EXPECT_EQ(start->starts[0].first, "state") << "a unit may call a number so";

  const auto named = [](std::uint32_t flags, std::uint32_t said, const std::string& rest) {
    std::string bytes = binary(8, flags, {0.5, 3.0});
    bytes.append(reinterpret_cast<const char*>(&said), sizeof said);
    return bytes + rest;
  };
  const auto saved = sim::read_command(named(16, 6, "corner"), kNames, why);
  ASSERT_TRUE(saved) << why;
  EXPECT_EQ(saved->save, "corner");
  EXPECT_FALSE(saved->resets);
  const auto gone = sim::read_command(named(32, 6, "corner"), kNames, why);
  ASSERT_TRUE(gone) << why;
  EXPECT_EQ(gone->state, "corner");
  EXPECT_TRUE(gone->resets);
  const auto planned = sim::read_command(
      named(24, 1, "c" + std::string("\1\0\0\0", 4) + std::string(24, '\0')), kNames, why);
  ASSERT_TRUE(planned) << why;
  EXPECT_EQ(planned->save, "c");
  EXPECT_EQ(planned->plan->size(), 1u);

  const std::string no_name = "a state without a name of 1 to 64 bytes";
  for (const std::string& text :
       {std::string(R"({"save": ""})"), std::string(R"({"save": 1})"),
        std::string(R"({"reset": {"state": ""}})"), R"({"save": ")" + std::string(65, 'a') + "\"}",
        named(16, 0, ""), named(16, 7, "corner"), named(16, 65, std::string(65, 'a')),
        named(32, 0xffffffffu, "corner"), binary(8, 16, {0.5, 3.0})})
    EXPECT_EQ(why_not(text), no_name) << text;
  EXPECT_EQ(why_not(named(16, 5, "corner")), "bytes after its end");
  EXPECT_EQ(why_not(R"({"save": "a", "reset": {}})"), "a state to save and a reset at once");
  EXPECT_EQ(why_not(R"({"reset": {"state": "a", "k": 1}})"), "starts for a state that was saved");
}

TEST(Message, WhatIsNoCommandIsRefused) {
  EXPECT_EQ(why_not(""), "neither JSON nor KSC1");
  EXPECT_EQ(why_not("{"), "no JSON object, or a number beyond 1e308");
  EXPECT_EQ(why_not(R"({"set": {"brake": 1}})"), "'brake' is no command of this run");
  EXPECT_EQ(why_not(R"({"set": {"gear": 1e999}})"), "no JSON object, or a number beyond 1e308");
  EXPECT_EQ(why_not(R"({"set": {"gear": "2"}})"),
            R"('gear' is said to be "2"; a finite number wanted)");
  EXPECT_EQ(why_not(R"({"sequence": -1})"), "sequence is no whole number from 0 to 4294967295");
  EXPECT_EQ(why_not(R"({"go": 1})"),
            "a key that is not sequence, set, plan, pause, save, reset or end: 'go'");
  EXPECT_EQ(why_not(std::string(100, '{')), "more lists or tables than a command has");
  EXPECT_EQ(why_not(std::string(sim::kLongestMessage + 1, ' ')), "longer than 60 kB");
  EXPECT_EQ(why_not("KSC1abc"), "cut short");
  EXPECT_EQ(why_not(binary(1, 0, {0.5})), "another number of values than commands were named");
  EXPECT_EQ(why_not(binary(1, 0, {0.5, std::numeric_limits<double>::quiet_NaN()})),
            "a value that is not finite");
  EXPECT_EQ(why_not(binary(1, 0, {0.5, 1.0}) + "x"),
            "another number of values than commands were named");
}

TEST(Message, ARefusalIsWrittenInBothForms) {
  const sim::Remark remark{"refused", "no \xff", 7, 0.25, 2};
  EXPECT_EQ(sim::write_remark(remark, false),
            "{\"refused\":\"no \xef\xbf\xbd\",\"sequence\":7,\"time_s\":0.25,\"resets\":2}");
  const std::string bytes = sim::write_remark(remark, true);
  EXPECT_EQ(bytes.size(), 4u + 8u + 8u + 4u);
  EXPECT_EQ(bytes.substr(0, 4), "KSR1");
  EXPECT_EQ(bytes.substr(20), "no \xff");
  EXPECT_EQ(sim::sequence_of(R"({"sequence": 12, "go": 1})"), 12u);
  EXPECT_EQ(sim::sequence_of(binary(13, 0, {0.5})), 13u);
  for (const char* const none : {"", "KSC1ab", "{", R"({"sequence": -1})", R"({"sequence": 1e3})"})
    EXPECT_FALSE(sim::sequence_of(none)) << none;
}

TEST(Message, WhatWasClippedAndThatItStandsIsTold) {
  sim::MeasurementMessage message{7, 0.25, false, false, {1.5}};
  message.clipped = "x";
  message.parked = "rolled";
  EXPECT_EQ(
      sim::write_measurement(message, {"a"}, false),
      R"({"sequence":7,"time_s":0.25,"safe":false,"reset":false,"values":{"a":1.5},"clipped":"x","parked":"rolled"})");
  EXPECT_EQ(sim::write_measurement(message, {"a"}, true)[8], 4 + 8);
}

TEST(Message, MeasurementsAreWrittenInBothForms) {
  const sim::MeasurementMessage message{7, 0.25, true, false, {1.0 / 3.0, -2.0}};
  EXPECT_EQ(
      sim::write_measurement(message, {"car.x", "car.y"}, false),
      R"({"sequence":7,"time_s":0.25,"safe":true,"reset":false,"values":{"car.x":0.3333333333333333,"car.y":-2.0}})");
  const std::string bytes = sim::write_measurement(message, {"car.x", "car.y"}, true);
  ASSERT_EQ(bytes.size(), 4u + 12u + 8u + 16u);
  EXPECT_EQ(bytes.substr(0, 4), "KSM1");
  std::uint32_t flags = 0;
  double third = 0.0;
  std::memcpy(&flags, bytes.data() + 8, 4);
  std::memcpy(&third, bytes.data() + 24, 8);
  EXPECT_EQ(flags, 1u);
  EXPECT_EQ(third, 1.0 / 3.0);
}

}  // namespace message_test
