// A road against a reference - the mesh it came from, or another road file.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "crg/surface.h"
#include "inspect/findings.h"
#include "inspect/height_map.h"
#include "inspect/validate.h"
#include "mesh/ray_surface.h"
#include "road/align.h"

namespace road {

/// Fills z_out_m with the reference's heights at map points, those nearest to z_near_m where there
/// are several; NaN where there is none. Called from several threads at once.
using ReferenceHeights =
    std::function<void(std::span<const crg::Point2> points, std::span<const double> z_near_m,
                       std::span<double> z_out_m)>;

/// Vertical rays on a mesh that lies within `reach_m` of the road. `mesh` must outlive the result.
ReferenceHeights reference_of(const RaySurface& mesh, const RotoTranslation& T_global_mesh = {},
                              double reach_m = 1.0);

/// The heights of another road where its grid has some. `surface` must outlive the result.
ReferenceHeights reference_of(const crg::Surface& surface, double reach_m = 1.0);

/// The surface that measured points lie on (map frame, any order): at each place the plane through
/// the points within 0.25 m and reach_m above or below, those beyond three scatters left out. NaN
/// where fewer than 6 remain or they lie on one side. Keeps an index of 8 bytes a point; `points_m`
/// must outlive the result.
ReferenceHeights reference_of(std::span<const Eigen::Vector3d> points_m, double reach_m = 1.0);

struct CompareOptions {
  double u_cell_m = 0.5;  ///< cells of the error map; doubled until they are fewer than max_cells
  double v_cell_m = 0.25;
  std::size_t max_cells = 1'500'000;
  std::size_t worst_places = 10;
  double worst_apart_m = 5.0;     ///< along u
  double min_kerb_loss_m = 0.01;  ///< of the crest; exact samplers stay below 1 mm at the nodes
  double min_kerb_loss_length_m = 1.0;
  double min_deviation_m = 0.02;       ///< a piece of road this far off ...
  double min_deviation_area_m2 = 0.5;  ///< ... over this area is a finding
  double max_deviation_m = 0.1;        ///< beyond: error, where the reference is the mesh
  bool reference_is_truth =
      true;         ///< false: another file, differences are changes and never errors
  RoadEdges edges;  ///< of the rows of the map: limits hold between them
  std::optional<ValidateLimits> limits = ValidateLimits{};  ///< of all of the road; empty: judged
                                                            ///< already
  unsigned threads = 0;
};

/// A cut across both at one u; z in the map frame, NaN where missing.
struct CrossCut {
  double u_m = 0.0, v_m = 0.0;  ///< the place itself
  double error_m = 0.0;         ///< file - reference there
  std::vector<double> at_v_m, file_z_m, reference_z_m;
};

struct Comparison {
  /// Error (file - reference) at the middle of cells: rows * columns, row after row; NaN where the
  /// file has no road, or the reference has nothing within reach (without_reference is then 1).
  double u_begin_m = 0.0, u_cell_m = 0.0;
  std::vector<double> v_m;  ///< middles of the cells
  std::size_t rows = 0;
  std::vector<float> error_m;
  std::vector<std::uint8_t> without_reference;

  std::size_t points = 0;
  double share_without_reference = 0.0;
  ErrorQuantiles abs_error_m;  ///< of |file - reference|
  double mean_error_m = 0.0;   ///< signed
  double histogram_begin_m = 0.0,
         histogram_step_m = 0.0;  ///< signed errors; the outer bins hold all beyond
  std::vector<std::size_t> histogram;
  std::vector<CrossCut> worst;      ///< by |error|, largest first
  std::vector<CrossCut> kerb_cuts;  ///< one per kerb of `kerbs`, at its u_of_profile_m
  std::vector<Finding> findings;    ///< kerb_loss, deviation, no_reference
};

/// An error that is known from elsewhere.
struct PlaceError {
  double u_m = 0.0, v_m = 0.0, error_m = 0.0;  ///< file - reference
};

/// `name`: how the findings call the reference ("mesh", "other file"). `kerbs`: of the file, for
/// kerb_cuts. A cell shows the one of `known` that lies in it where that is larger than the error
/// at its middle; findings go by the middles.
Comparison compare(const HeightMap& map, const KerbStrips& kerbs, const ReferenceHeights& reference,
                   const std::string& name, const CompareOptions& options = {},
                   std::span<const PlaceError> known = {});

}  // namespace road
