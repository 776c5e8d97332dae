#include "sim/unit.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <variant>
#include <vector>

#include "base/error.h"
#include "base/one_line.h"

namespace sim {
namespace {

using Reference = std::uint32_t;
using Status = int;  // OK 0, Warning 1, Discard 2, Error 3, Fatal 4, Pending 5
constexpr Status kWarning = 1;
constexpr const char* kStatusNames[] = {"ok", "warning", "discard", "error", "fatal", "pending"};

/// What a unit said, for messages; units may log from threads of their own.
struct Log {
  std::function<void(const std::string&)> take;
  std::string last;
  std::mutex mutex;

  void add(const char* text) {
    const std::lock_guard lock(mutex);
    last = base::one_line(text == nullptr ? "" : text);
    if (take) take(last);
  }
};

/// The functions of a binary.
class Library {
 public:
  Library(const std::string& path, std::string unit)
      : unit_(std::move(unit)), handle_(::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (handle_ != nullptr) return;
    const char* const why = ::dlerror();
    throw base::Error(fmt::format("{}: its binary cannot be loaded: {}", unit_,
                                  why == nullptr ? "no reason given" : why));
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  ~Library() { ::dlclose(handle_); }

  template <class Function>
  void find(Function& function, const char* name) {
    function = reinterpret_cast<Function>(::dlsym(handle_, name));
    if (function == nullptr) missing_ += (missing_.empty() ? "" : ", ") + std::string(name);
  }
  void want_all() const {
    if (!missing_.empty())
      throw base::Error(unit_ + ": its binary lacks functions of the standard: " + missing_);
  }

 private:
  std::string unit_, missing_;
  void* handle_;
};

bool is_whole(ValueType type) {
  return type != ValueType::float64 && type != ValueType::float32 && type != ValueType::boolean;
}

/// Into the unit's type and back; `call` gets a pointer to values of that type.
template <class Value, class Call>
Status with_copy(std::span<double> values, bool writes, const Call& call) {
  const std::unique_ptr<Value[]> copy(new Value[values.size()]());
  if (writes)
    for (std::size_t i = 0; i < values.size(); ++i)
      copy[i] = static_cast<Value>(std::is_floating_point_v<Value> ? values[i]
                                                                   : std::nearbyint(values[i]));
  const Status status = call(copy.get());
  if (!writes)
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(copy[i]);
  return status;
}

// Callbacks of FMI 2.0; section 2.1.5 of the standard.
struct Callbacks2 {
  void (*logger)(void*, const char*, Status, const char*, const char*, ...);
  void* (*allocate)(std::size_t, std::size_t);
  void (*release)(void*);
  void (*step_finished)(void*, Status);
  void* environment;
};

void log_2(void* environment, const char*, Status status, const char*, const char* format, ...) {
  if (environment == nullptr || format == nullptr) return;
  std::array<char, 2000> text{};
  va_list arguments;
  va_start(arguments, format);
  // NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): va_start is the line before
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  if (status != 0) static_cast<Log*>(environment)->add(text.data());
}

void log_3(void* environment, Status status, const char*, const char* text) {
  if (environment != nullptr && status != 0) static_cast<Log*>(environment)->add(text);
}

struct Fmi2 {
  template <class Value>
  using Access = Status (*)(void*, const Reference*, std::size_t, Value*);

  void* (*instantiate)(const char*, int, const char*, const char*, const Callbacks2*, int, int);
  void (*release)(void*);
  Status (*setup)(void*, int, double, double, int, double);
  Status (*enter)(void*);
  Status (*exit)(void*);
  Status (*do_step)(void*, double, double, int);
  Status (*terminate)(void*);
  Access<double> get_real;
  Access<const double> set_real;
  Access<int> get_integer, get_boolean;
  Access<const int> set_integer, set_boolean;
  Access<const char*> get_string;
  Access<const char* const> set_string;
  Callbacks2 callbacks{};

  void find_in(Library& library) {
    library.find(instantiate, "fmi2Instantiate");
    library.find(release, "fmi2FreeInstance");
    library.find(setup, "fmi2SetupExperiment");
    library.find(enter, "fmi2EnterInitializationMode");
    library.find(exit, "fmi2ExitInitializationMode");
    library.find(do_step, "fmi2DoStep");
    library.find(terminate, "fmi2Terminate");
    library.find(get_real, "fmi2GetReal");
    library.find(set_real, "fmi2SetReal");
    library.find(get_integer, "fmi2GetInteger");
    library.find(set_integer, "fmi2SetInteger");
    library.find(get_boolean, "fmi2GetBoolean");
    library.find(set_boolean, "fmi2SetBoolean");
    library.find(get_string, "fmi2GetString");
    library.find(set_string, "fmi2SetString");
  }

  void* make(const std::string& resources, const UnitDescription& description, Log& log) {
    callbacks = {&log_2, &std::calloc, &std::free, nullptr, &log};
    return instantiate("kerbstone", 1, description.token.c_str(), ("file://" + resources).c_str(),
                       &callbacks, 0, 0);
  }

  Status initialise(void* instance, double start_s, const std::optional<double>& stop_s) const {
    Status worst = setup(instance, 0, 0.0, start_s, stop_s ? 1 : 0, stop_s.value_or(0.0));
    if (worst <= kWarning) worst = std::max(worst, enter(instance));
    if (worst <= kWarning) worst = std::max(worst, exit(instance));
    return worst;
  }

  Status step(void* instance, double time_s, double step_s, bool&) const {
    return do_step(instance, time_s, step_s, 1);
  }

  Status access(void* instance, const UnitVariable& v, std::span<double> values,
                bool writes) const {
    const Reference* const r = &v.reference;
    if (v.type == ValueType::float64)
      return writes ? set_real(instance, r, 1, values.data())
                    : get_real(instance, r, 1, values.data());
    return with_copy<int>(values, writes, [&](int* copy) {
      if (v.type == ValueType::boolean)
        return writes ? set_boolean(instance, r, 1, copy) : get_boolean(instance, r, 1, copy);
      return writes ? set_integer(instance, r, 1, copy) : get_integer(instance, r, 1, copy);
    });
  }

  Status write_text(void* instance, const UnitVariable& v, const char* text) const {
    return set_string(instance, &v.reference, 1, &text);
  }
  Status read_text(void* instance, const UnitVariable& v, const char*& text) const {
    return get_string(instance, &v.reference, 1, &text);
  }
};

struct Fmi3 {
  template <class Value>
  struct Access {
    Status (*get)(void*, const Reference*, std::size_t, Value*, std::size_t);
    Status (*set)(void*, const Reference*, std::size_t, const Value*, std::size_t);
  };

  void* (*instantiate)(const char*, const char*, const char*, bool, bool, bool, bool,
                       const Reference*, std::size_t, void*,
                       void (*)(void*, Status, const char*, const char*), void*);
  void (*release)(void*);
  Status (*enter)(void*, bool, double, double, bool, double);
  Status (*exit)(void*);
  Status (*do_step)(void*, double, double, bool, bool*, bool*, bool*, double*);
  Status (*terminate)(void*);
  Access<double> float64;
  Access<float> float32;
  Access<std::int8_t> int8;
  Access<std::uint8_t> uint8;
  Access<std::int16_t> int16;
  Access<std::uint16_t> uint16;
  Access<std::int32_t> int32;
  Access<std::uint32_t> uint32;
  Access<std::int64_t> int64;
  Access<std::uint64_t> uint64;
  Access<bool> boolean;
  Access<const char*> string;

  template <class Value>
  static void find_access(Library& library, Access<Value>& access, const std::string& type) {
    library.find(access.get, ("fmi3Get" + type).c_str());
    library.find(access.set, ("fmi3Set" + type).c_str());
  }

  void find_in(Library& library) {
    library.find(instantiate, "fmi3InstantiateCoSimulation");
    library.find(release, "fmi3FreeInstance");
    library.find(enter, "fmi3EnterInitializationMode");
    library.find(exit, "fmi3ExitInitializationMode");
    library.find(do_step, "fmi3DoStep");
    library.find(terminate, "fmi3Terminate");
    find_access(library, float64, "Float64");
    find_access(library, float32, "Float32");
    find_access(library, int8, "Int8");
    find_access(library, uint8, "UInt8");
    find_access(library, int16, "Int16");
    find_access(library, uint16, "UInt16");
    find_access(library, int32, "Int32");
    find_access(library, uint32, "UInt32");
    find_access(library, int64, "Int64");
    find_access(library, uint64, "UInt64");
    find_access(library, boolean, "Boolean");
    find_access(library, string, "String");
  }

  void* make(const std::string& resources, const UnitDescription& description, Log& log) const {
    return instantiate("kerbstone", description.token.c_str(), resources.c_str(), false, false,
                       false, false, nullptr, 0, &log, &log_3, nullptr);
  }

  Status initialise(void* instance, double start_s, const std::optional<double>& stop_s) const {
    const Status entered =
        enter(instance, false, 0.0, start_s, stop_s.has_value(), stop_s.value_or(0.0));
    return entered > kWarning ? entered : std::max(entered, exit(instance));
  }

  Status step(void* instance, double time_s, double step_s, bool& ends) const {
    bool event = false, early = false;
    double reached_s = time_s;
    const Status status =
        do_step(instance, time_s, step_s, true, &event, &ends, &early, &reached_s);
    return status;
  }

  template <class Value>
  static Status by(const Access<Value>& access, void* instance, const UnitVariable& v,
                   std::span<double> values, bool writes) {
    return with_copy<Value>(values, writes, [&](Value* copy) {
      return writes ? access.set(instance, &v.reference, 1, copy, values.size())
                    : access.get(instance, &v.reference, 1, copy, values.size());
    });
  }

  Status access(void* instance, const UnitVariable& v, std::span<double> values,
                bool writes) const {
    switch (v.type) {
      case ValueType::float64:
        return by(float64, instance, v, values, writes);
      case ValueType::float32:
        return by(float32, instance, v, values, writes);
      case ValueType::int8:
        return by(int8, instance, v, values, writes);
      case ValueType::uint8:
        return by(uint8, instance, v, values, writes);
      case ValueType::int16:
        return by(int16, instance, v, values, writes);
      case ValueType::uint16:
        return by(uint16, instance, v, values, writes);
      case ValueType::int32:
        return by(int32, instance, v, values, writes);
      case ValueType::uint32:
        return by(uint32, instance, v, values, writes);
      case ValueType::int64:
        return by(int64, instance, v, values, writes);
      case ValueType::uint64:
        return by(uint64, instance, v, values, writes);
      default:
        return by(boolean, instance, v, values, writes);
    }
  }

  Status write_text(void* instance, const UnitVariable& v, const char* text) const {
    return string.set(instance, &v.reference, 1, &text, 1);
  }
  Status read_text(void* instance, const UnitVariable& v, const char*& text) const {
    return string.get(instance, &v.reference, 1, &text, 1);
  }
};

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
  std::variant<Fmi2, Fmi3> functions;
  std::optional<Library> library;
  void* instance = nullptr;
  std::string resources;
  bool is_ready = false, is_broken = false;

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
    const auto with = [&](const auto& of_version) {
      if (is_ready && !is_broken) of_version.terminate(instance);
      of_version.release(instance);
    };
    if (const auto* const two = std::get_if<Fmi2>(&functions)) with(*two);
    if (const auto* const three = std::get_if<Fmi3>(&functions)) with(*three);
    instance = nullptr;
    is_ready = false;
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
           std::function<void(const std::string&)> log)
    : loaded_(std::make_unique<Loaded>()) {
  Loaded& unit = *loaded_;
  unit.path = files.path();
  unit.description = std::move(description);
  unit.log.take = std::move(log);
  const bool is_2 = unit.description.version == 2;
  if (unit.description.needs_its_tool)
    unit.refuse("needs the tool that made it (needsExecutionTool); export it self-contained");
  const std::string binary =
      fmt::format("{}/binaries/{}/{}.so", files.folder(), is_2 ? "linux64" : "x86_64-linux",
                  unit.description.identifier);
  if (!std::filesystem::is_regular_file(binary))
    unit.refuse(
        fmt::format("no binary for Linux on x86-64: {}.so is missing in binaries/{}; "
                    "export it for this platform",
                    unit.description.identifier, is_2 ? "linux64" : "x86_64-linux"));
  unit.library.emplace(binary, unit.path);
  if (is_2)
    unit.functions.emplace<Fmi2>();
  else
    unit.functions.emplace<Fmi3>();
  std::visit([&](auto& functions) { functions.find_in(*unit.library); }, unit.functions);
  unit.library->want_all();
  std::filesystem::create_directories(files.folder() + "/resources");
  unit.resources = files.folder() + (is_2 ? "/resources" : "/resources/");
  unit.make();
}

Unit::~Unit() { loaded_->free(); }

void Unit::restart() {
  loaded_->free();
  loaded_->make();
}

const UnitDescription& Unit::description() const { return loaded_->description; }

void Unit::set(const UnitVariable& variable, std::span<const double> values) {
  Loaded& unit = *loaded_;
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
  if (variable.type != ValueType::string || variable.size != 1)
    unit.refuse(variable.name + " is no text");
  const Status status = std::visit(
      [&](auto& functions) { return functions.write_text(unit.instance, variable, text.c_str()); },
      unit.functions);
  unit.want(status, "setting " + variable.name);
}

std::string Unit::get_text(const UnitVariable& variable) {
  Loaded& unit = *loaded_;
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
  const Status status = std::visit(
      [&](auto& functions) { return functions.initialise(unit.instance, start_s, stop_s); },
      unit.functions);
  unit.want(status, "initialisation");
  unit.is_ready = true;
}

bool Unit::step(double time_s, double step_s) {
  Loaded& unit = *loaded_;
  bool ends = false;
  const Status status = std::visit(
      [&](auto& functions) { return functions.step(unit.instance, time_s, step_s, ends); },
      unit.functions);
  unit.want(status, fmt::format("the step of {} s at {} s", step_s, time_s));
  return !ends;
}

}  // namespace sim
