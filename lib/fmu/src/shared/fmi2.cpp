// The functions of FMI 2.0 for co-simulation.
#include <algorithm>
#include <vector>

#include "component.h"
#include "fmi2_types.h"
#include "fmu/resource_path.h"

#define FMU_EXPORT extern "C" __attribute__((visibility("default")))

namespace {

using fmu::Component, fmu::guarded, fmu::Status, fmu::Type, fmu::want;

fmi2Status code(Status status) { return static_cast<fmi2Status>(status); }

/// The message is a format for the importer's printf.
std::string as_format(const std::string& text) {
  std::string out;
  for (const char c : text) {
    out += c;
    if (c == '%') out += '%';
  }
  return out;
}

/// Reads or writes values one by one, as far as they go.
template <class Value, class Each>
fmi2Status each_value(fmi2Component component, const fmi2ValueReference* references,
                      std::size_t count, Value* values, const Each& each) {
  return code(guarded(component, [&](Component& c) {
    want(count == 0 || (references != nullptr && values != nullptr), "no values were given");
    Status worst = Status::kOk;
    for (std::size_t i = 0; i < count; ++i)
      worst = std::max(worst, each(c, references[i], values[i]));
    return worst;
  }));
}

template <class Value>
fmi2Status get_numbers(fmi2Component component, const fmi2ValueReference* references,
                       std::size_t count, Value* values, Type type) {
  return each_value(component, references, count, values,
                    [&](Component& c, fmi2ValueReference reference, Value& value) {
                      value = static_cast<Value>(c.instance->number(reference, type));
                      return Status::kOk;
                    });
}

template <class Value>
fmi2Status set_numbers(fmi2Component component, const fmi2ValueReference* references,
                       std::size_t count, const Value* values, Type type) {
  return each_value(component, references, count, values,
                    [&](Component& c, fmi2ValueReference reference, const Value& value) {
                      return told(
                          c, c.instance->set_number(reference, type, static_cast<double>(value)));
                    });
}

fmi2Status not_provided(fmi2Component component, const char* what) {
  return code(guarded(component, [&](Component&) -> Status {
    throw base::Error(std::string(what) +
                      ": this unit does not provide it, as its model "
                      "description says");
  }));
}

}  // namespace

FMU_EXPORT const char* fmi2GetTypesPlatform() { return "default"; }
FMU_EXPORT const char* fmi2GetVersion() { return "2.0"; }

FMU_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean, std::size_t,
                                          const fmi2String*) {
  // Errors and warnings are always told; there is nothing else.
  return code(guarded(component, [](Component&) { return Status::kOk; }));
}

FMU_EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                                         fmi2String resources,
                                         const fmi2CallbackFunctions* functions, fmi2Boolean,
                                         fmi2Boolean) {
  fmu::Log log = [](Status, const std::string&) {};
  try {
    if (functions != nullptr && functions->logger != nullptr)
      log = [logger = functions->logger, environment = functions->environment,
             own = std::string(name == nullptr ? "" : name)](Status status,
                                                             const std::string& text) {
        logger(environment, own.c_str(), code(status),
               status == Status::kError ? "logStatusError" : "logStatusWarning",
               as_format(text).c_str());
      };
    want(type == 1, "this unit is for co-simulation only");
    want(guid != nullptr && resources != nullptr, "no guid or no place of the resources was given");
    return fmu::make_component(fmu::resource_path(resources), guid, log);
  } catch (const std::exception& error) {
    log(Status::kError, error.what());
  } catch (...) {
  }
  return nullptr;
}

FMU_EXPORT void fmi2FreeInstance(fmi2Component component) {
  guarded(component, [](Component& c) {
    close_run(c);
    return Status::kOk;
  });
  delete static_cast<Component*>(component);
}

FMU_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean, fmi2Real,
                                          fmi2Real begin_s, fmi2Boolean, fmi2Real) {
  return code(guarded(component, [&](Component& c) {
    c.begin_s = begin_s;
    return Status::kOk;
  }));
}

FMU_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component component) {
  return code(guarded(component, [](Component& c) {
    c.instance->enter_initialisation(c.begin_s);
    return Status::kOk;
  }));
}

FMU_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component component) {
  return code(guarded(component, [](Component& c) {
    c.instance->leave_initialisation();
    return Status::kOk;
  }));
}

FMU_EXPORT fmi2Status fmi2Terminate(fmi2Component component) {
  return code(guarded(component, [](Component& c) {
    c.instance->terminate();
    close_run(c);
    return Status::kOk;
  }));
}

FMU_EXPORT fmi2Status fmi2Reset(fmi2Component component) {
  return code(guarded(component, [](Component& c) {
    close_run(c);
    c.instance->reset();
    c.begin_s = 0.0;
    return Status::kOk;
  }));
}

FMU_EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference* references,
                                  std::size_t count, fmi2Real* values) {
  return get_numbers(c, references, count, values, Type::kReal);
}
FMU_EXPORT fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference* references,
                                     std::size_t count, fmi2Integer* values) {
  return get_numbers(c, references, count, values, Type::kInteger);
}
FMU_EXPORT fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference* references,
                                     std::size_t count, fmi2Boolean* values) {
  return get_numbers(c, references, count, values, Type::kBoolean);
}
FMU_EXPORT fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference* references,
                                    std::size_t count, fmi2String* values) {
  return each_value(component, references, count, values,
                    [](Component& c, fmi2ValueReference reference, fmi2String& value) {
                      value = c.instance->text(reference).c_str();
                      return Status::kOk;
                    });
}
FMU_EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference* references,
                                  std::size_t count, const fmi2Real* values) {
  return set_numbers(c, references, count, values, Type::kReal);
}
FMU_EXPORT fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference* references,
                                     std::size_t count, const fmi2Integer* values) {
  return set_numbers(c, references, count, values, Type::kInteger);
}
FMU_EXPORT fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference* references,
                                     std::size_t count, const fmi2Boolean* values) {
  return set_numbers(c, references, count, values, Type::kBoolean);
}
FMU_EXPORT fmi2Status fmi2SetString(fmi2Component component, const fmi2ValueReference* references,
                                    std::size_t count, const fmi2String* values) {
  return each_value(component, references, count, values,
                    [](Component& c, fmi2ValueReference reference, const fmi2String& value) {
                      want(value != nullptr, "no text was given");
                      c.instance->set_text(reference, value);
                      return Status::kOk;
                    });
}

FMU_EXPORT fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate* state) {
  return code(guarded(component, [&](Component& c) { return keep_state(c, state); }));
}
FMU_EXPORT fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state) {
  return code(guarded(component, [&](Component& c) {
    c.instance->restore(kept_state(c, state));
    return Status::kOk;
  }));
}
FMU_EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate* state) {
  return code(guarded(component, [&](Component& c) { return free_state(c, state); }));
}
FMU_EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state,
                                                 std::size_t* size) {
  return code(guarded(component, [&](Component& c) { return state_size(c, state, size); }));
}
FMU_EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state,
                                            fmi2Byte* bytes, std::size_t size) {
  return code(guarded(component, [&](Component& c) { return write_state(c, state, bytes, size); }));
}
FMU_EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte* bytes,
                                              std::size_t size, fmi2FMUstate* state) {
  return code(guarded(component, [&](Component& c) { return read_state(c, bytes, size, state); }));
}

FMU_EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component component,
                                                   const fmi2ValueReference* unknowns,
                                                   std::size_t unknown_count,
                                                   const fmi2ValueReference* knowns,
                                                   std::size_t known_count, const fmi2Real* seed,
                                                   fmi2Real* sensitivity) {
  return code(guarded(component, [&](Component& c) {
    want((unknown_count == 0 || (unknowns != nullptr && sensitivity != nullptr)) &&
             (known_count == 0 || (knowns != nullptr && seed != nullptr)),
         "no variables or no values were given");
    const std::vector<double> out = c.instance->derivatives(
        {unknowns, unknown_count}, {knowns, known_count}, {seed, known_count});
    std::copy(out.begin(), out.end(), sensitivity);
    return Status::kOk;
  }));
}
FMU_EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference*,
                                                  std::size_t, const fmi2Integer*,
                                                  const fmi2Real*) {
  return not_provided(c, "derivatives of inputs");
}
FMU_EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference*,
                                                   std::size_t, const fmi2Integer*, fmi2Real*) {
  return not_provided(c, "derivatives of outputs");
}

FMU_EXPORT fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time_s, fmi2Real step_s,
                                 fmi2Boolean) {
  return code(guarded(component, [&](Component& c) {
    c.instance->step(time_s, step_s);
    return Status::kOk;
  }));
}
FMU_EXPORT fmi2Status fmi2CancelStep(fmi2Component c) {
  return not_provided(c, "a step that runs on its own");
}

FMU_EXPORT fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind, fmi2Status*) {
  return not_provided(c, "the status of a step that runs on its own");
}
FMU_EXPORT fmi2Status fmi2GetRealStatus(fmi2Component component, fmi2StatusKind kind,
                                        fmi2Real* value) {
  constexpr fmi2StatusKind kLastSuccessfulTime = 2;
  if (kind != kLastSuccessfulTime) return not_provided(component, "this status");
  return code(guarded(component, [&](Component& c) {
    want(value != nullptr, "no place for the time was given");
    *value = c.instance->time_s();
    return Status::kOk;
  }));
}
FMU_EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind, fmi2Integer*) {
  return not_provided(c, "this status");
}
FMU_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component component, fmi2StatusKind kind,
                                           fmi2Boolean* value) {
  constexpr fmi2StatusKind kTerminated = 3;
  if (kind != kTerminated) return not_provided(component, "this status");
  return code(guarded(component, [&](Component& c) {
    want(value != nullptr, "no place for the answer was given");
    *value = c.instance->phase() == fmu::Phase::kTerminated ? 1 : 0;
    return Status::kOk;
  }));
}
FMU_EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind, fmi2String*) {
  return not_provided(c, "this status");
}
