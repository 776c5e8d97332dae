#pragma once

#include <optional>
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

struct OpenCommand {
  std::string log;
  std::string out;                    ///< .html, .mcap or .csv; empty: nothing is written
  std::vector<std::string> channels;  ///< that the page draws; empty: the first that live
};

/// Lists the channels of a log of any maker, and writes it as a page, MCAP or CSV.
int open(const OpenCommand& command, command::Terminal& terminal);

struct TryCommand {
  std::string output = "kerbstone-try";  ///< the folder for all that it makes
  bool no_open = false;
  std::optional<unsigned> seed;  ///< which number is changed; empty: at random
};

/// Runs every step of the way once and says at the end what was hidden. Throws base::Error where a
/// step fails.
int try_it(const TryCommand& command, command::Terminal& terminal);

/// False where this system has no browser to start, or no screen.
bool open_browser(const std::string& address);

}  // namespace kerbstone
