// JSON's parser and writer of nlohmann, compiled once: a source with its own takes three seconds
// more to compile.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace base {

/// nlohmann::json or ordered_json. Throws nlohmann::json::exception where the text is none, or,
/// unless it `throws`, returns a value that is_discarded().
template <class Json>
Json parse_json(std::string_view text, bool throws = true);
extern template nlohmann::json parse_json(std::string_view, bool);
extern template nlohmann::ordered_json parse_json(std::string_view, bool);

/// In one line, or indented. Names of files are any bytes: what is no UTF-8 becomes U+FFFD, where
/// dump() alone throws.
std::string dump_json(const nlohmann::json& json, int indent = -1);
std::string dump_json(const nlohmann::ordered_json& json, int indent = -1);

/// The same as the tools print and write it, with a newline at its end.
std::string json_text(const nlohmann::json& json, int indent = 2);
std::string json_text(const nlohmann::ordered_json& json, int indent = 2);

}  // namespace base
