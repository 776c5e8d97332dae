// Messages of ROS 2 and of crgsim's own, filled and written. Private to dds.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "sim/message.h"
#include "sim/sights.h"
#include "topics.h"

struct dds_topic_descriptor;
struct builtin_interfaces_msg_dds__Time_;

namespace sim {

/// An entity and a result of Cyclone DDS.
using DdsNumber = std::int32_t;

/// A message that topics of the devices' file may have.
struct WireType {
  std::string_view name;
  const dds_topic_descriptor* descriptor;
  DdsNumber (*write)(DdsNumber writer, const Told&);
};
/// Throws Error where there is none.
const WireType& wire_type(const std::string& name);

builtin_interfaces_msg_dds__Time_ stamp_of(double time_s);

/// kerbstone_msgs/Remark.
DdsNumber write_remark(DdsNumber writer, const Remark& remark);

/// sensor_msgs/PointCloud2, kerbstone_msgs/Edges, kerbstone_msgs/Plan.
DdsNumber write_scan(DdsNumber writer, const Scan& scan);
DdsNumber write_edges(DdsNumber writer, const Edges& edges);
DdsNumber write_plan(DdsNumber writer, const Plan& plan);

}  // namespace sim
