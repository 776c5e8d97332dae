#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/sha256.h"
#include "brake_axles.h"
#include "crg/file.h"
#include "explain/fuel.h"
#include "recording/log_table.h"
#include "recording/place.h"
#include "run_steps.h"
#include "scales_of_car.h"
#include "vehicle/error.h"

namespace explain {
namespace {

using vehicle::Error;

/// Heights in place of grip factors would be taken for a very slippery road.
void want_grip_factors(const crg::Crg& map, const std::string& path) {
  constexpr float kMost = 3.0F;
  for (const float value : map.grid.z_m)
    if (value < 0.0F || value > kMost)
      throw Error(
          fmt::format("{}: a grip factor of {:.3g}, wanted 0 to {:.0f}; --grip is a file of "
                      "grip factors in place of heights",
                      path, value, kMost));
}

/// Laps of one drive that came twice would vouch for each other.
void refuse_the_same_twice(const std::vector<std::string>& paths) {
  std::vector<std::string> hashes;
  for (const std::string& path : paths) {
    const std::string hash = base::sha256_of_file(path);
    if (const auto same = std::find(hashes.begin(), hashes.end(), hash); same != hashes.end())
      throw Error(fmt::format("{}: the same recording as {}; give it once", path,
                              paths[static_cast<std::size_t>(same - hashes.begin())]));
    hashes.push_back(hash);
  }
}

/// Cells that are no numbers count as empty, unless nothing is left of what the analysis cannot do
/// without.
void note_words(const std::string& path, const recording::Table& table,
                const std::vector<std::size_t>& words, const Mapping& mapping,
                std::vector<std::string>& notes) {
  for (std::size_t c = 0; c < words.size(); ++c) {
    const auto m =
        std::find_if(mapping.columns.begin(), mapping.columns.end(),
                     [&](const auto& column) { return column.column == table.names[c]; });
    if (m == mapping.columns.end() || words[c] == 0) continue;
    if (words[c] == table.rows() && (m->channel == "time_s" || m->channel == "x_m" ||
                                     m->channel == "y_m" || m->channel == "vx_mps"))
      throw Error(fmt::format(
          "{}: no cell of '{}' is a number; wanted numbers with a decimal point", path, m->column));
    notes.push_back(fmt::format("{}: {} of {} cells of '{}' are no numbers: taken as empty", path,
                                words[c], table.rows(), m->column));
  }
}

Mapping given_mapping(const std::string& path, const std::vector<std::string>& paths,
                      const std::vector<recording::Table>& tables) {
  Mapping out = {recording::read_mapping(path), {}, {}, {}};
  for (std::size_t k = 0; k < tables.size(); ++k)
    for (const ColumnMapping& m : out.columns)
      if (tables[k].find(m.column) == nullptr)
        throw Error(fmt::format(
            "{}: no column '{}', which {} takes for {}; correct the mapping to the columns that "
            "there are: '{}'",
            paths[k], m.column, path, m.channel,
            fmt::join(tables[k].names.begin(),
                      tables[k].names.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(
                                                    tables[k].names.size(), 30)),
                      "', '")));
  return out;
}

/// Canonical columns, the same in all recordings: mechanisms, the whole car and mapping.yaml know
/// one mapping. Samples that repeat in one recording count as missing in all.
Mapping common_mapping(const std::vector<std::string>& paths,
                       const std::vector<recording::Table>& tables,
                       std::vector<std::string>& notes) {
  Mapping out;
  const auto want = [&](const Mapping& all, std::size_t here, std::size_t there) {
    for (const ColumnMapping& m : all.columns)
      if (tables[there].find(m.column) == nullptr)
        throw Error(
            fmt::format("{}: no column '{}', which {} has; recordings of one run want the same "
                        "columns: take it out of the other, or give --mapping with what all have",
                        paths[there], m.column, paths[here]));
  };
  for (std::size_t k = 0; k < tables.size(); ++k) {
    const Mapping own = identity_mapping(tables[k]);
    for (const std::string& note : own.notes) notes.push_back(paths[k] + ": " + note);
    if (k == 0) out = own;
    want(out, 0, k);
    want(own, k, 0);
    for (ColumnMapping& m : out.columns)
      m.held = m.held || std::any_of(own.columns.begin(), own.columns.end(),
                                     [&](const auto& o) { return o.held && o.column == m.column; });
  }
  return out;
}

}  // namespace

vehicle::Vehicle read_car(const ExplainRequest& request) {
  if (!std::isfinite(request.fuel_kg))
    throw vehicle::Error("--fuel-kg is no number; kilograms are wanted");
  vehicle::Vehicle car = vehicle::read_vehicle(request.vehicle_path);
  if (!car.files.steering.empty())
    throw vehicle::Error(fmt::format(
        "{}: has a steering map, but crgexplain reckons with a constant ratio; wanted a vehicle "
        "with steering.ratio alone, and logs with the road wheels' angle steer_rad",
        request.vehicle_path));
  return car;
}

StatedRoad read_road(const std::string& track_path, const std::string& friction_path) {
  crg::SurfaceOptions options;
  if (!friction_path.empty()) {
    options.friction_map = crg::read(friction_path);
    want_grip_factors(*options.friction_map, friction_path);
  }
  return {options.friction_map, crg::Surface(crg::read(track_path), options)};
}

std::vector<RecordedLog> Recordings::all() const {
  std::vector<RecordedLog> out;
  for (std::size_t k = 0; k < logs.size(); ++k) out.push_back({&tables[k], &logs[k]});
  return out;
}

Recordings read_recordings(const ExplainRequest& request, const crg::Surface& surface,
                           const vehicle::Vehicle& car) {
  const std::vector<std::string>& paths = request.recording_paths;
  Recordings out;
  std::vector<std::vector<std::size_t>> words(paths.size());
  for (std::size_t k = 0; k < paths.size(); ++k)
    out.tables.push_back(recording::read_log_table(paths[k], &words[k]));
  refuse_the_same_twice(paths);
  out.recorded = request.mapping_path.empty()
                     ? common_mapping(paths, out.tables, out.notes)
                     : given_mapping(request.mapping_path, paths, out.tables);
  out.given = out.recorded;
  for (std::size_t k = 0; k < paths.size(); ++k) {  // the same columns in all
    out.recorded = out.given;
    recording::put_on_plane(out.tables[k], out.recorded, paths[k]);
    words[k].resize(out.tables[k].names.size());
  }
  for (std::size_t k = 0; k < paths.size(); ++k)
    note_words(paths[k], out.tables[k], words[k], out.recorded, out.notes);
  out.read = out.recorded;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    out.logs.push_back(make_signals(out.tables[k], out.recorded, surface, paths[k]));
    if (request.fuel_kg != 0) {
      out.read = out.recorded;
      add_fuel(out.tables[k], out.read, out.logs[k], car, request.fuel_kg);
      out.logs[k] = make_signals(out.tables[k], out.read, surface, paths[k]);
    }
    leave_out_exchanged_brakes(out.logs[k], car);
    leave_out_other_steering(out.logs[k], car);
    leave_out_other_loads(out.logs[k], car);
    leave_out_what_changes(out.logs[k]);
  }
  return out;
}

}  // namespace explain
