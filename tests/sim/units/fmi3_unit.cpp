// The models behind the functions of FMI 3.0.
#include <cstddef>
#include <cstdint>

#include "models.h"

namespace {
using units::Model;
using Log = void (*)(void*, int, const char*, const char*);
struct Instance {
  Model model;
  Log log;
  void* environment;
};
Instance& of(void* instance) { return *static_cast<Instance*>(instance); }

/// An array's values have the references from its own on.
template <class Value>
int get(void* instance, const std::uint32_t* references, std::size_t, Value* values,
        std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    double value = 0.0;
    if (!of(instance).model.get(*references + static_cast<unsigned>(i), value)) return 3;
    values[i] = static_cast<Value>(value);
  }
  return 0;
}
template <class Value>
int set(void* instance, const std::uint32_t* references, std::size_t, const Value* values,
        std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (!of(instance).model.set(*references + static_cast<unsigned>(i),
                                static_cast<double>(values[i]))) {
      of(instance).log(of(instance).environment, 3, "error", "no such value is set here");
      return 3;
    }
  return 0;
}
}  // namespace

// NOLINTNEXTLINE(bugprone-macro-parentheses): a type
#define ACCESS(NAME, TYPE)                                                                    \
  int fmi3Get##NAME(void* i, const std::uint32_t* r, std::size_t n, TYPE* v, std::size_t m) { \
    return get(i, r, n, v, m);                                                                \
  }                                                                                           \
  int fmi3Set##NAME(void* i, const std::uint32_t* r, std::size_t n, const TYPE* v,            \
                    std::size_t m) {                                                          \
    return set(i, r, n, v, m);                                                                \
  }

extern "C" {
void* fmi3InstantiateCoSimulation(const char*, const char* token, const char*, bool, bool, bool,
                                  bool, const std::uint32_t*, std::size_t, void* environment,
                                  Log log, void*) {
  auto* const made = new Instance{{}, log, environment};
  made->model.kind = token;
  if (made->model.is_known()) return made;
  log(environment, 3, "error", "this is not my token");
  delete made;
  return nullptr;
}
void fmi3FreeInstance(void* instance) { delete static_cast<Instance*>(instance); }
int fmi3EnterInitializationMode(void* instance, bool has_tolerance, double tolerance,
                                double start_s, bool, double) {
  of(instance).model.tolerance = has_tolerance ? tolerance : -1.0;
  of(instance).model.time_s = start_s;
  return 0;
}
int fmi3ExitInitializationMode(void* instance) {
  of(instance).model.text_out = of(instance).model.text_in;
  return 0;
}
int fmi3DoStep(void* instance, double time_s, double step_s, bool, bool* event, bool* ends,
               bool* early, double* reached_s) {
  *event = *early = *ends = false;
  *reached_s = time_s + step_s;
  return of(instance).model.step(time_s, step_s, *ends);
}
int fmi3Terminate(void*) { return 0; }
int fmi3Reset(void* instance) {
  of(instance).model = Model{of(instance).model.kind, {}, {}};
  return 0;
}
int fmi3GetFMUState(void* instance, void** state) {
  if (*state == nullptr) *state = new Model;
  *static_cast<Model*>(*state) = of(instance).model;
  return 0;
}
int fmi3SetFMUState(void* instance, void* state) {
  of(instance).model = *static_cast<Model*>(state);
  return 0;
}
int fmi3FreeFMUState(void*, void** state) {
  delete static_cast<Model*>(*state);
  *state = nullptr;
  return 0;
}
ACCESS(Float64, double)
ACCESS(Float32, float)
ACCESS(Int8, std::int8_t)
ACCESS(UInt8, std::uint8_t)
ACCESS(Int16, std::int16_t)
ACCESS(UInt16, std::uint16_t)
ACCESS(Int32, std::int32_t)
ACCESS(UInt32, std::uint32_t)
ACCESS(Int64, std::int64_t)
ACCESS(UInt64, std::uint64_t)
ACCESS(Boolean, bool)
int fmi3GetString(void* i, const std::uint32_t*, std::size_t, const char** v, std::size_t) {
  *v = of(i).model.text_out.c_str();
  return 0;
}
int fmi3SetString(void* i, const std::uint32_t*, std::size_t, const char* const* v, std::size_t) {
  of(i).model.text_in = *v;
  return 0;
}
}
