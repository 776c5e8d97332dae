// The functions of a unit of FMI 2.0.
#pragma once

#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <span>
#include <string>

#include "sim/unit_description.h"
#include "unit_library.h"

namespace sim {

// Callbacks of FMI 2.0; section 2.1.5 of the standard.
struct Callbacks2 {
  void (*logger)(void*, const char*, Status, const char*, const char*, ...);
  void* (*allocate)(std::size_t, std::size_t);
  void (*release)(void*);
  void (*step_finished)(void*, Status);
  void* environment;
};

inline void log_2(void* environment, const char*, Status status, const char*, const char* format,
                  ...) {
  if (environment == nullptr || format == nullptr) return;
  std::array<char, 2000> text{};
  va_list arguments;
  va_start(arguments, format);
  // NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): va_start is the line before
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  if (status != 0) static_cast<Log*>(environment)->add(text.data());
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
  Status (*reset)(void*);
  Status (*get_state)(void*, void**);
  Status (*set_state)(void*, void*);
  Status (*free_state)(void*, void**);
  Access<double> get_real;
  Access<const double> set_real;
  Access<int> get_integer, get_boolean;
  Access<const int> set_integer, set_boolean;
  Access<const char*> get_string;
  Access<const char* const> set_string;
  Callbacks2 callbacks{};

  void find_in(Library& library, bool keeps_states) {
    library.find(instantiate, "fmi2Instantiate");
    library.find(release, "fmi2FreeInstance");
    library.find(setup, "fmi2SetupExperiment");
    library.find(enter, "fmi2EnterInitializationMode");
    library.find(exit, "fmi2ExitInitializationMode");
    library.find(do_step, "fmi2DoStep");
    library.find(terminate, "fmi2Terminate");
    if (keeps_states) {
      library.find(reset, "fmi2Reset");
      library.find(get_state, "fmi2GetFMUstate");
      library.find(set_state, "fmi2SetFMUstate");
      library.find(free_state, "fmi2FreeFMUstate");
    }
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

  Status initialise(void* instance, double start_s, const std::optional<double>& stop_s,
                    const std::optional<double>& tolerance) const {
    Status worst = setup(instance, tolerance ? 1 : 0, tolerance.value_or(0.0), start_s,
                         stop_s ? 1 : 0, stop_s.value_or(0.0));
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

}  // namespace sim
