#include "sim/unit.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"
#include "fmi2.h"
#include "fmi3.h"
#include "own_car.h"
#include "unit_library.h"
#include "watch.h"

namespace sim {
namespace {

constexpr const char* kStatusNames[] = {"ok", "warning", "discard", "error", "fatal", "pending"};

bool is_whole(ValueType type) {
  return type != ValueType::float64 && type != ValueType::float32 && type != ValueType::boolean;
}

/// The range of a whole number's type; beyond 2^53 a double cannot tell its neighbours apart.
std::pair<double, double> range_of(ValueType type) {
  switch (type) {
    case ValueType::int8:
      return {-128.0, 127.0};
    case ValueType::uint8:
      return {0.0, 255.0};
    case ValueType::int16:
      return {-32768.0, 32767.0};
    case ValueType::uint16:
      return {0.0, 65535.0};
    case ValueType::int32:
      return {-2147483648.0, 2147483647.0};
    case ValueType::uint32:
      return {0.0, 4294967295.0};
    case ValueType::uint64:
      return {0.0, 9007199254740992.0};
    default:
      return {-9007199254740992.0, 9007199254740992.0};
  }
}

}  // namespace

struct Unit::Loaded {
  std::string path;
  UnitDescription description;
  Log log;
  std::variant<Fmi2, Fmi3, OwnCar> functions;
  std::optional<Library> library;
  void* instance = nullptr;
  std::string resources;
  std::map<std::string, void*> states;
  bool is_ready = false, is_broken = false;
  Watch* watch = nullptr;

  [[noreturn]] void refuse(const std::string& what) const { throw base::Error(path + ": " + what); }

  void make() {
    instance = std::visit(
        [&](auto& of_version) { return of_version.make(resources, description, log); }, functions);
    if (instance == nullptr)
      refuse("the unit cannot be instantiated" +
             (log.last.empty() ? "" : "; it says: " + log.last));
  }

  void free() {
    if (instance == nullptr) return;
    log.closes = true;
    const auto with = [&](const auto& of_version) {
      for (auto& [name, state] : states)
        if (!is_broken) of_version.free_state(instance, &state);
      if (is_ready && !is_broken) of_version.terminate(instance);
      of_version.release(instance);
    };
    std::visit(with, functions);
    log.closes = false;
    states.clear();
    instance = nullptr;
    is_ready = false;
  }

  /// The one before stays until the new one has begun, where there may be two.
  void begin_in_another(const std::function<void()>& begin) {
    if (description.can_be_instantiated_once_only) free();
    const auto before = std::tuple(instance, is_ready, is_broken);
    auto now = std::tie(instance, is_ready, is_broken);
    now = std::tuple(nullptr, false, false);
    try {
      make();
      begin();
    } catch (...) {
      free();
      now = before;
      throw;
    }
    const std::tuple<void*, bool, bool> begun = now;
    now = before;
    free();
    now = begun;
  }

  /// States are of the instance that made them.
  void begin_after_reset(const std::function<void()>& begin) {
    void* before = nullptr;
    if (is_ready && !is_broken)
      want(std::visit([&](auto& of) { return of.get_state(instance, &before); }, functions),
           "saving its state");
    const auto forget = [&] {
      if (before != nullptr)
        std::visit([&](auto& of) { return of.free_state(instance, &before); }, functions);
    };
    is_ready = is_broken = false;
    try {
      log.closes = true;
      const Status status = std::visit([&](auto& of) { return of.reset(instance); }, functions);
      log.closes = false;
      want(status, "reset");
      begin();
    } catch (...) {
      if (before != nullptr)
        is_ready = std::visit([&](auto& of) { return of.set_state(instance, before); },
                              functions) <= kWarning;
      is_broken = !is_ready;
      forget();
      throw;
    }
    forget();
  }

  void want(Status status, const std::string& what) {
    if (status <= kWarning) return;
    is_broken = is_broken || status >= 3;
    const char* const name = status >= 0 && status <= 5 ? kStatusNames[status] : "unknown status";
    refuse(fmt::format("{}: {} from the unit{}", what, name,
                       log.last.empty() ? "" : ", which says: " + log.last));
  }
};

Unit::Unit(const UnpackedUnit& files, UnitDescription description,
           std::function<void(const std::string&, bool closes)> log, Watch* watch)
    : loaded_(std::make_unique<Loaded>()) {
  Loaded& unit = *loaded_;
  unit.watch = watch;
  const InUnit inside(watch, Watch::kStart);
  unit.path = files.path();
  unit.description = std::move(description);
  unit.log.take = std::move(log);
  const bool is_2 = unit.description.version == 2;
  if (unit.description.needs_its_tool)
    unit.refuse("needs the tool that made it (needsExecutionTool); export it self-contained");
  if (is_vehicle_file(unit.path)) {
    unit.functions.emplace<OwnCar>();
    unit.resources = files.folder() + "/resources";
    unit.make();
    return;
  }
  const std::string binary =
      fmt::format("{}/binaries/{}/{}.so", files.folder(), is_2 ? "linux64" : "x86_64-linux",
                  unit.description.identifier);
  if (!std::filesystem::is_regular_file(binary))
    unit.refuse(
        fmt::format("no binary for Linux on x86-64: {}.so is missing in binaries/{}; "
                    "export it for this platform",
                    unit.description.identifier, is_2 ? "linux64" : "x86_64-linux"));
  unit.library.emplace(binary, unit.path);
  const bool keeps_states = unit.description.keeps_states;
  if (is_2)
    unit.functions.emplace<Fmi2>().find_in(*unit.library, keeps_states);
  else
    unit.functions.emplace<Fmi3>().find_in(*unit.library, keeps_states);
  unit.library->want_all();
  std::filesystem::create_directories(files.folder() + "/resources");
  unit.resources = files.folder() + (is_2 ? "/resources" : "/resources/");
  unit.make();
}

Unit::~Unit() {
  const InUnit inside(loaded_->watch, Watch::kStart);
  loaded_->free();
}

bool Unit::is_there() const { return loaded_->instance != nullptr && loaded_->is_ready; }

void Unit::begin_anew(const std::function<void()>& begin) {
  Loaded& unit = *loaded_;
  const InUnit inside(unit.watch, Watch::kStart);
  if (unit.states.empty())
    unit.begin_in_another(begin);
  else
    unit.begin_after_reset(begin);
}

void Unit::save(const std::string& name) {
  Loaded& unit = *loaded_;
  const InUnit inside(unit.watch, Watch::kStep);
  if (!unit.description.keeps_states) unit.refuse("it cannot save its state");
  // What is there already is used again.
  void* state = has_saved(name) ? unit.states.at(name) : nullptr;
  const Status status = std::visit(
      [&](auto& functions) { return functions.get_state(unit.instance, &state); }, unit.functions);
  if (state != nullptr) unit.states[name] = state;
  unit.want(status, "saving its state");
  if (state == nullptr) unit.refuse("saving its state: ok from the unit, but there is none");
}

bool Unit::has_saved(const std::string& name) const { return loaded_->states.contains(name); }

std::size_t Unit::saved_states() const { return loaded_->states.size(); }

void Unit::restore(const std::string& name) {
  Loaded& unit = *loaded_;
  const InUnit inside(unit.watch, Watch::kStep);
  if (!has_saved(name)) unit.refuse("no state was saved as '" + name + "'");
  const Status status = std::visit(
      [&](auto& functions) { return functions.set_state(unit.instance, unit.states.at(name)); },
      unit.functions);
  unit.want(status, "going back to the state " + name);
  unit.is_ready = true;
  unit.is_broken = false;
}

const UnitDescription& Unit::description() const { return loaded_->description; }

void Unit::set(const UnitVariable& variable, std::span<const double> values) {
  Loaded& unit = *loaded_;
  const InUnit inside(unit.watch, Watch::kStep);
  if (variable.type == ValueType::string || variable.type == ValueType::other)
    unit.refuse(variable.name + " holds no numbers");
  if (values.size() != variable.size)
    unit.refuse(
        fmt::format("{} values for {}; {} wanted", values.size(), variable.name, variable.size));
  const auto [least, most] = range_of(variable.type);
  for (const double value : values)
    if (is_whole(variable.type) && !(value >= least && value <= most))
      unit.refuse(fmt::format("{} for {}; {} to {} wanted", value, variable.name, least, most));
  std::vector<double> copy(values.begin(), values.end());
  const Status status = std::visit(
      [&](auto& functions) { return functions.access(unit.instance, variable, copy, true); },
      unit.functions);
  unit.want(status, "setting " + variable.name);
}

void Unit::get(const UnitVariable& variable, std::span<double> values) {
  Loaded& unit = *loaded_;
  const InUnit inside(unit.watch, Watch::kStep);
  if (variable.type == ValueType::string || variable.type == ValueType::other)
    unit.refuse(variable.name + " holds no numbers");
  if (values.size() != variable.size)
    unit.refuse(fmt::format("{} places for {}, which has {} values", values.size(), variable.name,
                            variable.size));
  const Status status = std::visit(
      [&](auto& functions) { return functions.access(unit.instance, variable, values, false); },
      unit.functions);
  unit.want(status, "reading " + variable.name);
}

void Unit::set_text(const UnitVariable& variable, const std::string& text) {
  Loaded& unit = *loaded_;
  const InUnit inside(unit.watch, Watch::kStep);
  if (variable.type != ValueType::string || variable.size != 1)
    unit.refuse(variable.name + " is no text");
  const Status status = std::visit(
      [&](auto& functions) { return functions.write_text(unit.instance, variable, text.c_str()); },
      unit.functions);
  unit.want(status, "setting " + variable.name);
}

std::string Unit::get_text(const UnitVariable& variable) {
  Loaded& unit = *loaded_;
  const InUnit inside(unit.watch, Watch::kStep);
  if (variable.type != ValueType::string || variable.size != 1)
    unit.refuse(variable.name + " is no text");
  const char* text = nullptr;
  const Status status = std::visit(
      [&](auto& functions) { return functions.read_text(unit.instance, variable, text); },
      unit.functions);
  unit.want(status, "reading " + variable.name);
  return text == nullptr ? "" : text;
}

void Unit::initialise(double start_s, std::optional<double> stop_s) {
  Loaded& unit = *loaded_;
  const InUnit inside(unit.watch, Watch::kStart);
  const Status status = std::visit(
      [&](auto& functions) {
        return functions.initialise(unit.instance, start_s, stop_s, unit.description.tolerance);
      },
      unit.functions);
  unit.want(status, "initialisation");
  unit.is_ready = true;
}

bool Unit::step(double time_s, double step_s) {
  Loaded& unit = *loaded_;
  const InUnit inside(unit.watch, Watch::kStep);
  bool ends = false;
  const Status status = std::visit(
      [&](auto& functions) { return functions.step(unit.instance, time_s, step_s, ends); },
      unit.functions);
  unit.want(status, fmt::format("the step of {} s at {} s", step_s, time_s));
  return !ends;
}

}  // namespace sim
