// What a tool says about itself besides --help, made from the same texts.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace command {

constexpr const char* kExitCodes =
    "Exit code: 0 done, 1 cannot be done, 2 wrong command line, 3 done but must not be used,\n"
    "130 or 143 interrupted by Ctrl-C or SIGTERM.";

/// The group of flags that are shown nowhere. CLI11 leaves out those without a group, but has no
/// names for them in errors: leave_hidden_out() takes it off before the help.
constexpr const char* kHidden = "Hidden";
void leave_hidden_out(CLI::App& app);

/// Whether help, manual and completion show it.
bool is_shown(const CLI::Option& option);

/// Commands that do something: those without further commands, in the order of their definition.
std::vector<CLI::App*> leaves(CLI::App& app);

/// The words that lead to a command, e.g. "info".
std::string words_to(const CLI::App& leaf);

/// A page for man(1), section 1.
std::string man_page(CLI::App& app);

/// A script for bash: commands, flags, words that a flag takes, files.
std::string bash_completion(CLI::App& app);

}  // namespace command
