// Foreign code in a process of its own. Private to lib/sim.
#pragma once

#include <sys/types.h>

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "base/descriptor.h"

namespace sim {

/// What a process apart says: a letter and bytes.
struct Words {
  char kind;
  std::string_view bytes;
};

/// Work in a child process, which says things through its argument. When the child has ended, or
/// this process has, `afterwards` is called in a third process: it removes what the child used.
/// Standard output of the child goes to standard error. Exceptions of the work become an 'E' with
/// their text.
class Apart {
 public:
  /// Starts it. Throws Error when no process can be started. The thread that does so has to stay.
  Apart(const std::function<void(const std::function<void(Words)>& say)>& work,
        const std::function<void()>& afterwards);
  Apart(const Apart&) = delete;
  Apart& operator=(const Apart&) = delete;
  ~Apart();  ///< kills what has not ended, and waits for `afterwards`

  /// Readable when it says something or has ended.
  int descriptor() const { return from_.value; }
  /// What it says next, waited for and kept until the next call; nothing when it has ended.
  std::optional<Words> hear();
  /// How it ended before its work did (a signal, exit()), else nothing.
  std::string how_it_ended() const;

 private:
  base::Descriptor from_;
  pid_t guardian_ = -1;
  int status_;
  bool has_ended_ = false, has_finished_ = false;
  std::string bytes_;
};

/// Starts such work; `take` gets what it says, as it comes. Gives how_it_ended().
std::string run_apart(const std::function<void(const std::function<void(Words)>& say)>& work,
                      const std::function<void()>& afterwards,
                      const std::function<void(Words)>& take);

/// What to say of a unit whose process ended before its work did, with the time it had reached.
std::string crash_of(const std::string& path, const std::string& how,
                     std::optional<double> reached_s);

}  // namespace sim
