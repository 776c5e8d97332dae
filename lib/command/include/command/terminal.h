// What the user sees: results on standard output, remarks, progress and errors on standard error.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <string>
#include <thread>

#include "base/one_line.h"
#include "base/progress.h"
#include "base/shell_word.h"

namespace command {

class Terminal {
 public:
  bool quiet = false;  ///< results, remarks and progress are not shown
  bool json = false;   ///< results are printed as JSON

  explicit Terminal(std::string tool);
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  ~Terminal();

  const std::string& tool() const { return tool_; }

  /// A result, on standard output or where redirect() says; nothing with --quiet. Throws
  /// base::Error when it cannot be written.
  void print(const std::string& text);

  /// From now on results are kept and written to this file by finish().
  void redirect(std::string path) { result_path_ = std::move(path); }
  bool redirected() const { return !result_path_.empty(); }

  /// Results go to standard error: what was asked for itself goes to standard output.
  void results_to_stderr() { out_ = stderr; }

  /// Something the user should know although the work goes on; one line on standard error.
  void remark(const std::string& text);

  /// One line on standard error, also with --quiet.
  void error(const std::string& text);

  /// From now on, only on a terminal, a line shows the stage and the seconds once they are more
  /// than one; whoever prints wipes it.
  void start(const std::string& stage);

  /// For a library's long work: sets stage and share of that line; from these, once two seconds and
  /// two per cent are over, the time that is left.
  base::Progress progress();

  /// Wipes the line; there is no other.
  void progress_done();

  /// The end of the work: wipes the line, writes what redirect() kept and whatever is still on its
  /// way to standard output. Throws base::Error when that fails.
  void finish();

  /// For the thread that waits for signals: like error(), and nothing is shown after it.
  void last_words(const std::string& text);

 private:
  void show_while_running();
  void wipe();  ///< with the mutex held
  void line(const std::string& text, bool in_colour);

  std::string tool_, result_path_, result_;
  std::FILE* out_ = stdout;
  std::timed_mutex mutex_;
  std::condition_variable_any changed_;
  std::thread thread_;
  std::chrono::steady_clock::time_point begin_, share_at_;
  std::string stage_;
  double share_ = 0.0;
  bool done_ = false, visible_ = false;
};

using base::one_line, base::shell_word;

}  // namespace command
