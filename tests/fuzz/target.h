// What every fuzz target shares. A target is one source file that defines fuzz::run(); driver.cpp
// runs it under libFuzzer and, without, over a corpus and mutants of it (docs/dev/fuzzing.md).
#pragma once

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace fuzz {

/// Reads the bytes as a file of the target's kind. Aborts when a promise of the reader is broken.
void run(std::string_view bytes);

inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

/// A refusal is one line of a readable length that names the file.
inline void require_refusal(const std::exception& error, std::string_view name) {
  const std::string_view text = error.what();
  const bool good = text.find(name) != std::string_view::npos && text.size() < 2000 &&
                    text.find('\n') == std::string_view::npos;
  if (!good) std::fprintf(stderr, "refusal: %.300s\n", error.what());
  require(good, "a refusal of one line that names the file");
}

/// A folder of this process, for readers that want paths.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "kerbstone_fuzz.XXXXXX").string();
    require(::mkdtemp(name.data()) != nullptr, "a temporary folder");
    path_ = name;
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string operator/(std::string_view name) const { return path_ + "/" + std::string(name); }
  /// Writes a file; gives its path.
  std::string put(std::string_view name, std::string_view bytes) const {
    std::string path = *this / name;
    std::ofstream(path, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path;
  }

 private:
  std::string path_;
};

inline const Folder& folder() {
  static const Folder own;
  return own;
}

}  // namespace fuzz
