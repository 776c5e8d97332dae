// What lies in the place of a file that was not downloaded.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/answer.h"

namespace base {

/// Refuses a pointer of Git LFS: a few lines in the place of a large file, until that is asked for.
/// `bytes`: the whole file, `path` names it. Throws Error.
void want_no_lfs_pointer(std::string_view bytes, const std::string& path);

/// The same as an answer; nothing where it is none.
std::optional<Refusal> lfs_pointer(std::string_view bytes, const std::string& path);

/// Refuses an HTML page, which servers send in the place of a file that they do not give. `bytes`:
/// the file or its beginning. Throws Error.
void want_no_web_page(std::string_view bytes, const std::string& path);

}  // namespace base
