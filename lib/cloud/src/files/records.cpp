#include "records.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "cloud/error.h"
#include "text_records.h"

namespace cloud {
namespace {

constexpr const char* kProject =
    "project the points first, as with 'pdal translate in.las out.las reprojection "
    "--filters.reprojection.out_srs=EPSG:32632' (the UTM zone of the place)";

}  // namespace

void refuse_degrees(const std::string& seen) {
  throw Error(fmt::format("the coordinates {}, metres or feet wanted; {}", seen, kProject));
}

void refuse_angle(const std::string& name, const std::string& column) {
  throw Error(
      fmt::format("{}: column {} seen, x, y and z in metres wanted; {}", name, column, kProject));
}

void require_xyz(const std::vector<Role>& roles, const std::string& name) {
  for (const Role role : {Role::x, Role::y, Role::z})
    if (std::count(roles.begin(), roles.end(), role) != 1)
      throw Error(fmt::format("{}: {} fields {} seen, one wanted", name,
                              std::count(roles.begin(), roles.end(), role),
                              "xyz"[static_cast<int>(role)]));
}

void add_origin(const std::vector<std::string>& words, Records& records) {
  for (std::size_t k = 0; k + 3 < words.size(); ++k) {
    if (words[k] != "origin_m") continue;
    double origin[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string& word = words[k + 1 + axis];
      const char* at = word.data();
      if (!number_at(at, word.data() + word.size(), origin[axis]) ||
          !(std::abs(origin[axis]) < 1e8))
        return;
    }
    for (Field& field : records.fields)
      if (field.role <= Role::z) field.add = origin[static_cast<std::size_t>(field.role)];
    return;
  }
}

std::size_t size_of(FieldType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

Role role_of(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (name.starts_with("scalar_")) name.erase(0, 7);  // so CloudCompare calls what is no coordinate
  if (name == "x" || name == "x_m") return Role::x;
  if (name == "y" || name == "y_m") return Role::y;
  if (name == "z" || name == "z_m") return Role::z;
  if (name == "time" || name == "time_s" || name == "t" || name == "gps_time" ||
      name == "gpstime" || name == "timestamp")
    return Role::time;
  if (name == "intensity" || name == "i" || name == "reflectance") return Role::intensity;
  if (name == "classification") return Role::classification;
  if (name == "class" || name == "label") return Role::label;
  if (name == "sigma" || name == "sigma_m" || name == "stddev_m") return Role::sigma;
  if (name == "withheld") return Role::withheld;
  if (name == "synthetic") return Role::synthetic;
  if (name == "overlap") return Role::overlap;
  std::erase_if(name, [](char c) { return c == '_' || c == ' '; });
  if (name == "returnnumber") return Role::return_number;
  if (name == "numberofreturns") return Role::returns;
  return Role::none;
}

}  // namespace cloud
