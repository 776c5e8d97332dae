#include "mapped_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "cloud/error.h"

namespace cloud {

MappedFile::MappedFile(const std::string& path) {
  // A FIFO is refused, not waited for.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0)
    throw Error(fmt::format("{}: cannot be opened: {}", path, std::strerror(errno)));
  struct stat facts {};
  const bool known = ::fstat(descriptor, &facts) == 0;
  if (!known || !S_ISREG(facts.st_mode) || facts.st_size == 0) {
    ::close(descriptor);
    throw Error(fmt::format("{}: {}; a point cloud is wanted", path,
                            !known || !S_ISREG(facts.st_mode) ? "no regular file" : "empty file"));
  }
  size_ = static_cast<std::size_t>(facts.st_size);
  void* const mapped = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
  const int problem = errno;
  ::close(descriptor);
  if (mapped == MAP_FAILED)
    throw Error(fmt::format("{}: cannot be mapped: {}", path, std::strerror(problem)));
  data_ = static_cast<const char*>(mapped);
  ::madvise(mapped, size_, MADV_SEQUENTIAL);
}

MappedFile::~MappedFile() { ::munmap(const_cast<char*>(data_), size_); }

void MappedFile::forget_before(std::size_t offset) const {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t length = offset / page * page;
  if (length > 0) ::madvise(const_cast<char*>(data_), length, MADV_DONTNEED);
}

}  // namespace cloud
