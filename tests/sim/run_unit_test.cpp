#include "sim/run_unit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "base/error.h"
#include "some_unit.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/run_tool.h"

namespace run_unit_test {

using sim_tests::description_2, sim_tests::description_3, sim_tests::scalar_2, sim_tests::value_3,
    sim_tests::write_unit;
using ::testing::HasSubstr, ::testing::StartsWith;

std::string refusal(const std::string& path, const sim::UnitRunOptions& options = {}) {
  try {
    sim::run_unit(path, options);
  } catch (const base::Error& error) {
    return error.what();
  }
  return "";
}

double last(const sim::UnitRun& run, std::size_t column) {
  return run.values[(run.rows() - 1) * run.columns.size() + column];
}

const std::string kDecay2 =
    description_2("decay", scalar_2("x", 1, "output") + scalar_2("der(x)", 2, "output") +
                               scalar_2("k", 3, "parameter"));
const std::string kDecay3 = description_3("decay", value_3("Float64", "x", 1, "output") +
                                                       value_3("Float64", "der(x)", 2, "output") +
                                                       value_3("Float64", "k", 3, "parameter"));

TEST(RunUnit, ADecayDecaysInBothVersions) {
  const support::TemporaryFolder folder;
  for (const int version : {2, 3}) {
    SCOPED_TRACE(version);
    sim::UnitRunOptions options;
    options.starts = {{"k", "2"}};
    const sim::UnitRun run =
        sim::run_unit(write_unit(folder, version == 2 ? kDecay2 : kDecay3, version), options);
    EXPECT_THAT(run.columns, testing::ElementsAre("time_s", "x", "der(x)"));
    ASSERT_EQ(run.rows(), 301u);
    EXPECT_DOUBLE_EQ(run.values[1], 1.0);
    EXPECT_NEAR(last(run, 0), 3.0, 1e-12);
    // Euler's steps of 0.1 ms err by 3 s * 1e-4 s * k^2 / 2 of it.
    EXPECT_NEAR(last(run, 1) / std::exp(-6.0), 1.0, 7e-4);
    EXPECT_DOUBLE_EQ(last(run, 2), -2.0 * last(run, 1));
  }
}

TEST(RunUnit, ABallBouncesAndRests) {
  const support::TemporaryFolder folder;
  const std::string variables =
      scalar_2("h", 1, "output") + scalar_2("v", 2, "output") + scalar_2("g", 3, "parameter");
  const sim::UnitRun run =
      sim::run_unit(write_unit(folder, description_2("ball", variables), 2), {});
  double lowest_until_s = 0.0, lowest = 1.0, highest_again = 0.0;
  for (std::size_t i = 0; i < run.rows(); ++i) {
    const double t = run.values[3 * i], h = run.values[3 * i + 1];
    if (t < 0.6 && h < lowest) lowest = h, lowest_until_s = t;
    if (t > 0.5 && t < 1.0) highest_again = std::max(highest_again, h);
  }
  EXPECT_NEAR(lowest_until_s, std::sqrt(2.0 / 9.81), 0.011);
  EXPECT_NEAR(highest_again, 0.49, 0.005);  // 0.7^2 of 1 m
  EXPECT_EQ(last(run, 1), 0.0);
}

TEST(RunUnit, EveryTypeIsPassedThrough) {
  const support::TemporaryFolder folder;
  const std::vector<std::pair<const char*, double>> types{
      {"Float64", 0.1}, {"Float32", 0.25}, {"Int8", -100},
      {"UInt8", 200},   {"Int16", -30000}, {"UInt16", 60000},
      {"Int32", -2e9},  {"UInt32", 4e9},   {"Int64", -9007199254740992.0},
      {"Boolean", 1}};
  std::string variables;
  sim::UnitRunOptions options;
  options.stop_s = 0.02;
  options.inputs.time_s = {0.0};
  int reference = 10;
  for (const auto& [type, value] : types) {
    variables += value_3(type, fmt::format("{}_in", type), reference, "input") +
                 value_3(type, fmt::format("{}_out", type), reference + 10, "output");
    ++reference;
    options.inputs.names.push_back(fmt::format("{}_in", type));
    options.inputs.values.push_back(value);
  }
  const std::string unit = write_unit(folder, description_3("through", variables), 3);
  const sim::UnitRun run = sim::run_unit(unit, options);
  for (std::size_t k = 0; k < types.size(); ++k)
    EXPECT_EQ(last(run, k + 1), types[k].second) << types[k].first;
  options.inputs.values[2] = 200;
  EXPECT_THAT(refusal(unit, options), HasSubstr("200 for Int8_in; -128 to 127 wanted"));
}

TEST(RunUnit, InputsRunBetweenRowsOrAreHeldAndArraysAreNamedByPlace) {
  const support::TemporaryFolder folder;
  const std::string unit =
      write_unit(folder,
                 description_3("through", value_3("Float64", "a", 10, "input", 2) +
                                              value_3("Int32", "n", 12, "input") +
                                              value_3("Float64", "b", 20, "output", 2) +
                                              value_3("Int32", "m", 22, "output")),
                 3);
  sim::UnitRunOptions options;
  options.step_s = 0.25;
  options.stop_s = 1.0;
  options.inputs = {{"a[2]", "n"}, {0.0, 1.0}, {0.0, 1.0, 4.0, 9.0}};
  const sim::UnitRun run = sim::run_unit(unit, options);
  EXPECT_THAT(run.columns, testing::ElementsAre("time_s", "b[1]", "b[2]", "m"));
  // After a step what was set at its begin stands.
  EXPECT_THAT(run.values, testing::ElementsAre(0, 0, 0, 1, 0.25, 0, 0, 1, 0.5, 0, 1, 1, 0.75, 0, 2,
                                               1, 1, 0, 3, 1));
  options.inputs.names[0] = "a[3]";
  EXPECT_THAT(refusal(unit, options), HasSubstr("no variable 'a[3]'"));
  options.inputs.names[0] = "b[1]";
  EXPECT_THAT(refusal(unit, options), HasSubstr("b[1] is no input of the unit"));
}

TEST(RunUnit, TheToleranceOfTheDefaultExperimentIsHandedOn) {
  const support::TemporaryFolder folder;
  for (const int version : {2, 3})
    for (const double tolerance : {1e-5, -1.0}) {
      std::string xml = version == 2
                            ? description_2("through", scalar_2("t", 30, "output"))
                            : description_3("through", value_3("Float64", "t", 30, "output"));
      const std::string step = "stepSize=\"0.01\"";
      if (tolerance > 0.0) xml.insert(xml.find(step), "tolerance=\"1e-5\" ");
      const sim::UnitRun run = sim::run_unit(write_unit(folder, xml, version), {});
      EXPECT_EQ(run.values[1], tolerance) << version;
    }
}

TEST(RunUnit, AnOutputThatIsNoNumberIsSaid) {
  const support::TemporaryFolder folder;
  const std::string unit =
      write_unit(folder, description_2("through", scalar_2("far", 31, "output")), 2);
  sim::UnitRunOptions options;
  options.step_s = 0.125;
  EXPECT_EQ(sim::run_unit(unit, options).not_finite, "far is inf at 0.5 s");
  options.stop_s = 0.25;
  EXPECT_EQ(sim::run_unit(unit, options).not_finite, "");
  const support::ToolRun told = support::run_tool(
      places::crgsim(), {"run", unit, "--step-s", "0.125", "-o", folder.path("out.csv")});
  EXPECT_EQ(told.code, 3);
  EXPECT_THAT(told.err, HasSubstr("far is inf at 0.5 s"));
}

TEST(RunUnit, ColumnsWithOneNameTwiceAreRefused) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(
      folder,
      description_2("through", scalar_2("time_s", 0, "output") + scalar_2("b", 20, "output")), 2);
  sim::UnitRunOptions options;
  EXPECT_THAT(refusal(unit), HasSubstr("two columns time_s; time_s is its own"));
  options.record = {"b"};
  EXPECT_EQ(refusal(unit, options), "");
  options.record = {"b", "b"};
  EXPECT_THAT(refusal(unit, options), HasSubstr("two columns b"));
}

TEST(RunUnit, MisbehaviourIsOneLine) {
  const support::TemporaryFolder folder;
  const auto said = [&](const std::string& kind) {
    return refusal(write_unit(folder, description_2(kind, scalar_2("t", 0, "output")), 2));
  };
  EXPECT_THAT(said("crashes"), HasSubstr("the unit crashed after 0.45 s (signal 11: Segm"));
  EXPECT_THAT(said("leaves"),
              HasSubstr("crashed after 0.45 s (it ended its process with exit code 3)"));
  EXPECT_THAT(said("errs"), HasSubstr("the step of 0.01 s at 0.45 s: error from the unit"));
  EXPECT_THAT(said("another"),
              HasSubstr("cannot be instantiated; it says: 'another' is not my guid"));
  // A model description that lies: of the values, of the functions, of the binary.
  EXPECT_THAT(refusal(write_unit(folder, description_2("decay", scalar_2("y", 77, "output")), 2)),
              HasSubstr("reading y: error from the unit"));
  EXPECT_THAT(refusal(write_unit(folder, kDecay3, 3, {}, SIM_UNIT_2)),
              HasSubstr("lacks functions of the standard: fmi3InstantiateCoSimulation, "));
  folder.file("text.so", "no library");
  EXPECT_THAT(refusal(write_unit(folder, kDecay2, 2, {}, folder.path("text.so").c_str())),
              HasSubstr("its binary cannot be loaded"));
  folder.file("unit.fmu", fmu::make_archive({{"modelDescription.xml", kDecay2},
                                             {"binaries/win64/some.dll", "MZ"}}));
  EXPECT_THAT(refusal(folder.path("unit.fmu")), HasSubstr("no binary for Linux on x86-64"));
  EXPECT_THAT(
      refusal(write_unit(folder, description_2("decay", "", R"( needsExecutionTool="true")"), 2)),
      HasSubstr("needs the tool that made it"));
  const std::string unit =
      write_unit(folder, description_3("ends", value_3("Float64", "t", 0, "output")), 3);
  const sim::UnitRun ended = sim::run_unit(unit, {});
  EXPECT_TRUE(ended.ended_early);
  EXPECT_NEAR(last(ended, 0), 0.46, 1e-9);
}

TEST(RunUnit, WhatAUnitPrintsIsNotInTheTableAndNothingIsLeftBehind) {
  const support::TemporaryFolder folder;
  const std::string unit =
      write_unit(folder, description_2("prints", scalar_2("t", 0, "output")), 2);
  std::filesystem::create_directories(folder.path("tmp"));
  ::setenv("TMPDIR", folder.path("tmp").c_str(), 1);
  const support::ToolRun ran = support::run_tool(places::crgsim(), {"run", unit, "-o", "-"});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, StartsWith("time_s,t\n0,0\n0.01,0.01\n"));
  EXPECT_THAT(ran.err, HasSubstr("said on standard output"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path("tmp")));
  ::unsetenv("TMPDIR");
}

TEST(RunUnit, InputsWithOneNameTwiceAreRefused) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(
      folder, description_2("through", scalar_2("a", 10, "input") + scalar_2("b", 20, "output")),
      2);
  const std::string table = folder.file("in.csv", "time_s,a,a\n0,1,2\n");
  const support::ToolRun ran = support::run_tool(
      places::crgsim(), {"run", unit, "--inputs", table, "-o", folder.path("out.csv")});
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.err, HasSubstr("in.csv:1: two columns are called 'a'; take one away"));
}

TEST(RunUnit, DecimalCommasOfInputsAreReadOrRefused) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(
      folder, description_2("through", scalar_2("a", 10, "input") + scalar_2("b", 20, "output")),
      2);
  const auto ran_with = [&](const std::string& text) {
    return support::run_tool(places::crgsim(),
                             {"run", unit, "--inputs", folder.file("in.csv", text), "--record", "a",
                              "--stop-s", "0", "-o", "-"});
  };
  const support::ToolRun read = ran_with("\xEF\xBB\xBFtime_s;a\r\n0;0,05\r\n");
  EXPECT_EQ(read.code, 0) << read.err;
  EXPECT_EQ(read.out, "time_s,a\n0,0.05\n");
  const support::ToolRun refused = ran_with("time_s,a\n0,0,05\n");
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, testing::AllOf(HasSubstr("in.csv:2: '0,0,05' has 3 cells"),
                                          HasSubstr("decimal commas")));
}

TEST(RunUnit, TheCarIsDrivenByInputsAsByItsOwnTool) {
  const support::TemporaryFolder folder;
  const support::ToolRun made = support::run_tool(
      places::crgdrive(), {"fmu", places::source() + "/vehicles/open_wheel/vehicle.yaml", "--fmi",
                           "3", "-o", folder.path("car.fmu")});
  ASSERT_EQ(made.code, 0) << made.err;
  sim::UnitRunOptions options;
  options.starts = {{"start.speed", "20"}, {"input.gear", "2"}};
  options.stop_s = 1.0;
  options.record = {"car.vx", "wheel.fz"};
  options.inputs = {{"input.brake[1]", "input.brake[2]"}, {0.0}, {1e6, 1e6}};
  const sim::UnitRun run = sim::run_unit(folder.path("car.fmu"), options);
  EXPECT_THAT(run.columns, testing::ElementsAre("time_s", "car.vx", "wheel.fz[1]", "wheel.fz[2]",
                                                "wheel.fz[3]", "wheel.fz[4]"));
  options.inputs = {};
  const sim::UnitRun rolling = sim::run_unit(folder.path("car.fmu"), options);
  EXPECT_GT(last(rolling, 1), 18.5);
  EXPECT_LT(last(run, 1), last(rolling, 1) - 2.0) << "front brakes slow it";
}

/// Against the importer of the FMI reference units, where it lies beside the checkout.
TEST(RunUnit, TheCarAsAnotherImporterRunsIt) {
  const std::string other = places::data() + "/../tools/fmusim";
  if (std::getenv("KERBSTONE_HEAVY") == nullptr) GTEST_SKIP() << "KERBSTONE_HEAVY=1";
  if (!std::filesystem::exists(other)) GTEST_SKIP() << other << " is not there";
  const support::TemporaryFolder folder;
  const std::string unit = folder.path("car.fmu");
  ASSERT_EQ(
      support::run_tool(places::crgdrive(),
                        {"fmu", places::source() + "/vehicles/open_wheel/vehicle.yaml", "-o", unit})
          .code,
      0);
  sim::UnitRunOptions options;
  options.starts = {{"start.speed", "20"}, {"input.gear", "2"}};
  options.stop_s = 2.0;
  options.inputs.names = {"input.throttle", "input.steering", "input.gear"};
  std::string table = "time,input.throttle,input.steering,input.gear\n";
  for (int k = 0; k <= 200; ++k) {
    const double t = 0.01 * k, throttle = 0.3 + 0.2 * std::sin(3 * t),
                 steering = 0.05 * std::sin(2 * t);
    options.inputs.time_s.push_back(t);
    options.inputs.values.insert(options.inputs.values.end(), {throttle, steering, 2.0});
    table += fmt::format("{},{},{},2\n", t, throttle, steering);
  }
  folder.file("in.csv", table);
  const sim::UnitRun run = sim::run_unit(unit, options);
  ASSERT_EQ(
      support::run_tool(
          other, {"--interface-type", "cs", "--input-file", folder.path("in.csv"), "--start-value",
                  "start.speed", "20", "--start-value", "input.gear", "2", "--stop-time", "2",
                  "--output-interval", "0.001", "--output-file", folder.path("out.csv"), unit})
          .code,
      0);
  std::istringstream rows(folder.read("out.csv"));
  std::string row, cell;
  std::getline(rows, row);
  double worst = 0.0;
  std::size_t values = 0;
  for (std::size_t i = 0; std::getline(rows, row) && i < run.rows(); ++i) {
    std::istringstream cells(row);
    for (std::size_t k = 0; std::getline(cells, cell, ',') && k < run.columns.size();
         ++k, ++values) {
      const double theirs = std::stod(cell), ours = run.values[i * run.columns.size() + k];
      worst = std::max(worst, std::abs(ours - theirs) / std::max(1.0, std::abs(theirs)));
    }
  }
  EXPECT_EQ(values, run.values.size());
  EXPECT_LT(worst, 1e-12);
  support::figure("outputs", static_cast<double>(run.columns.size()));
  support::figure("largest_share", worst);
}

}  // namespace run_unit_test
