#include "load_car.h"

#include <fmt/format.h>

#include <cmath>

#include "files/sha256.h"
#include "vehicle/error.h"

namespace crgdrive {

vehicle::Vehicle load_vehicle(const CarOptions& options) {
  vehicle::Vehicle v = vehicle::read_vehicle(options.vehicle_path);
  if (!options.setup_path.empty()) vehicle::read_setup(v, options.setup_path);
  for (const std::string& setting : options.settings) vehicle::apply_setting(v, setting, "--set");
  if (options.contact == "single-point") v.contact = vehicle::Contact::kSinglePoint;
  if (options.contact == "four-point") v.contact = vehicle::Contact::kFourPoint;
  if (options.contact == "strip") v.contact = vehicle::Contact::kStrip;
  return v;
}

vehicle::StepOptions step_options(const CarOptions& options) {
  return {options.step_s,
          options.integrator == "explicit" ? vehicle::Integrator::kExplicitEuler
                                           : vehicle::Integrator::kSemiImplicit,
          options.stop_off_road};
}

std::size_t steps_per_row(double rate_hz, double step_s) {
  const double every = 1.0 / (rate_hz * step_s);
  if (std::abs(every - std::round(every)) > 1e-6 || every < 1.0 - 1e-6)
    throw vehicle::Error(
        fmt::format("--rate-hz {}: one row every {:.3f} steps of {} s; wanted a whole number",
                    rate_hz, every, step_s));
  return static_cast<std::size_t>(std::lround(every));
}

std::string provenance(const std::string& run, const vehicle::Vehicle& car,
                       const CarOptions& options, const std::vector<std::string>& more) {
  std::string out = fmt::format("# crgdrive {}: vehicle {}, step {} s, {}\n", run, car.name,
                                options.step_s, options.integrator);
  const auto file = [&](const std::string& path) {
    out += fmt::format("# file {} sha256 {}\n", path, files::sha256_of_file(path));
  };
  for (const std::string& path : car.read_files) file(path);
  if (!options.setup_path.empty()) file(options.setup_path);
  for (const std::string& path : more) file(path);
  for (const std::string& setting : options.settings) out += fmt::format("# set {}\n", setting);
  out += "# terms";
  const auto terms = vehicle::term_list();
  for (std::size_t i = 0; i < vehicle::kTermCount; ++i)
    out += fmt::format(" {}={:g}", terms[i].name, car.terms.value[i]);
  return out + "\n";
}

}  // namespace crgdrive
