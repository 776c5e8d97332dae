// Names that flags had: they work, and whoever uses them is told the name of today.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace command {

/// Whether another flag has come in its place: it is shown nowhere, and its description is what is
/// written now.
bool is_old(const CLI::Option& option);

/// Puts the new names in; what to say about it, a line for each.
std::vector<std::string> use_new_names(const CLI::App& app, std::vector<std::string>& words);

}  // namespace command
