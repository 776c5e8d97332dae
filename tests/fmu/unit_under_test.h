// A unit of the shipped car, unpacked into a folder, and what the standard's importers do with one.
#pragma once

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <minizip/unzip.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <string>

#include "base/error.h"
#include "crg/file.h"
#include "fmu/export_unit.h"
#include "fmu/unit_file.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace fmu_tests {

/// Every file of a zip. Read with minizip's own unpacking.
inline std::map<std::string, std::string> unpacked(const std::string& path) {
  std::map<std::string, std::string> out;
  const unzFile zip = unzOpen64(path.c_str());
  EXPECT_NE(zip, nullptr) << path;
  if (zip == nullptr) return out;
  for (int code = unzGoToFirstFile(zip); code == UNZ_OK; code = unzGoToNextFile(zip)) {
    unz_file_info64 info{};
    char name[1000];
    EXPECT_EQ(unzGetCurrentFileInfo64(zip, &info, name, sizeof name, nullptr, 0, nullptr, 0),
              UNZ_OK);
    std::string bytes(info.uncompressed_size, '\0');
    EXPECT_EQ(unzOpenCurrentFile(zip), UNZ_OK);
    EXPECT_EQ(unzReadCurrentFile(zip, bytes.data(), static_cast<unsigned>(bytes.size())),
              static_cast<int>(bytes.size()));
    EXPECT_EQ(unzCloseCurrentFile(zip), UNZ_OK);  // its checksum
    out[name] = bytes;
  }
  unzClose(zip);
  return out;
}

/// A banked, wavy circle of 60 m radius, 12 m wide, closed.
inline crg::Crg wavy_circle() {
  constexpr int kSteps = 754;
  crg::ReferenceLine line;
  line.u_step_m = 0.5;
  line.closed = true;
  crg::Grid grid;
  grid.u_step_m = 0.5;
  for (int j = -12; j <= 12; ++j) grid.v_m.push_back(0.5 * j);
  double x = 0.0, y = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    line.x_m.push_back(x);
    line.y_m.push_back(y);
    line.heading_rad.push_back(2.0 * std::numbers::pi * std::max(0.0, i - 0.5) / kSteps);
    const double next = 2.0 * std::numbers::pi * (i + 0.5) / kSteps;
    x += 0.5 * std::cos(next);
    y += 0.5 * std::sin(next);
    for (int j = -12; j <= 12; ++j)
      grid.z_m.push_back(static_cast<float>(
          0.05 * std::sin(2.0 * std::numbers::pi * 12.0 * i / kSteps) - 0.02 * 0.5 * j));
  }
  return crg::make_crg(line, grid);
}

/// Unpacked below a folder of its own.
class Unit {
 public:
  explicit Unit(fmu::Version version = fmu::Version::kFmi2, bool road = true) {
    crg::write(wavy_circle(), folder_.path("circle.crg"), crg::Format::KRBI);
    fmu::ExportOptions options;
    options.vehicle_path = places::source() + "/vehicles/open_wheel/vehicle.yaml";
    if (road) options.road_path = folder_.path("circle.crg");
    options.binary_path = places::kerbstone_car();
    options.generation_tool = "a test";
    options.version = version;
    exported_ = fmu::export_unit(options);
    folder_.file("car.fmu", exported_.bytes);
    files_ = unpacked(folder_.path("car.fmu"));
    for (const auto& [name, bytes] : files_) {
      std::filesystem::create_directories(
          std::filesystem::path(folder_.path("unit/" + name)).parent_path());
      folder_.file("unit/" + name, bytes);
    }
  }
  std::string resources() const { return folder_.path("unit/resources"); }
  const std::string& token() const { return exported_.token; }
  const fmu::Exported& exported() const { return exported_; }
  const std::map<std::string, std::string>& files() const { return files_; }
  const support::TemporaryFolder& folder() const { return folder_; }

 private:
  support::TemporaryFolder folder_;
  fmu::Exported exported_;
  std::map<std::string, std::string> files_;
};

/// Reference of the value with this name, FMI 2.
inline std::uint32_t reference_of(const std::string& name) {
  static const std::map<std::string, std::uint32_t> all = [] {
    std::map<std::string, std::uint32_t> out;
    for (const fmu::Variable& v : fmu::variables())
      for (std::size_t i = 0; i < v.size; ++i)
        out[fmu::value_name(v, i)] = static_cast<std::uint32_t>(v.reference + i);
    return out;
  }();
  return all.at(name);
}

}  // namespace fmu_tests
