#include "old_names.h"

#include <fmt/format.h>

#include <array>

#include "command/program.h"
#include "describe.h"

namespace command {
namespace {

/// One thing has one name in all commands; the names that it had still work.
constexpr std::array<std::array<const char*, 2>, 21> kOldNames = {{
    {"--track", "--road"},       {"--base", "--road"},           {"--vehicle", "--car"},
    {"--recording", "--log"},    {"--recordings", "--log"},      {"--friction", "--grip"},
    {"--from-m", "--u-begin-m"}, {"--to-m", "--u-end-m"},        {"--begin-mps", "--speed-mps"},
    {"--seconds", "--stop-s"},   {"--record-every", "--every"},  {"--mirrored", "--mirror"},
    {"--facet-m", "--step-m"},   {"--node-m", "--step-m"},       {"--octree-m", "--voxel-m"},
    {"--reference", "--tir"},    {"--accelerations", "--frame"}, {"--steps-s", "--step-s"},
    {"--level-m", "--window-m"}, {"--input", "--command"},       {"--movement", "--measure"},
}};

}  // namespace

CLI::Option* hide(CLI::Option* option) { return option->group(kHidden)->description(""); }

CLI::Option* hide_old(CLI::Option* option, const std::string& now) {
  return option->group(kHidden)->description(now);
}

bool is_old(const CLI::Option& option) {
  return !is_shown(option) && !option.get_description().empty();
}

std::vector<std::string> use_new_names(const CLI::App& app, std::vector<std::string>& words) {
  const CLI::App* at = &app;
  for (const std::string& word : words)
    for (const CLI::App* sub : at->get_subcommands({}))
      if (sub->get_name() == word) at = sub;
  std::vector<std::string> remarks;
  for (std::string& word : words) {
    if (word == "--") break;
    const std::string flag = word.substr(0, word.find('='));
    for (const auto& [old, now] : kOldNames)
      if (flag == old && at->get_option_no_throw(old) == nullptr &&
          at->get_option_no_throw(now) != nullptr) {
        word.replace(0, flag.size(), now);
        remarks.push_back(fmt::format("{} is called {} now", old, now));
      }
  }
  return remarks;
}

}  // namespace command
