#include "road/stretch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mesh/error.h"

namespace road {

namespace {

constexpr std::size_t kFewestRows = 3;

}  // namespace

RowRange rows_between(const crg::ReferenceLine& line, double u_begin_m, double u_end_m) {
  const double begin_m = line.u_begin_m,
               end_m = begin_m + static_cast<double>(line.size() - 1) * line.u_step_m;
  const auto fail = [&](const char* wanted) -> RowRange {
    throw Error(fmt::format(
        "a stretch from u = {:g} m to {:g} m seen; the line goes from {:.3f} m to {:.3f} m{}",
        u_begin_m, u_end_m, begin_m, end_m, wanted));
  };
  if (!std::isfinite(u_begin_m) || !std::isfinite(u_end_m)) return fail("");
  if (u_begin_m > u_end_m && !line.closed)
    return fail(" and is open: wanted is the smaller u first");
  if (u_begin_m > end_m || u_end_m < begin_m) return fail("");
  const auto row = [&](double u_m, double rounded) {
    const double at =
        std::floor((std::clamp(u_m, begin_m, end_m) - begin_m) / line.u_step_m + rounded);
    return std::min(static_cast<std::size_t>(at), line.size() - 1);
  };
  RowRange rows{row(u_begin_m, 1e-6), 0};
  const std::size_t last = row(u_end_m, 1.0 - 1e-6);
  rows.count =
      u_begin_m <= u_end_m ? last - rows.first + 1 : line.size() - 1 - rows.first + last + 1;
  if (rows.count < kFewestRows) return fail("; wanted are three rows or more");
  return rows;
}

crg::ReferenceLine line_of_rows(const crg::ReferenceLine& line, const RowRange& rows) {
  crg::ReferenceLine part;
  part.u_step_m = line.u_step_m;
  part.u_begin_m = line.u_begin_m + static_cast<double>(rows.first) * line.u_step_m;
  for (std::size_t k = 0; k < rows.count; ++k) {
    const std::size_t i = row_of_whole(line, rows, k);
    part.x_m.push_back(line.x_m[i]);
    part.y_m.push_back(line.y_m[i]);
    // The heading of a node is that of the step before it; that of the first node, of the step
    // after.
    const std::size_t of = k == 0                  ? row_of_whole(line, rows, 1)
                           : i == 0 && line.closed ? line.size() - 1
                                                   : i;
    part.heading_rad.push_back(line.heading_rad[of]);
    if (!line.z_m.empty()) part.z_m.push_back(line.z_m[i]);
    if (!line.banking.empty()) part.banking.push_back(line.banking[i]);
  }
  return part;
}

}  // namespace road
