#include "describe.h"

#include <fmt/format.h>

#include <algorithm>

#include "command/program.h"
#include "command/version.h"

namespace command {
namespace {

/// Text as roff takes it: no line of it is a request, hyphens can be copied.
std::string roff(const std::string& text) {
  std::string out;
  bool begin = true;
  for (const char c : text) {
    if (begin && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
    begin = c == '\n';
  }
  return out;
}

std::string takes(const CLI::Option& option) {
  if (option.get_type_size() == 0) return "";
  std::string text = option.get_type_name();
  // CLI11 puts the bounds of a number behind its type: "FLOAT:FLOAT in [0 - 1]".
  if (const std::size_t colon = text.find(':'); colon != std::string::npos)
    text = text.substr(0, colon);
  return text;
}

/// One option or argument: ".TP", its names, what it means.
std::string man_item(const CLI::Option& option) {
  std::string head;
  if (option.get_positional()) {
    head = "\\fI" + roff(option.get_name(true)) + "\\fR";
  } else {
    for (const std::string& name : option.get_snames()) head += "\\fB\\-" + roff(name) + "\\fR, ";
    for (const std::string& name : option.get_lnames())
      head += "\\fB\\-\\-" + roff(name) + "\\fR, ";
    head.resize(head.size() - 2);
  }
  if (const std::string type = takes(option); !type.empty()) head += " \\fI" + roff(type) + "\\fR";
  std::string text = option.get_description();
  if (option.get_required()) text += " (required)";
  return ".TP\n" + head + "\n" + roff(text) + "\n";
}

/// The rest of the help: examples are lines of two blanks, which stay as they are.
std::string man_footer(const std::string& footer) {
  std::string out = ".PP\n";
  bool literal = false;
  for (std::size_t at = 0; at < footer.size();) {
    const std::size_t end = std::min(footer.find('\n', at), footer.size());
    const std::string line = footer.substr(at, end - at);
    const bool wanted = line.starts_with("  ");
    if (wanted != literal && !line.empty()) {
      out += wanted ? ".nf\n" : ".fi\n";
      literal = wanted;
    }
    if (line.empty()) {
      if (literal) out += ".fi\n", literal = false;
      out += ".PP\n";
    } else {
      out += roff(line) + "\n";
    }
    at = end + 1;
  }
  return out + (literal ? ".fi\n" : "");
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

bool everywhere(const CLI::Option& option) { return option.get_group() == "Everywhere"; }

/// Flags of a command, all of their names.
std::vector<std::string> flags_of(const CLI::App& app) {
  std::vector<std::string> out;
  for (const CLI::Option* option : app.get_options()) {
    if (!is_shown(*option)) continue;
    for (const std::string& name : option->get_lnames()) out.push_back("--" + name);
    for (const std::string& name : option->get_snames()) out.push_back("-" + name);
  }
  return out;
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : between) + word;
  return out;
}

/// What completes a value of this kind, as bash.
std::string completed_by(const std::string& type_name) {
  const std::vector<std::string> words = words_of(type_name);
  if (!words.empty())
    return fmt::format("mapfile -t COMPREPLY < <(compgen -W '{}' -- \"$cur\")", joined(words, " "));
  if (type_name == kFolder)
    return "compopt -o filenames; mapfile -t COMPREPLY < <(compgen -d -- \"$cur\")";
  if (type_name == kFile || type_name == kFileOrDash || type_name == kFileOrFolder)
    return "compopt -o filenames; mapfile -t COMPREPLY < <(compgen -f -- \"$cur\")";
  return "COMPREPLY=()";
}

}  // namespace

bool is_shown(const CLI::Option& option) { return option.get_group() != kHidden; }

void leave_hidden_out(CLI::App& app) {
  for (CLI::App* leaf : leaves(app))
    for (CLI::Option* option : leaf->get_options())
      if (!is_shown(*option)) option->group("");
}

std::vector<CLI::App*> leaves(CLI::App& app) {
  std::vector<CLI::App*> out;
  for (CLI::App* sub : app.get_subcommands({})) {
    const std::vector<CLI::App*> below = leaves(*sub);
    if (below.empty()) out.push_back(sub);
    out.insert(out.end(), below.begin(), below.end());
  }
  return out;
}

std::string words_to(const CLI::App& leaf) {
  std::string out;
  for (const CLI::App* at = &leaf; at->get_parent() != nullptr; at = at->get_parent())
    out = at->get_name() + (out.empty() ? "" : " ") + out;
  return out;
}

std::string man_page(CLI::App& app) {
  const std::string name = app.get_name();
  std::string text = app.get_description();
  if (text.starts_with(name + ": ")) text = text.substr(name.size() + 2);
  if (text.ends_with('.')) text.pop_back();
  std::string out = fmt::format(
      ".TH {} 1 \"\" \"Kerbstone {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n",
      upper(name), roff(version()), name, roff(text));
  const std::vector<CLI::App*> commands = leaves(app);
  for (const CLI::App* leaf : commands) {
    if (leaf != commands.front()) out += ".br\n";
    out += fmt::format(".B {} {}\n", name, roff(words_to(*leaf)));
    std::string rest = "[\\fIoptions\\fR]";
    for (const CLI::Option* option : leaf->get_options())
      if (option->get_positional()) rest += " \\fI" + roff(option->get_name(true)) + "\\fR";
    out += rest + "\n";
  }
  out += ".SH DESCRIPTION\n" + roff(text) + ".\n";
  std::string footer = app.get_footer();
  footer = footer.substr(0, footer.find(kExitCodes));
  while (footer.ends_with('\n')) footer.pop_back();
  if (!footer.empty()) out += man_footer(footer);
  out += ".SH COMMANDS\n";
  for (const CLI::App* leaf : commands) {
    out +=
        fmt::format(".SS {} {}\n{}\n", name, roff(words_to(*leaf)), roff(leaf->get_description()));
    for (const bool positional : {true, false})
      for (const CLI::Option* option : leaf->get_options())
        if (option->get_positional() == positional && !everywhere(*option) && is_shown(*option))
          out += man_item(*option);
    footer = leaf->get_footer();
    footer = footer.substr(0, footer.find(kExitCodes));
    while (footer.ends_with('\n')) footer.pop_back();
    if (!footer.empty()) out += man_footer(footer);
  }
  out += ".SH OPTIONS OF EVERY COMMAND\n";
  for (const CLI::Option* option : app.get_options())
    if (everywhere(*option)) out += man_item(*option);
  out += ".SH EXIT STATUS\n" + roff(std::string(kExitCodes).substr(11)) + "\n";
  out += ".SH ENVIRONMENT\n.TP\n.B NO_COLOR\nwhen set, nothing is coloured.\n";
  return out;
}

std::string bash_completion(CLI::App& app) {
  const std::string name = app.get_name();
  const std::vector<CLI::App*> commands = leaves(app);
  // The words before the one that is completed lead to a command; each has its flags and its files.
  std::string next, flags, values, words;
  std::vector<const CLI::App*> above{&app};
  for (const CLI::App* leaf : commands)
    for (const CLI::App* at = leaf->get_parent(); at != &app; at = at->get_parent())
      if (std::find(above.begin(), above.end(), at) == above.end()) above.push_back(at);
  for (const CLI::App* at : above) {
    std::vector<std::string> names;
    for (const CLI::App* sub : at->get_subcommands([](const CLI::App*) { return true; }))
      names.push_back(sub->get_name());
    next += fmt::format("    '{}') words='{}' ;;\n", words_to(*at), joined(names, " "));
    flags += fmt::format("    '{}') flags='{}' ;;\n", words_to(*at), joined(flags_of(*at), " "));
  }
  for (const CLI::App* leaf : commands) {
    flags +=
        fmt::format("    '{}') flags='{}' ;;\n", words_to(*leaf), joined(flags_of(*leaf), " "));
    std::string positional;
    for (const CLI::Option* option : leaf->get_options()) {
      if (option->get_positional() && positional.empty())
        positional = completed_by(option->get_type_name());
      if (option->get_positional() || option->get_type_size() == 0 || !is_shown(*option)) continue;
      std::vector<std::string> names;
      for (const std::string& one : option->get_snames()) names.push_back("-" + one);
      for (const std::string& one : option->get_lnames()) names.push_back("--" + one);
      for (std::string& one : names) one = fmt::format("'{} {}'", words_to(*leaf), one);
      values += fmt::format("    {}) {}; return ;;\n", joined(names, "|"),
                            completed_by(option->get_type_name()));
    }
    words += fmt::format("    '{}') {} ;;\n", words_to(*leaf),
                         positional.empty() ? "COMPREPLY=()" : positional);
  }
  return fmt::format(
      "# bash completion for {0}, made by {0} --completion\n"
      "_{0}() {{\n"
      "  local cur=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} at='' words "
      "flags i w\n"
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
      "    words=''\n"
      "    case $at in\n{1}    esac\n"
      "    for w in $words; do\n"
      "      if [[ $w == \"${{COMP_WORDS[i]}}\" ]]; then at=${{at:+$at }}$w; break; fi\n"
      "    done\n"
      "  done\n"
      "  case \"$at $before\" in\n{2}    esac\n"
      "  words='' flags=''\n"
      "  case $at in\n{3}  esac\n"
      "  if [[ $cur == -* ]]; then mapfile -t COMPREPLY < <(compgen -W \"$flags\" -- \"$cur\"); "
      "return; fi\n"
      "  case $at in\n{1}  esac\n"
      "  if [[ -n $words ]]; then mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$cur\"); "
      "return; fi\n"
      "  case $at in\n{4}  esac\n"
      "}} && complete -F _{0} {0}\n",
      name, next, values, flags, words);
}

}  // namespace command
