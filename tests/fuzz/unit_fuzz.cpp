#include <set>

#include "base/error.h"
#include "fuzz/target.h"
#include "sim/unit_description.h"

void fuzz::run(std::string_view bytes) {
  try {
    const sim::UnitDescription unit = sim::read_unit_description(bytes, "unit.fmu");
    require(unit.version == 2 || unit.version == 3, "a version that is known");
    require(!unit.identifier.empty() && unit.identifier.find('/') == std::string::npos,
            "a binary in its folder");
    std::set<std::string> names;
    for (const sim::UnitVariable& variable : unit.variables)
      require(!variable.name.empty() && names.insert(variable.name).second &&
                  variable.size <= 1'000'000,
              "variables with names and bounds");
  } catch (const base::Error& error) {
    require_refusal(error, "unit.fmu");
  }
}
