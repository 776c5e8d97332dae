#include "explain/plausible_car.h"

#include <fmt/format.h>

#include <cmath>

#include "selection.h"

namespace explain {

void doubt_the_car(Findings& findings) {
  std::string far;
  int count = 0;
  for (const ParameterValue& p : findings.parameters)
    if ((p.beyond_prior || p.at_limit) && p.stated != 0 &&
        std::abs(p.value / p.stated - 1) > selection::kOtherCar)
      far += (count++ > 0 ? ", " : "") + p.name;
  if (count < selection::kOtherCarParameters) return;
  // Forces are those of the file's car: what is missing of another one is not found with them. The
  // list of parameters has those that are off.
  std::string unnamed;
  std::erase_if(findings.findings, [&](const Finding& f) {
    const bool of_the_car = f.kind == "vehicle" || f.kind == "environment";
    if (of_the_car) unnamed += (unnamed.empty() ? "; else it would name " : ", ") + f.mechanism;
    return of_the_car || f.kind == "parameter";
  });
  findings.remarks.push_back(
      fmt::format("{} are each more than 30 % off what the vehicle file states: is it the file of "
                  "this car? Nothing about the car is named or written back{}",
                  far, unnamed));
  findings.doubtful_car = true;
}

}  // namespace explain
