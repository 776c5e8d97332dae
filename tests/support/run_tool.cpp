#include "support/run_tool.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "support/places.h"
#include "support/run_crgbuild.h"

namespace support {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

void become(const std::string& program, const std::vector<std::string>& arguments) {
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  // Ignored where the tests run in the background of a shell: a signal before main() would be lost.
  std::signal(SIGINT, SIG_DFL);
  ::execv(argv[0], argv.data());
  ::_exit(127);
}

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
constexpr bool kCanLimit = false;  // a sanitizer takes addresses by the terabyte
#else
constexpr bool kCanLimit = true;
#endif
#else
constexpr bool kCanLimit = true;
#endif

void limit(const ToolOptions& options) {
  const rlimit most{options.most_address_bytes, options.most_address_bytes};
  if (kCanLimit && options.most_address_bytes > 0) ::setrlimit(RLIMIT_AS, &most);
  if (options.most_clock_s > 0) ::alarm(options.most_clock_s);  // it outlives exec
}

/// Until the file exists, or the process has ended.
void wait_for(const std::string& path, pid_t child) {
  siginfo_t ended{};
  while (::access(path.c_str(), F_OK) != 0 && ended.si_pid == 0 &&
         ::waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT) == 0)
    std::this_thread::sleep_for(std::chrono::microseconds(20));
}

int code_of(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

}  // namespace

ToolRun run_tool(const std::string& program, const std::vector<std::string>& arguments,
                 const ToolOptions& options) {
  const cli::Folder folder;
  const std::string out = options.out.empty() ? folder / "out" : options.out, err = folder / "err";
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(::open(options.in.c_str(), O_RDONLY), 0);
    ::dup2(::open(out.c_str(), O_WRONLY | O_CREAT, 0600), 1);
    ::dup2(::open(err.c_str(), O_WRONLY | O_CREAT, 0600), 2);
    limit(options);
    become(program, arguments);
  }
  ToolRun ran;
  if (!options.signal_once_exists.empty()) wait_for(options.signal_once_exists, child);
  if (options.signal_after_s > 0.0) {
    std::this_thread::sleep_for(std::chrono::duration<double>(options.signal_after_s));
    ::kill(child, options.signal);
  }
  const auto begin = Clock::now();
  int status = 0;
  rusage used{};
  ::wait4(child, &status, 0, &used);
  ran.seconds_after_signal = seconds_since(begin);
  ran.processor_s = static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
                    1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
  ran.most_resident_bytes = static_cast<std::size_t>(used.ru_maxrss) << 10;
  ran.code = code_of(status);
  if (options.out.empty()) ran.out = cli::read(out);
  ran.err = cli::read(err);
  return ran;
}

ToolRun run_on_terminal(const std::string& program, const std::vector<std::string>& arguments,
                        const std::string& until, const std::vector<std::string>& environment) {
  int terminal = -1;
  const pid_t child = ::forkpty(&terminal, nullptr, nullptr, nullptr);
  if (child < 0) throw std::runtime_error("no pseudo terminal");
  if (child == 0) {
    ::setenv("TERM", "xterm", 1);
    ::unsetenv("NO_COLOR");
    for (const std::string& one : environment) ::putenv(const_cast<char*>(one.c_str()));
    become(program, arguments);
  }
  ToolRun ran;
  const std::regex wanted(until);
  bool seen = false;
  const auto begin = Clock::now();
  auto signalled = begin;
  for (char bytes[4096];;) {
    pollfd one{terminal, POLLIN, 0};
    if (::poll(&one, 1, 1000) < 0) break;
    if (one.revents != 0) {
      const ssize_t count = ::read(terminal, bytes, sizeof bytes);
      if (count <= 0) break;  // it has ended
      ran.err.append(bytes, static_cast<std::size_t>(count));
    }
    if (!seen && !until.empty() && std::regex_search(ran.err, wanted)) {
      seen = true;
      signalled = Clock::now();
      (void)!::write(terminal, "\003", 1);  // Ctrl-C
    }
    if (seconds_since(begin) > 120.0) ::kill(child, SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ::close(terminal);
  ran.seconds_after_signal = seconds_since(signalled);
  ran.code = code_of(status);
  return ran;
}

std::vector<Tool> all_tools() {
  return {{"crgbuild", places::crgbuild()},     {"crgdrive", places::crgdrive()},
          {"crgexplain", places::crgexplain()}, {"crgidentify", places::crgidentify()},
          {"crgsim", places::crgsim()},         {"lidar2mesh", places::lidar2mesh()},
          {"kerbstone", places::kerbstone()}};
}

std::vector<std::vector<std::string>> commands_of(const Tool& tool) {
  std::vector<std::vector<std::string>> found, open{{}};
  while (!open.empty()) {
    const std::vector<std::string> at = open.front();
    open.erase(open.begin());
    std::vector<std::string> arguments = at;
    arguments.push_back("--help");
    std::istringstream help(run_tool(tool.path, arguments).out);
    bool inside = false, any = false;
    for (std::string line; std::getline(help, line);) {
      if (line == "Subcommands:") {
        inside = true;
      } else if (line.empty() || line[0] != ' ') {
        inside = false;
      } else if (inside && line.size() > 2 && line[2] != ' ') {
        std::vector<std::string> below = at;
        below.push_back(line.substr(2, line.find(' ', 2) - 2));
        open.push_back(below);
        any = true;
      }
    }
    if (!any) found.push_back(at);
  }
  return found;
}

}  // namespace support
