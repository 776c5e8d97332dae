#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/json_text.h"
#include "base/output_set.h"
#include "base/sha256.h"
#include "base/shell_word.h"
#include "base/write_file.h"
#include "commands.h"
#include "vehicle/error.h"
#include "vehicle/new_car.h"
#include "vehicle/straight_run.h"
#include "vehicle/vehicle_file.h"

namespace crgdrive {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr double kDoubt = 0.1;  ///< of a published figure; more is worth a remark

/// Throws Error where a file of that name lies there that this command did not write, or that was
/// changed since.
void keep_changed_files(const std::string& folder, const vehicle::NewCar& car) {
  const auto before = base::files_of_set(folder);
  for (const auto& [name, text] : car.files) {
    const std::string path = (fs::path(folder) / name).string();
    std::error_code missing;
    if (!fs::exists(path, missing)) continue;
    const auto known = before ? before->find(name) : decltype(before->find(name)){};
    if (!before || known == before->end() || known->second != base::sha256_of_file(path))
      throw vehicle::Error(path +
                           ": lies there already, and is not as this command wrote it; take "
                           "another folder with -o, or move it away");
  }
}

/// What is published beside what the car does; empty: nothing to say.
std::string doubt(const char* what, const char* unit, const std::optional<double>& published,
                  double seen) {
  if (!published || std::abs(seen - *published) <= kDoubt * *published) return "";
  return fmt::format(
      "the car's {} is {:.3g} {}, the sheet says {:g}: {}; check power, mass, gears, grip and "
      "drag_area_m2",
      what, seen, unit, *published,
      seen > 0.0 ? fmt::format("{:+.0f} %", 100.0 * (seen / *published - 1.0)) : "not reached");
}

}  // namespace

int new_car(const NewCommand& command, Terminal& terminal) {
  if (command.example) {
    const std::string text = vehicle::example_data_sheet();
    terminal.print(terminal.json ? base::json_text(ordered_json{{"example", text}}) : text);
    return kOk;
  }
  const vehicle::DataSheet sheet = vehicle::read_data_sheet(command.sheet_path);
  const vehicle::NewCar car = vehicle::make_new_car(sheet);
  keep_changed_files(command.out_path, car);
  base::OutputSet outputs(command.out_path, "crgdrive new");
  for (const auto& [name, text] : car.files) base::write_file(outputs.staged(name), text);
  terminal.start("driving it straight on");
  const vehicle::Vehicle read = vehicle::read_vehicle(outputs.staged("vehicle.yaml"));
  const auto simulated = vehicle::make_car(read.files, read.parameters, read.terms, read.contact);
  const vehicle::StraightRun run = vehicle::run_straight(simulated);
  if (!run.problem.empty()) throw vehicle::Error(command.sheet_path + ": " + run.problem);
  outputs.commit("car");
  const std::string path = outputs.path("vehicle.yaml");
  const double top_kmh = 3.6 * run.top_mps;
  if (terminal.json) {
    terminal.print(base::json_text(
        ordered_json{{"car", path},
                     {"guessed", car.guessed},
                     {"top_speed_kmh", top_kmh},
                     {"to_100_kmh_s", run.to_100_kmh_s > 0.0 ? ordered_json(run.to_100_kmh_s)
                                                             : ordered_json(nullptr)}}));
  } else {
    terminal.print(
        fmt::format("{}: {} numbers guessed, each with its range and why in the file\n"
                    "top speed {:.0f} km/h, {}\n"
                    "drive it: crgdrive lap --car {} --road ROAD.crg -o lap.csv\n",
                    path, car.guessed, top_kmh,
                    run.to_100_kmh_s > 0.0
                        ? fmt::format("0 to 100 km/h in {:.1f} s, without fuel", run.to_100_kmh_s)
                        : "100 km/h are not reached",
                    base::shell_word(path)));
  }
  for (const std::string& said :
       {doubt("top speed", "km/h", sheet.top_speed_kmh, top_kmh),
        doubt("time to 100 km/h", "s", sheet.to_100_kmh_s, run.to_100_kmh_s)})
    if (!said.empty()) terminal.remark(command.sheet_path + ": " + said);
  return kOk;
}

}  // namespace crgdrive
