// Sockets that others made in this process, kept to this machine. Private to dds.
#pragma once

#include <set>

namespace sim {

/// Sockets of the internet that this process has.
std::set<int> open_sockets();

/// Cyclone DDS sends by the interface that it was given, and receives by all. Sockets that are not
/// in `before` receive by the loopback alone. Throws Error where that cannot be.
void receive_by_loopback(const std::set<int>& before);

}  // namespace sim
