// States of a unit that are saved and gone back to while it is served.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/json_text.h"
#include "fmu/export_unit.h"
#include "sim/serve_unit.h"
#include "some_unit.h"
#include "support/places.h"
#include "unit_driver.h"

namespace serve_states_test {

using sim_tests::Driver, sim_tests::description_2, sim_tests::description_3, sim_tests::scalar_2,
    sim_tests::value_3, sim_tests::write_unit;
using ::testing::HasSubstr;

/// A unit whose x decays by k, with or without states that can be saved.
std::string decay_2(const char* more = " canGetAndSetFMUstate=\"true\"") {
  return description_2(
      "decay",
      scalar_2("x", 1, "output") + scalar_2("a", 10, "input") + scalar_2("m", 21, "output") +
          R"(<ScalarVariable name="k" valueReference="3" causality="parameter" variability="tunable"><Real start="1"/></ScalarVariable>)",
      more);
}
std::string decay_3() {
  std::string xml = description_3(
      "decay",
      value_3("Float64", "x", 1, "output") + value_3("Float64", "a", 10, "input") +
          value_3("Float64", "m", 21, "output") +
          R"(<Float64 name="k" valueReference="3" causality="parameter" variability="tunable" start="1"/>)");
  const std::string identifier = R"(modelIdentifier="some")";
  return xml.insert(xml.find(identifier) + identifier.size(), R"( canGetAndSetFMUState="true")");
}

/// A flat road along x, 12 m wide, on which x is the place of the car.
std::shared_ptr<const crg::Surface> flat_road() {
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = 1.0;
  for (int j = -6; j <= 6; ++j) grid.v_m.push_back(j);
  for (int i = 0; i <= 50; ++i) line.x_m.push_back(i);
  line.y_m.assign(51, 0.0);
  line.heading_rad.assign(51, 0.0);
  grid.z_m.assign(51 * grid.columns(), 0.0f);
  return std::make_shared<const crg::Surface>(crg::make_crg(line, grid));
}

sim::ServeOptions options_of(const support::TemporaryFolder& folder) {
  sim::ServeOptions options;
  options.socket_path = folder.path("s");
  options.commands = {"a", "k"};
  options.measurements = {"x", "noisy"};
  options.step_s = 0.01;
  options.stop_s = 20.0;
  options.lockstep = true;
  options.every = 7;
  options.patience_s = 5.0;
  vehicle::SignalSensor noisy;
  noisy.name = "noisy";
  noisy.signal = "x";
  noisy.rate_hz = 30.0;
  noisy.delay_s = 0.05;
  noisy.noise = 0.1;
  noisy.bias_walk = 0.1;
  noisy.jitter_s = 0.01;
  noisy.lost = 0.2;
  vehicle::SignalCommand slow{"a", "a"};
  slow.dead_time_s = 0.03, slow.lag_s = 0.2, slow.damping = 0.7;
  options.devices = {1, {noisy}, {slow}, {}};
  options.road = flat_road();
  options.devices.road.pose = {"x", "m", "m", "m", "m", "m"};
  vehicle::EdgeSensor edges;
  edges.name = "camera";
  edges.clock = {10.0, 0.05};
  edges.mounting.at_m = {0.0, 0.0, 1.0};
  edges.field_rad = 2.0;
  edges.noise_rad = 0.01;
  options.devices.road.edges = {edges};
  return options;
}

/// Says something and hears everything until the measurement; without what tells the one command
/// from the other.
class Asker {
 public:
  explicit Asker(const std::string& path) : driver_(path) {}

  std::vector<std::string> operator()(nlohmann::json said) {
    said["sequence"] = ++sequence_;
    driver_.say(base::dump_json(said));
    std::vector<std::string> out;
    while (true) {
      nlohmann::json told = driver_.hear();
      if (!told.is_object()) return out;  // nothing came: the test has failed
      const bool is_last = told.contains("values");
      if (is_last) {
        EXPECT_EQ(told.at("sequence"), sequence_);
      }
      told.erase("sequence");
      told.erase("reset");
      out.push_back(base::dump_json(told));
      if (is_last) return out;
    }
  }
  /// Says what is refused: gives back why.
  std::string refusal_of(const nlohmann::json& said) {
    say(said);
    return driver_.hear().value("refused", "");
  }
  void say(nlohmann::json said) {
    said["sequence"] = ++sequence_;
    driver_.say(base::dump_json(said));
  }
  const Driver& driver() const { return driver_; }
  std::uint32_t sequence() { return ++sequence_; }

 private:
  Driver driver_;
  std::uint32_t sequence_ = 0;
};

using Told = std::vector<std::vector<std::string>>;

Told drive(Asker& ask) {
  Told out;
  for (int k = 0; k < 12; ++k) out.push_back(ask({{"set", {{"a", k}, {"k", 0.5 + 0.1 * k}}}}));
  return out;
}

class ServeStates : public testing::TestWithParam<int> {};

TEST_P(ServeStates, AfterGoingBackEverythingIsAsTheFirstTime) {
  const support::TemporaryFolder folder;
  const std::string unit =
      GetParam() == 2 ? write_unit(folder, decay_2(), 2) : write_unit(folder, decay_3(), 3);
  const sim::ServeOptions options = options_of(folder);
  std::thread drives([&] {
    Asker ask(options.socket_path);
    std::vector<std::string> here;
    for (int k = 0; k < 4; ++k) here = ask({{"set", {{"a", -k}}}});
    EXPECT_EQ(ask.refusal_of({{"reset", {{"state", "corner"}}}}), "a state that was not saved");
    // The state is the one in which the command finds the unit.
    Told first{ask({{"save", "corner"}, {"set", {{"k", 3}}}})};
    const Told rest = drive(ask);
    first.insert(first.end(), rest.begin(), rest.end());
    EXPECT_NE(rest.front(), rest.back());
    std::size_t seen = 0;
    for (const auto& one : first) seen += one.size() - 1;
    EXPECT_GE(seen, 8u) << "edges, ten a second";

    // Longer away, at 0 s again meanwhile, which keeps what was saved.
    drive(ask);
    ask({{"reset", {{"k", 2}}}});
    for (int round = 0; round < 2; ++round) {
      drive(ask);
      EXPECT_EQ(ask({{"reset", {{"state", "corner"}}}}).back(), here.back());
      Told again{ask({{"set", {{"k", 3}}}})};
      const Told more = drive(ask);
      again.insert(again.end(), more.begin(), more.end());
      EXPECT_EQ(again, first) << round;
    }

    // By the binary form, to another state.
    const auto last = ask({{"save", "end"}});
    drive(ask);
    std::string back = "KSC1";
    for (const std::uint32_t number : {ask.sequence(), 32u, 2u})
      back.append(reinterpret_cast<const char*>(&number), sizeof number);
    const double values[] = {11.0, 1.6};  // as drive() left them
    back.append(reinterpret_cast<const char*>(values), sizeof values);
    back += std::string("\3\0\0\0end", 7);
    ask.driver().say(back);
    EXPECT_EQ(ask.driver().hear_bytes().substr(0, 4), "KSM1");
    EXPECT_EQ(ask(nlohmann::json::object()), last);
    ask.say({{"end", true}});
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  drives.join();
  EXPECT_EQ(run.counts.resets, 4u);
  EXPECT_EQ(run.counts.broken, 1u);
  EXPECT_EQ(run.first_broken, "a state that was not saved");
  EXPECT_TRUE(run.counts.asked_to_end);
}

INSTANTIATE_TEST_SUITE_P(OfFmi, ServeStates, testing::Values(2, 3));

TEST(ServeStates, SixteenAreKept) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(folder, decay_2(), 2);
  const sim::ServeOptions options = options_of(folder);
  std::thread drives([&] {
    Asker ask(options.socket_path);
    for (int k = 0; k < 16; ++k) ask({{"save", fmt::format("state {}", k)}});
    EXPECT_THAT(ask.refusal_of({{"save", "one more"}}), HasSubstr("a 17th state"));
    const auto here = ask(nlohmann::json::object());
    ask({{"save", "state 3"}});  // instead of the older one
    EXPECT_EQ(ask({{"reset", {{"state", "state 3"}}}}).back(), here.back());
    ask.say({{"end", true}});
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  drives.join();
  EXPECT_EQ(run.counts.broken, 1u);
  EXPECT_EQ(run.first_broken, "a 17th state to save; save under a name that is there already");
}

TEST(ServeStates, AUnitThatCannotSaveIsServedAndSaysSo) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(folder, decay_2(""), 2);
  const sim::ServeOptions options = options_of(folder);
  std::thread drives([&] {
    Asker ask(options.socket_path);
    EXPECT_THAT(ask.refusal_of({{"save", "here"}}), HasSubstr("which this unit cannot"));
    ask(nlohmann::json::object());
    ask.say({{"end", true}});
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  drives.join();
  EXPECT_EQ(run.counts.broken, 1u);
  EXPECT_THAT(run.first_broken, HasSubstr("which this unit cannot"));
}

/// The unit of crgdrive fmu: numbers read back as the same bits.
TEST(ServeStates, TheCarDrivesOnAsTheFirstTime) {
  for (const fmu::Version version : {fmu::Version::kFmi2, fmu::Version::kFmi3}) {
    const support::TemporaryFolder folder;
    fmu::ExportOptions car;
    car.vehicle_path = places::source() + "/vehicles/open_wheel/vehicle.yaml";
    car.binary_path = places::kerbstone_car();
    car.version = version;
    folder.file("car.fmu", fmu::export_unit(car).bytes);
    sim::ServeOptions options;
    options.socket_path = folder.path("s");
    options.commands = {"input.steering", "input.throttle", "input.gear"};
    options.measurements = {"car.x", "car.y", "car.yaw", "car.vx"};
    options.starts = {{"start.speed", "30"}, {"input.gear", "3"}};
    options.stop_s = 20.0;
    options.lockstep = true;
    options.every = 20;
    std::thread drives([&] {
      Asker ask(options.socket_path);
      const auto swerve = [&] {
        Told out;
        for (int k = 0; k < 30; ++k)
          out.push_back(ask({{"set",
                              {{"input.steering", 0.02 * std::sin(0.3 * k)},
                               {"input.throttle", 0.03 * k},
                               {"input.gear", 3 + k / 20}}}}));
        return out;
      };
      swerve();
      ask({{"save", "there"}});
      const Told first = swerve();
      // A teleport: another place and speed, from 0 s.
      const auto moved = base::parse_json<nlohmann::json>(
          ask({{"reset", {{"start.u", 500}, {"start.v", -3}, {"start.speed", 12}}}}).back());
      EXPECT_NEAR(moved.at("values").at("car.x"), 500.0, 1e-9);
      EXPECT_NEAR(moved.at("values").at("car.y"), -3.0, 1e-9);
      EXPECT_NEAR(moved.at("values").at("car.vx"), 12.0, 1e-9);
      EXPECT_EQ(moved.at("time_s"), 0.0);
      swerve();
      ask({{"reset", {{"state", "there"}}}});
      ask(nlohmann::json::object());
      EXPECT_EQ(swerve(), first);
      ask.say({{"end", true}});
    });
    const sim::ServeRun run = sim::serve_unit(folder.path("car.fmu"), options);
    drives.join();
    EXPECT_EQ(run.counts.resets, 2u);
    EXPECT_EQ(run.counts.broken, 0u) << run.first_broken;
  }
}

}  // namespace serve_states_test
