// Discs whose surface gives its heat to the core the better the hotter they are. Found by a search
// of its own, discs.cpp.
#include <fmt/format.h>

#include "car_changes.h"
#include "listing.h"
#include "vehicle/laws/disc_heat.h"

namespace explain::brake_disc_conductance {
namespace {

using P = vehicle::Parameter;
using vehicle::laws::kConductanceReference_k;

void write(CarChanges& out, const Finding& f) {
  out.set(P::brake_conductance_slope_1pk, f.parameters[0].value / kConductanceReference_k);
  out.set_constants(f);
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {
      {.id = kBrakeDiscConductance,
       .list = [](const Listing& l) { untestable(l, kBrakeDiscConductance, kTooShort); },
       .physics = "heat flows from the discs' surface to their core the better the hotter they are",
       .equation =
           fmt::format("flow = G (1 + k (T_mean - {0:.0f} K) / {0:.0f} K) (T_surface - T_core)",
                       kConductanceReference_k),
       .write_car = write}};
}

}  // namespace explain::brake_disc_conductance
