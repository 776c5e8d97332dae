#include "fmu/export_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/error.h"
#include "base/read_file.h"
#include "base/sha256.h"
#include "fmu/archive.h"
#include "fmu/unit_file.h"
#include "vehicle/road_file.h"
#include "vehicle/step.h"
#include "vehicle/vehicle_file.h"

namespace fmu {
namespace {

namespace fs = std::filesystem;

constexpr const char* kResources = "resources/";

/// The folder that all of the vehicle's files lie below, from where it is: "car/" holds it.
struct CarFolder {
  std::string vehicle;  ///< path of the vehicle file within the resources
  std::vector<ArchiveFile> files;
};

CarFolder pack_car(const vehicle::Vehicle& car) {
  std::vector<fs::path> paths;
  for (const std::string& file : car.read_files) {
    const fs::path path = fs::path(file).lexically_normal();
    if (path.is_absolute() && !fs::path(car.read_files.front()).is_absolute())
      throw base::Error(fmt::format(
          "{}: names {} by an absolute path, which another machine has not; put the file beside "
          "the vehicle file",
          car.read_files.front(), file));
    paths.push_back(fs::absolute(path).lexically_normal());
  }
  fs::path common = paths.front().parent_path();
  for (const fs::path& path : paths)
    while (path.lexically_relative(common).begin()->string() == "..") common = common.parent_path();
  CarFolder out;
  for (const fs::path& path : paths) {
    const std::string name = "car/" + path.lexically_relative(common).generic_string();
    if (std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < 32; }))
      throw base::Error(fmt::format("{}: a control character in its name", path.string()));
    if (out.vehicle.empty()) out.vehicle = name;
    const bool known = std::any_of(out.files.begin(), out.files.end(),
                                   [&](const ArchiveFile& f) { return f.name == name; });
    if (!known) out.files.push_back({name, base::read_file(path.string())});
  }
  return out;
}

/// The setup and the settings, which replace what it says, as one sheet; applied to the car too.
std::string one_sheet(const ExportOptions& options, vehicle::Vehicle& car) {
  const vehicle::Vehicle plain = car;
  if (!options.setup_path.empty()) vehicle::read_setup(car, options.setup_path);
  for (const std::string& setting : options.settings) vehicle::apply_setting(car, setting, "--set");
  std::string sheet;
  for (std::size_t i = 0; i < vehicle::kParameterCount; ++i)
    if (car.parameters.value[i] != plain.parameters.value[i])
      sheet += fmt::format("{} = {}\n", vehicle::parameter_list()[i].name, car.parameters.value[i]);
  for (std::size_t i = 0; i < vehicle::kTermCount; ++i)
    if (car.terms.value[i] != plain.terms.value[i])
      sheet += fmt::format("{} = {}\n", vehicle::term_list()[i].name, car.terms.value[i]);
  return sheet;
}

/// A road as one file: what it includes is put into it.
std::string road_bytes(const std::string& path) {
  const crg::Crg road = crg::read(path);
  return road.included_path.empty() ? base::read_file(path) : crg::to_bytes(road, road.format);
}

/// Where a car can stand: on the middle of the road or on its reference line.
void choose_start(const vehicle::Vehicle& car, const crg::Surface& surface, UnitFile& unit) {
  const crg::ReferenceLine& line = surface.reference_line();
  const std::vector<double>& v_m = surface.grid().v_m;
  constexpr double kBesideWheel_m = 1.5;
  double u_m = line.u_begin_m;
  if (!line.closed) u_m += car.parameters[vehicle::Parameter::chassis_wheelbase_m] + kBesideWheel_m;
  const bool on_line = v_m.front() < -kBesideWheel_m && v_m.back() > kBesideWheel_m;
  unit.numbers.push_back({"start.u", u_m});
  unit.numbers.push_back({"start.v", on_line ? 0.0 : 0.5 * (v_m.front() + v_m.back())});
}

/// What the model description says of the starts.
std::vector<double> starts(const std::vector<Variable>& list, const UnitFile& unit,
                           const vehicle::Vehicle& car) {
  std::vector<double> out(count_values(list) - kTextCount, 0.0);
  for (const Variable& v : list) {
    if (v.source == Source::kText) continue;
    double start = v.start;
    if (v.source == Source::kParameter) start = car.parameters.value[v.index];
    if (v.source == Source::kTerm) start = car.terms.value[v.index];
    for (const UnitFile::Number& number : unit.numbers)
      if (number.name == v.name) start = number.value;
    std::fill_n(out.begin() + v.reference, v.size, start);
  }
  return out;
}

/// With an empty token.
Description describe(const ExportOptions& options, const UnitFile& unit,
                     const vehicle::Vehicle& car) {
  Description out;
  out.name = car.name;
  out.generation_tool = options.generation_tool;
  out.step_s = options.step_s;
  out.texts = unit.texts;
  out.starts = starts(variables(), unit, car);
  return out;
}

std::string token_of(const std::string& everything) {
  const std::string hash = base::sha256(everything);
  return fmt::format("{{{}-{}-{}-{}-{}}}", hash.substr(0, 8), hash.substr(8, 4), hash.substr(12, 4),
                     hash.substr(16, 4), hash.substr(20, 12));
}

/// Description, binary and resources, with a token that stands for all of them.
void pack(const ExportOptions& options, const vehicle::Vehicle& car, UnitFile& unit,
          std::vector<ArchiveFile> resources, Exported& out) {
  const bool second = options.version == Version::kFmi2;
  const std::string binary = base::read_file(options.binary_path);
  const std::vector<Variable> list = variables();
  Description description = describe(options, unit, car);
  // The token stands for everything in the unit, the description with an empty token included.
  std::string all = model_description(description, options.version) + base::sha256(binary);
  for (const ArchiveFile& file : resources) all += file.name + '\n' + base::sha256(file.bytes);
  unit.token = description.token = token_of(all);

  std::vector<ArchiveFile> files{
      {"modelDescription.xml", model_description(description, options.version)},
      {fmt::format("binaries/{}/{}.so", second ? "linux64" : "x86_64-linux", kModelIdentifier),
       binary},
      {std::string(kResources) + "unit.txt", format_unit_file(unit)}};
  for (ArchiveFile& file : resources)
    files.push_back({kResources + file.name, std::move(file.bytes)});
  out.bytes = make_archive(files);
  out.model_name = car.name;
  out.token = unit.token;
  out.variables = second ? count_values(list) : list.size();
  for (const ArchiveFile& file : files) out.files.push_back(file.name);
}

}  // namespace

Exported export_unit(const ExportOptions& options) {
  vehicle::Vehicle car = vehicle::read_vehicle(options.vehicle_path);
  CarFolder folder = pack_car(car);
  Exported out;
  out.inputs = car.read_files;
  UnitFile unit;
  const auto text = [&](Text which) -> std::string& {
    return unit.texts[static_cast<std::size_t>(which)];
  };
  text(Text::kVehicle) = folder.vehicle;
  text(Text::kContact) = options.contact;
  text(Text::kIntegrator) = options.integrator;
  unit.numbers.push_back({"solver.step", options.step_s});

  std::vector<ArchiveFile> resources = std::move(folder.files);
  if (!options.setup_path.empty() || !options.settings.empty()) {
    text(Text::kSetup) = "setup.txt";
    resources.push_back({"setup.txt", one_sheet(options, car)});
    if (!options.setup_path.empty()) out.inputs.push_back(options.setup_path);
  }
  vehicle::check_car(car.files, car.parameters, car.terms);
  vehicle::check_step(car.parameters, {.step_s = options.step_s});

  if (!options.road_path.empty()) {
    const crg::Surface surface =
        vehicle::read_road(options.road_path, options.friction_path).surface;
    choose_start(car, surface, unit);
    text(Text::kRoad) = "road.crg";
    resources.push_back({"road.crg", road_bytes(options.road_path)});
    out.inputs.push_back(options.road_path);
    if (!options.friction_path.empty()) {
      text(Text::kFriction) = "friction.crg";
      resources.push_back({"friction.crg", road_bytes(options.friction_path)});
      out.inputs.push_back(options.friction_path);
    }
  } else if (!options.friction_path.empty()) {
    throw base::Error(options.friction_path + ": a friction map without a road; give --road");
  }

  pack(options, car, unit, std::move(resources), out);
  return out;
}

UnitInPlace unit_in_place(const ExportOptions& options) {
  const vehicle::Vehicle car = vehicle::read_vehicle(options.vehicle_path);
  vehicle::check_car(car.files, car.parameters, car.terms);
  vehicle::check_step(car.parameters, {.step_s = options.step_s});
  UnitFile unit;
  const auto name = [&](Text which, const std::string& path) {
    if (!path.empty()) unit.texts[static_cast<std::size_t>(which)] = fs::absolute(path).string();
  };
  name(Text::kVehicle, options.vehicle_path);
  name(Text::kRoad, options.road_path);
  name(Text::kFriction, options.friction_path);
  unit.texts[static_cast<std::size_t>(Text::kContact)] = options.contact;
  unit.texts[static_cast<std::size_t>(Text::kIntegrator)] = options.integrator;
  unit.numbers.push_back({"solver.step", options.step_s});
  if (!options.road_path.empty())
    choose_start(car, vehicle::read_road(options.road_path, options.friction_path).surface, unit);
  Description description = describe(options, unit, car);
  unit.token = description.token = token_of(model_description(description, options.version));
  return {model_description(description, options.version), format_unit_file(unit)};
}

}  // namespace fmu
