#pragma once

#include <string>
#include <string_view>

namespace fmu {

/// The folder that an importer names: a path, or a URI "file:/a%20b", "file:///a", "file://host/a"
/// of this machine. Throws base::Error for other schemes and for what is no such URI.
std::string resource_path(std::string_view location);

}  // namespace fmu
