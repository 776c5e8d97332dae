// The lists beside the tests: exceptions with their reasons.
#pragma once

#include <map>
#include <string>

namespace support {

/// A list in tests/: the first word of each line, and the rest. A line without a rest, and a word
/// that stands twice, fail the test that asks.
std::map<std::string, std::string> listed(const std::string& name);

}  // namespace support
