// What findings about the car mean in the words of a vehicle folder.
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>

#include "base/read_file.h"
#include "car_changes.h"
#include "explain/write_back.h"
#include "mechanism.h"
#include "vehicle/error.h"

namespace explain {
namespace {

using P = vehicle::Parameter;

void add_finding(CarChanges& out, const Finding& f) {
  if (f.parameters.empty()) return;
  const Mechanism* const m = find_mechanism(f.mechanism);
  if (m != nullptr && m->write_car != nullptr) return m->write_car(out, f);
  if (f.kind != "vehicle" && f.kind != "environment") return;
  const FoundParameter& p = f.parameters[0];
  out.remarks.push_back(fmt::format("{}: {} = {:.5g} {}; a vehicle file has nothing that holds it",
                                    f.mechanism, p.name, p.value, p.unit));
}

CarChanges changes_of(const vehicle::Vehicle& car, const Findings& findings,
                      const std::vector<Signals>& logs) {
  CarChanges out{car, logs};
  for (const Turn turn : {Turn::kFirst, Turn::kUsual, Turn::kLast})
    for (const Finding& f : findings.findings)
      if (turn_of(f) == turn) add_finding(out, f);
  return out;
}

/// Keeps what a map at the key says about prior and source.
void write_value(YAML::Node root, const std::string& name, double value) {
  if (root["parameters"] && root["parameters"][name] && root["parameters"][name].IsMap())
    root["parameters"][name]["value"] = value;
  else
    root["parameters"][name] = value;
}

/// Paths of files that stay are made absolute.
void make_paths_absolute(YAML::Node root, const std::string& vehicle_path) {
  const std::filesystem::path folder = std::filesystem::absolute(vehicle_path).parent_path();
  for (const char* section : {"tyres", "maps"}) {
    if (!root[section]) continue;
    for (auto entry : root[section])
      if (const auto key = entry.first.as<std::string>(); key != "alpha" && key != "fx_arm")
        entry.second = (folder / entry.second.as<std::string>()).lexically_normal().string();
  }
}

void write_tyres(YAML::Node root, const CarChanges& changes, CorrectedCar& out) {
  for (std::size_t k = 0; k < 2; ++k) {
    if (changes.tyre[k].empty()) continue;
    const char *axle = k == 0 ? "front" : "rear", *file = k == 0 ? "front.tir" : "rear.tir";
    const std::string stated =
        base::read_file(root["tyres"][axle].as<std::string>(), vehicle::kLargestTyreBytes);
    out.files.emplace_back(file, vehicle::with_tyre_values(stated, changes.tyre[k]));
    root["tyres"][axle] = file;
  }
}

void write_maps(YAML::Node root, const CarChanges& changes, bool refitted, CorrectedCar& out) {
  for (const auto& [name, map] : changes.maps) {
    const bool engine = name == "engine_torque_nm";
    const std::string file = engine ? "engine.csv" : name.substr(0, name.find("_factor")) + ".csv";
    if (!engine || !refitted)
      out.files.emplace_back(
          file, map_csv(map, engine ? "engine_radps:throttle" : "ride_front_m:ride_rear_m"));
    root["maps"][name] = file;
  }
}

void write_refit(YAML::Node root, const RefittedCar& refit, CarChanges& changes,
                 CorrectedCar& out) {
  out.files.emplace_back("engine.csv", map_csv(refit.engine_torque_nm, "engine_radps:throttle"));
  root["maps"]["engine_torque_nm"] = "engine.csv";
  for (const P p : refit.changed)
    if (refit.parameters[p] != changes.car.parameters[p]) changes.set(p, refit.parameters[p]);
  changes.remarks.push_back(
      "engine map, drag, brakes, tyre stiffness, grip and gear shift are refitted together with "
      "what was found.");
}

/// A setup sheet is read after the parameters and would undo them: its values move into the file.
void take_in_setup(YAML::Node root, const vehicle::Vehicle& car) {
  if (!root["setup"]) return;
  for (std::size_t k = 0; k < vehicle::kParameterCount; ++k)
    if (car.stated[k])
      write_value(root, std::string(vehicle::parameter_list()[k].name), car.parameters.value[k]);
  for (std::size_t k = 0; k < vehicle::kTermCount; ++k)
    if (car.terms.value[k] != vehicle::default_amplitudes().value[k])
      root["terms"][std::string(vehicle::term_list()[k].name)] = car.terms.value[k];
  root.remove("setup");
}

/// Held to what a vehicle file may hold; where that is less, a remark.
void write_parameters(YAML::Node root, CarChanges& changes) {
  for (const auto& [name, value] : changes.parameters) {
    const auto p = vehicle::find_parameter(name);
    if (!p) throw vehicle::Error(name + ": found, but no parameter of a vehicle file");
    const vehicle::ParameterInfo& info = vehicle::parameter_list()[static_cast<std::size_t>(*p)];
    const double held = std::clamp(value, info.low, info.high);
    if (held != value)
      changes.remarks.push_back(
          fmt::format("{}: found {:.5g} {}; a vehicle file holds {:g} to {:g}", name, value,
                      info.unit, info.low, info.high));
    write_value(root, name, held);
  }
}

}  // namespace

std::string map_csv(const vehicle::Map2& map, const std::string& axes) {
  std::string out = axes;
  for (const double y : map.y) out += fmt::format(",{:.9g}", y);
  for (std::size_t i = 0; i < map.x.size(); ++i) {
    out += fmt::format("\n{:.9g}", map.x[i]);
    for (std::size_t j = 0; j < map.y.size(); ++j)
      out += fmt::format(",{:.9g}", map.z[i * map.y.size() + j]);
  }
  return out + "\n";
}

std::optional<CorrectedCar> corrected_vehicle(const std::string& vehicle_path,
                                              const vehicle::Vehicle& car, const Findings& findings,
                                              const std::vector<Signals>& logs,
                                              const RefittedCar* refit) {
  if (findings.doubtful_car) return std::nullopt;
  CarChanges changes = changes_of(car, findings, logs);
  if (changes.none()) return std::nullopt;

  CorrectedCar out;
  out.fuel_kg = changes.fuel_kg;
  YAML::Node root = YAML::LoadFile(vehicle_path);
  if (changes.strip) root["contact"] = "strip";
  make_paths_absolute(root, vehicle_path);
  write_tyres(root, changes, out);
  write_maps(root, changes, refit != nullptr, out);
  if (refit != nullptr) write_refit(root, *refit, changes, out);
  take_in_setup(root, car);
  write_parameters(root, changes);
  for (const auto& [name, value] : changes.terms) root["terms"][name] = value;

  YAML::Emitter yaml;
  yaml.SetDoublePrecision(9);
  yaml << root;
  out.vehicle_yaml = "# Corrected by crgexplain; see findings.json.\n";
  for (const std::string& remark : changes.remarks) out.vehicle_yaml += "# " + remark + "\n";
  out.vehicle_yaml += yaml.c_str() + std::string("\n");
  return out;
}

}  // namespace explain
