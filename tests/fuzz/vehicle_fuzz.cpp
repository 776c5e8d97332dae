// A car: parts of the input that begin with a line "@@ NAME" take the place of that file of the car
// that is shipped; before the first, of vehicle.yaml.
#include <cmath>
#include <map>

#include "base/error.h"
#include "fuzz/target.h"
#include "vehicle/vehicle_file.h"

namespace {

const std::map<std::string, std::string>& shipped() {
  static const std::map<std::string, std::string> files = [] {
    std::map<std::string, std::string> all;
    for (const auto& entry :
         std::filesystem::directory_iterator(KERBSTONE_SOURCE "/vehicles/open_wheel")) {
      std::ifstream file(entry.path(), std::ios::binary);
      const std::string name = entry.path().filename().string();
      all[name] = std::string(std::istreambuf_iterator<char>(file), {});
      fuzz::folder().put(name, all[name]);
    }
    return all;
  }();
  return files;
}

}  // namespace

void fuzz::run(std::string_view bytes) {
  std::vector<std::string> replaced;
  std::string name = "vehicle.yaml";
  for (std::string_view rest = bytes; !rest.empty();) {
    if (rest.starts_with("@@ ")) {
      const std::size_t end = std::min(rest.find('\n'), rest.size());
      name = rest.substr(3, end - 3);
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    const std::size_t next = std::min(rest.find("\n@@ "), rest.size());
    if (shipped().contains(name)) {
      folder().put(name, rest.substr(0, next));
      replaced.push_back(name);
    }
    rest.remove_prefix(std::min(next + 1, rest.size()));
  }
  try {
    const vehicle::Vehicle car = vehicle::read_vehicle(folder() / "vehicle.yaml");
    for (const double value : car.parameters.value)
      require(std::isfinite(value), "finite parameters");
  } catch (const base::Error& error) {
    require_refusal(error, folder() / "");
  }
  for (const std::string& file : replaced) folder().put(file, shipped().at(file));
}
