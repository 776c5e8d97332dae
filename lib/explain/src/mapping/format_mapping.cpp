// A mapping as the text of a mapping.yaml.
#include <fmt/format.h>

#include <string>

#include "base/one_line.h"
#include "explain/mapping.h"

namespace explain {
namespace {

/// A name in YAML's double quotes.
std::string quoted(const std::string& name) {
  std::string out = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\')
      out += std::string("\\") + c;
    else if (static_cast<unsigned char>(c) < 32 || c == 127)
      out += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out + '"';
}

}  // namespace

std::string format_mapping(const Mapping& mapping) {
  std::string out =
      "# Which column of a log is which channel: value = column * scale + offset, taken delay_s "
      "earlier.\n";
  for (const std::string& note : mapping.notes) out += "# " + base::one_line(note) + "\n";
  out += "version: 1\n";
  const auto add_number = [&](const char* key, double value) {
    out += fmt::format("{}: {:.12g}", key, value);
  };
  if (mapping.imu_yaw_rad != 0) add_number("imu_yaw_rad", mapping.imu_yaw_rad), out += '\n';
  if (mapping.imu_ahead_m != 0) add_number("imu_ahead_m", mapping.imu_ahead_m), out += '\n';
  if (mapping.has_origin) {
    add_number("origin_latitude_deg", mapping.origin_latitude_deg), out += '\n';
    add_number("origin_longitude_deg", mapping.origin_longitude_deg), out += '\n';
  }
  if (mapping.place_turn_rad != 0)
    add_number("place_turn_rad", mapping.place_turn_rad), out += '\n';
  if (mapping.place_x_m != 0) add_number("place_x_m", mapping.place_x_m), out += '\n';
  if (mapping.place_y_m != 0) add_number("place_y_m", mapping.place_y_m), out += '\n';
  out += "columns:";
  if (mapping.columns.empty()) out += "\n  {}";
  for (std::size_t k = 0; k < mapping.columns.size(); ++k) {
    const ColumnMapping& m = mapping.columns[k];
    std::string channels = m.channel;
    for (; k + 1 < mapping.columns.size() && mapping.columns[k + 1].column == m.column; ++k)
      channels += ", " + mapping.columns[k + 1].channel;
    if (channels != m.channel) channels = "[" + channels + "]";
    // Longer keys need a question mark.
    const std::string name = quoted(m.column);
    out += fmt::format("\n  {}{}: {{channel: {}", name.size() > 1000 ? "? " : "",
                       name.size() > 1000 ? name + "\n  " : name, channels);
    const auto add = [&](const char* key, double value, double usual) {
      if (value != usual) out += ", ", add_number(key, value);
    };
    add("scale", m.scale, 1.0);
    add("offset", m.offset, 0.0);
    add("delay_s", m.delay_s, 0.0);
    add("low_pass_s", m.low_pass_s, 0.0);
    if (m.held) out += ", held: true";
    out += '}';
  }
  return out + "\n";
}

}  // namespace explain
