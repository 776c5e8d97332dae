// Heights of a road over what lies before and behind them. Private to the findings.
#pragma once

#include <cstddef>
#include <vector>

#include "inspect/findings.h"

namespace road {

/// The road that is looked at lies this far before and behind, in metres.
inline constexpr double kShoulderNear_m = 3.0, kShoulderFar_m = 9.0;

/// Heights over the road before and behind them, on every few rows and columns.
struct Residuals {
  std::vector<std::size_t> row, column;  ///< of the map
  std::vector<float> z_m;                ///< row.size() * column.size(); NaN where not known
};

/// Nothing on roads of fewer than 8 rows or with steps of more than 1 m.
Residuals residuals(const HeightMap& map, const FindingOptions& options);

/// Takes out what belongs to kerbs: their edges and the ends over which they rise.
void leave_out_kerbs(const HeightMap& map, const KerbStrips& kerbs, Residuals& r);

}  // namespace road
