#include "fmu/loaded_files.h"

#include <fmt/format.h>

#include <filesystem>

#include "base/error.h"
#include "text_place.h"
#include "vehicle/road_file.h"

namespace fmu {
namespace {

/// A path that does not begin with / lies in the folder.
std::string in_folder(const std::string& folder, const std::string& path) {
  return (std::filesystem::path(folder) / path).string();
}

vehicle::Integrator integrator_of(const std::string& word) {
  if (word.empty() || word == "semi-implicit") return vehicle::Integrator::kSemiImplicit;
  if (word == "explicit") return vehicle::Integrator::kExplicitEuler;
  throw base::Error(fmt::format("integrator = '{}', wanted semi-implicit or explicit", word));
}

void apply_contact(vehicle::Vehicle& vehicle, const std::string& word) {
  if (word.empty()) return;
  if (word == "single-point")
    vehicle.contact = vehicle::Contact::kSinglePoint;
  else if (word == "four-point")
    vehicle.contact = vehicle::Contact::kFourPoint;
  else if (word == "strip")
    vehicle.contact = vehicle::Contact::kStrip;
  else
    throw base::Error(
        fmt::format("contact = '{}', wanted single-point, four-point or strip", word));
}

}  // namespace

std::shared_ptr<const LoadedFiles> load_files(const Texts& texts, const std::string& resources) {
  auto files = std::make_shared<LoadedFiles>();
  files->texts = texts;
  const std::string& own = texts[place(Text::kResources)];
  const std::string folder = own.empty() ? resources : own;
  const auto path = [&](Text text) {
    const std::string& name = texts[place(text)];
    return name.empty() ? name : in_folder(folder, name);
  };
  if (texts[place(Text::kVehicle)].empty())
    throw base::Error("vehicle is empty; wanted the vehicle.yaml of a car");
  files->vehicle = vehicle::read_vehicle(path(Text::kVehicle));
  if (const std::string setup = path(Text::kSetup); !setup.empty())
    vehicle::read_setup(files->vehicle, setup);
  apply_contact(files->vehicle, texts[place(Text::kContact)]);
  files->integrator = integrator_of(texts[place(Text::kIntegrator)]);
  if (const std::string road = path(Text::kRoad); !road.empty()) {
    files->surface = vehicle::read_road(road, path(Text::kFriction)).surface;
    files->road = vehicle::Road(*files->surface);
  } else if (!texts[place(Text::kFriction)].empty()) {
    throw base::Error("friction is given, but no road that it lies on");
  }
  return files;
}

}  // namespace fmu
