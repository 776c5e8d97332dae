#pragma once

#include <string>

#include "command/terminal.h"

namespace kerbstone {

struct CollectCommand {
  std::string folder;  ///< of the campaign: plan.json lies there
};

/// Writes index.html, campaign.csv and campaign.sqlite; the exit code.
int collect(const CollectCommand& command, command::Terminal& terminal);

}  // namespace kerbstone
