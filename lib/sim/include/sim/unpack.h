// A Functional Mock-up Unit is a zip; what is needed of it, unpacked. The car of a vehicle file is
// a unit too: its binary is linked in.
#pragma once

#include <string>

#include "base/descriptor.h"

namespace sim {

/// A folder of its own below TMPDIR with the model description, the binaries of this platform and
/// the resources of a unit; it goes with this object. It is locked (flock): those of this user that
/// nobody locks, whose run was killed, are removed when another one is made.
class UnpackedUnit {
 public:
  /// Throws Error on what is no zip, holds names that lead out of the folder (absolute, "..", a
  /// backslash), a name twice, more than 20,000 files or more than 2 GB, and on damaged files.
  /// Of a vehicle file only what the car is told at its begin is there.
  explicit UnpackedUnit(const std::string& path, const std::string& road_path = {});
  UnpackedUnit(const UnpackedUnit&) = delete;
  UnpackedUnit& operator=(const UnpackedUnit&) = delete;
  ~UnpackedUnit();

  const std::string& folder() const { return folder_; }
  /// Of the unit, for messages.
  const std::string& path() const { return path_; }

 private:
  std::string path_, folder_;
  base::Descriptor lock_{-1};
};

/// By its name: .yaml or .yml.
bool is_vehicle_file(const std::string& path);

/// The model description in the zip alone, or of the car of a vehicle file on a road (none: the
/// level plane). Throws Error where there is none, or it is larger than 100 MB.
std::string model_description_of(const std::string& path, const std::string& road_path = {});

}  // namespace sim
