#pragma once

#include <string>

namespace base {

/// JSON (of nlohmann) as the tools print and write it, with a newline at its end. Names of files
/// are any bytes: what is no UTF-8 becomes U+FFFD, where dump() alone throws.
template <class Json>
std::string json_text(const Json& json, int indent = 2) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace base
