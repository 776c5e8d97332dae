#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "command/exit_code.h"
#include "command/signals.h"
#include "commands.h"
#include "vehicle/error.h"

namespace trials {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using vehicle::Error;

/// Runs a program to its end; what it prints goes to standard error. Throws Error.
void run_program(std::vector<std::string> words) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const auto refuse = [&](int reason) {
    throw Error(
        fmt::format("{}: cannot be started: {}; give the program make_trials of the tests "
                    "with --generator",
                    words[0], std::strerror(reason)));
  };
  int told[2];  // closed by a program that starts; otherwise the reason comes through
  if (::pipe2(told, O_CLOEXEC) != 0) refuse(errno);
  const pid_t child = ::fork();
  int reason = errno;
  if (child == 0) {
    command::end_with_parent();
    ::dup2(STDERR_FILENO, STDOUT_FILENO);
    ::execv(argv[0], argv.data());
    reason = errno;
    (void)!::write(told[1], &reason, sizeof reason);
    ::_exit(1);
  }
  ::close(told[1]);
  const bool started = child > 0 && ::read(told[0], &reason, sizeof reason) == 0;
  ::close(told[0]);
  int status = 0;
  if (child > 0) ::waitpid(child, &status, 0);
  if (!started) refuse(reason);
  if (WIFSIGNALED(status))
    throw Error(fmt::format("{}: was ended by signal {} ({})", words[0], WTERMSIG(status),
                            strsignal(WTERMSIG(status))));
  if (WEXITSTATUS(status) != 0)
    throw Error(fmt::format("{}: failed with exit code {}; what it says is above", words[0],
                            WEXITSTATUS(status)));
}

}  // namespace

std::vector<fs::path> folders(const fs::path& folder) {
  std::vector<fs::path> out;
  if (!fs::is_directory(folder)) throw Error(fmt::format("{}: no such folder", folder.string()));
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && fs::exists(entry.path() / "run.csv")) out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  if (out.empty())
    throw Error(fmt::format("{}: holds no trials; blind_trials make draws some", folder.string()));
  return out;
}

int make(const MakeCommand& c, Terminal& terminal) {
  fs::create_directories(c.folder);
  if (!fs::is_empty(c.folder))
    throw Error(c.folder + ": is not empty; trials want a folder of their own");
  std::vector<std::string> words{c.generator, std::to_string(c.count), std::to_string(c.seed),
                                 c.folder};
  if (c.waves)
    words.insert(words.begin() + 1, "--waves");
  else
    words.insert(words.begin() + 1, {"--third-share", fmt::format("{}", c.third_share)});
  run_program(words);
  std::string sums;
  std::vector<fs::path> sealed;
  for (const auto& entry : fs::directory_iterator(fs::path(c.folder) / "sealed"))
    sealed.push_back(entry.path());
  std::sort(sealed.begin(), sealed.end());
  for (const fs::path& path : sealed)
    sums += base::sha256_of_file(path.string()) + "  sealed/" + path.filename().string() + "\n";
  base::write_file(c.folder + "/SHA256SUMS", sums);
  const std::string seal = base::sha256_of_file(c.folder + "/SHA256SUMS");
  const std::size_t count = folders(c.folder).size();
  terminal.print(terminal.json ? base::json_text(json{{"trials", count}, {"seal", seal}})
                               : fmt::format("{} trials; seal of all truths: {}\n", count, seal));
  return command::kOk;
}

}  // namespace trials
