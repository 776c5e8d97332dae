// The validation report of a road file: every number computed once, then report.json and
// report.html.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "crg/file.h"
#include "inspect/findings.h"
#include "inspect/validate.h"
#include "mesh/mesh.h"
#include "mesh/read_mesh.h"
#include "road/align.h"
#include "road/kerb.h"
#include "road/sample.h"

namespace report {
struct TrackReport;
}

namespace road {

/// A file that went into the road, besides those that the report reads itself.
struct ReportSource {
  std::string role, path, sha256;
};

/// What is published of a road, to be compared with it, and of the mesh that it was made of.
struct Published {
  std::optional<double> length_m;  ///< of the line
  std::optional<double> climb_m;   ///< from its lowest to its highest point
  std::optional<double> width_m;   ///< of the road, its median
  std::optional<std::string> source;
  std::optional<std::string> mesh;  ///< whose it is, of what date, under which licence
};

/// What to report on. Pointers are looked at, not kept; everything but crg_path may stay empty.
struct ReportRequest {
  std::string crg_path;
  std::string shown_folder;    ///< where crg_path, and what lies beside it, will be when the report
                               ///< is read; empty: where they are
  std::string title;           ///< empty: the file's name
  std::string mesh_path;       ///< the mesh that the road should follow
  const Mesh* mesh = nullptr;  ///< the same, already read; mesh_path then only names it
  MeshReadOptions read;        ///< how to read mesh_path
  std::vector<ControlPoint>
      control_points;             ///< fitted: residuals on the plan, and where the mesh lies
  AlignOptions align;             ///< how; a mesh already read is tilted and scaled already
  RotoTranslation T_global_mesh;  ///< where the mesh lies, when there are no control points
  ValidateOptions validate;       ///< how to compare with the mesh; where it lies is set here
  ValidateLimits limits;          ///< of what is compared with the mesh
  std::optional<ValidateReport> validated;  ///< what validate() said; asked here when empty
  std::optional<std::vector<Kerb>>
      kerbs;  ///< as found on the mesh; when empty they are found by the shape of the road
  std::optional<std::array<double, 3>>
      road_width_m;       ///< between the borders of the road: least, median, largest
  std::string mesh_unit;  ///< of `mesh`: "m"; with what it would be in feet where nobody stated it
  std::string mesh_up;    ///< of `mesh`: "-z, from the faces of 14,210 triangles"; empty: not told
  std::string against_path;  ///< another road file
  std::string
      cloud_path;  ///< measured points: names those in cloud_points_m; its files belong in sources
  std::span<const Eigen::Vector3d>
      cloud_points_m;                ///< in the map frame; those far from the road do no harm
  std::string before_path;           ///< the same road before smoothing and kerb refinement
  const crg::Crg* before = nullptr;  ///< the same, in memory
  std::string grip_path;             ///< a road file that holds friction in place of heights
  Published published;
  RoadEdges edges;  ///< of the rows of the file; empty: all of it is judged as road
  const std::vector<Provenance>* provenance = nullptr;  ///< per node of the file
  std::vector<ReportSource> sources;
  std::vector<std::string> remarks;   ///< of the build that made the road: shown among the notes
  std::vector<std::string> failures;  ///< why that build says that the road must not be used: each
                                      ///< is an error of the report
  std::string command_line;           ///< that makes the road, or this report, again
  unsigned threads = 0;               ///< 0 = all cores; any number gives the same bytes
};

/// Reads the files and computes everything. Throws Error, crg::Error.
report::TrackReport make_report(const ReportRequest& request);

struct ReportFiles {
  std::string json_path;  ///< DIR/report.json
  std::string page_path;  ///< DIR/report.html; empty when this build has no page (scripts/setup)
  Verdict verdict = Verdict::usable;
  std::size_t remarks = 0;          ///< findings that are none of the errors
  std::vector<std::string> errors;  ///< what each says, with its place
};

/// Writes both files into `output_dir` (made if missing), each whole or not at all.
ReportFiles write_report(const ReportRequest& request, const std::string& output_dir);

/// What write_report() returned when it wrote the report that lies in `output_dir`. Throws Error
/// where there is none.
ReportFiles read_report(const std::string& output_dir);

}  // namespace road
