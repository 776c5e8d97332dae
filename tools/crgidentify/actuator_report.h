// An identified actuator as a setup sheet, in words, as JSON and as curves.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "identify/actuator_fit.h"

namespace crgidentify {

/// "2 poles, a zero and play".
std::string order_words(const identify::ActuatorOrder& order);

/// The lines of a setup sheet for `part` (steering, throttle or brake). At most 2 poles: the car's
/// actuators have no more. One pole becomes two of which the other is 1,600 times as fast, or as
/// fast as a lag of 1 ms allows.
std::string actuator_sheet(const identify::ActuatorFit& fit, const std::string& part);
std::string actuator_text(const identify::ActuatorFit& fit);
nlohmann::ordered_json actuator_json(const identify::ActuatorFit& fit);
/// The page: part of the record, response to a step, amplitude and phase.
std::string actuator_page(const identify::ActuatorFit& fit, const std::string& title,
                          const std::vector<double>& command, const std::vector<double>& movement);

}  // namespace crgidentify
