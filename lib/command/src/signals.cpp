#include "command/signals.h"

#include <pthread.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <mutex>
#include <thread>

#include "base/write_file.h"
#include "command/terminal.h"

namespace command {
namespace {

volatile std::sig_atomic_t exit_code = 1;

void at_once(int) { ::_exit(exit_code); }

Terminal* speaker = nullptr;  ///< says the last words; none once it is destroyed

std::mutex& speaker_guard() {
  static auto& guard = *new std::mutex;  // never destroyed: the watching thread may outlive main
  return guard;
}

}  // namespace

void end_on_signals(Terminal& terminal) {
  sigset_t watched;
  sigemptyset(&watched);
  struct sigaction hangup {};
  ::sigaction(SIGHUP, nullptr, &hangup);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    if (signal == SIGHUP && hangup.sa_handler == SIG_IGN) continue;
    std::signal(signal, SIG_DFL);
    sigaddset(&watched, signal);
  }
  // A file beyond the limit of the shell (ulimit -f) is then an error of the writer, with its name.
  std::signal(SIGXFSZ, SIG_IGN);
  pthread_sigmask(SIG_BLOCK, &watched, nullptr);
  speaker = &terminal;
  std::thread([watched] {
    int signal = 0;
    sigwait(&watched, &signal);
    exit_code = 128 + signal;
    // Whatever hangs on the way (a disk, a stopped terminal), the process is gone in a second.
    std::signal(SIGALRM, at_once);
    ::alarm(1);
    base::abandon_writes();
    speaker_guard().lock();  // for good: whoever destroys the terminal waits for the end
    if (speaker != nullptr) speaker->last_words("interrupted; no file is half-written");
    ::_exit(exit_code);
  }).detach();
}

void say_nothing_more(const Terminal& terminal) {
  const std::lock_guard lock(speaker_guard());
  if (speaker == &terminal) speaker = nullptr;
}

void end_with_parent() noexcept {
  sigset_t none;
  sigemptyset(&none);
  pthread_sigmask(SIG_SETMASK, &none, nullptr);
  std::signal(SIGXFSZ, SIG_DFL);
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
}

}  // namespace command
