// The whole of `lidar2mesh map`: scans, their trajectory and a road in, a folder of files out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/output_set.h"
#include "base/progress.h"
#include "cloud/map.h"
#include "cloud/provenance.h"
#include "crg/file.h"

namespace cloud {

/// What a number of a request may be.
struct Bounds {
  double least, most;
};
constexpr Bounds kMaxRangeM{1.0, 1000.0}, kDriftM{1e-6, 10.0}, kDriftRad{1e-8, 0.1},
    kVoxelM{0.005, 1.0}, kVMaxM{1.0, 100.0}, kNodeM{0.01, 1.0}, kBaseStddevM{1e-4, 10.0},
    kGateM{0.05, 5.0}, kEdgeM{0.0, 100.0};
constexpr int kLeastMinPoints = 1, kMostMinPoints = 1000;

/// What is refined with what, by path, and how. Empty paths and words: not given.
struct RefineRequest {
  std::vector<std::string> scans;     ///< clouds, or folders of them
  std::string trajectory;             ///< poses of the sensor
  std::string base;                   ///< the road to refine: a .crg, or a mesh
  std::string centreline;             ///< no base: the line that a road is made along
  std::string output_dir;             ///< made if missing
  std::string frame;                  ///< of the points: "sensor", "map"; empty: sensor with a
                                      ///< trajectory
  std::string unit;                   ///< of the clouds: "m", "ft", "us-ft", "cm", "mm"
  std::string base_unit;              ///< of a base mesh: "m", "cm", "mm", "ft", "inch", "yard"
  std::string base_up;                ///< of a base mesh: "x" to "-z"
  bool base_mirror = false;           ///< its plan is reflected
  std::vector<double> extrinsic;      ///< the sensor in the frame of the poses: x, y, z (m), roll,
                                      ///< pitch, yaw (deg)
  std::vector<double> outliers;       ///< neighbours, deviations
  double voxel_m = 0.0;               ///< 0: not thinned
  double base_stddev_m = 0.02;        ///< of the base's heights
  double drift_m = 0.05;              ///< how fast x, y, z may drift, m per 100 m
  double drift_rad = 0.002;           ///< how fast roll, pitch, yaw may drift, rad per 100 m
  double gate_m = 0.5;                ///< points farther above or below the base are no road
  double edge_m = 0.0;                ///< so far to both sides of the line nothing is grass
  bool no_grass = false;              ///< nowhere is any
  bool campaigns = false;             ///< MapOptions::keep_older
  double v_max_m = 10.0;              ///< without a base: how far to both sides of the line
  double node_m = 0.1;                ///< without a base: between the nodes of the road
  std::optional<double> max_range_m;  ///< points farther from the sensor are left out
  int min_points = 1;                 ///< a node with fewer keeps the base, or is a hole
  bool correct_drift = true;
  bool report = true;                      ///< report.html and report.json too
  std::vector<std::string> format{"ply"};  ///< of the refined surface: ply, stl (float32), pcd
  bool doubles = false;                    ///< coordinates in double, in the map frame
  bool allow_outside = false;              ///< a base mesh may refer to files outside its folder
  unsigned threads = 0;                    ///< 0: all cores; any number gives the same bytes
  std::string program = "lidar2mesh";      ///< what summary.json calls the program
  Options options;                         ///< what it says of the options
};

struct Refined {
  MapReport facts;  ///< with every remark
  std::string crg_path, summary_path;
  std::string json_path, page_path;  ///< of the report; empty without one
  std::string summary_json;          ///< the text of summary_path
};

/// Reads, refines and writes (docs/lidar2mesh.md). Throws Error.
Refined refine(const RefineRequest& request, const base::Progress& progress = {});

/// The last part of it: writes roads, surfaces, trajectory, timing, summary and report. `remarks`
/// are added to those of the result.
Refined write_refined(const RefineRequest& request, const crg::Crg& base, const MapResult& result,
                      const std::vector<std::string>& remarks,
                      const std::vector<road::InputFile>& inputs, base::OutputSet& outputs,
                      const base::Progress& progress);

/// Why the road must not be used, in one sentence; empty: it may be.
std::string why_not_usable(const Refined& refined);

/// Throws Error where the two numbers of `outliers` are none that can be meant.
void want_outliers(const std::vector<double>& outliers);

}  // namespace cloud
