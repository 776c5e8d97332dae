// What keeps the process of a unit from the rest of the machine. Private to lib/sim.
#pragma once

#include <string>
#include <vector>

namespace sim {

/// From now on this process, which has one thread, writes in this folder alone, has no other
/// descriptors than `keep`, the standard ones (its input is empty) and what it opens, and none of
/// root's rights but those that real time wants. Throws Error where the machine cannot do that.
void confine_files(const std::string& folder, double largest_file_bytes,
                   const std::vector<int>& keep, bool real_time);

/// From now on no thread of this process makes processes or sockets, signals others, or changes
/// what is not in files. Gives the descriptor by which the guardian refuses such calls, which has
/// to be closed here; -1 where they are refused without it. Throws Error as above.
int confine_calls();

/// Refuses the next call that waits at such a descriptor; its name, "" where there is none.
std::string refuse_call(int listener);

}  // namespace sim
