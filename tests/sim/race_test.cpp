// crgsim race: two stacks against each other.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/json_text.h"
#include "sim/dds.h"
#include "support/own_domain.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace race_test {

using ::testing::HasSubstr;

/// Of a table, the column of this name.
std::vector<double> column(const std::string& text, const std::string& name) {
  std::vector<double> out;
  std::istringstream rows(text);
  std::string row, cell;
  std::getline(rows, row);
  std::size_t at = 0;
  for (std::istringstream names(row); std::getline(names, cell, ',') && cell != name;) ++at;
  while (std::getline(rows, row)) {
    std::istringstream cells(row);
    for (std::size_t k = 0; k <= at; ++k) std::getline(cells, cell, ',');
    out.push_back(std::stod(cell));
  }
  return out;
}

/// kerbstone-ring, its line, a car for it, and the example's race.
class Race : public testing::Test {
 protected:
  void SetUp() override {
    sh(fmt::format(R"(mkdir -p race stack
cp {0}/examples/race/*.yaml race; cp {0}/examples/stack/*.yaml stack
{1} synth {0}/tracks/kerbstone-ring/circuit.yaml -o demo --quiet
{1} export demo/kerbstone-ring_truth.crg -o line.csv --quiet
{2} fmu {0}/vehicles/open_wheel/vehicle.yaml --road demo/kerbstone-ring_truth.crg -o race/car.fmu --quiet)",
                   places::source(), places::crgbuild(), places::crgdrive()));
  }

  void sh(const std::string& script) {
    folder_.file("all.sh", fmt::format("set -e; cd '{}'\n{}\n", folder_.path("."), script));
    ASSERT_EQ(std::system(("timeout 250 bash " + folder_.path("all.sh") + " > " +
                           folder_.path("log") + " 2>&1")
                              .c_str()),
              0)
        << folder_.read("log");
  }

  support::TemporaryFolder folder_;
};

/// Of all rows faster than 20 m/s the mean of drag over the square of speed, kg/m.
double mean_drag_kgpm(const std::string& table) {
  const std::vector<double> drag_n = column(table, "car.drag"), vx_mps = column(table, "car.vx");
  double sum = 0.0, rows = 0.0;
  for (std::size_t k = 0; k < vx_mps.size(); ++k) {
    if (vx_mps[k] < 20.0) continue;
    sum += drag_n[k] / (vx_mps[k] * vx_mps[k]);
    ++rows;
  }
  return sum / rows;
}

using SlowRace = Race;

TEST_F(SlowRace, TwoStacksDriveALapAndFeelEachOther) {
  // The same again, with other forms and one that is slower; then blue alone.
  sh(fmt::format(R"(sed '/^  red:/d' race/race.yaml > race/alone.yaml
race() {{ {0} race race/$1.yaml --socket s --lockstep --stop-s 300 -o $2 --json > $2.json & }}
there() {{ for name in "$@"; do until test -S s.$name; do sleep 0.05; done; done; }}
race race first; there red blue
{1} s.red line.csv binary > red.log & {1} s.blue line.csv json > blue.log; wait
race race again; there red blue
{1} s.red line.csv json > red.log & nice -n 19 {1} s.blue line.csv binary > blue.log; wait
race alone alone; there blue
{1} s.blue line.csv binary > alone.log; wait)",
                 places::crgsim(), EXAMPLE_STACK));
  for (const std::string log : {"red.log", "blue.log", "alone.log"})
    EXPECT_THAT(folder_.read(log), HasSubstr("lap in "));
  for (const std::string car : {"red", "blue"})
    EXPECT_EQ(folder_.read("first/" + car + ".csv"), folder_.read("again/" + car + ".csv"));
  const auto told = base::parse_json<nlohmann::json>(folder_.read("first.json")).at("cars");
  EXPECT_EQ(told.at("red").at("ended"), "by a command");
  EXPECT_EQ(told.at("blue").at("safe_steps"), 0);
  const std::string red = folder_.read("first/red.csv"), blue = folder_.read("first/blue.csv"),
                    alone = folder_.read("alone/blue.csv");
  // Sensors of their own: another seed.
  const auto off_m = [](const std::string& table) {
    return column(table, "gnss.x")[0] - column(table, "car.x")[0];
  };
  EXPECT_NE(off_m(red), off_m(blue));
  EXPECT_EQ(off_m(blue), off_m(alone));
  const double behind = mean_drag_kgpm(blue), free = mean_drag_kgpm(alone);
  std::printf("drag behind the other: %.3f of that alone\n", behind / free);
  EXPECT_LT(behind, 0.9 * free);
}

TEST_F(SlowRace, TopicsOfEachCarStandBelowItsName) {
  if (sim::dds_version().empty()) GTEST_SKIP() << "built without Cyclone DDS";
  sh(fmt::format(R"({0} race race/race.yaml --dds --domain {2} --lockstep --stop-s 300 -o topics &
{1} {2} line.csv dds red/ > red.log & {1} {2} line.csv dds blue/ > blue.log; wait
{0} race race/race.yaml --socket s --lockstep --stop-s 300 -o sockets &
until test -S s.red && test -S s.blue; do sleep 0.05; done
{1} s.red line.csv binary & {1} s.blue line.csv binary; wait)",
                 places::crgsim(), EXAMPLE_STACK, places::own_domain()));
  for (const std::string log : {"red.log", "blue.log"})
    EXPECT_THAT(folder_.read(log), HasSubstr("lap in "));
  for (const std::string car : {"red", "blue"}) {
    const std::string topics = folder_.read("topics/" + car + ".csv"),
                      sockets = folder_.read("sockets/" + car + ".csv");
    const std::vector<double> a = column(topics, "car.x"), b = column(sockets, "car.x");
    ASSERT_EQ(a.size(), b.size());
    double apart_m = 0.0;
    for (std::size_t k = 0; k < a.size(); ++k) apart_m = std::max(apart_m, std::abs(a[k] - b[k]));
    EXPECT_LE(apart_m, 1e-6) << "stamps are nanoseconds; alone 2.5e-11 were measured";
  }
}

TEST_F(Race, AStackThatDiesLeavesTheOtherDriving) {
  sh(fmt::format(R"(sed 's/patience_s: 20/patience_s: 2/' race/race.yaml > race/short.yaml
(code=0; {0} race race/short.yaml --socket s --lockstep --stop-s 300 -o out --json > told.json 2> said.txt || code=$?
echo "exit code $code" >> said.txt) &
until test -S s.red && test -S s.blue; do sleep 0.05; done
{1} s.red line.csv binary > red.log & red=$!
{1} s.blue line.csv binary > blue.log & blue=$!
sleep 1; kill -9 $red; wait $blue; wait)",
                 places::crgsim(), EXAMPLE_STACK));
  EXPECT_THAT(folder_.read("blue.log"), HasSubstr("lap in "));
  const std::string said = folder_.read("said.txt");
  EXPECT_THAT(said, HasSubstr("red: no command came any more, and its safe input acted"));
  EXPECT_THAT(said, HasSubstr("exit code 3"));
  const auto told = base::parse_json<nlohmann::json>(folder_.read("told.json")).at("cars");
  EXPECT_EQ(told.at("red").at("ended"), "because no command came");
  EXPECT_GT(told.at("red").at("safe_steps"), 1000);
  EXPECT_EQ(told.at("red").at("steps"), told.at("blue").at("steps"));
  // It brakes and stands.
  EXPECT_LT(std::abs(column(folder_.read("out/red.csv"), "car.vx").back()), 0.1);
}

}  // namespace race_test
