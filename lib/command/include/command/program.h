// A tool's command line: the only header that knows CLI11. main.cpp describes its commands with it
// and hands them to run().
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "command/exit_code.h"
#include "command/terminal.h"

namespace command {

// What the help says that an option takes is what checks and the shell's completion go by: one of
// these, or "a, b or c" for one of these words.
constexpr const char *kFile = "FILE", *kFileOrDash = "FILE or -", *kFileOrFolder = "FILE or FOLDER",
                     *kFolder = "FOLDER";

/// Files that are read. They must be regular files: not a pipe, which ends while it is read twice.
template <class Paths>
CLI::Option* add_input(CLI::App& app, const std::string& names, Paths& paths,
                       const std::string& text, const char* kind = kFile) {
  return app.add_option(names, paths, text)->type_name(kind);
}

/// -o FILE, or --sights for a second file; "-" is standard output.
CLI::Option* add_output_file(CLI::App& app, std::string& path, const std::string& text,
                             const std::string& names = "-o,--output");

/// Where one of several results goes, by the ending of its name: ".html". One kind has the empty
/// ending, which stands for all others.
struct OutputKind {
  std::string ending;
  std::string* path;
  bool alone = true;  ///< false: where it is the only name, it is that of the kind for all others
};

/// -o FILE, more than once where more than one result is wanted; the ending says which it is.
CLI::Option* add_output_files(CLI::App& app, const std::vector<OutputKind>& kinds,
                              const std::string& text);

/// -o FOLDER.
CLI::Option* add_output_folder(CLI::App& app, std::string& path, const std::string& text);

/// One of these words, in any case.
CLI::Option* add_choice(CLI::App& app, const std::string& names, std::string& value,
                        const std::string& text, const std::vector<std::string>& words);

/// From now on in no help, manual or completion: what nearly nobody needs. It works all the same;
/// the program's page in docs/ describes it.
CLI::Option* hide(CLI::Option* option);

/// A flag as it was called before: hidden; who uses it is told what is written `now` in its place,
/// e.g. "-o NAME.xodr".
CLI::Option* hide_old(CLI::Option* option, const std::string& now);

/// The words of "a, b or c"; none when that is no list of words.
std::vector<std::string> words_of(const std::string& type_name);

/// What a tool adds to messages that all have.
struct Advice {
  std::string memory;      ///< how to need less of it
  std::string file;        ///< what is done with a file whose command was left out, before its name
  std::string built = {};  ///< with or without what this was built: a line of --version
  std::vector<std::string> elsewhere = {};  ///< commands that other programs do
};

/// Everything from the command line to the exit code. Adds -q/--quiet, --json, --version, a place
/// for results (-o) where a command has none, and the exit codes to every command; answers --man
/// and
/// --completion (describe.h); ends on signals; parses; looks at what is read and written before
/// the work; does it; makes one line of any exception. `--out` is taken for `--output`.
int run(CLI::App& app, Terminal& terminal, int argc, char** argv, const std::function<int()>& work,
        const Advice& advice = {});

/// What a command was told or takes by itself: name (without dashes) and value of each option that
/// has a bearing on results, for its callback. Files are left out, old flags, and what says how,
/// not what (--threads, --json ...). Flags: "true" or "false"; an empty value: found from the
/// inputs.
std::vector<std::pair<std::string, std::string>> options_used(CLI::App& command);

/// The command that was chosen, e.g. "crgexplain run".
std::string chosen(const CLI::App& app);

}  // namespace command
