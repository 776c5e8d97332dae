// A vehicle file in the place of a unit.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/read_file.h"
#include "fmu/export_unit.h"
#include "sim/run_unit.h"
#include "sim/serve_unit.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"
#include "unit_driver.h"

namespace own_car_test {

using ::testing::HasSubstr;

std::string vehicle() { return places::source() + "/vehicles/open_wheel/vehicle.yaml"; }

/// A bend of 80 m radius that rises, 12 m wide.
void write_bend(const std::string& path) {
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = 0.5;
  for (int j = -24; j <= 24; ++j) grid.v_m.push_back(0.25 * j);
  for (int i = 0; i <= 400; ++i) {
    const double turned_rad = 0.5 * i / 80.0;
    line.x_m.push_back(100.0 + 80.0 * std::sin(turned_rad));
    line.y_m.push_back(80.0 * (1.0 - std::cos(turned_rad)));
    line.heading_rad.push_back(turned_rad);
    for (const double v_m : grid.v_m)
      grid.z_m.push_back(static_cast<float>(0.3 * std::sin(0.02 * i) + 0.03 * v_m));
  }
  crg::write(crg::make_crg(line, grid), path, crg::Format::KRBI);
}

std::string write_unit(const support::TemporaryFolder& folder, const std::string& road) {
  fmu::ExportOptions options;
  options.vehicle_path = vehicle();
  options.road_path = road;
  options.binary_path = places::kerbstone_car();
  folder.file("car.fmu", fmu::export_unit(options).bytes);
  return folder.path("car.fmu");
}

sim::UnitRunOptions swerve() {
  sim::UnitRunOptions options;
  options.starts = {{"start.speed", "20"}, {"input.gear", "2"}};
  options.inputs.names = {"input.steering", "input.throttle", "input.brake.fl"};
  for (int k = 0; k <= 20; ++k) {
    options.inputs.time_s.push_back(0.25 * k);
    for (const double value : {0.02 * std::sin(0.9 * k), 0.02 * k, k == 12 ? 1e6 : 0.0})
      options.inputs.values.push_back(value);
  }
  options.stop_s = 5.0;
  return options;
}

TEST(OwnCar, IsWhatTheUnitIsOnThePlaneAndOnARoad) {
  const support::TemporaryFolder folder;
  write_bend(folder.path("bend.crg"));
  for (const std::string& road : {std::string(), folder.path("bend.crg")}) {
    const std::string unit = write_unit(folder, road);
    sim::UnitRunOptions options = swerve();
    const sim::UnitRun exported = sim::run_unit(unit, options);
    if (!road.empty()) options.starts.insert(options.starts.begin(), {"road", road});
    const sim::UnitRun own = sim::run_unit(vehicle(), options);
    EXPECT_EQ(own.columns, exported.columns);
    ASSERT_EQ(own.values.size(), exported.values.size());
    EXPECT_EQ(own.rows(), 5001u);
    double largest = 0.0, sum = 0.0;
    for (std::size_t k = 0; k < own.values.size(); ++k) {
      const double is = own.values[k], wanted = exported.values[k];
      if (std::isnan(is) && std::isnan(wanted)) continue;
      largest = std::max(largest, std::abs(is - wanted) / std::max(1.0, std::abs(wanted)));
      sum += std::abs(wanted);
    }
    EXPECT_LE(largest, 1e-12) << road;
    EXPECT_GT(sum, 0.0);
  }
}

TEST(OwnCar, IsServedAndSavesItsState) {
  const support::TemporaryFolder folder;
  sim::ServeOptions options;
  options.socket_path = folder.path("s");
  options.commands = {"input.throttle"};
  options.measurements = {"car.x", "car.vx"};
  options.starts = {{"start.speed", "30"}, {"input.gear", "3"}};
  options.lockstep = true;
  std::thread drives([&] {
    const sim_tests::Driver driver(options.socket_path);
    const auto values = [&](const std::string& text) {
      driver.say(text);
      return driver.hear().at("values");
    };
    values(R"({"sequence": 1, "set": {"input.throttle": 0.5}})");
    const auto first = values(R"({"sequence": 2, "save": "here"})");
    const auto second = values(R"({"sequence": 3})");
    EXPECT_NE(first, second);
    values(R"({"sequence": 4, "reset": {}})");
    values(R"({"sequence": 5, "reset": {"state": "here"}})");
    EXPECT_EQ(values(R"({"sequence": 6})"), first);
    EXPECT_EQ(values(R"({"sequence": 7})"), second);
    driver.say(R"({"sequence": 8, "end": true})");
  });
  const sim::ServeRun run = sim::serve_unit(vehicle(), options);
  drives.join();
  EXPECT_EQ(run.counts.broken, 0u) << run.first_broken;
  EXPECT_EQ(run.counts.resets, 2u);
}

/// The rows of one column.
std::vector<double> column(const sim::ServeRun& run, const std::string& name) {
  const auto at = std::find(run.columns.begin(), run.columns.end(), name) - run.columns.begin();
  std::vector<double> out;
  for (std::size_t k = static_cast<std::size_t>(at); k < run.values.size(); k += run.columns.size())
    out.push_back(run.values[k]);
  return out;
}

TEST(OwnCar, TwoRaceAndSeeEachOther) {
  const support::TemporaryFolder folder;
  std::vector<sim::ServedUnit> cars{{"red", vehicle(), {}}, {"blue", vehicle(), {}}};
  std::vector<std::thread> drivers;
  for (sim::ServedUnit& car : cars) {
    sim::ServeOptions& options = car.options;
    options.socket_path = folder.path(car.name);
    options.commands = {"input.throttle"};
    options.measurements = {"car.x", "input.opponent[1].active", "input.opponent[1].x"};
    options.starts = {{"start.speed", "30"}, {"input.gear", "3"}};
    if (car.name == "red") options.starts.emplace_back("start.u", "20");
    options.lockstep = true;
    options.every = 1;
  }
  for (const sim::ServedUnit& car : cars)
    drivers.emplace_back([path = car.options.socket_path] {
      const sim_tests::Driver driver(path);
      for (int k = 1; k <= 20; ++k) {
        driver.say(fmt::format(R"({{"sequence": {}}})", k));
        EXPECT_EQ(driver.hear().at("sequence"), k);
      }
      driver.say(R"({"sequence": 21, "end": true})");
    });
  const std::vector<sim::ServeRun> runs = sim::serve_units(cars);
  for (std::thread& driver : drivers) driver.join();
  ASSERT_EQ(runs.size(), 2u);
  const auto red_x = column(runs[0], "car.x"), seen_x = column(runs[1], "input.opponent[1].x"),
             sees = column(runs[1], "input.opponent[1].active");
  ASSERT_EQ(seen_x.size(), 21u);
  EXPECT_EQ(red_x.front(), 20.0);
  EXPECT_NEAR(red_x.back(), 20.6, 0.01);
  for (std::size_t row = 1; row < seen_x.size(); ++row) {
    EXPECT_EQ(sees[row], 1.0);
    EXPECT_EQ(seen_x[row], red_x[row - 1]);
  }
}

TEST(OwnCar, TheToolTakesItWithARoad) {
  const support::TemporaryFolder folder;
  write_bend(folder.path("bend.crg"));
  const auto run = support::run_tool(
      places::crgsim(), {"run", vehicle(), "--road", folder.path("bend.crg"), "--stop-s", "0.1",
                         "--record", "car.x", "-o", folder.path("out.csv")});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(folder.read("out.csv"), testing::StartsWith("time_s,car.x\n0,10"))
      << "it begins where the road does, its wheels on it";
  const auto unit =
      support::run_tool(places::crgsim(), {"run", write_unit(folder, ""), "--road",
                                           folder.path("bend.crg"), "-o", folder.path("out.csv")});
  EXPECT_EQ(unit.code, 2);
  EXPECT_THAT(unit.err, HasSubstr("--set road="));
  const auto info = support::run_tool(places::crgsim(), {"info", vehicle()});
  EXPECT_EQ(info.code, 0);
  EXPECT_THAT(info.out, HasSubstr("input.steering"));
}

/// A straight with a ledge of 5 cm up, 20 m from its begin.
std::string write_ledge(const support::TemporaryFolder& folder) {
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = 0.05;
  grid.v_m = {-4, -2, 0, 2, 4};
  for (int i = 0; i <= 1200; ++i) {
    line.x_m.push_back(0.05 * i), line.y_m.push_back(0.0), line.heading_rad.push_back(0.0);
    grid.z_m.insert(grid.z_m.end(), 5, i >= 400 ? 0.05f : 0.0f);
  }
  crg::write(crg::make_crg(line, grid), folder.path("ledge.crg"), crg::Format::KRBI);
  return folder.path("ledge.crg");
}

const auto kSaysTheLedge =
    ::testing::AllOf(::testing::StartsWith("ledges: "),
                     ::testing::ContainsRegex(R"([0-9.]+ kJ\) at u = (19|20)\.)"));

// By a vehicle file and by units of both versions; a road without a ledge is said nothing of.
TEST(OwnCar, SaysWhereALedgeHeldBackEnergy) {
  const support::TemporaryFolder folder;
  const std::string road = write_ledge(folder);
  sim::UnitRunOptions options;
  options.starts = {{"start.speed", "20"}, {"input.gear", "0"}, {"start.u", "10"}};
  options.record = {"car.vx"};
  options.stop_s = 1.0;
  EXPECT_THAT(sim::run_unit(vehicle(), options).log, ::testing::IsEmpty());
  fmu::ExportOptions exported;
  exported.vehicle_path = vehicle();
  exported.road_path = road;
  exported.binary_path = places::kerbstone_car();
  folder.file("2.fmu", fmu::export_unit(exported).bytes);
  exported.version = fmu::Version::kFmi3;
  folder.file("3.fmu", fmu::export_unit(exported).bytes);
  for (const std::string& unit : {folder.path("2.fmu"), folder.path("3.fmu"), vehicle()}) {
    if (unit == vehicle()) options.starts.insert(options.starts.begin(), {"road", road});
    EXPECT_THAT(sim::run_unit(unit, options).log, ::testing::ElementsAre(kSaysTheLedge)) << unit;
  }
  options.starts.emplace_back("parameter.environment.gravity_mps2", "0");
  options.starts.emplace_back("term.aero_downforce", "0");
  options.stop_s = 60.0;  // it flies away
  EXPECT_THAT([&] { sim::run_unit(vehicle(), options); },
              ::testing::ThrowsMessage<base::Error>(
                  ::testing::ContainsRegex("; the unit says: ledges: .* kJ")));
}

// Served: each run until a reset says its own, at its end and in what is kept of the run.
TEST(OwnCar, SaysLedgesOfEachRunThatIsServed) {
  const support::TemporaryFolder folder;
  sim::ServeOptions options;
  options.socket_path = folder.path("s");
  options.commands = {"input.throttle"};
  options.measurements = {"car.x"};
  options.starts = {
      {"road", write_ledge(folder)}, {"start.speed", "20"}, {"input.gear", "0"}, {"start.u", "10"}};
  options.lockstep = true;
  options.every = 1000;
  std::vector<std::string> remarks;
  options.keep_remark = [&](std::string_view line) { remarks.emplace_back(line); };
  std::thread drives([&] {
    const sim_tests::Driver driver(options.socket_path);
    for (const char* const text :
         {R"({"sequence": 1})", R"({"sequence": 2, "reset": {}})", R"({"sequence": 3})"}) {
      driver.say(text);
      driver.hear();
    }
    driver.say(R"({"sequence": 4, "end": true})");
  });
  const sim::ServeRun run = sim::serve_unit(vehicle(), options);
  drives.join();
  EXPECT_THAT(run.log, ::testing::ElementsAre(kSaysTheLedge, kSaysTheLedge));
  EXPECT_THAT(remarks, ::testing::ElementsAre(HasSubstr(R"({"said":"ledges: )"),
                                              HasSubstr(R"({"said":"ledges: )")));
}

TEST(OwnCar, RefusesInOneLineAsAUnitDoes) {
  const support::TemporaryFolder folder;
  const auto refusal = [](const std::string& path, const sim::UnitRunOptions& options) {
    try {
      sim::run_unit(path, options);
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  folder.file("no.yaml", "what: is this\n");
  EXPECT_THAT(refusal(folder.path("no.yaml"), {}), HasSubstr("no.yaml:1"));
  EXPECT_THAT(refusal(folder.path("none.yaml"), {}), HasSubstr("none.yaml"));
  sim::UnitRunOptions options = swerve();
  options.starts.emplace_back("start.speed", "1e9");
  EXPECT_THAT(refusal(vehicle(), options), HasSubstr("start.speed = 1000000000, wanted"));
}

}  // namespace own_car_test
