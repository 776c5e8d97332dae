#include "topics.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/one_line.h"

namespace sim {
namespace {

constexpr std::size_t kMostTopics = 1000;

struct MessageType {
  std::string_view name;
  std::vector<std::string_view> fields;  ///< none: any
};

const std::vector<MessageType>& message_types() {
  static const std::vector<MessageType> types{
      {"sensor_msgs/Imu",
       {"roll", "pitch", "yaw", "angular_velocity.x", "angular_velocity.y", "angular_velocity.z",
        "linear_acceleration.x", "linear_acceleration.y", "linear_acceleration.z",
        "orientation.variance", "angular_velocity.variance", "linear_acceleration.variance"}},
      {"sensor_msgs/NavSatFix", {"latitude", "longitude", "altitude", "position.variance"}},
      {"nav_msgs/Odometry",
       {"position.x", "position.y", "position.z", "roll", "pitch", "yaw", "linear.x", "linear.y",
        "linear.z", "angular.x", "angular.y", "angular.z", "position.variance",
        "orientation.variance", "linear.variance", "angular.variance"}},
      {"geometry_msgs/TwistWithCovarianceStamped",
       {"linear.x", "linear.y", "linear.z", "angular.x", "angular.y", "angular.z",
        "linear.variance", "angular.variance"}},
      {"kerbstone_msgs/Values", {}}};
  return types;
}

/// What a car is without a file: of this, what the unit has.
std::vector<vehicle::SignalTopic> usual_topics() {
  return {{"odom",
           "nav_msgs/Odometry",
           "map",
           "base_link",
           {{"position.x", "car.x"},
            {"position.y", "car.y"},
            {"position.z", "car.z"},
            {"roll", "car.roll"},
            {"pitch", "car.pitch"},
            {"yaw", "car.yaw"},
            {"linear.x", "car.vx"},
            {"linear.y", "car.vy"},
            {"angular.x", "car.roll_rate"},
            {"angular.y", "car.pitch_rate"},
            {"angular.z", "car.yaw_rate"}}},
          {"imu",
           "sensor_msgs/Imu",
           "base_link",
           "",
           {{"angular_velocity.x", "car.roll_rate"},
            {"angular_velocity.y", "car.pitch_rate"},
            {"angular_velocity.z", "car.yaw_rate"},
            {"linear_acceleration.x", "car.ax"},
            {"linear_acceleration.y", "car.ay"},
            {"linear_acceleration.z", "car.az"}}}};
}

std::optional<double> number(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

std::size_t index_of(std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  names.push_back(name);
  return names.size() - 1;
}

/// ROS 2 takes letters, digits, _ and single / that stand between them.
bool is_topic_name(const std::string& name) {
  bool begins = true;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    if (begins ? !letter : !(letter || c == '/' || (c >= '0' && c <= '9'))) return false;
    begins = c == '/';
  }
  return !begins && name.size() <= 200;
}

/// The sensor whose age is that of a measurement; nothing for the unit's own numbers.
std::optional<std::string> aging_sensor(const vehicle::SignalSensorFile& devices,
                                        const std::string& name) {
  for (const vehicle::SignalSensor& sensor : devices.sensors)
    if (name == sensor.name) return sensor.name;
  for (const vehicle::SignalPosition& position : devices.positions)
    if (name == position.name + ".latitude_deg" || name == position.name + ".longitude_deg")
      return devices.sensors[position.x].name;
  return std::nullopt;
}

PlannedTopic plan_topic(const vehicle::SignalTopic& topic, ServeOptions& options,
                        const std::string& path) {
  const auto refuse = [&](const std::string& what) {
    throw base::Error(fmt::format("{}: the topic {} {}", path, topic.name.substr(0, 60), what));
  };
  if (!is_topic_name(topic.name))
    refuse("has a name that ROS 2 does not take: letters, digits, _, and / between them");
  const auto& types = message_types();
  const auto type = std::find_if(types.begin(), types.end(),
                                 [&](const MessageType& one) { return one.name == topic.type; });
  if (type == types.end()) {
    std::string known;
    for (const MessageType& one : types)
      known += (known.empty() ? "" : ", ") + std::string(one.name);
    refuse("has the type " + topic.type.substr(0, 60) + "; known are " + known);
  }
  PlannedTopic out{topic.name, topic.type, topic.frame, topic.child_frame, {}, {}, {}, {}};
  for (const auto& [field, told] : topic.fields) {
    const bool known = type->fields.empty() || std::find(type->fields.begin(), type->fields.end(),
                                                         field) != type->fields.end();
    if (!known)
      refuse(fmt::format("tells {}, which is no field of {}; it has {}", field.substr(0, 60),
                         topic.type, fmt::join(type->fields, ", ")));
    out.fields.push_back(field);
    const std::optional<double> constant = number(told);
    out.constants.push_back(constant.value_or(0.0));
    out.measurements.push_back(constant ? std::nullopt
                                        : std::optional(index_of(options.measurements, told)));
    const std::optional<std::string> sensor = aging_sensor(options.devices, told);
    if (sensor && !out.age) out.age = index_of(options.measurements, *sensor + ".age_s");
  }
  return out;
}

/// The usual topics, of what the unit has.
std::vector<vehicle::SignalTopic> usual_topics_of(const UnitDescription& unit) {
  std::vector<vehicle::SignalTopic> out;
  for (vehicle::SignalTopic& topic : usual_topics()) {
    std::erase_if(topic.fields, [&](const auto& field) { return !unit.find(field.second); });
    if (!topic.fields.empty()) out.push_back(std::move(topic));
  }
  return out;
}

/// What a field of a command acts on; empty where there is nothing.
std::string command_name(const CarField& field, const vehicle::SignalSensorFile& devices,
                         const UnitDescription& unit) {
  for (const vehicle::SignalCommand& command : devices.commands)
    if (command.name == field.name) return field.name;
  if (unit.find(field.input) != nullptr) return field.input;
  const std::string element = field.element;
  const UnitVariable* const array = unit.find(element.substr(0, element.find('[')));
  return array != nullptr && array->size == 4 ? element : "";
}

}  // namespace

TopicPlan plan_topics(ServeOptions& options, const UnitDescription& unit, const std::string& path) {
  const std::vector<vehicle::SignalTopic> topics =
      options.devices.topics.empty() ? usual_topics_of(unit) : options.devices.topics;
  if (topics.size() > kMostTopics)
    throw base::Error(
        fmt::format("{}: {} topics; at most {} wanted", path, topics.size(), kMostTopics));
  TopicPlan plan;
  plan.prefix = options.topic_prefix;
  for (const vehicle::SignalTopic& topic : topics)
    plan.topics.push_back(plan_topic(topic, options, path));
  for (std::size_t k = 0; k < kCarFields.size(); ++k) {
    const std::string name = command_name(kCarFields[k], options.devices, unit);
    if (!name.empty()) plan.commands[k] = index_of(options.commands, name);
  }
  plan.command_names = options.commands;
  const auto name_of = [&](const std::string& sensor) {
    if (!is_topic_name(sensor))
      throw base::Error(
          fmt::format("{}: the sensor {} has a name that is no topic of ROS 2: "
                      "letters, digits, _, and / between them",
                      path, sensor.substr(0, 60)));
    return sensor;
  };
  for (const auto& scan : options.devices.road.scans) plan.scans.push_back(name_of(scan.name));
  for (const auto& edges : options.devices.road.edges) plan.edges.push_back(name_of(edges.name));
  std::vector<std::string> taken{"clock", "crgsim/step", "crgsim/command", "crgsim/plan"};
  for (const PlannedTopic& topic : plan.topics) taken.push_back(topic.name);
  for (const auto* const names : {&plan.scans, &plan.edges})
    taken.insert(taken.end(), names->begin(), names->end());
  std::sort(taken.begin(), taken.end());
  if (const auto twice = std::adjacent_find(taken.begin(), taken.end()); twice != taken.end())
    throw base::Error(fmt::format(
        "{}: two topics would be called {}: topics, scans and edges of the devices want names of "
        "their own, and clock and crgsim/... are taken",
        path, twice->substr(0, 60)));
  return plan;
}

bool Told::has(std::string_view field) const {
  return std::find(topic_.fields.begin(), topic_.fields.end(), field) != topic_.fields.end();
}

double Told::value(std::string_view field) const {
  const auto found = std::find(topic_.fields.begin(), topic_.fields.end(), field);
  return found == topic_.fields.end()
             ? 0.0
             : value_at(static_cast<std::size_t>(found - topic_.fields.begin()));
}

double Told::value_at(std::size_t field) const {
  const std::optional<std::size_t>& measurement = topic_.measurements[field];
  return measurement ? message_.values[*measurement] : topic_.constants[field];
}

double Told::time_s() const {
  return message_.time_s - (topic_.age ? message_.values[*topic_.age] : 0.0);
}

std::optional<CommandMessage> command_of(const CarCommand& said, const TopicPlan& plan,
                                         std::string& why) {
  CommandMessage out;
  out.sequence = said.sequence;
  out.ends = said.ends;
  out.pauses = said.pauses;
  out.resets = said.resets;
  out.values.assign(plan.command_names.size(), std::numeric_limits<double>::quiet_NaN());
  const auto set = [&](std::size_t at, double value) {
    if (!std::isfinite(value)) why = "a value that is not finite";
    out.values[at] = value;
  };
  // With a reset the fields would undo the starts; the next command acts.
  for (std::size_t k = 0; k < kCarFields.size() && !said.resets; ++k)
    if (plan.commands[k]) set(*plan.commands[k], said.fields[k]);
  for (const auto& [name, value] : said.others) {
    const auto found = std::find(plan.command_names.begin(), plan.command_names.end(), name);
    if (found == plan.command_names.end())
      why = "'" + base::one_line(name.substr(0, 60)) + "' is no command of this run";
    else
      set(static_cast<std::size_t>(found - plan.command_names.begin()), value);
  }
  if (said.resets) out.starts = said.starts;
  if (said.resets) out.state = said.state;
  out.save = said.save;
  if (said.plan.size() > kMostPlanPoints) why = "a plan of more than 500 points";
  for (const PlanPoint& point : said.plan)
    if (!std::isfinite(point.x_m) || !std::isfinite(point.y_m) || !std::isfinite(point.speed_mps))
      why = "a value that is not finite";
  if (!said.plan.empty()) out.plan = said.plan;
  for (const auto& [name, value] : out.starts)
    if (!std::isfinite(value)) why = "a value that is not finite";
  if (why.empty()) why = wrong_with_states(out);
  return why.empty() ? std::optional(out) : std::nullopt;
}

std::array<double, 4> quaternion(double roll_rad, double pitch_rad, double yaw_rad) {
  const double cr = std::cos(0.5 * roll_rad), sr = std::sin(0.5 * roll_rad);
  const double cp = std::cos(0.5 * pitch_rad), sp = std::sin(0.5 * pitch_rad);
  const double cy = std::cos(0.5 * yaw_rad), sy = std::sin(0.5 * yaw_rad);
  return {cy * cp * sr - sy * sp * cr, cy * sp * cr + sy * cp * sr, sy * cp * cr - cy * sp * sr,
          cy * cp * cr + sy * sp * sr};
}

}  // namespace sim
