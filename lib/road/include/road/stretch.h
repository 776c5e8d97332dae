// Some rows of a road, as the whole road has them.
#pragma once

#include <vector>

#include "crg/reference_line.h"
#include "road/sample.h"

namespace road {

/// Rows of a line; behind the last row of a closed one they go on at its first.
struct RowRange {
  std::size_t first = 0, count = 0;
};

/// The rows from u_begin_m to u_end_m, at least three; where the first is the larger: over the
/// start of a closed line. Throws Error where the line has no such stretch.
RowRange rows_between(const crg::ReferenceLine& line, double u_begin_m, double u_end_m);

/// These rows as an open line. Each keeps its u; behind the end of a closed line u goes on.
crg::ReferenceLine line_of_rows(const crg::ReferenceLine& line, const RowRange& rows);

/// The row of the whole line that is row k of these.
inline std::size_t row_of_whole(const crg::ReferenceLine& line, const RowRange& rows,
                                std::size_t k) {
  return (rows.first + k) % (line.closed ? line.size() - 1 : line.size());
}

/// What is known of every row of the whole line, for these.
template <class Value>
std::vector<Value> of_rows(const std::vector<Value>& of_all, const crg::ReferenceLine& line,
                           const RowRange& rows) {
  std::vector<Value> part(rows.count);
  for (std::size_t k = 0; k < rows.count; ++k) part[k] = of_all[row_of_whole(line, rows, k)];
  return part;
}

/// sample_grid() of these rows alone, as the whole road has them: where other legs of it are
/// nearer, and which layer is its own, the whole line tells. The grid is that of line_of_rows().
SampledGrid sample_rows(const RoadMesh& road, const RaySurface& surface,
                        const crg::ReferenceLine& line, const RowRange& rows,
                        const Centreline& centreline, const SampleOptions& options = {},
                        SampleReport* report = nullptr);

}  // namespace road
