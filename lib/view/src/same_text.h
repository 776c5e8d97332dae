// Comparing what a stranger must not find out by trying. Private to lib/view.
#pragma once

#include <string_view>

namespace view {

/// As long for a wrong text as for one that is wrong at its end.
inline bool is_same(std::string_view a, std::string_view b) {
  unsigned char differs = a.size() == b.size() ? 0 : 1;
  for (std::size_t k = 0; k < a.size(); ++k)
    differs = static_cast<unsigned char>(differs | (a[k] ^ b[b.empty() ? 0 : k % b.size()]));
  return differs == 0;
}

}  // namespace view
