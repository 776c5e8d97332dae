#pragma once

#include <string>
#include <string_view>

namespace base {

/// Writes `bytes` to a temporary name beside `path`, flushes to disk, renames: a kill at any moment
/// leaves the old file or the new one. Throws Error with the path and the system's reason.
///
/// The temporary name is .NAME.PID-COUNT.part, made anew and locked (flock) while it is written;
/// such files of the same NAME that no process writes any more (it was killed) are removed on the
/// way. Only files are replaced: a symbolic link is followed and the file that it names replaced;
/// "-" (standard output), /dev/stdout and the like, a FIFO and a character device are written
/// through, from the first byte on; block devices and sockets are refused.
void write_file(const std::string& path, std::string_view bytes);

/// The same for files that are made piece by piece. Without commit() nothing is left behind.
class FileWriter {
 public:
  explicit FileWriter(const std::string& path);
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;
  ~FileWriter();

  void append(std::string_view bytes);
  void commit();  ///< flushes and renames; nothing may be appended afterwards

 private:
  std::string path_;            ///< as given, for messages
  std::string final_path_;      ///< links followed
  std::string temporary_path_;  ///< empty when written through, and after commit()
  int descriptor_ = -1;
};

/// Whether FileWriter could write `path`, without writing: to be asked before work that takes long.
/// Throws Error as it would: the folder is missing or cannot be written, the name is a folder's.
void check_writable(const std::string& path);

/// The same for a folder of outputs, which need not exist yet.
void check_writable_folder(const std::string& path);

/// For the moment before _exit() when a user interrupts: removes every unfinished file of this
/// process; files that grow (growing_file.h) keep their lines and get their names. May run beside
/// threads that write; those that still want to begin or finish a file wait for ever, so that
/// afterwards nothing new gets its final name.
void abandon_writes() noexcept;

}  // namespace base
