// Reading: header, then the payload in one pass.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "crg/error.h"
#include "crg/file.h"
#include "header.h"
#include "input.h"
#include "payload.h"
#include "text.h"

namespace crg {
namespace {

constexpr std::size_t kHeaderChunkBytes = 1 << 16;

Header read_file(Input& input) {
  std::string begun;
  std::size_t end = std::string::npos;
  while (end == std::string::npos) {
    const std::size_t before = begun.size();
    begun.resize(before + std::min<std::size_t>(kHeaderChunkBytes,
                                                input.size() - std::min(before, input.size()) + 1));
    const std::size_t got = input.read(begun.data() + before, begun.size() - before);
    begun.resize(before + got);
    if (got == 0) break;
    end = find_header_end(begun);
  }
  Header header = parse_header(std::string_view(begun).substr(0, end), input.name());
  Crg& crg = header.crg;
  crg.source = input.name();
  if (header.columns.empty()) return header;

  const auto increment = find_value(crg.road, "REFERENCE_LINE_INCREMENT");
  if (!increment || !(*increment >= 1e-9 && *increment <= 1e6)) {
    throw Error(input.name() + ": REFERENCE_LINE_INCREMENT is " +
                (increment ? shortest(*increment) : "missing") +
                ": want the row spacing in metres, 1e-9 to 1e6");
  }
  crg.grid.u_step_m = *increment;
  crg.grid.u_begin_m = find_value(crg.road, "REFERENCE_LINE_START_U").value_or(0.0);
  if (*increment < 1e-10 * std::abs(crg.grid.u_begin_m)) {
    throw Error(input.name() + ": REFERENCE_LINE_START_U = " + shortest(crg.grid.u_begin_m) +
                " leaves no digits for the increment " + shortest(*increment) +
                "; start nearer to zero");
  }
  read_payload(header, input, std::move(begun));
  return header;
}

// Throws Error without naming the including file.
std::filesystem::path include_target(const std::string& text, const std::string& from) {
  std::string path = text;
  if (path.starts_with('$')) {
    std::size_t end = 1;
    const bool braces = path.size() > 1 && path[1] == '{';
    if (braces) ++end;
    const std::size_t begin = end;
    while (end < path.size() &&
           (std::isalnum(static_cast<unsigned char>(path[end])) != 0 || path[end] == '_'))
      ++end;
    const std::string variable = path.substr(begin, end - begin);
    const char* value = std::getenv(variable.c_str());
    if (value == nullptr) {
      throw Error("the environment variable " + variable + " is not set");
    }
    path = value + path.substr(std::min(path.size(), end + (braces ? 1 : 0)));
  }
  std::filesystem::path given(path);
  if (given.is_absolute()) return given;
  const std::filesystem::path beside = std::filesystem::path(from).parent_path() / given;
  std::error_code ignored;
  return std::filesystem::exists(beside, ignored) ? beside : given;
}

// What the including file says about options and modifiers replaces the included file's sections;
// its other values are added where the included file has none.
Crg merge(Crg outer, Crg inner) {
  inner.comment.insert(inner.comment.begin(), outer.comment.begin(), outer.comment.end());
  if (outer.has_option_section) {
    inner.options = std::move(outer.options);
    inner.has_option_section = true;
  }
  if (outer.has_modifier_section) {
    inner.modifiers = std::move(outer.modifiers);
    inner.has_modifier_section = true;
  }
  const auto add_missing = [&](std::vector<HeaderEntry>& to, const std::vector<HeaderEntry>& from) {
    for (const HeaderEntry& entry : from) {
      const bool known = std::any_of(to.begin(), to.end(),
                                     [&](const HeaderEntry& e) { return e.key == entry.key; });
      if (entry.key == "*" || !known) {
        to.push_back(entry);
      } else {
        inner.notes.push_back(entry.key +
                              " of the including file was ignored: the included file has its own");
      }
    }
  };
  add_missing(inner.road, outer.road);
  add_missing(inner.projection, outer.projection);
  inner.other_sections.insert(inner.other_sections.end(), outer.other_sections.begin(),
                              outer.other_sections.end());
  inner.notes.insert(inner.notes.begin(), outer.notes.begin(), outer.notes.end());
  return inner;
}

[[noreturn]] void fail_without_data(const std::string& name) {
  throw Error(
      name +
      ": no $KD_DEFINITION with channels and no $ROAD_CRG_FILE: there is no road in this file");
}

}  // namespace

Crg read(const std::string& path) {
  Input input(path);
  Header header = read_file(input);
  if (!header.columns.empty()) {
    if (!header.include_path.empty())
      header.crg.notes.push_back("$ROAD_CRG_FILE was ignored: the file has data of its own");
    return std::move(header.crg);
  }
  if (header.include_path.empty()) fail_without_data(path);
  const auto refuse = [&](const std::string& why) {
    throw Error(path + ":" + std::to_string(header.include_line) + ": $ROAD_CRG_FILE: " + why);
  };
  std::string target;
  std::optional<Input> included;
  try {
    target = include_target(header.include_path, path).string();
    included.emplace(target);
  } catch (const Error& error) {
    refuse(error.what());
  }
  Header inner = read_file(*included);
  if (inner.columns.empty()) refuse(target + " has no data of its own: includes go one level deep");
  Crg crg = merge(std::move(header.crg), std::move(inner.crg));
  crg.included_path = target;
  return crg;
}

Crg read_bytes(std::string_view bytes, const std::string& name) {
  Input input(bytes, name);
  Header header = read_file(input);
  if (header.columns.empty()) {
    if (header.include_path.empty()) fail_without_data(name);
    throw Error(name + ": $ROAD_CRG_FILE needs a file system; read it with read(path)");
  }
  return std::move(header.crg);
}

}  // namespace crg
