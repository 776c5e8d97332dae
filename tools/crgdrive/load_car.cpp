#include "load_car.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/sha256.h"
#include "vehicle/error.h"
#include "vehicle/road_file.h"

namespace crgdrive {

vehicle::Vehicle load_vehicle(const CarOptions& options) {
  vehicle::Vehicle v =
      vehicle::read_vehicle(options.vehicle_path, options.setup_path, options.settings);
  if (options.contact == "single-point") v.contact = vehicle::Contact::kSinglePoint;
  if (options.contact == "four-point") v.contact = vehicle::Contact::kFourPoint;
  if (options.contact == "strip") v.contact = vehicle::Contact::kStrip;
  return v;
}

crg::Surface read_road(const std::string& track_path, const std::string& friction_path,
                       Terminal& terminal) {
  vehicle::RoadFiles files = vehicle::read_road(track_path, friction_path);
  if (!files.remark.empty()) terminal.remark(files.remark);
  return std::move(files.surface);
}

vehicle::StepOptions step_options(const CarOptions& options) {
  return {options.step_s,
          options.integrator == "explicit" ? vehicle::Integrator::kExplicitEuler
                                           : vehicle::Integrator::kSemiImplicit,
          options.stop_off_road};
}

void require_on_road(const crg::Surface& road, const std::string& road_path,
                     const recording::Table& table, const std::string& table_path) {
  const auto* const x = table.find("x_m");
  const auto* const y = table.find("y_m");
  if (x == nullptr || y == nullptr) return;  // said by those who need them
  const auto& v_m = road.grid().v_m;
  std::size_t places = 0, beside = 0;
  // A thousand places tell; the cursor would follow a drive along the road, so each looks anew.
  const std::size_t every = std::max<std::size_t>(1, table.rows() / 1000);
  for (std::size_t i = 0; i < table.rows(); i += every) {
    if (!std::isfinite((*x)[i]) || !std::isfinite((*y)[i])) continue;
    crg::Cursor cursor;
    const crg::UV at = road.uv_of_xy((*x)[i], (*y)[i], cursor);
    ++places;
    if (!(at.v_m >= v_m.front() && at.v_m <= v_m.back())) ++beside;
  }
  if (2 * beside > places)
    throw vehicle::Error(fmt::format(
        "{}: {:.0f} % of the places lie beside the road {}; give the road of this "
        "drive, in the same frame",
        table_path, 100.0 * static_cast<double>(beside) / static_cast<double>(places), road_path));
}

std::size_t steps_per_row(double rate_hz, double step_s, Terminal& terminal) {
  const double every = 1.0 / (rate_hz * step_s);
  if (every < 1.0 - 1e-6)
    throw vehicle::Error(
        fmt::format("--rate-hz {}: more than one row per step of {} s; wanted at most {:.6g}",
                    rate_hz, step_s, 1.0 / step_s));
  const double whole = std::max(1.0, std::round(every));
  if (std::abs(every - whole) > 1e-6)
    terminal.remark(fmt::format("one row every {:.0f} steps of {} s: {:.6g} Hz, nearest to {:g} Hz",
                                whole, step_s, 1.0 / (whole * step_s), rate_hz));
  return static_cast<std::size_t>(whole);
}

std::string provenance(const std::string& run, const vehicle::Vehicle& car,
                       const CarOptions& options, const std::vector<std::string>& more) {
  std::string out = fmt::format("# crgdrive {}: vehicle {}, step {} s, {}\n", run, car.name,
                                options.step_s, options.integrator);
  const auto file = [&](const std::string& path) {
    out += fmt::format("# file {} sha256 {}\n", path, base::sha256_of_file(path));
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
