// Air that moves over the ground.
#include <cmath>

#include "car_changes.h"
#include "effect.h"
#include "listing.h"

namespace explain::wind {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;

constexpr const char* kId = "environment.wind";

/// Amounts: towards +x and towards +y, m/s.
constexpr Effect kBlow{[](vehicle::Car<double>& car, const Acting& a) {
  auto& p = car.parameters;
  const double wind = car.terms[Term::wind] * p[P::environment_wind_mps];
  const double x = a.amount[0] + wind * std::cos(p[P::environment_wind_heading_rad]);
  const double y = a.amount[1] + wind * std::sin(p[P::environment_wind_heading_rad]);
  p[P::environment_wind_mps] = std::hypot(x, y);
  p[P::environment_wind_heading_rad] = std::atan2(y, x);
  car.terms[Term::wind] = 1.0;
}};

void list(const Listing& l) {
  if (!l.engine) return untestable(l, kId, kNoThrottle);
  const Physics wind{"the air moves over the ground", "drag = k |v - w| (v - w)",
                     "drive the straight in both directions, or log the wind"};
  candidate(l, kId, {"wind towards +x", "m/s", 1.5, 0.8}, wind,
            [](Setting& s, double v) { s.acting(kBlow).amount[0] += v; });
  candidate(l, kId, {"wind towards +y", "m/s", 1.5, 0.8}, wind,
            [](Setting& s, double v) { s.acting(kBlow).amount[1] += v; });
}

void write(CarChanges& out, const Finding& f) {
  const double wind = out.now(P::environment_wind_mps);
  double x = wind * std::cos(out.now(P::environment_wind_heading_rad));
  double y = wind * std::sin(out.now(P::environment_wind_heading_rad));
  if (out.terms.count(name_of(Term::wind)) == 0) x = y = 0;  // the relations know no stated wind
  for (const FoundParameter& p : f.parameters) (p.name.ends_with("+x") ? x : y) += p.value;
  out.set(Term::wind, 1);
  out.set(P::environment_wind_mps, std::hypot(x, y));
  out.set(P::environment_wind_heading_rad, std::atan2(y, x));
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kId, .list = list, .most = 25.0, .by_components = true, .write_car = write}};
}

}  // namespace explain::wind
