// Files of lines that are written while something goes on for long.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace base {

/// Lines that are in the file as soon as they are appended. Until the end it is called
/// NAME.partial.EXTENSION; then it gets its name, whatever ended it: finish(), the destructor (an
/// exception), abandon_writes() (a signal). The file of an earlier run goes when the first line
/// comes, so that it never stands for this one. After a kill -9 the lines stay in the partial file;
/// the next one for the same path calls it NAME.killed.EXTENSION, without what a line was cut to
/// (killed()). Pipes, devices and "-" are written through. One process at a time may have a path.
class GrowingFile {
 public:
  /// Makes nothing yet. Throws Error where another process writes it, or where it cannot be.
  explicit GrowingFile(const std::string& path);
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;
  ~GrowingFile();

  /// Whole lines with their ends. Throws Error where not all can be written; the file ends with the
  /// lines before then.
  void append(std::string_view lines);
  /// Nothing may be appended afterwards. Where nothing was, a file of an earlier run is removed.
  void finish();

  /// Where lines of a run that was killed lie now; empty: there were none.
  const std::string& killed() const { return killed_; }
  bool is_written_through() const { return partial_path_.empty(); }

 private:
  void open();
  void take_name() noexcept;
  friend void finish_growing() noexcept;

  std::string path_;          ///< as given, for messages
  std::string final_path_;    ///< links followed
  std::string partial_path_;  ///< empty when written through
  std::string killed_;
  int descriptor_ = -1;
  std::int64_t size_ = 0;
  bool is_finished_ = false;
};

}  // namespace base
