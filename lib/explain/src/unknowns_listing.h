// What the steps of inventory() share. Each lists the unknowns of one kind, in a fixed order, and
// says which of them the logs cannot speak about.
#pragma once

#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "explain/unknowns.h"

namespace explain {

struct Listing {
  const std::vector<Signals>& logs;
  const vehicle::Vehicle& car;
  bool engine, brake, lateral;  ///< logged: throttle; brake pressure; lateral speed and steering
  Inventory& out;
};

/// Name of the curve that says how level the accelerometer stays.
inline constexpr const char* kLevelAccelerometer = "level accelerometer";

/// Whether a log has the channel.
bool has(const Listing& l, Channel c);

/// Its name in the first log that has it.
const std::string& column(const Listing& l, Channel c);

void untestable(const Listing& l, std::initializer_list<const char*> ids,
                const std::string& reason);

/// How much of it there may be, see Unknown.
struct Amount {
  const char *name, *unit;
  double step, least;
  bool one_sided = false;
};
/// What it is, and the experiment that would separate it from its usual rivals.
struct Physics {
  std::string text, equation, separating;
};

/// Lists what is absent from the simulation; its kind is what `id` begins with. The result is valid
/// until the next one is listed.
Unknown& candidate(const Listing& l, const std::string& id, const Amount& amount,
                   const Physics& physics, std::function<void(Setting&, double)> set);

void list_parameters(const Listing& l);
void list_wheel_radii(const Listing& l);
void list_curves(const Listing& l);
void list_sensors(const Listing& l);
void list_road(const Listing& l);
void list_physics(const Listing& l);

}  // namespace explain
