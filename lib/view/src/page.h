// The page itself, embedded when it was built. Private to lib/view.
#pragma once

#include <string_view>

namespace view {

/// Empty where Kerbstone was built without the npm packages (scripts/setup fetches them).
std::string_view page();

}  // namespace view
