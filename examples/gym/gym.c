// Many cars of one unit (crgdrive fmu, FMI 2.0) in one process, stepped together, put back to any
// state: what learning needs. A library for gym.py, which unpacks the unit and knows its names;
// it uses nothing of Kerbstone but the unit.
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GYM_API __attribute__((visibility("default")))

// Of FMI 2.0, as far as it is used here.
typedef int status;  // 0 is OK, 1 a warning
typedef struct {
  void (*logger)(void*, const char*, status, const char*, const char*, ...);
  void* (*allocate)(size_t, size_t);
  void (*release)(void*);
  void (*step_finished)(void*, status);
  void* environment;
} callbacks;

typedef struct {
  void* unit;
  double time_s;
} car;

typedef struct gym {
  void* library;
  void* (*instantiate)(const char*, int, const char*, const char*, const callbacks*, int, int);
  void (*release)(void*);
  status (*setup)(void*, int, double, double, int, double);
  status (*enter)(void*);
  status (*leave)(void*);
  status (*do_step)(void*, double, double, int);
  status (*get)(void*, const unsigned*, size_t, double*);
  status (*set)(void*, const unsigned*, size_t, const double*);
  status (*set_int)(void*, const unsigned*, size_t, const int*);
  status (*get_state)(void*, void**);
  status (*set_state)(void*, void*);
  status (*free_state)(void*, void**);
  status (*state_size)(void*, void*, size_t*);
  status (*write_state)(void*, void*, char*, size_t);
  status (*read_state)(void*, const char*, size_t, void**);
  callbacks calls;
  double step_s;
  int cars;
  car* car;
} gym;

static void say(void* environment, const char* name, status level, const char* category,
                const char* text, ...) {
  (void)environment, (void)category;
  if (level > 1) fprintf(stderr, "%s: %s\n", name, text);
}

GYM_API void gym_free(gym* g) {
  if (g == NULL) return;
  for (int i = 0; i < g->cars; ++i)
    if (g->car[i].unit != NULL) g->release(g->car[i].unit);
  free(g->car);
  if (g->library != NULL) dlclose(g->library);
  free(g);
}

#define FIND(member, name) (*(void**)&(g->member) = dlsym(g->library, name)) == NULL

// The binary of an unpacked unit with its token and the address of its resources; `starts` are set
// before each of `cars` cars is initialised. NULL where something is missing or refuses.
GYM_API gym* gym_make(const char* binary, const char* token, const char* resources, int cars,
                      double step_s, const unsigned* starts, const double* values, int count) {
  gym* g = calloc(1, sizeof *g);
  if (g == NULL) return NULL;
  g->library = dlopen(binary, RTLD_NOW | RTLD_LOCAL);
  g->car = calloc((size_t)cars, sizeof *g->car);
  g->step_s = step_s;
  if (g->library == NULL || g->car == NULL || FIND(instantiate, "fmi2Instantiate") ||
      FIND(release, "fmi2FreeInstance") || FIND(setup, "fmi2SetupExperiment") ||
      FIND(enter, "fmi2EnterInitializationMode") || FIND(leave, "fmi2ExitInitializationMode") ||
      FIND(do_step, "fmi2DoStep") || FIND(get, "fmi2GetReal") || FIND(set, "fmi2SetReal") ||
      FIND(set_int, "fmi2SetInteger") || FIND(get_state, "fmi2GetFMUstate") ||
      FIND(set_state, "fmi2SetFMUstate") || FIND(free_state, "fmi2FreeFMUstate") ||
      FIND(state_size, "fmi2SerializedFMUstateSize") ||
      FIND(write_state, "fmi2SerializeFMUstate") || FIND(read_state, "fmi2DeSerializeFMUstate")) {
    gym_free(g);
    return NULL;
  }
  g->calls = (callbacks){say, calloc, free, NULL, NULL};
  for (; g->cars < cars; ++g->cars) {
    char name[32];
    snprintf(name, sizeof name, "car %d", g->cars);
    void* unit = g->instantiate(name, 1, token, resources, &g->calls, 0, 0);
    g->car[g->cars].unit = unit;
    if (unit == NULL || g->set(unit, starts, (size_t)count, values) > 1 ||
        g->setup(unit, 0, 0.0, 0.0, 0, 0.0) > 1 || g->enter(unit) > 1 || g->leave(unit) > 1) {
      ++g->cars;
      gym_free(g);
      return NULL;
    }
  }
  return g;
}

// `steps` steps of every car: its gear and its actions are set, then it goes on, then it is
// observed. Actions and observations car after car. `refused` gets 1 for each car that refused a
// step (it left the road), 0 for the others, which drive on; it stands as it was until a state is
// loaded. How many refused.
GYM_API int gym_step(gym* g, int steps, const unsigned* action, const double* actions,
                     int n_actions, unsigned gear, const int* gears, const unsigned* observation,
                     double* observations, int n_observations, int* refused) {
  int count = 0;
  for (int i = 0; i < g->cars; ++i) {
    car* c = &g->car[i];
    int bad = g->set(c->unit, action, (size_t)n_actions, actions + (size_t)i * n_actions) > 1 ||
              g->set_int(c->unit, &gear, 1, gears + i) > 1;
    for (int k = 0; k < steps && !bad; ++k) {
      bad = g->do_step(c->unit, c->time_s, g->step_s, 1) > 1;
      c->time_s += g->step_s;
    }
    bad |= g->get(c->unit, observation, (size_t)n_observations,
                  observations + (size_t)i * n_observations) > 1;
    refused[i] = bad;
    count += bad;
  }
  return count;
}

// How many bytes gym_save() writes: the time, and the unit's own state.
GYM_API size_t gym_state_size(gym* g, int i) {
  void* state = NULL;
  size_t size = 0;
  if (g->get_state(g->car[i].unit, &state) > 1) return 0;
  if (g->state_size(g->car[i].unit, state, &size) > 1) size = 0;
  g->free_state(g->car[i].unit, &state);
  return size == 0 ? 0 : size + sizeof(double);
}

GYM_API int gym_save(gym* g, int i, char* bytes, size_t size) {
  void* state = NULL;
  if (size < sizeof(double) || g->get_state(g->car[i].unit, &state) > 1) return 1;
  memcpy(bytes, &g->car[i].time_s, sizeof(double));
  const int bad =
      g->write_state(g->car[i].unit, state, bytes + sizeof(double), size - sizeof(double)) > 1;
  g->free_state(g->car[i].unit, &state);
  return bad;
}

// Any car may take any car's bytes, of this process or another.
GYM_API int gym_load(gym* g, int i, const char* bytes, size_t size) {
  void* state = NULL;
  if (size < sizeof(double) ||
      g->read_state(g->car[i].unit, bytes + sizeof(double), size - sizeof(double), &state) > 1)
    return 1;
  const int bad = g->set_state(g->car[i].unit, state) > 1;
  g->free_state(g->car[i].unit, &state);
  if (!bad) memcpy(&g->car[i].time_s, bytes, sizeof(double));
  return bad;
}
