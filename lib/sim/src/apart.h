// Foreign code in a process of its own. Private to run_unit.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace sim {

/// What a process apart says: a letter and bytes.
struct Words {
  char kind;
  std::string_view bytes;
};

/// Calls `work` in a child process, which says things through its argument; `take` gets them here,
/// as they come. When the child has ended, or this process has, `afterwards` is called in a third
/// process: it removes what the child used. Standard output of the child goes to standard error.
/// Gives how the child ended before its work did (a signal, exit()), else nothing. Exceptions of
/// `work` become an 'E' with their text.
std::string run_apart(const std::function<void(const std::function<void(Words)>& say)>& work,
                      const std::function<void()>& afterwards,
                      const std::function<void(Words)>& take);

/// Throws Error when a unit's process ended before its work did, with the time that it had reached.
void want_no_crash(const std::string& path, const std::string& how,
                   std::optional<double> reached_s);

}  // namespace sim
