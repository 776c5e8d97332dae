// Whoever drives by topics of ROS 2, without ROS 2. Private to serve_unit.
#pragma once

#include "connection.h"
#include "topics.h"

namespace sim {

/// Joins the domain: on this machine alone (the loopback), unless CYCLONEDDS_URI says otherwise.
/// Starts threads. In lockstep a reader that is slow is waited for, in real time its messages are
/// lost. Throws Error where it cannot be joined, and where require_dds() does. `plan` has to stay.
Connection connect_dds(unsigned domain, const TopicPlan& plan, bool lockstep);

}  // namespace sim
