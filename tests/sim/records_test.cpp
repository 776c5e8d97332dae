// Whatever ends a run, what it drove is in its record.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "some_unit.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"

namespace records_test {

using sim_tests::description_2, sim_tests::scalar_2, sim_tests::write_unit;
using ::testing::HasSubstr;

std::string vehicle() { return places::source() + "/vehicles/open_wheel/vehicle.yaml"; }

/// Time of the last row of a table in which each line has as many cells as the first, and all of
/// them are numbers; -1 where it has none.
double last_whole_row_s(const std::string& text) {
  EXPECT_TRUE(text.ends_with('\n'))
      << text.substr(text.size() - std::min<std::size_t>(text.size(), 80));
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  const auto commas = std::count(line.begin(), line.end(), ',');
  EXPECT_THAT(line, ::testing::StartsWith("time_s,"));
  double last_s = -1.0;
  while (std::getline(lines, line)) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), commas) << line;
    last_s = std::stod(line);
  }
  return last_s;
}

std::vector<std::string> serve_arguments(const support::TemporaryFolder& folder) {
  return {"serve",     vehicle(),
          "--socket",  folder.path("s"),
          "--command", "input.throttle",
          "--measure", "car.x",
          "--every",   "10",
          "--stop-s",  "1000",
          "-o",        folder.path("drive.csv")};
}

TEST(Records, ASignalLeavesWhatWasDriven) {
  for (const int signal : {2, 15}) {
    SCOPED_TRACE(signal);
    const support::TemporaryFolder folder;
    folder.file("drive.csv", "old\n");
    support::ToolOptions after;
    after.signal_after_s = 0.7;
    after.signal = signal;
    const support::ToolRun run = support::run_tool(
        places::crgsim(), {"run", vehicle(), "--stop-s", "1e5", "-o", folder.path("drive.csv")},
        after);
    EXPECT_EQ(run.code, 128 + signal) << run.err;
    EXPECT_GT(last_whole_row_s(folder.read("drive.csv")), 0.01);
    support::run_tool(places::crgsim(), serve_arguments(folder), after);
    const double served_s = last_whole_row_s(folder.read("drive.csv"));
    EXPECT_GT(served_s, 0.05) << "real time, from its begin to the signal";
    EXPECT_LT(served_s, 0.75);
  }
}

TEST(Records, ARaceThatIsInterruptedLeavesTheRecordOfEachCar) {
  const support::TemporaryFolder folder;
  folder.file("race.yaml", fmt::format("each:\n  unit: {}\n  command: [input.throttle]\n  measure: "
                                       "[car.x]\ncars:\n  red: {{}}\n  blue: {{}}\n",
                                       vehicle()));
  support::ToolOptions after;
  after.signal_after_s = 1.0;
  after.signal = 2;
  support::run_tool(
      places::crgsim(),
      {"race", folder.path("race.yaml"), "--socket", folder.path("s"), "-o", folder.path("out")},
      after);
  for (const char* const car : {"out/red.csv", "out/blue.csv"})
    EXPECT_GT(last_whole_row_s(folder.read(car)), 0.05) << car;
}

/// kill -9, and the next run. Gives how far the record was behind the kill, at most.
void kill_and_look(double after_s) {
  const support::TemporaryFolder folder;
  folder.file("drive.csv", "old\n");
  support::ToolOptions after;
  after.signal_after_s = after_s;
  after.signal = 9;
  support::run_tool(places::crgsim(), serve_arguments(folder), after);
  const std::string partial = folder.path("drive.partial.csv");
  if (!std::filesystem::exists(partial)) {
    EXPECT_LT(after_s, 1.0) << "killed before it began to drive";
    return;
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path("drive.csv"))) << "the old one";
  EXPECT_GT(last_whole_row_s(folder.read("drive.partial.csv")), after_s - 1.0);
  std::filesystem::remove(folder.path("s"));
  const support::ToolRun next = support::run_tool(
      places::crgsim(),
      {"run", vehicle(), "--stop-s", "0.01", "--record", "car.x", "-o", folder.path("drive.csv")});
  EXPECT_EQ(next.code, 0) << next.err;
  EXPECT_THAT(next.err, HasSubstr("drive.killed.csv"));
  EXPECT_GT(last_whole_row_s(folder.read("drive.killed.csv")), after_s - 1.0);
  EXPECT_EQ(last_whole_row_s(folder.read("drive.csv")), 0.01);
}

TEST(Records, AfterAKillTheRowsAreThereAndTheNextRunSaysSo) { kill_and_look(0.8); }

TEST(SlowRecords, AHundredKillsLoseLessThanASecond) {
  for (int k = 0; k < 100; ++k) kill_and_look(0.3 + 0.017 * k);
}

TEST(Records, AnErrorOrACrashOfAUnitLeavesItsRows) {
  const support::TemporaryFolder folder;
  for (const char* kind : {"errs", "crashes", "leaves"}) {
    SCOPED_TRACE(kind);
    folder.file("drive.csv", "old\n");
    const std::string unit = write_unit(
        folder, description_2(kind, scalar_2("a", 10, "input") + scalar_2("b", 20, "output")), 2);
    const support::ToolRun run = support::run_tool(
        places::crgsim(), {"run", unit, "--step-s", "0.1", "-o", folder.path("drive.csv")});
    EXPECT_EQ(run.code, 1);
    EXPECT_DOUBLE_EQ(last_whole_row_s(folder.read("drive.csv")), 0.4);
  }
}

TEST(Records, WithoutRemarksThereIsNoFileOfThem) {
  const support::TemporaryFolder folder;
  folder.file("drive.remarks.jsonl", "old\n");
  std::vector<std::string> arguments = serve_arguments(folder);
  arguments[11] = "0.3";
  support::run_tool(places::crgsim(), arguments);
  EXPECT_FALSE(std::filesystem::exists(folder.path("drive.remarks.jsonl"))) << "nothing was said";
}

TEST(Records, EveryNthStepIsRecordedAndTheLast) {
  const support::TemporaryFolder folder;
  const support::ToolRun run = support::run_tool(
      places::crgsim(), {"run", vehicle(), "--stop-s", "0.025", "--record", "car.x", "--every",
                         "10", "-o", folder.path("drive.csv")});
  EXPECT_EQ(run.code, 0) << run.err;
  const std::string text = folder.read("drive.csv");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 5);
  for (const char* const begin : {"\n0,", "\n0.01,", "\n0.02,", "\n0.025,"})
    EXPECT_THAT(text, HasSubstr(begin));
}

}  // namespace records_test
