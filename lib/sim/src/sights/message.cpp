#include "sim/message.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/one_line.h"
#include "put_bytes.h"

namespace sim {
namespace {

using nlohmann::json;

constexpr std::string_view kCommand = "KSC1", kMeasurement = "KSM1", kRemark = "KSR1";
constexpr std::uint32_t kEnds = 1, kResets = 2, kPauses = 4, kPlans = 8, kSaves = 16,
                        kGoesBack = 32, kSafe = 1, kWasReset = 2, kClipped = 4, kParked = 8;

template <class Value>
bool take(std::string_view& bytes, Value& value) {
  if (bytes.size() < sizeof value) return false;
  std::memcpy(&value, bytes.data(), sizeof value);
  bytes.remove_prefix(sizeof value);
  return true;
}

constexpr const char* kNoPlan = "a plan that is no list of at most 500 points x, y, speed";

bool plan_is_finite(const std::vector<PlanPoint>& plan, std::string& why) {
  for (const PlanPoint& point : plan)
    if (!std::isfinite(point.x_m) || !std::isfinite(point.y_m) || !std::isfinite(point.speed_mps)) {
      why = "a value that is not finite";
      return false;
    }
  return true;
}

constexpr const char* kNoName = "a state without a name of 1 to 64 bytes";

bool take_name(std::string_view& bytes, std::string& name, std::string& why) {
  std::uint32_t size = 0;
  if (!take(bytes, size) || size == 0 || size > kLongestStateName || size > bytes.size()) {
    why = kNoName;
    return false;
  }
  name = bytes.substr(0, size);
  bytes.remove_prefix(size);
  return true;
}

/// What is left of a command is its plan.
bool take_plan(std::string_view bytes, std::vector<PlanPoint>& plan, std::string& why) {
  std::uint32_t points = 0;
  if (!take(bytes, points) || points > kMostPlanPoints ||
      bytes.size() != std::size_t{points} * 3 * sizeof(double)) {
    why = kNoPlan;
    return false;
  }
  plan.resize(points);
  for (PlanPoint& point : plan) {
    take(bytes, point.x_m);
    take(bytes, point.y_m);
    take(bytes, point.speed_mps);
  }
  return plan_is_finite(plan, why);
}

std::optional<CommandMessage> read_binary(std::string_view bytes, std::size_t count,
                                          std::string& why) {
  CommandMessage message;
  message.is_binary = true;
  std::uint32_t flags = 0, values = 0;
  bytes.remove_prefix(kCommand.size());
  if (!take(bytes, message.sequence) || !take(bytes, flags) || !take(bytes, values)) {
    why = "cut short";
    return std::nullopt;
  }
  message.ends = (flags & kEnds) != 0;
  message.resets = (flags & kResets) != 0;
  message.pauses = (flags & kPauses) != 0;
  if (values != count || bytes.size() < count * sizeof(double) ||
      ((flags & (kPlans | kSaves | kGoesBack)) == 0 && bytes.size() != count * sizeof(double))) {
    why = "another number of values than commands were named";
    return std::nullopt;
  }
  message.values.resize(count);
  for (double& value : message.values) {
    take(bytes, value);
    if (!std::isfinite(value)) {
      why = "a value that is not finite";
      return std::nullopt;
    }
  }
  message.resets = message.resets || (flags & kGoesBack) != 0;
  if ((flags & kSaves) != 0 && !take_name(bytes, message.save, why)) return std::nullopt;
  if ((flags & kGoesBack) != 0 && !take_name(bytes, message.state, why)) return std::nullopt;
  if ((flags & kPlans) != 0 && !take_plan(bytes, message.plan.emplace(), why)) return std::nullopt;
  if ((flags & kPlans) == 0 && (flags & (kSaves | kGoesBack)) != 0 && !bytes.empty()) {
    why = "bytes after its end";
    return std::nullopt;
  }
  return message;
}

/// [[x, y, speed], ...]
bool read_plan(const json& list, std::vector<PlanPoint>& plan, std::string& why) {
  if (!list.is_array() || list.size() > kMostPlanPoints) {
    why = kNoPlan;
    return false;
  }
  for (const json& point : list) {
    std::array<double, 3> numbers{};
    bool is_point = point.is_array() && point.size() == numbers.size();
    for (std::size_t k = 0; is_point && k < numbers.size(); ++k) {
      is_point = point[k].is_number();
      if (is_point) numbers[k] = point[k].get<double>();
    }
    if (!is_point) {
      why = kNoPlan;
      return false;
    }
    plan.push_back({numbers[0], numbers[1], numbers[2]});
  }
  return plan_is_finite(plan, why);
}

/// Words of whoever drives, fit for a line.
std::string quoted(const std::string& said) {
  return "'" + base::one_line(said.substr(0, 60)) + "'";
}

/// A number that is one; else the reason.
bool take_number(const std::string& name, const json& said, double& value, std::string& why) {
  value = said.is_number() ? said.get<double>() : std::numeric_limits<double>::quiet_NaN();
  if (std::isfinite(value)) return true;
  why = quoted(name) + " is said to be " + base::one_line(base::dump_json(said).substr(0, 60)) +
        "; a finite number wanted";
  return false;
}

bool has_too_many_lists(std::string_view bytes) {
  return std::count(bytes.begin(), bytes.end(), '[') >
             16 + static_cast<std::ptrdiff_t>(kMostPlanPoints) ||
         std::count(bytes.begin(), bytes.end(), '{') > 16;
}

std::optional<CommandMessage> read_json(std::string_view bytes,
                                        const std::vector<std::string>& names, std::string& why) {
  if (has_too_many_lists(bytes)) {
    why = "more lists or tables than a command has";
    return std::nullopt;
  }
  const json object = base::parse_json<json>(bytes, false);
  const auto refuse = [&](std::string reason) {
    why = std::move(reason);
    return std::nullopt;
  };
  if (!object.is_object()) return refuse("no JSON object, or a number beyond 1e308");
  CommandMessage message;
  message.values.assign(names.size(), std::numeric_limits<double>::quiet_NaN());
  for (const auto& [key, value] : object.items()) {
    if (key == "sequence") {
      if (!value.is_number_unsigned() ||
          value.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max())
        return refuse("sequence is no whole number from 0 to 4294967295");
      message.sequence = value.get<std::uint32_t>();
    } else if (key == "end") {
      if (!value.is_boolean()) return refuse("end is neither true nor false");
      message.ends = value.get<bool>();
    } else if (key == "set") {
      if (!value.is_object()) return refuse("set is no object");
      for (const auto& [name, number] : value.items()) {
        const auto found = std::find(names.begin(), names.end(), name);
        if (found == names.end()) return refuse(quoted(name) + " is no command of this run");
        double& to = message.values[static_cast<std::size_t>(found - names.begin())];
        if (!take_number(name, number, to, why)) return std::nullopt;
      }
    } else if (key == "pause") {
      if (!value.is_boolean()) return refuse("pause is neither true nor false");
      message.pauses = value.get<bool>();
    } else if (key == "reset") {
      if (!value.is_object()) return refuse("reset is no object of starts");
      message.resets = true;
      for (const auto& [name, number] : value.items()) {
        if (name == "state" && number.is_string()) {
          message.state = number.get<std::string>();
          if (message.state.empty()) return refuse(kNoName);
          continue;
        }
        double& to = message.starts.emplace_back(name, 0.0).second;
        if (!take_number(name, number, to, why)) return std::nullopt;
      }
    } else if (key == "save") {
      if (!value.is_string() || value.get_ref<const std::string&>().empty()) return refuse(kNoName);
      message.save = value.get<std::string>();
    } else if (key == "plan") {
      if (!read_plan(value, message.plan.emplace(), why)) return std::nullopt;
    } else {
      return refuse("a key that is not sequence, set, plan, pause, save, reset or end: " +
                    quoted(key));
    }
  }
  return message;
}

}  // namespace

std::string wrong_with_states(const CommandMessage& message) {
  if (std::max(message.save.size(), message.state.size()) > kLongestStateName) return kNoName;
  if (!message.save.empty() && message.resets) return "a state to save and a reset at once";
  if (!message.state.empty() && !message.starts.empty()) return "starts for a state that was saved";
  return {};
}

std::optional<CommandMessage> read_command(std::string_view bytes,
                                           const std::vector<std::string>& names,
                                           std::string& why) {
  if (bytes.size() > kLongestMessage) {
    why = "longer than 60 kB";
    return std::nullopt;
  }
  std::optional<CommandMessage> message;
  if (is_binary(bytes))
    message = read_binary(bytes, names.size(), why);
  else if (bytes.starts_with('{'))
    message = read_json(bytes, names, why);
  else
    why = "neither JSON nor KSC1";
  if (!message) return std::nullopt;
  why = wrong_with_states(*message);
  return why.empty() ? message : std::nullopt;
}

bool is_binary(std::string_view bytes) { return bytes.starts_with(kCommand); }

std::optional<std::uint32_t> sequence_of(std::string_view bytes) {
  std::uint32_t sequence = 0;
  if (bytes.size() > kLongestMessage) return std::nullopt;
  if (is_binary(bytes)) {
    bytes.remove_prefix(kCommand.size());
    return take(bytes, sequence) ? std::optional(sequence) : std::nullopt;
  }
  if (!bytes.starts_with('{') || has_too_many_lists(bytes)) return std::nullopt;
  const json object = base::parse_json<json>(bytes, false);
  const auto said = object.is_object() ? object.find("sequence") : object.end();
  if (said == object.end() || !said->is_number_unsigned() ||
      said->get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max())
    return std::nullopt;
  return said->get<std::uint32_t>();
}

std::string write_remark(const Remark& remark, bool as_binary) {
  if (!as_binary) {
    nlohmann::ordered_json line{{remark.kind, remark.text}, {"sequence", nullptr}};
    if (remark.sequence) line["sequence"] = *remark.sequence;
    line["time_s"] = remark.time_s;
    line["resets"] = remark.resets;
    return base::dump_json(line);
  }
  std::string bytes(kRemark);
  put(bytes, remark.sequence.value_or(0), static_cast<std::uint32_t>(remark.text.size()),
      remark.time_s);
  return bytes + remark.text;
}

std::string write_measurement(const MeasurementMessage& message,
                              const std::vector<std::string>& names, bool as_binary) {
  if (!as_binary) {
    nlohmann::ordered_json values = nlohmann::ordered_json::object();
    for (std::size_t i = 0; i < names.size(); ++i) values[names[i]] = message.values[i];
    nlohmann::ordered_json out{{"sequence", message.sequence},
                               {"time_s", message.time_s},
                               {"safe", message.is_safe},
                               {"reset", message.was_reset},
                               {"values", std::move(values)}};
    if (!message.clipped.empty()) out["clipped"] = message.clipped;
    if (!message.parked.empty()) out["parked"] = message.parked;
    return base::dump_json(out);
  }
  std::string bytes(kMeasurement);
  put(bytes, message.sequence);
  put(bytes, (message.is_safe ? kSafe : 0U) | (message.was_reset ? kWasReset : 0U) |
                 (message.clipped.empty() ? 0U : kClipped) |
                 (message.parked.empty() ? 0U : kParked));
  put(bytes, static_cast<std::uint32_t>(message.values.size()));
  put(bytes, message.time_s);
  for (const double value : message.values) put(bytes, value);
  return bytes;
}

}  // namespace sim
