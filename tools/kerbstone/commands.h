#pragma once

#include <string>
#include <vector>

#include "command/terminal.h"

namespace kerbstone {

struct CollectCommand {
  std::string folder;  ///< of the campaign: plan.json lies there
};

/// Writes index.html, campaign.csv and campaign.sqlite; the exit code.
int collect(const CollectCommand& command, command::Terminal& terminal);

struct ViewCommand {
  std::vector<std::string> paths;  ///< folders and files; empty: where it was started
  bool no_open = false;            ///< the address is printed, no browser started
  std::string host, token;         ///< empty: this machine alone; made at random
  int port = 0;                    ///< 0: any that is free
  double seconds = 0.0;            ///< ends by itself; 0: not
};

/// Serves the page until it is interrupted or `seconds` are over.
int view(const ViewCommand& command, command::Terminal& terminal);

}  // namespace kerbstone
