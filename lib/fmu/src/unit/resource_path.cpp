#include "fmu/resource_path.h"

#include <fmt/format.h>

#include <charconv>

#include "base/error.h"

namespace fmu {

std::string resource_path(std::string_view location) {
  const auto refuse = [&] {
    throw base::Error(fmt::format("resources at '{}', wanted file:///FOLDER", location));
  };
  if (location.empty()) refuse();
  if (location.front() == '/') return std::string(location);
  if (!location.starts_with("file:")) refuse();
  std::string_view rest = location.substr(5);
  if (rest.starts_with("//")) {
    const std::size_t slash = rest.find('/', 2);
    if (slash == std::string_view::npos) refuse();
    rest = rest.substr(slash);
  }
  std::string out;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (rest[i] != '%') {
      out += rest[i];
      continue;
    }
    unsigned code = 0;
    const char* const digits = rest.data() + i + 1;
    if (i + 3 > rest.size() || std::from_chars(digits, digits + 2, code, 16).ptr != digits + 2 ||
        code == 0)
      refuse();
    out += static_cast<char>(code);
    i += 2;
  }
  if (out.empty() || out.front() != '/') refuse();
  return out;
}

}  // namespace fmu
