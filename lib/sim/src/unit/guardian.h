// The process that looks after one with foreign code. Private to lib/sim.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>

#include "sim/unit_limits.h"
#include "watch.h"

namespace sim {

/// What a guardian looks after, and by what.
struct Charge {
  pid_t worker;
  int printed;  ///< what it prints comes here
  int calls;    ///< a socket through which comes the descriptor of refused calls, or none
  const Watch& watch;
  std::string folder;
  UnitLimits limits;
};

struct Guarded {
  int status = 0;       ///< of waitpid()
  std::string limit;    ///< which one it crossed; empty: none
  std::string refused;  ///< names of calls
};

/// The signals that guard() waits for; a guardian blocks them before it has a child. SIGUSR1: the
/// worker is to be killed.
void block_guarded_signals();

/// Until the worker and all that it started have ended. This process is a subreaper.
Guarded guard(const Charge& charge);

/// Hands a descriptor on, and closes it here; negative: nothing.
void hand_on(int socket, int descriptor);

}  // namespace sim
