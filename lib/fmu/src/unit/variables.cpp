#include "fmu/variables.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "fmu/channel_name.h"
#include "recording/channels.h"
#include "vehicle/parameters.h"
#include "vehicle/state.h"

namespace fmu {
namespace {

constexpr std::array<const char*, 4> kWheelNames{"fl", "fr", "rl", "rr"};

/// What is no state's channel: meaning. Those of wheels with * for the wheel.
constexpr std::pair<std::string_view, std::string_view> kTelemetryTexts[] = {
    {"time_s", "simulated time"},
    {"u_m", "along the road's reference line, of the design centre of mass"},
    {"v_m", "left of the road's reference line, of the design centre of mass"},
    {"ax_mps2", "specific force along the body's x axis at the design centre of mass, last step"},
    {"ay_mps2", "specific force along the body's y axis at the design centre of mass, last step"},
    {"az_mps2", "specific force along the body's z axis at the design centre of mass, last step"},
    {"steer_command_rad", "input.steering as the last step had it"},
    {"steer_rad", "mean angle of the front road wheels behind the actuator, last step"},
    {"throttle_command", "input.throttle as the last step had it"},
    {"throttle", "opening behind the actuator, last step"},
    {"brake_*_command_pa", "input.brake as the last step had it"},
    {"brake_*_pa", "pressure behind the actuator, last step"},
    {"gear", "engaged gear; 0 neutral or shifting, -1 reverse"},
    {"fz_*_n", "force of the road on the tyre along the road's normal, last step"}};

std::string meaning_of_channel(const std::string& channel, const std::string& pattern) {
  for (const auto& [name, text] : kTelemetryTexts)
    if (name == pattern) return std::string(text);
  for (const vehicle::StateInfo& state : vehicle::kStates)
    if (state.channel == channel || state.name == channel) return std::string(state.meaning);
  return channel;
}

class List {
 public:
  void add(Variable variable) {
    variable.reference = reference_;
    reference_ += static_cast<std::uint32_t>(variable.size);
    all_.push_back(std::move(variable));
  }
  std::vector<Variable> all() const { return all_; }
  std::vector<Variable> take() { return std::move(all_); }

 private:
  std::vector<Variable> all_;
  std::uint32_t reference_ = 0;
};

void add_telemetry(List& list) {
  const std::vector<std::string>& channels = recording::telemetry_channels();
  for (std::size_t i = 0; i < channels.size();) {
    const ChannelName name = structured_name(channels[i]);
    Variable v;
    v.name = name.name;
    v.unit = name.unit;
    v.text = meaning_of_channel(channels[i], name.pattern);
    v.source = Source::kTelemetry;
    v.index = i;
    v.size = name.of_wheel ? 4 : 1;
    if (channels[i] == "time_s") {
      v.name = "time";
      v.causality = Causality::kIndependent;
    }
    if (channels[i] == "gear") {
      v.type = Type::kInteger;
      v.variability = Variability::kDiscrete;
      v.unit.clear();
    }
    i += v.size;
    list.add(std::move(v));
  }
}

void add_forces(List& list) {
  std::size_t index = 0;
  const auto add = [&](const char* channel, const char* text, std::size_t size, Type type) {
    const ChannelName name = structured_name(channel);
    Variable v;
    v.name = name.name;
    v.text = std::string(text) + ", last step";
    v.unit = type == Type::kReal ? name.unit : "";
    v.type = type;
    if (type != Type::kReal) v.variability = Variability::kDiscrete;
    v.source = Source::kForces;
    v.size = size;
    v.index = index;
    index += size;
    list.add(std::move(v));
  };
#define FMU_WHEEL(channel, member, text) add(channel, text, 4, Type::kReal);
#define FMU_WHEEL_FLAG(channel, member, text) add(channel, text, 4, Type::kBoolean);
#define FMU_CAR(channel, member, text) add(channel, text, 1, Type::kReal);
#include "forces.def"
#undef FMU_WHEEL
#undef FMU_WHEEL_FLAG
#undef FMU_CAR
}

void add_states(List& list) {
  for (std::size_t i = 0; i < vehicle::kStateSize;) {
    const ChannelName name = structured_name(vehicle::kStates[i].name);
    Variable v;
    v.name = "state." + name.name.substr(name.name.starts_with("car.") ? 4 : 0);
    v.unit = name.unit;
    v.text = vehicle::kStates[i].meaning;
    // "The same" of the state before says nothing alone.
    for (std::size_t j = i; v.text.starts_with("the same"); --j)
      v.text = vehicle::kStates[j].meaning;
    if (v.text.starts_with("its rate")) v.text = "rate of the wheel's travel";
    v.causality = Causality::kLocal;
    v.source = Source::kState;
    v.size = name.of_wheel ? 4 : 1;
    v.index = i;
    i += v.size;
    list.add(std::move(v));
  }
}

std::string rate_unit(const std::string& unit) {
  if (unit.ends_with("/s")) return unit + "2";
  return (unit == "1" ? "1" : unit) + "/s";
}

/// Made of the states of the list.
void add_rates(List& list) {
  for (Variable v : list.all()) {
    if (v.source != Source::kState) continue;
    v.name = "der(" + v.name + ")";
    v.unit = rate_unit(v.unit);
    v.text = "rate of the state as the next step has it: " + v.text;
    v.source = Source::kRate;
    list.add(std::move(v));
  }
}

void add_inputs(List& list) {
  std::size_t index = 0;
  const auto add = [&](std::string name, const char* unit, Type type, std::size_t size,
                       double start, double low, double high, const char* text) {
    Variable v;
    v.name = "input." + std::move(name);
    v.text = text;
    v.unit = unit;
    v.type = type;
    v.causality = Causality::kInput;
    v.variability = type == Type::kReal ? Variability::kContinuous : Variability::kDiscrete;
    v.source = Source::kInput;
    v.size = size;
    v.index = index;
    v.start = start;
    v.low = low;
    v.high = high;
    index += size;
    list.add(std::move(v));
  };
  constexpr double kFar_m = 1e7;
  add("steering", "rad", Type::kReal, 1, 0, -100, 100,
      "mean road wheel angle asked for times steering.ratio, left positive");
  add("throttle", "1", Type::kReal, 1, 0, 0, 1, "opening asked for");
  add("brake.*", "Pa", Type::kReal, 4, 0, 0, 1e8, "pressure asked for at this wheel's brake");
  add("gear", "", Type::kInteger, 1, 1, -1, vehicle::kMostGears,
      "gear asked for: 1 to the car's last, 0 neutral, -1 reverse; at the start the one engaged");
  add("clutch", "1", Type::kReal, 1, 0, 0, 1,
      "clutch pedal: 0 released, as the clutch does by itself, to 1, no torque");
  add("wake.active", "", Type::kBoolean, 1, 0, 0, 1,
      "a car at wake.x, wake.y slows the air; the opponents are not looked at then");
  add("wake.x", "m", Type::kReal, 1, 0, -kFar_m, kFar_m, "its place ahead of this car, body frame");
  add("wake.y", "m", Type::kReal, 1, 0, -kFar_m, kFar_m, "its place left of this car, body frame");
  add("opponent*.active", "", Type::kBoolean, 4, 0, 0, 1,
      "this opponent is on the road; of all, the nearest ahead slows the air");
  add("opponent*.x", "m", Type::kReal, 4, 0, -kFar_m, kFar_m, "its place in the map frame");
  add("opponent*.y", "m", Type::kReal, 4, 0, -kFar_m, kFar_m, "its place in the map frame");
}

Variable number_parameter(std::string name, std::string unit, std::string text, double start,
                          double low, double high) {
  Variable v;
  v.name = std::move(name);
  v.unit = std::move(unit);
  std::replace(v.unit.begin(), v.unit.end(), ' ', '.');
  v.text = std::move(text);
  v.causality = Causality::kParameter;
  v.start = start;
  v.low = low;
  v.high = high;
  return v;
}

void add_start(List& list) {
  std::size_t index = 0;
  const auto add = [&](const char* name, const char* unit, double start, double low, double high,
                       const char* text) {
    Variable v = number_parameter(name, unit, text, start, low, high);
    v.variability = Variability::kFixed;
    v.source = Source::kStart;
    v.index = index++;
    list.add(std::move(v));
  };
  add("start.u", "m", 0, -1e6, 1e6, "where the car stands at the start, along the reference line");
  add("start.v", "m", 0, -1e4, 1e4, "and left of it");
  add("start.yaw", "rad", 0, -7, 7, "its heading against that of the road, left positive");
  add("start.speed", "m/s", 0, -50, 120, "its speed, rolling straight");
  add("start.fuel", "kg", 30, 0, 500, "fuel at the start");
  add("start.tyre_temperature", "K", 360, 200, 500, "of the tyres at the start");
  add("start.disc_temperature", "K", 500, 200, 1500, "of the brake discs at the start");
  add("solver.step", "s", 0.001, 1e-5, 0.01, "the solver's own step; it divides those asked for");
}

void add_parameters(List& list) {
  std::size_t index = 0;
  for (const vehicle::ParameterInfo& info : vehicle::parameter_list()) {
    Variable v = number_parameter("parameter." + std::string(info.name), std::string(info.unit),
                                  std::string(info.text), info.value, info.low, info.high);
    v.variability = Variability::kTunable;
    v.source = Source::kParameter;
    v.index = index++;
    list.add(std::move(v));
  }
  const vehicle::Amplitudes<double> amplitudes = vehicle::default_amplitudes();
  index = 0;
  for (const vehicle::TermInfo& info : vehicle::term_list()) {
    Variable v = number_parameter("term." + std::string(info.name), "1",
                                  "share of this term; at 0: " + std::string(info.absence),
                                  amplitudes.value[index], 0.0, 1.0);
    v.variability = Variability::kTunable;
    v.source = Source::kTerm;
    v.index = index++;
    list.add(std::move(v));
  }
}

void add_texts(List& list) {
  static constexpr std::pair<const char*, const char*> kTexts[kTextCount] = {
      {"vehicle", "vehicle.yaml of the car; a path that does not begin with / lies in resources"},
      {"setup", "setup sheet, read after the vehicle's own; empty: none"},
      {"road", "CRG file of the road; empty: a level plane"},
      {"friction", "CRG file of the same shape whose heights are grip factors; empty: none"},
      {"contact", "single-point, four-point or strip; empty: as the vehicle file says"},
      {"integrator", "semi-implicit or explicit"},
      {"resources", "folder of the other files; empty: the one inside the unit"}};
  std::size_t index = 0;
  for (const auto& [name, text] : kTexts) {
    Variable v;
    v.name = name;
    v.text = text;
    v.type = Type::kString;
    v.causality = Causality::kParameter;
    v.variability = Variability::kFixed;
    v.source = Source::kText;
    v.index = index++;
    list.add(std::move(v));
  }
}

std::string with_star_as(const std::string& name, std::string_view instead) {
  const std::size_t star = name.find('*');
  if (star == std::string::npos) return name;
  return name.substr(0, star) + std::string(instead) + name.substr(star + 1);
}

}  // namespace

std::vector<Variable> variables() {
  List list;
  add_telemetry(list);
  add_forces(list);
  add_states(list);
  add_rates(list);
  add_inputs(list);
  add_start(list);
  add_parameters(list);
  add_texts(list);
  return list.take();
}

std::uint32_t count_values(const std::vector<Variable>& list) {
  return list.empty() ? 0 : list.back().reference + static_cast<std::uint32_t>(list.back().size);
}

std::vector<std::size_t> states_behind(const Variable& variable, std::size_t i) {
  if (variable.source != Source::kTelemetry) return {};
  const std::string& channel = recording::telemetry_channels()[variable.index + i];
  if (channel == "u_m" || channel == "v_m") return {vehicle::kX, vehicle::kY};
  if (channel == "boost") return {};  // of the last step, whatever the engine
  for (std::size_t k = 0; k < vehicle::kStateSize; ++k)
    if (vehicle::kStates[k].channel == channel) return {k};
  return {};
}

std::string value_name(const Variable& variable, std::size_t i) {
  if (variable.size == 1) return variable.name;
  const bool wheels = variable.name.find(".*") != std::string::npos;
  return with_star_as(variable.name, wheels ? std::string(kWheelNames[i])
                                            : std::string("[") + std::to_string(i + 1) + "]");
}

std::string array_name(const Variable& variable) {
  std::string name = variable.name;
  if (const std::size_t wheel = name.find(".*"); wheel != std::string::npos) name.erase(wheel, 2);
  std::erase(name, '*');
  return name;
}

}  // namespace fmu
