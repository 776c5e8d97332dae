// A DDS domain that no other test on this machine has at the same time.
#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace places {

/// The same at every call of this process, which keeps it until it ends: the lock of a file is the
/// kernel's, so that a killed test frees its domain.
inline unsigned own_domain() {
  static const unsigned domain = [] {
    const std::string file = std::filesystem::temp_directory_path() / "kerbstone_tests_domain_";
    for (unsigned i = 1; i <= 200; ++i) {
      const int lock =
          ::open((file + std::to_string(i)).c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
      if (lock >= 0 && ::flock(lock, LOCK_EX | LOCK_NB) == 0) return i;
      if (lock >= 0) ::close(lock);
    }
    throw std::runtime_error("200 tests have every DDS domain");
  }();
  return domain;
}

}  // namespace places
