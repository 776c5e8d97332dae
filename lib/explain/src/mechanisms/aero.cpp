// Forces of the air that the simulation leaves out.
#include <algorithm>
#include <initializer_list>

#include "car_changes.h"
#include "effect.h"
#include "listing.h"

namespace explain::aero {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;

constexpr const char* kDrag = "vehicle.aero_drag";
constexpr const char* kDownforce = "vehicle.aero_downforce";

void list_drag(const Listing& l) {
  if (l.car.terms[Term::aero_drag] != 0.0)
    return untestable(l, kDrag, "the stated car has drag: see parameter.drag");
  if (!l.engine) return untestable(l, kDrag, kNoThrottle);
  candidate(l, kDrag, {"aero_drag", "1", 0.1, 0.03, true},
            {"the air holds the car back, which the simulation leaves out", "F = -q A",
             "coast down from high speed"},
            [](Setting& s, double v) { s.act(kMoreOf<Term::aero_drag>, v); });
}

void list_downforce(const Listing& l) {
  if (l.car.terms[Term::aero_downforce] != 0.0)
    return untestable(l, kDownforce, "the stated car has downforce: see parameter.downforce");
  if (!l.lateral && !has(l, kLoadFront))
    return untestable(l, kDownforce, "neither wheel loads nor side slip are logged");
  candidate(l, kDownforce, {"aero_downforce", "1", 0.1, 0.05, true},
            {"the air presses the car down, which the simulation leaves out", "Fz += q A",
             "constant-radius cornering at several speeds"},
            [](Setting& s, double v) { s.act(kMoreOf<Term::aero_downforce>, v); });
}

/// The relations see what is missing as a share of the area.
template <Term kTerm>
void write(CarChanges& out, const Finding& f, std::initializer_list<P> areas) {
  const double amount = out.car.terms[kTerm] + f.parameters[0].value;
  out.set(kTerm, std::clamp(amount, 0.0, 1.0));
  if (amount > 1)
    for (const P area : areas) out.set(area, amount * out.now(area));
}

void write_drag(CarChanges& out, const Finding& f) {
  write<Term::aero_drag>(out, f, {P::aero_drag_area_m2});
}

void write_downforce(CarChanges& out, const Finding& f) {
  write<Term::aero_downforce>(out, f, {P::front_lift_area_m2, P::rear_lift_area_m2});
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kDrag, .list = list_drag, .most = 3.0, .write_car = write_drag},
          {.id = kDownforce, .list = list_downforce, .most = 3.0, .write_car = write_downforce}};
}

}  // namespace explain::aero
