// From the raw centreline to the reference line of a CRG: uniform steps, smooth heading, closed.
#pragma once

#include <optional>

#include "base/answer.h"
#include "crg/reference_line.h"
#include "road/centreline.h"

namespace road {

struct ReferenceLineOptions {
  /// Wanted step; a closed line changes it by < 0.1 % to close. Absent: automatic_step_m().
  std::optional<double> u_step_m = {};
};

struct ReferenceLineReport {
  double length_m = 0.0;  ///< of the curve, closing gap included
  bool closed = false;
  double closing_gap_m = 0.0;  ///< left on purpose between the last node and the first
  double heading_step_at_seam_rad = 0.0;
  double fit_residual_p99_m = 0.0;  ///< distance of centreline stations from the line
  double fit_residual_max_m = 0.0;
  double min_radius_m = 0.0;
};

/// 0.1 m; on a road less than 4 m wide (median) a fortieth of its width, rounded down to 1, 2 or 5.
double automatic_step_m(const Centreline& centreline);

/// The line passes within the report's residual of the stations. Its z_m and banking are empty.
/// A refusal where no smooth line with equal steps follows the stations.
base::Answer<crg::ReferenceLine> try_fit_reference_line(const Centreline& centreline,
                                                        const ReferenceLineOptions& options = {},
                                                        ReferenceLineReport* report = nullptr);

/// The same for those who have no other line to take: throws the refusal as Error.
crg::ReferenceLine fit_reference_line(const Centreline& centreline,
                                      const ReferenceLineOptions& options = {},
                                      ReferenceLineReport* report = nullptr);

}  // namespace road
