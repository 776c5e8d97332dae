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

#include "base/error.h"

namespace sim {
namespace {

constexpr char kFinished = '!';  ///< of the worker: it came to the end of its work
constexpr char kEnded = '.';     ///< of the third process: the worker's status
constexpr std::uint32_t kMostMessageBytes = 1u << 28;

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

Apart::Apart(const std::function<void(const std::function<void(Words)>&)>& work,
             const std::function<void()>& afterwards)
    : from_(-1), status_(SIGKILL) {  // as long as nobody says otherwise
  std::array<int, 2> ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
    throw base::Error(std::string("no process can be started: ") + std::strerror(errno));
  from_.value = ends[0];
  const base::Descriptor to(ends[1]);
  const pid_t self = ::getpid();
  guardian_ = ::fork();
  if (guardian_ == 0) be_the_guardian(to.value, self, work, afterwards);
  if (guardian_ < 0) throw base::Error("no process can be started");
}

Apart::~Apart() {
  if (!has_ended_) ::kill(guardian_, SIGUSR1);
  // What is still said would keep it from ending.
  while (hear()) {
  }
  ::waitpid(guardian_, nullptr, 0);
}

std::optional<Words> Apart::hear() {
  while (!has_ended_) {
    char kind = 0;
    std::uint32_t size = 0;
    has_ended_ = true;
    if (!read_all(from_.value, &kind, 1) || !read_all(from_.value, &size, sizeof size)) break;
    if (size > kMostMessageBytes) break;
    bytes_.resize(size);
    if (!read_all(from_.value, bytes_.data(), size)) break;
    if (kind == kEnded && size == sizeof status_) std::memcpy(&status_, bytes_.data(), size);
    if (kind == kEnded) break;
    has_ended_ = false;
    has_finished_ = has_finished_ || kind == kFinished || kind == 'E';
    if (kind != kFinished) return Words{kind, bytes_};
  }
  return std::nullopt;
}

std::string Apart::how_it_ended() const {
  if (WIFSIGNALED(status_)) {
    const char* const name = ::strsignal(WTERMSIG(status_));
    return fmt::format("signal {}: {}", WTERMSIG(status_), name == nullptr ? "" : name);
  }
  // Foreign code may call exit().
  return has_finished_
             ? ""
             : fmt::format("it ended its process with exit code {}", WEXITSTATUS(status_));
}

std::string run_apart(const std::function<void(const std::function<void(Words)>&)>& work,
                      const std::function<void()>& afterwards,
                      const std::function<void(Words)>& take) {
  Apart apart(work, afterwards);
  while (const auto words = apart.hear()) take(*words);
  return apart.how_it_ended();
}

std::string crash_of(const std::string& path, const std::string& how,
                     std::optional<double> reached_s) {
  return fmt::format(
      "{}: the unit crashed {} ({})", path,
      reached_s ? fmt::format("after {:.6g} s", *reached_s) : "before it was initialised", how);
}

}  // namespace sim
