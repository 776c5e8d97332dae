#include "vehicle/parameters.h"

#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "commands.h"

namespace crgdrive {

int parameters(Terminal& terminal) {
  if (!terminal.json) {
    terminal.print(vehicle::describe_parameters());
    return kOk;
  }
  nlohmann::ordered_json parameters = nlohmann::ordered_json::array(),
                         terms = nlohmann::ordered_json::array();
  for (const vehicle::ParameterInfo& p : vehicle::parameter_list())
    parameters.push_back({{"name", p.name},
                          {"unit", p.unit},
                          {"default", p.value},
                          {"lowest", p.low},
                          {"highest", p.high},
                          {"prior", p.prior},
                          {"meaning", p.text}});
  for (const vehicle::TermInfo& t : vehicle::term_list())
    terms.push_back({{"name", t.name}, {"without", t.absence}});
  terminal.print(
      base::json_text(nlohmann::ordered_json{{"parameters", parameters}, {"terms", terms}}));
  return kOk;
}

}  // namespace crgdrive
