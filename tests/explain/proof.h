// A scenario of the second car, explained by the tool: what proofs and write-backs are shown with.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "base/json_text.h"
#include "support/page_claims.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace explain_test {

using nlohmann::json;

/// So many laps are enough to show it; all that the scenario has with KERBSTONE_HEAVY=1.
inline int unless_heavy(int laps) { return std::getenv("KERBSTONE_HEAVY") != nullptr ? 0 : laps; }

/// A named scenario, drawn and explained.
class Proof {
 public:
  /// `laps`: 0 for as many as the scenario has.
  explicit Proof(std::string name, int laps = 0) : name_(std::move(name)) {
    EXPECT_EQ(shell(fmt::format("{} --scenario {} {} {} 2>> {}", places::make_trials(), name_,
                                folder.path("."), laps, folder.path("log"))),
              0)
        << folder.read("log");
    std::erase(name_, ':');  // "fade:31" lies in fade31
    inputs_ = name_;
    truth = base::parse_json<json>(folder.read("sealed/" + name_ + ".json"));
  }
  json explain(const std::string& recordings = "run.csv", const std::string& out = "out",
               const std::string& more = "--skip-simulation") {
    std::string files;
    for (std::size_t at = 0; at < recordings.size();) {
      const std::size_t end = std::min(recordings.find(' ', at), recordings.size());
      files += " " + quoted(path(recordings.substr(at, end - at)));
      at = end + 1;
    }
    EXPECT_EQ(shell(fmt::format("{} run --road {} --car {} --log{} -o {} {} > {} 2>&1",
                                places::crgexplain(), quoted(path("track.crg")),
                                quoted(path("vehicle.yaml")), files, quoted(folder.path(out)), more,
                                folder.path("log"))),
              0)
        << folder.read("log");
    json found = base::parse_json<json>(folder.read(out + "/findings.json"));
    support::expect_page_says(found, folder.read(out + "/report.html"));
    return found;
  }
  /// Runs the command that the last explain() printed after these words.
  int printed(const std::string& words, const std::string& more) {
    const std::string log = folder.read("log");
    const std::size_t at = log.find(words);
    if (at == std::string::npos) return -1;
    const std::string command =
        log.substr(at + words.size(), log.find('\n', at) - at - words.size());
    const std::string path = places::crgdrive().substr(0, places::crgdrive().rfind('/')) + ":" +
                             places::crgexplain().substr(0, places::crgexplain().rfind('/'));
    return shell(fmt::format("PATH={}:$PATH {} {} > {} 2>&1", path, command, more,
                             folder.path("again.log")));
  }
  /// Car, road and recordings lie in another folder from now on.
  void move_inputs(const std::string& to) {
    std::filesystem::rename(folder.path(inputs_), folder.path(to));
    inputs_ = to;
  }
  std::string path(const std::string& file) const { return folder.path(inputs_ + "/" + file); }
  std::string sealed(const std::string& ending) const {
    return folder.path("sealed/" + name_ + ending);
  }

  support::TemporaryFolder folder;
  json truth;

 private:
  static int shell(const std::string& command) { return std::system(command.c_str()); }
  static std::string quoted(const std::string& path) { return '"' + path + '"'; }
  std::string name_, inputs_;
};

inline json finding(const json& all, const std::string& mechanism) {
  for (const json& f : all.at("findings"))
    if (f.at("mechanism") == mechanism) return f;
  ADD_FAILURE() << mechanism << " was not found; verdict " << all.at("verdict");
  return json{{"parameters", {{{"value", NAN}, {"ci90", {NAN, NAN}}}}},
              {"where", json::array()},
              {"held_out", json::array()}};
}

inline double value(const json& f) { return f.at("parameters")[0].at("value"); }

}  // namespace explain_test
