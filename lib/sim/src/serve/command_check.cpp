#include "command_check.h"

#include "base/one_line.h"
#include "unit_places.h"

namespace sim {

std::string wrong_with(const CommandMessage& message, const Unit& unit) {
  for (const auto& [name, value] : message.starts) {
    const UnitVariable* const variable = unit.description().find(name);
    const bool may_be = variable != nullptr && is_number(*variable) && variable->size == 1 &&
                        (variable->is_input() || variable->causality == "parameter");
    if (!may_be)
      return "'" + base::one_line(name.substr(0, 60)) +
             "' is no number of a parameter or input of the unit to begin with";
    if (std::string wrong = wrong_with(*variable, value); !wrong.empty()) return wrong;
  }
  if (!message.save.empty() && !unit.description().keeps_states)
    return "a state to save, which this unit cannot (its description says so)";
  if (!message.save.empty() && !unit.has_saved(message.save) &&
      unit.saved_states() >= kMostSavedStates)
    return "a 17th state to save; save under a name that is there already";
  if (!message.state.empty() && !unit.has_saved(message.state)) return "a state that was not saved";
  return {};
}

}  // namespace sim
