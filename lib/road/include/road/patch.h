// Finer roads laid over kerbs whose teeth fall between the rows of the grid.
#pragma once

#include <string>
#include <vector>

#include "crg/grid.h"
#include "crg/reference_line.h"
#include "road/kerb.h"

namespace road {

struct PatchOptions {
  double max_error_m = 0.002;  ///< a kerb that its rows miss by more (95 % of the places between
                               ///< them) gets a patch; 0 = off
  unsigned threads = 0;        ///< 0 = all cores; any number gives the same bytes
};

/// A road of its own over one kerb: the line of the road between two rows, with more of them.
struct KerbPatch {
  crg::ReferenceLine line;
  crg::Grid grid;
  double u_begin_m = 0.0, u_end_m = 0.0;  ///< on the road
  double error_before_m = 0.0,
         error_m = 0.0;  ///< 95 % of |grid - mesh| midway between rows, without and with the patch
};

/// How wide the border is in which a patch passes into the road (crg::PatchedSurface).
constexpr double kPatchBlend_m = 0.1;

/// Looks midway between the rows of every kerb and makes those rows 2, 4, 8 or 16 times as many,
/// until the kerb is within max_error_m or rows are 1 cm apart. The columns are those of `sampled`
/// about the kerb.
std::vector<KerbPatch> patch_kerbs(const SampledGrid& sampled, const RaySurface& surface,
                                   const RoadMesh& road, const crg::ReferenceLine& line,
                                   const std::vector<Kerb>& kerbs,
                                   const PatchOptions& options = {});

}  // namespace road
