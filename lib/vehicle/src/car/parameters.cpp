#include "vehicle/parameters.h"

#include <fmt/format.h>

namespace vehicle {
namespace {

constexpr std::array<ParameterInfo, kParameterCount> kParameters{{
#define VEHICLE_PARAMETER(group, key, unit, value, low, high, prior, text) \
  {#group "." #key, unit, value, low, high, prior, text},
#include "vehicle/parameters.def"
#undef VEHICLE_PARAMETER
}};

constexpr std::array<TermInfo, kTermCount> kTerms{{
#define VEHICLE_TERM(name, text) {#name, text},
#include "vehicle/terms.def"
#undef VEHICLE_TERM
}};

}  // namespace

std::span<const ParameterInfo, kParameterCount> parameter_list() { return kParameters; }

std::optional<Parameter> find_parameter(std::string_view name) {
  for (std::size_t i = 0; i < kParameterCount; ++i)
    if (kParameters[i].name == name) return static_cast<Parameter>(i);
  return std::nullopt;
}

int top_gear(const Parameters<double>& p) {
  int gear = kMostGears;
  while (gear > 0 && !(overall_ratio(p, gear) > 0.0)) --gear;
  return gear;
}

Parameters<double> default_parameters() {
  Parameters<double> out{};
  for (std::size_t i = 0; i < kParameterCount; ++i) out.value[i] = kParameters[i].value;
  return out;
}

std::span<const TermInfo, kTermCount> term_list() { return kTerms; }

std::optional<Term> find_term(std::string_view name) {
  for (std::size_t i = 0; i < kTermCount; ++i)
    if (kTerms[i].name == name) return static_cast<Term>(i);
  return std::nullopt;
}

Amplitudes<double> default_amplitudes() {
  Amplitudes<double> out;
  out.value.fill(1.0);
  out[Term::locked_differential] = 0.0;
  out[Term::brake_vanes] = 0.0;
  return out;
}

std::string describe_parameters() {
  std::string out =
      "# Parameters and terms of the simulated car\n"
      "Written by `crgdrive parameters`; a test compares.\n\n"
      "| parameter | unit | default | lowest | highest | prior | meaning |\n"
      "|---|---|---|---|---|---|---|\n";
  for (const ParameterInfo& p : kParameters)
    out += fmt::format("| `{}` | {} | {:.7g} | {:g} | {:g} | {:g} | {} |\n", p.name, p.unit,
                       p.value, p.low, p.high, p.prior, p.text);
  out += "\n| term | without it |\n|---|---|\n";
  for (const TermInfo& t : kTerms) out += fmt::format("| `{}` | {} |\n", t.name, t.absence);
  return out;
}

}  // namespace vehicle
