// What the user sees: results on standard output, progress on a terminal, one line per error.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "road/build.h"

namespace crgbuild {

/// Thrown out of a running stage after Ctrl-C.
struct Interrupted {};

class Terminal {
 public:
  bool quiet = false;  ///< results are not printed
  bool json = false;   ///< results are printed as JSON

  Terminal() = default;
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// A result: nothing with --quiet.
  void print(const std::string& text);
  /// Something the user should know although the work goes on; standard error.
  void remark(const std::string& text);

  /// For a library's long work. After a second, and only on a terminal, a line shows the stage; it
  /// is wiped when the work is done. Throws Interrupted after Ctrl-C.
  road::Progress progress();
  void progress_done();

 private:
  void show_while_running();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::thread thread_;
  std::string stage_;
  double share_ = 0.0;
  bool done_ = false, visible_ = false;
};

/// First Ctrl-C (or SIGTERM): the work stops at the next stage. Second one: at once.
void catch_interrupts();
bool interrupted();

/// Control characters replaced, line breaks too: an error is one line whatever a file name holds.
std::string one_line(const std::string& text);

}  // namespace crgbuild
