// The functions of a unit of FMI 3.0.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "sim/unit_description.h"
#include "unit_library.h"

namespace sim {

inline void log_3(void* environment, Status status, const char*, const char* text) {
  if (environment != nullptr && status != 0) static_cast<Log*>(environment)->add(text);
}

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
  Status (*reset)(void*);
  Status (*get_state)(void*, void**);
  Status (*set_state)(void*, void*);
  Status (*free_state)(void*, void**);
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

  void find_in(Library& library, bool keeps_states) {
    library.find(instantiate, "fmi3InstantiateCoSimulation");
    library.find(release, "fmi3FreeInstance");
    library.find(enter, "fmi3EnterInitializationMode");
    library.find(exit, "fmi3ExitInitializationMode");
    library.find(do_step, "fmi3DoStep");
    library.find(terminate, "fmi3Terminate");
    if (keeps_states) {
      library.find(reset, "fmi3Reset");
      library.find(get_state, "fmi3GetFMUState");
      library.find(set_state, "fmi3SetFMUState");
      library.find(free_state, "fmi3FreeFMUState");
    }
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

  Status initialise(void* instance, double start_s, const std::optional<double>& stop_s,
                    const std::optional<double>& tolerance) const {
    const Status entered = enter(instance, tolerance.has_value(), tolerance.value_or(0.0), start_s,
                                 stop_s.has_value(), stop_s.value_or(0.0));
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

}  // namespace sim
