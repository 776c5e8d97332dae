// What a build did, in numbers: summary.json; how long it took: timing.json.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "inspect/input_file.h"
#include "inspect/sizes.h"
#include "inspect/validate.h"
#include "make/by_type.h"
#include "make/make_track.h"
#include "make/place.h"
#include "make/recipe.h"
#include "mesh/read_mesh.h"
#include "road/clean.h"
#include "road/friction.h"
#include "road/kerb.h"
#include "road/reference_line.h"
#include "road/road_edges.h"
#include "road/sample.h"
#include "road/smooth.h"

namespace road {

struct StageSeconds {
  std::string
      stage;  ///< "read", "clean", "centreline", "reference_line", "sample", "kerb",
              ///< "smooth", "patch", "friction", "doubt", "align", "picture", "write", "validate"
  double seconds = 0.0;
};

/// A finer road over one kerb.
struct PatchFile {
  std::string file;                                                       ///< beside the road
  double u_begin_m = 0.0, u_end_m = 0.0, v_begin_m = 0.0, v_end_m = 0.0;  ///< on the road
  double u_step_m = 0.0;
  double error_before_m = 0.0,
         error_m = 0.0;  ///< 95 % of |z - mesh| midway between rows, without and with it
};

std::string json_text(const GeoEnds& ends);

/// Everything that summary.json says. The stage reports are those of the stages, unchanged.
struct BuildSummary {
  Recipe recipe;  ///< written out key by key under "recipe"
  std::vector<InputFile> inputs;
  MeshReadReport read;
  CleanReport clean;
  CentrelineReport centreline;
  ReferenceLineReport reference_line;
  SampleReport sample;
  KerbReport kerb;
  SmoothReport smooth;
  std::vector<PatchFile> patches;
  std::string friction_file;  ///< beside the road; empty: none
  FrictionReport friction;
  ByType more;                         ///< what a stage has for itself, see src/stages
  std::optional<Placement> placement;  ///< empty: the file is in the mesh's own frame
  GridReport grid;                     ///< of the written file
  RoadEdges road_edges;                ///< of the grid's rows
  GeoEnds wgs84;                       ///< of the written file
  ValidateReport validate;
  std::vector<InputFile>
      outputs;  ///< role and name of each file beside summary.json, hash of its bytes
};

/// "crgbuild 1.2.3".
std::string program_name();

/// For $CT of a road file: the program and what went in, with each SHA-256. No date: the same
/// inputs give the same bytes. What a mesh refers to is in summary.json alone.
std::vector<std::string> source_lines(const std::vector<InputFile>& inputs);

/// JSON text, two spaces of indentation, keys in a fixed order (docs/formats.md). NaN becomes null.
/// The versions of the libraries are added here. The same bytes for the same inputs.
std::string summary_json(const BuildSummary& summary);

/// Seconds per stage and in total, and peak memory: what differs from run to run.
std::string timing_json(const std::vector<StageSeconds>& seconds, double seconds_total);

/// The objects under "smooth", "align" and "validation" in it, as the single stages print them.
std::string json_text(const SmoothReport& report, const SmoothOptions& options);
std::string json_text(const Placement& placement);
std::string json_text(const ValidateReport& report, const ValidateLimits& limits);

/// The text of the summary at `path` when it was written by this program from the inputs and the
/// recipe of `fresh`, and what its mesh refers to has not changed either. Nothing otherwise.
std::optional<std::string> unchanged_summary(const std::string& path, const BuildSummary& fresh);
/// The validation failures that a summary names.
std::vector<std::string> failures_in_summary(const std::string& summary_json);

/// What the build of a road says of it in the summary.json beside it.
struct BuiltBeside {
  RoadEdges edges;                    ///< of the file's rows, from node to node
  RoadEdges smooth;                   ///< straight over the metres between
  std::vector<std::string> failures;  ///< why it must not be used
  Published published;                ///< as its recipe says
};
/// Nothing where there is no such summary, or where it is that of another road.
BuiltBeside built_beside(const std::string& crg_path);

/// The same for a road from two edges.
struct EdgesSummary {
  EdgeRecipe recipe;
  std::vector<InputFile> inputs;
  EdgesReport edges;
  double line_length_m = 0.0;
  GridReport grid;
};
std::string edges_summary_json(const EdgesSummary& summary);

/// The recipe's, and room for the gaps that were bridged as it asks: there the file has heights and
/// the mesh has none.
ValidateLimits limits_of(const BuildSummary& summary);

/// Why the road must not be used, one sentence each; empty when validation passed.
std::vector<std::string> validation_failures(const ValidateReport& report,
                                             const ValidateLimits& limits = {});

/// Largest resident memory of this process so far, in MB (1e6 bytes).
double peak_memory_mb();

}  // namespace road
