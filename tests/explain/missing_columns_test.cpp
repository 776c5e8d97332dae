// What a log does not have is unknown, not zero: nothing is missing in the car because a column is.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "base/json_text.h"
#include "proof.h"
#include "support/figure.h"
#include "support/run_tool.h"

namespace explain_test {
namespace missing_columns_test {

/// Columns that a logger has together or not at all.
const std::map<std::string, std::vector<std::string>> kGroups{
    {"heading", {"yaw_rad"}},
    {"lateral speed", {"vy_mps"}},
    {"yaw rate", {"yaw_rate_radps"}},
    {"forward acceleration", {"ax_mps2"}},
    {"lateral acceleration", {"ay_mps2"}},
    {"vertical acceleration", {"az_mps2"}},
    {"steering", {"steer_rad", "steer_command_rad"}},
    {"throttle", {"throttle", "throttle_command"}},
    {"brakes",
     {"brake_fl_pa", "brake_fr_pa", "brake_rl_pa", "brake_rr_pa", "brake_fl_command_pa",
      "brake_fr_command_pa", "brake_rl_command_pa", "brake_rr_command_pa"}},
    {"gear", {"gear"}},
    {"engine speed", {"engine_radps"}},
    {"wheel speeds", {"wheel_fl_radps", "wheel_fr_radps", "wheel_rl_radps", "wheel_rr_radps"}},
    {"wheel loads", {"fz_fl_n", "fz_fr_n", "fz_rl_n", "fz_rr_n"}}};

std::string without(const std::string& csv, const std::set<std::string>& columns) {
  std::istringstream lines(csv);
  std::string out;
  std::vector<bool> kept;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    std::string row;
    std::size_t at = 0;
    for (std::string cell; std::getline(cells, cell, ','); ++at) {
      if (out.empty()) kept.push_back(!columns.contains(cell));
      if (kept[at]) row += (row.empty() ? "" : ",") + cell;
    }
    out += row + "\n";
  }
  return out;
}

TEST(SlowMissingColumns, AreNoMissingPhysics) {
  // KERBSTONE_HEAVY=1: every one and every two of them, ten minutes.
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const Proof drawn("none", 2);
  const std::string csv = drawn.folder.read("none/run.csv");
  const std::string header = csv.substr(0, csv.find('\n'));
  std::vector<std::pair<std::string, std::set<std::string>>> drops;
  for (auto a = kGroups.begin(); a != kGroups.end(); ++a) {
    if (header.find(a->second.front()) == std::string::npos) continue;
    for (auto b = a; b != kGroups.end(); ++b) {
      if (header.find(b->second.front()) == std::string::npos) continue;
      std::set<std::string> columns(a->second.begin(), a->second.end());
      columns.insert(b->second.begin(), b->second.end());
      drops.emplace_back(a == b ? a->first : a->first + " and " + b->first, columns);
    }
  }
  const std::set<std::string> few{"wheel speeds", "brakes and lateral speed"};
  int runs = 0, named = 0;
  for (const auto& [name, columns] : drops) {
    if (!heavy && !few.contains(name)) continue;
    const std::string log = drawn.folder.file("log.csv", without(csv, columns));
    const support::ToolRun ran = support::run_tool(
        places::crgexplain(),
        {"run", "--skip-simulation", "--road", drawn.path("track.crg"), "--car",
         drawn.path("vehicle.yaml"), "--log", log, "-o", drawn.folder.path("out")});
    ASSERT_EQ(ran.code, 0) << name << ": " << ran.err;
    const json found = base::parse_json<json>(drawn.folder.read("out/findings.json"));
    EXPECT_NE(found.at("verdict"), "explained")
        << name << ": " << base::dump_json(found.at("findings"), 1);
    runs += 1;
    named += found.at("findings").empty() ? 0 : 1;
    if (found.at("verdict") != "none")
      fmt::print("without {}: {}\n", name, found.at("verdict").get<std::string>());
  }
  support::figure("runs", runs), support::figure("named", named);
  EXPECT_GE(runs, 2);
  EXPECT_LE(named, 0.05 * runs);
}

}  // namespace missing_columns_test
}  // namespace explain_test
