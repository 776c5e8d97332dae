// What crgexplain cannot work with is refused in one line that says what, where and what to do.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <sstream>

#include "base/json_text.h"
#include "explain/mapping.h"
#include "proof.h"
#include "recording/log_table.h"
#include "support/places.h"

namespace refusals_test {

using explain_test::Proof;
using explain_test::unless_heavy;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// A log with one cell of every row, or of the header alone, replaced.
std::string changed(const std::string& log, const std::string& column, const std::string& name,
                    const std::function<std::string(const std::string& cell)>& change = {}) {
  std::string out;
  std::size_t place = 0;
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    std::string made;
    std::size_t k = 0;
    for (std::string cell; std::getline(cells, cell, ','); ++k) {
      if (out.empty() && cell == column)
        place = k, cell = name;
      else if (!out.empty() && k == place && change)
        cell = change(cell);
      made += (k == 0 ? "" : ",") + cell;
    }
    out += made + "\n";
  }
  return out;
}

class Refusals : public ::testing::Test {
 protected:
  void SetUp() override {
    if (proof_ == nullptr) proof_ = new Proof("none");
  }
  static void TearDownTestSuite() { delete proof_; }
  static std::string path(const std::string& file) { return proof_->path(file); }
  static std::string file(const std::string& name, const std::string& text) {
    return proof_->folder.file(name, text);
  }

  /// The one line that refuses; `code` is the exit code. Nothing may be left in the folder of the
  /// result.
  static std::string refused(const std::string& arguments, int code = 1) {
    const std::string log = proof_->folder.path("refusal");
    const int status =
        std::system(fmt::format("{} {} > {} 2>&1", places::crgexplain(), arguments, log).c_str());
    EXPECT_EQ(WEXITSTATUS(status), code) << arguments;
    const std::string said = proof_->folder.read("refusal");
    if (code == 1) {
      EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    }
    EXPECT_FALSE(std::filesystem::exists(proof_->folder.path("out"))) << arguments;
    return said;
  }
  static std::string run(const std::string& recordings, const std::string& more = "") {
    return fmt::format("run --road {} --car {} --log {} -o {} {}", path("track.crg"),
                       path("vehicle.yaml"), recordings, proof_->folder.path("out"), more);
  }

  static Proof* proof_;
};
Proof* Refusals::proof_ = nullptr;

TEST_F(Refusals, RecordingsWithOtherColumns) {
  const std::string other =
      file("other.csv", changed(proof_->folder.read("none/run.csv"), "gear", "gang"));
  for (const std::string& both : {path("run.csv") + " " + other, other + " " + path("run.csv")})
    EXPECT_THAT(refused(run(both)),
                AllOf(HasSubstr("other.csv: no column 'gear', which " + path("run.csv") + " has"),
                      HasSubstr("give --mapping with what all have")));
}

TEST_F(Refusals, OneRecordingTwice) {
  const std::string copy = file("copy.csv", proof_->folder.read("none/run.csv"));
  EXPECT_THAT(refused(run(path("run.csv") + " " + copy)),
              HasSubstr("copy.csv: the same recording as " + path("run.csv")));
}

TEST_F(Refusals, MappingsOfColumnsThatAreNotThere) {
  const std::string gyro = file(
      "gyro.yaml", "columns:\n  time_s: {channel: time_s}\n  gyro: {channel: yaw_rate_radps}\n");
  EXPECT_THAT(
      refused(run(path("run.csv"), "--mapping " + gyro)),
      AllOf(HasSubstr("run.csv: no column 'gyro', which " + gyro + " takes for yaw_rate_radps"),
            HasSubstr("'yaw_rate_radps', 'ax_mps2'")));
  const std::string timeless = file("timeless.yaml", "columns:\n  x_m: {channel: x_m}\n");
  EXPECT_THAT(refused(run(path("run.csv"), "--mapping " + timeless)),
              HasSubstr(timeless + " takes no column for time_s"));
  EXPECT_THAT(refused(run(path("run.csv"), "--mapping " + file("empty.yaml", ""))),
              HasSubstr("empty.yaml: is empty, wanted a mapping"));
}

TEST_F(Refusals, LapsThatCannotBeHeldOut) {
  EXPECT_THAT(refused(run(path("run.csv"), "--hold-out 1,77")),
              HasSubstr("--hold-out 77: no such lap; these recordings have laps 0 to 4"));
  EXPECT_THAT(refused(run(path("run.csv"), "--hold-out 0,1,2,3,4")),
              HasSubstr("all laps that there are"));
  for (const char* nonsense : {"-1", "x"})
    EXPECT_THAT(refused(run(path("run.csv"), std::string("--hold-out ") + nonsense), 2),
                HasSubstr("--hold-out"));
}

TEST_F(Refusals, FoldersThatCannotBeMade) {
  const std::string taken = file("taken", "text");
  for (const std::string& place : {taken, taken + "/below"})
    EXPECT_THAT(refused(fmt::format("run --road {} --car {} --log {} -o {}", path("track.crg"),
                                    path("vehicle.yaml"), path("run.csv"), place)),
                HasSubstr(place + ": cannot make this folder: Not a directory"));
  EXPECT_EQ(proof_->folder.read("taken"), "text");
}

TEST_F(Refusals, FilesInThePlaceOfOthers) {
  EXPECT_THAT(refused(run(path("run.csv"), "--grip " + path("track.crg"))),
              AllOf(HasSubstr("track.crg: a grip factor of "), HasSubstr("wanted 0 to 3")));
  const std::string rest = " --log " + path("run.csv") + " -o " + proof_->folder.path("out");
  EXPECT_THAT(refused("run --road " + path("run.csv") + " --car " + path("vehicle.yaml") + rest),
              HasSubstr("run.csv: no $KD_DEFINITION"));
  EXPECT_THAT(refused("run --road " + path("track.crg") + " --car " + path("track.crg") + rest),
              HasSubstr("track.crg:"));
  EXPECT_THAT(refused(run(path("."))), HasSubstr("a folder without metadata.yaml"));
  EXPECT_THAT(refused(run(file("empty.csv", ""))),
              HasSubstr("empty.csv: no header line with column names"));
  EXPECT_THAT(refused(run(file("bytes.csv", "time_s,\x1b[2J\n1,2,3\n"))), Not(HasSubstr("\x1b")));
}

TEST_F(Refusals, AMappingInThePlaceOfItsLog) {
  const std::string log = proof_->folder.read("none/run.csv"), copy = file("log.csv", log);
  EXPECT_THAT(refused(fmt::format("map {0} -o {0}", copy)),
              HasSubstr("log.csv: is the log, and -o would overwrite it"));
  EXPECT_EQ(proof_->folder.read("log.csv"), log);
}

TEST_F(Refusals, AMappingOfALogWithoutAClock) {
  std::string rows = "time,speed [km/h]\n";
  for (int i = 0; i < 60; ++i) rows += fmt::format("day {},100\n", i);
  const std::string log = file("day.csv", rows);
  EXPECT_THAT(
      refused(fmt::format("map {} -o mapping.yaml", log)),
      HasSubstr("day.csv: the clock, column 'time', holds no number in any of its 60 rows"));
  EXPECT_FALSE(std::filesystem::exists("mapping.yaml"));
}

TEST_F(Refusals, WordsThatAreNoCommand) {
  EXPECT_THAT(refused("explain", 2), HasSubstr("there is no command 'explain'"));
}

/// A table as loggers write it: semicolons, words, a last line that was cut off.
TEST(LogsOfOthers, AreReadAsTheyAre) {
  Proof proof("none", 2);
  std::string one_lap = proof.folder.read("none/run.csv");
  std::size_t end = 0;
  for (int line = 0; line < 2301; ++line) end = one_lap.find('\n', end) + 1;
  one_lap.resize(end);
  std::size_t row = 0;
  std::string log = changed(one_lap, "gear", "gear",
                            [&](const std::string& cell) { return row++ % 100 == 7 ? "N" : cell; });
  std::replace(log.begin(), log.end(), ',', ';');
  proof.folder.file("none/loggers.csv", log + "300.1;2");
  const auto all = proof.explain("loggers.csv", "out", "--skip-simulation --nulls 100");
  EXPECT_EQ(all.at("verdict"), "none");
  EXPECT_THAT(
      base::dump_json(all.at("remarks")),
      HasSubstr(fmt::format("loggers.csv: {} of {} cells of 'gear' are no numbers: taken as empty",
                            (row + 92) / 100, row)));
  // With decimal commas it is the same log.
  std::replace(log.begin(), log.end(), '.', ',');
  proof.folder.file("none/commas.csv", log + "300,1;2");
  const recording::Table points = recording::read_log_table(proof.path("loggers.csv")),
                         commas = recording::read_log_table(proof.path("commas.csv"));
  EXPECT_EQ(commas.names, points.names);
  ASSERT_EQ(commas.columns.size(), points.columns.size());
  for (std::size_t k = 0; k < points.columns.size(); ++k)
    EXPECT_TRUE(std::equal(points.columns[k].begin(), points.columns[k].end(),
                           commas.columns[k].begin(), commas.columns[k].end(),
                           [](double a, double b) { return a == b || (a != a && b != b); }))
        << points.names[k];
}

/// A column that repeats its samples in one of two recordings counts as repeating in the mapping
/// for both.
TEST(SlowTwoRecordings, HaveOneMapping) {
  Proof proof("alike-apart", unless_heavy(2));
  std::string last;
  std::size_t row = 0;
  const std::string held =
      changed(proof.folder.read("alike-apart/run.csv"), "ax_mps2", "ax_mps2",
              [&](const std::string& cell) { return row++ % 2 == 0 ? last = cell : last; });
  proof.folder.file("alike-apart/held.csv", held);
  const auto all = proof.explain("held.csv experiment.csv");
  EXPECT_EQ(explain_test::finding(all, "sensor.delay").at("channel"), "yaw_rate_radps");
  const std::string notes = base::dump_json(all.at("remarks"));
  EXPECT_THAT(notes, HasSubstr("held.csv: 'ax_mps2': 50 % of the samples repeat"));
  const explain::Mapping mapping =
      explain::Mapping{recording::read_mapping(proof.folder.path("out/mapping.yaml")), {}, {}, {}};
  for (const auto& m : mapping.columns) EXPECT_EQ(m.held, m.channel == "ax_mps2") << m.channel;
}

}  // namespace refusals_test
