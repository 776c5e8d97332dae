// A Functional Mock-up Unit is a zip; what is needed of it, unpacked.
#pragma once

#include <string>

namespace sim {

/// A folder of its own below TMPDIR with the model description, the binaries of this platform and
/// the resources of a unit; it goes with this object.
class UnpackedUnit {
 public:
  /// Throws Error on what is no zip, holds names that lead out of the folder (absolute, "..", a
  /// backslash), a name twice, more than 20,000 files or more than 2 GB, and on damaged files.
  explicit UnpackedUnit(const std::string& path);
  UnpackedUnit(const UnpackedUnit&) = delete;
  UnpackedUnit& operator=(const UnpackedUnit&) = delete;
  ~UnpackedUnit();

  const std::string& folder() const { return folder_; }
  /// Of the unit, for messages.
  const std::string& path() const { return path_; }

 private:
  std::string path_, folder_;
};

/// The model description in the zip alone. Throws Error where there is none, or it is larger than
/// 100 MB.
std::string model_description_of(const std::string& path);

}  // namespace sim
