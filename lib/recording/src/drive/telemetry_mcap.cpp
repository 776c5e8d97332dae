#include "recording/telemetry_mcap.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "recording/mcap.h"

namespace recording {
namespace {

bool is_one_of(std::string_view name, std::initializer_list<std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// The topic that a channel belongs to.
const char* topic_of(std::string_view name) {
  const auto begins = [&](std::string_view with) { return name.starts_with(with); };
  if (is_one_of(name, {"time_s", "u_m", "v_m", "x_m", "y_m", "z_m", "roll_rad", "pitch_rad",
                       "yaw_rad", "latitude_rad", "longitude_rad"}))
    return "/place";
  if (is_one_of(name, {"vx_mps", "vy_mps", "ax_mps2", "ay_mps2", "az_mps2", "roll_rate_radps",
                       "pitch_rate_radps", "yaw_rate_radps"}))
    return "/motion";
  if (begins("brake_disc_") || begins("wheel_") || begins("fz_") || begins("suspension_") ||
      begins("tyre_"))
    return "/wheels";
  if (begins("steer_") || begins("throttle") || begins("brake_") || name == "gear")
    return "/controls";
  if (is_one_of(name, {"engine_radps", "boost", "fuel_kg"})) return "/engine";
  return "/other";
}

}  // namespace

std::string format_mcap(const Table& table, const std::string& about) {
  const std::vector<double>* const time = table.find("time_s");
  if (time == nullptr)
    throw base::Error("a drive without a column time_s cannot be written as MCAP");
  std::vector<WrittenTopic> topics;
  for (const char* name : {"/place", "/motion", "/controls", "/engine", "/wheels", "/other"}) {
    WrittenTopic topic{name, {}, {}};
    for (std::size_t c = 0; c < table.names.size(); ++c)
      if (topic_of(table.names[c]) == std::string_view(name)) {
        topic.fields.push_back(table.names[c]);
        topic.columns.push_back(table.columns[c].data());
      }
    if (!topic.fields.empty()) topics.push_back(std::move(topic));
  }
  return format_mcap(*time, topics, table.names, about);
}

}  // namespace recording
