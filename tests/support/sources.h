// The project's own sources, for tests that read them.
#pragma once

#include <string>
#include <vector>

namespace support {

/// Every source below lib and tools, as a path from the top; packages fetched for the pages are not
/// ours.
std::vector<std::string> sources_of_lib_and_tools();

/// Of these, those in C++.
std::vector<std::string> cpp_of_lib_and_tools();

}  // namespace support
