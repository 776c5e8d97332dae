// What this process has begun and not finished: abandon_writes() removes it. Private.
#pragma once

#include <mutex>
#include <string>

namespace base {

/// Held while something unfinished comes to be, gets its final name or is removed. abandon_writes()
/// takes it for ever.
std::recursive_mutex& unfinished_guard();

/// A file, or a folder with all that is in it, that is to go if the process gives up; what was
/// added last goes first. The caller holds the guard, here and below.
void add_unfinished(const std::string& path);

/// The same for a folder that goes only if nothing lies in it.
void add_made_folder(const std::string& path);

void drop_unfinished(const std::string& path);

/// Files that grow get their names.
void finish_growing() noexcept;

}  // namespace base
