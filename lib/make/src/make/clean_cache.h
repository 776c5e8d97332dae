// The result of cleaning, kept beside the road so that a later build of the same mesh need not
// clean again. Private.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "make/recipe.h"
#include "make/summary.h"

namespace road {

/// Everything that cleaning depends on, as text: program, bytes of the mesh and of what it refers
/// to (by hash), how it is read, tilted, scaled and cleaned, and the guide.
std::string clean_key(const Recipe& recipe, const std::optional<Guide>& guide,
                      const TiltAndScale& tilt_and_scale, const std::string& program,
                      const std::vector<InputFile>& mesh_files);

struct Cleaned {
  RoadMesh road;
  CleanReport report;
};

/// Bit for bit what was cleaned, behind its key.
void write_clean_cache(const Cleaned& cleaned, const std::string& key, const std::string& path);

/// Nothing when there is no such file, when it has another key, or when it is damaged in any way.
std::optional<Cleaned> read_clean_cache(const std::string& key, const std::string& path);

}  // namespace road
