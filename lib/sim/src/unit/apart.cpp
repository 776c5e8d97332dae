#include "apart.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <exception>
#include <new>

#include "base/error.h"
#include "base/one_line.h"
#include "guardian.h"
#include "sandbox.h"

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
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_DFL);
}

/// The ends of the pipes and the socket between worker and guardian.
struct Ends {
  int said, printed_out, printed_in, calls_out, calls_in;
};

void confine(const ApartPlace& place, const Ends& ends) {
  if (place.limits.trusted) {
    if (place.before) place.before();
    return;
  }
  std::vector<int> keep = place.keep;
  keep.insert(keep.end(), {ends.said, ends.calls_in});
  confine_files(place.folder, place.limits.memory_gb * 1e9, keep, place.real_time);
  if (place.before) place.before();
  hand_on(ends.calls_in, confine_calls());
  ::close(ends.calls_in);
}

[[noreturn]] void be_the_worker(const Ends& ends, const ApartPlace& place, const ApartWork& work,
                                Watch& watch) {
  plain_signals();
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::dup2(ends.printed_in, STDOUT_FILENO);
  ::dup2(ends.printed_in, STDERR_FILENO);
  for (const int of_guardian : {ends.printed_in, ends.printed_out, ends.calls_out})
    ::close(of_guardian);
  const int to = ends.said;
  try {
    confine(place, ends);
    work([to](Words words) { say(to, words); }, place.limits.trusted ? nullptr : &watch);
    say(to, {kFinished, {}});
  } catch (const std::exception& error) {
    say(to, {'E', error.what()});
  } catch (...) {
    say(to, {'E', "an exception that says nothing"});
  }
  ::_exit(0);
}

/// Waits for the worker and for the end of the process that wants it.
[[noreturn]] void be_the_guardian(int to, pid_t parent, const ApartPlace& place,
                                  const ApartWork& work, const std::function<void()>& afterwards,
                                  Watch& watch) {
  block_guarded_signals();
  ::prctl(PR_SET_PDEATHSIG, SIGUSR1);
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  std::signal(SIGPIPE, SIG_IGN);
  std::array<int, 2> printed{-1, -1}, calls{-1, -1};
  const bool has_pipes = ::pipe2(printed.data(), O_CLOEXEC) == 0 &&
                         ::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0, calls.data()) == 0;
  const Ends ends{to, printed[0], printed[1], calls[0], calls[1]};
  const pid_t worker = has_pipes && ::getppid() == parent ? ::fork() : -1;
  if (worker == 0) be_the_worker(ends, place, work, watch);
  ::close(ends.printed_in);
  ::close(ends.calls_in);
  Guarded guarded;
  if (worker > 0)
    guarded = guard({worker, ends.printed_out, ends.calls_out, watch, place.folder, place.limits});
  afterwards();
  std::string ending(reinterpret_cast<const char*>(&guarded.status), sizeof guarded.status);
  ending += guarded.limit + '\n' + guarded.refused;
  say(to, {kEnded, ending});
  ::_exit(worker > 0 ? 0 : 1);
}

}  // namespace

Apart::Apart(const ApartPlace& place, const ApartWork& work,
             const std::function<void()>& afterwards)
    : from_(-1), status_(SIGKILL) {  // as long as nobody says otherwise
  std::array<int, 2> ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
    throw base::Error(std::string("no process can be started: ") + std::strerror(errno));
  from_.value = ends[0];
  const base::Descriptor to(ends[1]);
  void* const memory =
      ::mmap(nullptr, sizeof(Watch), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw base::Error("no process can be started: no memory for it");
  watch_ = new (memory) Watch;
  const pid_t self = ::getpid();
  guardian_ = ::fork();
  if (guardian_ == 0) be_the_guardian(to.value, self, place, work, afterwards, *watch_);
  if (guardian_ < 0) throw base::Error("no process can be started");
}

Apart::~Apart() {
  // Foreign code may have said that all had ended.
  ::kill(guardian_, SIGUSR1);
  // What is still said would keep it from ending.
  while (hear()) {
  }
  for (std::array<char, 4096> unheard{}; ::read(from_.value, unheard.data(), unheard.size()) > 0;) {
  }
  ::waitpid(guardian_, nullptr, 0);
  ::munmap(watch_, sizeof(Watch));
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
    if (kind == kEnded) take_ending();
    if (kind == kEnded) break;
    has_ended_ = false;
    has_finished_ = has_finished_ || kind == kFinished || kind == 'E';
    if (kind != kFinished) return Words{kind, bytes_};
  }
  return std::nullopt;
}

void Apart::take_ending() {
  if (bytes_.size() < sizeof status_) return;
  std::memcpy(&status_, bytes_.data(), sizeof status_);
  const std::string said = bytes_.substr(sizeof status_);
  const std::size_t line = std::min(said.find('\n'), said.size());
  ending_.how = base::one_line(said.substr(0, line));
  ending_.by_limit = !ending_.how.empty();
  if (line < said.size()) ending_.refused = base::one_line(said.substr(line + 1));
}

Ending Apart::ending() const {
  Ending out = ending_;
  if (out.by_limit) return out;
  if (WIFSIGNALED(status_)) {
    const char* const name = ::strsignal(WTERMSIG(status_));
    out.how = fmt::format("signal {}: {}", WTERMSIG(status_), name == nullptr ? "" : name);
  } else if (!has_finished_) {  // foreign code may call exit()
    out.how = fmt::format("it ended its process with exit code {}", WEXITSTATUS(status_));
  }
  return out;
}

Ending run_apart(const ApartPlace& place, const ApartWork& work,
                 const std::function<void()>& afterwards, const std::function<void(Words)>& take) {
  Apart apart(place, work, afterwards);
  while (const auto words = apart.hear()) take(*words);
  return apart.ending();
}

std::string crash_of(const std::string& path, const Ending& ending,
                     std::optional<double> reached_s) {
  if (ending.how.empty()) return {};
  const std::string when =
      reached_s ? fmt::format("after {:.6g} s", *reached_s) : "before it was initialised";
  return ending.by_limit ? fmt::format("{}: the unit was ended {}: {}", path, when, ending.how)
                         : fmt::format("{}: the unit crashed {} ({})", path, when, ending.how);
}

std::string refused_to(const Ending& ending) {
  return ending.refused.empty()
             ? ""
             : fmt::format("; its sandbox refused it {} (--trust runs it without)", ending.refused);
}

}  // namespace sim
