// The blind trials' steps: drawn and sealed, explained, scored (docs/crgexplain.md).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "command/terminal.h"
#include "explain/findings.h"

namespace trials {

using command::Terminal;

inline constexpr const char* kFailedVerdict = "failed";  ///< of what could not be explained

struct MakeCommand {
  std::string folder, generator;
  bool waves = false;            ///< about short waves and brake discs
  double third_share = 1.0 / 3;  ///< of the third car; the others are the second's
  int count = 64;
  long long seed = 1;
};
int make(const MakeCommand& command, Terminal& terminal);

struct RunCommand {
  std::string folder;
  unsigned threads = 0;
};
int run(const RunCommand& command, Terminal& terminal);

struct ScoreCommand {
  std::string folder;
};
int score(const ScoreCommand& command, Terminal& terminal);

/// The folders of the trials in a folder, in their order. Throws vehicle::Error when there are
/// none.
std::vector<std::filesystem::path> folders(const std::filesystem::path& folder);

/// A trial's recording explained with what the simulation knows. Without mechanisms only the refit
/// and its proof are asked for.
explain::Findings explained(const std::filesystem::path& trial,
                            const std::filesystem::path& recording, bool mechanisms);

}  // namespace trials
