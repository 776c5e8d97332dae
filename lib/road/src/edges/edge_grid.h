// The grid between two edges. Private to the edges stage.
#pragma once

#include <vector>

#include "edge_sections.h"
#include "road/edges.h"

namespace road {

/// Throws Error where the edges cross, or come nearer to each other than `least_m`.
void refuse_narrow(const std::vector<EdgeSection>& sections, double u_step_m, double least_m);

/// What the grid leaves open.
struct EdgeGridReport {
  std::vector<double> gaps_m;    ///< per row and side, from the outermost node to the edge
  std::vector<double> widths_m;  ///< per row
};

/// Heights linear across between the edges; the last row of a closed line is its first. Throws
/// Error where the grid would be larger than options.max_nodes.
SampledGrid grid_between(const crg::ReferenceLine& line, const std::vector<EdgeSection>& sections,
                         const EdgeOptions& options, EdgeGridReport& report);

}  // namespace road
