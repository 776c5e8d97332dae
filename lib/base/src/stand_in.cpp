#include "base/stand_in.h"

#include <algorithm>
#include <cctype>

#include "base/error.h"

namespace base {

std::optional<Refusal> lfs_pointer(std::string_view bytes, const std::string& path) {
  if (bytes.size() > 1024 || !bytes.starts_with("version https://git-lfs.github.com/spec/"))
    return std::nullopt;
  return Refusal(path +
                 ": is a pointer of Git LFS, not the file itself; run 'git lfs pull' in its "
                 "repository, or download the file itself");
}

void want_no_lfs_pointer(std::string_view bytes, const std::string& path) {
  if (const auto pointer = lfs_pointer(bytes, path)) throw Error(pointer->message);
}

void want_no_web_page(std::string_view bytes, const std::string& path) {
  std::string begin(bytes.substr(0, 1000));
  std::transform(begin.begin(), begin.end(), begin.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (begin.starts_with("\xef\xbb\xbf")) begin.erase(0, 3);
  const std::size_t first = begin.find_first_not_of(" \t\r\n");
  if (first == std::string::npos || begin[first] != '<') return;
  for (const char* tag : {"<!doctype html", "<html>", "<html "}) {
    if (begin.find(tag) == std::string::npos) continue;
    throw Error(path +
                ": is an HTML page, not the file itself: a server sent it in its place; download "
                "the file again, by the link of the file and not of its page");
  }
}

}  // namespace base
