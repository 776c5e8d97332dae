#include <algorithm>

#include "crg/file.h"

namespace crg {

std::optional<double> find_value(const std::vector<HeaderEntry>& entries, std::string_view key) {
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
    if (entry->key == key) return entry->value;
  }
  return std::nullopt;
}

void set_value(std::vector<HeaderEntry>& entries, std::string_view key, double value) {
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
    if (entry->key == key) {
      entry->value = value;
      entry->text.clear();
      return;
    }
  }
  entries.push_back({.key = std::string(key), .value = value});
}

void erase_key(std::vector<HeaderEntry>& entries, std::string_view key) {
  std::erase_if(entries, [&](const HeaderEntry& entry) { return entry.key == key; });
}

}  // namespace crg
