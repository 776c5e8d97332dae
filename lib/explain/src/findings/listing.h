// What mechanisms know when they list their unknowns, and the words that they list them with.
#pragma once

#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "explain/unknowns.h"
#include "mechanism.h"

namespace explain {

struct Listing {
  const std::vector<Signals>& logs;
  const vehicle::Vehicle& car;
  bool engine, brake, lateral;  ///< logged: throttle; brake pressure; lateral speed and steering
  Inventory& out;
};

/// Of what the stated car has already.
inline constexpr const char* kStatedToo = "the stated car has it; its parameters are not refitted";
/// Of what acts on steering and tyres.
inline constexpr const char* kNoSlip = "side slip or steering is not logged";
/// Of what acts between throttle and road.
inline constexpr const char* kNoThrottle = "no throttle in the log";
/// Of what short waves and temperatures show, which have searches of their own.
inline constexpr const char* kTooShort = "outside what means of 0.3 s show";

/// Whether a log has the channel.
bool has(const Listing& l, Channel c);

/// Whether a log has the command itself.
bool commanded(const std::vector<Signals>& logs, Channel c);

/// Its name in the first log that has it.
const std::string& column(const Listing& l, Channel c);

void untestable(const Listing& l, const char* id, const std::string& reason);

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

/// Lists what is absent from the simulation. The result is valid until the next one is listed.
Unknown& candidate(const Listing& l, const char* id, const Amount& amount, const Physics& physics,
                   std::function<void(Setting&, double)> set);

/// Lists the curves that nobody knows exactly: always refitted, never a finding.
void list_curves(const Listing& l);

}  // namespace explain
