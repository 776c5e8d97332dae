// A file's bytes without copying them into memory.
#pragma once

#include <string>
#include <string_view>

namespace cloud {

/// Read-only; the system drops pages it needs elsewhere, so a file may be larger than memory.
class MappedFile {
 public:
  /// Throws Error: missing, a folder, empty, unreadable.
  explicit MappedFile(const std::string& path);
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();
  std::string_view bytes() const { return {data_, size_}; }
  /// Pages before this offset are not needed again.
  void forget_before(std::size_t offset) const;

 private:
  const char* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace cloud
