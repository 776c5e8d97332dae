// The models behind the functions of FMI 2.0.
#include <cstddef>

#include "models.h"

namespace {
using units::Model;
using Logger = void (*)(void*, const char*, int, const char*, const char*, ...);
struct Callbacks {
  Logger logger;
  void *allocate, *release, *step_finished, *environment;
};
struct Instance {
  Model model;
  Logger log;
  void* environment;
};
Instance& of(void* instance) { return *static_cast<Instance*>(instance); }

template <class Value>
int get(void* instance, const unsigned* references, std::size_t count, Value* values) {
  for (std::size_t i = 0; i < count; ++i) {
    double value = 0.0;
    if (!of(instance).model.get(references[i], value)) return 3;
    values[i] = static_cast<Value>(value);
  }
  return 0;
}
template <class Value>
int set(void* instance, const unsigned* references, std::size_t count, const Value* values) {
  for (std::size_t i = 0; i < count; ++i)
    if (!of(instance).model.set(references[i], static_cast<double>(values[i]))) {
      of(instance).log(of(instance).environment, "unit", 3, "error", "no value %u is set here",
                       references[i]);
      return 3;
    }
  return 0;
}
}  // namespace

extern "C" {
void* fmi2Instantiate(const char*, int, const char* guid, const char*, const Callbacks* callbacks,
                      int, int) {
  auto* const made = new Instance{{}, callbacks->logger, callbacks->environment};
  made->model.kind = guid;
  if (made->model.is_known()) return made;
  made->log(made->environment, "unit", 3, "error", "'%s' is not my guid", guid);
  delete made;
  return nullptr;
}
void fmi2FreeInstance(void* instance) { delete static_cast<Instance*>(instance); }
int fmi2SetupExperiment(void* instance, int has_tolerance, double tolerance, double start_s, int,
                        double) {
  of(instance).model.tolerance = has_tolerance != 0 ? tolerance : -1.0;
  of(instance).model.time_s = start_s;
  return 0;
}
int fmi2EnterInitializationMode(void*) { return 0; }
int fmi2ExitInitializationMode(void* instance) {
  of(instance).model.text_out = of(instance).model.text_in;
  return 0;
}
int fmi2DoStep(void* instance, double time_s, double step_s, int) {
  bool ends = false;
  return of(instance).model.step(time_s, step_s, ends);
}
int fmi2Terminate(void*) { return 0; }
int fmi2Reset(void* instance) {
  of(instance).model = Model{of(instance).model.kind, {}, {}};
  return 0;
}
int fmi2GetFMUstate(void* instance, void** state) {
  if (*state == nullptr) *state = new Model;
  *static_cast<Model*>(*state) = of(instance).model;
  return 0;
}
int fmi2SetFMUstate(void* instance, void* state) {
  of(instance).model = *static_cast<Model*>(state);
  return 0;
}
int fmi2FreeFMUstate(void*, void** state) {
  delete static_cast<Model*>(*state);
  *state = nullptr;
  return 0;
}
int fmi2GetReal(void* i, const unsigned* r, std::size_t n, double* v) { return get(i, r, n, v); }
int fmi2SetReal(void* i, const unsigned* r, std::size_t n, const double* v) {
  return set(i, r, n, v);
}
int fmi2GetInteger(void* i, const unsigned* r, std::size_t n, int* v) { return get(i, r, n, v); }
int fmi2SetInteger(void* i, const unsigned* r, std::size_t n, const int* v) {
  return set(i, r, n, v);
}
int fmi2GetBoolean(void* i, const unsigned* r, std::size_t n, int* v) { return get(i, r, n, v); }
int fmi2SetBoolean(void* i, const unsigned* r, std::size_t n, const int* v) {
  return set(i, r, n, v);
}
int fmi2GetString(void* i, const unsigned*, std::size_t, const char** v) {
  *v = of(i).model.text_out.c_str();
  return 0;
}
int fmi2SetString(void* i, const unsigned*, std::size_t, const char* const* v) {
  of(i).model.text_in = *v;
  return 0;
}
}
