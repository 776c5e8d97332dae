#include "data_set.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "closing.h"

namespace opencrg {
namespace {

std::map<int, std::unique_ptr<DataSet>>& all() {
  // Never destroyed: programs release their data while they end, in any order.
  static auto* sets = new std::map<int, std::unique_ptr<DataSet>>;
  return *sets;
}

// A surface that answers the grid alone: what lies beyond its borders is worked out here.
std::unique_ptr<const crg::Surface> make_surface(crg::Crg crg, bool close) {
  crg.options.clear();
  crg::set_value(crg.options, "BORDER_MODE_U", 0.0);
  crg::set_value(crg.options, "BORDER_MODE_V", 0.0);
  crg::set_value(crg.options, "REFLINE_CONTINUATION", close ? 1.0 : 0.0);
  return std::make_unique<const crg::Surface>(
      std::move(crg), crg::SurfaceOptions{.modifiers = crg::ModifierUse::None});
}

bool wants_closed(const DataSet& set) {
  return set.options.value_or(dCrgCpOptionRefLineContinue, 0.0) == dCrgRefLineCloseTrack;
}

bool evenly_spaced(const std::vector<double>& v_m) {
  const double step = (v_m.back() - v_m.front()) / static_cast<double>(v_m.size() - 1);
  for (std::size_t j = 0; j < v_m.size(); ++j)
    if (std::abs(v_m.front() + static_cast<double>(j) * step - v_m[j]) > 1e-6 * step) return false;
  return true;
}

void take_surface(DataSet& set, std::unique_ptr<const crg::Surface> surface, bool close) {
  const crg::ReferenceLine& line = surface->reference_line();
  const crg::Grid& grid = surface->grid();
  set.range = {};
  // Ends that lie on each other count as open, as they do for the reference implementation.
  if (const auto closing = crg::find_closing(line);
      closing && closing->before_start_m + closing->after_end_m > 0.0) {
    set.range.begin_m = grid.u_begin_m - closing->before_start_m;
    set.range.period_m = grid.u_of(grid.rows() - 1) + closing->after_end_m - set.range.begin_m;
  }
  const bool even = evenly_spaced(grid.v_m);
  const double step =
      (grid.v_m.back() - grid.v_m.front()) / static_cast<double>(grid.columns() - 1);
  const auto named = crg::find_value(surface->file().road, "LONG_SECTION_V_INCREMENT");
  set.banking_folds = even && named.has_value();
  set.v_step_m = even ? step : named.value_or(0.01);
  (close ? set.open : set.closed).reset();
  (close ? set.closed : set.open) = std::move(surface);
}

// The reference implementation turns headings as they are written, whole turns included.
void scale_curvature(crg::Crg& crg, double factor) {
  const double first =
      crg::find_value(crg.road, "REFERENCE_LINE_START_PHI").value_or(crg.heading_rad[1]);
  for (double& heading : crg.heading_rad) heading = first + factor * (heading - first);
  crg.heading_rad[0] = first;
  crg::set_value(crg.road, "REFERENCE_LINE_START_PHI", first);
  crg::set_value(crg.road, "REFERENCE_LINE_END_PHI", crg.heading_rad.back());
  for (const char* key : {"REFERENCE_LINE_END_X", "REFERENCE_LINE_END_Y"})
    crg::erase_key(crg.road, key);
}

// A longer road begins where it began.
void keep_begin(crg::Crg& crg, double begin_m) {
  crg.grid.u_begin_m = begin_m;
  for (const auto& [key, value] :
       {std::pair{"REFERENCE_LINE_START_U", begin_m},
        std::pair{"REFERENCE_LINE_END_U", crg.grid.u_of(crg.grid.rows() - 1)}}) {
    if (crg::find_value(crg.road, key)) crg::set_value(crg.road, key, value);
  }
}

/// Where a road's line begins, and the height that is added to it.
Origin begin_of(const crg::Crg& crg) {
  const crg::ReferenceLine line = crg::integrate_reference_line(crg);
  return {line.x_m.front(), line.y_m.front(),
          crg::find_value(crg.road, "REFERENCE_LINE_START_Z").value_or(0.0),
          line.heading_rad.front()};
}

/// Makes the road the set's, where the modifiers `moving` put it.
void take_moved(DataSet& set, crg::Crg crg, std::vector<crg::HeaderEntry> moving) {
  const Origin from = begin_of(crg);
  crg.modifiers = std::move(moving);
  crg = crg::apply_modifiers(std::move(crg));
  crg.modifiers.clear();
  const Origin to = begin_of(crg);
  const bool close = wants_closed(set);
  take_surface(set, make_surface(std::move(crg), close), close);
  set.origin = {set.origin.x_m + from.x_m - to.x_m, set.origin.y_m + from.y_m - to.y_m,
                set.origin.z_m + from.z_m - to.z_m, set.origin.phi_rad + from.phi_rad - to.phi_rad};
  if (set.channels) set.channels->take(set.any());
}

}  // namespace

std::mutex& registry_lock() {
  static std::mutex lock;
  return lock;
}

DataSet& load(const char* path) {
  crg::Crg crg = crg::read(path);
  auto set = std::make_unique<DataSet>();
  set->options = default_options();
  set->options.take(crg.options, options());
  if (crg.has_modifier_section) {
    set->modifiers.take(crg.modifiers, modifiers());
  } else {
    set->modifiers = default_modifiers();
  }
  crg.modifiers.clear();
  crg.has_modifier_section = true;
  const auto offset = [&](const char* key) { return crg::find_value(crg.road, key).value_or(0.0); };
  set->origin = {offset("REFERENCE_LINE_OFFSET_X"), offset("REFERENCE_LINE_OFFSET_Y"),
                 offset("REFERENCE_LINE_OFFSET_Z"), offset("REFERENCE_LINE_OFFSET_PHI")};
  const bool close = wants_closed(*set);
  take_surface(*set, make_surface(std::move(crg), close), close);
  set->id = all().empty() ? 1 : all().rbegin()->first + 1;
  return *(all()[set->id] = std::move(set));
}

DataSet* find_data_set(int id) {
  const auto found = all().find(id);
  return found == all().end() ? nullptr : found->second.get();
}

std::vector<int> data_set_ids() {
  std::vector<int> ids;
  for (const auto& [id, set] : all()) ids.push_back(id);
  return ids;
}

void erase_data_set(int id) { all().erase(id); }

const crg::Surface& surface_of(DataSet& set, bool close) {
  if (set.range.period_m <= 0.0) return set.any();
  std::unique_ptr<const crg::Surface>& wanted = close ? set.closed : set.open;
  if (!wanted) wanted = make_surface(set.any().file(), close);
  return *wanted;
}

void apply_modifiers(DataSet& set) {
  crg::Crg crg = set.any().file();
  Settings now = set.modifiers;
  const double begin_m = crg.grid.u_begin_m;
  double factor = 1.0;
  const bool headings = crg.heading_rad.size() > 1 && (crg.x_m.empty() || crg.y_m.empty());
  if (headings && now.get_double(dCrgModScaleCurvature, factor)) {
    scale_curvature(crg, factor);
    now.remove(dCrgModScaleCurvature);
  }
  if (now.get_double(dCrgModScaleLength, factor)) {
    Settings length;
    length.set_double(dCrgModScaleLength, factor);
    now.remove(dCrgModScaleLength);
    crg.modifiers = length.entries(modifiers());
    crg = crg::apply_modifiers(std::move(crg));
    keep_begin(crg, begin_m);
  }
  crg.modifiers = now.entries(modifiers());
  const auto placed = [&] {
    for (unsigned int id = dCrgModRefPointV; id <= dCrgModRefPointPhi; ++id)
      if (now.has(id)) return true;
    return false;
  };
  // The reference takes the right edge from the header and not from the channels.
  if (placed() && !now.has(dCrgModRefPointV) && !now.has(dCrgModRefPointVFrac) &&
      !crg::find_value(crg.road, "LONG_SECTION_V_RIGHT")) {
    crg.modifiers.push_back({.key = "REFPOINT_V"});
  }
  const auto moves = std::stable_partition(
      crg.modifiers.begin(), crg.modifiers.end(), [](const crg::HeaderEntry& entry) {
        return !entry.key.starts_with("REFPOINT_") && !entry.key.starts_with("REFLINE_");
      });
  std::vector<crg::HeaderEntry> moving(moves, crg.modifiers.end());
  crg.modifiers.erase(moves, crg.modifiers.end());
  take_moved(set, crg::apply_modifiers(std::move(crg)), std::move(moving));
  set.modifiers.clear();
}

void set_origin(DataSet& set, const Origin& origin) {
  crg::Crg crg = set.any().file();
  const Origin begin = begin_of(crg);
  std::vector<crg::HeaderEntry> moving;
  for (const auto& [key, value] :
       {std::pair{"REFLINE_ROTCENTER_X", begin.x_m}, std::pair{"REFLINE_ROTCENTER_Y", begin.y_m},
        std::pair{"REFLINE_OFFSET_PHI", set.origin.phi_rad - origin.phi_rad},
        std::pair{"REFLINE_OFFSET_X", set.origin.x_m - origin.x_m},
        std::pair{"REFLINE_OFFSET_Y", set.origin.y_m - origin.y_m},
        std::pair{"REFLINE_OFFSET_Z", set.origin.z_m - origin.z_m}})
    crg::set_value(moving, key, value);
  take_moved(set, std::move(crg), std::move(moving));
  set.origin = origin;
}

crg::Crg as_file(const DataSet& set) {
  crg::Crg crg = set.any().file();
  crg.options = set.options.entries(options());
  return crg;
}

}  // namespace opencrg
