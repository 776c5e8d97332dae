#include "command/terminal.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "base/error.h"
#include "base/write_file.h"
#include "command/signals.h"

namespace command {
namespace {

using std::chrono::milliseconds;

constexpr std::string_view kWipe = "\r\033[K";

bool in_colour() {
  static const bool wanted = [] {
    const char* const no = std::getenv("NO_COLOR");
    const char* const kind = std::getenv("TERM");
    return ::isatty(STDERR_FILENO) && !(no && *no) && !(kind && std::strcmp(kind, "dumb") == 0);
  }();
  return wanted;
}

/// Standard error is a terminal on which a line can be wiped.
bool can_wipe() {
  const char* const kind = std::getenv("TERM");
  return ::isatty(STDERR_FILENO) && !(kind && std::strcmp(kind, "dumb") == 0);
}

std::size_t columns() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
}

[[noreturn]] void fail(int reason) {
  throw base::Error(
      fmt::format("standard output cannot be written: {}; what was printed is not whole",
                  std::strerror(reason != 0 ? reason : EIO)));
}

void write_to(std::FILE* file, std::string_view text) {
  errno = 0;
  if (std::fwrite(text.data(), 1, text.size(), file) != text.size() && file == stdout) fail(errno);
}

}  // namespace

Terminal::Terminal(std::string tool) : tool_(std::move(tool)) {}

Terminal::~Terminal() {
  try {
    say_nothing_more(*this);
    progress_done();
  } catch (...) {  // a lock that cannot be had: nothing is left to be said
  }
}

void Terminal::print(const std::string& text) {
  if (redirected()) {
    result_ += text;
    return;
  }
  if (quiet) return;
  const std::lock_guard lock(mutex_);
  wipe();
  write_to(out_, text);
}

void Terminal::line(const std::string& text, bool red) {
  const std::string name = red && in_colour() ? "\033[31m" + tool_ + ":\033[0m " : tool_ + ": ";
  write_to(stderr, name + one_line(text) + "\n");
}

void Terminal::remark(const std::string& text) {
  if (quiet) return;
  const std::lock_guard lock(mutex_);
  wipe();
  line(text, false);
}

void Terminal::error(const std::string& text) {
  progress_done();
  const std::lock_guard lock(mutex_);
  line(text, true);
}

void Terminal::start(const std::string& stage) {
  if (quiet || thread_.joinable() || !can_wipe()) return;
  stage_ = stage;
  done_ = false;
  begin_ = std::chrono::steady_clock::now();
  thread_ = std::thread([this] { show_while_running(); });
}

base::Progress Terminal::progress() {
  return [this](const std::string& stage, double share) {
    const std::lock_guard lock(mutex_);
    stage_ = stage;
    if (share == share_) return;
    share_ = share;
    share_at_ = std::chrono::steady_clock::now();
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
  const std::lock_guard lock(mutex_);
  wipe();
}

void Terminal::finish() {
  progress_done();
  if (redirected()) base::write_file(result_path_, result_);
  errno = 0;
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) fail(errno);
}

void Terminal::last_words(const std::string& text) {
  // A terminal that is stopped holds whoever writes to it: the process must end all the same.
  std::unique_lock lock(mutex_, milliseconds(300));
  const std::string words =
      (visible_ ? std::string(kWipe) : "") + tool_ + ": " + one_line(text) + "\n";
  (void)!::write(STDERR_FILENO, words.data(), words.size());
  lock.release();  // nothing is shown after it
}

void Terminal::wipe() {
  if (visible_) write_to(stderr, kWipe);
  visible_ = false;
}

namespace {

/// ", 20 s left" of work of which a share was done at `then`; empty while nobody can tell.
std::string left_of(double share, double then, double now) {
  if (now < 2.0 || share < 0.02 || share >= 1.0) return "";
  const double left = then * (1.0 - share) / share - (now - then);
  if (left < 1.0) return "";
  return left < 100.0 ? fmt::format(", {:.0f} s left", left)
                      : fmt::format(", {:.0f} min left", left / 60.0);
}

}  // namespace

void Terminal::show_while_running() {
  std::unique_lock lock(mutex_);
  if (changed_.wait_for(lock, std::chrono::seconds(1), [&] { return done_; })) return;
  do {
    const auto since_begin = [&](std::chrono::steady_clock::time_point time) {
      return std::chrono::duration<double>(time - begin_).count();
    };
    const double seconds = since_begin(std::chrono::steady_clock::now());
    const std::string share =
        share_ > 0.0 ? fmt::format("{:3.0f} % ", 100.0 * std::min(share_, 1.0)) : "";
    std::string text = one_line(fmt::format("{}{}, {:.0f} s{}", share, stage_, seconds,
                                            left_of(share_, since_begin(share_at_), seconds)));
    text.resize(std::min(text.size(), columns() - 1));
    visible_ = true;
    write_to(stderr, std::string(kWipe) + text);
    std::fflush(stderr);
  } while (!changed_.wait_for(lock, milliseconds(200), [&] { return done_; }));
}

}  // namespace command
