// In place of dds.cpp where there is no Cyclone DDS: everything but dds_version() says what to
// install.
#include <fmt/format.h>

#include "base/error.h"
#include "dds_connection.h"
#include "sim/dds.h"

namespace sim {

std::string dds_version() { return ""; }

void require_dds(const std::string& option) {
  throw base::Error(fmt::format(
      "{} needs Eclipse Cyclone DDS, which this program was built without; install cyclonedds-dev "
      "and cyclonedds-tools, run cmake again and build",
      option));
}

Connection connect_dds(unsigned, const TopicPlan&, bool) {
  require_dds("this");
  return {};
}

}  // namespace sim
