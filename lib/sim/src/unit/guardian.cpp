#include "guardian.h"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <set>
#include <sstream>
#include <string_view>
#include <vector>

#include "base/descriptor.h"
#include "base/one_line.h"
#include "sandbox.h"

namespace sim {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kTick_s = 0.05, kFolderTick_s = 1.0, kFolderShare = 0.02, kBytesPerGb = 1e9;
constexpr long kMostThreads = 1000;
constexpr std::size_t kMostFilesInFolder = 200'000;
constexpr int kMostKills = 10'000;

double since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

sigset_t guarded_signals() {
  sigset_t out;
  sigemptyset(&out);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGCHLD, SIGUSR1}) sigaddset(&out, signal);
  return out;
}

/// Of /proc/PID/stat.
struct Taken {
  char state = '?';
  pid_t parent = -1;
  long threads = 0;
  double memory_bytes = 0.0;
};

Taken taken_by(int stat) {
  std::array<char, 1024> text{};
  const ssize_t size = ::pread(stat, text.data(), text.size() - 1, 0);
  // The program's name may have anything in it, ')' too.
  const char* const name_end = size > 0 ? std::strrchr(text.data(), ')') : nullptr;
  Taken out;
  if (name_end == nullptr) return out;
  std::istringstream words(name_end + 1);
  std::vector<std::string> fields;
  for (std::string word; words >> word;) fields.push_back(word);
  constexpr std::size_t kThreads = 17, kPages = 21;  // counted from the state
  if (fields.size() <= kPages) return out;
  out.state = fields[0][0];
  out.parent = std::atoi(fields[1].c_str());
  out.threads = std::atol(fields[kThreads].c_str());
  out.memory_bytes =
      std::atof(fields[kPages].c_str()) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  return out;
}

int open_stat(pid_t process) {
  return ::open(fmt::format("/proc/{}/stat", process).c_str(), O_RDONLY | O_CLOEXEC);
}

/// Somebody looks at it step by step.
bool is_traced(pid_t process) {
  std::array<char, 4096> text{};
  const int file = ::open(fmt::format("/proc/{}/status", process).c_str(), O_RDONLY | O_CLOEXEC);
  const ssize_t size = file < 0 ? -1 : ::read(file, text.data(), text.size() - 1);
  if (file >= 0) ::close(file);
  const char* const at = size > 0 ? std::strstr(text.data(), "TracerPid:") : nullptr;
  return at != nullptr && std::atol(at + std::strlen("TracerPid:")) != 0;
}

struct Written {
  double bytes = 0.0;
  std::size_t files = 0;
};

Written written_in(const std::string& folder) {
  Written out;
  std::error_code ignored;
  for (std::filesystem::recursive_directory_iterator entry(folder, ignored), end;
       !ignored && entry != end && out.files <= kMostFilesInFolder; entry.increment(ignored)) {
    ++out.files;
    std::error_code gone;
    if (!entry->is_symlink(gone) && entry->is_regular_file(gone))
      if (const auto size = entry->file_size(gone); !gone) out.bytes += static_cast<double>(size);
  }
  return out;
}

class Guard {
 public:
  explicit Guard(const Charge& charge)
      : charge_(charge),
        stat_(open_stat(charge.worker)),
        most_bytes_(charge.limits.memory_gb * kBytesPerGb),
        calls_(charge.calls) {
    const sigset_t signals = guarded_signals();
    signals_ = ::signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
    ::fcntl(charge.printed, F_SETFL, O_NONBLOCK);
    if (!charge.limits.trusted) {
      begun_bytes_ = taken_by(stat_).memory_bytes;
      begun_in_folder_ = written_in(charge.folder);
    }
  }

  Guarded run() {
    while (!has_ended_) {
      wait();
      if (!charge_.limits.trusted && since(ticked_) >= kTick_s) tick();
    }
    kill_what_is_left();
    while (print()) {
    }
    if (WIFSIGNALED(out_.status) && WTERMSIG(out_.status) == SIGXFSZ && out_.limit.empty())
      out_.limit = fmt::format("a file of {:g} GB; at most that wanted (--unit-memory-gb)",
                               charge_.limits.memory_gb);
    for (const std::string& name : refused_)
      out_.refused += (out_.refused.empty() ? "" : ", ") + name;
    return out_;
  }

 private:
  void wait() {
    const bool has_more = !unprinted_.empty();
    std::array<pollfd, 4> waits{{{signals_, POLLIN, 0},
                                 {has_more ? -1 : printed(), POLLIN, 0},
                                 {has_more ? STDERR_FILENO : -1, POLLOUT, 0},
                                 {calls_, POLLIN, 0}}};
    ::poll(waits.data(), waits.size(),
           charge_.limits.trusted ? -1 : static_cast<int>(1e3 * kTick_s));
    if (waits[0].revents != 0) take_signals();
    if (waits[1].revents != 0 || waits[2].revents != 0) print();
    if (waits[3].revents != 0) take_calls(waits[3].revents);
  }

  int printed() const { return printed_to_the_end_ ? -1 : charge_.printed; }

  void take_signals() {
    signalfd_siginfo signal{};
    while (::read(signals_, &signal, sizeof signal) == sizeof signal)
      if (signal.ssi_signo == SIGUSR1) ::kill(charge_.worker, SIGKILL);
    int status = 0;
    for (pid_t ended = 0; (ended = ::waitpid(-1, &status, WNOHANG)) > 0;)
      if (ended == charge_.worker) {
        out_.status = status;
        has_ended_ = true;
      }
  }

  /// First comes the descriptor at which calls wait, through the socket; then the calls.
  void take_calls(short events) {
    if (are_calls_) {
      const std::string name = (events & POLLIN) != 0 ? refuse_call(calls_) : "";
      if (!name.empty()) refused_.insert(name);
      if ((events & POLLIN) == 0) calls_ = -1;
      return;
    }
    char byte = 0;
    iovec data{&byte, 1};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> room{};
    msghdr message{};
    message.msg_iov = &data;
    message.msg_iovlen = 1;
    message.msg_control = room.data();
    message.msg_controllen = room.size();
    const ssize_t got = ::recvmsg(calls_, &message, MSG_CMSG_CLOEXEC | MSG_DONTWAIT);
    const cmsghdr* const header = got == 1 ? CMSG_FIRSTHDR(&message) : nullptr;
    calls_ = -1;
    if (header == nullptr || header->cmsg_type != SCM_RIGHTS) return;
    std::memcpy(&calls_, CMSG_DATA(header), sizeof calls_);
    are_calls_ = true;
  }

  /// A piece of what it prints, never so much that standard error would be waited for. False when
  /// there is none now.
  bool print() {
    if (!unprinted_.empty()) {
      const std::size_t most = std::min<std::size_t>(unprinted_.size(), 4096);
      const ssize_t count = ::write(STDERR_FILENO, unprinted_.data(), most);
      // A standard error that is gone takes nothing, for ever.
      if (count < 0 && errno != EINTR && errno != EAGAIN) unprinted_.clear();
      if (count > 0) unprinted_.erase(0, static_cast<std::size_t>(count));
      return count > 0 || unprinted_.empty();
    }
    std::array<char, 16384> piece{};
    const ssize_t count = ::read(charge_.printed, piece.data(), piece.size());
    if (count == 0) printed_to_the_end_ = true;
    if (count <= 0) return false;
    printed_bytes_ += static_cast<double>(count);
    half_ += std::string_view(piece.data(), static_cast<std::size_t>(count));
    // The second byte of a control character of Unicode may come later.
    const bool is_half = half_.back() == '\xC2';
    unprinted_ =
        base::visible(std::string_view(half_).substr(0, half_.size() - (is_half ? 1 : 0)), "\n\t");
    half_ = is_half ? "\xC2" : "";
    return true;
  }

  void end_it(const std::string& limit) {
    if (!out_.limit.empty()) return;
    out_.limit = limit;
    ::kill(charge_.worker, SIGKILL);
  }

  void tick() {
    // While all was stopped no time has passed.
    const double passed_s = std::min(since(ticked_), 2.0 * kTick_s);
    ticked_ = Clock::now();
    const Taken taken = taken_by(stat_);
    look_at_time(taken.state, passed_s);
    const UnitLimits& limits = charge_.limits;
    if (taken.memory_bytes - begun_bytes_ > most_bytes_)
      end_it(fmt::format("{:.3g} GB of memory; at most {:g} wanted (--unit-memory-gb)",
                         (taken.memory_bytes - begun_bytes_) / kBytesPerGb, limits.memory_gb));
    if (taken.threads > kMostThreads)
      end_it(fmt::format("{} threads; at most {} wanted (--trust takes all limits away)",
                         taken.threads, kMostThreads));
    if (printed_bytes_ > UnitLimits::kPrintedShare * most_bytes_)
      end_it(fmt::format("{:.3g} GB printed; at most {:g} wanted (a twentieth of --unit-memory-gb)",
                         printed_bytes_ / kBytesPerGb,
                         UnitLimits::kPrintedShare * limits.memory_gb));
    if (since(folder_looked_at_) >= folder_tick_s_) look_at_folder();
  }

  void look_at_time(char state, double passed_s) {
    const std::uint32_t now = charge_.watch.now.load(std::memory_order_relaxed);
    auto kind = static_cast<Watch::Kind>(now & Watch::kKinds);
    // A thread of its own may stop it in between.
    if (kind == Watch::kOutside && state == 'T') kind = Watch::kStep;
    step_s_ = kind == Watch::kStep && now == seen_ ? step_s_ + passed_s : 0.0;
    start_s_ = kind == Watch::kStart ? start_s_ + passed_s : 0.0;
    seen_ = now;
    const double most_s = charge_.limits.step_s, most_start_s = UnitLimits::kStartSteps * most_s;
    if (step_s_ <= most_s && start_s_ <= most_start_s) return;
    if (is_traced(charge_.worker)) {
      step_s_ = start_s_ = 0.0;
      return;
    }
    if (start_s_ > most_start_s)
      end_it(fmt::format("its start took {:.2f} s; at most {:g} wanted (12 times --unit-step-s)",
                         start_s_, most_start_s));
    else
      end_it(fmt::format("a step took {:.2f} s; at most {:g} wanted (--unit-step-s)", step_s_,
                         most_s));
  }

  void look_at_folder() {
    const Clock::time_point begin = Clock::now();
    const Written written = written_in(charge_.folder);
    const double more_bytes = written.bytes - begun_in_folder_.bytes;
    if (more_bytes > most_bytes_)
      end_it(fmt::format("{:.3g} GB written to files; at most {:g} wanted (--unit-memory-gb)",
                         more_bytes / kBytesPerGb, charge_.limits.memory_gb));
    if (written.files > kMostFilesInFolder)
      end_it(fmt::format("more than {} files; fewer wanted (--trust takes all limits away)",
                         kMostFilesInFolder));
    folder_tick_s_ = std::max(kFolderTick_s, since(begin) / kFolderShare);
    folder_looked_at_ = Clock::now();
  }

  /// What it detached has this process for a parent when its own is gone.
  static void kill_what_is_left() {
    for (int k = 0; k < kMostKills && (::waitpid(-1, nullptr, WNOHANG) >= 0 || errno != ECHILD);
         ++k) {
      DIR* const processes = ::opendir("/proc");
      if (processes == nullptr) return;
      while (const dirent* const entry = ::readdir(processes)) {
        const pid_t process = std::atoi(entry->d_name);
        if (process <= 0) continue;
        const base::Descriptor stat(open_stat(process));
        if (taken_by(stat.value).parent == ::getpid()) ::kill(process, SIGKILL);
      }
      ::closedir(processes);
      while (::waitpid(-1, nullptr, WNOHANG) > 0) {
      }
      ::usleep(1000);
    }
  }

  const Charge& charge_;
  int stat_, signals_ = -1;
  double most_bytes_, begun_bytes_ = 0.0, printed_bytes_ = 0.0;
  Written begun_in_folder_;
  Clock::time_point ticked_ = Clock::now(), folder_looked_at_ = Clock::now();
  double folder_tick_s_ = kFolderTick_s, step_s_ = 0.0, start_s_ = 0.0;
  std::uint32_t seen_ = 0;
  int calls_;
  bool are_calls_ = false, has_ended_ = false, printed_to_the_end_ = false;
  std::string half_, unprinted_;
  std::set<std::string> refused_;
  Guarded out_;
};

}  // namespace

void block_guarded_signals() {
  const sigset_t signals = guarded_signals();
  sigprocmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGCHLD, SIG_DFL);
}

Guarded guard(const Charge& charge) { return Guard(charge).run(); }

void hand_on(int socket, int descriptor) {
  if (descriptor < 0) return;
  char byte = 0;
  iovec data{&byte, 1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> room{};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = room.data();
  message.msg_controllen = room.size();
  cmsghdr* const header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_SOCKET;
  header->cmsg_type = SCM_RIGHTS;
  header->cmsg_len = CMSG_LEN(sizeof(int));
  std::memcpy(CMSG_DATA(header), &descriptor, sizeof descriptor);
  ::sendmsg(socket, &message, 0);
  ::close(descriptor);
}

}  // namespace sim
