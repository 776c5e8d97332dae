#include "verbs.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

namespace kerbstone {

namespace fs = std::filesystem;

const std::vector<Verb>& verbs() {
  static const std::vector<Verb> kVerbs = {
      {"objects", "crgbuild", "objects", {}, "objects of a mesh: what each is taken for, and why"},
      {"build",
       "crgbuild",
       "build",
       {"from-edges", "synth", "preview", "stretch"},
       "a mesh becomes a checked road"},
      {"check", "crgbuild", "check", {"validate"}, "does a road keep the rules of the standard?"},
      {"report", "crgbuild", "report", {}, "what is wrong with a road, and where: a page"},
      {"info", "crgbuild", "info", {"query"}, "what a road holds; heights at points"},
      {"edit", "crgbuild", "", {}, "crop, resample, reverse, append, transform or convert a road"},
      {"export", "crgbuild", "export", {}, "a road in a format of other programs"},
      {"scan", "lidar2mesh", "", {}, "clouds: info, ground, register, changes, tiles, synth"},
      {"refine",
       "lidar2mesh",
       "map",
       {"grid", "split", "map-tile", "merge"},
       "a road, mended by scans"},
      {"drive",
       "crgdrive",
       "lap",
       {"replay", "report", "manoeuvre"},
       "a car drives laps of a road"},
      {"car",
       "crgdrive",
       "",
       {},
       "new: from a data sheet; parameters, tyre, poles, timing; fmu: as a unit"},
      {"race", "crgsim", "race", {}, "several cars on one road"},
      {"explain",
       "crgexplain",
       "run",
       {"map", "road", "summary", "fleet"},
       "why a simulation and a recording differ"},
      {"fit",
       "crgidentify",
       "",
       {},
       "tyre, actuator, mass, aero, suspension, brakes, engine from measurements; reduce, forces"},
      {"unit", "crgsim", "", {}, "info, run or serve a Functional Mock-up Unit"},
  };
  return kVerbs;
}

std::vector<std::string> words_of_owner(const std::vector<std::string>& words) {
  const auto word = std::find_if(words.begin(), words.end(),
                                 [](const std::string& w) { return !w.starts_with('-'); });
  const auto verb = std::find_if(verbs().begin(), verbs().end(), [&](const Verb& v) {
    return word != words.end() && *word == v.name;
  });
  if (verb == verbs().end()) return {};
  const auto rest = word + 1;
  const bool is_other = rest != words.end() &&
                        std::find(verb->also.begin(), verb->also.end(), *rest) != verb->also.end();
  std::vector<std::string> out = {verb->program};
  if (*verb->command != '\0' && !is_other) out.emplace_back(verb->command);
  out.insert(out.end(), rest, words.end());
  out.insert(out.end(), words.begin(), word);  // --quiet and --json may stand before the verb
  return out;
}

std::string own_folder() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  return error ? std::string() : self.parent_path().string();
}

std::string example_file(const std::string& own, const std::string& name) {
  for (const char* const examples : {"../share/doc/kerbstone/examples", "../../../.."}) {
    std::error_code error;
    const fs::path path = fs::canonical(fs::path(own) / examples / name, error);
    if (!error) return path.string();
  }
  return "";
}

void make_tools_found(const std::string& own) {
  if (own.empty()) return;
  std::string path = own;
  for (const Verb& verb : verbs()) {
    const fs::path folder = fs::path(own).parent_path() / verb.program;
    if (fs::exists(folder / verb.program) && path.find(folder.string()) == std::string::npos)
      path += ":" + folder.string();
  }
  const char* const known = ::getenv("PATH");
  ::setenv("PATH", (path + (known == nullptr ? "" : std::string(":") + known)).c_str(), 1);
}

std::string become(std::vector<std::string> words) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::execvp(arguments[0], arguments.data());
  return fmt::format("{} cannot be started: {}; install it beside kerbstone, or where PATH leads",
                     words[0], std::generic_category().message(errno));
}

std::string verbs_text() {
  std::string out = "Verbs, each done by the program in brackets:\n";
  for (const Verb& verb : verbs())
    out += fmt::format("  {:<26}{} ({})\n", verb.name, verb.about, verb.program);
  return out;
}

}  // namespace kerbstone
