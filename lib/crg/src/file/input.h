// The bytes of a file, or of a string in memory, front to back.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

namespace crg {

class Input {
 public:
  Input(std::string_view bytes, std::string name)
      : memory_(bytes), name_(std::move(name)), size_(bytes.size()) {}

  /// Throws Error where `path` is no regular file or cannot be opened.
  explicit Input(const std::string& path);
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;
  ~Input();

  const std::string& name() const { return name_; }
  std::size_t size() const { return size_; }

  /// Up to `count` bytes; fewer only at the end. Throws Error when the file cannot be read.
  std::size_t read(char* to, std::size_t count);

 private:
  std::string_view memory_;
  std::size_t position_ = 0;
  int file_ = -1;
  std::string name_;
  std::size_t size_ = 0;
};

}  // namespace crg
