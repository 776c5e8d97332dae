// What does not fit into memory for a while.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace base {

/// A file without a name: it is gone with the object or the process, however that ends.
class ScratchFile {
 public:
  /// On the disk of `path`, a name that nothing has; it is in use only while this runs. Throws
  /// Error.
  explicit ScratchFile(const std::string& path);
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  ~ScratchFile();

  /// Throws Error: no room on the disk, with what was written so far.
  void append(std::string_view bytes);
  std::uint64_t size() const { return size_; }

  /// So many bytes from `begin` on. Throws Error where there are fewer.
  void read(std::uint64_t begin, char* to, std::size_t count) const;

 private:
  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace base
