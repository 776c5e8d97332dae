#include "terminal.h"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>

namespace crgbuild {
namespace {

volatile std::sig_atomic_t interrupt_seen = 0;

void on_interrupt(int signal) {
  interrupt_seen = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void catch_interrupts() {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
}

bool interrupted() { return interrupt_seen != 0; }

std::string one_line(const std::string& text) {
  std::string out;
  for (char c : text) {
    const bool control = static_cast<unsigned char>(c) < 32 || c == 127;
    if (!control)
      out += c;
    else if (!out.empty() && out.back() != ' ')
      out += ' ';
  }
  while (!out.empty() && out.back() == ' ') out.pop_back();
  return out;
}

Terminal::~Terminal() { progress_done(); }

void Terminal::print(const std::string& text) {
  if (quiet) return;
  std::fwrite(text.data(), 1, text.size(), stdout);
}

void Terminal::remark(const std::string& text) {
  if (quiet) return;
  const std::string line = "crgbuild: " + one_line(text) + "\n";
  std::fwrite(line.data(), 1, line.size(), stderr);
}

road::Progress Terminal::progress() {
  if (!quiet && ::isatty(STDERR_FILENO) && !thread_.joinable()) {
    done_ = false;
    thread_ = std::thread([this] { show_while_running(); });
  }
  return [this](const std::string& stage, double share) {
    if (interrupted()) throw Interrupted{};
    const std::lock_guard lock(mutex_);
    stage_ = stage;
    share_ = share;
  };
}

void Terminal::progress_done() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    done_ = true;
  }
  changed_.notify_all();
  thread_.join();
  if (visible_) std::fputs("\r\033[K", stderr);
  visible_ = false;
}

void Terminal::show_while_running() {
  std::unique_lock lock(mutex_);
  if (changed_.wait_for(lock, std::chrono::seconds(1), [&] { return done_; })) return;
  do {
    visible_ = true;
    fmt::print(stderr, "\r\033[K{:3.0f} % {}", 100.0 * share_, stage_);
    std::fflush(stderr);
  } while (!changed_.wait_for(lock, std::chrono::milliseconds(200), [&] { return done_; }));
}

}  // namespace crgbuild
