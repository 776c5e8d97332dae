#include "apart.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <exception>

#include "base/descriptor.h"
#include "base/error.h"

namespace sim {
namespace {

constexpr char kFinished = '!';  ///< of the worker: it came to the end of its work
constexpr char kEnded = '.';     ///< of the third process: the worker's status
constexpr std::uint32_t kMostBytes = 1u << 28;

bool write_all(int to, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t count = ::write(to, at, size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    at += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

bool read_all(int from, void* data, std::size_t size) {
  char* at = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t count = ::read(from, at, size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    at += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

void say(int to, Words words) {
  const auto size = static_cast<std::uint32_t>(words.bytes.size());
  if (!write_all(to, &words.kind, 1) || !write_all(to, &size, sizeof size) ||
      !write_all(to, words.bytes.data(), size))
    ::_exit(1);  // nobody listens any more
}

void plain_signals() {
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(signal, SIG_DFL);
}

[[noreturn]] void be_the_worker(
    int to, const std::function<void(const std::function<void(Words)>&)>& work) {
  plain_signals();
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::dup2(STDERR_FILENO, STDOUT_FILENO);
  try {
    work([to](Words words) { say(to, words); });
    say(to, {kFinished, {}});
  } catch (const std::exception& error) {
    say(to, {'E', error.what()});
  } catch (...) {
    say(to, {'E', "an exception that says nothing"});
  }
  ::_exit(0);
}

/// Waits for the worker and for the end of the process that wants it.
[[noreturn]] void be_the_guardian(
    int to, pid_t parent, const std::function<void(const std::function<void(Words)>&)>& work,
    const std::function<void()>& afterwards) {
  sigset_t watched;
  sigemptyset(&watched);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGCHLD, SIGUSR1}) sigaddset(&watched, signal);
  sigprocmask(SIG_BLOCK, &watched, nullptr);
  std::signal(SIGCHLD, SIG_DFL);
  ::prctl(PR_SET_PDEATHSIG, SIGUSR1);
  const pid_t worker = ::getppid() == parent ? ::fork() : -1;
  if (worker == 0) be_the_worker(to, work);
  int status = 0;
  while (worker > 0) {
    int signal = 0;
    sigwait(&watched, &signal);
    if (signal == SIGUSR1) ::kill(worker, SIGKILL);
    if (signal == SIGUSR1 || signal == SIGCHLD)
      if (::waitpid(worker, &status, signal == SIGUSR1 ? 0 : WNOHANG) == worker) break;
  }
  afterwards();
  std::signal(SIGPIPE, SIG_IGN);
  say(to, {kEnded, {reinterpret_cast<const char*>(&status), sizeof status}});
  ::_exit(worker > 0 ? 0 : 1);
}

}  // namespace

std::string run_apart(const std::function<void(const std::function<void(Words)>& say)>& work,
                      const std::function<void()>& afterwards,
                      const std::function<void(Words)>& take) {
  std::array<int, 2> ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
    throw base::Error(std::string("no process can be started: ") + std::strerror(errno));
  base::Descriptor from(ends[0]);
  pid_t guardian = -1;
  {
    base::Descriptor to(ends[1]);
    const pid_t self = ::getpid();
    guardian = ::fork();
    if (guardian == 0) be_the_guardian(to.value, self, work, afterwards);
  }
  if (guardian < 0) throw base::Error("no process can be started");
  int status = SIGKILL;  // as long as nobody says otherwise
  bool finished = false;
  std::string bytes;
  try {
    while (true) {
      char kind = 0;
      std::uint32_t size = 0;
      if (!read_all(from.value, &kind, 1) || !read_all(from.value, &size, sizeof size)) break;
      if (size > kMostBytes) break;
      bytes.resize(size);
      if (!read_all(from.value, bytes.data(), size)) break;
      if (kind == kEnded && size == sizeof status)
        std::memcpy(&status, bytes.data(), size);
      else if (kind == kFinished || kind == 'E')
        finished = true;
      if (kind != kEnded && kind != kFinished) take({kind, bytes});
    }
  } catch (...) {
    ::kill(guardian, SIGUSR1);
    ::waitpid(guardian, nullptr, 0);
    throw;
  }
  ::waitpid(guardian, nullptr, 0);
  if (WIFSIGNALED(status)) {
    const char* const name = ::strsignal(WTERMSIG(status));
    return fmt::format("signal {}: {}", WTERMSIG(status), name == nullptr ? "" : name);
  }
  // Foreign code may call exit().
  return finished ? "" : fmt::format("it ended its process with exit code {}", WEXITSTATUS(status));
}

void want_no_crash(const std::string& path, const std::string& how,
                   std::optional<double> reached_s) {
  if (how.empty()) return;
  throw base::Error(fmt::format(
      "{}: the unit crashed {} ({})", path,
      reached_s ? fmt::format("after {:.6g} s", *reached_s) : "before it was initialised", how));
}

}  // namespace sim
