#include "command/program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <new>

#include "base/ending.h"
#include "base/error.h"
#include "base/output_set.h"
#include "base/write_file.h"
#include "command/signals.h"
#include "command/version.h"
#include "describe.h"
#include "old_names.h"

namespace command {
namespace {

/// A descriptor that the caller closed would be taken by the first file that is opened; this one
/// can be neither read nor written.
void take_closed_descriptors() {
  for (const int descriptor : {0, 1, 2})
    if (::fcntl(descriptor, F_GETFD) < 0) (void)::open("/dev/null", O_PATH);
}

/// Insertions, deletions, exchanges of a letter and swaps of two that make one word of the other.
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] =
          std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

/// The nearest of the words, if one is near: a third of its letters off, or begun alike. Of two
/// equally near the one of the same letters: swapped letters were all typed.
std::string near(const std::string& word, const std::vector<std::string>& words) {
  std::string best;
  std::size_t least = ~std::size_t{0};
  for (const std::string& other : words) {
    const std::size_t off = distance(word, other);
    const bool begun = word.size() > 3 && other.starts_with(word);
    const bool swapped = std::is_permutation(word.begin(), word.end(), other.begin(), other.end());
    if ((off <= std::max<std::size_t>(2, word.size() / 3) || begun) &&
        (off < least || (off == least && swapped)) && off < word.size()) {
      best = other;
      least = off;
    }
  }
  return best;
}

const CLI::App* last_chosen(const CLI::App& app) {
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) at = at->get_subcommands().back();
  return at;
}

std::string about_flag(const CLI::App& app, std::string flag) {
  flag = flag.substr(0, flag.find('='));
  std::vector<std::string> known;
  for (const CLI::App* at = last_chosen(app); at != nullptr; at = at->get_parent())
    for (const CLI::Option* option : at->get_options())
      for (const std::string& name : option->get_lnames())
        if (is_shown(*option)) known.push_back("--" + name);
  const std::string meant = near(flag, known);
  return fmt::format("there is no flag '{}'{}", one_line(flag),
                     meant.empty() ? "" : fmt::format("; did you mean {}?", meant));
}

std::string about_word(const CLI::App& app, const std::string& word, const Advice& advice) {
  const CLI::App& at = *last_chosen(app);
  std::vector<std::string> words;
  if (&at == &app) words = advice.elsewhere;
  for (const CLI::App* sub : at.get_subcommands({})) words.push_back(sub->get_name());
  const std::string known = fmt::format("{}", fmt::join(words, ", "));
  if (word.empty()) return fmt::format("a command is wanted: {}", known);
  if (const std::string meant = near(word, words); !meant.empty())
    return fmt::format("there is no command '{}'; did you mean '{}'?", word, meant);
  if (word.find_first_of("./") != std::string::npos && !advice.file.empty())
    return fmt::format("'{0}' is no command; {1}{0}", word, advice.file);
  return fmt::format("there is no command '{:.60}'; there are {}", word, known);
}

/// What is wrong with a command line that CLI11 refuses.
std::string explain(const CLI::App& app, const CLI::ParseError& error, const Advice& advice) {
  const std::vector<std::string> unknown = app.remaining(true);
  const auto flag = std::find_if(unknown.begin(), unknown.end(), [](const std::string& word) {
    return word.size() > 1 && word[0] == '-' &&
           std::isdigit(static_cast<unsigned char>(word[1])) == 0 && word != "--";
  });
  const bool command_missing = !last_chosen(app)->get_subcommands({}).empty();
  // A file in the place of the command: its flags are those of the command that is missing.
  const bool begins_with_word = !unknown.empty() && unknown.front()[0] != '-';
  if (flag != unknown.end() && !(command_missing && begins_with_word))
    return about_flag(app, *flag);
  if (command_missing) return about_word(app, unknown.empty() ? "" : unknown.front(), advice);
  return error.what();
}

/// "0 to 256" in place of "UINT:INT in [0 - 256]"; empty: not one of a number.
std::string bounds_of(const std::string& type) {
  if (type == "FLOAT") return "a number";
  if (type == "FLOAT:POSITIVE") return "above 0";
  if (type == "FLOAT:NONNEGATIVE") return "0 or more";
  const std::size_t begin = type.find(" in ["), between = type.find(" - ", begin),
                    end = type.find(']', between);
  if (end == std::string::npos) return "";
  return type.substr(begin + 5, between - begin - 5) + " to " +
         type.substr(between + 3, end - between - 3);
}

/// Shows bounds in plain words, and refuses what is no number: NaN is within all bounds of CLI11.
void mend_number(CLI::Option& option) {
  const std::string type = option.get_type_name(), bounds = bounds_of(type);
  if (bounds.empty()) return;
  if (type != "FLOAT") option.get_validator(0)->description("");
  option.type_name(bounds);
  option.check(CLI::Validator(
      [bounds](const std::string& text) {
        double value = 0;
        const bool endless = CLI::detail::lexical_cast(text, value) && !std::isfinite(value);
        return endless ? fmt::format("'{}' seen, {} wanted", one_line(text), bounds) : "";
      },
      ""));
}

void add_everywhere(CLI::App& app, Terminal& terminal) {
  app.fallthrough();  // --quiet and --json may stand before or after the command
  const auto add_common = [&](CLI::App& at) {
    at.set_help_flag();  // it comes with the others, at the end
    at.set_help_flag("-h,--help", "this text")->group("Everywhere");
    at.add_flag("-q,--quiet", terminal.quiet, "nothing but errors")->group("Everywhere");
    at.add_flag("--json", terminal.json, "the result as JSON")->group("Everywhere");
    at.add_flag_callback(
          "--version", [] {}, "version and commit of this program")
        ->group("Everywhere");
    at.footer(at.get_footer() + (at.get_footer().empty() ? "" : "\n\n") + kExitCodes);
  };
  for (CLI::App* leaf : leaves(app)) {
    for (CLI::Option* option : leaf->get_options()) mend_number(*option);
    for (CLI::App* at = leaf; at != nullptr; at = at->get_parent()) at->fallthrough();
    if (leaf->get_option_no_throw("--output") == nullptr)
      leaf->add_option_function<std::string>(
              "-o,--output", [&](const std::string& path) { terminal.redirect(path); },
              "file for what is printed [-: standard output]")
          ->type_name(kFileOrDash);
    add_common(*leaf);
  }
  add_common(app);
}

/// --points alone is a "FILE or -" that is read.
bool is_output(const CLI::Option& option) {
  return option.check_lname("output") ||
         (option.get_type_name() == kFileOrDash && !option.check_lname("points"));
}

/// Refuses, before the work, what could not be read or written after it.
void look_at_paths(const CLI::App& app, Terminal& terminal) {
  std::string on_stdout;
  for (const CLI::Option* option : last_chosen(app)->get_options()) {
    const std::string& kind = option->get_type_name();
    if (kind != kFile && kind != kFileOrDash && kind != kFileOrFolder && kind != kFolder) continue;
    for (const std::string& path : option->results()) {
      const bool nothing = path.empty() && (is_output(*option) || kind == kFolder);
      if (nothing || (path == "-" && kind != kFileOrDash))
        throw UsageError(fmt::format("{}: '{}' seen, a {} wanted", option->get_name(), path,
                                     kind == kFolder ? "folder" : "file"));
      if (is_output(*option)) {
        if (path == "-") {
          if (!on_stdout.empty())
            throw UsageError(
                fmt::format("{} and {}: standard output takes one of them; name a file", on_stdout,
                            option->get_name()));
          on_stdout = option->get_name();
          terminal.results_to_stderr();
        }
        kind == kFolder ? base::check_writable_folder(path) : base::check_writable(path);
        continue;
      }
      struct stat found {};
      if (path.empty() || path == "-" || ::stat(path.c_str(), &found) != 0) continue;
      if (!S_ISREG(found.st_mode) && !S_ISDIR(found.st_mode))
        throw base::Error(fmt::format(
            "{}: is a pipe or device; a regular file is wanted: write it to one first", path));
      // A file of a killed run, or a road changed behind its manifest, is taken by nobody.
      if (S_ISREG(found.st_mode))
        path.ends_with(".crg") ? base::check_in_set(path) : base::check_set_is_whole(path);
    }
  }
}

int parse_and_work(CLI::App& app, Terminal& terminal, std::vector<std::string> words,
                   const std::function<int()>& work, const Advice& advice) {
  const std::string name = app.get_name();
  if (words.size() == 1 && words[0] == "--man") return terminal.print(man_page(app)), kOk;
  if (words.size() == 1 && words[0] == "--completion")
    return terminal.print(bash_completion(app)), kOk;
  for (std::string& word : words) {
    if (word == "--") break;
    if (word == "--version")
      return terminal.print(fmt::format("{} {}\n{}{}", name, version(), advice.built,
                                        advice.built.empty() ? "" : "\n")),
             kOk;
    if (word == "--out" || word.starts_with("--out=")) word.insert(5, "put");
  }
  const std::vector<std::string> remarks = use_new_names(app, words);
  std::reverse(words.begin(), words.end());
  try {
    app.parse(std::move(words));
  } catch (const CLI::CallForHelp&) {
    terminal.quiet = false;
    leave_hidden_out(app);
    const CLI::App* const at = last_chosen(app);
    const std::string all = chosen(app);
    return terminal.print(at->help(at == &app ? "" : all.substr(0, all.rfind(' ')))), kOk;
  } catch (const CLI::ParseError& error) {
    throw UsageError(explain(app, error, advice));
  }
  for (const std::string& remark : remarks) terminal.remark(remark);
  for (const CLI::Option* option : last_chosen(app)->get_options())
    if (is_old(*option) && option->count() > 0)
      terminal.remark(
          fmt::format("{} is written {} now", option->get_name(), option->get_description()));
  look_at_paths(app, terminal);
  terminal.start(words_to(*last_chosen(app)));
  return work();
}

}  // namespace

CLI::Option* add_output_file(CLI::App& app, std::string& path, const std::string& text,
                             const std::string& names) {
  return app.add_option(names, path, text)->type_name(kFileOrDash);
}

CLI::Option* add_output_files(CLI::App& app, const std::vector<OutputKind>& kinds,
                              const std::string& text) {
  const auto sort = [kinds](const std::vector<std::string>& paths) {
    std::vector<const std::string*> taken;
    for (const std::string& path : paths) {
      const auto called = [&](const std::string& ending) {
        return std::find_if(kinds.begin(), kinds.end(),
                            [&](const OutputKind& kind) { return kind.ending == ending; });
      };
      auto kind = called(base::ending_of(path));
      if (kind == kinds.end() || (paths.size() == 1 && !kind->alone)) kind = called("");
      if (std::find(taken.begin(), taken.end(), kind->path) != taken.end())
        throw CLI::ValidationError(
            "--output",
            fmt::format("{} and {} are files of one kind; give one", *kind->path, path));
      *kind->path = path;
      taken.push_back(kind->path);
    }
  };
  return app.add_option_function<std::vector<std::string>>("-o,--output", sort, text)
      ->allow_extra_args(false)
      ->type_name(kFileOrDash);
}

CLI::Option* add_output_folder(CLI::App& app, std::string& path, const std::string& text) {
  return app.add_option("-o,--output", path, text)->type_name(kFolder);
}

CLI::Option* add_choice(CLI::App& app, const std::string& names, std::string& value,
                        const std::string& text, const std::vector<std::string>& words) {
  std::string shown;
  for (std::size_t i = 0; i < words.size(); ++i)
    shown += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return app.add_option(names, value, text)
      ->transform(CLI::IsMember(words, CLI::ignore_case).description(""))
      ->type_name(shown);
}

std::vector<std::pair<std::string, std::string>> options_used(CLI::App& command) {
  std::vector<std::pair<std::string, std::string>> used;
  for (CLI::Option* option : command.get_options()) {
    const std::string kind = option->get_type_name();
    const std::vector<std::string>& names = option->get_lnames();
    if (names.empty() || kind == kFile || kind == kFileOrDash || kind == kFileOrFolder ||
        kind == kFolder || is_old(*option))
      continue;
    const auto is = [&](const char* name) { return names.front() == name; };
    if (is("help") || is("quiet") || is("json") || is("version") || is("threads") || is("force"))
      continue;
    if (option->get_expected_min() == 0) {
      used.emplace_back(names.front(), option->count() > 0 ? "true" : "false");
      continue;
    }
    option->capture_default_str();  // of the variable, which has been set by now
    std::string value = option->get_default_str();
    if (value.empty() && option->count() > 0) value = option->results().front();  // std::optional
    used.emplace_back(names.front(), value == "[]" ? "" : value);
  }
  return used;
}

std::vector<std::string> words_of(const std::string& type_name) {
  std::vector<std::string> out;
  std::string rest = type_name;
  const std::size_t last = rest.rfind(" or ");
  if (last == std::string::npos) return {};
  rest.replace(last, 4, ", ");
  for (std::size_t at = 0; at <= rest.size();) {
    const std::size_t end = std::min(rest.find(", ", at), rest.size());
    const std::string word = rest.substr(at, end - at);
    const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
      return std::isalnum(c) != 0 || c == '-' || c == '_';
    });
    if (!plain) return {};
    out.push_back(word);
    at = end + 2;
  }
  return out;
}

std::string chosen(const CLI::App& app) {
  const std::string words = words_to(*last_chosen(app));
  return app.get_name() + (words.empty() ? "" : " ") + words;
}

int run(CLI::App& app, Terminal& terminal, int argc, char** argv, const std::function<int()>& work,
        const Advice& advice) {
  take_closed_descriptors();
  end_on_signals(terminal);
  add_everywhere(app, terminal);
  int code = kFailed;
  try {
    code = parse_and_work(app, terminal, {argv + 1, argv + argc}, work, advice);
  } catch (const UsageError& error) {
    const bool asks = std::string_view(error.what()).ends_with('?');
    terminal.error(
        fmt::format("{}{} {} --help", error.what(), asks ? " See" : "; see", chosen(app)));
    code = kUsage;
  } catch (const NotValid& error) {
    terminal.error(error.what());
    code = kNotValid;
  } catch (const std::bad_alloc&) {
    terminal.error("not enough memory" + (advice.memory.empty() ? "" : "; " + advice.memory));
  } catch (const std::exception& error) {
    terminal.error(error.what());
  }
  if (code != kOk && code != kNotValid) return code;
  try {
    terminal.finish();
  } catch (const std::exception& error) {
    terminal.error(error.what());
    code = kFailed;
  }
  return code;
}

}  // namespace command
