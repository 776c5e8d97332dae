#include "base/json_text.h"

#include <nlohmann/json.hpp>

namespace base {

template <class Json>
Json parse_json(std::string_view text, bool throws) {
  return Json::parse(text, nullptr, throws);
}
template nlohmann::json parse_json(std::string_view, bool);
template nlohmann::ordered_json parse_json(std::string_view, bool);

std::string dump_json(const nlohmann::json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}
std::string dump_json(const nlohmann::ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string json_text(const nlohmann::json& json, int indent) {
  return dump_json(json, indent) + "\n";
}
std::string json_text(const nlohmann::ordered_json& json, int indent) {
  return dump_json(json, indent) + "\n";
}

}  // namespace base
