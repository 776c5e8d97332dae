// Locate, name, size and prove a mismatch between recordings and a simulation.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "base/progress.h"
#include "explain/findings.h"
#include "explain/simulate.h"

namespace explain {

/// Where a run keeps what took long, for one over the same inputs that goes on where it was
/// stopped. Both empty: nowhere.
struct KeptParts {
  std::function<bool(const std::string& name, std::string& bytes)> load;  ///< false: not there
  std::function<void(const std::string& name, const std::string& bytes)> keep;
};

struct ExplainOptions {
  std::set<int>
      hold_out;  ///< laps (counted from 0 over all recordings) only used for proof; empty: rotation
  unsigned threads = 0;      ///< 0: as many as the machine has; never changes the result
  bool mechanisms = true;    ///< false: only the refit of the parameters, and its proof
  bool forces = true;        ///< false: only relations that need no tyres and no forces; nothing
                             ///< is found where these give less than 200 rows
  std::size_t nulls = 1000;  ///< null replicates
  base::Progress progress;
  KeptParts kept{};
};

/// What is compared.
struct Comparison {
  const std::vector<Signals>& logs;
  const std::vector<RecordedLog>& recordings;  ///< the tables of the same logs
  const Mapping& mapping;                      ///< of their columns
  const crg::Surface& road;
  const vehicle::Vehicle& car;
};

/// All that can be said without driving the whole simulated car (docs/crgexplain.md): relations,
/// short waves, discs, and the verdict. Throws vehicle::Error when it cannot be made: nothing in
/// common between the channels, less than 15 s of usable driving.
Findings explain(const Comparison& comparison, const ExplainOptions& options = {});

/// The relations alone, without a verdict.
Findings explain_relations(const std::vector<Signals>& logs, const vehicle::Vehicle& car,
                           const ExplainOptions& options = {});

}  // namespace explain
