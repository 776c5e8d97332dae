// A road as the stages make it from a recipe, and how it is written.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/output_set.h"
#include "base/progress.h"
#include "crg/grid.h"
#include "crg/reference_line.h"
#include "make/make_track.h"
#include "make/recipe.h"
#include "make/summary.h"
#include "mesh/mesh.h"
#include "road/centreline.h"
#include "road/patch.h"
#include "road/road_edges.h"
#include "road/sample.h"

namespace road {

/// Nothing of it is written yet.
struct MadeRoad {
  Mesh mesh;  ///< as read, in metres; tilted and scaled where the recipe says so
  RoadMesh road;
  Centreline centreline;    ///< in the frame of the mesh, as are road and mesh
  crg::ReferenceLine line;  ///< where the recipe puts it on the Earth
  SampledGrid sampled;
  RoadEdges edges;                  ///< of its rows; empty for a stretch
  std::optional<crg::Grid> before;  ///< before kerb refinement and smoothing, where it was wanted
  std::vector<KerbPatch> patches;
  std::optional<crg::Grid> friction;
  /// Of every node, what a stage added to the height of the mesh because the recipe asks for it;
  /// empty: nothing. The check of the written file leaves it out.
  std::vector<float> added_m;
  std::vector<std::string> doubts;  ///< whether this is the road that is meant (doubts_about())
  BuildSummary summary;             ///< what the stages said; its outputs are those of write()
  std::vector<StageSeconds> seconds;
  bool clean_reused = false;  ///< the mesh had been cleaned before
};

struct MakeOptions {
  base::Progress progress;
  std::string question_path;      ///< of the picture, where it cannot be told which road is meant
  std::string clean_cache_path;   ///< of the mesh as it was cleaned before; empty: clean it again
  std::string clean_staged_path;  ///< where a cleaned mesh is kept that took long; empty: nowhere
  bool keep_before = false;
  std::optional<URange> stretch;  ///< this alone (rows_between()); nobody doubts its road
};

/// Where a build keeps the mesh as it was cleaned, in its folder.
std::string clean_cache_name(const Recipe& recipe);

/// Runs the stages. `inputs` are the files that the recipe names (inputs_of()). Throws Error, and
/// Question where more than one road could be meant.
MadeRoad make_road(const Recipe& recipe, const std::vector<InputFile>& inputs,
                   const MakeOptions& options);

/// Role, path and SHA-256 of the files that the recipe names. Throws Error where one is missing.
std::vector<InputFile> inputs_of(const Recipe& recipe);

/// Writes all files of a track but the reports' into the set (make_track()) and checks the road by
/// reading it back (summary.validate). Takes the grids out of `built`. The paths are those after
/// the commit.
BuildResult write(MadeRoad& built, base::OutputSet& outputs, const base::Progress& progress = {});

}  // namespace road
