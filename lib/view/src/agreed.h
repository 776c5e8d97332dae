// Units that may run. Private to lib/view.
#pragma once

#include <mutex>
#include <set>
#include <string>

namespace view {

/// What whoever uses the page has agreed to run, by its bytes: a unit is a program of whoever made
/// it. As long as this program serves; from any thread.
class Agreed {
 public:
  bool has(const std::string& sha256) const;
  /// `said`: the SHA-256 that the page asked for. Throws Refusal (428) where the file has another
  /// one and was not agreed to before.
  void check(const std::string& path, const std::string& said);

 private:
  mutable std::mutex mutex_;
  std::set<std::string> sha256_;
};

}  // namespace view
