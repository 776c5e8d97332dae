// The functions of FMI 3.0: those of co-simulation, and the others of the standard, which an
// importer may look for, as errors.
#include <algorithm>
#include <vector>

#include "component.h"
#include "fmi3_types.h"
#include "fmu/resource_path.h"

#define FMU_EXPORT extern "C" __attribute__((visibility("default")))

namespace {

using fmu::Component, fmu::guarded, fmu::Status, fmu::Type, fmu::Variable, fmu::want;
using References = const fmi3ValueReference*;

fmi3Status code(Status status) { return static_cast<fmi3Status>(status); }

/// Goes through the values of the variables, arrays by their one reference, as far as they go.
template <class Value, class Each>
fmi3Status each_value(fmi3Instance component, References references, std::size_t count,
                      Value* values, std::size_t value_count, const Each& each) {
  return code(guarded(component, [&](Component& c) {
    want(count == 0 || (references != nullptr && values != nullptr), "no values were given");
    Status worst = Status::kOk;
    std::size_t at = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const Variable& v = c.instance->variable(references[k]);
      want(v.reference == references[k], "a value reference within an array; wanted its own");
      want(at + v.size <= value_count, "fewer values than the variables have");
      for (std::size_t i = 0; i < v.size; ++i)
        worst = std::max(worst, each(c, static_cast<std::uint32_t>(v.reference + i), values[at++]));
    }
    want(at == value_count, "more values than the variables have");
    return worst;
  }));
}

/// Of each value of the variables, one after another.
std::vector<std::uint32_t> values_of(Component& c, References references, std::size_t count) {
  std::vector<std::uint32_t> out;
  for (std::size_t k = 0; k < count; ++k) {
    const Variable& v = c.instance->variable(references[k]);
    want(v.reference == references[k], "a value reference within an array; wanted its own");
    for (std::size_t i = 0; i < v.size; ++i)
      out.push_back(static_cast<std::uint32_t>(v.reference + i));
  }
  return out;
}

template <class Value>
fmi3Status get_numbers(fmi3Instance component, References references, std::size_t count,
                       Value* values, std::size_t value_count, Type type) {
  return each_value(component, references, count, values, value_count,
                    [&](Component& c, std::uint32_t reference, Value& value) {
                      value = static_cast<Value>(c.instance->number(reference, type));
                      return Status::kOk;
                    });
}

template <class Value>
fmi3Status set_numbers(fmi3Instance component, References references, std::size_t count,
                       const Value* values, std::size_t value_count, Type type) {
  return each_value(component, references, count, values, value_count,
                    [&](Component& c, std::uint32_t reference, const Value& value) {
                      return told(
                          c, c.instance->set_number(reference, type, static_cast<double>(value)));
                    });
}

fmi3Status not_provided(fmi3Instance component, const char* function) {
  return code(guarded(component, [&](Component&) -> Status {
    throw base::Error(std::string(function) +
                      ": this unit does not provide it, as its model description says");
  }));
}

}  // namespace

FMU_EXPORT const char* fmi3GetVersion() { return "3.0"; }

FMU_EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance component, fmi3Boolean, std::size_t,
                                          const fmi3String*) {
  // Errors and warnings are always told; there is nothing else.
  return code(guarded(component, [](Component&) { return Status::kOk; }));
}

FMU_EXPORT fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String, fmi3String token, fmi3String resources, fmi3Boolean, fmi3Boolean, fmi3Boolean,
    fmi3Boolean, References, std::size_t intermediate, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback logger, fmi3IntermediateUpdateCallback) {
  fmu::Log log = [](Status, const std::string&) {};
  try {
    if (logger != nullptr)
      log = [logger, environment](Status status, const std::string& text) {
        logger(environment, code(status),
               status == Status::kError ? "logStatusError" : "logStatusWarning", text.c_str());
      };
    want(intermediate == 0, "this unit has no intermediate values");
    want(token != nullptr && resources != nullptr,
         "no token or no place of the resources was given");
    return fmu::make_component(fmu::resource_path(resources), token, log);
  } catch (const std::exception& error) {
    log(Status::kError, error.what());
  } catch (...) {
  }
  return nullptr;
}

FMU_EXPORT fmi3Instance fmi3InstantiateModelExchange(fmi3String, fmi3String, fmi3String,
                                                     fmi3Boolean, fmi3Boolean,
                                                     fmi3InstanceEnvironment environment,
                                                     fmi3LogMessageCallback logger) {
  if (logger != nullptr)
    logger(environment, code(Status::kError), "logStatusError",
           "this unit is for co-simulation only");
  return nullptr;
}
FMU_EXPORT fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger, fmi3ClockUpdateCallback,
    fmi3PreemptionCallback, fmi3PreemptionCallback) {
  return fmi3InstantiateModelExchange(nullptr, nullptr, nullptr, false, false, environment, logger);
}

FMU_EXPORT void fmi3FreeInstance(fmi3Instance component) {
  guarded(component, [](Component& c) {
    close_run(c);
    return Status::kOk;
  });
  delete static_cast<Component*>(component);
}

FMU_EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance component, fmi3Boolean, fmi3Float64,
                                                  fmi3Float64 begin_s, fmi3Boolean, fmi3Float64) {
  return code(guarded(component, [&](Component& c) {
    c.instance->enter_initialisation(begin_s);
    return Status::kOk;
  }));
}
FMU_EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance component) {
  return code(guarded(component, [](Component& c) {
    c.instance->leave_initialisation();
    return Status::kOk;
  }));
}
FMU_EXPORT fmi3Status fmi3Terminate(fmi3Instance component) {
  return code(guarded(component, [](Component& c) {
    c.instance->terminate();
    close_run(c);
    return Status::kOk;
  }));
}
FMU_EXPORT fmi3Status fmi3Reset(fmi3Instance component) {
  return code(guarded(component, [](Component& c) {
    close_run(c);
    c.instance->reset();
    return Status::kOk;
  }));
}

FMU_EXPORT fmi3Status fmi3GetFloat64(fmi3Instance c, References references, std::size_t count,
                                     fmi3Float64* values, std::size_t value_count) {
  return get_numbers(c, references, count, values, value_count, Type::kReal);
}
FMU_EXPORT fmi3Status fmi3GetInt32(fmi3Instance c, References references, std::size_t count,
                                   std::int32_t* values, std::size_t value_count) {
  return get_numbers(c, references, count, values, value_count, Type::kInteger);
}
FMU_EXPORT fmi3Status fmi3GetBoolean(fmi3Instance c, References references, std::size_t count,
                                     fmi3Boolean* values, std::size_t value_count) {
  return get_numbers(c, references, count, values, value_count, Type::kBoolean);
}
FMU_EXPORT fmi3Status fmi3GetString(fmi3Instance component, References references,
                                    std::size_t count, fmi3String* values,
                                    std::size_t value_count) {
  return each_value(component, references, count, values, value_count,
                    [](Component& c, std::uint32_t reference, fmi3String& value) {
                      value = c.instance->text(reference).c_str();
                      return Status::kOk;
                    });
}
FMU_EXPORT fmi3Status fmi3SetFloat64(fmi3Instance c, References references, std::size_t count,
                                     const fmi3Float64* values, std::size_t value_count) {
  return set_numbers(c, references, count, values, value_count, Type::kReal);
}
FMU_EXPORT fmi3Status fmi3SetInt32(fmi3Instance c, References references, std::size_t count,
                                   const std::int32_t* values, std::size_t value_count) {
  return set_numbers(c, references, count, values, value_count, Type::kInteger);
}
FMU_EXPORT fmi3Status fmi3SetBoolean(fmi3Instance c, References references, std::size_t count,
                                     const fmi3Boolean* values, std::size_t value_count) {
  return set_numbers(c, references, count, values, value_count, Type::kBoolean);
}
FMU_EXPORT fmi3Status fmi3SetString(fmi3Instance component, References references,
                                    std::size_t count, const fmi3String* values,
                                    std::size_t value_count) {
  return each_value(component, references, count, values, value_count,
                    [](Component& c, std::uint32_t reference, const fmi3String& value) {
                      want(value != nullptr, "no text was given");
                      c.instance->set_text(reference, value);
                      return Status::kOk;
                    });
}

FMU_EXPORT fmi3Status fmi3GetFMUState(fmi3Instance component, fmi3FMUState* state) {
  return code(guarded(component, [&](Component& c) { return keep_state(c, state); }));
}
FMU_EXPORT fmi3Status fmi3SetFMUState(fmi3Instance component, fmi3FMUState state) {
  return code(guarded(component, [&](Component& c) {
    c.instance->restore(kept_state(c, state));
    return Status::kOk;
  }));
}
FMU_EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance component, fmi3FMUState* state) {
  return code(guarded(component, [&](Component& c) { return free_state(c, state); }));
}
FMU_EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance component, fmi3FMUState state,
                                                 std::size_t* size) {
  return code(guarded(component, [&](Component& c) { return state_size(c, state, size); }));
}
FMU_EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance component, fmi3FMUState state,
                                            fmi3Byte* bytes, std::size_t size) {
  return code(guarded(component, [&](Component& c) {
    return write_state(c, state, reinterpret_cast<char*>(bytes), size);
  }));
}
FMU_EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance component, const fmi3Byte* bytes,
                                              std::size_t size, fmi3FMUState* state) {
  return code(guarded(component, [&](Component& c) {
    return read_state(c, reinterpret_cast<const char*>(bytes), size, state);
  }));
}

FMU_EXPORT fmi3Status fmi3EnterStepMode(fmi3Instance component) {
  // The unit has no event mode, so it is in step mode already.
  return code(guarded(component, [](Component& c) {
    want(c.instance->phase() == fmu::Phase::kStepping, "the unit is not initialised");
    return Status::kOk;
  }));
}
FMU_EXPORT fmi3Status fmi3DoStep(fmi3Instance component, fmi3Float64 time_s, fmi3Float64 step_s,
                                 fmi3Boolean, fmi3Boolean* event, fmi3Boolean* terminate,
                                 fmi3Boolean* early, fmi3Float64* reached_s) {
  return code(guarded(component, [&](Component& c) {
    for (fmi3Boolean* const answer : {event, terminate, early})
      if (answer != nullptr) *answer = false;
    if (reached_s != nullptr) *reached_s = c.instance->time_s();
    c.instance->step(time_s, step_s);
    if (reached_s != nullptr) *reached_s = c.instance->time_s();
    return Status::kOk;
  }));
}

FMU_EXPORT fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance component,
                                                          fmi3ValueReference reference,
                                                          std::size_t* count) {
  return code(guarded(component, [&](Component& c) {
    (void)c.instance->variable(reference);
    want(count != nullptr, "no place for the count was given");
    *count = 0;  // what is set acts in the next step
    return Status::kOk;
  }));
}
FMU_EXPORT fmi3Status fmi3GetVariableDependencies(fmi3Instance component,
                                                  fmi3ValueReference reference, std::size_t*,
                                                  fmi3ValueReference*, std::size_t*,
                                                  fmi3DependencyKind*, std::size_t) {
  return code(guarded(component, [&](Component& c) {
    (void)c.instance->variable(reference);
    return Status::kOk;
  }));
}

FMU_EXPORT fmi3Status fmi3GetDirectionalDerivative(fmi3Instance component, References unknowns,
                                                   std::size_t unknown_count, References knowns,
                                                   std::size_t known_count, const fmi3Float64* seed,
                                                   std::size_t seed_count, fmi3Float64* sensitivity,
                                                   std::size_t sensitivity_count) {
  return code(guarded(component, [&](Component& c) {
    want((unknown_count == 0 || (unknowns != nullptr && sensitivity != nullptr)) &&
             (known_count == 0 || (knowns != nullptr && seed != nullptr)),
         "no variables or no values were given");
    const auto unknown_values = values_of(c, unknowns, unknown_count),
               known_values = values_of(c, knowns, known_count);
    want(unknown_values.size() == sensitivity_count && known_values.size() == seed_count,
         "another number of values than the variables have");
    const std::vector<double> out =
        c.instance->derivatives(unknown_values, known_values, {seed, seed_count});
    std::copy(out.begin(), out.end(), sensitivity);
    return Status::kOk;
  }));
}

// What this unit has none of. Parameters are those of the standard, in its order.
#define FMU_NONE(name, ...)                                               \
  FMU_EXPORT fmi3Status name(fmi3Instance c __VA_OPT__(, ) __VA_ARGS__) { \
    return not_provided(c, #name);                                        \
  }
#define FMU_NONE_OF_TYPE(kind, type)                                   \
  FMU_NONE(fmi3Get##kind, References, std::size_t, type*, std::size_t) \
  FMU_NONE(fmi3Set##kind, References, std::size_t, const type*, std::size_t)

FMU_NONE_OF_TYPE(Float32, fmi3Float32)
FMU_NONE_OF_TYPE(Int8, std::int8_t)
FMU_NONE_OF_TYPE(UInt8, std::uint8_t)
FMU_NONE_OF_TYPE(Int16, std::int16_t)
FMU_NONE_OF_TYPE(UInt16, std::uint16_t)
FMU_NONE_OF_TYPE(UInt32, std::uint32_t)
FMU_NONE_OF_TYPE(Int64, std::int64_t)
FMU_NONE_OF_TYPE(UInt64, std::uint64_t)
FMU_NONE(fmi3GetBinary, References, std::size_t, std::size_t*, fmi3Binary*, std::size_t)
FMU_NONE(fmi3SetBinary, References, std::size_t, const std::size_t*, const fmi3Binary*, std::size_t)
FMU_NONE(fmi3GetClock, References, std::size_t, fmi3Clock*)
FMU_NONE(fmi3SetClock, References, std::size_t, const fmi3Clock*)
FMU_NONE(fmi3GetAdjointDerivative, References, std::size_t, References, std::size_t,
         const fmi3Float64*, std::size_t, fmi3Float64*, std::size_t)
FMU_NONE(fmi3GetOutputDerivatives, References, std::size_t, const std::int32_t*, fmi3Float64*,
         std::size_t)
FMU_NONE(fmi3EnterConfigurationMode)
FMU_NONE(fmi3ExitConfigurationMode)
FMU_NONE(fmi3EnterEventMode)
FMU_NONE(fmi3GetIntervalDecimal, References, std::size_t, fmi3Float64*, fmi3IntervalQualifier*)
FMU_NONE(fmi3GetIntervalFraction, References, std::size_t, std::uint64_t*, std::uint64_t*,
         fmi3IntervalQualifier*)
FMU_NONE(fmi3GetShiftDecimal, References, std::size_t, fmi3Float64*)
FMU_NONE(fmi3GetShiftFraction, References, std::size_t, std::uint64_t*, std::uint64_t*)
FMU_NONE(fmi3SetIntervalDecimal, References, std::size_t, const fmi3Float64*)
FMU_NONE(fmi3SetIntervalFraction, References, std::size_t, const std::uint64_t*,
         const std::uint64_t*)
FMU_NONE(fmi3SetShiftDecimal, References, std::size_t, const fmi3Float64*)
FMU_NONE(fmi3SetShiftFraction, References, std::size_t, const std::uint64_t*, const std::uint64_t*)
FMU_NONE(fmi3EvaluateDiscreteStates)
FMU_NONE(fmi3UpdateDiscreteStates, fmi3Boolean*, fmi3Boolean*, fmi3Boolean*, fmi3Boolean*,
         fmi3Boolean*, fmi3Float64*)
FMU_NONE(fmi3EnterContinuousTimeMode)
FMU_NONE(fmi3CompletedIntegratorStep, fmi3Boolean, fmi3Boolean*, fmi3Boolean*)
FMU_NONE(fmi3SetTime, fmi3Float64)
FMU_NONE(fmi3SetContinuousStates, const fmi3Float64*, std::size_t)
FMU_NONE(fmi3GetContinuousStateDerivatives, fmi3Float64*, std::size_t)
FMU_NONE(fmi3GetEventIndicators, fmi3Float64*, std::size_t)
FMU_NONE(fmi3GetContinuousStates, fmi3Float64*, std::size_t)
FMU_NONE(fmi3GetNominalsOfContinuousStates, fmi3Float64*, std::size_t)
FMU_NONE(fmi3GetNumberOfEventIndicators, std::size_t*)
FMU_NONE(fmi3GetNumberOfContinuousStates, std::size_t*)
FMU_NONE(fmi3ActivateModelPartition, fmi3ValueReference, fmi3Float64)
