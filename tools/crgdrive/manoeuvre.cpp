#include "vehicle/manoeuvre.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "live.h"
#include "load_car.h"
#include "vehicle/error.h"
#include "write_telemetry.h"

namespace crgdrive {

int manoeuvre(const ManoeuvreCommand& command, Terminal& terminal) {
  const vehicle::Vehicle v = load_vehicle(command.car);
  const auto car = vehicle::make_car(v.files, v.parameters, v.terms, v.contact);
  vehicle::Manoeuvre m;
  m.kind = vehicle::manoeuvre_named(command.kind);
  m.speed_mps = command.speed_mps;
  m.duration_s = command.duration_s;
  m.steer_rad = command.steer_rad;
  m.frequency_hz = command.frequency_hz;
  m.pressure_pa = command.pressure_pa;
  m.height_m = command.height_m;
  m.low_grip = command.low_grip;
  m.fuel_kg = command.fuel_kg;
  m.step = step_options(command.car);

  m.progress = terminal.progress();
  Live live(command.live);
  if (live.wanted() || !command.out_path.empty())
    m.record_every = steps_per_row(command.rate_hz, m.step.step_s, terminal);
  if (live.wanted()) m.on_row = [&](const recording::Table& table) { live.row(table); };
  vehicle::DeviceFile devices;
  std::vector<std::string> files;
  if (!command.devices_path.empty()) {
    devices = vehicle::read_devices(command.devices_path);
    m.devices = &devices;
    files.push_back(command.devices_path);
  }

  const vehicle::ManoeuvreResult r = vehicle::run_manoeuvre(car, m);
  if (terminal.json)
    terminal.print(base::json_text(nlohmann::ordered_json{
        {"manoeuvre", command.kind},
        {"complete", r.complete},
        {"peak_fz_n", r.peak_fz_n},
        {"peak_ay_mps2", r.peak_ay_mps2},
        {"peak_yaw_rate_radps", r.peak_yaw_rate_radps},
        {"end_mps", r.end_mps},
        {"step_swing", r.step_swing},
        {"swing_warning", r.swing_warning},
        {"ledge_warning", r.ledge_warning},
        {"stop_m", r.stop_m > 0.0 ? nlohmann::ordered_json(r.stop_m) : nullptr},
        {"telemetry", command.out_path}}));
  else
    terminal.print(fmt::format(
        "{}: largest wheel load {:.0f} N, lateral acceleration {:.2f} m/s2, yaw rate {:.3f} rad/s; "
        "{:.2f} m/s at the end{}\n",
        command.kind, r.peak_fz_n, r.peak_ay_mps2, r.peak_yaw_rate_radps, r.end_mps,
        r.stop_m > 0.0 ? fmt::format("; stopped within {:.2f} m", r.stop_m) : std::string()));
  for (const std::string& warning : {r.swing_warning, r.ledge_warning})
    if (!terminal.json && !warning.empty()) terminal.print(warning + "\n");
  if (!command.out_path.empty())
    write_telemetry(command.out_path,
                    provenance("manoeuvre " + command.kind, v, command.car, files) +
                        fmt::format("# start fuel_kg={:g}\n", command.fuel_kg),
                    r.telemetry);
  if (!r.complete) throw vehicle::Error(r.problem);
  return kOk;
}

}  // namespace crgdrive
