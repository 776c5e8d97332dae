// Curves that nobody knows exactly: refitted with weak priors whatever is found, never reported.
#include <functional>
#include <utility>

#include "effect.h"
#include "listing.h"

namespace explain {
namespace {

using vehicle::Term;

void curve(const Listing& l, const char* name, double width,
           std::function<void(Setting&, double)> set) {
  Unknown u;
  u.id = "curve";
  u.kind = "curve";
  u.name = name;
  u.unit = "1";
  u.role = Role::kCurve;
  u.width = width;
  u.step = 0.02;
  u.set = std::move(set);
  l.out.unknowns.push_back(std::move(u));
}

}  // namespace

void list_curves(const Listing& l) {
  // On the body it leans with it; some loggers take that out.
  if (has(l, kAx) || has(l, kAy) || has(l, kAz)) {
    curve(l, "level accelerometer", 1.0, [](Setting& s, double amount) { s.level += amount; });
    l.out.unknowns.back().step = 0.2;
    l.out.unknowns.back().beside_road = {1.0, 1.0};
  }
  // Half a sample if the logger filters what it has sampled, none if it samples what was filtered.
  if (has(l, kYawRate)) {
    const double half_s = 0.5 / l.logs.front().sample_hz;
    curve(l, "sampling of filters", half_s,
          [](Setting& s, double lead_s) { s.filter_lead_s += lead_s; });
    l.out.unknowns.back().step = 0.002;
    l.out.unknowns.back().unit = "s";
    l.out.unknowns.back().beside_road = {half_s, half_s};
  }
  if (l.engine) {
    for (std::size_t k = 0; k < 4; ++k)
      curve(l, "engine map", 0.02, [k](Setting& s, double amount) { s.engine_shape[k] += amount; });
    // Geometry of the suspension, which carries a part of them past the springs.
    curve(l, "torques of the wheels on the body", 1.0,
          [](Setting& s, double amount) { s.reaction += amount; });
    curve(l, "rolling resistance", 0.1, [](Setting& s, double amount) { s.rolling += amount; });
    if (has(l, kWheelRear)) {
      if (!l.car.files.tyre[1].states_rolling_radius)  // a rule of thumb
        curve(l, "rolling radius over load", 0.5,
              [](Setting& s, double amount) { s.radius_by_load += amount; });
      curve(l, "slip stiffness", 0.5, [](Setting& s, double amount) { s.slip += amount; });
    }
  }
  if (!l.lateral) return;
  if (l.car.terms[Term::tyre_combined_slip] > 0)
    curve(l, "combined slip", 0.1, [](Setting& s, double amount) {
      s.act(kMoreOfPositive<Term::tyre_combined_slip>, amount);
    });
  if (l.car.terms[Term::tyre_relaxation] > 0)
    curve(l, "relaxation length", 0.2,
          [](Setting& s, double amount) { s.act(kMoreOfPositive<Term::tyre_relaxation>, amount); });
  for (std::size_t k = 0; k < 2; ++k) {
    curve(l, "tyre curve", 0.02, [k](Setting& s, double amount) { s.curve[k] += amount; });
    curve(l, "tyre curve", 0.02, [k](Setting& s, double amount) { s.curve2[k] += amount; });
    curve(l, "tyre load", 0.02, [k](Setting& s, double amount) { s.load_curve[k] += amount; });
    curve(l, "side force", 0.01, [k](Setting& s, double amount) { s.drop[k] += amount; });
  }
}

}  // namespace explain
