// Finer roads laid over a road: kerbs, repairs, joints, each a standard file of its own.
#pragma once

#include <string>
#include <vector>

#include "crg/surface.h"

namespace crg {

/// What an index file names. Its lines: "base FILE", "patch FILE blend_m=0.2"; "#" begins a
/// comment; paths without blanks, relative to the index file.
struct PatchIndex {
  struct Entry {
    std::string path = {};
    double blend_m = 0.1;
  };
  std::string base_path;
  std::vector<Entry> patches;
};

/// Throws Error with file:line.
PatchIndex read_patch_index(const std::string& path);

/// A surface of which other surfaces replace parts. Inside its grid a patch counts fully from
/// blend_m off its border on, and passes smoothly into what lies below it before; where it has no
/// height it does not count. Later patches lie over earlier ones. Immutable and shared like
/// Surface.
class PatchedSurface {
 public:
  struct Patch {
    Surface surface;
    double blend_m = 0.1;  ///< > 0; at most half the patch's width makes sense
  };

  /// Throws Error for a blend that is not positive.
  PatchedSurface(Surface base, std::vector<Patch> patches);
  /// Reads the index and the files it names.
  explicit PatchedSurface(const PatchIndex& index);

  /// u, v, heading, curvature and friction are the base's; height, gradient and normal those of the
  /// stack. The gradient in the blended border takes the patch's line as straight between its rows.
  Sample at_xy(double x_m, double y_m, Cursor& cursor) const noexcept;
  double z_at_xy(double x_m, double y_m, Cursor& cursor) const noexcept;

  const Surface& base() const noexcept { return base_; }

 private:
  struct Box {
    double x_min_m, x_max_m, y_min_m, y_max_m;
  };
  Surface base_;
  std::vector<Patch> patches_;
  std::vector<Box> boxes_;  ///< of the nodes at the sides of each patch
};

}  // namespace crg
