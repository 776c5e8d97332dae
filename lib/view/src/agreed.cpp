#include "agreed.h"

#include <fmt/format.h>

#include "base/sha256.h"
#include "wish.h"

namespace view {

bool Agreed::has(const std::string& sha256) const {
  const std::lock_guard lock(mutex_);
  return sha256_.contains(sha256);
}

void Agreed::check(const std::string& path, const std::string& said) {
  const std::string sha256 = base::sha256_of_file(path);
  const std::lock_guard lock(mutex_);
  if (said != sha256 && !sha256_.contains(sha256))
    throw Refusal(428,
                  fmt::format("{}: SHA-256 {}: nobody has agreed to run this unit; press Start, "
                              "read what is asked, and agree",
                              path, sha256));
  sha256_.insert(sha256);
}

}  // namespace view
