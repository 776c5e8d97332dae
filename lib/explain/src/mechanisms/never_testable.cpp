// What no log can tell, and why.
#include "listing.h"

namespace explain::never_testable {

std::vector<Mechanism> mechanisms() {
  return {{.id = "vehicle.mass",
           .list =
               [](const Listing& l) {
                 untestable(l, "vehicle.mass", "the same change as parameter.mass: see there");
               }},
          {.id = "vehicle.aero_slipstream", .list = [](const Listing& l) {
             untestable(l, "vehicle.aero_slipstream", "the log names no opponent");
           }}};
}

}  // namespace explain::never_testable
