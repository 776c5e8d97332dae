// Recordings of a simulator that shares nothing with this project, with truths that the tool does
// not see: TUMFTM Open-Car-Dynamics (ocd_trials beside the checkout).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "base/json_text.h"
#include "base/read_file.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/recorded_car.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"

namespace other_simulator_test {

using nlohmann::json;

std::string trials_folder() { return places::data() + "/ocd_trials/"; }

/// The car as its owners state it, in this project's format.
void write_stated_car(const support::TemporaryFolder& folder) {
  const json as_stated{{"mass", 1.0}, {"cog", 1.0},  {"inertia_z", 1.0},
                       {"drag", 1.0}, {"grip", 1.0}, {"cornering_stiffness", 1.0}};
  const support::RecordedCar car = support::recorded_car(trials_folder(), as_stated);
  folder.file("tyre.tir", base::read_file(trials_folder() + "nominal/tyre.tir"));
  const vehicle::Map2& engine = car.files.engine_torque_nm;
  std::string map = "engine_radps:throttle,0,1\n";
  for (std::size_t i = 0; i < engine.x.size(); ++i)
    map += fmt::format("{},{},{}\n", engine.x[i], engine.z[2 * i], engine.z[2 * i + 1]);
  folder.file("engine.csv", map);
  std::string text =
      "name: stated\ntyres: {front: tyre.tir, rear: tyre.tir, alpha: tan, fx_arm: rolling_radius}\n"
      "maps: {engine_torque_nm: engine.csv}\nparameters:\n";
  const auto parameters = vehicle::parameter_list();
  for (std::size_t i = 0; i < parameters.size(); ++i)
    text += fmt::format("  {}: {}\n", parameters[i].name, car.parameters.value[i]);
  text += "terms:\n";
  const auto terms = vehicle::term_list();
  for (std::size_t i = 0; i < terms.size(); ++i)
    text += fmt::format("  {}: {}\n", terms[i].name, car.terms.value[i]);
  folder.file("vehicle.yaml", text);
}

/// Every column under its own name; travel is negative when compressed there.
std::string mapping_of(const std::string& csv) {
  std::istringstream header(csv.substr(0, csv.find_first_of("\r\n")));
  std::string out = "version: 1\ncolumns:\n";
  for (std::string column; std::getline(header, column, ',');)
    out += fmt::format("  \"{0}\": {{channel: {0}{1}}}\n", column,
                       column.starts_with("suspension_") ? ", scale: -1" : "");
  return out;
}

/// `rows`: of the recording, from its beginning on. `from`: the folder of the trials.
json explain(const support::TemporaryFolder& folder, const std::string& from, const json& trial,
             int rows) {
  const std::string id = trial.at("id"), which = trial.at("track");
  const std::string track = "circuit_" + which.substr(which.size() - 1);
  const std::string csv = folder.path(id + ".csv");
  EXPECT_EQ(
      std::system(
          fmt::format("xz -dc '{}{}.csv.xz' | sed {}q > '{}'", from, id, rows + 1, csv).c_str()),
      0);
  const std::string mapping = folder.file(id + ".yaml", mapping_of(base::read_file(csv)));
  if (!std::filesystem::exists(folder.path(track))) {
    const std::string edges = places::data() + "/edges/" + track;
    const support::ToolRun built = support::run_tool(
        places::crgbuild(),
        {"from-edges", edges + "_left.csv", edges + "_right.csv", "-o", folder.path(track)});
    EXPECT_EQ(built.code, 0) << built.err;
  }
  const support::ToolRun ran = support::run_tool(
      places::crgexplain(),
      {"run", "--skip-simulation", "--road", folder.path(track + "/" + track + ".crg"), "--car",
       folder.path("vehicle.yaml"), "--log", csv, "--mapping", mapping, "-o", folder.path(id)});
  EXPECT_EQ(ran.code, 0) << ran.err;
  return base::parse_json<json>(folder.read(id + "/findings.json"));
}

/// What the truth says, and names that the same data would allow as well; the tool's own words.
std::set<std::string> allowed_names(const json& trial) {
  std::set<std::string> names;
  for (const json& effect : trial.at("effects")) names.insert(effect.at("mechanism"));
  if (trial.contains("tie") && trial["tie"].is_array())
    for (const json& others : trial["tie"])
      for (const json& other : others) names.insert(other.get<std::string>());
  if (names.contains("vehicle.mass")) names.insert("parameter.mass");
  if (names.contains("vehicle.aero_downforce")) names.insert("parameter.downforce");
  return names;
}

TEST(SlowOtherSimulator, NothingIsNamedWhereNothingIsMissingAndWhatIsMissingFirst) {
  const std::string truths = trials_folder() + "truth.json";
  if (!std::filesystem::exists(truths)) GTEST_SKIP() << "skipped: " << truths << " is not there";
  // KERBSTONE_HEAVY=1: all twenty-six, whole, a quarter of an hour. Else two laps of one.
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const support::TemporaryFolder folder;
  write_stated_car(folder);
  int nulls = 0, alarms = 0, effects = 0, first = 0, wrong = 0, large = 0, large_first = 0;
  std::vector<std::pair<std::string, json>> trials;
  for (const std::string& from : {trials_folder(), trials_folder() + "more/"}) {
    const json all = base::parse_json<json>(base::read_file(from + "truth.json"));
    for (const json& trial : all.at("trials"))
      if (heavy || trial.at("id") == "t13") trials.emplace_back(from, trial);
  }
  json stated;
  int outside = 0, outside_named = 0;
  for (const auto& [from, trial] : trials) {
    const json found = explain(folder, from, trial, heavy ? 1000000 : 9600);
    stated = found.at("other_cars");
    const std::string verdict = found.at("verdict");
    std::string names;
    for (const json& f : found.at("findings")) names += " " + f.at("mechanism").get<std::string>();
    const bool nothing = trial.at("effects").empty();
    const bool right = !found.at("findings").empty() &&
                       allowed_names(trial).contains(found["findings"][0].at("mechanism"));
    const double size = nothing ? 0.0 : trial.at("size").at("noise_sd").get<double>();
    if (nothing) nulls += 1, alarms += verdict != "none" ? 1 : 0;
    if (trial.at("class") == "outside") {
      outside += 1, outside_named += names.empty() ? 0 : 1;
      continue;
    }
    if (size >= 0.5) effects += 1, first += right ? 1 : 0;
    if (size >= 1.0) large += 1, large_first += right ? 1 : 0;
    wrong += !nothing && verdict == "explained" && !right ? 1 : 0;
    std::printf(
        "%s %s%s (%.2f sd): %s%s\n", trial.at("id").get<std::string>().c_str(),
        nothing ? "nothing" : trial["effects"][0].at("mechanism").get<std::string>().c_str(),
        nothing || right ? "" : " NOT FIRST", size, verdict.c_str(), names.c_str());
  }
  support::figure("alarms", alarms), support::figure("nulls", nulls);
  support::figure("first", first), support::figure("effects", effects);
  support::figure("large_first", large_first), support::figure("large", large);
  support::figure("wrong", wrong);
  support::figure("outside", outside), support::figure("outside_named", outside_named);
  EXPECT_GT(effects, 0);
  EXPECT_EQ(outside_named, 0);
  EXPECT_LE(10 * alarms, nulls);
  if (heavy) {  // what every page says of these recordings
    EXPECT_EQ(nulls, stated.at("recordings"));
    EXPECT_EQ(alarms, stated.at("alarms"));
  }
  EXPECT_GE(first, 0.8 * effects);
  EXPECT_EQ(wrong, 0);
}

}  // namespace other_simulator_test
