// A part of a file that is too large to be sent as a whole. Private to lib/view.
#pragma once

#include <string>

namespace view {

/// So many bytes of a file of points (.tiles) from `begin` on, both as the request spells them.
/// Throws Refusal: another kind of file, no numbers, more than 16 MB, beyond the file's end.
std::string part_of_file(const std::string& path, const std::string& begin,
                         const std::string& bytes);

}  // namespace view
