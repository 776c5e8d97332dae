#include "cloud/changes.h"

#include <fmt/format.h>

#include <algorithm>

#include "change_cells.h"
#include "change_fit.h"
#include "change_level.h"
#include "change_places.h"
#include "cloud/error.h"

namespace cloud {
namespace {

constexpr std::size_t kFewestCells = 100;

/// The cells that both campaigns show, by y, then x; counts those that one alone shows. Returns of
/// each how many points count.
std::vector<double> fit_cells(const HeldCells& held, ChangeResult& result) {
  std::vector<Key> keys;
  for (const auto& [key, cell] : held) keys.push_back(key);
  std::sort(keys.begin(), keys.end());
  std::vector<double> points;
  for (const Key& key : keys) {
    const Held& cell = held.at(key);
    const CellFit fit = fit_cell(cell);
    if (!fit.done) {
      result.old_alone += cell.points[0].size() > cell.points[1].size() ? 1 : 0;
      result.new_alone += cell.points[0].size() < cell.points[1].size() ? 1 : 0;
      continue;
    }
    ChangeCell& out = result.cells.emplace_back();
    out.x_m = (static_cast<double>(key[1]) + 0.5) * result.cell_m;
    out.y_m = (static_cast<double>(key[0]) + 0.5) * result.cell_m;
    out.z_m = fit.old_m, out.change_m = fit.change_m, out.stddev_m = fit.stddev_m;
    points.push_back(fit.points);
  }
  return points;
}

/// What the points do not tell, and what was taken for drift.
void remark(const ChangeOptions& options, ChangeResult& result) {
  if (result.smallest_told_m > 1.5 * options.min_change_m)
    result.remarks.push_back(fmt::format(
        "in half of the cells a place of two must change by {:.0f} mm or more to be told: the "
        "points "
        "are too few or scatter too much for {:.0f} mm; larger cells (--cell-m) tell less, wider",
        1e3 * result.smallest_told_m, 1e3 * options.min_change_m));
  const double range = result.level_high_m - result.level_low_m;
  if (options.level_m > 0.0 && range > options.min_change_m)
    result.remarks.push_back(
        fmt::format("the campaigns differ slowly by {:.0f} to {:.0f} mm, which was taken out: "
                    "drift, or a change "
                    "wider than {:g} m (--window-m 0 keeps it)",
                    1e3 * result.level_low_m, 1e3 * result.level_high_m, 0.5 * options.level_m));
}

}  // namespace

ChangeResult find_changes(const CloudSource& before, const CloudSource& after,
                          const ChangeOptions& options) {
  ChangeResult result;
  const auto stage = [&](const char* name, double share) {
    if (options.progress) options.progress(name, share);
  };
  stage("look at the points", 0.0);
  result.cell_m = options.cell_m > 0.0 ? options.cell_m : cell_for(before, after);
  stage("read", 0.3);
  HeldCells held;
  Box old_box, new_box;
  result.old_points =
      read_all(before, old_box, [&](const Eigen::Vector3d& p) { hold(held, p, result.cell_m, 0); });
  stage("read", 0.5);
  result.new_points =
      read_all(after, new_box, [&](const Eigen::Vector3d& p) { hold(held, p, result.cell_m, 1); });
  stage("heights", 0.7);
  const std::vector<double> points = fit_cells(held, result);
  if (result.cells.size() < kFewestCells)
    throw Error(fmt::format(
        "{} cells of {:g} m in common, {} wanted: old {}, new {}; is one of them in another frame "
        "or "
        "unit, or still in the sensor's frame?",
        result.cells.size(), result.cell_m, kFewestCells, old_box.text(), new_box.text()));
  stage("changes", 0.9);
  share_scatter(result.cells, points, result.cell_m, result.unclear);
  take_level_out(result.cells, options.level_m, result);
  result.places = places_of(result.cells, result.cell_m, options.min_change_m);
  result.smallest_told_m = smallest_told_m(result.cells, options.min_change_m);
  remark(options, result);
  return result;
}

}  // namespace cloud
