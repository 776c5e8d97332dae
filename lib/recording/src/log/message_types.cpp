#include "message_types.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "base/error.h"
#include "base/text_lines.h"

namespace recording {
namespace {

struct Primitive {
  std::string_view name;
  Kind kind;
};
constexpr Primitive kPrimitives[] = {
    {"bool", Kind::boolean},    {"byte", Kind::uint8},    {"char", Kind::uint8},
    {"int8", Kind::int8},       {"uint8", Kind::uint8},   {"int16", Kind::int16},
    {"uint16", Kind::uint16},   {"int32", Kind::int32},   {"uint32", Kind::uint32},
    {"int64", Kind::int64},     {"uint64", Kind::uint64}, {"float32", Kind::float32},
    {"float64", Kind::float64}, {"string", Kind::text},   {"time", Kind::time},
    {"duration", Kind::time}};

bool is_name(std::string_view text, std::string_view also) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           also.find(c) != std::string_view::npos;
  });
}

/// Takes "[5]", "[]" or "[<=5]" off the type.
void take_array(std::string_view& type, MessageField& field) {
  if (type.empty() || type.back() != ']') return;
  const std::size_t open = type.rfind('[');
  if (open == std::string_view::npos) return;
  const std::string_view inside = type.substr(open + 1, type.size() - open - 2);
  type = type.substr(0, open);
  field.many = Many::sequence;
  if (const auto count = base::to_number<std::size_t>(inside)) {
    field.many = Many::fixed;
    field.count = *count;
  }
}

std::optional<MessageField> field_of(std::string_view line, const std::string& of) {
  std::string_view rest = line;
  std::string_view type = base::take_word(rest);
  std::string_view name = base::take_word(rest);
  const std::string_view after = base::trimmed(rest);
  if (name.find('=') != std::string_view::npos || after.starts_with('=')) return std::nullopt;
  MessageField field;
  field.name = name;
  take_array(type, field);
  if (type.starts_with("string<=")) type = "string";
  const auto known = std::find_if(std::begin(kPrimitives), std::end(kPrimitives),
                                  [&](const Primitive& p) { return p.name == type; });
  if (known != std::end(kPrimitives)) field.kind = known->kind;
  const bool wide = type.starts_with("wstring");
  if (!is_name(name, "_") || wide || !is_name(type, "_/"))
    throw base::Error(fmt::format("{}: '{}' is no field of a known kind", of, line.substr(0, 60)));
  if (field.kind != Kind::nested) return field;
  const std::string package = of.substr(0, of.find('/'));
  field.type = type == "Header"                           ? "std_msgs/Header"
               : type.find('/') == std::string_view::npos ? package + '/' + std::string(type)
                                                          : plain_type(type);
  return field;
}

/// Units of standard types by REP 103 and their own descriptions.
struct StandardUnit {
  std::string_view type, field, unit;
};
constexpr StandardUnit kUnits[] = {
    {"geometry_msgs/Twist", "linear", "m/s"},
    {"geometry_msgs/Twist", "angular", "rad/s"},
    {"geometry_msgs/Accel", "linear", "m/s2"},
    {"geometry_msgs/Accel", "angular", "rad/s2"},
    {"geometry_msgs/Wrench", "force", "N"},
    {"geometry_msgs/Wrench", "torque", "Nm"},
    {"geometry_msgs/Pose", "position", "m"},
    {"geometry_msgs/Transform", "translation", "m"},
    {"geometry_msgs/PointStamped", "point", "m"},
    {"sensor_msgs/Imu", "angular_velocity", "rad/s"},
    {"sensor_msgs/Imu", "linear_acceleration", "m/s2"},
    {"sensor_msgs/NavSatFix", "latitude", "deg"},
    {"sensor_msgs/NavSatFix", "longitude", "deg"},
    {"sensor_msgs/NavSatFix", "altitude", "m"},
    {"sensor_msgs/MagneticField", "magnetic_field", "T"},
    {"sensor_msgs/Temperature", "temperature", "C"},
    {"sensor_msgs/FluidPressure", "fluid_pressure", "Pa"},
    {"sensor_msgs/Range", "range", "m"},
    {"ackermann_msgs/AckermannDrive", "steering_angle", "rad"},
    {"ackermann_msgs/AckermannDrive", "steering_angle_velocity", "rad/s"},
    {"ackermann_msgs/AckermannDrive", "speed", "m/s"},
    {"ackermann_msgs/AckermannDrive", "acceleration", "m/s2"},
    {"ackermann_msgs/AckermannDrive", "jerk", "m/s3"},
    {"foxglove.LocationFix", "latitude", "deg"},
    {"foxglove.LocationFix", "longitude", "deg"},
    {"foxglove.LocationFix", "altitude", "m"}};

// One type a line: its name, then its fields; lines that begin with blanks go on.
constexpr std::string_view kStandard = R"(builtin_interfaces/Time; int32 sec; uint32 nanosec
builtin_interfaces/Duration; int32 sec; uint32 nanosec
std_msgs/Header; builtin_interfaces/Time stamp; string frame_id
std_msgs/Bool; bool data
std_msgs/Int8; int8 data
std_msgs/UInt8; uint8 data
std_msgs/Int16; int16 data
std_msgs/UInt16; uint16 data
std_msgs/Int32; int32 data
std_msgs/UInt32; uint32 data
std_msgs/Int64; int64 data
std_msgs/UInt64; uint64 data
std_msgs/Float32; float32 data
std_msgs/Float64; float64 data
geometry_msgs/Vector3; float64 x; float64 y; float64 z
geometry_msgs/Point; float64 x; float64 y; float64 z
geometry_msgs/Quaternion; float64 x; float64 y; float64 z; float64 w
geometry_msgs/Pose; Point position; Quaternion orientation
geometry_msgs/Twist; Vector3 linear; Vector3 angular
geometry_msgs/Accel; Vector3 linear; Vector3 angular
geometry_msgs/Wrench; Vector3 force; Vector3 torque
geometry_msgs/Transform; Vector3 translation; Quaternion rotation
geometry_msgs/PoseWithCovariance; Pose pose; float64[36] covariance
geometry_msgs/TwistWithCovariance; Twist twist; float64[36] covariance
geometry_msgs/AccelWithCovariance; Accel accel; float64[36] covariance
geometry_msgs/Vector3Stamped; Header header; Vector3 vector
geometry_msgs/PointStamped; Header header; Point point
geometry_msgs/QuaternionStamped; Header header; Quaternion quaternion
geometry_msgs/PoseStamped; Header header; Pose pose
geometry_msgs/TwistStamped; Header header; Twist twist
geometry_msgs/AccelStamped; Header header; Accel accel
geometry_msgs/WrenchStamped; Header header; Wrench wrench
geometry_msgs/TransformStamped; Header header; string child_frame_id; Transform transform
geometry_msgs/PoseWithCovarianceStamped; Header header; PoseWithCovariance pose
geometry_msgs/TwistWithCovarianceStamped; Header header; TwistWithCovariance twist
geometry_msgs/AccelWithCovarianceStamped; Header header; AccelWithCovariance accel
nav_msgs/Odometry; Header header; string child_frame_id
  ; geometry_msgs/PoseWithCovariance pose; geometry_msgs/TwistWithCovariance twist
sensor_msgs/Imu; Header header; geometry_msgs/Quaternion orientation
  ; float64[9] orientation_covariance; geometry_msgs/Vector3 angular_velocity
  ; float64[9] angular_velocity_covariance; geometry_msgs/Vector3 linear_acceleration
  ; float64[9] linear_acceleration_covariance
sensor_msgs/NavSatStatus; int8 status; uint16 service
sensor_msgs/NavSatFix; Header header; NavSatStatus status; float64 latitude
  ; float64 longitude; float64 altitude; float64[9] position_covariance
  ; uint8 position_covariance_type
sensor_msgs/MagneticField; Header header; geometry_msgs/Vector3 magnetic_field
  ; float64[9] magnetic_field_covariance
sensor_msgs/Temperature; Header header; float64 temperature; float64 variance
sensor_msgs/FluidPressure; Header header; float64 fluid_pressure; float64 variance
sensor_msgs/JointState; Header header; string[] name; float64[] position; float64[] velocity
  ; float64[] effort
sensor_msgs/TimeReference; Header header; builtin_interfaces/Time time_ref; string source
ackermann_msgs/AckermannDrive; float32 steering_angle; float32 steering_angle_velocity
  ; float32 speed; float32 acceleration; float32 jerk
ackermann_msgs/AckermannDriveStamped; Header header; AckermannDrive drive
)";

MessageTypes make_standard() {
  MessageTypes out;
  base::Lines lines(kStandard);
  std::string_view line;
  std::string type;
  while (lines.next(line)) {
    std::size_t end = line.find(';');
    if (line.front() != ' ') type = line.substr(0, end);
    std::vector<MessageField>& fields = out[type];
    while (end != std::string_view::npos) {
      line.remove_prefix(end + 1);
      end = line.find(';');
      if (auto field = field_of(base::trimmed(line.substr(0, end)), type))
        fields.push_back(std::move(*field));
    }
  }
  return out;
}

}  // namespace

std::string plain_type(std::string_view type) {
  std::string out(type);
  if (const std::size_t at = out.find("/msg/"); at != std::string::npos) out.erase(at, 4);
  return out;
}

MessageTypes parse_message_types(std::string_view text, const std::string& root) {
  MessageTypes out;
  std::string type = plain_type(root);
  out[type];
  base::Lines lines(text);
  std::string_view line;
  while (lines.next(line)) {
    line = base::trimmed(line.substr(0, line.find('#')));
    if (line.empty() || line.starts_with("====")) continue;
    if (line.starts_with("MSG: ")) {
      type = plain_type(base::trimmed(line.substr(5)));
      out[type].clear();
      continue;
    }
    if (auto field = field_of(line, type)) out[type].push_back(std::move(*field));
  }
  return out;
}

const MessageTypes& standard_types() {
  static const MessageTypes types = make_standard();
  return types;
}

std::string_view standard_unit(std::string_view type, std::string_view field) {
  for (const StandardUnit& known : kUnits)
    if (known.type == type && known.field == field) return known.unit;
  return {};
}

}  // namespace recording
