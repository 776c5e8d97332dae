#include "explain/unknowns.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "listing.h"
#include "plausible.h"

namespace explain {
namespace {

bool any(const std::vector<Signals>& logs, Channel c) {
  return std::any_of(logs.begin(), logs.end(), [&](const Signals& s) { return s.present[c]; });
}

void limit_amounts(std::vector<Unknown>& unknowns) {
  for (Unknown& u : unknowns)
    if (const Mechanism* m = find_mechanism(u.id)) u.most = m->most;
}

// One lap shows every place once: nothing comes back there.
void drop_places_seen_once(const Listing& l) {
  double rounds = 0.0;
  bool closed = false;
  for (const Signals& s : l.logs) {
    rounds += s.rounds;
    closed = closed || s.closed;
  }
  if (!closed || rounds >= kTwoRounds) return;
  for (const Unknown& u : l.out.unknowns)
    if (u.along_road) untestable(l, u.id.c_str(), "less than two laps");
  std::erase_if(l.out.unknowns, [](const Unknown& u) { return u.along_road; });
}

}  // namespace

bool has(const Listing& l, Channel c) { return any(l.logs, c); }

const std::string& column(const Listing& l, Channel c) {
  for (const Signals& s : l.logs)
    if (s.present[c]) return s.column[c];
  return l.logs.front().column[c];
}

void untestable(const Listing& l, const char* id, const std::string& reason) {
  l.out.untestable.push_back({id, reason});
}

bool commanded(const std::vector<Signals>& logs, Channel c) {
  return std::any_of(logs.begin(), logs.end(),
                     [&](const Signals& s) { return s.present[c] && s.commanded[c]; });
}

Unknown& candidate(const Listing& l, const char* id, const Amount& amount, const Physics& physics,
                   std::function<void(Setting&, double)> set) {
  Unknown u;
  u.id = id;
  u.kind = u.id.substr(0, u.id.find('.'));
  u.name = amount.name;
  u.unit = amount.unit;
  u.step = amount.step;
  u.least = amount.least;
  u.one_sided = amount.one_sided;
  u.physics = physics.text;
  u.equation = physics.equation;
  u.separating = physics.separating;
  u.set = std::move(set);
  return l.out.unknowns.emplace_back(std::move(u));
}

const std::vector<std::string>& mechanism_ids() {
  static const std::vector<std::string> ids = [] {
    std::vector<std::string> out;
    for (const Mechanism& m : mechanisms()) out.emplace_back(m.id);
    return out;
  }();
  return ids;
}

Inventory inventory(const std::vector<Signals>& logs, const vehicle::Vehicle& car) {
  Inventory out;
  const Listing l{.logs = logs,
                  .car = car,
                  .engine = any(logs, kThrottle),
                  .brake = any(logs, kBrakeFront),
                  .lateral = any(logs, kVy) && any(logs, kSteer),
                  .out = out};
  // What is stated, then the curves that nobody knows exactly, then what may be missing.
  const auto list = [&](bool stated) {
    for (const Mechanism& m : mechanisms())
      if (m.list != nullptr && (m.kind() == "parameter") == stated) m.list(l);
  };
  list(true);
  list_curves(l);
  list(false);
  limit_amounts(out.unknowns);
  drop_places_seen_once(l);
  return out;
}

}  // namespace explain
