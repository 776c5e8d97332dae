// Parts of a car from one recorded drive, from files to numbers: what the commands mass, aero,
// suspension, brakes and engine of crgidentify do before they print.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "crg/surface.h"
#include "identify/drive_fits.h"
#include "vehicle/vehicle_file.h"

namespace identify {

/// What is on board where neither the log nor the request says it.
inline constexpr double kAssumedFuel_kg = 30.0;

struct MeasureRequest {
  std::string recording_path, vehicle_path, setup_path, road_path, mapping_path;
  std::vector<std::string> settings;                    ///< name=value
  bool body_axes = true;                                ///< accelerometers tilt with the body
  std::optional<double> fuel_kg;                        ///< none: kAssumedFuel_kg
  std::vector<std::pair<double, double>> engine_off_s;  ///< aero only: from, to
};

enum class FuelFrom { kAssumed, kRequest, kLog };

/// A log, its car and its road as they were read. Not to be moved: the car points into it.
struct ReadDrive {
  /// Throws base::Error on files that cannot be read.
  explicit ReadDrive(const MeasureRequest& request);
  ReadDrive(const ReadDrive&) = delete;
  ReadDrive& operator=(const ReadDrive&) = delete;

  MeasureRequest request;
  vehicle::Vehicle vehicle;
  vehicle::Car<double> car;
  std::optional<crg::Surface> road;
  recording::Recording recording;
  DriveWindowsOptions options;
  double fuel_kg = 0.0;
  FuelFrom fuel_from = FuelFrom::kAssumed;
};

/// One part, measured. The numbers stand in `fit`.
struct Measured {
  DriveWindows windows;
  DriveFit fit;                     ///< its doubts are those of the windows too
  std::string sheet;                ///< lines of a setup sheet; engine: none
  std::string discs_sheet;          ///< brakes only, behind them
  std::optional<PadMapFit> pads;    ///< brakes only
  std::optional<EngineFit> engine;  ///< engine only: its map
};

/// The recording with empty cells filled where the channel's own samples before and behind are at
/// most `longest_s` apart and no gap of the rows lies between: by the straight line, the gear as
/// before. Longer gaps stay empty.
recording::Recording without_short_gaps(recording::Recording recording, double longest_s = 0.25);

inline constexpr const char* kMeasuredParts[] = {"mass", "aero", "suspension", "brakes", "engine"};

/// Throws base::Error, with the log's name, where channels are missing or the drive tells nothing,
/// and for another part.
Measured measure(const std::string& part, const ReadDrive& drive);

}  // namespace identify
