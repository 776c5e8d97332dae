#include "changed_ground.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/statistics.h"
#include "height_cells.h"
#include "no_value.h"

namespace cloud {
namespace {

constexpr double kLeast_m = 0.008;       // of the middle of a place that is told
constexpr float kLeastOfCell_m = 0.004;  // of its cells
constexpr float kSigmas = 4.0;
constexpr double kLeastArea_m2 = 2.0;
constexpr int kRounds = 4;

/// A value per cell of the road; NaN: none.
struct Field {
  std::size_t along = 0, across = 0;
  bool closed = false;
  std::vector<float> of;

  /// Calls what(cell) for each within `reach` cells.
  template <typename What>
  void around(std::size_t cell, std::size_t reach, const What& what) const {
    const std::size_t i = cell / across, j = cell % across;
    for (std::size_t k = i + along - std::min(reach, along); k <= i + along + reach; ++k) {
      if (!closed && (k < along || k >= 2 * along)) continue;
      for (std::size_t l = j - std::min(j, reach); l <= std::min(j + reach, across - 1); ++l)
        what(k % along * across + l);
    }
  }
};

/// Median within `reach`, of as many cells as a third of these; NaN: fewer.
float middle_around(const Field& field, std::size_t cell, std::size_t reach) {
  std::vector<float> values;
  field.around(cell, reach, [&](std::size_t k) {
    if (std::isfinite(field.of[k])) values.push_back(field.of[k]);
  });
  const std::size_t side = 2 * reach + 1;
  return 3 * values.size() < side * side ? kNoValue : base::median(std::move(values));
}

/// What a cell differs by, and the least that is sure.
struct Differences {
  Field smooth;
  std::vector<float> least_m;
};

/// Of single cells from their neighbours, and of neighbours from each other.
Differences differences_of(const Field& raw) {
  Differences out{raw, std::vector<float>(raw.of.size(), kNoValue)};
  std::vector<float> all;
  for (std::size_t k = 0; k < raw.of.size(); ++k) {
    out.smooth.of[k] = std::isfinite(raw.of[k]) ? middle_around(raw, k, 1) : kNoValue;
    if (std::isfinite(out.smooth.of[k])) all.push_back(std::abs(out.smooth.of[k]));
  }
  const float typical_m = 1.4826f * base::median_or(0.0f, std::move(all));
  for (std::size_t k = 0; k < raw.of.size(); ++k) {
    if (!std::isfinite(out.smooth.of[k])) continue;
    const float middle_m = middle_around(raw, k, 2);
    std::vector<float> off;
    raw.around(k, 2, [&](std::size_t n) {
      if (std::isfinite(raw.of[n])) off.push_back(std::abs(raw.of[n] - middle_m));
    });
    const float own_m = 1.4826f * base::median_or(0.0f, std::move(off));
    out.least_m[k] = std::max(kLeastOfCell_m, kSigmas * std::max(own_m, typical_m));
  }
  return out;
}

/// Neighbouring cells that differ the same way.
std::vector<std::vector<std::size_t>> groups_of(const Differences& seen) {
  const Field& field = seen.smooth;
  const auto differs = [&](std::size_t k) { return std::abs(field.of[k]) >= seen.least_m[k]; };
  std::vector<std::vector<std::size_t>> groups;
  std::vector<std::uint8_t> taken(field.of.size(), 0);
  for (std::size_t first = 0; first < field.of.size(); ++first) {
    if (taken[first] != 0 || !differs(first)) continue;
    std::vector<std::size_t> group{first};
    taken[first] = 1;
    for (std::size_t at = 0; at < group.size(); ++at)
      field.around(group[at], 1, [&](std::size_t k) {
        if (taken[k] != 0 || !differs(k) || (field.of[k] > 0.0f) != (field.of[first] > 0.0f))
          return;
        taken[k] = 1;
        group.push_back(k);
      });
    groups.push_back(std::move(group));
  }
  return groups;
}

ChangedPlace place_of(const std::vector<std::size_t>& group, const Field& field,
                      const HeightCells& cells, const RoadFrame& frame, int pass) {
  ChangedPlace place;
  std::vector<double> u_m, v_m, change_m;
  for (const std::size_t k : group) {
    u_m.push_back(frame.u_begin_m() + (static_cast<double>(k / field.across) + 0.5) *
                                          cells.cell_rows * frame.u_step_m());
    v_m.push_back(cells.v_begin_m + (static_cast<double>(k % field.across) + 0.5) * cells.cell_m);
    change_m.push_back(-static_cast<double>(field.of[k]));
  }
  const auto [u_low, u_high] = std::minmax_element(u_m.begin(), u_m.end());
  const auto [v_low, v_high] = std::minmax_element(v_m.begin(), v_m.end());
  const double half_m = 0.5 * cells.cell_m;
  place.u_begin_m = *u_low - half_m, place.u_end_m = *u_high + half_m;
  place.v_begin_m = *v_low - half_m, place.v_end_m = *v_high + half_m;
  place.area_m2 = static_cast<double>(group.size()) * cells.cell_m * cells.cell_m;
  place.change_m = base::median(std::move(change_m)), place.pass = pass;
  return place;
}

/// The views of cells in which passes differ tell nothing about the trajectory.
void set_apart(Sections& sections, const std::vector<Correction>& corrections,
               const RoadFrame& frame, const HeightCells& cells,
               const std::vector<std::uint8_t>& unsure) {
  for (std::size_t s = 0; s < sections.list.size(); ++s) {
    const Mover move(sections, corrections, s);
    for (SectionCell& cell : sections.list[s].cells) {
      const Eigen::Vector3d p = move(cell);
      const std::optional<GridPlace> place = frame.project(p.x(), p.y(), sections.list[s].row);
      std::size_t i = 0, j = 0;
      cell.apart = place && cells.cell_of(*place, i, j) && unsure[i * cells.across + j] != 0;
    }
  }
}

/// Where any place is, the whole width of the road: poses may have followed what changed.
std::vector<std::uint8_t> rows_of(const ChangedGround& changed, const HeightCells& cells) {
  std::vector<std::uint8_t> out(changed.unsure.size(), 0);
  for (std::size_t i = 0; i < cells.along; ++i) {
    const auto row = changed.unsure.begin() + static_cast<std::ptrdiff_t>(i * cells.across);
    if (std::any_of(row, row + static_cast<std::ptrdiff_t>(cells.across),
                    [](std::uint8_t is) { return is != 0; }))
      std::fill_n(out.begin() + static_cast<std::ptrdiff_t>(i * cells.across), cells.across, 1);
  }
  return out;
}

}  // namespace

ChangedGround find_changed_ground(const Sections& sections,
                                  const std::vector<Correction>& corrections,
                                  const RoadFrame& frame, unsigned threads) {
  ChangedGround out;
  int last = 0;
  for (const Section& section : sections.list)
    if (section.has_data()) last = std::max(last, section.pass);
  if (last == 0) return out;
  std::vector<float> ground_m, count;
  std::vector<std::uint8_t> done;
  for (int pass = last; pass >= 0; --pass) {
    const HeightCells cells = cells_of(sections, corrections, frame, pass, threads);
    const std::size_t all = cells.height_m.size();
    if (ground_m.empty()) {
      ground_m.assign(all, 0.0f), count.assign(all, 0.0f), done.assign(all, 0);
      out.first_pass.assign(all, 0), out.unsure.assign(all, 0), out.agrees_m.assign(all, 0.0f);
    }
    Field raw{cells.along, cells.across, cells.closed, std::vector<float>(all, kNoValue)};
    for (std::size_t k = 0; k < all; ++k)
      if (count[k] > 0.0f && done[k] == 0) raw.of[k] = cells.height_m[k] - ground_m[k] / count[k];
    const Differences seen = differences_of(raw);
    for (const std::vector<std::size_t>& group : groups_of(seen)) {
      const ChangedPlace place = place_of(group, seen.smooth, cells, frame, pass);
      if (place.area_m2 < kLeastArea_m2 || std::abs(place.change_m) < kLeast_m) continue;
      out.places.push_back(place);
      for (const std::size_t cell : group)
        raw.around(cell, 1, [&](std::size_t k) {
          out.unsure[k] = 1;
          if (done[k] != 0) return;
          out.first_pass[k] = static_cast<std::uint16_t>(pass + 1);
          out.agrees_m[k] = static_cast<float>(0.5 * std::abs(place.change_m));
        });
      for (const std::size_t cell : group) out.agrees_m[cell] = 0.0f;
    }
    for (std::size_t k = 0; k < all; ++k) {
      if (out.first_pass[k] > pass) done[k] = 1;
      if (done[k] == 0 && std::isfinite(cells.height_m[k]))
        ground_m[k] += cells.height_m[k], count[k] += 1.0f;
    }
  }
  std::stable_sort(
      out.places.begin(), out.places.end(),
      [](const ChangedPlace& a, const ChangedPlace& b) { return a.area_m2 > b.area_m2; });
  if (out.places.empty()) out.first_pass.clear(), out.agrees_m.clear();
  return out;
}

Drift estimate_drift_apart(Sections& sections, const RoadFrame& frame, const MapOptions& options,
                           const std::vector<Correction>& before, MapReport& report,
                           std::optional<double> base_tilt, ChangedGround& changed) {
  double begin = 0.0, end = 0.5;  // shares of the way; the next estimate takes half of what is left
  MapOptions part = options;
  if (options.progress)
    part.progress = [&](const std::string& stage, double share) {
      options.progress(stage, begin + share * (end - begin));
    };
  Drift drift = estimate_drift(sections, frame, part, before, report, base_tilt);
  changed = find_changed_ground(sections, drift.correction, frame, options.threads);
  for (int round = 0; round < kRounds && !changed.places.empty(); ++round) {
    const HeightCells cells = cells_of(sections, drift.correction, frame, 0, options.threads);
    set_apart(sections, drift.correction, frame, cells,
              round == 0 ? rows_of(changed, cells) : changed.unsure);
    begin = end, end = 0.5 * (1.0 + end);
    drift = estimate_drift(sections, frame, part, before, report, base_tilt);
    const std::vector<std::uint8_t> last = std::move(changed.unsure);
    changed = find_changed_ground(sections, drift.correction, frame, options.threads);
    if (changed.unsure == last) break;
  }
  return drift;
}

}  // namespace cloud
