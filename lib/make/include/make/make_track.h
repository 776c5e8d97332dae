// The main path: mesh in, checked CRG out.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/progress.h"
#include "crg/file.h"
#include "make/recipe.h"
#include "mesh/mesh.h"
#include "road/edges.h"
#include "road/road_edges.h"
#include "road/sample.h"

namespace base {
class OutputSet;
}

namespace road {

using base::Progress;

struct BuildResult {
  std::string crg_path, stl_path, centreline_path, summary_path, picture_path;
  std::string classes_path;   ///< plan of the mesh in the colours of its classes; its world file
                              ///< (.pgw) beside it
  std::string friction_path;  ///< empty without a friction map
  std::string patches_path;   ///< index of the road and its patches; empty without patches
  std::string summary_json;   ///< the text written to summary_path
  std::string timing_path;    ///< seconds and memory, which differ from run to run
  std::string timing_json;    ///< the text in it; empty when a reused build has none any more
  std::vector<std::string>
      kept;                   ///< names of files of an earlier build that belong to this one too
  bool reused = false;        ///< nothing had changed since the build that wrote these files
  bool clean_reused = false;  ///< nor had the mesh since it was cleaned last
  std::vector<std::string>
      validation_failures;  ///< why the road must not be used; empty = validation passed
};

/// What a report shows beyond the written file (ReportRequest takes each as it is).
struct BuildEvidence {
  Mesh mesh;                           ///< as read, in metres
  std::vector<Provenance> provenance;  ///< per node of the file
  std::optional<crg::Crg>
      before;  ///< before kerb refinement and smoothing; none above kMaxBeforeNodes
  std::array<double, 3>
      road_width_m{};       ///< between the borders of the road: least, median, largest
  std::vector<Kerb> kerbs;  ///< on the mesh
  RoadEdges edges;          ///< of the rows of the file
  ValidateReport validate;
  ValidateLimits limits;
};
constexpr std::size_t kMaxBeforeNodes = 40'000'000;  ///< 160 MB

/// What an earlier build in the same folder is good for.
enum class Reuse {
  nothing,
  /// Cleaning, which takes most of the time of large meshes: from 50,000 triangles on its result
  /// lies in <name>.clean.cache and is taken when the program, the mesh (by hash) and what is said
  /// of reading and cleaning are the same. The other stages take less time than reading their
  /// result would.
  stages,
  /// Everything as well: nothing is built (and no evidence filled) when the files that lie there
  /// were written by the same program with the same recipe from the same inputs (by hash; also what
  /// the mesh refers to, and what it refers to and lacks), and are still what their manifest says.
  /// Where evidence is wanted, the report has to be among them.
  everything,
};

/// Runs every stage and writes <name>.crg, <name>.stl, centreline.csv, summary.json, timing.json,
/// <name>.png and <name>.classes.png
/// (.pgw) into `output_dir` (made if missing). All of them appear together or not at all
/// (base/output_set.h). Fills `evidence` where given. Throws Error, also when another process
/// writes into the folder.
BuildResult make_track(const Recipe& recipe, const std::string& output_dir,
                       const Progress& progress = {}, BuildEvidence* evidence = nullptr,
                       Reuse reuse = Reuse::nothing);

/// The same for a caller that adds files to the set (a report) and then calls commit_build(), which
/// has nothing to do for a build that is reused. The paths in the result are those after that.
BuildResult make_track(const Recipe& recipe, base::OutputSet& outputs,
                       const Progress& progress = {}, BuildEvidence* evidence = nullptr,
                       Reuse reuse = Reuse::nothing);
void commit_build(const Recipe& recipe, const BuildResult& result, base::OutputSet& outputs);
/// What the lock of the folder and its manifest say.
constexpr const char* kBuildCommand = "crgbuild build";

/// Two surveyed edges in place of a mesh.
struct EdgeRecipe {
  std::string left_path, right_path;
  std::string name;        ///< DIR/<name>.crg
  bool keep_open = false;  ///< although both edges come round to their start
  EdgeOptions options;
  crg::Format format = crg::Format::KRBI;
  unsigned threads = 0;
};

/// What the names of both files share at their beginning: circuit_a_left.csv and
/// circuit_a_right.csv give circuit_a; "road" when they share nothing.
std::string name_of_edges(const std::string& left_path, const std::string& right_path);

/// road_between_edges() from file to file: writes <name>.crg, centreline.csv, summary.json,
/// timing.json and <name>.png, together or not at all; stl_path and validation_failures stay empty.
BuildResult make_from_edges(const EdgeRecipe& recipe, const std::string& output_dir,
                            const Progress& progress = {});

}  // namespace road
