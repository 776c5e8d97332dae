#include "explain/plausible_car.h"

#include <fmt/format.h>

#include <cmath>
#include <set>
#include <string>

#include "selection.h"

namespace explain {

namespace {

/// Parameters beyond their priors and further off than a share of what is stated.
struct Off {
  std::string names;
  int count = 0;
  std::set<std::string> kinds;
};

Off off_by(const Findings& findings, double share) {
  Off off;
  for (const ParameterValue& p : findings.parameters)
    if ((p.beyond_prior || p.at_limit) && p.stated != 0 &&
        std::abs(p.value / p.stated - 1) > share) {
      off.names += (off.count++ > 0 ? ", " : "") + p.name;
      off.kinds.insert(p.id);
    }
  return off;
}

}  // namespace

bool is_of_the_car(const std::string& kind) {
  return kind == "vehicle" || kind == "environment" || kind == "parameter";
}

void doubt_the_car(Findings& findings) {
  const Off far = off_by(findings, selection::kOtherCar),
            less = off_by(findings, selection::kOtherCarLess);
  const bool two_far = far.count >= selection::kOtherCarParameters;
  if (!two_far && less.count <= selection::kOtherCarParameters) return;
  // Both axles' lift or stiffness alone may be one number that is wrong.
  if (off_by(findings, selection::kOtherCarAtAll).kinds.size() < 2) return;
  // Forces are those of the file's car: what is missing of another one is not found with them. The
  // list of parameters has those that are off.
  std::string unnamed;
  for (const Finding& f : findings.findings)
    if (is_of_the_car(f.kind) && f.kind != "parameter")
      unnamed += (unnamed.empty() ? "; else it would name " : ", ") + f.mechanism;
  std::erase_if(findings.findings, [](const Finding& f) { return is_of_the_car(f.kind); });
  findings.remarks.push_back(
      fmt::format("{} are each more than {:.0f} % off what the vehicle file states: is it the file "
                  "of this car? Nothing about the car is named by forces, or written back{}",
                  two_far ? far.names : less.names,
                  100 * (two_far ? selection::kOtherCar : selection::kOtherCarLess), unnamed));
  findings.doubtful_car = true;
}

}  // namespace explain
