#include "files/write_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "files/error.h"

namespace files {
namespace {

[[noreturn]] void fail(const std::string& path, const char* what) {
  const int reason = errno;
  throw Error(fmt::format("{}: {}: {}; choose a folder that exists, is writable and has free space",
                          path, what, std::strerror(reason)));
}

}  // namespace

FileWriter::FileWriter(const std::string& path) : path_(path), temporary_path_(path + ".XXXXXX") {
  struct stat target {};
  if (::stat(path.c_str(), &target) == 0 && S_ISDIR(target.st_mode)) {
    throw Error(fmt::format("{}: is a folder; give the name of a file", path));
  }
  descriptor_ = ::mkstemp(temporary_path_.data());
  if (descriptor_ < 0) fail(path_, "cannot create a file in this folder");
}

FileWriter::~FileWriter() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  if (!temporary_path_.empty()) ::unlink(temporary_path_.c_str());
}

void FileWriter::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(path_, "cannot write");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void FileWriter::commit() {
  // mkstemp makes 0600; a written file gets what open() would have given, or keeps what it had.
  struct stat old {};
  mode_t mode = 0;
  if (::stat(path_.c_str(), &old) == 0) {
    mode = old.st_mode & 07777;
  } else {
    const mode_t mask = ::umask(022);
    ::umask(mask);
    mode = 0666 & ~mask;
  }
  if (::fchmod(descriptor_, mode) != 0) fail(path_, "cannot set the permissions");
  if (::fsync(descriptor_) != 0) fail(path_, "cannot flush to disk");
  if (::rename(temporary_path_.c_str(), path_.c_str()) != 0)
    fail(path_, "cannot rename to the final name");
  temporary_path_.clear();
  // The rename itself lasts through a power cut only once the folder is flushed; a file system
  // that cannot flush a folder is no reason to fail.
  const std::size_t slash = path_.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path_.substr(0, slash + 1);
  const int folder_descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY);
  if (folder_descriptor >= 0) {
    ::fsync(folder_descriptor);
    ::close(folder_descriptor);
  }
}

void write_file(const std::string& path, std::string_view bytes) {
  FileWriter file(path);
  file.append(bytes);
  file.commit();
}

}  // namespace files
