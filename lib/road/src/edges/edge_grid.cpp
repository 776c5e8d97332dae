#include "edge_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mesh/error.h"

namespace road {
namespace {

constexpr double kColumnTolerance_m = 2e-3;  // a column this near to an edge stands for it
constexpr double kSteadyShare =
    0.02;  // of the rows with one edge position: it gets a column of its own
constexpr double kFinestColumn_m = 5e-3;

/// Columns: even ones, finer where an edge moves, and one exactly where an edge stays.
std::vector<double> columns_for(std::vector<double> left_m, std::vector<double> right_m,
                                double v_step_m) {
  std::vector<double> exact, fine;
  for (std::vector<double>* side : {&left_m, &right_m}) {
    std::sort(side->begin(), side->end());
    const double band = side->back() - side->front();
    const auto pieces =
        static_cast<int>(std::clamp(std::ceil(band / (0.25 * v_step_m)), 1.0, 400.0));
    for (int k = 0; k <= pieces; ++k) fine.push_back(side->front() + band * k / pieces);
    const auto wanted = std::max<std::size_t>(
        2, static_cast<std::size_t>(kSteadyShare * static_cast<double>(side->size())));
    for (std::size_t i = 0; i + wanted <= side->size();) {
      std::size_t end = i;
      while (end < side->size() && (*side)[end] - (*side)[i] <= kColumnTolerance_m) ++end;
      if (end - i < wanted) {
        ++i;
        continue;
      }
      // It stands for all that is near it, so that the next is further away than what a file may
      // hold.
      exact.push_back((*side)[(i + end) / 2]);
      while (i < side->size() && (*side)[i] <= exact.back() + kColumnTolerance_m) ++i;
    }
  }
  std::vector<double> columns = exact;
  const auto add = [&](double v) {
    const bool near = std::any_of(columns.begin(), columns.end(),
                                  [&](double c) { return std::abs(c - v) < kFinestColumn_m; });
    if (!near) columns.push_back(v);
  };
  for (const double v : fine) add(v);
  const auto first = static_cast<int>(std::ceil(right_m.front() / v_step_m)),
             last = static_cast<int>(std::floor(left_m.back() / v_step_m));
  for (int j = first; j <= last; ++j) add(j * v_step_m);
  std::sort(columns.begin(), columns.end());
  return columns;
}

}  // namespace

void refuse_narrow(const std::vector<EdgeSection>& sections, double u_step_m, double least_m) {
  std::size_t first = sections.size(), last = 0;
  double narrowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const double width = sections[i].left.v_m - sections[i].right.v_m;
    if (width >= least_m) {
      if (first < sections.size()) break;
      continue;
    }
    first = std::min(first, i);
    last = i;
    narrowest = std::min(narrowest, width);
  }
  if (first == sections.size()) return;
  const double from = u_step_m * static_cast<double>(first),
               to = u_step_m * static_cast<double>(last);
  if (narrowest <= 0.0) {
    throw Error(
        fmt::format("the edges cross: from u = {:.1f} to {:.1f} m the left edge lies up to {:.2f} "
                    "m to the right of the "
                    "right one; look at both files there",
                    from, to, -narrowest));
  }
  throw Error(
      fmt::format("from u = {:.1f} to {:.1f} m the road is down to {:.3f} m wide; wanted at least "
                  "two steps across, "
                  "{} m; take a smaller --v-step-m or look at the edges there",
                  from, to, narrowest, least_m));
}

SampledGrid grid_between(const crg::ReferenceLine& line, const std::vector<EdgeSection>& sections,
                         const EdgeOptions& options, EdgeGridReport& report) {
  const std::size_t rows = line.size();
  std::vector<double> left_v, right_v;
  for (const EdgeSection& section : sections) {
    left_v.push_back(section.left.v_m);
    right_v.push_back(section.right.v_m);
  }
  SampledGrid sampled;
  crg::Grid& grid = sampled.grid;
  grid.u_begin_m = line.u_begin_m;
  grid.u_step_m = line.u_step_m;
  grid.v_m = columns_for(std::move(left_v), std::move(right_v), options.v_step_m);
  const std::size_t columns = grid.v_m.size();
  if (static_cast<double>(rows) * static_cast<double>(columns) >
      static_cast<double>(options.max_nodes)) {
    throw Error(
        fmt::format("the grid would have {:.3g} nodes, more than the limit of {:.3g}; take larger "
                    "steps (--u-step-m, "
                    "--v-step-m)",
                    static_cast<double>(rows) * static_cast<double>(columns),
                    static_cast<double>(options.max_nodes)));
  }
  grid.z_m.assign(rows * columns, std::numeric_limits<float>::quiet_NaN());
  sampled.provenance.assign(rows * columns, Provenance::none);
  sampled.surface_class.assign(rows * columns, SurfaceClass::road);
  for (std::size_t i = 0; i < rows; ++i) {
    // The last row of a closed line stands for the first.
    const EdgeSection& section = sections[line.closed && i + 1 == rows ? 0 : i];
    const double from = section.right.v_m, to = section.left.v_m;
    const auto begin =
        std::lower_bound(grid.v_m.begin(), grid.v_m.end(), from - kColumnTolerance_m) -
        grid.v_m.begin();
    const auto end = std::upper_bound(grid.v_m.begin(), grid.v_m.end(), to + kColumnTolerance_m) -
                     grid.v_m.begin();
    for (auto j = static_cast<std::size_t>(begin); j < static_cast<std::size_t>(end); ++j) {
      const double share = (grid.v_m[j] - from) / (to - from);
      grid.at(i, j) =
          static_cast<float>(section.right.z_m + share * (section.left.z_m - section.right.z_m));
      sampled.provenance[i * columns + j] = Provenance::mesh;
    }
    report.gaps_m.push_back(std::max(0.0, grid.v_m[static_cast<std::size_t>(begin)] - from));
    report.gaps_m.push_back(std::max(0.0, to - grid.v_m[static_cast<std::size_t>(end) - 1]));
    report.widths_m.push_back(to - from);
  }
  return sampled;
}

}  // namespace road
