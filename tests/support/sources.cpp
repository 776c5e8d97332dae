#include "support/sources.h"

#include <filesystem>
#include <set>

#include "support/places.h"

namespace support {

namespace fs = std::filesystem;

std::vector<std::string> sources_of_lib_and_tools() {
  static const std::set<std::string> kSources = {".cpp", ".h",   ".def", ".js",
                                                 ".mjs", ".css", ".py",  ".pyi"};
  const fs::path top = places::source();
  std::vector<std::string> sources;
  for (const char* below : {"lib", "tools"})
    for (auto entry = fs::recursive_directory_iterator(top / below); entry != fs::end(entry);
         ++entry) {
      if (entry->path().filename() == "node_modules") entry.disable_recursion_pending();
      if (entry->is_regular_file() && kSources.contains(entry->path().extension().string()))
        sources.push_back(entry->path().lexically_relative(top).generic_string());
    }
  return sources;
}

std::vector<std::string> cpp_of_lib_and_tools() {
  std::vector<std::string> sources = sources_of_lib_and_tools();
  std::erase_if(sources, [](const std::string& name) {
    return !name.ends_with(".cpp") && !name.ends_with(".h");
  });
  return sources;
}

}  // namespace support
