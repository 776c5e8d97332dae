#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/parallel.h"
#include "base/write_file.h"
#include "command/exit_code.h"
#include "command/program.h"
#include "commands.h"
#include "crg/file.h"
#include "explain/explain.h"
#include "vehicle/error.h"

namespace trials {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Whether a run before this one explained it; one that failed is tried again.
bool is_explained(const fs::path& trial) {
  std::ifstream in(trial / "findings.json");
  const json found = json::parse(in, nullptr, false);
  return found.is_object() && found.contains("verdict") && found["verdict"] != kFailedVerdict;
}

}  // namespace

explain::Findings explained(const fs::path& trial, const fs::path& recording, bool mechanisms) {
  const std::string here = trial.string();
  const vehicle::Vehicle car = vehicle::read_vehicle(here + "/vehicle.yaml");
  const crg::Surface surface(crg::read(here + "/track.crg"));
  const recording::Table table = recording::read_table(recording.string());
  std::vector<explain::Signals> logs;
  logs.push_back(
      explain::make_signals(table, explain::identity_mapping(table), surface, recording.string()));
  explain::ExplainOptions options;
  options.threads = 1;
  options.mechanisms = mechanisms;
  // Without mechanisms only the refit and its proof are asked for.
  if (!mechanisms) return explain::explain_relations(logs, car, options);
  return explain::explain(
      {logs, {{&table, &logs.front()}}, explain::identity_mapping(table), surface, car}, options);
}

int run(const RunCommand& c, Terminal& terminal) {
  const std::vector<fs::path> all = folders(c.folder);
  std::atomic<std::size_t> done{0};
  std::vector<std::string> failures(all.size());  ///< why; empty: none
  const base::Progress progress = terminal.progress();
  base::parallel_for(all.size(), 1, c.threads, [&](std::size_t k, std::size_t) {
    const std::string here = all[k].string();
    if (is_explained(all[k])) return;  // a run that was stopped goes on
    std::string result;
    try {
      result = explain::findings_json(explained(all[k], here + "/run.csv", true));
    } catch (const std::exception& error) {
      failures[k] = error.what();
      result = base::json_text(
          json{{"verdict", kFailedVerdict}, {"error", failures[k]}, {"findings", json::array()}},
          1);
    }
    base::write_file(here + "/findings.json", result);
    progress("trials", static_cast<double>(++done) / static_cast<double>(all.size()));
  });
  const auto is_failure = [](const std::string& why) { return !why.empty(); };
  const auto failed =
      static_cast<std::size_t>(std::count_if(failures.begin(), failures.end(), is_failure));
  terminal.print(terminal.json
                     ? base::json_text(json{{"recordings", all.size()}, {"failed", failed}})
                     : fmt::format("{} recordings explained\n", all.size() - failed));
  if (failed > 0)
    throw command::NotValid(fmt::format(
        "{}: {} of {} recordings could not be explained, the first because: {}; findings.json of "
        "each says why, and 'blind_trials run' tries them again",
        c.folder, failed, all.size(), *std::find_if(failures.begin(), failures.end(), is_failure)));
  return command::kOk;
}

}  // namespace trials
