// What the commands that fit a drive by its windows have in common: reading and telling.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "commands.h"
#include "crg/surface.h"
#include "identify/drive_windows.h"
#include "identify/mass_fit.h"
#include "vehicle/vehicle_file.h"

namespace crgidentify {

/// A log, its car and its road as they were read. Not to be moved: the car points into it.
struct ReadDrive {
  explicit ReadDrive(const DriveCommand& command);
  vehicle::Vehicle vehicle;
  vehicle::Car<double> car;
  std::optional<crg::Surface> road;
  recording::Recording recording;
  identify::DriveWindowsOptions options;
  double fuel_kg = 0.0;
  std::string fuel_from;  ///< in words

  identify::DriveWindows windows() const;
};

/// The fit of the loads; nothing where there are none, or where they do not tell. What makes it
/// doubtful joins the doubts of the windows: all fits lean on the loads.
std::optional<identify::DriveFit> mass_where_seen(const ReadDrive& drive,
                                                  identify::DriveWindows& windows);

/// A fit's options with fuel, axes and, where wheel loads tell it, the mass.
template <class Options>
Options options_of(const ReadDrive& drive, identify::DriveWindows& windows) {
  Options out;
  out.fuel_kg = drive.fuel_kg;
  out.body_axes = drive.options.body_axes;
  if (const auto weighed = mass_where_seen(drive, windows)) {
    out.mass_kg = weighed->at("mass_kg").value;
    out.mass_sd_kg = weighed->at("mass_kg").sd;
  }
  return out;
}

/// The first lines of a sheet: log, its sum, fuel.
std::string drive_header(const DriveCommand& command, const ReadDrive& drive,
                         const std::string& what);
/// Windows, numbers and remarks of a fit, as text and as JSON.
std::string drive_text(const identify::DriveWindows& windows, const identify::DriveFit& fit);
nlohmann::ordered_json drive_json(const identify::DriveWindows& windows,
                                  const identify::DriveFit& fit);

/// Of the windows and of a fit.
std::vector<std::string> all_doubts(const identify::DriveWindows& windows,
                                    const identify::DriveFit& fit);
/// Whether a file is asked for and nothing speaks against it; says so where something does.
bool may_write(const std::vector<std::string>& doubts, const std::string& path, Terminal& terminal);

/// What a command tells beside its numbers, behind them.
struct Beside {
  std::string text, key;
  nlohmann::ordered_json json;
};

/// Prints the fit as a table behind the sheet, or as JSON; writes the sheet where -o names a file
/// and there is no doubt.
/// Returns the exit code.
int tell(const DriveCommand& command, const ReadDrive& drive, const identify::DriveWindows& windows,
         identify::DriveFit fit, const std::string& what, const std::string& lines,
         Terminal& terminal, const Beside& beside = {});

}  // namespace crgidentify
