#include "dds_messages.h"

#include <dds/dds.h>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "kerbstone.h"
#include "ros2.h"

namespace sim {

builtin_interfaces_msg_dds__Time_ stamp_of(double time_s) {
  const std::int64_t all = std::llround(1e9 * time_s);
  const std::int64_t seconds = all >= 0 ? all / 1'000'000'000 : (all + 1) / 1'000'000'000 - 1;
  return {static_cast<std::int32_t>(seconds),
          static_cast<std::uint32_t>(all - seconds * 1'000'000'000)};
}

namespace {

// Written, not kept: Cyclone DDS copies it.
char* text_of(const std::string& text) { return const_cast<char*>(text.c_str()); }

void fill(std_msgs_msg_dds__Header_& header, const Told& told) {
  header.stamp_ = stamp_of(told.time_s());
  header.frame_id_ = text_of(told.topic().frame);
}

geometry_msgs_msg_dds__Vector3_ vector_of(const Told& told, const std::string& of) {
  return {told.value(of + ".x"), told.value(of + ".y"), told.value(of + ".z")};
}

geometry_msgs_msg_dds__Quaternion_ orientation_of(const Told& told) {
  const auto q = quaternion(told.value("roll"), told.value("pitch"), told.value("yaw"));
  return {q[0], q[1], q[2], q[3]};
}

/// `variance` on three places of a square matrix's diagonal.
template <std::size_t count>
void spread(double variance, double (&matrix)[count], std::size_t first = 0) {
  constexpr std::size_t rows = count == 9 ? 3 : 6;
  for (std::size_t k = first; k < first + 3; ++k) matrix[k * (rows + 1)] = variance;
}

void fill(geometry_msgs_msg_dds__TwistWithCovariance_& twist, const Told& told) {
  twist.twist_ = {vector_of(told, "linear"), vector_of(told, "angular")};
  spread(told.value("linear.variance"), twist.covariance_);
  spread(told.value("angular.variance"), twist.covariance_, 3);
}

void fill(geometry_msgs_msg_dds__TwistWithCovarianceStamped_& message, const Told& told) {
  fill(message.header_, told);
  fill(message.twist_, told);
}

void fill(sensor_msgs_msg_dds__Imu_& message, const Told& told) {
  fill(message.header_, told);
  message.orientation_ = orientation_of(told);
  spread(told.value("orientation.variance"), message.orientation_covariance_);
  // The message's word for: not measured.
  if (!told.has("yaw") && !told.has("pitch") && !told.has("roll"))
    message.orientation_covariance_[0] = -1.0;
  message.angular_velocity_ = vector_of(told, "angular_velocity");
  spread(told.value("angular_velocity.variance"), message.angular_velocity_covariance_);
  message.linear_acceleration_ = vector_of(told, "linear_acceleration");
  spread(told.value("linear_acceleration.variance"), message.linear_acceleration_covariance_);
}

void fill(sensor_msgs_msg_dds__NavSatFix_& message, const Told& told) {
  fill(message.header_, told);
  message.status_ = {0, 1};  // a fix, by GPS
  message.latitude_ = told.value("latitude");
  message.longitude_ = told.value("longitude");
  message.altitude_ = told.value("altitude");
  spread(told.value("position.variance"), message.position_covariance_);
  message.position_covariance_type_ = told.has("position.variance") ? 2 : 0;  // diagonal known
}

void fill(nav_msgs_msg_dds__Odometry_& message, const Told& told) {
  fill(message.header_, told);
  message.child_frame_id_ = text_of(told.topic().child_frame);
  const auto at = vector_of(told, "position");
  message.pose_.pose_ = {{at.x_, at.y_, at.z_}, orientation_of(told)};
  spread(told.value("position.variance"), message.pose_.covariance_);
  spread(told.value("orientation.variance"), message.pose_.covariance_, 3);
  fill(message.twist_, told);
}

template <class Message>
dds_return_t write_as(dds_entity_t writer, const Told& told) {
  Message message{};
  fill(message, told);
  return dds_write(writer, &message);
}

template <>
dds_return_t write_as<kerbstone_msgs_msg_dds__Values_>(dds_entity_t writer, const Told& told) {
  std::vector<char*> names;
  std::vector<double> values;
  for (const std::string& field : told.topic().fields) {
    names.push_back(text_of(field));
    values.push_back(told.value(field));
  }
  const auto count = static_cast<std::uint32_t>(values.size());
  kerbstone_msgs_msg_dds__Values_ message{};
  fill(message.header_, told);
  message.names_ = {count, count, names.data(), false};
  message.values_ = {count, count, values.data(), false};
  return dds_write(writer, &message);
}

template <class Sequence, class Value>
Sequence lent(std::vector<Value>& values) {
  const auto count = static_cast<std::uint32_t>(values.size());
  return {count, count, values.data(), false};
}

std_msgs_msg_dds__Header_ header_of(double time_s, const std::string& frame) {
  return {stamp_of(time_s), text_of(frame)};
}

constexpr std::array kWireTypes{
    WireType{"sensor_msgs/Imu", &sensor_msgs_msg_dds__Imu__desc,
             write_as<sensor_msgs_msg_dds__Imu_>},
    WireType{"sensor_msgs/NavSatFix", &sensor_msgs_msg_dds__NavSatFix__desc,
             write_as<sensor_msgs_msg_dds__NavSatFix_>},
    WireType{"nav_msgs/Odometry", &nav_msgs_msg_dds__Odometry__desc,
             write_as<nav_msgs_msg_dds__Odometry_>},
    WireType{"geometry_msgs/TwistWithCovarianceStamped",
             &geometry_msgs_msg_dds__TwistWithCovarianceStamped__desc,
             write_as<geometry_msgs_msg_dds__TwistWithCovarianceStamped_>},
    WireType{"kerbstone_msgs/Values", &kerbstone_msgs_msg_dds__Values__desc,
             write_as<kerbstone_msgs_msg_dds__Values_>}};

}  // namespace

dds_return_t write_scan(dds_entity_t writer, const Scan& scan) {
  constexpr std::uint8_t kFloat32 = 7;
  static_assert(sizeof(ScanPoint) == 16);
  std::array<std::string, 4> names{"x", "y", "z", "intensity"};
  std::vector<sensor_msgs_msg_dds__PointField_> fields;
  for (std::uint32_t k = 0; k < 4; ++k) fields.push_back({text_of(names[k]), 4 * k, kFloat32, 1});
  const auto count = static_cast<std::uint32_t>(scan.points.size());
  auto* const bytes = reinterpret_cast<std::uint8_t*>(const_cast<ScanPoint*>(scan.points.data()));
  const sensor_msgs_msg_dds__PointCloud2_ message{header_of(scan.time_s, scan.name),
                                                  1,
                                                  count,
                                                  lent<decltype(message.fields_)>(fields),
                                                  false,
                                                  16,
                                                  16 * count,
                                                  {16 * count, 16 * count, bytes, false},
                                                  true};
  return dds_write(writer, &message);
}

dds_return_t write_edges(dds_entity_t writer, const Edges& edges) {
  std::vector<geometry_msgs_msg_dds__Point_> left, right;
  for (const auto& [x, y, z] : edges.left_m) left.push_back({x, y, z});
  for (const auto& [x, y, z] : edges.right_m) right.push_back({x, y, z});
  const std::string frame = "base_link";
  kerbstone_msgs_msg_dds__Edges_ message{};
  message.header_ = header_of(edges.time_s, frame);
  message.left_ = lent<decltype(message.left_)>(left);
  message.right_ = lent<decltype(message.right_)>(right);
  return dds_write(writer, &message);
}

dds_return_t write_plan(dds_entity_t writer, const Plan& plan) {
  std::vector<kerbstone_msgs_msg_dds__PlanPoint_> points;
  for (const PlanPoint& p : plan.points) points.push_back({p.x_m, p.y_m, p.speed_mps});
  const std::string frame = "map";
  kerbstone_msgs_msg_dds__Plan_ message{};
  message.header_ = header_of(plan.time_s, frame);
  message.sequence_ = plan.sequence;
  message.points_ = lent<decltype(message.points_)>(points);
  return dds_write(writer, &message);
}

dds_return_t write_remark(dds_entity_t writer, const Remark& remark) {
  kerbstone_msgs_msg_dds__Remark_ message{};
  message.stamp_ = stamp_of(remark.time_s);
  message.sequence_ = remark.sequence.value_or(0);
  message.kind_ = text_of(remark.kind);
  message.text_ = text_of(remark.text);
  return dds_write(writer, &message);
}

const WireType& wire_type(const std::string& name) {
  for (const WireType& type : kWireTypes)
    if (type.name == name) return type;
  throw base::Error("DDS: no message " + name);
}

}  // namespace sim
