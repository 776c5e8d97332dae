#include "served_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"

namespace sim {

Numbers::Numbers(Unit& unit, const std::string& path, const std::vector<std::string>& names)
    : unit_(unit) {
  for (const std::string& name : names) {
    places_.push_back(place_of(unit.description(), path, name));
    if (!is_number(*places_.back().variable))
      throw base::Error(fmt::format("{}: {} holds no number", path, name));
  }
}

void Numbers::want_settable(const std::string& path) const {
  for (const Place& place : places_)
    if (!is_settable(*place.variable))
      throw base::Error(fmt::format(
          "{}: {} is no input of the unit and no tunable parameter, it is: {} {}", path,
          place.variable->name, place.variable->variability, place.variable->causality));
}

std::vector<double> Numbers::get() {
  std::vector<double> out;
  for (const Place& place : places_) {
    all_.resize(place.variable->size);
    unit_.get(*place.variable, all_);
    out.push_back(all_[place.index]);
  }
  return out;
}

void Numbers::set(const std::vector<double>& values) {
  for (std::size_t k = 0; k < places_.size(); ++k) {
    const UnitVariable& variable = *places_[k].variable;
    all_.resize(variable.size);
    if (variable.size > 1) unit_.get(variable, all_);
    all_[places_[k].index] = values[k];
    unit_.set(variable, all_);
  }
}

Measurements::Measurements(Unit& unit, const std::string& path, const ServeOptions& options)
    : options_(options),
      sensors_(options.devices, options.step_s),
      truth_(unit, path, vehicle::SignalSensors::signals(options.devices)),
      direct_(unit, path, names_of(options, unit.description(), path)) {}

void Measurements::restart() {
  sensors_ = vehicle::SignalSensors(options_.devices, options_.step_s);
}

void Measurements::step() {
  if (sensors_.size() > 0) sensors_.step(truth_.get());
}

std::vector<double> Measurements::get() {
  const std::vector<double> direct = direct_.get();
  std::vector<double> out;
  for (const auto& [kind, index] : sources_) switch (kind) {
      case Kind::direct:
        out.push_back(direct[index]);
        break;
      case Kind::sensor:
        out.push_back(sensors_.value(index));
        break;
      case Kind::age:
        out.push_back(sensors_.age_s(index));
        break;
      case Kind::latitude:
        out.push_back(place_deg(index)[0]);
        break;
      case Kind::longitude:
        out.push_back(place_deg(index)[1]);
        break;
    }
  return out;
}

std::array<double, 2> Measurements::place_deg(std::size_t position) const {
  const vehicle::SignalPosition& is = options_.devices.positions[position];
  return options_.to_latitude_longitude_deg(sensors_.value(is.x), sensors_.value(is.y));
}

std::optional<std::pair<Measurements::Kind, std::size_t>> Measurements::place_of_name(
    const ServeOptions& options, const std::string& name, const std::string& path) {
  const auto& positions = options.devices.positions;
  for (std::size_t k = 0; k < positions.size(); ++k)
    for (const auto& [kind, ending] :
         {std::pair{Kind::latitude, ".latitude_deg"}, {Kind::longitude, ".longitude_deg"}}) {
      if (name != positions[k].name + ending) continue;
      if (!options.to_latitude_longitude_deg)
        throw base::Error(
            fmt::format("{}: {} needs a road whose header says where on the Earth it "
                        "lies (--road)",
                        path, name));
      return std::pair{kind, k};
    }
  return std::nullopt;
}

std::vector<std::string> Measurements::names_of(const ServeOptions& options,
                                                const UnitDescription& unit,
                                                const std::string& path) {
  const auto& sensors = options.devices.sensors;
  for (const vehicle::SignalSensor& sensor : sensors)
    for (const std::string& name : {sensor.name, sensor.name + ".age_s"})
      if (unit.find(name) != nullptr)
        throw base::Error(fmt::format(
            "{}: the sensor {} has the name of a variable of the unit; call it otherwise", path,
            name));
  std::vector<std::string> direct;
  for (const std::string& name : options.measurements) {
    const auto sensor = std::find_if(sensors.begin(), sensors.end(), [&](const auto& one) {
      return name == one.name || name == one.name + ".age_s";
    });
    const std::optional<std::pair<Kind, std::size_t>> place = place_of_name(options, name, path);
    if (place) {
      sources_.push_back(*place);
    } else if (sensor == sensors.end()) {
      sources_.emplace_back(Kind::direct, direct.size());
      direct.push_back(name);
    } else {
      sources_.emplace_back(name == sensor->name ? Kind::sensor : Kind::age,
                            static_cast<std::size_t>(sensor - sensors.begin()));
    }
  }
  return direct;
}

Commands::Commands(Unit& unit, const std::string& path, const ServeOptions& options)
    : numbers_(unit, path, signals_of(options)), step_s_(options.step_s) {
  numbers_.want_settable(path);
  const double longest_s = step_s_ * (vehicle::laws::Actuator<double>::kCapacity - 2);
  for (const vehicle::SignalCommand& one : are_) {
    if (!(one.dead_time_s <= longest_s))
      throw base::Error(fmt::format(
          "{}: the command {} has a dead time of {} s, and steps of {} s allow {} s at most", path,
          one.name, one.dead_time_s, step_s_, longest_s));
    responses_.push_back(vehicle::laws::actuator_response(one.dead_time_s, one.lag_s, one.damping,
                                                          one.lead_s, step_s_));
  }
}

std::string Commands::bring_within(std::vector<double>& said, std::string& clipped) const {
  for (std::size_t k = 0; k < said.size(); ++k) {
    if (std::isnan(said[k])) continue;
    const UnitVariable& variable = *numbers_.places()[k].variable;
    const double value = are_[k].to_signal(said[k]);
    const std::string wrong = wrong_with(variable, value);
    if (wrong.empty()) continue;
    const std::string name = are_[k].name == variable.name ? "" : are_[k].name + ": ";
    const bool is_float =
        variable.type == ValueType::float64 || variable.type == ValueType::float32;
    if (!variable.is_input() || !is_float) return name + wrong;
    const double bound = std::clamp(value, variable.low, variable.high);
    said[k] = are_[k].from_signal(bound);
    clipped += fmt::format("{}{}{}; {} is taken", clipped.empty() ? "" : ", ", name, wrong, bound);
  }
  return {};
}

std::vector<double> Commands::get() {
  std::vector<double> values = numbers_.get();
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = are_[k].from_signal(values[k]);
  return values;
}

void Commands::restart() {
  const std::vector<double> values = numbers_.get();
  moving_ = {};
  for (const double value : values) {
    vehicle::laws::Actuator<double> at_rest;
    at_rest.history.fill(value);
    at_rest.place = value;
    moving_.actuators.push_back(at_rest);
  }
  held_ = values;
  is_written_ = false;
}

void Commands::restore(const Moving& moving) {
  moving_ = moving;
  held_ = numbers_.get();
  is_written_ = false;
}

std::string Commands::act(const std::vector<double>& said) {
  std::vector<double> values;
  for (std::size_t k = 0; k < said.size(); ++k) {
    values.push_back(are_[k].to_signal(said[k]));
    if (are_[k].has_actuator())
      values[k] = vehicle::laws::move(moving_.actuators[k], moving_.step, values[k], responses_[k]);
    // An actuator may swing beyond where it goes.
    const UnitVariable& variable = *numbers_.places()[k].variable;
    values[k] = std::clamp(values[k], variable.low, variable.high);
  }
  ++moving_.step;
  if (is_written_ && values == held_) return {};
  is_written_ = true;
  try {
    numbers_.set(values);
  } catch (const base::Error& error) {
    numbers_.set(held_);
    return error.what();
  }
  held_ = std::move(values);
  return {};
}

std::vector<std::string> Commands::signals_of(const ServeOptions& options) {
  std::vector<std::string> signals;
  for (const std::string& name : options.commands) {
    const auto& known = options.devices.commands;
    const auto found =
        std::find_if(known.begin(), known.end(), [&](const auto& one) { return one.name == name; });
    are_.push_back(found != known.end() ? *found : vehicle::SignalCommand{name, name});
    signals.push_back(are_.back().signal);
  }
  return signals;
}

std::vector<std::string> pose_names(const ServeOptions& options) {
  const auto& names = options.devices.road.pose;
  if (options.devices.road.empty()) return {};
  return {names.begin(), names.end()};
}

}  // namespace sim
