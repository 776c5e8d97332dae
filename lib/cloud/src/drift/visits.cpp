#include "visits.h"

#include <algorithm>

namespace cloud {
namespace {

constexpr std::size_t kMostOpen = 8;

}  // namespace

Visits::Seen Visits::operator()(std::size_t section) {
  const auto found = last_use_.find(section);
  Seen seen;
  if (found == last_use_.end()) {
    if (last_use_.size() >= kMostOpen) {
      const auto oldest =
          std::min_element(last_use_.begin(), last_use_.end(),
                           [](const auto& a, const auto& b) { return a.second < b.second; });
      seen.closed = oldest->first;
      last_use_.erase(oldest);
    }
    ++number_[section];
  }
  last_use_[section] = ++clock_;
  seen.number = number_[section];
  return seen;
}

}  // namespace cloud
