#include "view/jobs.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <deque>
#include <mutex>
#include <thread>

#include "base/descriptor.h"
#include "base/error.h"
#include "wish.h"

namespace view {
namespace {

using Clock = std::chrono::steady_clock;

double since_s(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

struct Task {
  Job job;
  pid_t process = -1;
  int out = -1, terminal = -1;  ///< read ends
  Clock::time_point begin = Clock::now();
  Clock::time_point stop_asked{};
  std::string output, line;
  std::thread thread;
};

std::runtime_error no(const char* what) {
  return base::Error(fmt::format("{}: {}", what, std::strerror(errno)));
}

bool has_ended(ssize_t got) { return got == 0 || (got < 0 && errno != EINTR && errno != EAGAIN); }

/// What a terminal shows after these bytes: lines that were wiped leave nothing but the last.
void take_shown(Task& task, std::string_view bytes) {
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    const char c = bytes[k];
    if (c == '\r' || c == '\n') {
      if (!task.line.empty()) task.job.progress = task.line;
      const bool ends = c == '\n';
      if (ends && !task.line.empty()) task.job.messages += task.line + "\n";
      task.line.clear();
    } else if (c == '\033') {  // wipes and colours
      while (k + 1 < bytes.size() && std::isalpha(static_cast<unsigned char>(bytes[k])) == 0) ++k;
    } else {
      task.line += c;
    }
  }
  if (task.job.messages.size() > kMostMessages)
    task.job.messages.erase(0, task.job.messages.size() - kMostMessages);
  if (task.line.size() > kMostMessages) task.line.clear();
}

}  // namespace

struct Jobs::Running {
  mutable std::mutex mutex;
  std::deque<std::unique_ptr<Task>> tasks;
  int next = 1;

  Task* find(int id) const {
    for (const auto& task : tasks)
      if (task->job.id == id) return task.get();
    return nullptr;
  }

  /// Reads until both ends are closed, then waits for the process.
  void follow(Task& task) {
    std::array<char, 65536> buffer;
    bool is_out = true, is_terminal = true;
    while (is_out || is_terminal) {
      pollfd ends[2] = {{is_out ? task.out : -1, POLLIN, 0},
                        {is_terminal ? task.terminal : -1, POLLIN, 0}};
      ::poll(ends, 2, 200);
      const std::lock_guard lock(mutex);
      task.job.seconds = since_s(task.begin);
      if (task.stop_asked != Clock::time_point{} && since_s(task.stop_asked) > 2.0)
        ::kill(-task.process, SIGKILL);
      if ((ends[0].revents & (POLLIN | POLLHUP | POLLERR)) != 0) {
        const ssize_t got = ::read(task.out, buffer.data(), buffer.size());
        if (has_ended(got)) is_out = false;
        if (got > 0) task.output.append(buffer.data(), static_cast<std::size_t>(got));
        if (task.output.size() > kMostOutput) {
          task.job.messages += "more output than this page takes; stopped\n";
          ::kill(-task.process, SIGKILL);
          is_out = false;
        }
      }
      if ((ends[1].revents & (POLLIN | POLLHUP | POLLERR)) != 0) {
        const ssize_t got = ::read(task.terminal, buffer.data(), buffer.size());
        if (has_ended(got)) is_terminal = false;  // EIO: nobody holds the other end
        if (got > 0) take_shown(task, {buffer.data(), static_cast<std::size_t>(got)});
      }
    }
    int status = 0;
    while (::waitpid(task.process, &status, 0) < 0 && errno == EINTR) {
    }
    const std::lock_guard lock(mutex);
    if (!task.line.empty()) task.job.messages += task.line + "\n";
    ::close(task.out);
    ::close(task.terminal);
    task.job.seconds = since_s(task.begin);
    task.job.exit_code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    task.job.output_bytes = task.output.size();
    task.job.is_running = false;
  }
};

Jobs::Jobs(std::string tools) : tools_(std::move(tools)), running_(std::make_unique<Running>()) {}

Jobs::~Jobs() {
  {
    const std::lock_guard lock(running_->mutex);
    for (const auto& task : running_->tasks)
      if (task->job.is_running) ::kill(-task->process, SIGKILL);
  }
  for (const auto& task : running_->tasks)
    if (task->thread.joinable()) task->thread.join();
}

int Jobs::start(const std::vector<std::string>& command, const std::string& folder) {
  const std::lock_guard lock(running_->mutex);
  std::size_t busy = 0;
  for (const auto& task : running_->tasks) {
    if (task->job.is_running)
      ++busy;
    else if (task->thread.joinable())
      task->thread.join();  // it has nothing left to do
  }
  if (busy >= kMostRunning)
    throw Refusal(429,
                  fmt::format("{} commands run already; wait for one of them or stop it", busy));

  // Outputs are for whoever asked; the oldest that have ended go.
  for (std::size_t k = 0; k + kMostOutputs < running_->tasks.size(); ++k)
    if (!running_->tasks[k]->job.is_running) std::string().swap(running_->tasks[k]->output);

  const base::Descriptor terminal(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (terminal.value < 0 || ::grantpt(terminal.value) != 0 || ::unlockpt(terminal.value) != 0)
    throw no("no terminal for a command");
  std::array<char, 128> name;
  if (::ptsname_r(terminal.value, name.data(), name.size()) != 0)
    throw no("no terminal for a command");
  termios mode{};
  if (::tcgetattr(terminal.value, &mode) != 0) throw no("no terminal for a command");
  mode.c_oflag &= ~static_cast<tcflag_t>(OPOST);  // "\n" stays what it is
  ::tcsetattr(terminal.value, TCSANOW, &mode);
  std::array<int, 2> pipe;
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0) throw no("no pipe for a command");
  const base::Descriptor read_end(pipe[0]), write_end(pipe[1]);

  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawnattr_init(&attributes);
  ::posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  ::posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, write_end.value, 1);
  // As the first terminal of a new session it is the one that rules it: when this process ends,
  // however it does, the command gets SIGHUP.
  ::posix_spawn_file_actions_addopen(&actions, 2, name.data(), O_RDWR, 0);
  sigset_t none;
  ::sigemptyset(&none);
  ::posix_spawnattr_setsigmask(&attributes, &none);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK);
  std::vector<char*> words;
  words.reserve(command.size() + 1);
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  const std::string beside = tools_ + "/" + command.front();
  const std::string program = ::access(beside.c_str(), X_OK) == 0 ? beside : command.front();
  auto task = std::make_unique<Task>();
  const int failed =
      ::posix_spawnp(&task->process, program.c_str(), &actions, &attributes, words.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::posix_spawnattr_destroy(&attributes);
  if (failed != 0)
    throw base::Error(fmt::format("{} cannot be started: {}", program, std::strerror(failed)));
  task->out = ::fcntl(read_end.value, F_DUPFD_CLOEXEC, 0);
  task->terminal = ::fcntl(terminal.value, F_DUPFD_CLOEXEC, 0);
  task->job.id = running_->next++;
  task->job.command = command;
  task->job.folder = folder;
  Task& begun = *task;
  running_->tasks.push_back(std::move(task));
  begun.thread = std::thread([this, &begun] { running_->follow(begun); });
  return begun.job.id;
}

void Jobs::stop(int id) {
  const std::lock_guard lock(running_->mutex);
  Task* const task = running_->find(id);
  if (task == nullptr || !task->job.is_running) return;
  task->stop_asked = Clock::now();
  ::kill(-task->process, SIGTERM);
}

std::vector<Job> Jobs::list() const {
  const std::lock_guard lock(running_->mutex);
  std::vector<Job> jobs;
  for (const auto& task : running_->tasks) jobs.push_back(task->job);
  if (jobs.size() > kMostKept) jobs.erase(jobs.begin(), jobs.end() - kMostKept);
  return jobs;
}

std::string Jobs::output(int id) const {
  const std::lock_guard lock(running_->mutex);
  const Task* const task = running_->find(id);
  if (task == nullptr) throw base::Error(fmt::format("no command with the number {}", id));
  if (task->job.is_running) throw base::Error(fmt::format("command {} still runs", id));
  return task->output;
}

}  // namespace view
