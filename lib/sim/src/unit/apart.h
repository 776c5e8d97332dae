// Foreign code in a process of its own. Private to lib/sim.
#pragma once

#include <sys/types.h>

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/descriptor.h"
#include "sim/unit_limits.h"
#include "watch.h"

namespace sim {

/// What a process apart says: a letter and bytes.
struct Words {
  char kind;
  std::string_view bytes;
};

/// The work of a process apart. `watch` learns of calls of the unit; none where it is trusted.
using ApartWork = std::function<void(const std::function<void(Words)>& say, Watch* watch)>;

/// Where such work is done, and when it is ended.
struct ApartPlace {
  std::string folder;                 ///< the one where it may write
  UnitLimits limits;                  ///< trusted: it is not confined
  std::vector<int> keep = {};         ///< descriptors that it needs
  bool real_time = false;             ///< it will want to be scheduled so
  std::function<void()> before = {};  ///< in its process, before it may make no sockets
};

/// How a process ended before its work did.
struct Ending {
  std::string how;        ///< a signal, exit(), or the limit that it crossed; empty: it did not
  bool by_limit = false;  ///< its guardian ended it
  std::string refused;    ///< calls of the system that its sandbox refused it; empty: none
};

/// Work in a child process, which says things through its argument. When the child has ended, or
/// this process has, whatever it started is killed, and `afterwards` is called in a third process:
/// it removes what the child used. What the child prints goes to standard error, with control
/// characters made visible. Exceptions of the work become an 'E' with their text.
class Apart {
 public:
  /// Starts it. Throws Error when no process can be started. The thread that does so has to stay.
  Apart(const ApartPlace& place, const ApartWork& work, const std::function<void()>& afterwards);
  Apart(const Apart&) = delete;
  Apart& operator=(const Apart&) = delete;
  ~Apart();  ///< kills what has not ended, and waits for `afterwards`

  /// Readable when it says something or has ended.
  int descriptor() const { return from_.value; }
  /// What it says next, waited for and kept until the next call; nothing when it has ended.
  std::optional<Words> hear();
  Ending ending() const;

 private:
  void take_ending();

  base::Descriptor from_;
  Watch* watch_;
  pid_t guardian_ = -1;
  int status_;
  bool has_ended_ = false, has_finished_ = false;
  std::string bytes_;
  Ending ending_;
};

/// Starts such work; `take` gets what it says, as it comes.
Ending run_apart(const ApartPlace& place, const ApartWork& work,
                 const std::function<void()>& afterwards, const std::function<void(Words)>& take);

/// What to say of a unit whose process ended before its work did, with the time it had reached;
/// empty where it did not.
std::string crash_of(const std::string& path, const Ending& ending,
                     std::optional<double> reached_s);

/// After an error: what its sandbox refused a unit; empty: nothing.
std::string refused_to(const Ending& ending);

}  // namespace sim
