#pragma once

#include <string>
#include <string_view>

namespace files {

/// Writes `bytes` to a temporary name beside `path`, flushes to disk, renames: a kill at any moment
/// leaves the old file or the new one. Throws Error with the path and the system's reason.
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
  std::string path_, temporary_path_;
  int descriptor_ = -1;
};

}  // namespace files
